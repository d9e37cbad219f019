//! The numbers that steer the coder: what the stream gives, the standard's defaults for what it
//! does not, and what follows from both.

use super::super::codestream::CodestreamError;

/// The preset parameters of an LSE segment; 0 stands for the default (T.87, C.2.4.1.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Preset {
    pub(super) maxval: u16,
    pub(super) t1: u16,
    pub(super) t2: u16,
    pub(super) t3: u16,
    pub(super) reset: u16,
}

/// All of them, checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Coding {
    /// The largest sample.
    pub(super) maxval: i32,
    /// The largest error of a sample, 0 where nothing is lost.
    pub(super) near: i32,
    /// Thresholds of the gradients, rising.
    pub(super) t1: i32,
    pub(super) t2: i32,
    pub(super) t3: i32,
    /// The count at which a context's sums are halved.
    pub(super) reset: u32,
    /// Prediction errors there are.
    pub(super) range: i32,
    /// Bits that number them.
    pub(super) qbpp: u32,
    /// The longest code, in bits.
    pub(super) limit: u32,
}

fn within(field: &'static str, found: i32, least: i32, most: i32) -> Result<i32, CodestreamError> {
    if (least..=most).contains(&found) {
        return Ok(found);
    }
    let [found, least, most] = [found, least, most].map(i32::unsigned_abs);
    Err(CodestreamError::Field { field, found, least, most })
}

/// Bits that number `count` things, `count` at least 1.
fn bits_for(count: i32) -> u32 {
    (count - 1).checked_ilog2().map_or(0, |b| b + 1)
}

impl Coding {
    /// For samples of `bits` bits (2 to 16).
    ///
    /// # Errors
    /// A parameter outside the range that T.87, C.2.3 and C.2.4.1.1 give it.
    pub(super) fn new(bits: u8, near: u8, preset: Preset) -> Result<Self, CodestreamError> {
        let largest = (1 << bits) - 1;
        let maxval = match i32::from(preset.maxval) {
            0 => largest,
            given => within("MAXVAL", given, 1, largest)?,
        };
        let near = within("NEAR", i32::from(near), 0, (maxval / 2).min(255))?;
        let [d1, d2, d3] = default_thresholds(maxval, near);
        // A default may lie below a threshold that is given, which C.2.4.1.1 does not foresee:
        // it is refused as any other pair that does not rise.
        let given = |value: u16, default| if value == 0 { default } else { i32::from(value) };
        let t1 = within("T1", given(preset.t1, d1), near + 1, maxval)?;
        let t2 = within("T2", given(preset.t2, d2), t1, maxval)?;
        let t3 = within("T3", given(preset.t3, d3), t2, maxval)?;
        let reset = match i32::from(preset.reset) {
            0 => 64,
            given => within("RESET", given, 3, maxval.max(255))?,
        };
        // A.2.1
        let range = (maxval + 2 * near) / (2 * near + 1) + 1;
        let bpp = bits_for(maxval + 1).max(2);
        let limit = 2 * (bpp + bpp.max(8));
        let qbpp = bits_for(range);
        Ok(Self { maxval, near, t1, t2, t3, reset: reset.unsigned_abs(), range, qbpp, limit })
    }
}

/// T.87, C.2.4.1.1.1.
fn default_thresholds(maxval: i32, near: i32) -> [i32; 3] {
    let [t1, t2, t3] = if maxval >= 128 {
        let factor = (maxval.min(4095) + 128) / 256;
        [factor + 2 + 3 * near, 4 * factor + 3 + 5 * near, 17 * factor + 4 + 7 * near]
    } else {
        let factor = 256 / (maxval + 1);
        [
            (3 / factor + 3 * near).max(2),
            (7 / factor + 5 * near).max(3),
            (21 / factor + 7 * near).max(4),
        ]
    };
    let clamp = |t: i32, least: i32| if t > maxval || t < least { least } else { t };
    let t1 = clamp(t1, near + 1);
    let t2 = clamp(t2, t1);
    [t1, t2, clamp(t3, t2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_standard() {
        // T.87, table C.3: 8, 10 and 12 bits, and the sizes that its text gives.
        for (bits, wanted) in [(8, [3, 7, 21]), (12, [18, 67, 276]), (16, [18, 67, 276])] {
            let coding = Coding::new(bits, 0, Preset::default()).unwrap();
            assert_eq!([coding.t1, coding.t2, coding.t3], wanted, "{bits} bits");
            assert_eq!(coding.reset, 64);
            assert_eq!(coding.range, 1 << bits);
            assert_eq!(coding.qbpp, u32::from(bits));
        }
    }

    #[test]
    fn every_size_and_near_has_rising_defaults() {
        for bits in 2..=16 {
            for near in 0..=255_u8 {
                let allowed = i32::from(near) <= ((1 << bits) - 1) / 2;
                let coding = Coding::new(bits, near, Preset::default());
                assert_eq!(coding.is_ok(), allowed, "{bits} bits, NEAR {near}");
                if let Ok(c) = coding {
                    // The longest run code leaves room for the escape.
                    assert!(c.limit > 16 + c.qbpp + 1, "{c:?}");
                    assert!(c.range >= 2);
                }
            }
        }
    }
}
