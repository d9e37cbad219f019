//! Opening a file whatever its name: the content says what it is.

use std::path::{Path, PathBuf};

use super::input::Input;
use super::nifti::{self, Nifti, Part};
use super::{SourceError, Volume};
use crate::Error;
use crate::cancel::Cancel;
use crate::volume::{Meta, Note};

/// The most volumes of one file that [`volumes`] lists.
pub const MAX_LISTED_VOLUMES: usize = 65_536;

/// How to open a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// Which volume of a file that holds several, from 1; the first where nothing is said.
    pub volume: Option<usize>,
}

/// What a file is by its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Content {
    /// NIfTI, plain or gzipped, one file or a part of a pair. Opened by [`open`].
    Nifti,
    /// A DICOM object.
    Dicom,
    /// A zip archive.
    Zip,
    /// A folder.
    Folder,
    /// A pipe or a device, which was not looked into since its bytes come only once. [`open`] takes
    /// it for NIfTI.
    Stream,
    /// gzip of something else.
    Gzip,
    /// A format that is known but not read here, by name.
    Foreign(&'static str),
    /// Anything else.
    Unknown,
}

/// Looks at a file's first bytes.
///
/// # Errors
/// `not-found`, `unreadable`; a gzip file so damaged that it cannot be looked into.
pub fn sniff(path: &Path) -> Result<Content, Error> {
    let at = |e: SourceError| Error::at(path, e);
    let facts = std::fs::metadata(path).map_err(|e| at(e.into()))?;
    if facts.is_dir() {
        return Ok(Content::Folder);
    }
    if !facts.is_file() {
        return Ok(Content::Stream);
    }
    let input = Input::open(path, &Cancel::new()).map_err(at)?;
    match content_of(input.head()) {
        Content::Nifti => Ok(Content::Nifti),
        _ if is_image(path) => Ok(Content::Nifti),
        Content::Gzip => {
            let mut stream = input.into_stream(true).map_err(at)?;
            let head = nifti::head_of(&mut stream).map_err(at)?;
            Ok(if nifti::recognise(&head) { Content::Nifti } else { Content::Gzip })
        }
        content => Ok(content),
    }
}

/// The files that a volume at `path` is read from: itself, and the other one of a pair. Reads the
/// header of a regular file whose name does not tell.
pub fn files(path: &Path) -> Vec<PathBuf> {
    let other = match nifti::part_by_name(path) {
        Some(Part::Image) => nifti::partner(path, Part::Header).ok(),
        Some(Part::Header) => nifti::partner(path, Part::Image).ok(),
        None if is_header_of_pair(path) => nifti::partner(path, Part::Image).ok(),
        None => None,
    };
    [Some(path.to_owned()), other].into_iter().flatten().collect()
}

/// Whether a regular file begins with the header of a pair, as a `.nii` may that was split.
fn is_header_of_pair(path: &Path) -> bool {
    let header = || {
        let input = Input::open(path, &Cancel::new()).ok()?;
        if !input.is_gzip() {
            return Some(input.head().to_vec());
        }
        nifti::head_of(&mut input.into_stream(true).ok()?).ok()
    };
    // What is no regular file gives its bytes only once.
    path.is_file() && header().is_some_and(|header| nifti::is_of_pair(&header))
}

/// Whether a volume at `path` can be read only once, since it, or the other file of its pair, is a
/// pipe or a device.
pub fn is_stream(path: &Path) -> bool {
    let is_one = |facts: std::fs::Metadata| !facts.is_file() && !facts.is_dir();
    files(path).iter().any(|path| std::fs::metadata(path).is_ok_and(is_one))
}

/// Whether a file is the image of a pair: it has no header of its own, but one beside it. Its
/// samples may begin like anything at all.
fn is_image(path: &Path) -> bool {
    nifti::part_by_name(path) == Some(Part::Image) && nifti::partner(path, Part::Header).is_ok()
}

/// What the first bytes of a file say.
fn content_of(head: &[u8]) -> Content {
    if super::gunzip::Gunzip::recognise(head) {
        return Content::Gzip;
    }
    if head.get(128..132) == Some(b"DICM") {
        return Content::Dicom;
    }
    if nifti::recognise(head) {
        return Content::Nifti;
    }
    if super::dicom::is_zip(head) {
        return Content::Zip;
    }
    let foreign: [(&[u8], &str); 13] = [
        (b"\0\x05\x16\x07", "AppleDouble"),
        (b"NRRD000", "NRRD"),
        (b"ObjectType", "MetaImage"),
        (b"\x89HDF\r\n\x1a\n", "HDF5 (MINC 2)"),
        (b"CDF\x01", "NetCDF (MINC 1)"),
        (b"\x93NUMPY", "a NumPy array"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"\xff\xd8\xff", "JPEG"),
        (b"II*\0", "TIFF"),
        (b"MM\0*", "TIFF"),
        (b"\x28\xb5\x2f\xfd", "zstd"),
        (b"BZh", "bzip2"),
        (b"\xfd7zXZ\0", "xz"),
    ];
    match foreign.into_iter().find(|(magic, _)| head.starts_with(magic)) {
        Some((_, name)) => Content::Foreign(name),
        None if super::dicom::is_dicom(head) => Content::Dicom,
        None => Content::Unknown,
    }
}

/// Opens the NIfTI file at `path`; `path` may be either part of a pair. Nothing but headers is
/// read; a plain file's size is checked against its header. `cancel` ends a wait for a pipe, then and
/// while its planes are read.
///
/// # Errors
/// Everything that headers and sizes can have wrong. What only the samples can show comes from the
/// planes.
pub fn open(path: &Path, options: &OpenOptions, cancel: &Cancel) -> Result<Volume<'static>, Error> {
    let nifti = open_nifti(path, cancel)?;
    let of = nifti.meta.n_volumes;
    let mut volume = nifti.volume(options.volume.unwrap_or(1)).map_err(|e| Error::at(path, e))?;
    if of > 1 && options.volume.is_none() {
        volume.meta.notes.insert(0, Note::ChoseVolume { number: 1, of });
    }
    Ok(volume)
}

/// The facts of every volume of the NIfTI file at `path`, at most [`MAX_LISTED_VOLUMES`] of them;
/// each says how many there are.
///
/// # Errors
/// As [`open`].
pub fn volumes(path: &Path) -> Result<Vec<Meta>, Error> {
    Ok(volumes_beside(&open_nifti(path, &Cancel::new())?.meta))
}

/// As [`volumes`], of the file that one of its volumes was opened from. Reads nothing.
pub fn volumes_beside(one: &Meta) -> Vec<Meta> {
    let mut meta = one.clone();
    meta.notes.retain(|note| !matches!(note, Note::ChoseVolume { .. }));
    let listed = 1..=meta.n_volumes.min(MAX_LISTED_VOLUMES);
    listed.map(|number| Meta { volume_number: number, ..meta.clone() }).collect()
}

fn open_nifti(path: &Path, cancel: &Cancel) -> Result<Nifti, Error> {
    let at = |e: SourceError| Error::at(path, e);
    let input = Input::open(path, cancel).map_err(at)?;
    let unknown = |name| Error::at(path, SourceError::UnknownFormat(name));
    let is_image = is_image(path);
    match content_of(input.head()) {
        // The samples of an image may begin like a header, but not like one that can be used.
        Content::Nifti if !is_image || nifti::is_usable(input.head()) => {
            Nifti::open(path, input, cancel)
        }
        _ if is_image => {
            let header = nifti::partner(path, Part::Header).map_err(|e| at(e.into()))?;
            let input = Input::open(&header, cancel).map_err(|e| Error::at(&header, e))?;
            Nifti::open(&header, input, cancel)
        }
        Content::Dicom => Err(unknown(Some("DICOM"))),
        Content::Zip => Err(unknown(Some("a zip archive"))),
        Content::Foreign(name) => Err(unknown(Some(name))),
        _ => Nifti::open(path, input, cancel),
    }
}
