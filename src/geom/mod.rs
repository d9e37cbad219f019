//! Where samples lie: dimensions, the voxel-to-millimetre map, output spaces.
//!
//! Pure arithmetic in `f64`; knows nothing of files, samples or meshes.

mod affine;
mod bounds;
mod dims;
mod grid;
mod orientation;
mod place;
mod regrid;
mod space;
pub mod vec3;

pub use affine::Affine;
pub use bounds::Bounds;
pub use dims::{Dims, DimsError};
pub use grid::Grid;
pub use orientation::orientation;
pub use place::{Place, PlaceError};
pub use regrid::RegridError;
pub use space::Space;
