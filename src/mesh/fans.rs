//! The faces around each vertex, and what they tell of its edges and its fan.

use super::Triangle;
use super::defects::Defects;

/// Longer rings are sorted instead of searched.
const SHORT: usize = 16;

/// For each vertex, the proper faces that name it.
pub(super) struct Fans {
    /// Where each vertex's faces begin in `faces`, and the end.
    starts: Vec<usize>,
    faces: Vec<u32>,
}

impl Fans {
    pub(super) fn of(n_vertices: usize, triangles: &[Triangle]) -> Self {
        let mut starts = vec![0_usize; n_vertices + 1];
        for triangle in triangles.iter().filter(|t| is_proper(t)) {
            for &vertex in triangle {
                starts[vertex as usize] += 1;
            }
        }
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        // Filled from the ends, which thereby become the starts.
        let mut faces = vec![0_u32; total];
        for (face, triangle) in triangles.iter().enumerate().rev() {
            if is_proper(triangle) {
                for &vertex in triangle {
                    let start = &mut starts[vertex as usize];
                    *start -= 1;
                    faces[*start] = face as u32;
                }
            }
        }
        Self { starts, faces }
    }

    /// Puts the vertex's faces into `ring`; says whether there are any.
    pub(super) fn fill(&self, vertex: u32, triangles: &[Triangle], ring: &mut Ring) -> bool {
        let faces = &self.faces[self.starts[vertex as usize]..self.starts[vertex as usize + 1]];
        ring.links.clear();
        ring.links.extend(faces.iter().map(|&face| match triangles[face as usize] {
            [v, a, b] | [b, v, a] | [a, b, v] if v == vertex => [a, b],
            // Not reached: the face is listed because it names the vertex.
            [_, a, b] => [a, b],
        }));
        !faces.is_empty()
    }
}

/// The edges opposite to one vertex, each in its face's direction, and room to sort them.
#[derive(Default)]
pub(super) struct Ring {
    links: Vec<[u32; 2]>,
    ends: Vec<(u32, bool)>,
    pairs: Vec<[u32; 2]>,
    parents: Vec<usize>,
}

impl Ring {
    /// Adds what is wrong around `vertex` to `defects`. Edges to lower vertices, and faces with a
    /// lower vertex, were counted there. Returns how many edges go to higher ones.
    pub(super) fn count(&mut self, vertex: u32, defects: &mut Defects) -> i64 {
        if self.is_ring() {
            return self.links.iter().filter(|link| link[0] > vertex).count() as i64;
        }
        self.duplicates(vertex, defects);
        let n_edges = self.edges(vertex, defects);
        defects.nonmanifold_vertices += u64::from(!self.is_fan());
        n_edges
    }

    /// Whether the links, followed in their direction, are one ring of three or more: then every
    /// edge at the vertex has two faces, once in each direction, and no two faces are the same.
    fn is_ring(&self) -> bool {
        let n = self.links.len();
        if !(3..=SHORT).contains(&n) {
            return false;
        }
        let [first, mut at] = self.links[0];
        for _ in 1..n {
            // Back too early: this ring is not all.
            if at == first {
                return false;
            }
            match self.links.iter().find(|link| link[0] == at) {
                Some(link) => at = link[1],
                None => return false,
            }
        }
        at == first
    }

    fn duplicates(&mut self, vertex: u32, defects: &mut Defects) {
        self.pairs.clear();
        let own = self.links.iter().filter(|link| link[0] > vertex && link[1] > vertex);
        self.pairs.extend(own.map(|&[a, b]| [a.min(b), a.max(b)]));
        self.pairs.sort_unstable();
        defects.duplicate_faces +=
            self.pairs.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    }

    /// Counts the edges by their other ends, which are left sorted in `ends`.
    fn edges(&mut self, vertex: u32, defects: &mut Defects) -> i64 {
        self.ends.clear();
        self.ends.extend(self.links.iter().flat_map(|&[a, b]| [(a, true), (b, false)]));
        self.ends.sort_unstable();
        let mut n_edges = 0;
        for edge in self.ends.chunk_by(|a, b| a.0 == b.0).filter(|edge| edge[0].0 > vertex) {
            n_edges += 1;
            match edge {
                [_] => defects.boundary_edges += 1,
                [a, b] => defects.inconsistent_edges += u64::from(a.1 == b.1),
                _ => defects.nonmanifold_edges += 1,
            }
        }
        n_edges
    }

    /// Whether the links hang together, with at most two at each end. Wants `ends` sorted.
    fn is_fan(&mut self) -> bool {
        if self.ends.chunk_by(|a, b| a.0 == b.0).any(|edge| edge.len() > 2) {
            return false;
        }
        self.ends.dedup_by_key(|end| end.0);
        self.parents.clear();
        self.parents.extend(0..self.ends.len());
        let mut n_parts = self.ends.len();
        for &[a, b] in &self.links {
            let place = |id| self.ends.partition_point(|end| end.0 < id);
            let (a, b) = (place(a), place(b));
            let (a, b) = (root(&mut self.parents, a), root(&mut self.parents, b));
            if a != b {
                self.parents[a.max(b)] = a.min(b);
                n_parts -= 1;
            }
        }
        n_parts == 1
    }
}

fn root(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

/// Whether the three vertices differ.
pub(super) fn is_proper(&[a, b, c]: &Triangle) -> bool {
    a != b && b != c && c != a
}
