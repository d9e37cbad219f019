//! Sample types: the ten a file may store, and the eight that are meshed as they are.

use std::fmt;

/// The type of a stored sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum StoredType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl StoredType {
    /// All ten.
    pub const ALL: [Self; 10] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F32,
        Self::F64,
    ];

    /// Bytes of one sample.
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The word on the command line and in reports: `i16`, `f32`, ...
    pub fn as_str(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

impl fmt::Display for StoredType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A sample type that the kernel meshes as it is stored. 64-bit integers are read as `f64`.
///
/// No other crate can add one: the kernel's gathers rely on `TYPE`.
pub trait Sample:
    sealed::Sealed + bytemuck::Pod + PartialOrd + Default + Send + Sync + fmt::Debug + 'static
{
    /// Its stored type.
    const TYPE: StoredType;

    /// The value, exactly.
    fn to_f64(self) -> f64;

    /// The difference to another value, as `f32`: exact where samples have 16 bits at most.
    fn minus(self, other: Self) -> f32;

    /// The value's place in the order of all values that are no NaN: `a < b` implies a lower
    /// place. The two zeros have places of their own, -0.0 below 0.0.
    fn ordinal(self) -> i64;

    /// The value at a place between [`Self::FIRST`] and [`Self::LAST`].
    fn from_ordinal(ordinal: i64) -> Self;

    /// The place of the least value (negative infinity for floats).
    const FIRST: i64;

    /// The place of the greatest value (infinity for floats).
    const LAST: i64;
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! integer_sample {
    ($wide:ty: $($t:ty => $name:ident),*) => {$(
        impl sealed::Sealed for $t {}

        impl Sample for $t {
            const TYPE: StoredType = StoredType::$name;
            const FIRST: i64 = <$t>::MIN as i64;
            const LAST: i64 = <$t>::MAX as i64;

            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            fn minus(self, other: Self) -> f32 {
                (<$wide>::from(self) - <$wide>::from(other)) as f32
            }

            fn ordinal(self) -> i64 {
                i64::from(self)
            }

            fn from_ordinal(ordinal: i64) -> Self {
                ordinal as $t
            }
        }
    )*};
}

integer_sample!(i32: u8 => U8, i8 => I8, u16 => U16, i16 => I16);
integer_sample!(i64: u32 => U32, i32 => I32);

macro_rules! float_sample {
    ($($t:ty, $bits:ty => $name:ident),*) => {$(
        impl sealed::Sealed for $t {}

        impl Sample for $t {
            const TYPE: StoredType = StoredType::$name;
            // As IEEE 754 orders bit patterns: sign and magnitude, the negative ones turned round.
            const FIRST: i64 = -(<$t>::INFINITY.to_bits() as i64) - 1;
            const LAST: i64 = <$t>::INFINITY.to_bits() as i64;

            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            fn minus(self, other: Self) -> f32 {
                (self - other) as f32
            }

            fn ordinal(self) -> i64 {
                if self.is_sign_negative() {
                    -((-self).to_bits() as i64) - 1
                } else {
                    self.to_bits() as i64
                }
            }

            fn from_ordinal(ordinal: i64) -> Self {
                if ordinal < 0 {
                    -<$t>::from_bits((-(ordinal + 1)) as $bits)
                } else {
                    <$t>::from_bits(ordinal as $bits)
                }
            }
        }
    )*};
}

float_sample!(f32, u32 => F32, f64, u64 => F64);

#[cfg(test)]
mod tests {
    use super::*;

    fn ordered<T: Sample>(values: &[T]) {
        for pair in values.windows(2) {
            assert!(pair[0].ordinal() < pair[1].ordinal(), "{pair:?}");
        }
        for &v in values {
            assert_eq!(T::from_ordinal(v.ordinal()).to_f64().to_bits(), v.to_f64().to_bits());
        }
        assert_eq!(values[0].ordinal(), T::FIRST);
        assert_eq!(values[values.len() - 1].ordinal(), T::LAST);
    }

    #[test]
    fn ordinals_follow_the_order_of_values() {
        ordered(&[i16::MIN, -1, 0, 1, i16::MAX]);
        ordered(&[0_u32, 1, u32::MAX]);
        ordered(&[f32::NEG_INFINITY, f32::MIN, -1.0, -1e-45, -0.0, 0.0, 1e-45, 1.0, f32::INFINITY]);
        ordered(&[f64::NEG_INFINITY, f64::MIN, -0.0, 0.0, f64::MIN_POSITIVE, f64::INFINITY]);
    }
}
