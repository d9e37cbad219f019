//! Volumes made by formulas, for trying out, teaching and measuring: what they show, what is true
//! of their surfaces, and writing them as NIfTI.
//!
//! A phantom is a source of planes like any other. Nothing here meshes.

mod ahead;
mod error;
mod nifti;
mod noise;
mod planes;
mod shape;
mod truth;

pub use error::PhantomError;
pub use shape::Shape;
pub use truth::Truth;

use std::path::Path;

use crate::Error;
use crate::cancel::Cancel;
use crate::geom::{Affine, Dims, Grid};
use crate::source::Volume;
use crate::volume::{Meta, Rescale, SourceFormat, StoredType};

/// A volume to be made. The axes i, j, k point right, anterior, superior; the origin of
/// millimetres is the middle of the grid. The shape fills the grid whatever its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phantom {
    /// What it shows.
    pub shape: Shape,
    /// Samples along i, j, k.
    pub dims: [i64; 3],
    /// Distances between samples along i, j, k.
    pub spacing_mm: [f64; 3],
    /// Standard deviation of the noise that is added to each sample, in real values.
    pub noise: f64,
    /// Another seed, another noise. The noise of a sample hangs on its indices and this alone.
    pub seed: u64,
    /// The type of the samples. Integers hold rounded values, those of 8 bits with a slope.
    pub stored: StoredType,
}

impl Phantom {
    /// 128 samples along each axis, 1 mm apart, `i16`, without noise.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            dims: [128; 3],
            spacing_mm: [1.0; 3],
            noise: 0.0,
            seed: 0,
            stored: StoredType::I16,
        }
    }

    /// The volume, its planes made as they are read.
    ///
    /// # Errors
    /// Dimensions that are no size of a volume; a spacing or a noise that is no such thing.
    pub fn volume(&self) -> Result<Volume<'static>, PhantomError> {
        let [nx, ny, nz] = self.dims;
        let dims = Dims::checked(nx, ny, nz, self.stored.size())?;
        if !(self.noise.is_finite() && self.noise >= 0.0) {
            return Err(PhantomError::Noise(self.noise));
        }
        let [si, sj, sk] = self.spacing_mm;
        let half = self.extent_mm().map(|e| -e / 2.0);
        let affine = Affine::from_columns([si, 0.0, 0.0], [0.0, sj, 0.0], [0.0, 0.0, sk], half);
        // The header of NIfTI-1 holds them in single precision.
        let is_length = |mm: f64| mm > 0.0 && (mm as f32).is_normal();
        let reach = half.iter().all(|e| (*e as f32).is_finite());
        if !(self.spacing_mm.iter().all(|&s| is_length(s)) && reach && affine.is_usable()) {
            return Err(PhantomError::Spacing(si, sj, sk));
        }
        let mut meta = Meta::plain(SourceFormat::Memory, Grid::new(dims, affine), self.stored);
        meta.rescale = self.rescale();
        meta.description = Some(format!("{} phantom", self.shape));
        let planes = planes::planes(self, dims, affine, meta.rescale);
        Ok(Volume { meta, planes })
    }

    /// Writes the volume to `path` as NIfTI, gzipped where the name ends in `.gz`, or plain to
    /// standard output where there is no path. The file appears under its name when it is whole.
    /// Version 1 is written, which holds the affine in single precision; version 2 where an axis
    /// has more samples than version 1 can count.
    ///
    /// The planes are made by `threads` threads, the same samples for any number of them, two
    /// planes a thread at a time.
    ///
    /// # Errors
    /// Those of [`Phantom::volume`]; what the system says; [`PhantomError::Interrupted`].
    pub fn write(&self, path: Option<&Path>, threads: usize, cancel: &Cancel) -> Result<(), Error> {
        let written = self.volume().and_then(|volume| nifti::write(path, volume, threads, cancel));
        written.map_err(|e| Error::at(path.unwrap_or(Path::new("standard output")), e))
    }

    /// What is known of the surface at [`Shape::iso`], without noise.
    pub fn truth(&self) -> Truth {
        truth::truth(self.shape, self.extent_mm())
    }

    /// From the first sample to the last.
    fn extent_mm(&self) -> [f64; 3] {
        [0, 1, 2].map(|a| (self.dims[a] - 1).max(0) as f64 * self.spacing_mm[a])
    }

    /// From stored to real values: as they are where the type has room for them, as CT has it where
    /// it cannot be negative, in steps that single precision has exactly where it is of 8 bits.
    fn rescale(&self) -> Rescale {
        let signed = self.shape.range().0 < 0.0;
        let (slope, inter) = match self.stored {
            StoredType::U8 => (if signed { 16.0 } else { 4.0 }, if signed { -1024.0 } else { 0.0 }),
            StoredType::I8 => {
                (if signed { 16.0 } else { 4.0 }, if signed { 1024.0 } else { 512.0 })
            }
            StoredType::U16 | StoredType::U32 | StoredType::U64 if signed => (1.0, -1024.0),
            _ => (1.0, 0.0),
        };
        Rescale::new(slope, inter).unwrap_or_default()
    }
}
