//! NIfTI-1 and NIfTI-2: one file or a pair, plain or gzipped, in either byte order.
//!
//! Everything is told by content; names serve only to find the other file of a pair.

mod affine;
mod error;
mod fields;
mod header;
mod pair;

use std::fs::File;
use std::path::Path;

pub use error::NiftiError;
pub(super) use fields::{is_of_pair, recognise};
pub(super) use pair::{Part, part_by_name, partner};

use fields::{SIZE_1, SIZE_2};
use header::Header;

use super::file::FilePlanes;
use super::input::{Input, check_gzip_size};
use super::layout::{IntoPlanes, Layout};
use super::stream::{ByteStream, StreamPlanes};
use super::{SourceError, Volume};
use crate::Error;
use crate::cancel::Cancel;
use crate::volume::{Meta, Note};

/// An opened NIfTI file: what its header says, and where its samples are to be had.
pub(super) struct Nifti {
    /// The facts of the first volume.
    pub(super) meta: Meta,
    layout: Layout,
    samples: Opened,
}

/// A file that is ready to give its samples.
enum Opened {
    /// A regular file and its size.
    Plain(File, u64),
    /// A stream of which so many bytes were taken; the size of the gzip file behind it.
    Stream(ByteStream, u64, Option<u64>),
}

impl Nifti {
    /// Opens `input`, which stands at `path` and is a header by its content.
    pub(super) fn open(path: &Path, input: Input, cancel: &Cancel) -> Result<Self, Error> {
        let at = |e: SourceError| Error::at(path, e);
        let (head, opened) = begin(input).map_err(at)?;
        let mut header = Header::parse(&head).map_err(at)?;
        if header.single {
            let notes = opened.check(&header.layout, header.size).map_err(at)?;
            header.meta.notes.extend(notes);
            return Ok(Self { meta: header.meta, layout: header.layout, samples: opened });
        }
        let image = pair::partner(path, Part::Image).map_err(|e| at(e.into()))?;
        let at = |e: SourceError| Error::at(&image, e);
        let input = Input::open(&image, cancel).map_err(at)?;
        // Samples may happen to begin like gzip: the size that fits exactly decides.
        let fits = header.layout.offset.saturating_add(header.layout.total_bytes());
        let gzip = input.is_gzip() && !input.is_just(fits);
        let opened = Opened::new(input, gzip).map_err(at)?;
        let notes = opened.check(&header.layout, 0).map_err(at)?;
        header.meta.notes.extend(notes);
        Ok(Self { meta: header.meta, layout: header.layout, samples: opened })
    }

    /// The samples of volume `number`, counted from 1.
    pub(super) fn volume(mut self, number: usize) -> Result<Volume<'static>, SourceError> {
        let of = self.meta.n_volumes;
        if number < 1 || number > of {
            return Err(SourceError::NoSuchVolume { asked: number, of });
        }
        self.meta.volume_number = number;
        self.layout.volume = number as u64 - 1;
        let stored = self.layout.stored;
        let planes = match self.samples {
            Opened::Plain(file, _) => FilePlanes::new(file, self.layout).any(stored),
            Opened::Stream(stream, taken, _) => {
                StreamPlanes::new(stream, self.layout, taken).any(stored)
            }
        };
        Ok(Volume { meta: self.meta, planes })
    }
}

/// Whether a file begins with a header that can be used.
pub(super) fn is_usable(head: &[u8]) -> bool {
    Header::parse(head).is_ok()
}

/// The bytes of the header, and the file behind it.
fn begin(input: Input) -> Result<(Vec<u8>, Opened), SourceError> {
    let head = input.head().to_vec();
    let gzip = input.is_gzip();
    match Opened::new(input, gzip)? {
        Opened::Stream(mut stream, _, size) => {
            let head = head_of(&mut stream)?;
            let taken = head.len() as u64;
            Ok((head, Opened::Stream(stream, taken, size)))
        }
        plain @ Opened::Plain(..) => Ok((head, plain)),
    }
}

/// The bytes of the header at the beginning of a stream and no more, so that the samples come next.
pub(super) fn head_of(stream: &mut ByteStream) -> Result<Vec<u8>, SourceError> {
    let mut head = vec![0; SIZE_2];
    let (first, rest) = head.split_at_mut(SIZE_1);
    let mut n = stream.fill(first)?;
    if n == SIZE_1 && fields::version_of(first).is_some_and(|(version, _)| version == 2) {
        n += stream.fill(rest)?;
    }
    head.truncate(n);
    // A header that was cut with the gzip stream is a matter of the stream.
    match stream.cut() {
        Some(cut) if n < SIZE_1 => Err(cut),
        _ => Ok(head),
    }
}

impl Opened {
    fn new(input: Input, gzip: bool) -> Result<Self, SourceError> {
        let compressed = input.size().filter(|_| gzip);
        let input = if gzip {
            input
        } else {
            match input.into_file() {
                Ok((file, size)) => return Ok(Self::Plain(file, size)),
                Err(input) => input,
            }
        };
        Ok(Self::Stream(input.into_stream(gzip)?, 0, compressed))
    }

    /// Checks what can be known of the size beforehand. `header` bytes come first in the file.
    fn check(&self, layout: &Layout, header: u64) -> Result<Vec<Note>, SourceError> {
        match *self {
            Self::Stream(_, _, compressed) => {
                check_gzip_size(compressed, layout.total_bytes())?;
                Ok(Vec::new())
            }
            // Samples that begin beyond the end: a file that stops right after its header was cut,
            // in any other the field is wrong.
            Self::Plain(_, file) if layout.offset > file && file > header + 4 => {
                Err(NiftiError::OffsetBeyond { offset: layout.offset, file }.into())
            }
            Self::Plain(_, size) => layout.check_size(size),
        }
    }
}
