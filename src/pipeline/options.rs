//! What a run is asked to do, and what it reports.

use super::RunError;
use crate::cancel::Cancel;
use crate::kernel::{Method, Rule};
use crate::mesh::Measure;
use crate::volume::{Note, Side};

/// One surface of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOptions {
    /// The level, in real units. Finite.
    pub iso: f64,
    /// Which side of it is inside.
    pub side: Side,
    /// How cells become triangles.
    pub method: Method,
    /// Leaves out the cap: only cells whose eight corners are samples.
    pub open: bool,
    /// A unit normal with each vertex.
    pub normals: bool,
}

impl SurfaceOptions {
    /// What the kernel needs to know of it.
    pub(super) fn rule(&self) -> Result<Rule, RunError> {
        let Self { iso, side, method, open, .. } = *self;
        if !iso.is_finite() {
            return Err(RunError::Iso(iso));
        }
        Ok(Rule { iso, side, method, open })
    }

    /// The closed surface at `iso`, inside at and above it.
    pub fn at(iso: f64) -> Self {
        Self { iso, side: Side::AtLeast, method: Method::Cubes, open: false, normals: false }
    }
}

/// Told how far a run is. Called from worker threads.
pub trait Progress: Sync {
    /// `done` of `of` planes are meshed.
    fn planes(&self, done: usize, of: usize);
}

/// How a run is carried out; nothing here changes the mesh.
#[derive(Clone)]
pub struct RunOptions<'a> {
    /// Threads of work in all, at least 1. With 1 nothing overlaps.
    pub threads: usize,
    /// Planes a slab; chosen by their size where absent.
    pub slab_planes: Option<usize>,
    /// Raised to stop the run.
    pub cancel: Cancel,
    /// Told of progress.
    pub progress: Option<&'a dyn Progress>,
}

impl Default for RunOptions<'_> {
    /// As many threads as the machine offers.
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self { threads, slab_planes: None, cancel: Cancel::new(), progress: None }
    }
}

/// Time spent, summed over threads for the three stages; `total` is by the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Seconds {
    pub read: f64,
    pub mesh: f64,
    pub write: f64,
    pub total: f64,
}

/// What became of one surface.
#[derive(Clone, Debug)]
pub struct Report {
    /// Vertices written.
    pub n_vertices: u64,
    /// Triangles written.
    pub n_triangles: u64,
    /// Area, enclosed volume and bounds, in output units.
    pub measure: Measure,
    /// Where the time went.
    pub seconds: Seconds,
    /// What the source noticed while reading.
    pub notes: Vec<Note>,
}
