//! What the integration tests share.

pub mod expected;
pub mod planes;
pub mod random;

pub(crate) mod codestreams;
pub(crate) mod dicom;
pub(crate) mod ljpeg;
pub mod manifold;
#[cfg(target_os = "linux")]
pub(crate) mod memory;
pub(crate) mod nifti;
pub(crate) mod one_slab;
pub mod oracle;
pub mod sandbox;
pub(crate) mod segments;

use std::path::{Path, PathBuf};

/// A file or folder of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The folder that `MCUBES_SCANS` names: the whole collection of scans, of which `testdata` has the
/// small ones. Tests that need it are ignored unless they are asked for.
pub fn scans() -> PathBuf {
    named_scans().expect("MCUBES_SCANS names the folder of the whole collection of scans")
}

/// The same, for tests that run on `testdata` and on more where there is more.
pub fn named_scans() -> Option<PathBuf> {
    std::env::var_os("MCUBES_SCANS").map(PathBuf::from)
}
