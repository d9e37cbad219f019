//! What is known of a volume before any sample is read.

use super::{Note, Rescale, StoredType};
use crate::geom::Grid;

/// Where a volume came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceFormat {
    /// NIfTI-1 or NIfTI-2, one file or a pair.
    Nifti,
    /// Samples without a header.
    Raw,
    /// DICOM images.
    Dicom,
    /// An array in memory, or a formula.
    Memory,
}

impl SourceFormat {
    /// The word in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Nifti => "nifti",
            Self::Raw => "raw",
            Self::Dicom => "dicom",
            Self::Memory => "memory",
        }
    }
}

/// Stored values that stand for "nothing here" (DICOM PS3.3 C.7.5.1.1.2), both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Padding {
    /// The lowest such stored value.
    pub low: f64,
    /// The highest; equal to `low` where a single value is named.
    pub high: f64,
}

impl Padding {
    /// Whether a stored value is one of them.
    pub fn holds(self, stored: f64) -> bool {
        self.low <= stored && stored <= self.high
    }
}

/// What names a DICOM series in reports. Nothing here tells who the patient is.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SeriesFacts {
    /// SeriesInstanceUID.
    pub uid: String,
    /// SeriesNumber, as written.
    pub number: Option<String>,
    /// SeriesDescription.
    pub description: Option<String>,
    /// Images that make up the volume.
    pub n_images: usize,
    /// The angle between the step from slice to slice and the slice normal, in degrees.
    pub tilt_degrees: f64,
    /// TransferSyntaxUID of its images, without doubles.
    pub transfer_syntaxes: Vec<String>,
}

/// The facts about one volume.
#[derive(Clone, Debug)]
pub struct Meta {
    /// Where it came from.
    pub format: SourceFormat,
    /// Dimensions and place, RAS millimetres.
    pub grid: Grid,
    /// The type the file stores. 64-bit integers, slopes that change from plane to plane and
    /// active padding are handed on as `f64`.
    pub stored: StoredType,
    /// From the samples as handed on to real values.
    pub rescale: Rescale,
    /// Samples that are outside whatever their value.
    pub padding: Option<Padding>,
    /// Real values, the least and the greatest, of samples that are padding and are handed on as
    /// NaN, because padding or rescale change from plane to plane. `pad_out` gives them back where
    /// they are outside by their own values.
    pub uneven_padding: Option<Padding>,
    /// DICOM Modality (CT, MR, ...), where known.
    pub modality: Option<String>,
    /// The DICOM series.
    pub series: Option<SeriesFacts>,
    /// Distances between planes along the normal in mm, where they are uneven.
    pub gaps_mm: Option<Vec<f64>>,
    /// Which volume of the file or folder this is, from 1.
    pub volume_number: usize,
    /// How many volumes the file or folder holds.
    pub n_volumes: usize,
    /// A short text from the header, free of patient data.
    pub description: Option<String>,
    /// What was noticed while reading the header.
    pub notes: Vec<Note>,
}

impl Meta {
    /// The angle between the step from plane to plane and the normal of the planes, in degrees.
    pub fn tilt_degrees(&self) -> f64 {
        self.series.as_ref().map_or_else(|| self.grid.affine.tilt_degrees(), |s| s.tilt_degrees)
    }

    /// The facts of a volume that has a grid and a type and nothing else to say.
    pub fn plain(format: SourceFormat, grid: Grid, stored: StoredType) -> Self {
        Self {
            format,
            grid,
            stored,
            rescale: Rescale::IDENTITY,
            padding: None,
            uneven_padding: None,
            modality: None,
            series: None,
            gaps_mm: None,
            volume_number: 1,
            n_volumes: 1,
            description: None,
            notes: Vec::new(),
        }
    }
}
