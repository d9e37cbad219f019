//! What topology the trilinear interpolant of a small grid has, by two ways that share nothing with
//! each other or with the extraction: an exact count of critical points, and the topology of finer
//! and finer digital pictures.
//!
//! M is where the interpolant is at least 0. Outside the grid everything is below.

/// A grid of values, x fastest.
pub struct Field {
    pub dims: [usize; 3],
    pub values: Vec<f64>,
}

/// The Euler number of M, and how far the grid is from one where it would be another.
#[derive(Clone, Copy, Debug)]
pub struct Count {
    pub euler: i64,
    pub margin: f64,
}

impl Field {
    pub fn at(&self, [x, y, z]: [usize; 3]) -> f64 {
        let [nx, ny, _] = self.dims;
        self.values[x + nx * (y + ny * z)]
    }

    fn get(&self, at: [i64; 3]) -> Option<f64> {
        let inside = (0..3).all(|a| (0..self.dims[a] as i64).contains(&at[a]));
        inside.then(|| self.at(at.map(|x| x as usize)))
    }

    /// The eight values of the cell whose lowest corner is given.
    fn cell(&self, [x, y, z]: [usize; 3]) -> [f64; 8] {
        std::array::from_fn(|i| self.at([x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)]))
    }

    /// All corners of boxes of the given size that lie in the grid.
    fn places(&self, size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> + use<> {
        let n = [0, 1, 2].map(|a| self.dims[a].saturating_sub(size[a]));
        let [nx, ny, nz] = n;
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    /// Counts critical points of the interpolant where it is at least 0, each by what passing it
    /// downwards adds to the Euler number of what is above: samples, saddles of faces, saddles of
    /// cells. Exact but for rounding, whose reach `margin` tells.
    pub fn count(&self) -> Count {
        let mut count = Count { euler: 0, margin: f64::INFINITY };
        for at in self.places([0; 3]) {
            self.count_sample(at, &mut count);
        }
        for axis in 0..3 {
            let mut size = [1; 3];
            size[axis] = 0;
            for at in self.places(size) {
                self.count_face(axis, at, &mut count);
            }
        }
        for at in self.places([1; 3]) {
            count_cell(&self.cell(at), &mut count);
        }
        count
    }

    fn count_sample(&self, at: [usize; 3], count: &mut Count) {
        let value = self.at(at);
        count.near(value);
        let mut higher = [0i64; 3];
        for axis in 0..3 {
            for step in [-1, 1] {
                let mut next = at.map(|x| x as i64);
                next[axis] += step;
                if let Some(other) = self.get(next) {
                    count.near(other - value);
                    higher[axis] += i64::from(other > value);
                }
            }
        }
        if value >= 0.0 {
            // The higher neighbours span a part of an octahedron, opposite ones not joined.
            let [a, b, c] = higher;
            count.euler += 1 - (a + b + c - (a * b + b * c + c * a) + a * b * c);
        }
    }

    fn count_face(&self, axis: usize, at: [usize; 3], count: &mut Count) {
        let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
        let corners = |shift: i64| -> Option<[f64; 4]> {
            let mut low = at.map(|x| x as i64);
            low[axis] += shift;
            let mut found = [0.0; 4];
            for (value, (u, v)) in found.iter_mut().zip([(0, 0), (1, 0), (1, 1), (0, 1)]) {
                let mut place = low;
                place[u_axis] += u;
                place[v_axis] += v;
                *value = self.get(place)?;
            }
            Some(found)
        };
        let Some([a, b, c, d]) = corners(0) else { return };
        let twist = a + c - b - d;
        let (u, v) = ((a - d) / twist, (a - b) / twist);
        count.near(inset(&[u, v]));
        let is_within = inset(&[u, v]) > 0.0;
        if !is_within {
            return;
        }
        let saddle = (a * c - b * d) / twist;
        count.near(saddle);
        let mut rising = -1;
        for shift in [-1, 1] {
            if let Some([a, b, c, d]) = corners(shift) {
                let across = (a * (1.0 - u) + b * u) * (1.0 - v) + (d * (1.0 - u) + c * u) * v;
                count.near(across - saddle);
                rising += i64::from(across > saddle);
            }
        }
        if saddle >= 0.0 {
            count.euler += rising;
        }
    }
}

impl Count {
    fn near(&mut self, distance: f64) {
        if distance.abs() < self.margin {
            self.margin = distance.abs();
        }
    }
}

/// How far a point is inside the unit box; how far outside where negative.
fn inset(point: &[f64]) -> f64 {
    point.iter().map(|x| x.min(1.0 - x)).fold(f64::INFINITY, f64::min)
}

/// F = a + bx + cy + dz + exy + fyz + gxz + hxyz has at most two critical points.
fn count_cell(v: &[f64; 8], count: &mut Count) {
    let a = v[0];
    let (b, c, d) = (v[1] - a, v[2] - a, v[4] - a);
    let (e, f, g) = (v[3] - a - b - c, v[6] - a - c - d, v[5] - a - b - d);
    let h = v[7] - a - b - c - d - e - f - g;
    let (p, q, r) = (b - e * g / h, c - e * f / h, d - f * g / h);
    let square = -q * r / (h * p);
    let is_real = square > 0.0 && square.is_finite();
    if !is_real {
        return;
    }
    for x in [square.sqrt(), -square.sqrt()] {
        let (y, z) = (-r / (h * x), -q / (h * x));
        let at = [x - f / h, y - g / h, z - e / h];
        count.near(inset(&at));
        if inset(&at) > 0.0 {
            let [i, j, k] = at;
            let value =
                a + b * i + c * j + d * k + e * i * j + f * j * k + g * i * k + h * i * j * k;
            count.near(value);
            if value >= 0.0 {
                count.euler += if h * x * y * z > 0.0 { -1 } else { 1 };
            }
        }
    }
}

/// Betti numbers of M: components, tunnels, cavities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Betti {
    pub b0: i64,
    pub b1: i64,
    pub b2: i64,
}

impl Betti {
    pub fn euler(self) -> i64 {
        self.b0 - self.b1 + self.b2
    }
}

/// The Betti numbers of M from digital pictures with 16, 32 or 64 points along a cell, the first in
/// which it makes no difference whether points that touch at corners are joined; nothing where that
/// is none.
pub fn digital(field: &Field, finest: usize) -> Option<Betti> {
    [16, 32, 64].into_iter().filter(|&k| k <= finest).find_map(|k| Picture::of(field, k).betti())
}

/// Points of M on a finer grid, one bit each, with a border of points that are not.
struct Picture {
    dims: [usize; 3],
    words: usize,
    rows: Vec<u64>,
}

impl Picture {
    fn of(field: &Field, k: usize) -> Self {
        let dims = field.dims.map(|n| (n - 1) * k + 3);
        let [nx, ny, nz] = dims;
        let words = nx.div_ceil(64);
        let mut rows = vec![0; words * ny * nz];
        let place = |i: usize, n: usize| {
            let cell = ((i - 1) / k).min(n - 2);
            (cell, (i - 1 - cell * k) as f64 / k as f64)
        };
        for z in 1..nz - 1 {
            let (cz, w) = place(z, field.dims[2]);
            for y in 1..ny - 1 {
                let (cy, v) = place(y, field.dims[1]);
                let row = &mut rows[words * (y + ny * z)..][..words];
                for x in 1..nx - 1 {
                    let (cx, u) = place(x, field.dims[0]);
                    let f = field.cell([cx, cy, cz]);
                    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
                    let near = mix(mix(f[0], f[1], u), mix(f[2], f[3], u), v);
                    let far = mix(mix(f[4], f[5], u), mix(f[6], f[7], u), v);
                    row[x / 64] |= u64::from(mix(near, far, w) >= 0.0) << (x % 64);
                }
            }
        }
        Self { dims, words, rows }
    }

    fn betti(&self) -> Option<Betti> {
        let [thin, thick] = [false, true].map(|corners| {
            let joined = |what| self.components(what, corners);
            (joined(true), joined(false))
        });
        let euler = self.euler(true);
        if thin != thick || euler != self.euler(false) {
            return None;
        }
        let (b0, outside) = thin;
        let b2 = outside - 1;
        Some(Betti { b0, b1: b0 + b2 - euler, b2 })
    }

    fn row(&self, y: usize, z: usize) -> &[u64] {
        &self.rows[self.words * (y + self.dims[1] * z)..][..self.words]
    }

    /// The runs of points in M, or not in it, in a row: first, and one past the last.
    fn runs(&self, y: usize, z: usize, what: bool, out: &mut Vec<[usize; 2]>) {
        let row = self.row(y, z);
        let is = |x: usize| (row[x / 64] >> (x % 64) & 1 == 1) == what;
        let mut x = 0;
        while x < self.dims[0] {
            let first = x;
            while x < self.dims[0] && is(x) {
                x += 1;
            }
            if x > first {
                out.push([first, x]);
            }
            x += 1;
        }
    }

    /// Components of the points in M, or of those not in it, joined along axes, or also across
    /// diagonals.
    fn components(&self, what: bool, corners: bool) -> i64 {
        let [_, ny, nz] = self.dims;
        let mut runs = Vec::new();
        let mut first = Vec::new();
        for row in 0..ny * nz {
            first.push(runs.len());
            self.runs(row % ny, row / ny, what, &mut runs);
        }
        first.push(runs.len());
        let mut parent: Vec<u32> = (0..runs.len() as u32).collect();
        let mut n = runs.len() as i64;
        let reach = usize::from(corners);
        for z in 0..nz {
            for y in 0..ny {
                let (up, last) = (y.wrapping_sub(1), z.wrapping_sub(1));
                let straight = [(up, z), (y, last)];
                let across = [(up, last), (y + 1, last)];
                let earlier = straight.into_iter().chain(across.into_iter().filter(|_| corners));
                for (v, w) in earlier.filter(|&(v, w)| v < ny && w < nz) {
                    let ends = |row: usize| (first[row], first[row + 1]);
                    let ((mut a, a_end), (mut b, b_end)) = (ends(y + ny * z), ends(v + ny * w));
                    while a < a_end && b < b_end {
                        let ([p, q], [r, s]) = (runs[a], runs[b]);
                        if p < s + reach && r < q + reach {
                            n -= i64::from(join(&mut parent, a as u32, b as u32));
                        }
                        if q < s { a += 1 } else { b += 1 }
                    }
                }
            }
        }
        n
    }

    /// The Euler number of M's points: with the edges, squares and cubes all of whose corners are
    /// in M (`all`), or as a union of closed boxes around them.
    fn euler(&self, all: bool) -> i64 {
        let [_, ny, nz] = self.dims;
        let both = |a: u64, b: u64| if all { a & b } else { a | b };
        let mut euler = 0;
        for axes in 0..8usize {
            // Points in a window along these axes are a cell's corners, or the boxes at one.
            let dimension = if all { axes.count_ones() } else { 3 - axes.count_ones() };
            let sign = if dimension % 2 == 0 { 1 } else { -1 };
            let [dx, dy, dz] = [axes & 1, axes >> 1 & 1, axes >> 2];
            let mut n = 0;
            for z in 0..nz - dz {
                for y in 0..ny - dy {
                    let [a, b] = [z, z + dz].map(|z| (self.row(y, z), self.row(y + dy, z)));
                    let at = |w: usize| both(both(a.0[w], a.1[w]), both(b.0[w], b.1[w]));
                    for w in 0..self.words {
                        // The last point of a row is in the border.
                        let next = if w + 1 < self.words { at(w + 1) << 63 } else { 0 };
                        let here = at(w);
                        let found = if dx == 1 { both(here, here >> 1 | next) } else { here };
                        n += i64::from(found.count_ones());
                    }
                }
            }
            euler += sign * n;
        }
        euler
    }
}

/// Joins two sets; whether they were two.
fn join(parent: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
    a != b
}

fn root(parent: &mut [u32], mut a: u32) -> u32 {
    while parent[a as usize] != a {
        parent[a as usize] = parent[parent[a as usize] as usize];
        a = parent[a as usize];
    }
    a
}

/// What a closed mesh encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enclosed {
    /// Components that enclose a positive volume, and those that are cavities.
    pub solids: i64,
    pub cavities: i64,
    /// V - E + F.
    pub euler: i64,
}

impl Enclosed {
    pub fn of(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut parent: Vec<u32> = (0..vertices.len() as u32).collect();
        for &[a, b, c] in triangles {
            join(&mut parent, a, b);
            join(&mut parent, b, c);
        }
        let mut volumes = vec![0.0; vertices.len()];
        for &[a, b, c] in triangles {
            let [p, q, r] = [a, b, c].map(|id| vertices[id as usize].map(f64::from));
            volumes[root(&mut parent, a) as usize] += p[0] * (q[1] * r[2] - q[2] * r[1])
                + p[1] * (q[2] * r[0] - q[0] * r[2])
                + p[2] * (q[0] * r[1] - q[1] * r[0]);
        }
        let euler = vertices.len() as i64 - (triangles.len() / 2) as i64;
        Self {
            solids: volumes.iter().filter(|&&v| v > 0.0).count() as i64,
            cavities: volumes.iter().filter(|&&v| v < 0.0).count() as i64,
            euler,
        }
    }
}
