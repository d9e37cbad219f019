//! A volume whose samples are the values of a function of place.

use ndarray::ArrayViewMut2;

use super::WrapError;
use super::lend::samples;
use crate::geom::vec3::{add, scale};
use crate::geom::{Affine, Dims, Grid};
use crate::source::{AnyPlanes, Planes, PositionedPlanes, SourceError, Volume};
use crate::volume::{Meta, Sample, SourceFormat, StoredType};

/// The values of `field` at the samples of a grid: `affine` takes (i, j, k) to x, y, z in RAS
/// millimetres, which `field` is given. Planes are evaluated when they are read, by as many threads
/// as read; the volume is never held.
///
/// ```
/// use mcubes::geom::{Affine, Dims, Place, Space};
/// use mcubes::pipeline::{RunOptions, SurfaceOptions, extract};
/// use mcubes::sink::{MeshFormat, MeshFile, MeshOptions};
/// use mcubes::source::formula;
///
/// // A ball of radius 8 mm around the origin, sampled each half millimetre: positive inside.
/// let dims = Dims::checked(41, 41, 41, 4)?;
/// let affine = Affine::from_columns(
///     [0.5, 0.0, 0.0],
///     [0.0, 0.5, 0.0],
///     [0.0, 0.0, 0.5],
///     [-10.0, -10.0, -10.0],
/// );
/// let ball = formula(dims, affine, |x, y, z| (8.0 - (x * x + y * y + z * z).sqrt()) as f32)?;
///
/// let folder = tempfile::tempdir()?;
/// let place = Place::new(&ball.meta.grid, Space::Ras)?;
/// let mut file =
///     MeshFile::create(&folder.path().join("ball.stl"), &MeshOptions::new(MeshFormat::Stl))?;
/// let reports =
///     extract(ball, &place, vec![(SurfaceOptions::at(0.0), &mut file)], &RunOptions::default())?;
/// file.commit()?;
///
/// let volume = 4.0 / 3.0 * std::f64::consts::PI * 8.0_f64.powi(3);
/// assert!((reports[0].measure.volume / volume - 1.0).abs() < 0.005);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`WrapError::Affine`] for an affine that is not finite or cannot be inverted.
pub fn formula<'a>(
    dims: Dims,
    affine: Affine,
    field: impl Fn(f64, f64, f64) -> f32 + Send + Sync + 'a,
) -> Result<Volume<'a>, SourceError> {
    let planes = evaluated(dims, affine, field)?;
    let meta = Meta::plain(SourceFormat::Memory, Grid::new(dims, affine), StoredType::F32);
    Ok(Volume { meta, planes: AnyPlanes::F32(planes) })
}

fn evaluated<'a, T: Sample>(
    dims: Dims,
    affine: Affine,
    field: impl Fn(f64, f64, f64) -> T + Send + Sync + 'a,
) -> Result<Planes<'a, T>, WrapError> {
    if !affine.is_usable() {
        return Err(WrapError::Affine);
    }
    Ok(Planes::Positioned(Box::new(Formula { dims, affine, field })))
}

struct Formula<F> {
    dims: Dims,
    affine: Affine,
    field: F,
}

impl<T: Sample, F: Fn(f64, f64, f64) -> T + Send + Sync> PositionedPlanes<T> for Formula<F> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        let out = samples(&mut out, self.dims.plane_len())?;
        let [step_i, step_j, step_k, origin] = [0, 1, 2, 3].map(|c| self.affine.column(c));
        let plane = add(origin, scale(step_k, k as f64));
        for (j, row) in out.chunks_exact_mut(self.dims.nx()).enumerate() {
            let start = add(plane, scale(step_j, j as f64));
            for (i, value) in row.iter_mut().enumerate() {
                let [x, y, z] = add(start, scale(step_i, i as f64));
                *value = (self.field)(x, y, z);
            }
        }
        Ok(())
    }
}
