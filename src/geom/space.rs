//! The coordinates a mesh is written in.

/// Axes and units of output coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Space {
    /// Right, anterior, superior; millimetres (NIfTI, nibabel).
    #[default]
    Ras,
    /// Left, posterior, superior; millimetres (DICOM, ITK).
    Lps,
    /// Voxel indices (i, j, k).
    Voxel,
}

impl Space {
    /// The word on the command line and in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Ras => "ras",
            Self::Lps => "lps",
            Self::Voxel => "voxel",
        }
    }

    /// What a mesh file's header or comment says, in the form 3D Slicer reads; nothing for voxels.
    pub fn tag(self) -> Option<&'static str> {
        match self {
            Self::Ras => Some("SPACE=RAS"),
            Self::Lps => Some("SPACE=LPS"),
            Self::Voxel => None,
        }
    }
}
