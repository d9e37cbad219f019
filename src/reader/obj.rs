//! Wavefront OBJ: vertices, faces and normals; all else is passed over.
//!
//! Read by ourselves: a library that splits a file into its objects copies the vertices that they
//! share, and then cannot tell how the whole surface hangs together.

use super::build::{Highest, no_such_vertex, push_polygon, push_vertex};
use super::lines::{Lines, number, triple};
use super::{Input, ReadError};
use crate::mesh::Mesh;

/// Keywords that an OBJ file may begin with.
const KEYWORDS: [&[u8]; 9] = [b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl"];

/// Whether a file's first line that is no comment begins with a keyword.
pub(super) fn is_likely(start: &[u8]) -> bool {
    let lines = start.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let word = first.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|word| KEYWORDS.contains(&word))
}

/// Reads a file. Normals are kept where there is one for each vertex and faces use them so.
pub(super) fn read(input: Input) -> Result<Mesh, ReadError> {
    let mut lines = Lines::new(input, 0);
    let mut mesh = Mesh::default();
    let mut ids = Vec::new();
    let (mut n_faces, mut highest, mut in_step) = (0, Highest::default(), true);
    while lines.advance_joined()? {
        let mut words = lines.words();
        match words.next() {
            Some(b"v") => {
                let point = triple(&mut words).ok_or_else(|| lines.wrong("v x y z"))?;
                push_vertex(&mut mesh, point)?;
            }
            Some(b"vn") => {
                let normal = triple(&mut words).ok_or_else(|| lines.wrong("vn x y z"))?;
                mesh.normals.push(normal);
            }
            Some(b"f") => {
                n_faces += 1;
                ids.clear();
                for word in words {
                    let (id, normal) =
                        corner(word).ok_or_else(|| lines.wrong("vertex numbers after f"))?;
                    in_step &= normal.is_none_or(|normal| normal == id);
                    let n_vertices = mesh.vertices.len();
                    let index = absolute(id, n_vertices)
                        .ok_or_else(|| no_such_vertex(n_faces, id, n_vertices))?;
                    highest.see(index, n_faces);
                    ids.push(index);
                }
                push_polygon(&mut mesh, &ids, n_faces)?;
            }
            _ => {}
        }
    }
    highest.check(mesh.vertices.len(), 1)?;
    if mesh.vertices.is_empty() {
        return Err(ReadError::UnknownFormat);
    }
    if !in_step || mesh.normals.len() != mesh.vertices.len() {
        mesh.normals = Vec::new();
    }
    Ok(mesh)
}

/// The vertex and the normal of one corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(word: &[u8]) -> Option<(i64, Option<i64>)> {
    let mut parts = word.split(|&byte| byte == b'/');
    let vertex = number(parts.next()?)?;
    let _texture = parts.next();
    let normal = match parts.next() {
        Some(part) => Some(number(part)?),
        None => None,
    };
    Some((vertex, normal))
}

/// The index of the vertex that a face calls `id`: from 1, or from the last one backwards.
fn absolute(id: i64, n_vertices: usize) -> Option<u32> {
    let index = match id {
        1.. => id.checked_sub(1)?,
        0 => return None,
        _ => i64::try_from(n_vertices).ok()?.checked_add(id)?,
    };
    u32::try_from(index).ok()
}
