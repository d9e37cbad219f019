//! The flow: planes read once, slabs meshed side by side, patches out in order.

mod error;
mod options;

pub use error::RunError;
pub use options::{Method, Progress, Report, RunOptions, Seconds, SurfaceOptions};

pub use crate::kernel::Side;

use crate::geom::Place;
use crate::sink::Sink;
use crate::source::Volume;

/// Meshes one volume for each of the surfaces asked for, reading its planes once. Sinks are
/// finished but not yet moved to a final name.
///
/// # Errors
/// Whatever the source, the kernel or a sink has to say; nothing is finished then.
pub fn extract(
    volume: Volume<'_>,
    place: &Place,
    surfaces: Vec<(SurfaceOptions, &mut dyn Sink)>,
    options: &RunOptions<'_>,
) -> Result<Vec<Report>, RunError> {
    let _ = (volume, place, surfaces, options);
    Err(RunError::Internal("not built yet"))
}
