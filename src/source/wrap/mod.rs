//! Sources that wrap a source: a box of it, means of blocks, a blur, a mask, padding taken out.
//!
//! Each is a function from a volume to a volume, streaming, in any order. Planes that could be had
//! in any order still can, those in memory too; none of them holds the volume. None knows of files.

mod blur;
mod crop;
mod downsample;
mod error;
mod formula;
mod gaussian;
mod lend;
mod mask;
mod padding;
mod valid;

pub use blur::blur;
pub use crop::crop;
pub use downsample::downsample;
pub use error::WrapError;
pub use formula::formula;
pub use mask::{mask, two_values};
pub use padding::{is_active, pad_out};

/// Runs one expression with the planes inside an `AnyPlanes` and puts the planes it gives, of the
/// same type, back into one.
macro_rules! any {
    ($any:expr, $planes:ident => $body:expr) => {
        match $any {
            $crate::source::AnyPlanes::U8($planes) => $crate::source::AnyPlanes::U8($body),
            $crate::source::AnyPlanes::I8($planes) => $crate::source::AnyPlanes::I8($body),
            $crate::source::AnyPlanes::U16($planes) => $crate::source::AnyPlanes::U16($body),
            $crate::source::AnyPlanes::I16($planes) => $crate::source::AnyPlanes::I16($body),
            $crate::source::AnyPlanes::U32($planes) => $crate::source::AnyPlanes::U32($body),
            $crate::source::AnyPlanes::I32($planes) => $crate::source::AnyPlanes::I32($body),
            $crate::source::AnyPlanes::F32($planes) => $crate::source::AnyPlanes::F32($body),
            $crate::source::AnyPlanes::F64($planes) => $crate::source::AnyPlanes::F64($body),
        }
    };
}
use any;
