//! A judge of meshes that knows nothing of how they were made.

use std::collections::HashMap;

use mcubes::mesh::{Position, Triangle};

/// Panics where the mesh breaks the promise: closed, manifold, wound the same way round
/// everywhere, no face of zero area, no duplicate face, no unused vertex, no two vertices at the
/// same place.
pub fn assert_clean(vertices: &[Position], triangles: &[Triangle], what: &str) {
    check(vertices, triangles, true).unwrap_or_else(|e| panic!("{what}: {e}"));
}

/// The same for a mesh that may have a boundary.
pub fn assert_clean_but_open(vertices: &[Position], triangles: &[Triangle], what: &str) {
    check(vertices, triangles, false).unwrap_or_else(|e| panic!("{what}: {e}"));
}

fn check(vertices: &[Position], triangles: &[Triangle], closed: bool) -> Result<(), String> {
    let mut places = HashMap::new();
    for (id, v) in vertices.iter().enumerate() {
        if !v.iter().all(|x| x.is_finite()) {
            return Err(format!("vertex {id} is {v:?}"));
        }
        // Equal as numbers: the two zeros are one place.
        if let Some(other) = places.insert(v.map(|x| (x + 0.0).to_bits()), id) {
            return Err(format!("vertices {other} and {id} lie at {v:?}"));
        }
    }
    let mut halves: HashMap<(u32, u32), u32> = HashMap::new();
    let mut fans: Vec<Vec<(u32, u32)>> = vec![Vec::new(); vertices.len()];
    for (n, &[a, b, c]) in triangles.iter().enumerate() {
        if a == b || b == c || c == a {
            return Err(format!("triangle {n} is {:?}", [a, b, c]));
        }
        let p = [a, b, c].map(|id| vertices.get(id as usize).copied());
        let [Some(p), Some(q), Some(r)] = p else {
            return Err(format!("triangle {n} names a vertex that is not there"));
        };
        if area(p, q, r) == 0.0 {
            return Err(format!("triangle {n} has no area: {p:?} {q:?} {r:?}"));
        }
        for (from, to, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
            if halves.insert((from, to), apex).is_some() {
                return Err(format!("edge {from} -> {to} is used twice in one direction"));
            }
            fans[apex as usize].push((from, to));
        }
    }
    let open = halves.keys().find(|(a, b)| !halves.contains_key(&(*b, *a)));
    if let (true, Some(edge)) = (closed, open) {
        return Err(format!("edge {edge:?} is open"));
    }
    for (id, fan) in fans.iter().enumerate() {
        if fan.is_empty() {
            return Err(format!("vertex {id} is in no triangle"));
        }
        let next: HashMap<u32, u32> = fan.iter().copied().collect();
        let ends: Vec<u32> = fan.iter().map(|e| e.1).collect();
        let start = fan.iter().map(|e| e.0).find(|a| !ends.contains(a)).unwrap_or(fan[0].0);
        let (mut at, mut steps) = (start, 0);
        while let Some(&to) = next.get(&at) {
            (at, steps) = (to, steps + 1);
            if at == start {
                break;
            }
        }
        if steps != fan.len() {
            return Err(format!("the faces around vertex {id} make more than one fan"));
        }
    }
    Ok(())
}

fn area(p: Position, q: Position, r: Position) -> f64 {
    let d = |a: Position, b: Position| [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
    let (u, v) = (d(q, p), d(r, p));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    n.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The volume that the mesh encloses: positive where its triangles face outward.
pub fn enclosed(vertices: &[Position], triangles: &[Triangle]) -> f64 {
    let at = |id: u32| vertices[id as usize].map(f64::from);
    let six = triangles.iter().map(|&[a, b, c]| {
        let (p, q, r) = (at(a), at(b), at(c));
        p[0] * (q[1] * r[2] - q[2] * r[1])
            + p[1] * (q[2] * r[0] - q[0] * r[2])
            + p[2] * (q[0] * r[1] - q[1] * r[0])
    });
    six.sum::<f64>() / 6.0
}
