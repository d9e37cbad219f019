//! One file: what it says of itself, of its pixels and of each of its frames.

use std::sync::Arc;

use super::blob::Blob;
use super::error::FileFault;
use super::groups;
use super::guard::contain;
use super::header::{self, Item, bad};
use super::layout::Layout;
use super::set_aside::{self, What};
use super::tags;
use super::walk::{PixelElement, Walked, walk};
use crate::geom::vec3::Vec3;
use crate::volume::Padding;

/// What one file turned out to be.
pub(super) enum Scanned {
    /// No DICOM.
    Foreign,
    /// DICOM, but no slice: a report, a localizer, a colour picture.
    Aside { what: What, series: Option<String> },
    /// DICOM that cannot be used.
    Broken { series_uid: Option<String>, fault: FileFault },
    /// An image.
    Image(Box<Instance>),
}

/// An image file.
pub(super) struct Instance {
    /// Relative to the input, for messages.
    pub(super) name: String,
    pub(super) blob: Arc<Blob>,
    pub(super) syntax: String,
    pub(super) element: PixelElement,
    pub(super) deflated_at: Option<u64>,
    pub(super) layout: Layout,
    pub(super) n_frames: u64,
    pub(super) study_uid: Option<String>,
    /// Empty where there is none.
    pub(super) series_uid: String,
    pub(super) series_number: Option<String>,
    pub(super) description: Option<String>,
    pub(super) modality: Option<String>,
    pub(super) frame_of_reference: Option<String>,
    pub(super) is_segmentation: bool,
    pub(super) is_mosaic: bool,
    pub(super) has_modality_lut: bool,
    /// InstanceNumber; 0 where there is none.
    pub(super) number: i64,
    /// Stored values that stand for nothing, both ends included.
    pub(super) padding: Option<Padding>,
    /// What is odd about it and of no harm, for notes.
    pub(super) odd: Vec<&'static str>,
    /// What is wrong with the pixels, seen without reading them.
    pub(super) fault: Option<FileFault>,
    pub(super) frames: Vec<Frame>,
}

impl Instance {
    /// Whether it is a secondary capture: a slice where a folder holds nothing better.
    pub(super) fn is_capture(&self) -> bool {
        self.odd.contains(&CAPTURE)
    }
}

/// One frame: its place and its rescale.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// Within its file, from 0.
    pub(super) index: u64,
    /// ImagePositionPatient, LPS mm.
    pub(super) position: Option<Vec3>,
    /// Why there is no position, where it is not that ImagePositionPatient is absent.
    pub(super) unplaced: Option<&'static str>,
    /// ImageOrientationPatient.
    pub(super) orientation: Option<[f64; 6]>,
    /// PixelSpacing: between rows, between columns, mm.
    pub(super) spacing: Option<[f64; 2]>,
    /// SpacingBetweenSlices, mm.
    pub(super) slice_spacing: Option<f64>,
    pub(super) slope: f64,
    pub(super) inter: f64,
    /// The number of the segment that a frame of a segmentation belongs to.
    pub(super) segment: Option<u32>,
    /// What always separates volumes: stack, segment, energy window, time slot.
    pub(super) apart: String,
    /// What separates volumes where a series mixes them, by [`SPLITTERS`].
    pub(super) mixed: [Option<String>; SPLITTERS.len()],
    /// `DimensionIndexValues`. Which of them counts positions need not be known: it tells no frames
    /// at one position apart.
    pub(super) dimensions: Vec<String>,
}

impl Frame {
    /// Bytes of text that it holds.
    pub(super) fn text_bytes(&self) -> u64 {
        let mixed: usize = self.mixed.iter().flatten().map(String::capacity).sum();
        let dimensions: usize =
            self.dimensions.iter().map(|text| size_of::<String>() + text.capacity()).sum();
        (self.apart.capacity() + mixed + dimensions) as u64
    }
}

/// A frame's name: the file's, with the frame's number from 1 where the file has several.
pub(super) fn frame_name((instance, frame): (&Instance, &Frame)) -> String {
    if instance.n_frames > 1 {
        format!("{} frame {}", instance.name, frame.index + 1).trim_start().to_owned()
    } else {
        instance.name.clone()
    }
}

/// What a series may mix under one UID, in the order in which a split is tried.
pub(super) const SPLITTERS: [&str; 14] = [
    "echo time",
    "echo number",
    "temporal position",
    "b-value",
    "image type",
    "trigger time",
    "acquisition number",
    "inversion time",
    "tube voltage",
    "kernel",
    "flip angle",
    "gradient direction",
    "time offset",
    "time",
];

/// The splitters that are set for whole volumes: no volume has them change from slice to slice and
/// back.
pub(super) const SETTINGS: [&str; 5] =
    ["echo time", "echo number", "temporal position", "b-value", "kernel"];

/// The splitter that numbers echoes.
pub(super) const ECHO_NUMBER: usize = 1;

/// The splitter whose values are not all as good as each other.
pub(super) const IMAGE_TYPE: usize = 4;

/// The splitter that is a time of day.
pub(super) const CLOCK: usize = SPLITTERS.len() - 1;

/// Said of captures that are meshed.
const CAPTURE: &str = "secondary captures, taken for slices: each says where it lies";

/// Reads one file's header.
pub(super) fn scan_file(blob: Blob, name: String) -> Scanned {
    let walked = match blob.with_stream(walk) {
        Ok(walked) => walked,
        Err(FileFault::NotDicom) => return Scanned::Foreign,
        Err(fault) => return Scanned::Broken { series_uid: None, fault },
    };
    let header = match header::parse(&walked) {
        Ok(header) => header,
        Err(fault) => return Scanned::Broken { series_uid: None, fault },
    };
    let series_uid = header::text(&header, tags::SERIES_INSTANCE_UID);
    let read = contain(|| read(blob, name, &walked, &header)).unwrap_or_else(|| {
        let what = "its values do not parse";
        Err(FileFault::BadElement { tag: tags::SPECIFIC_CHARACTER_SET, what })
    });
    read.unwrap_or_else(|fault| Scanned::Broken { series_uid, fault })
}

fn read(blob: Blob, name: String, walked: &Walked, header: &Item) -> Result<Scanned, FileFault> {
    let class = header::text(header, tags::SOP_CLASS_UID);
    let is_directory = walked.media_class.as_deref() == Some(set_aside::DIRECTORY_CLASS);
    if is_directory {
        return Ok(Scanned::Aside { what: What::Directory, series: None });
    }
    if walked.kept.is_empty() {
        return Ok(match walked.media_class {
            Some(_) => Scanned::Aside { what: What::NoPixels, series: None },
            None => Scanned::Broken {
                series_uid: None,
                fault: FileFault::Missing { attribute: "the data set" },
            },
        });
    }
    let series = header::label(header, tags::SERIES_NUMBER);
    let image_type = header::texts(header, tags::IMAGE_TYPE);
    let Some(element) = walked.pixels else {
        let has_rows = header::text(header, tags::ROWS).is_some();
        if set_aside::lacks_pixels(class.as_deref(), has_rows) {
            return Err(FileFault::Missing { attribute: "PixelData" });
        }
        let what = set_aside::without_pixels(class.as_deref());
        return Ok(Scanned::Aside { what, series });
    };
    let photometric = header::text(header, tags::PHOTOMETRIC_INTERPRETATION);
    let samples = header::integer(header, tags::SAMPLES_PER_PIXEL, "SamplesPerPixel")?;
    let mut is_capture = false;
    if let Some(what) =
        set_aside::with_pixels(class.as_deref(), &image_type, samples, photometric.as_deref())
    {
        if what != What::SecondaryCapture || !groups::is_placed(header) {
            return Ok(Scanned::Aside { what, series });
        }
        is_capture = true;
    }
    let layout = Layout::read(header, walked, &element)?;
    let n_frames = match header::integer(header, tags::NUMBER_OF_FRAMES, "NumberOfFrames")? {
        // Single images of some writers say that they have none.
        None | Some(0) => 1,
        Some(n @ 1..) => n as u64,
        Some(n) => return Err(bad("NumberOfFrames", &n.to_string(), "at least 1")),
    };
    let fault = pixel_fault(&blob, &layout, walked, &element, n_frames)?;
    let modality = header::label(header, tags::MODALITY);
    let is_segmentation = set_aside::is_segmentation(class.as_deref(), modality.as_deref());
    let padding = padding(header, &layout)?;
    let frames = groups::frames(header, n_frames, &image_type, is_segmentation)?;
    Ok(Scanned::Image(Box::new(Instance {
        name,
        blob: Arc::new(blob),
        syntax: walked.syntax.clone(),
        element,
        deflated_at: walked.deflated_at,
        layout,
        n_frames,
        study_uid: header::text(header, tags::STUDY_INSTANCE_UID),
        series_uid: header::text(header, tags::SERIES_INSTANCE_UID).unwrap_or_default(),
        series_number: series,
        description: header::label(header, tags::SERIES_DESCRIPTION),
        modality,
        frame_of_reference: header::text(header, tags::FRAME_OF_REFERENCE_UID),
        is_segmentation,
        is_mosaic: image_type.iter().any(|t| t == "MOSAIC"),
        has_modality_lut: !header::items(header, tags::MODALITY_LUT_SEQUENCE).is_empty(),
        number: header::integer(header, tags::INSTANCE_NUMBER, "InstanceNumber")
            .ok()
            .flatten()
            .unwrap_or(0),
        padding,
        odd: if is_capture { vec![CAPTURE] } else { Vec::new() },
        fault,
        frames,
    })))
}

/// Compares what the pixels need with what there is. An error where the frames cannot even be
/// listed.
fn pixel_fault(
    blob: &Blob,
    layout: &Layout,
    walked: &Walked,
    element: &PixelElement,
    n_frames: u64,
) -> Result<Option<FileFault>, FileFault> {
    let encapsulated = super::syntax::is_encapsulated(&walked.syntax);
    let wanted = layout.native_bytes(n_frames).unwrap_or(u64::MAX);
    match (encapsulated, element.length) {
        (true, _) if super::syntax::codec(&walked.syntax).is_none() => {
            Ok(super::syntax::refuse(&walked.syntax, layout))
        }
        (false, Some(length)) => {
            let fault = match element.left {
                Some(left) if left < length => {
                    FileFault::LengthBeyond { tag: element.tag, length, left }
                }
                _ if length < wanted => FileFault::PixelsEnd { found: length, wanted },
                _ => return Ok(None),
            };
            // One image cut short still says where in the volume it is missing. Of a file of
            // several frames their number is not believed either.
            if n_frames == 1 { Ok(Some(fault)) } else { Err(fault) }
        }
        (false, None) => {
            let what = "pixel data of undefined length in an uncompressed transfer syntax";
            Err(FileFault::BadElement { tag: element.tag, what })
        }
        (true, Some(_)) => {
            let what = "pixel data of defined length in a compressed transfer syntax";
            Err(FileFault::BadElement { tag: element.tag, what })
        }
        (true, None) => {
            // Each frame has at least one fragment, and a fragment at least eight bytes.
            let most = blob.len().saturating_sub(element.offset) / 8;
            if n_frames > most {
                let (frame, fragments) = (most + 1, most);
                return Err(FileFault::NoFrame { frame, fragments, frames: n_frames });
            }
            Ok(super::syntax::refuse(&walked.syntax, layout))
        }
    }
}

/// PixelPaddingValue to PixelPaddingRangeLimit, as stored values of the image's own sign; of
/// floats those of their own size.
fn padding(header: &Item, layout: &Layout) -> Result<Option<Padding>, FileFault> {
    use super::layout::SampleKind;
    let ends = match (layout.kind, layout.bytes) {
        (SampleKind::Float, 4) => {
            let read = |tag| header::float(header, tag).map(|v| f64::from(v as f32));
            (read(tags::FLOAT_PADDING_VALUE), read(tags::FLOAT_PADDING_RANGE_LIMIT))
        }
        (SampleKind::Float, _) => {
            let read = |tag| header::float(header, tag);
            (read(tags::DOUBLE_FLOAT_PADDING_VALUE), read(tags::DOUBLE_FLOAT_PADDING_RANGE_LIMIT))
        }
        (kind, bytes) => {
            let read = |tag, attribute| {
                let value = header::integer(header, tag, attribute)?;
                Ok::<_, FileFault>(value.map(|v| match (kind, bytes) {
                    (SampleKind::Signed, 1) => f64::from(v as i8),
                    (SampleKind::Signed, 2) => f64::from(v as i16),
                    (SampleKind::Unsigned, 1 | 2) => f64::from(v as u16),
                    _ => v as f64,
                }))
            };
            (
                read(tags::PIXEL_PADDING_VALUE, "PixelPaddingValue")?,
                read(tags::PIXEL_PADDING_RANGE_LIMIT, "PixelPaddingRangeLimit")?,
            )
        }
    };
    let (Some(value), limit) = ends else { return Ok(None) };
    let limit = limit.unwrap_or(value);
    Ok(Some(Padding { low: value.min(limit), high: value.max(limit) }))
}
