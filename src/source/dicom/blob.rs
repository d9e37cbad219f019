//! Where the bytes of a DICOM file come from: a plain file or an entry of a zip archive.
//!
//! Gives a stream from the start that can skip; knows nothing of DICOM.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use zip::ZipArchive;

use super::error::FileFault;
use crate::source::file::FileAt;

/// Bytes read at once from a plain file: most headers end within it.
const BUFFER: usize = 16 << 10;

/// The bytes of one file.
pub(super) enum Blob {
    /// A plain file.
    File { path: PathBuf, len: u64 },
    /// An entry of an archive.
    Zipped { archive: ZipArchive<Shared>, index: usize, len: u64 },
}

/// A stream over bytes, from the start, that counts and skips.
pub(super) struct Stream<'a> {
    inner: Inner<'a>,
    unread: Vec<u8>,
    at: u64,
    end: Option<u64>,
}

enum Inner<'a> {
    File(BufReader<Shared>),
    Plain(Box<dyn Read + 'a>),
}

impl Blob {
    /// The bytes there are.
    pub(super) fn len(&self) -> u64 {
        match self {
            Self::File { len, .. } | Self::Zipped { len, .. } => *len,
        }
    }

    /// The plain file, if it is one.
    pub(super) fn path(&self) -> Option<&Path> {
        match self {
            Self::File { path, .. } => Some(path),
            Self::Zipped { .. } => None,
        }
    }

    /// Hands a stream from the first byte to `read`, which takes as much of it as it wants.
    pub(super) fn with_stream<T>(
        &self,
        read: impl FnOnce(Stream<'_>) -> Result<T, FileFault>,
    ) -> Result<T, FileFault> {
        self.stream(false, read)
    }

    /// As [`Self::with_stream`], and fails where the bytes are not those that were archived: an
    /// entry is read on to its end, which is where its checksum is compared.
    pub(super) fn with_verified_stream<T>(
        &self,
        read: impl FnOnce(Stream<'_>) -> Result<T, FileFault>,
    ) -> Result<T, FileFault> {
        self.stream(true, read)
    }

    fn stream<T>(
        &self,
        verified: bool,
        read: impl FnOnce(Stream<'_>) -> Result<T, FileFault>,
    ) -> Result<T, FileFault> {
        match self {
            Self::File { path, len } => {
                let file = Shared::open(path).map_err(FileFault::io)?;
                read(Stream { end: Some(*len), ..Stream::within(file, 0) })
            }
            Self::Zipped { archive, index, len } => {
                // A copy shares the directory and has a position of its own.
                let mut archive = archive.clone();
                let zip = |e: &dyn std::error::Error| FileFault::Zip(one_line(e));
                // It gives no more than the size in the directory, as a few bytes can stand for any
                // number of them.
                let mut entry = archive.by_index(*index).map_err(|e| zip(&e))?;
                let mut stream = Stream::new(Box::new(&mut entry));
                stream.end = Some(*len);
                let done = read(stream)?;
                if verified {
                    io::copy(&mut entry, &mut io::sink())
                        .map_err(|e| FileFault::Zip(one_line(&e).to_lowercase()))?;
                }
                Ok(done)
            }
        }
    }
}

/// An error's own words, without line breaks and not too many of them.
pub(super) fn one_line(error: &dyn std::error::Error) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or_default().chars().take(160).collect()
}

impl<'a> Stream<'a> {
    /// Over any reader whose length is not known.
    pub(super) fn new(reader: Box<dyn Read + 'a>) -> Self {
        Self { inner: Inner::Plain(reader), unread: Vec::new(), at: 0, end: None }
    }

    /// Over a plain file from `at` on, to its end.
    pub(super) fn within(file: Shared, at: u64) -> Stream<'static> {
        let end = Some(file.len);
        let inner = Inner::File(BufReader::with_capacity(BUFFER, Shared { at, ..file }));
        Stream { inner, unread: Vec::new(), at, end }
    }

    /// Bytes passed so far.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Bytes left, where that is known.
    pub(super) fn left(&self) -> Option<u64> {
        self.end.map(|end| end.saturating_sub(self.at))
    }

    /// The rest, inflated (raw deflate, no header), as a stream that counts from 0.
    pub(super) fn inflate(mut self) -> Self {
        let unread = std::mem::take(&mut self.unread);
        let rest = io::Cursor::new(unread).chain(RestOf(self));
        Self::new(Box::new(BufReader::new(flate2::read::DeflateDecoder::new(rest))))
    }

    /// Gives bytes back, to be read again.
    pub(super) fn unread(&mut self, bytes: &[u8]) {
        self.at -= (bytes.len() as u64).min(self.at);
        self.unread.splice(0..0, bytes.iter().copied());
    }

    /// Fills as much of `out` as there are bytes for.
    pub(super) fn fill(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let given = self.unread.len().min(out.len());
        let mut n = given;
        for (to, from) in out.iter_mut().zip(self.unread.drain(..given)) {
            *to = from;
        }
        while let Some(rest) = out.get_mut(n..).filter(|r| !r.is_empty()) {
            let read = match &mut self.inner {
                Inner::File(file) => file.read(rest),
                Inner::Plain(reader) => reader.read(rest),
            };
            match read {
                Ok(0) => break,
                Ok(read) => n += read,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        self.at += n as u64;
        Ok(n)
    }

    /// Fills `out`; nothing where the bytes end before.
    pub(super) fn take(&mut self, out: &mut [u8]) -> io::Result<Option<()>> {
        Ok((self.fill(out)? == out.len()).then_some(()))
    }

    /// Passes over `n` bytes; whether there were as many.
    pub(super) fn skip(&mut self, n: u64) -> io::Result<bool> {
        if self.left().is_some_and(|left| left < n) {
            return Ok(false);
        }
        let given = self.unread.len().min(usize::try_from(n).unwrap_or(usize::MAX));
        self.unread.drain(..given);
        let rest = n - given as u64;
        match &mut self.inner {
            Inner::File(file) => {
                let Ok(by) = i64::try_from(rest) else { return Ok(false) };
                file.seek_relative(by)?;
            }
            Inner::Plain(reader) => {
                if io::copy(&mut reader.take(rest), &mut io::sink())? < rest {
                    return Ok(false);
                }
            }
        }
        self.at += n;
        Ok(true)
    }

    /// Appends up to `n` bytes to `out`; how many there were. Memory grows with what is there, not
    /// with what is asked for.
    pub(super) fn append(&mut self, n: u64, out: &mut Vec<u8>) -> io::Result<u64> {
        let given = self.unread.len().min(usize::try_from(n).unwrap_or(usize::MAX));
        out.extend(self.unread.drain(..given));
        let rest = n - given as u64;
        if matches!(self.inner, Inner::File(_)) {
            let there = rest.min(self.left().unwrap_or(0).saturating_sub(given as u64));
            let room = out.try_reserve(usize::try_from(there).unwrap_or(usize::MAX));
            room.map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
        }
        let read = match &mut self.inner {
            Inner::File(file) => file.take(rest).read_to_end(out)?,
            Inner::Plain(reader) => reader.take(rest).read_to_end(out)?,
        };
        let read = (given + read) as u64;
        self.at += read;
        Ok(read)
    }
}

/// What is left of a stream, as a reader.
struct RestOf<'a>(Stream<'a>);

impl Read for RestOf<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match &mut self.0.inner {
            Inner::File(file) => file.read(out),
            Inner::Plain(reader) => reader.read(out),
        }
    }
}

/// One open file, read through any number of positions at once.
#[derive(Clone)]
pub(super) struct Shared {
    file: Arc<FileAt>,
    at: u64,
    /// When it was opened.
    len: u64,
}

impl Shared {
    /// Opens a file.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        Self::over(File::open(path)?)
    }

    /// Over a file that is open.
    pub(super) fn over(file: File) -> io::Result<Self> {
        let len = file.metadata()?.len();
        Ok(Self { file: Arc::new(FileAt::new(file)), at: 0, len })
    }

    /// Fills what there is of `out` from `offset` on; how many bytes there were.
    pub(super) fn fill(&self, out: &mut [u8], offset: u64) -> io::Result<usize> {
        self.file.fill(out, offset)
    }

    /// Appends what there is of `length` bytes from `offset` on.
    pub(super) fn append(&self, offset: u64, length: u64, out: &mut Vec<u8>) -> io::Result<()> {
        let there = length.min(self.len.saturating_sub(offset));
        let there = usize::try_from(there).unwrap_or(usize::MAX);
        let before = out.len();
        out.try_reserve_exact(there).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
        out.resize(before + there, 0);
        let filled = self.fill(out.get_mut(before..).unwrap_or_default(), offset)?;
        out.truncate(before + filled);
        Ok(())
    }
}

impl Read for Shared {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.file.read_at(out, self.at)?;
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let target = match to {
            SeekFrom::Start(n) => Some(n),
            SeekFrom::End(n) => self.len.checked_add_signed(n),
            SeekFrom::Current(n) => self.at.checked_add_signed(n),
        };
        let target = target.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        self.at = target;
        Ok(target)
    }
}
