//! Triangles: the surface of one slab, the whole mesh, its measures and its topology.
//!
//! Knows nothing of volumes, kernels or file formats.

mod measure;
mod memory;
mod patch;

pub use measure::Measure;
pub use memory::Buffer;
pub use patch::Patch;

/// A triangle: three vertex ids, counter-clockwise seen from outside.
pub type Triangle = [u32; 3];

/// A vertex position in output coordinates.
pub type Position = [f32; 3];
