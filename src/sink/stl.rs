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
use crate::mesh::Patch;

/// Bytes of one binary triangle.
const RECORD: usize = 50;

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

fn binary(patch: &Patch, triangles: Range<usize>, out: &mut Vec<u8>) {
    let start = out.len();
    out.resize(start + triangles.len() * RECORD, 0);
    let (records, _) = out[start..].as_chunks_mut::<RECORD>();
    for (record, n) in records.iter_mut().zip(triangles) {
        let [a, b, c] = patch.corners(patch.triangles[n]);
        let (numbers, _) = record.as_chunks_mut::<4>();
        for (number, value) in
            numbers.iter_mut().zip([patch.face_normal(n), a, b, c].as_flattened())
        {
            *number = value.to_le_bytes();
        }
    }
}

fn text(patch: &Patch, triangles: Range<usize>, out: &mut Vec<u8>) {
    let mut line = Line::new();
    for n in triangles {
        line.word(b"facet normal").floats(patch.face_normal(n)).end(out);
        out.extend_from_slice(b"outer loop\n");
        for corner in patch.corners(patch.triangles[n]) {
            line.word(b"vertex").floats(corner).end(out);
        }
        out.extend_from_slice(b"endloop\nendfacet\n");
    }
}
