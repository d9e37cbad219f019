//! One comparison for all sample types: flip some bits, then compare signed or ordered.

use super::bits::BitPlane;
use super::cpu::Detected;
use super::region::Region;
use super::tetra::Crossings;
use super::{Cut, simd};
use crate::volume::Sample;

/// A sample type that the kernel can turn into bit planes.
pub trait Classify: Sample {
    /// What its bits are compared as.
    #[doc(hidden)]
    type Key: Key;
    /// The bits that turn the order of this type into that of its key.
    #[doc(hidden)]
    const FLIP: Self::Key;
}

/// What samples are compared as: signed integers or floats of the same size.
#[doc(hidden)]
pub trait Key: bytemuck::Pod + Default + Send + Sync {
    /// All bits, or the sign alone: what reverses the order.
    const REVERSE: Self;

    /// Bits of one differ where those of the other are set.
    #[must_use]
    fn flip(self, bits: Self) -> Self;

    /// self ≥ at, false for NaN.
    fn reaches(self, at: Self) -> bool;

    /// Fills a bit plane with `key(sample) ≥ threshold.at` by the widest instructions allowed.
    fn fill(
        cpu: Detected,
        samples: &[Self],
        threshold: Threshold<Self>,
        region: Region,
        out: &mut Bits,
    );
}

/// A bit plane, opaque outside the kernel; where the method wants them, with its diagonals.
#[doc(hidden)]
#[derive(Debug)]
pub struct Bits(pub(super) BitPlane, pub(super) Crossings);

impl Bits {
    /// Of a plane without samples.
    pub(super) fn empty() -> Self {
        Self(BitPlane::new(0, 0), Crossings::default())
    }

    /// Makes these the same as others.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.0.copy_from(&other.0);
        self.1.copy_from(&other.1);
    }
}

/// A sample is inside where `(sample ^ flip) ≥ at`.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Threshold<K> {
    pub(super) flip: K,
    pub(super) at: K,
}

impl<K: Key> Threshold<K> {
    /// Nothing where no stored value is inside.
    pub(super) fn of<T: Classify<Key = K>>(cut: Cut<T>) -> Option<Self> {
        let (at, flip) = match cut {
            Cut::From(at) => (at, T::FLIP),
            Cut::UpTo(at) => (at, T::FLIP.flip(K::REVERSE)),
            Cut::Nothing => return None,
        };
        Some(Self { flip, at: bytemuck::cast::<T, K>(at).flip(flip) })
    }

    /// What every instruction set does: the definition. Written so that a compiler makes vectors
    /// of it on any processor: bytes first, then eight of them to eight bits by one product.
    #[inline(always)]
    pub(super) fn word(self, chunk: &[K; 64]) -> u64 {
        let inside = chunk.map(|key| u8::from(key.flip(self.flip).reaches(self.at)));
        let mut word = 0;
        for (i, bytes) in inside.as_chunks::<8>().0.iter().enumerate() {
            // Byte n is moved to bit n of the topmost byte; no two products meet in one bit.
            let bits = u64::from_le_bytes(*bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
            word |= bits << (8 * i);
        }
        word
    }
}

macro_rules! integer_key {
    ($($key:ident: $signed:ty, $unsigned:ty);*) => {$(
        impl Key for $key {
            const REVERSE: Self = -1;

            fn flip(self, bits: Self) -> Self {
                self ^ bits
            }

            fn reaches(self, at: Self) -> bool {
                self >= at
            }

            fn fill(cpu: Detected, samples: &[Self], threshold: Threshold<Self>, region: Region, out: &mut Bits) {
                simd::$key::fill(cpu, samples, threshold, region, &mut out.0);
            }
        }

        impl Classify for $signed {
            type Key = $key;
            const FLIP: $key = 0;
        }

        impl Classify for $unsigned {
            type Key = $key;
            const FLIP: $key = $key::MIN;
        }
    )*};
}

integer_key!(i8: i8, u8; i16: i16, u16; i32: i32, u32);

macro_rules! float_key {
    ($($key:ident),*) => {$(
        impl Key for $key {
            const REVERSE: Self = -0.0;

            fn flip(self, bits: Self) -> Self {
                Self::from_bits(self.to_bits() ^ bits.to_bits())
            }

            fn reaches(self, at: Self) -> bool {
                self >= at
            }

            fn fill(cpu: Detected, samples: &[Self], threshold: Threshold<Self>, region: Region, out: &mut Bits) {
                simd::$key::fill(cpu, samples, threshold, region, &mut out.0);
            }
        }

        impl Classify for $key {
            type Key = $key;
            const FLIP: $key = 0.0;
        }
    )*};
}

float_key!(f32, f64);

#[cfg(test)]
mod tests {
    use super::*;

    /// A lone sample among 64.
    fn is_inside<T: Classify>(cut: Cut<T>, x: T) -> bool {
        let mut chunk = [<T::Key as Default>::default(); 64];
        chunk[5] = bytemuck::cast(x);
        Threshold::of(cut).is_some_and(|t| t.word(&chunk) >> 5 & 1 == 1)
    }

    #[test]
    fn keys_keep_the_order_of_their_types() {
        for at in u8::MIN..=u8::MAX {
            for x in u8::MIN..=u8::MAX {
                assert_eq!(is_inside(Cut::From(at), x), x >= at);
                assert_eq!(is_inside(Cut::UpTo(at), x), x <= at);
                assert_eq!(is_inside(Cut::From(at as i8), x as i8), x as i8 >= at as i8);
                assert_eq!(is_inside(Cut::UpTo(at as i8), x as i8), x as i8 <= at as i8);
            }
        }
        let floats = [f32::NEG_INFINITY, -1.5, -0.0, 0.0, 1e-40, 2.0, f32::INFINITY, f32::NAN];
        for at in &floats[..7] {
            for x in floats {
                assert_eq!(is_inside(Cut::From(*at), x), x >= *at, "{x} {at}");
                assert_eq!(is_inside(Cut::UpTo(*at), x), x <= *at, "{x} {at}");
            }
        }
    }
}
