//! NIfTI files, against what nibabel sees.
