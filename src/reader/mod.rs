//! Mesh files back in: STL, PLY and OBJ, for `mcubes check`.
//!
//! Content decides what a file is. Counts in headers are compared with the size of the file
//! before anything is allocated for them. Polygons become fans of triangles.

mod build;
mod error;
mod lines;
mod obj;
mod ply;
mod stl;

pub use error::ReadError;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::Error;
use crate::mesh::Mesh;

/// As much of a file as tells what it is.
const SNIFF_BYTES: u64 = 4096;

/// What some editors begin UTF-8 text with (U+FEFF).
const MARK: &[u8] = b"\xef\xbb\xbf";

/// An open mesh file of known length.
type Input = BufReader<File>;

/// Reads a mesh file. STL corners with the same coordinates become one vertex; vertices of PLY
/// and OBJ stay as they are.
///
/// # Errors
/// The file is missing, unreadable, of another format, cut short, or contradicts itself.
pub fn read(path: &Path) -> Result<Mesh, Error> {
    open(path).map_err(|e| Error::at(path, e))
}

fn open(path: &Path) -> Result<Mesh, ReadError> {
    let mut file = File::open(path)?;
    let found = file.metadata()?;
    if found.is_dir() {
        return Err(ReadError::IsFolder);
    }
    if !found.is_file() {
        // A pipe: its length is known when it has been read.
        let mut whole = tempfile::tempfile()?;
        io::copy(&mut file, &mut whole)?;
        whole.rewind()?;
        file = whole;
    }
    let n_bytes = file.metadata()?.len();
    let mut start = Vec::new();
    (&mut file).take(SNIFF_BYTES).read_to_end(&mut start)?;
    let sniffed = sniff(&start, n_bytes, path);
    // The mark is no part of the text; of binary STL it would be part of the header.
    let is_marked = start.starts_with(MARK) && sniffed != Some(Sniffed::StlBinary);
    let skipped = if is_marked { MARK.len() as u64 } else { 0 };
    file.seek(SeekFrom::Start(skipped))?;
    let n_bytes = n_bytes - skipped;
    let input = BufReader::with_capacity(1 << 20, file);
    match sniffed {
        Some(Sniffed::StlBinary) => stl::binary(input, n_bytes),
        Some(Sniffed::StlText) => stl::text(input),
        Some(Sniffed::Ply) => ply::read(input, n_bytes),
        Some(Sniffed::Obj) => obj::read(input),
        None => Err(ReadError::UnknownFormat),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sniffed {
    StlBinary,
    StlText,
    Ply,
    Obj,
}

/// What the file is by its first bytes and its size; where they do not tell, its extension may.
fn sniff(start: &[u8], n_bytes: u64, path: &Path) -> Option<Sniffed> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let text = start.strip_prefix(MARK).unwrap_or(start);
    if text.starts_with(b"ply") && matches!(text.get(3), Some(b'\n' | b'\r' | b' ' | b'\t')) {
        return Some(Sniffed::Ply);
    }
    // Some programs begin binary files with `solid`, so the size is asked first.
    if stl::count(start).is_some_and(|count| n_bytes == stl::size(count)) {
        return Some(Sniffed::StlBinary);
    }
    let is_text = !start.contains(&0);
    let word = text.trim_ascii_start().get(..5);
    if is_text && word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return Some(Sniffed::StlText);
    }
    if is_text && (extension == "obj" || obj::is_likely(text)) {
        return Some(Sniffed::Obj);
    }
    (extension == "stl" && !start.is_empty() && !is_text).then_some(Sniffed::StlBinary)
}
