//! Meshes put together from what readers find.

use std::collections::HashMap;

use super::ReadError;
use crate::limits;
use crate::mesh::{Mesh, Position};

/// The slots of the table of recent points, a power of two.
const RECENT: usize = 1 << 14;

/// A mesh from corners given by their coordinates: equal ones become one vertex.
pub(super) struct Joiner {
    mesh: Mesh,
    ids: HashMap<[u32; 3], u32>,
    /// Neighbouring triangles come close together: most corners are found here, without a look
    /// into the large table.
    recent: Vec<([u32; 3], u32)>,
}

impl Joiner {
    pub(super) fn new() -> Self {
        // No point is filed under `u32::MAX`, which no vertex has.
        let recent = vec![([0; 3], u32::MAX); RECENT];
        Self { mesh: Mesh::default(), ids: HashMap::new(), recent }
    }

    /// Adds a triangle.
    pub(super) fn add(&mut self, corners: [Position; 3]) -> Result<(), ReadError> {
        let mut triangle = [0; 3];
        for (id, corner) in triangle.iter_mut().zip(corners) {
            *id = self.id(corner)?;
        }
        push_triangle(&mut self.mesh, triangle)
    }

    fn id(&mut self, point: Position) -> Result<u32, ReadError> {
        // Adding zero turns −0 to 0, the same point, and leaves other numbers as they are.
        let key = point.map(|x| (x + 0.0).to_bits());
        let mixed = key
            .iter()
            .fold(0_u32, |mixed, &bits| (mixed.rotate_left(11) ^ bits).wrapping_mul(0x9E37_79B1));
        let slot = &mut self.recent[(mixed >> 8) as usize % RECENT];
        if slot.0 == key && slot.1 != u32::MAX {
            return Ok(slot.1);
        }
        let next = self.mesh.vertices.len() as u32;
        let id = *self.ids.entry(key).or_insert(next);
        if id == next {
            push_vertex(&mut self.mesh, point)?;
        }
        *slot = (key, id);
        Ok(id)
    }

    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }
}

/// Adds a vertex, up to the limit.
pub(super) fn push_vertex(mesh: &mut Mesh, vertex: Position) -> Result<(), ReadError> {
    if mesh.vertices.len() as u64 >= limits::MAX_VERTICES {
        return Err(ReadError::TooMany { what: "vertices", limit: limits::MAX_VERTICES });
    }
    mesh.vertices.push(vertex);
    Ok(())
}

/// Adds a polygon as a fan around its first corner.
pub(super) fn push_polygon(mesh: &mut Mesh, ids: &[u32], face: u64) -> Result<(), ReadError> {
    let [first, rest @ ..] = ids else {
        return Err(ReadError::FewCorners { face, corners: 0 });
    };
    if rest.len() < 2 {
        return Err(ReadError::FewCorners { face, corners: ids.len() as u64 });
    }
    for pair in rest.windows(2) {
        push_triangle(mesh, [*first, pair[0], pair[1]])?;
    }
    Ok(())
}

fn push_triangle(mesh: &mut Mesh, triangle: [u32; 3]) -> Result<(), ReadError> {
    if mesh.triangles.len() as u64 >= limits::MAX_TRIANGLES {
        return Err(ReadError::TooMany { what: "triangles", limit: limits::MAX_TRIANGLES });
    }
    mesh.triangles.push(triangle);
    Ok(())
}

/// The highest vertex that a face names. Faces are checked when all vertices are known, since
/// they may come first.
#[derive(Default)]
pub(super) struct Highest {
    index: u32,
    /// Counted from 1; 0 before any.
    face: u64,
}

impl Highest {
    pub(super) fn see(&mut self, index: u32, face: u64) {
        if index > self.index || self.face == 0 {
            *self = Self { index, face };
        }
    }

    /// Whether all the vertices named are there. The file counts them from `first`.
    pub(super) fn check(&self, n_vertices: usize, first: i64) -> Result<(), ReadError> {
        if self.face > 0 && self.index as usize >= n_vertices {
            return Err(no_such_vertex(self.face, i64::from(self.index) + first, n_vertices));
        }
        Ok(())
    }
}

/// A face, counted from 1, names a vertex, as the file counts, that is not there.
pub(super) fn no_such_vertex(face: u64, id: i64, n_vertices: usize) -> ReadError {
    ReadError::NoSuchVertex { face, id, n_vertices: n_vertices as u64 }
}
