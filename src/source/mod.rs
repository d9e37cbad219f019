//! Sources of planes: files and arrays as a stream of samples.
//!
//! A source knows a volume's facts before any sample is read, then fills planes that it is lent.
//! It never holds the volume. Decompression, DICOM decoding and byte swapping happen here; later
//! steps (crop, blur, a formula) wrap a source and are sources themselves.

mod buffer;
pub mod dicom;
mod each;
mod error;
mod file;
mod gunzip;
mod input;
mod layout;
mod nifti;
mod open;
mod raw;
mod stream;
mod survey;
mod waiting;
mod wrap;

pub(crate) use buffer::buffer;
pub(crate) use each::Copied;
pub use error::SourceError;
pub(crate) use error::grouped;
pub use nifti::NiftiError;
pub use open::{
    Content, MAX_LISTED_VOLUMES, OpenOptions, files, is_stream, open, sniff, volumes,
    volumes_beside,
};
pub use raw::{RawError, RawInput, RawOptions, SizeMismatch, open_raw};
pub use survey::survey;
pub use wrap::{WrapError, blur, crop, downsample, formula, is_active, mask, pad_out, two_values};

use ndarray::{ArrayView3, ArrayViewMut2};

use crate::volume::{Inside, Meta, Note};

/// Planes that come one after another: gzip, standard input.
pub trait OrderedPlanes<T>: Send {
    /// Fills `out` (`ny` × `nx`, contiguous, i fastest) with the next plane, beginning with plane
    /// 0. Never called more than `nz` times.
    ///
    /// # Errors
    /// Data that end early or do not decode.
    fn next_plane(&mut self, out: ArrayViewMut2<'_, T>) -> Result<(), SourceError>;

    /// Called once after the last plane: reads on to the end of the stream and checks what can be
    /// checked there (gzip's CRC).
    ///
    /// # Errors
    /// What the check finds.
    fn finish(&mut self) -> Result<Vec<Note>, SourceError>;
}

/// Planes that can be had in any order, from several threads at once: plain files, DICOM frames.
pub trait PositionedPlanes<T>: Send + Sync {
    /// Fills `out` (`ny` × `nx`, contiguous, i fastest) with plane `k`.
    ///
    /// # Errors
    /// Data that end early or do not decode.
    fn read_plane(&self, k: usize, out: ArrayViewMut2<'_, T>) -> Result<(), SourceError>;

    /// Fills `out` (rows × `nx`, contiguous, i fastest) with rows `first..` of plane `k`, and says
    /// true; or says false and reads nothing, where only whole planes can be had.
    ///
    /// # Errors
    /// Data that end early or do not decode.
    fn read_rows(
        &self,
        k: usize,
        first: usize,
        out: ArrayViewMut2<'_, T>,
    ) -> Result<bool, SourceError> {
        let _ = (k, first, out);
        Ok(false)
    }

    /// From here on hands on samples that are padding by their own value where that is not inside,
    /// and as NaN where it is. Without a call they are NaN, those of
    /// [`Meta::uneven_padding`](crate::volume::Meta::uneven_padding); other sources do nothing.
    fn keep_padding(&mut self, inside: Inside) {
        let _ = inside;
    }
}

/// The samples of one volume, by the way they can be had.
pub enum Planes<'a, T> {
    /// One after another.
    Ordered(Box<dyn OrderedPlanes<T> + 'a>),
    /// In any order.
    Positioned(Box<dyn PositionedPlanes<T> + 'a>),
    /// In memory already: (z, y, x), x fastest where it is contiguous.
    Resident(ArrayView3<'a, T>),
}

/// [`Planes`] of one of the eight sample types that are meshed as they are stored.
#[expect(missing_docs, reason = "the names say it")]
pub enum AnyPlanes<'a> {
    U8(Planes<'a, u8>),
    I8(Planes<'a, i8>),
    U16(Planes<'a, u16>),
    I16(Planes<'a, i16>),
    U32(Planes<'a, u32>),
    I32(Planes<'a, i32>),
    F32(Planes<'a, f32>),
    F64(Planes<'a, f64>),
}

/// Runs one expression with the planes inside an [`AnyPlanes`], whatever their type.
#[macro_export]
macro_rules! with_planes {
    ($any:expr, $planes:ident => $body:expr) => {
        match $any {
            $crate::source::AnyPlanes::U8($planes) => $body,
            $crate::source::AnyPlanes::I8($planes) => $body,
            $crate::source::AnyPlanes::U16($planes) => $body,
            $crate::source::AnyPlanes::I16($planes) => $body,
            $crate::source::AnyPlanes::U32($planes) => $body,
            $crate::source::AnyPlanes::I32($planes) => $body,
            $crate::source::AnyPlanes::F32($planes) => $body,
            $crate::source::AnyPlanes::F64($planes) => $body,
        }
    };
}

/// A volume ready to be read: its facts, and its planes.
pub struct Volume<'a> {
    /// Known before any sample is read.
    pub meta: Meta,
    /// The samples, once.
    pub planes: AnyPlanes<'a>,
}
