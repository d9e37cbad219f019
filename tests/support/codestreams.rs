//! Compressed frames with the samples they hold, as the `make.py` of a folder in `testdata` writes
//! them: NAME with the codestream, NAME.raw with the samples, and index.txt.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;

use mcubes::source::dicom::{CodestreamError, DecodedFrame};

use super::random::Random;
use super::repository;

/// A process of the JPEG family: the decoder, and where the frames for it are kept.
pub(crate) struct Process {
    pub(crate) decode: fn(&[u8], usize, usize) -> Result<DecodedFrame, CodestreamError>,
    pub(crate) folder: &'static str,
    pub(crate) extension: &'static str,
}

impl Process {
    /// The frames kept in the repository.
    pub(crate) fn kept(&self) -> Vec<Frame> {
        frames(&repository(self.folder), self.extension)
    }

    pub(crate) fn kept_frame(&self, name: &str) -> Frame {
        self.kept().into_iter().find(|frame| frame.name == name).unwrap()
    }

    /// Panics unless the kept frames, `least` or more, decode to the samples beside them.
    pub(crate) fn check_kept(&self, least: usize) {
        let frames = self.kept();
        assert!(frames.len() >= least);
        self.check(&frames);
    }

    /// The same of a folder of frames that an environment variable names.
    pub(crate) fn check_folder(&self, variable: &str) {
        let folder = std::env::var_os(variable).unwrap();
        self.check(&frames(Path::new(&folder), self.extension));
    }

    fn check(&self, frames: &[Frame]) {
        for frame in frames {
            let decoded = (self.decode)(&frame.stream, frame.rows, frame.cols);
            let decoded = decoded.unwrap_or_else(|e| panic!("{}: {e}", frame.name));
            frame.assert_is(decoded.bits, &decoded.samples);
        }
    }

    /// Panics unless damaged frames are refused or give as many samples as were asked for, each
    /// within its bits.
    pub(crate) fn check_damage(&self, random: &mut Random) {
        for frame in self.kept() {
            for _ in 0..400 {
                let stream = frame.damaged(random);
                if let Ok(decoded) = (self.decode)(&stream, frame.rows, frame.cols) {
                    assert_eq!(decoded.samples.len(), frame.rows * frame.cols);
                    let largest = u16::MAX >> (16 - decoded.bits);
                    assert!(decoded.samples.iter().all(|&s| s <= largest), "{}", frame.name);
                }
            }
        }
    }
}

#[derive(Clone)]
pub(crate) struct Frame {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    pub(crate) bits: u8,
    pub(crate) stream: Vec<u8>,
    pub(crate) samples: Vec<u16>,
}

/// The frames of a folder, whose codestreams have the extension given.
fn frames(folder: &Path, extension: &str) -> Vec<Frame> {
    let index = fs::read_to_string(folder.join("index.txt")).unwrap();
    let frame = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        let number = |at: usize| fields[at].parse().unwrap();
        let raw = fs::read(folder.join(format!("{}.raw", fields[0]))).unwrap();
        Frame {
            name: fields[0].to_owned(),
            rows: number(1),
            cols: number(2),
            bits: number(3) as u8,
            stream: fs::read(folder.join(format!("{}.{extension}", fields[0]))).unwrap(),
            samples: raw.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect(),
        }
    };
    index.lines().map(frame).collect()
}

impl Frame {
    /// Panics unless a decoder found the bits and the samples that the frame has.
    fn assert_is(&self, bits: u8, samples: &[u16]) {
        let Self { name, .. } = self;
        assert_eq!(bits, self.bits, "{name}");
        let differs = samples.iter().zip(&self.samples).position(|(a, b)| a != b);
        assert_eq!(differs, None, "{name}: the first sample that differs");
        assert_eq!(samples.len(), self.samples.len(), "{name}");
    }

    /// Where the coded data begin: after the segment of the SOS marker.
    pub(crate) fn data_begin(&self) -> usize {
        self.stream.windows(2).position(|w| w == [0xFF, 0xDA]).unwrap() + 10
    }

    /// The codestream with the byte that is `at` bytes after its first `marker` changed.
    pub(crate) fn changed(&self, marker: u8, at: usize, value: u8) -> Vec<u8> {
        let mut stream = self.stream.clone();
        let begin = stream.windows(2).position(|w| w == [0xFF, marker]).unwrap();
        stream[begin + at] = value;
        stream
    }

    /// The codestream with a few bytes changed.
    pub(crate) fn damaged(&self, random: &mut Random) -> Vec<u8> {
        let mut stream = self.stream.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(stream.len() as u64) as usize;
            match random.below(4) {
                0 => stream[at] ^= 1 << random.below(8),
                1 => stream[at] = random.below(256) as u8,
                2 => stream[at] = if random.below(2) == 0 { 0xFF } else { 0 },
                _ => _ = stream.splice(at..at, [random.below(256) as u8]),
            }
        }
        stream
    }
}
