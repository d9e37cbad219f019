//! A file opened and looked at: its first bytes, its size if it has one, and the whole of it as a
//! stream. Knows no format but gzip.

use std::fs::File;
use std::io::{Cursor, Read, Seek};
use std::path::Path;

use super::SourceError;
use super::gunzip::Gunzip;
use super::stream::ByteStream;
use super::waiting::Waiting;
use crate::cancel::Cancel;

/// Bytes looked at: both NIfTI headers and DICOM's preamble fit.
pub(super) const HEAD_BYTES: usize = 544;

/// The most that deflate can make of one byte (258 bytes of output for two bits of input, less the
/// stream's own framing).
const DEFLATE_FACTOR: u64 = 1032;

/// An opened file whose first bytes have been looked at.
pub(super) struct Input {
    source: Source,
    /// The size; nothing for pipes and devices.
    size: Option<u64>,
    /// Whether its name ends in `.gz`.
    named_gzip: bool,
    head: Vec<u8>,
}

enum Source {
    /// A regular file; its cursor may stand anywhere.
    File(File),
    /// What follows the head.
    Stream(Waiting),
}

impl Input {
    /// What is no regular file may keep waiting, already to be opened, until `cancel` is raised.
    pub(super) fn open(path: &Path, cancel: &Cancel) -> Result<Self, SourceError> {
        let facts = std::fs::metadata(path)?;
        if facts.is_dir() {
            return Err(SourceError::Folder);
        }
        if !facts.is_file() {
            let path = path.to_owned();
            return Self::stream(Waiting::new(|| File::open(path), cancel)?);
        }
        let mut file = File::open(path)?;
        let size = file.metadata()?.len();
        let head = read_head(&mut file)?;
        let named_gzip = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
        Ok(Self { source: Source::File(file), size: Some(size), named_gzip, head })
    }

    /// Standard input.
    pub(super) fn stdin(cancel: &Cancel) -> Result<Self, SourceError> {
        Self::stream(Waiting::new(|| Ok(std::io::stdin()), cancel)?)
    }

    fn stream(mut stream: Waiting) -> Result<Self, SourceError> {
        let head = read_head(&mut stream)?;
        Ok(Self { source: Source::Stream(stream), size: None, named_gzip: false, head })
    }

    /// The first bytes of the file, as they stand in it.
    pub(super) fn head(&self) -> &[u8] {
        &self.head
    }

    /// The size in bytes, as it stands in the folder; nothing for pipes and devices.
    pub(super) fn size(&self) -> Option<u64> {
        self.size
    }

    pub(super) fn is_gzip(&self) -> bool {
        Gunzip::recognise(&self.head)
    }

    /// Whether the file's size says that it holds `bytes` bytes as they are, though they may begin
    /// like gzip. A gzip file may have just that size too, so one that is named so is none.
    pub(super) fn is_just(&self, bytes: u64) -> bool {
        self.size == Some(bytes) && !self.named_gzip
    }

    /// The whole content as a stream, inflated if `gzip` says so.
    pub(super) fn into_stream(self, gzip: bool) -> Result<ByteStream, SourceError> {
        let all: Box<dyn Read + Send> = match self.source {
            Source::File(mut file) => {
                file.rewind()?;
                Box::new(file)
            }
            Source::Stream(rest) => Box::new(Cursor::new(self.head).chain(rest)),
        };
        Ok(if gzip { ByteStream::Gzip(Box::new(Gunzip::new(all))) } else { ByteStream::Plain(all) })
    }

    /// The regular file itself and its size, or the input back where it is none.
    pub(super) fn into_file(self) -> Result<(File, u64), Self> {
        match (self.source, self.size) {
            (Source::File(file), Some(size)) => Ok((file, size)),
            (source, size) => Err(Self { source, size, ..self }),
        }
    }
}

/// Refuses a gzip file of `compressed` bytes, where that is known, if it is too small for
/// `of_bytes`, before anything is allocated for them.
pub(super) fn check_gzip_size(compressed: Option<u64>, of_bytes: u64) -> Result<(), SourceError> {
    match compressed {
        Some(compressed) if of_bytes / DEFLATE_FACTOR > compressed => {
            Err(SourceError::TooSmallForGzip { compressed, of_bytes })
        }
        _ => Ok(()),
    }
}

fn read_head(input: &mut impl Read) -> Result<Vec<u8>, SourceError> {
    let mut head = Vec::with_capacity(HEAD_BYTES);
    input.take(HEAD_BYTES as u64).read_to_end(&mut head)?;
    Ok(head)
}
