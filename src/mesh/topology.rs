//! Whether a mesh is a closed, manifold surface wound outward, and what keeps it from being one.
//!
//! Works on vertex ids alone; coordinates count for area, volume and points that coincide. Every
//! edge and every fan is looked at from one of its vertices, so that nothing but a list of the
//! faces around each vertex is made: time and memory grow with the mesh, 4 bytes a corner and 12
//! a vertex, and 12 a vertex for the points.

use super::defects::Defects;
use super::fans::{Fans, Ring, is_proper};
use super::{Position, Triangle};
use crate::geom::vec3::{cross, dot, norm, sub};

/// A mesh seen as a surface. Faces that name a vertex twice count as defects and are otherwise
/// left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Topology {
    /// All vertices.
    pub n_vertices: u64,
    /// All faces.
    pub n_triangles: u64,
    /// Parts of the surface; faces that share a vertex belong to the same.
    pub n_components: u64,
    /// Vertices in use, minus edges, plus faces.
    pub euler: i64,
    /// In square units.
    pub area: f64,
    /// In cubic units by the divergence theorem, positive where faces are wound outward. Of a
    /// mesh that is not closed: that of the cone from its faces to the origin.
    pub volume: f64,
    /// There are faces, and no edge has just one.
    pub closed: bool,
    /// There are faces, no edge has more than two, and every vertex has one fan.
    pub manifold: bool,
    /// It is closed, neighbours agree in winding, and the volume enclosed is positive. (That a
    /// cavity's wall lies inside its body, and no body in another, is not looked at.)
    pub outward: bool,
    /// What is wrong.
    pub defects: Defects,
}

impl Topology {
    /// Looks at a mesh.
    ///
    /// # Panics
    /// A triangle names a vertex that is not there, or there are 2³² or more vertices or faces.
    pub fn of(vertices: &[Position], triangles: &[Triangle]) -> Self {
        let mut defects = Defects {
            coincident_vertices: coincident(vertices),
            nonfinite_vertices: vertices.iter().filter(|v| !v.iter().all(|x| x.is_finite())).count()
                as u64,
            ..Defects::default()
        };

        let mut parts = Parts::new(vertices.len());
        for triangle in triangles.iter().filter(|t| is_proper(t)) {
            parts.join(triangle[0], triangle[1]);
            parts.join(triangle[0], triangle[2]);
        }

        let fans = Fans::of(vertices.len(), triangles);
        let mut ring = Ring::default();
        let (mut n_used, mut n_edges, mut n_components) = (0_i64, 0_i64, 0);
        for vertex in 0..vertices.len() as u32 {
            if !fans.fill(vertex, triangles, &mut ring) {
                defects.unused_vertices += 1;
                continue;
            }
            n_used += 1;
            n_components += u64::from(parts.root(vertex) == vertex);
            n_edges += ring.count(vertex, &mut defects);
        }
        drop(fans);

        let (mut area, mut volume, mut cone) = (0.0, 0.0, 0.0);
        let mut n_faces = 0_i64;
        for triangle in triangles {
            if !is_proper(triangle) {
                defects.zero_area_faces += 1;
                continue;
            }
            n_faces += 1;
            let [a, b, c] = triangle.map(|id| vertices[id as usize].map(f64::from));
            let normal = cross(sub(b, a), sub(c, a));
            let twice = norm(normal);
            if twice.is_nan() || twice <= 0.0 {
                defects.zero_area_faces += 1;
            }
            area += 0.5 * twice;
            cone += dot(a, normal) / 6.0;
            // Seen from a point of its own part, a small part far from the origin keeps its sign.
            let near = vertices[parts.root(triangle[0]) as usize].map(f64::from);
            volume += dot(sub(a, near), normal) / 6.0;
        }

        let closed = n_faces > 0 && defects.boundary_edges == 0;
        let volume = if closed { volume } else { cone };
        Self {
            n_vertices: vertices.len() as u64,
            n_triangles: triangles.len() as u64,
            n_components,
            euler: n_used - n_edges + n_faces,
            area,
            volume,
            closed,
            manifold: n_faces > 0
                && defects.nonmanifold_edges == 0
                && defects.nonmanifold_vertices == 0,
            outward: closed && defects.inconsistent_edges == 0 && volume > 0.0,
            defects,
        }
    }

    /// Whether it is closed, manifold, outward and without any defect.
    pub fn is_sound(&self) -> bool {
        self.closed && self.manifold && self.outward && self.defects == Defects::default()
    }
}

/// How many vertices have the coordinates of another, beyond the first.
fn coincident(vertices: &[Position]) -> u64 {
    // Adding zero turns −0 to 0 and leaves every other number as it is.
    let mut points: Vec<_> = vertices.iter().map(|v| v.map(|x| (x + 0.0).to_bits())).collect();
    points.sort_unstable();
    points.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64
}

/// Which vertices hang together: each points towards its part's root.
struct Parts(Vec<u32>);

impl Parts {
    fn new(n_vertices: usize) -> Self {
        Self((0..n_vertices as u32).collect())
    }

    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            let above = self.0[self.0[vertex as usize] as usize];
            self.0[vertex as usize] = above;
            vertex = above;
        }
        vertex
    }

    /// Joins the parts of two vertices. The lower root stays.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
