//! The flow: planes read once, slabs meshed side by side, patches out in order.
//!
//! ```text
//! source ─► dispenser ─► worker: count ─► ledger ─► fill ─► encode ─► sink
//!           (dispense)           (kernel) (sequence)          (patches, front)
//!           each plane once               in slab order     in slab order
//! ```
//!
//! Every worker does all steps for its slab; what must be in order is done in turns.

mod dispense;
mod error;
mod estimate;
mod front;
mod handover;
mod options;
mod patches;
mod plan;
mod pool;
mod run;
mod sequence;

use std::time::Instant;

pub use crate::kernel::Method;
pub use crate::volume::Side;
pub use error::RunError;
pub use estimate::{likely_triangles, working_bytes};
pub use front::{Surface, mesh, mesh_placed};
pub use options::{Progress, Report, RunOptions, Seconds, SurfaceOptions};

use crate::geom::Place;
use crate::kernel::{Classify, Kernel, cpu};
use crate::sink::Sink;
use crate::source::{Planes, Volume};
use crate::volume::Meta;
use crate::with_planes;
use patches::Patches;

/// Meshes one volume for each of the surfaces asked for, reading its planes once. Sinks are
/// finished but not yet moved to a final name. A surface among several that has no triangle is
/// reported as it is, and its sink left unfinished.
///
/// # Errors
/// A place of other dimensions, or a sink that names another space than the place's; then
/// Whatever the source, the kernel or a sink has to say; nothing is finished then.
/// [`RunError::IsoNotReached`] where none of the surfaces has a triangle.
pub fn extract(
    volume: Volume<'_>,
    place: &Place,
    surfaces: Vec<(SurfaceOptions, &mut dyn Sink)>,
    options: &RunOptions<'_>,
) -> Result<Vec<Report>, RunError> {
    let Volume { meta, planes } = volume;
    with_planes!(planes, planes => extract_typed(&meta, planes, place, surfaces, options))
}

fn extract_typed<T: Classify>(
    meta: &Meta,
    planes: Planes<'_, T>,
    place: &Place,
    surfaces: Vec<(SurfaceOptions, &mut dyn Sink)>,
    options: &RunOptions<'_>,
) -> Result<Vec<Report>, RunError> {
    let begun = Instant::now();
    let dims = meta.grid.dims;
    front::same(dims.to_array(), place.dims())?;
    if let Planes::Resident(array) = &planes {
        let (nz, ny, nx) = array.dim();
        front::same([nx, ny, nz], dims)?;
    }
    let (rules, sinks): (Vec<SurfaceOptions>, Vec<&mut dyn Sink>) = surfaces.into_iter().unzip();
    let mut outputs = Vec::with_capacity(sinks.len());
    for (sink, rule) in sinks.into_iter().zip(&rules) {
        let placed = place.space();
        if let Some(named) = sink.space().filter(|&named| named != placed) {
            return Err(RunError::Space { named, placed });
        }
        let normals = rule.normals || sink.normals();
        outputs.push(Patches::new(sink, normals));
    }
    let kernels = rules
        .iter()
        .map(|rule| Ok(Kernel::new(dims, place, meta.rescale, rule.rule()?, cpu())))
        .collect::<Result<Vec<_>, RunError>>()?;
    let surfaces = kernels.into_iter().zip(&mut outputs).collect();
    let outcome = run::run(planes, dims, surfaces, options)?;
    let mut reports = Vec::new();
    if let Some(rule) = rules.first()
        && outcome.totals.iter().all(|totals| totals.n_triangles == 0)
    {
        return Err(RunError::IsoNotReached { iso: rule.iso, range: None, open: rule.open });
    }
    for (totals, output) in outcome.totals.iter().zip(outputs) {
        let (sink, measure) = output.into_inner();
        if totals.n_triangles > 0 {
            sink.finish(totals.n_vertices, totals.n_triangles)?;
        }
        let spent = outcome.spent;
        reports.push(Report {
            n_vertices: totals.n_vertices,
            n_triangles: totals.n_triangles,
            measure,
            seconds: Seconds {
                read: spent.read.as_secs_f64(),
                mesh: spent.mesh.as_secs_f64(),
                write: spent.write.as_secs_f64(),
                total: begun.elapsed().as_secs_f64(),
            },
            notes: outcome.notes.clone(),
        });
    }
    Ok(reports)
}
