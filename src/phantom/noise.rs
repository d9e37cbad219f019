//! Noise that hangs on a sample's place and a seed alone, so that planes can be made in any order.

/// A well-mixed 64-bit number for each number (the finaliser of `SplitMix64`, Steele, Lea and Flood
/// 2014).
fn mix(n: u64) -> u64 {
    let n = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    n ^ (n >> 31)
}

/// A number with mean 0 and deviation 1, close to a normal one: the sum of eight even ones
/// (Irwin and Hall), the same bits on every machine.
pub(super) fn normal(seed: u64, sample: u64) -> f64 {
    let first = mix(mix(seed) ^ sample);
    let halves = [first, mix(first)];
    let parts = halves.iter().flat_map(|h| (0..4).map(move |n| h >> (16 * n) & 0xffff));
    let sum: u64 = parts.sum();
    // Each part is even on 0..=65535: mean 32767.5, variance (65536² - 1) / 12.
    (sum as f64 - 8.0 * 32767.5) / ((65536.0 * 65536.0 - 1.0) * 8.0 / 12.0_f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_moments_of_a_normal_one_and_neighbours_know_nothing_of_each_other() {
        let n = 100_000;
        let all: Vec<f64> = (0..=n).map(|s| normal(7, s)).collect();
        let mean = |f: &dyn Fn(usize) -> f64| (0..n as usize).map(f).sum::<f64>() / n as f64;
        assert!(mean(&|s| all[s]).abs() < 0.015);
        assert!((mean(&|s| all[s] * all[s]) - 1.0).abs() < 0.02);
        assert!(mean(&|s| all[s] * all[s + 1]).abs() < 0.015);
        assert!(mean(&|s| all[s] * normal(8, s as u64)).abs() < 0.015);
        // The fourth moment is 3 for a normal number, 3 - 1.2 / 8 for this sum.
        assert!((mean(&|s| all[s].powi(4)) - 2.85).abs() < 0.1);
    }
}
