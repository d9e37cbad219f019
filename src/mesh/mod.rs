//! Triangles: the surface of one slab, the whole mesh, its measures and its topology.
//!
//! Knows nothing of volumes, kernels or file formats.

mod defects;
mod fans;
mod measure;
mod memory;
#[expect(clippy::module_inception, reason = "the type of the same name")]
mod mesh;
mod patch;
mod topology;

pub use defects::Defects;
pub use measure::Measure;
pub use memory::Buffer;
pub use mesh::Mesh;
pub use patch::Patch;
pub use topology::Topology;

/// A triangle: three vertex ids, counter-clockwise seen from outside.
pub type Triangle = [u32; 3];

/// A vertex position in output coordinates.
pub type Position = [f32; 3];

/// A direction of length 1 in output coordinates.
pub type Normal = [f32; 3];
