//! Counting samples by value while they stream by, without knowing their range beforehand.
//!
//! 8- and 16-bit samples are counted value by value. Others go into bins whose width, a power of
//! two, doubles whenever the range outgrows them, so that one pass is enough and the result does
//! not depend on the order of the samples.

use super::{Padding, Sample};

/// Bins for samples of more than 16 bits; at least half as many lie within the range at the end,
/// unless the values are closer together than `f64` can tell.
const N_BINS: i64 = 1 << 16;

/// How many samples have which stored value.
pub(crate) struct Tally<T> {
    padding: Option<Padding>,
    counts: Counts,
    pub(crate) n_samples: u64,
    pub(crate) n_nan: u64,
    pub(crate) n_infinite: u64,
    pub(crate) n_padding: u64,
    /// Least and greatest finite stored value; the least is above the greatest while there is none.
    low: f64,
    high: f64,
    of: std::marker::PhantomData<T>,
}

enum Counts {
    /// One count a value, from the least value of the type.
    Exact(Vec<u64>),
    Binned(Bins),
}

/// Counts of values in `[index · width, (index + 1) · width)`, from index `first`.
#[derive(Default)]
struct Bins {
    width: f64,
    first: i64,
    counts: Vec<u64>,
}

impl<T: Sample> Tally<T> {
    /// Nothing counted yet. Samples within `padding` are counted apart.
    pub(crate) fn new(padding: Option<Padding>) -> Self {
        let counts = if size_of::<T>() <= 2 {
            Counts::Exact(vec![0; (T::LAST - T::FIRST + 1) as usize])
        } else {
            Counts::Binned(Bins::default())
        };
        Self {
            padding,
            counts,
            n_samples: 0,
            n_nan: 0,
            n_infinite: 0,
            n_padding: 0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            of: std::marker::PhantomData,
        }
    }

    /// Counts more samples.
    pub(crate) fn add(&mut self, samples: &[T]) {
        self.n_samples += samples.len() as u64;
        let padding = self.padding;
        let is_padding = |v: f64| padding.is_some_and(|p| p.holds(v));
        match &mut self.counts {
            Counts::Exact(counts) => {
                for v in samples {
                    if let Some(n) = counts.get_mut((v.ordinal() - T::FIRST) as usize) {
                        *n += 1;
                    }
                }
            }
            Counts::Binned(bins) => {
                let (mut low, mut high) = (self.low, self.high);
                for v in samples.iter().map(|v| v.to_f64()) {
                    if is_padding(v) {
                        self.n_padding += 1;
                    } else if v.is_finite() {
                        low = low.min(v);
                        high = high.max(v);
                    } else if v.is_nan() {
                        self.n_nan += 1;
                    } else {
                        self.n_infinite += 1;
                    }
                }
                (self.low, self.high) = (low, high);
                if low <= high {
                    bins.cover(low, high);
                }
                for v in samples.iter().map(|v| v.to_f64()) {
                    if v.is_finite() && !is_padding(v) {
                        bins.count(v);
                    }
                }
            }
        }
    }

    /// The stored values that occur and how often, in rising order; a binned value is the middle
    /// of its bin.
    pub(crate) fn finish(&mut self) -> Vec<(f64, u64)> {
        let occupied: Vec<(f64, u64)> = match &self.counts {
            Counts::Exact(counts) => counts
                .iter()
                .enumerate()
                .filter(|(_, n)| **n > 0)
                .map(|(at, n)| ((at as i64 + T::FIRST) as f64, *n))
                .collect(),
            Counts::Binned(bins) => bins.occupied(self.low, self.high),
        };
        if matches!(self.counts, Counts::Binned(_)) {
            return occupied;
        }
        let (padded, kept): (Vec<_>, Vec<_>) =
            occupied.into_iter().partition(|(v, _)| self.padding.is_some_and(|p| p.holds(*v)));
        self.n_padding = padded.iter().map(|(_, n)| n).sum();
        if let (Some(first), Some(last)) = (kept.first(), kept.last()) {
            (self.low, self.high) = (first.0, last.0);
        }
        kept
    }

    /// The least and the greatest finite stored value; for 8- and 16-bit samples after
    /// [`Self::finish`] only.
    pub(crate) fn range(&self) -> Option<(f64, f64)> {
        (self.low <= self.high).then_some((self.low, self.high))
    }
}

impl Bins {
    fn index(&self, v: f64) -> i64 {
        let index = (v / self.width).floor() as i64;
        // A quotient too small for f64 loses its sign.
        if index == 0 && v < 0.0 { -1 } else { index }
    }

    fn count(&mut self, v: f64) {
        let at = (self.index(v) - self.first) as usize;
        if let Some(n) = self.counts.get_mut(at) {
            *n += 1;
        }
    }

    /// Widens bins and range until everything from `low` to `high` has a bin.
    fn cover(&mut self, low: f64, high: f64) {
        let width = width_for(low, high).max(self.width);
        let mut wider = Self { width, first: 0, counts: Vec::new() };
        let first = wider.index(low);
        if width == self.width && first == self.first {
            return;
        }
        (wider.first, wider.counts) = (first, vec![0; N_BINS as usize + 2]);
        let old = std::mem::replace(self, wider);
        // floor(v / (2ⁿ w)) is floor(v / w) shifted by n.
        let shift = (exponent(width) - exponent(old.width)).clamp(0, 63);
        for (at, n) in old.counts.into_iter().enumerate().filter(|(_, n)| *n > 0) {
            let index = (old.first + at as i64) >> shift;
            if let Some(sum) = self.counts.get_mut((index - first) as usize) {
                *sum += n;
            }
        }
    }

    fn occupied(&self, low: f64, high: f64) -> Vec<(f64, u64)> {
        let middle = |at: usize| {
            ((self.first + at as i64) as f64 * self.width + 0.5 * self.width).clamp(low, high)
        };
        let occupied = self.counts.iter().enumerate().filter(|(_, n)| **n > 0);
        occupied.map(|(at, n)| (middle(at), *n)).collect()
    }
}

/// The least power of two that parts the range into at most [`N_BINS`] + 1 bins and is no finer
/// than `f64` is at its ends.
fn width_for(low: f64, high: f64) -> f64 {
    let span = high / N_BINS as f64 - low / N_BINS as f64;
    let grain = low.abs().max(high.abs()) * f64::EPSILON;
    let width = span.max(grain).max(f64::MIN_POSITIVE);
    let up = u64::from(width.to_bits() << 12 != 0);
    f64::from_bits(((width.to_bits() >> 52) + up) << 52)
}

/// The exponent of a power of two; 0 has that of the smallest.
fn exponent(width: f64) -> i64 {
    (width.to_bits() >> 52) as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally<T: Sample>(chunks: &[&[T]]) -> (Vec<(f64, u64)>, Tally<T>) {
        let mut tally = Tally::new(None);
        for chunk in chunks {
            tally.add(chunk);
        }
        (tally.finish(), tally)
    }

    #[test]
    fn small_types_are_counted_value_by_value() {
        let (counts, tally) = tally::<i16>(&[&[-1, 5, -1], &[i16::MIN, i16::MAX, 5, -1]]);
        assert_eq!(counts, [(-32768.0, 1), (-1.0, 3), (5.0, 2), (32767.0, 1)]);
        assert_eq!(tally.range(), Some((-32768.0, 32767.0)));
    }

    #[test]
    fn bins_grow_without_losing_a_sample_whatever_the_order() {
        let values: Vec<f64> = (0..2000).map(|n| f64::from(n * n % 977) * 0.37 - 20.0).collect();
        let extremes = [1e300, -1e-300, f64::MAX, f64::MIN, 5e-324, 0.0, -0.0];
        let (a, _) = tally(&[&values[..], &extremes[..]]);
        let (b, _) = tally(&[&extremes[1..2], &extremes[..1], &extremes[2..], &values[..]]);
        assert_eq!(a.iter().map(|(_, n)| n).sum::<u64>(), 2007);
        assert_eq!(a, b);
        let (one, _) = tally(&[&values[..1]]);
        let (far, t) = tally(&[&[values[0]][..], &[values[0]; 5]]);
        assert_eq!((one[0].0, one[0].1 * 6), far[0]);
        assert_eq!(t.range(), Some((values[0], values[0])));
    }

    #[test]
    fn values_land_in_bins_no_wider_than_a_32768th_of_the_range() {
        let values: Vec<f32> = (0..50_000).map(|n| (n as f32).sin() * 1000.0 - 24.0).collect();
        let (counts, tally) = tally(&[&values[..7], &values[7..20_000], &values[20_000..]]);
        let (low, high) = tally.range().unwrap();
        let width = (high - low) / 32_768.0;
        let mut sorted: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        sorted.sort_by(f64::total_cmp);
        let mut at = 0;
        for (middle, n) in counts {
            for v in &sorted[at..at + n as usize] {
                assert!((v - middle).abs() <= width, "{v} in the bin of {middle}");
            }
            at += n as usize;
        }
        assert_eq!(at, sorted.len());
    }

    #[test]
    fn what_is_not_finite_is_counted_apart() {
        let (counts, tally) = tally(&[&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0]]);
        assert_eq!((tally.n_nan, tally.n_infinite, counts.len()), (1, 2, 1));
        let (counts, tally) = self::tally::<f64>(&[&[f64::NAN]]);
        assert_eq!((tally.range(), counts.len()), (None, 0));
    }
}
