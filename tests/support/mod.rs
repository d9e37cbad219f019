//! What the integration tests share.
#![allow(dead_code, unreachable_pub, reason = "not every module uses every helper yet")]

pub mod expected;
pub mod planes;
pub mod random;

pub(crate) mod dicom;
pub(crate) mod ljpeg;
pub mod manifold;
pub(crate) mod memory;
pub mod oracle;
pub mod sandbox;
pub(crate) mod segments;

use std::path::{Path, PathBuf};

/// A file or folder of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A file or folder of the large test data beside the repository, or nothing, said aloud, where
/// they are not present.
pub fn shared(path: &str) -> Option<PathBuf> {
    let found = repository("../shared/data").join(path);
    if found.exists() {
        Some(found)
    } else {
        eprintln!("skipped: ../shared/data/{path} is not here");
        None
    }
}
