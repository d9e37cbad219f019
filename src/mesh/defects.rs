//! What can be wrong with a mesh.

/// What is wrong with a mesh, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Defects {
    /// Edges of one face.
    pub boundary_edges: u64,
    /// Edges of more than two faces.
    pub nonmanifold_edges: u64,
    /// Vertices whose faces are not one fan: the edges opposite to the vertex form neither one
    /// ring nor one chain. The ends of an edge of more than two faces are among them.
    pub nonmanifold_vertices: u64,
    /// Edges of two faces that run along it in the same direction.
    pub inconsistent_edges: u64,
    /// Faces that name a vertex twice, or whose area, computed in `f64` from their `f32` corners,
    /// is zero or not a number.
    pub zero_area_faces: u64,
    /// Faces with the same three vertices as another, whatever their order, beyond the first.
    pub duplicate_faces: u64,
    /// Vertices with the same coordinates as another (0 and −0 are the same), beyond the first.
    pub coincident_vertices: u64,
    /// Vertices of no face.
    pub unused_vertices: u64,
    /// Vertices with a coordinate that is infinite or not a number.
    pub nonfinite_vertices: u64,
}
