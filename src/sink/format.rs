//! Which mesh format, and how a format lays out its file.

use std::path::Path;

use super::{Encoder, ObjEncoder, PlyEncoder, StlEncoder};
use crate::geom::Space;
use crate::limits;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// Stereolithography: triangles with normals, no shared vertices.
    Stl,
    /// Polygon file format (Stanford).
    Ply,
    /// Wavefront OBJ; always text.
    Obj,
}

impl MeshFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Stl, Self::Ply, Self::Obj];

    /// The format that the path's extension names, in any case.
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::from_name(path.extension()?.to_str()?)
    }

    /// The format called `stl`, `ply` or `obj`, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.as_str().eq_ignore_ascii_case(name))
    }

    /// Its name and extension, in lower case.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Obj => "obj",
        }
    }

    /// The most triangles that a file of it can count.
    pub fn max_triangles(self) -> u64 {
        limits::MAX_TRIANGLES
    }

    /// The most vertices that a file of it can count; STL counts none.
    pub fn max_vertices(self) -> u64 {
        match self {
            Self::Stl => u64::MAX,
            Self::Ply | Self::Obj => limits::MAX_VERTICES,
        }
    }
}

/// How a mesh is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshOptions {
    /// The format.
    pub format: MeshFormat,
    /// STL and PLY as text; OBJ always is.
    pub ascii: bool,
    /// Named in the file, as 3D Slicer reads it; the coordinates are written as they come, so it has
    /// to be that of the [`Place`](crate::geom::Place).
    pub space: Space,
    /// A normal with each vertex, in PLY and OBJ. Every patch must then carry them, and
    /// [`extract`](crate::pipeline::extract) sees to it.
    pub normals: bool,
}

impl MeshOptions {
    /// Binary where the format can be, RAS, no vertex normals.
    pub fn new(format: MeshFormat) -> Self {
        Self { format, ascii: false, space: Space::Ras, normals: false }
    }

    /// The layout of the file.
    pub(super) fn layout(self) -> Box<dyn Layout> {
        match self.format {
            MeshFormat::Stl => Box::new(StlEncoder::new(self)),
            MeshFormat::Ply => Box::new(PlyEncoder::new(self)),
            MeshFormat::Obj => Box::new(ObjEncoder::new(self)),
        }
    }
}

/// What a file holds around the encoded patches.
pub(super) trait Layout: Send {
    /// The encoder of its patches.
    fn encoder(&self) -> std::sync::Arc<dyn Encoder>;

    /// What stands first. Its length does not depend on the totals, so that it can be written
    /// before they are known and again after.
    fn header(&self, n_vertices: u64, n_triangles: u64) -> Vec<u8>;

    /// What stands last.
    fn footer(&self) -> &'static [u8] {
        b""
    }

    /// Bytes a vertex and bytes a triangle, where they are fixed.
    fn strides(&self) -> Option<(u64, u64)>;
}
