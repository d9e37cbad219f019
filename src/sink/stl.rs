//! STL: each triangle for itself, with its normal.
//!
//! Binary: 80 bytes of header, a `u32` count, 50 bytes a triangle (12 little-endian `f32`: normal
//! and corners, then two bytes of zero). The header begins with the program's name, never with
//! `solid`, which readers take for text.

use std::ops::Range;
use std::sync::Arc;

use super::format::{Layout, MeshOptions};
use super::text::Line;
use super::{Encoded, Encoder};
use crate::geom::Space;
use crate::geom::vec3::{cross, dot, sub};
use crate::mesh::{Patch, Position, Triangle};

/// Bytes of one binary triangle.
const RECORD: usize = 50;

/// Triangles that are gathered before they are appended.
const BATCH: usize = 64;

/// Writes patches as STL.
#[derive(Clone, Copy, Debug)]
pub(super) struct StlEncoder {
    ascii: bool,
    space: Space,
}

impl StlEncoder {
    pub(super) fn new(options: MeshOptions) -> Self {
        Self { ascii: options.ascii, space: options.space }
    }
}

impl Encoder for StlEncoder {
    fn encode(&self, patch: &Patch, triangles: Range<usize>, out: &mut Encoded) {
        let triangles = &patch.triangles[triangles];
        if self.ascii {
            text(patch, triangles, &mut out.faces);
        } else {
            binary(patch, triangles, &mut out.faces);
        }
    }
}

impl Layout for StlEncoder {
    fn encoder(&self) -> Arc<dyn Encoder> {
        Arc::new(*self)
    }

    fn header(&self, _n_vertices: u64, n_triangles: u64) -> Vec<u8> {
        let title = match self.space.tag() {
            Some(tag) => format!("mcubes {tag}"),
            None => "mcubes".to_owned(),
        };
        if self.ascii {
            return format!("solid {title}\n").into_bytes();
        }
        let mut header = format!("{title:<80}").into_bytes();
        header.extend_from_slice(&u32::try_from(n_triangles).unwrap_or(u32::MAX).to_le_bytes());
        header
    }

    fn footer(&self) -> &'static [u8] {
        if self.ascii { b"endsolid mcubes\n" } else { b"" }
    }

    fn strides(&self) -> Option<(u64, u64)> {
        (!self.ascii).then_some((0, RECORD as u64))
    }
}

/// The unit normal of a triangle, computed in `f64` from the corners as they are written; zero
/// where the corners lie on one line.
fn normal([a, b, c]: [Position; 3]) -> [f32; 3] {
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    let n = cross(sub(b, a), sub(c, a));
    let square = dot(n, n);
    if square > 0.0 && square < f64::INFINITY {
        let scale = 1.0 / square.sqrt();
        n.map(|x| (x * scale) as f32)
    } else {
        [0.0; 3]
    }
}

fn binary(patch: &Patch, triangles: &[Triangle], out: &mut Vec<u8>) {
    out.reserve(triangles.len() * RECORD);
    let mut batch = [[0_u8; RECORD]; BATCH];
    for triangles in triangles.chunks(BATCH) {
        for (record, &triangle) in batch.iter_mut().zip(triangles) {
            let corners = patch.corners(triangle);
            let (numbers, _) = record.as_chunks_mut::<4>();
            let values = [normal(corners), corners[0], corners[1], corners[2]];
            for (number, value) in numbers.iter_mut().zip(values.as_flattened()) {
                *number = value.to_le_bytes();
            }
        }
        out.extend_from_slice(batch[..triangles.len()].as_flattened());
    }
}

fn text(patch: &Patch, triangles: &[Triangle], out: &mut Vec<u8>) {
    let mut line = Line::new();
    for &triangle in triangles {
        let corners = patch.corners(triangle);
        line.word(b"facet normal").floats(normal(corners)).end(out);
        out.extend_from_slice(b"outer loop\n");
        for corner in corners {
            line.word(b"vertex").floats(corner).end(out);
        }
        out.extend_from_slice(b"endloop\nendfacet\n");
    }
}
