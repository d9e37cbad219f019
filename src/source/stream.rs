//! Planes that come in order: gzip, pipes, standard input.

use std::io::{self, Read};

use ndarray::ArrayViewMut2;

use super::gunzip::Gunzip;
use super::layout::{IntoPlanes, Layout};
use super::{OrderedPlanes, Planes, SourceError};
use crate::volume::{Note, Sample};

/// Bytes behind the samples that are read to be counted: some streams never end.
const MOST_SURPLUS: u64 = 256 << 20;

/// Bytes in order, plain or inflated.
pub(super) enum ByteStream {
    Plain(Box<dyn Read + Send>),
    Gzip(Box<Gunzip>),
}

impl ByteStream {
    /// Fills `out`; how many bytes there were, fewer only at the end of the stream.
    pub(super) fn fill(&mut self, out: &mut [u8]) -> Result<usize, SourceError> {
        let input = match self {
            Self::Gzip(gunzip) => return gunzip.fill(out),
            Self::Plain(input) => input,
        };
        let mut done = 0;
        while let Some(rest) = out.get_mut(done..).filter(|rest| !rest.is_empty()) {
            match input.read(rest) {
                Ok(0) => break,
                Ok(n) => done += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e.into()),
            }
        }
        Ok(done)
    }

    /// Reads past `n` bytes; how many there were, fewer only at the end of the stream.
    pub(super) fn skip(&mut self, n: u64) -> Result<u64, SourceError> {
        let mut scratch = vec![0; usize::try_from(n).unwrap_or(usize::MAX).min(64 << 10)];
        let mut left = n;
        while left > 0 {
            let step = scratch.len().min(usize::try_from(left).unwrap_or(usize::MAX));
            let Some(buffer) = scratch.get_mut(..step) else { break };
            let got = self.fill(buffer)?;
            left -= got as u64;
            if got < step {
                break;
            }
        }
        Ok(n - left)
    }

    /// The error of a compressed stream that was cut, if it was.
    pub(super) fn cut(&self) -> Option<SourceError> {
        match self {
            Self::Gzip(g) if g.is_cut() => Some(SourceError::GzipCut { after: g.inflated() }),
            _ => None,
        }
    }
}

/// The planes of one volume in a stream.
pub(super) struct StreamPlanes {
    stream: ByteStream,
    layout: Layout,
    /// Bytes of the stream taken so far.
    at: u64,
}

impl StreamPlanes {
    /// `taken` bytes of the stream have been read already, no more than the layout's offset.
    pub(super) fn new(stream: ByteStream, layout: Layout, taken: u64) -> Self {
        Self { stream, layout, at: taken }
    }
}

impl<T: Sample> OrderedPlanes<T> for StreamPlanes {
    fn next_plane(&mut self, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        let plane = out.as_slice_mut().ok_or(SourceError::PlaneBuffer)?;
        let start = self.layout.plane_start(0);
        if self.at < start {
            self.at += self.stream.skip(start - self.at)?;
            if self.at < start {
                return Err(self.layout.ends_early(self.at));
            }
        }
        let bytes = bytemuck::cast_slice_mut::<T, u8>(plane);
        let n = self.stream.fill(bytes)?;
        self.at += n as u64;
        if n < bytes.len() {
            return Err(self.layout.ends_early(self.at));
        }
        self.layout.to_native(plane);
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        let owed = self.layout.bytes_after();
        let most = match &self.stream {
            // To its end, where its checksum is.
            ByteStream::Gzip(_) => u64::MAX,
            ByteStream::Plain(_) => owed.saturating_add(MOST_SURPLUS),
        };
        let surplus = self.stream.skip(most)?;
        if surplus < owed {
            return Err(self.layout.ends_early(self.at + surplus));
        }
        if let Some(cut) = self.stream.cut() {
            return Err(cut);
        }
        let mut notes = self.layout.goes_on(surplus - owed)?;
        if let ByteStream::Gzip(gunzip) = &self.stream
            && gunzip.trailing() > 0
        {
            notes.push(Note::AfterGzip { bytes: gunzip.trailing() });
        }
        Ok(notes)
    }
}

impl IntoPlanes for StreamPlanes {
    fn planes<T: Sample>(self) -> Planes<'static, T> {
        Planes::Ordered(Box::new(self))
    }
}
