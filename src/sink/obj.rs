//! Wavefront OBJ: text, vertices counted from 1.

use std::ops::Range;
use std::sync::Arc;

use super::format::{Layout, MeshOptions};
use super::text::Line;
use super::{Encoded, Encoder};
use crate::geom::Space;
use crate::mesh::Patch;

/// Writes patches as OBJ.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjEncoder {
    normals: bool,
    space: Space,
}

impl ObjEncoder {
    pub(super) fn new(options: MeshOptions) -> Self {
        Self { normals: options.normals, space: options.space }
    }
}

impl Encoder for ObjEncoder {
    fn encode(&self, patch: &Patch, triangles: Range<usize>, out: &mut Encoded) {
        let mut line = Line::new();
        let mut normals = patch.normals.iter();
        let vertices = if triangles.start == 0 { patch.own_vertices() } else { &[] };
        for &vertex in vertices {
            line.word(b"v").floats(vertex).end(&mut out.vertices);
            if self.normals {
                let normal = normals.next().copied().unwrap_or_default();
                line.word(b"vn").floats(normal).end(&mut out.vertices);
            }
        }
        for triangle in &patch.triangles[triangles] {
            line.word(b"f");
            for &id in triangle {
                let number = id.saturating_add(1);
                line.integer(number);
                if self.normals {
                    line.word(b"//").digits(number);
                }
            }
            line.end(&mut out.faces);
        }
    }
}

impl Layout for ObjEncoder {
    fn encoder(&self) -> Arc<dyn Encoder> {
        Arc::new(*self)
    }

    fn header(&self, _n_vertices: u64, _n_triangles: u64) -> Vec<u8> {
        let mut header = "# mcubes\n".to_owned();
        if let Some(tag) = self.space.tag() {
            header.push_str("# ");
            header.push_str(tag);
            header.push('\n');
        }
        header.into_bytes()
    }

    fn strides(&self) -> Option<(u64, u64)> {
        None
    }
}
