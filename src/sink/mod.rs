//! Writers: patches in, a mesh file out.
//!
//! An [`Encoder`] turns a patch into the bytes of its format on any thread; a [`Sink`] takes them
//! in order. Sinks turn no coordinates and join no vertices.

mod atomic;
mod error;
mod file;
mod format;
mod obj;
mod ply;
mod stl;
mod text;

pub(crate) use atomic::Target;
#[cfg(feature = "cli")]
pub(crate) use atomic::folder_of;
pub use error::SinkError;
pub use file::MeshFile;
#[cfg(feature = "cli")]
pub(crate) use file::SPOOL_BYTES;
pub use format::{MeshFormat, MeshOptions};

use obj::ObjEncoder;
use ply::PlyEncoder;
use stl::StlEncoder;

use std::ops::Range;
use std::sync::Arc;

use crate::geom::Space;
use crate::mesh::{Measure, Patch};

/// The bytes of one patch.
#[derive(Clone, Debug, Default)]
pub struct Encoded {
    /// What stands with the vertices, before all faces; empty for STL.
    pub vertices: Vec<u8>,
    /// What stands with the faces, after all vertices.
    pub faces: Vec<u8>,
    /// The sums over what was encoded.
    pub measure: Measure,
}

/// Turns patches into bytes. Called from many threads, in any order.
pub trait Encoder: Send + Sync {
    /// Appends the bytes of some of the patch's triangles to `out`, and those of its own vertices
    /// where the triangles begin with the first (`0..0` is the vertices alone).
    fn encode(&self, patch: &Patch, triangles: Range<usize>, out: &mut Encoded);
}

/// Takes the encoded patches of one surface, in order.
pub trait Sink: Send {
    /// The encoder that goes with it.
    fn encoder(&self) -> Arc<dyn Encoder>;

    /// The space that the output says its coordinates are in, if it does.
    fn space(&self) -> Option<Space> {
        None
    }

    /// Whether every patch must carry normals.
    fn normals(&self) -> bool {
        false
    }

    /// Appends the next patch.
    ///
    /// # Errors
    /// The output cannot be written.
    fn append(&mut self, encoded: &Encoded) -> Result<(), SinkError>;

    /// Called once after the last patch: completes header and body. The file does not yet stand
    /// under its final name.
    ///
    /// # Errors
    /// The output cannot be written.
    fn finish(&mut self, n_vertices: u64, n_triangles: u64) -> Result<(), SinkError>;
}
