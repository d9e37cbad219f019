//! STL, binary and text.

use std::io::Read;

use super::build::Joiner;
use super::lines::{Lines, triple};
use super::{Input, ReadError};
use crate::mesh::Mesh;

/// Bytes of header and count.
const HEADER: usize = 84;

/// Bytes of one triangle.
const RECORD: usize = 50;

/// The number of triangles that a binary file's first bytes tell.
pub(super) fn count(start: &[u8]) -> Option<u32> {
    let bytes = start.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

/// The bytes of a binary file of that many triangles.
pub(super) fn size(count: u32) -> u64 {
    HEADER as u64 + RECORD as u64 * u64::from(count)
}

/// Reads a binary file. Normals are not looked at; bytes after the last triangle neither.
pub(super) fn binary(mut input: Input, n_bytes: u64) -> Result<Mesh, ReadError> {
    if n_bytes < HEADER as u64 {
        return Err(ReadError::EndsWithin { within: "the header".to_owned() });
    }
    let mut header = [0; HEADER];
    input.read_exact(&mut header)?;
    let n_triangles = count(&header).unwrap_or(0);
    let wanted = size(n_triangles);
    if n_bytes < wanted {
        return Err(ReadError::TooShort {
            what: "triangles".to_owned(),
            count: n_triangles.into(),
            wanted: wanted.into(),
            found: n_bytes,
        });
    }
    let mut joiner = Joiner::new();
    let mut record = [0; RECORD];
    for _ in 0..n_triangles {
        input.read_exact(&mut record)?;
        let (numbers, _) = record.as_chunks::<4>();
        let mut numbers = numbers.iter().skip(3).map(|&bytes| f32::from_le_bytes(bytes));
        let mut corners = [[0.0; 3]; 3];
        for (place, number) in corners.as_flattened_mut().iter_mut().zip(&mut numbers) {
            *place = number;
        }
        joiner.add(corners)?;
    }
    Ok(joiner.finish())
}

/// Reads a text file, of one or several solids.
pub(super) fn text(input: Input) -> Result<Mesh, ReadError> {
    let mut lines = Lines::new(input, 0);
    let mut joiner = Joiner::new();
    let (mut corners, mut n_corners) = ([[0.0; 3]; 3], 0);
    let (mut in_solid, mut in_facet) = (false, false);
    while lines.advance()? {
        let mut words = lines.words();
        let Some(word) = words.next() else { continue };
        match (word.to_ascii_lowercase().as_slice(), in_solid, in_facet) {
            (b"solid", false, _) => in_solid = true,
            (b"endsolid", true, false) => in_solid = false,
            (b"facet", true, false) => (in_facet, n_corners) = (true, 0),
            (b"outer" | b"endloop", true, true) => {}
            (b"vertex", true, true) => {
                let point = triple(&mut words).ok_or_else(|| lines.wrong("vertex x y z"))?;
                *corners.get_mut(n_corners).ok_or_else(|| lines.wrong("three vertices"))? = point;
                n_corners += 1;
            }
            (b"endfacet", true, true) => {
                if n_corners != 3 {
                    return Err(lines.wrong("three vertices before the end of a facet"));
                }
                joiner.add(corners)?;
                in_facet = false;
            }
            _ => return Err(lines.wrong("the next line of an STL file")),
        }
    }
    if in_solid {
        let within = if in_facet { "a facet" } else { "a solid" };
        return Err(ReadError::EndsWithin { within: within.to_owned() });
    }
    Ok(joiner.finish())
}
