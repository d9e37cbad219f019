//! Lines of text from a file that may hold anything.

use std::io::{BufRead, Read};

use super::ReadError;

/// A longer line is not text that we read.
const MAX_LINE: u64 = 1 << 20;

/// The lines of a file, counted from 1.
pub(super) struct Lines<R> {
    input: R,
    bytes: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R, number: u64) -> Self {
        Self { input, bytes: Vec::new(), number }
    }

    /// Moves to the next line; false at the end of the file.
    pub(super) fn advance(&mut self) -> Result<bool, ReadError> {
        self.bytes.clear();
        self.number += 1;
        (&mut self.input).take(MAX_LINE).read_until(b'\n', &mut self.bytes)?;
        if self.bytes.len() as u64 == MAX_LINE {
            return Err(self.wrong("a line of text"));
        }
        Ok(!self.bytes.is_empty())
    }

    /// As [`Self::advance`]; a line that ends with a backslash, and is no comment, goes on with the
    /// next one.
    pub(super) fn advance_joined(&mut self) -> Result<bool, ReadError> {
        let is_line = self.advance()?;
        while let Some(length) = self.goes_on_after() {
            self.bytes.truncate(length);
            self.bytes.push(b' ');
            self.number += 1;
            let room = MAX_LINE.saturating_sub(self.bytes.len() as u64);
            if (&mut self.input).take(room).read_until(b'\n', &mut self.bytes)? as u64 == room {
                return Err(self.wrong("a line of text"));
            }
        }
        Ok(is_line)
    }

    /// How much of the line comes before the backslash at its end.
    fn goes_on_after(&self) -> Option<usize> {
        if self.bytes.trim_ascii_start().starts_with(b"#") {
            return None;
        }
        let line = self.bytes.strip_suffix(b"\n")?;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        line.strip_suffix(b"\\").map(<[u8]>::len)
    }

    /// The words of the line.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }

    /// The file itself, after the line.
    pub(super) fn input(&mut self) -> &mut R {
        &mut self.input
    }

    /// The line itself.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The line is not what is expected; the last one, without an end, is cut short.
    pub(super) fn wrong(&self, expected: &'static str) -> ReadError {
        if !self.bytes.ends_with(b"\n") && (self.bytes.len() as u64) < MAX_LINE {
            return ReadError::EndsWithin { within: format!("line {}", self.number) };
        }
        let line = String::from_utf8_lossy(self.bytes.get(..200).unwrap_or(&self.bytes));
        let found = line.trim().chars().take(40).map(|c| if c.is_control() { '?' } else { c });
        ReadError::Line { line: self.number, expected, found: found.collect() }
    }
}

/// A number in decimal digits.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The next three words as numbers.
pub(super) fn triple<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<[f32; 3]> {
    let mut next = || number(words.next()?);
    Some([next()?, next()?, next()?])
}
