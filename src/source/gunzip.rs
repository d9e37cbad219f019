//! gzip as one stream of bytes: all members, each with its checksum and length checked.
//!
//! Inflates straight into the caller's buffer and holds nothing but the compressed input's buffer.

use std::io::{self, BufRead, BufReader, Read};

use flate2::bufread::GzDecoder;

use super::SourceError;
use super::waiting::is_stopped;

/// Compressed bytes read at a time.
const INPUT_BYTES: usize = 256 << 10;

/// Bytes inflated at a time: few enough that their checksum is taken while they are in the cache.
const STEP_BYTES: usize = 128 << 10;

type Input = BufReader<Box<dyn Read + Send>>;

/// A gzip file (RFC 1952) as the bytes that it holds.
pub(super) struct Gunzip {
    /// Nothing once the last member has ended.
    member: Option<GzDecoder<Input>>,
    inflated: u64,
    /// Whether the stream ended within a member.
    cut: bool,
    /// Bytes after the last member that are no gzip.
    trailing: u64,
}

impl Gunzip {
    /// Whether bytes begin a gzip member, perhaps a damaged one.
    pub(super) fn recognise(head: &[u8]) -> bool {
        head.starts_with(&[0x1f, 0x8b])
    }

    /// Whether bytes begin a member that can be read: where anything at all may stand, two bytes
    /// say little. The method is deflate and no reserved flag is set (RFC 1952, 2.3.1).
    pub(super) fn recognise_fully(head: &[u8]) -> bool {
        matches!(head, [0x1f, 0x8b, 8, flags, ..] if flags & 0xe0 == 0)
    }

    pub(super) fn new(input: Box<dyn Read + Send>) -> Self {
        let input = BufReader::with_capacity(INPUT_BYTES, input);
        Self { member: Some(GzDecoder::new(input)), inflated: 0, cut: false, trailing: 0 }
    }

    /// Whether the stream ended within a member.
    pub(super) fn is_cut(&self) -> bool {
        self.cut
    }

    /// Bytes inflated so far.
    pub(super) fn inflated(&self) -> u64 {
        self.inflated
    }

    /// Bytes after the last member that are no gzip, known at the end only.
    pub(super) fn trailing(&self) -> u64 {
        self.trailing
    }

    /// Fills `out`; how many bytes there were, fewer only at the end of the stream.
    pub(super) fn fill(&mut self, out: &mut [u8]) -> Result<usize, SourceError> {
        let mut done = 0;
        while done < out.len() {
            let Some(member) = &mut self.member else { break };
            let end = out.len().min(done + STEP_BYTES);
            let Some(rest) = out.get_mut(done..end) else { break };
            match member.read(rest) {
                Ok(0) => self.next_member()?,
                Ok(n) => {
                    done += n;
                    self.inflated += n as u64;
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) if e.raw_os_error().is_some() || is_stopped(&e) => return Err(e.into()),
                Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                    self.cut = true;
                    self.member = None;
                }
                Err(e) => {
                    self.member = None;
                    return Err(SourceError::GzipDamaged {
                        after: self.inflated,
                        reason: e.to_string(),
                    });
                }
            }
        }
        Ok(done)
    }

    /// Goes on to the member behind the one that has ended, or counts what is there instead:
    /// archives pad with zeros, and gunzip ignores anything.
    fn next_member(&mut self) -> Result<(), SourceError> {
        let Some(mut input) = self.member.take().map(GzDecoder::into_inner) else { return Ok(()) };
        loop {
            let found = match input.fill_buf() {
                Ok(found) => found,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(e.into()),
            };
            match found {
                [] => return Ok(()),
                [0x1f, ..] if self.trailing == 0 => {
                    self.member = Some(GzDecoder::new(input));
                    return Ok(());
                }
                junk => {
                    let n = junk.len();
                    self.trailing += n as u64;
                    input.consume(n);
                }
            }
        }
    }
}
