//! Writes DICOM segmentations: functional groups, a frame for some of the slices of each segment.

use super::dicom::{Elements, file};

pub(crate) const COLS: usize = 12;
pub(crate) const ROWS: usize = 10;

/// Between slices, mm.
pub(crate) const STEP: f64 = 2.5;

/// Where SpacingBetweenSlices stands in its `PixelMeasuresSequence`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Measures {
    Shared,
    PerFrame,
    /// Shared, and so many mm.
    Says(f64),
    /// Nowhere.
    Absent,
}

/// One segmentation object.
#[derive(Clone, Debug)]
pub(crate) struct Segmentation {
    pub(crate) class: &'static str,
    /// BINARY; or LABELMAP, whose frames belong to no one segment.
    pub(crate) kind: &'static str,
    /// Segment and slice of each frame, in the order of the file.
    pub(crate) frames: Vec<(u16, usize)>,
    pub(crate) measures: Measures,
    pub(crate) photometric: &'static str,
}

impl Segmentation {
    pub(crate) fn binary(frames: &[(u16, usize)], measures: Measures) -> Self {
        Self {
            class: "1.2.840.10008.5.1.4.1.1.66.4",
            kind: "BINARY",
            frames: frames.to_vec(),
            measures,
            photometric: "MONOCHROME2",
        }
    }

    /// One byte a sample, the labels themselves.
    pub(crate) fn label_map(n_slices: usize) -> Self {
        Self {
            class: "1.2.840.10008.5.1.4.1.1.66.7",
            kind: "LABELMAP",
            frames: (0..n_slices).map(|k| (1, k)).collect(),
            measures: Measures::Shared,
            photometric: "MONOCHROME2",
        }
    }

    /// The samples of a stored frame: a block that tells segments and slices apart.
    pub(crate) fn plane(segment: u16, k: usize) -> Vec<f64> {
        let is_in = |index: usize| {
            let (i, j) = (index % COLS, index / COLS);
            (2..4 + k % 7).contains(&i) && (2..3 + usize::from(segment)).contains(&j)
        };
        (0..COLS * ROWS).map(|index| if is_in(index) { 1.0 } else { 0.0 }).collect()
    }

    /// The bytes of the file.
    pub(crate) fn file(&self) -> Vec<u8> {
        file("1.2.840.10008.1.2.1", &self.data())
    }

    /// The data set.
    pub(crate) fn data(&self) -> Elements {
        let is_binary = self.kind == "BINARY";
        let bits: u16 = if is_binary { 1 } else { 8 };
        let mut data = Elements::default();
        data.text((0x0008, 0x0016), *b"UI", self.class);
        data.text((0x0008, 0x0060), *b"CS", "SEG");
        data.text((0x0020, 0x000E), *b"UI", "1.2.826.0.1.3680043.9.7.66");
        data.text((0x0020, 0x0011), *b"IS", "300");
        data.text((0x0020, 0x0052), *b"UI", "1.2.826.0.1.3680043.9.7.0");
        data.short((0x0028, 0x0002), 1);
        data.text((0x0028, 0x0004), *b"CS", self.photometric);
        data.text((0x0028, 0x0008), *b"IS", &self.frames.len().to_string());
        data.short((0x0028, 0x0010), ROWS as u16);
        data.short((0x0028, 0x0011), COLS as u16);
        data.short((0x0028, 0x0100), bits);
        data.short((0x0028, 0x0101), bits);
        data.short((0x0028, 0x0102), bits - 1);
        data.short((0x0028, 0x0103), 0);
        data.text((0x0062, 0x0001), *b"CS", self.kind);
        let mut orientation = Elements::default();
        orientation.text((0x0020, 0x0037), *b"DS", "1\\0\\0\\0\\1\\0");
        let mut shared = Elements::default();
        shared.sequence((0x0020, 0x9116), &[orientation]);
        if self.measures != Measures::PerFrame {
            shared.sequence((0x0028, 0x9110), &[self.pixel_measures()]);
        }
        data.sequence((0x5200, 0x9229), &[shared]);
        let own: Vec<Elements> = self.frames.iter().map(|&f| self.own(f, is_binary)).collect();
        data.sequence((0x5200, 0x9230), &own);
        data.element((0x7FE0, 0x0010), *b"OB", &self.pixels(is_binary));
        data
    }

    fn own(&self, (segment, k): (u16, usize), is_binary: bool) -> Elements {
        let mut groups = Elements::default();
        let mut position = Elements::default();
        let z = k as f64 * STEP - 30.0;
        position.text((0x0020, 0x0032), *b"DS", &format!("-10\\20\\{z}"));
        groups.sequence((0x0020, 0x9113), &[position]);
        if self.measures == Measures::PerFrame {
            groups.sequence((0x0028, 0x9110), &[self.pixel_measures()]);
        }
        if is_binary {
            let mut of = Elements::default();
            of.short((0x0062, 0x000B), segment);
            groups.sequence((0x0062, 0x000A), &[of]);
        }
        groups
    }

    fn pixel_measures(&self) -> Elements {
        let mut measures = Elements::default();
        match self.measures {
            Measures::Absent => {}
            Measures::Says(mm) => measures.text((0x0018, 0x0088), *b"DS", &mm.to_string()),
            _ => measures.text((0x0018, 0x0088), *b"DS", &STEP.to_string()),
        }
        measures.text((0x0028, 0x0030), *b"DS", "1.4\\0.9");
        measures
    }

    fn pixels(&self, is_binary: bool) -> Vec<u8> {
        let samples: Vec<f64> =
            self.frames.iter().flat_map(|&(segment, k)| Self::plane(segment, k)).collect();
        if !is_binary {
            return samples.iter().map(|&v| v as u8).collect();
        }
        // The first sample in the lowest bit (PS3.5, 8.1.1).
        let byte = |bits: &[f64]| {
            bits.iter().enumerate().map(|(n, &v)| (v as u8) << n).fold(0, |all, bit| all | bit)
        };
        samples.chunks(8).map(byte).collect()
    }
}
