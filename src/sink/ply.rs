//! PLY: a header that counts, then vertices, then faces; little endian or text.
//!
//! Header by `ply-rs`. The header stands before the counts are known, so a comment is padded to
//! keep its length the same for all of them. Bodies are laid out here: per element, the library's
//! typed writer looks up each property by name, and that takes several times as long.

use std::ops::Range;
use std::sync::Arc;

use ply_rs::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType,
};
use ply_rs::writer::Writer;

use super::format::{Layout, MeshOptions};
use super::text::Line;
use super::{Encoded, Encoder};
use crate::geom::Space;
use crate::mesh::{Patch, Position, Triangle};

/// Bytes of one binary face: how many corners, and three ids.
const FACE: usize = 13;

/// Elements that are gathered before they are appended.
const BATCH: usize = 128;

/// Digits of the largest count.
const COUNT_DIGITS: usize = 10;

/// Writes patches as PLY.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlyEncoder {
    ascii: bool,
    normals: bool,
    space: Space,
}

impl PlyEncoder {
    pub(super) fn new(options: MeshOptions) -> Self {
        Self { ascii: options.ascii, normals: options.normals, space: options.space }
    }
}

impl Encoder for PlyEncoder {
    fn encode(&self, patch: &Patch, triangles: Range<usize>, out: &mut Encoded) {
        let vertices = if triangles.start == 0 { patch.own_vertices() } else { &[] };
        let triangles = &patch.triangles[triangles];
        match (self.ascii, self.normals) {
            (true, false) => text(vertices, &[], triangles, out),
            (true, true) => text(vertices, &patch.normals, triangles, out),
            (false, false) => {
                flat::<3, 12>(vertices, |&v| v, &mut out.vertices);
                faces(triangles, &mut out.faces);
            }
            (false, true) => {
                let mut normals = patch.normals.iter();
                let both = |&[x, y, z]: &Position| {
                    let [nx, ny, nz] = normals.next().copied().unwrap_or_default();
                    [x, y, z, nx, ny, nz]
                };
                flat::<6, 24>(vertices, both, &mut out.vertices);
                faces(triangles, &mut out.faces);
            }
        }
    }
}

impl Layout for PlyEncoder {
    fn encoder(&self) -> Arc<dyn Encoder> {
        Arc::new(*self)
    }

    fn header(&self, n_vertices: u64, n_triangles: u64) -> Vec<u8> {
        let digits = n_vertices.to_string().len() + n_triangles.to_string().len();
        let padding = (2 * COUNT_DIGITS).saturating_sub(digits);

        let float = PropertyType::Scalar(ScalarType::Float);
        let ids = PropertyType::List(ScalarType::UChar, ScalarType::Int);
        let names: &[&str] =
            if self.normals { &["x", "y", "z", "nx", "ny", "nz"] } else { &["x", "y", "z"] };
        let mut vertex = ElementDef::new("vertex".to_owned());
        vertex.count = usize::try_from(n_vertices).unwrap_or(usize::MAX);
        for name in names {
            vertex.properties.add(PropertyDef::new((*name).to_owned(), float.clone()));
        }
        let mut face = ElementDef::new("face".to_owned());
        face.count = usize::try_from(n_triangles).unwrap_or(usize::MAX);
        face.properties.add(PropertyDef::new("vertex_indices".to_owned(), ids));

        let mut header = Header::new();
        header.encoding = if self.ascii { Encoding::Ascii } else { Encoding::BinaryLittleEndian };
        header.comments.push(format!("mcubes{}", " ".repeat(padding)));
        header.comments.extend(self.space.tag().map(str::to_owned));
        header.elements.add(vertex);
        header.elements.add(face);

        let mut bytes = Vec::new();
        let written = Writer::<DefaultElement>::new().write_header(&mut bytes, &header);
        debug_assert!(written.is_ok(), "a vector takes every byte");
        bytes
    }

    fn strides(&self) -> Option<(u64, u64)> {
        let vertex = if self.normals { 24 } else { 12 };
        (!self.ascii).then_some((vertex, FACE as u64))
    }
}

/// Appends `N` little-endian numbers, `BYTES` bytes, for each vertex.
fn flat<const N: usize, const BYTES: usize>(
    vertices: &[Position],
    mut numbers: impl FnMut(&Position) -> [f32; N],
    out: &mut Vec<u8>,
) {
    const { assert!(BYTES == 4 * N) }
    out.reserve(vertices.len() * BYTES);
    let mut batch = [[0_u8; BYTES]; BATCH];
    for vertices in vertices.chunks(BATCH) {
        for (record, vertex) in batch.iter_mut().zip(vertices) {
            let (places, _) = record.as_chunks_mut::<4>();
            for (place, number) in places.iter_mut().zip(numbers(vertex)) {
                *place = number.to_le_bytes();
            }
        }
        out.extend_from_slice(batch[..vertices.len()].as_flattened());
    }
}

fn faces(triangles: &[Triangle], out: &mut Vec<u8>) {
    out.reserve(triangles.len() * FACE);
    let mut batch = [[3_u8; FACE]; BATCH];
    for triangles in triangles.chunks(BATCH) {
        for (record, triangle) in batch.iter_mut().zip(triangles) {
            let (ids, _) = record[1..].as_chunks_mut::<4>();
            for (id, value) in ids.iter_mut().zip(triangle) {
                *id = value.to_le_bytes();
            }
        }
        out.extend_from_slice(batch[..triangles.len()].as_flattened());
    }
}

/// `normals` is empty where none are written.
fn text(vertices: &[Position], normals: &[[f32; 3]], triangles: &[Triangle], out: &mut Encoded) {
    let mut line = Line::new();
    let mut normals = normals.iter();
    for &vertex in vertices {
        line.floats(vertex);
        if let Some(&normal) = normals.next() {
            line.floats(normal);
        }
        line.end(&mut out.vertices);
    }
    for triangle in triangles {
        line.word(b"3");
        for &id in triangle {
            line.integer(id);
        }
        line.end(&mut out.faces);
    }
}
