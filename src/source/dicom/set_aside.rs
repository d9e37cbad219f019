//! DICOM that is no slice of a volume, by name.

/// MediaStorageSOPClassUID of a DICOMDIR.
pub(super) const DIRECTORY_CLASS: &str = "1.2.840.10008.1.3.10";

/// SOPClassUID of segmentations and of label maps.
const SEGMENTATION_CLASSES: [&str; 2] = ["1.2.840.10008.5.1.4.1.1.66.4", LABEL_MAP_CLASS];

/// SOPClassUID of label maps.
const LABEL_MAP_CLASS: &str = "1.2.840.10008.5.1.4.1.1.66.7";

/// SOPClassUID of MR spectroscopy, which has rows and columns of spectra and no pixels.
const SPECTROSCOPY_CLASS: &str = "1.2.840.10008.5.1.4.1.1.4.2";

/// What a file is that is no slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum What {
    /// A localizer, scout or topogram.
    Localizer,
    /// A secondary capture.
    SecondaryCapture,
    /// A picture in colour.
    Colour,
    /// A structured report or an encapsulated document.
    Report,
    /// A radiotherapy object.
    Radiotherapy,
    /// A presentation state.
    Presentation,
    /// A DICOMDIR.
    Directory,
    /// Spectra (MR spectroscopy).
    Spectroscopy,
    /// Something else without pixels.
    NoPixels,
    /// A file that is no DICOM.
    Foreign,
}

impl What {
    /// Its name, in the singular or plural that `count` asks for.
    pub fn name(self, count: usize) -> &'static str {
        let one = count == 1;
        match self {
            Self::Localizer if one => "localizer",
            Self::Localizer => "localizers",
            Self::SecondaryCapture if one => "secondary capture",
            Self::SecondaryCapture => "secondary captures",
            Self::Colour if one => "colour picture",
            Self::Colour => "colour pictures",
            Self::Report if one => "report",
            Self::Report => "reports",
            Self::Radiotherapy if one => "radiotherapy object",
            Self::Radiotherapy => "radiotherapy objects",
            Self::Presentation if one => "presentation state",
            Self::Presentation => "presentation states",
            Self::Directory if one => "DICOMDIR",
            Self::Directory => "DICOMDIRs",
            Self::Spectroscopy if one => "spectroscopy object",
            Self::Spectroscopy => "spectroscopy objects",
            Self::NoPixels if one => "object without pixels",
            Self::NoPixels => "objects without pixels",
            Self::Foreign if one => "file that is no DICOM",
            Self::Foreign => "files that are no DICOM",
        }
    }
}

/// Files of one kind that were set aside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetAside {
    /// What they are.
    pub what: What,
    /// SeriesNumber, where there is one.
    pub series_number: Option<String>,
    /// How many.
    pub count: usize,
    /// The first of them, relative to the input.
    pub first: String,
}

/// Whether an object's samples say what belongs to a segment, not what was measured.
pub(super) fn is_segmentation(class: Option<&str>, modality: Option<&str>) -> bool {
    class.is_some_and(|c| SEGMENTATION_CLASSES.contains(&c)) || modality == Some("SEG")
}

/// Whether an object without pixels should have them, having rows.
pub(super) fn lacks_pixels(class: Option<&str>, has_rows: bool) -> bool {
    has_rows && class != Some(SPECTROSCOPY_CLASS)
}

/// What an object without pixels is, by its SOP class.
pub(super) fn without_pixels(class: Option<&str>) -> What {
    let Some(storage) = class.and_then(|c| c.strip_prefix("1.2.840.10008.5.1.4.1.1.")) else {
        return What::NoPixels;
    };
    match storage.split('.').next() {
        Some("88" | "104") => What::Report,
        Some("481") => What::Radiotherapy,
        Some("11") => What::Presentation,
        _ if class == Some(SPECTROSCOPY_CLASS) => What::Spectroscopy,
        _ => What::NoPixels,
    }
}

/// Why an object with pixels is no slice, if so.
pub(super) fn with_pixels(
    class: Option<&str>,
    image_type: &[String],
    samples: Option<i64>,
    photometric: Option<&str>,
) -> Option<What> {
    let storage = class.and_then(|c| c.strip_prefix("1.2.840.10008.5.1.4.1.1.")).unwrap_or("");
    if storage.starts_with("481.") {
        return Some(What::Radiotherapy);
    }
    // The palette of a label map says how labels are shown, and its samples are the labels.
    let grey = match photometric {
        None | Some("MONOCHROME1" | "MONOCHROME2") => true,
        Some("PALETTE COLOR") => class == Some(LABEL_MAP_CLASS),
        Some(_) => false,
    };
    if samples.is_some_and(|n| n != 1) || !grey {
        return Some(What::Colour);
    }
    if storage == "7" || storage.starts_with("7.") {
        return Some(What::SecondaryCapture);
    }
    let localizer = |t: &String| matches!(t.as_str(), "LOCALIZER" | "SCOUT" | "TOPOGRAM");
    image_type.iter().any(localizer).then_some(What::Localizer)
}
