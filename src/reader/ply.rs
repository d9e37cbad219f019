//! PLY, text and binary of either byte order, by `ply-rs`, one element at a time.
//!
//! A face takes its corners from `vertex_indices` or `vertex_index`. Everything but positions,
//! normals and faces is passed over.

use std::io::{BufRead, ErrorKind, Read};

use ply_rs::parser::{ParseError, Parser, Reader};
use ply_rs::ply::{
    BeginList, ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::build::{Highest, no_such_vertex, push_polygon, push_vertex};
use super::lines::Lines;
use super::{Input, ReadError};
use crate::mesh::Mesh;

/// A longer header is refused.
const MAX_HEADER: u64 = 1 << 20;

/// Reads a file of `n_bytes`.
pub(super) fn read(mut input: Input, n_bytes: u64) -> Result<Mesh, ReadError> {
    let mut limited = Reader::new((&mut input).take(MAX_HEADER));
    let header = Parser::<Vertex>::new().read_header(&mut limited).map_err(|e| header_error(&e))?;
    let (n_lines, n_header) = (limited.line(), MAX_HEADER - limited.into_inner().limit());
    let is_text = header.encoding == Encoding::Ascii;

    let elements: Vec<&ElementDef> = header.elements.values().collect();
    let vertex = find(&elements, "vertex")?;
    for name in ["x", "y", "z"] {
        match vertex.properties.get(name).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            _ => return Err(ReadError::Header(format!("the element vertex has no number {name}"))),
        }
    }
    let has_normals = ["nx", "ny", "nz"].iter().all(|&name| vertex.properties.contains_key(name));
    let face = find(&elements, "face")?;
    if !face.properties.keys().any(|name| is_ids(name)) {
        return Err(ReadError::Header("the element face has no list vertex_indices".to_owned()));
    }
    check_size(&elements, is_text, n_header, n_bytes)?;

    let mut body = Body {
        lines: Lines::new(input, (n_lines as u64).saturating_sub(1)),
        encoding: header.encoding,
    };
    let mut mesh = Mesh::default();
    let (mut ids, mut highest) = (Vec::new(), Highest::default());
    for element in elements {
        for number in 1..=element.count as u64 {
            match element.name.as_str() {
                "vertex" => {
                    let vertex: Vertex = body.next(element, number)?;
                    push_vertex(&mut mesh, vertex.position)?;
                    if has_normals {
                        mesh.normals.push(vertex.normal);
                    }
                }
                "face" => {
                    let face: Face = body.next(element, number)?;
                    face.indices(&mut ids)
                        .map_err(|id| no_such_vertex(number, id, mesh.vertices.len()))?;
                    for &index in &ids {
                        highest.see(index, number);
                    }
                    push_polygon(&mut mesh, &ids, number)?;
                }
                _ => {
                    body.next::<Other>(element, number)?;
                }
            }
        }
    }
    highest.check(mesh.vertices.len(), 0)?;
    Ok(mesh)
}

fn find<'a>(elements: &[&'a ElementDef], name: &str) -> Result<&'a ElementDef, ReadError> {
    let found = elements.iter().find(|element| element.name == name);
    found.copied().ok_or_else(|| ReadError::Header(format!("there is no element {name}")))
}

fn is_ids(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

/// Compares the least number of bytes that the counts stand for with those there are.
fn check_size(
    elements: &[&ElementDef],
    is_text: bool,
    n_header: u64,
    n_bytes: u64,
) -> Result<(), ReadError> {
    // The last number of a text may end without a space or line end.
    let mut wanted = u128::from(n_header).saturating_sub(u128::from(is_text));
    for element in elements {
        let each: u128 = element
            .properties
            .values()
            .map(|property| match &property.data_type {
                _ if is_text => 2,
                PropertyType::Scalar(kind) | PropertyType::List(kind, _) => size(kind),
            })
            .sum();
        if each == 0 && element.count > 0 {
            let message = format!("the element {} has no properties", element.name);
            return Err(ReadError::Header(message));
        }
        wanted = wanted.saturating_add(each.saturating_mul(element.count as u128));
        if wanted > u128::from(n_bytes) {
            return Err(ReadError::TooShort {
                what: format!("elements {}", element.name),
                count: element.count as u64,
                wanted,
                found: n_bytes,
            });
        }
    }
    Ok(())
}

fn size(kind: &ScalarType) -> u128 {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn header_error(e: &ParseError) -> ReadError {
    if e.kind() == ErrorKind::UnexpectedEof {
        return ReadError::EndsWithin { within: "the header".to_owned() };
    }
    // The library's message has the line itself and a debug text on lines of their own.
    let message = e.to_string();
    let first = message.lines().next().unwrap_or_default().trim_end_matches('.');
    ReadError::Header(format!("the PLY header cannot be read: {}", first.to_lowercase()))
}

/// What follows the header.
struct Body<R> {
    lines: Lines<R>,
    encoding: Encoding,
}

impl<R: BufRead> Body<R> {
    fn next<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
        number: u64,
    ) -> Result<E, ReadError> {
        let parser = Parser::<E>::new();
        let within = || format!("{} {number} of {}", element.name, element.count);
        let parsed = match self.encoding {
            Encoding::Ascii => {
                loop {
                    if !self.lines.advance()? {
                        return Err(ReadError::EndsWithin { within: within() });
                    }
                    if self.lines.words().next().is_some() {
                        break;
                    }
                }
                let wrong = || self.lines.wrong("the numbers that the header says");
                let line = std::str::from_utf8(self.lines.bytes()).map_err(|_| wrong())?;
                return parser.read_ascii_element(line.trim(), element).map_err(|_| wrong());
            }
            Encoding::BinaryLittleEndian => {
                parser.read_little_endian_element(self.lines.input(), element)
            }
            Encoding::BinaryBigEndian => {
                parser.read_big_endian_element(self.lines.input(), element)
            }
        };
        parsed.map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => ReadError::EndsWithin { within: within() },
            _ => ReadError::Header(format!("{} is not what the header says", within())),
        })
    }
}

/// A vertex in the making.
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], normal: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        match value.to_f32_lossy() {
            Some(value) => self.set_float(name, value),
            None => PropertyAccessResult::Ignored,
        }
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ => return PropertyAccessResult::Ignored,
        };
        *place = value;
        PropertyAccessResult::Set
    }
}

/// A face in the making: its vertices as the file's type has them.
#[derive(Default)]
struct Face {
    signed: Vec<i32>,
    unsigned: Vec<u32>,
}

impl Face {
    /// Puts the indices into `out`, or gives back one that is negative.
    fn indices(&self, out: &mut Vec<u32>) -> Result<(), i64> {
        out.clear();
        out.extend_from_slice(&self.unsigned);
        for &id in &self.signed {
            out.push(u32::try_from(id).map_err(|_| i64::from(id))?);
        }
        Ok(())
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn begin_list_int(&mut self, name: &str, _len: usize) -> BeginList<'_, i32> {
        if is_ids(name) { BeginList::Fill(&mut self.signed) } else { BeginList::UseSetter }
    }

    fn begin_list_uint(&mut self, name: &str, _len: usize) -> BeginList<'_, u32> {
        if is_ids(name) { BeginList::Fill(&mut self.unsigned) } else { BeginList::UseSetter }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !is_ids(name) {
            return PropertyAccessResult::Ignored;
        }
        self.signed = match value {
            Property::ListChar(ids) => ids.into_iter().map(i32::from).collect(),
            Property::ListUChar(ids) => ids.into_iter().map(i32::from).collect(),
            Property::ListShort(ids) => ids.into_iter().map(i32::from).collect(),
            Property::ListUShort(ids) => ids.into_iter().map(i32::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is passed over.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Self
    }
}
