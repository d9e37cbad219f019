//! The two files of a pair: which name goes with which.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::NiftiError;

/// Which file of a pair a name says it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::source) enum Part {
    Header,
    Image,
}

impl Part {
    fn extension(self) -> &'static str {
        match self {
            Self::Header => "hdr",
            Self::Image => "img",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Header => "header (.hdr)",
            Self::Image => "image (.img)",
        }
    }
}

/// Splits `stem.img.gz` and its like: the stem, and which part of a pair the rest names.
fn split(path: &Path) -> (PathBuf, Option<Part>) {
    let is = |p: &Path, want: &str| p.extension().is_some_and(|e| e.eq_ignore_ascii_case(want));
    let plain = if is(path, "gz") { path.with_extension("") } else { path.to_owned() };
    let part = [Part::Header, Part::Image].into_iter().find(|p| is(&plain, p.extension()));
    let stem = if part.is_some() || is(&plain, "nii") { plain.with_extension("") } else { plain };
    (stem, part)
}

/// Which part of a pair the name of a file says that it is.
pub(in crate::source) fn part_by_name(path: &Path) -> Option<Part> {
    split(path).1
}

/// The other file of a pair: the same stem, in either case, gzipped or not.
pub(in crate::source) fn partner(path: &Path, wanted: Part) -> Result<PathBuf, NiftiError> {
    let (stem, _) = split(path);
    let lower = wanted.extension();
    let upper = lower.to_ascii_uppercase();
    let names_upper = path
        .extension()
        .and_then(OsStr::to_str)
        .is_some_and(|e| e.bytes().all(|b| b.is_ascii_uppercase()));
    let (first, second) =
        if names_upper { (upper.as_str(), lower) } else { (lower, upper.as_str()) };
    let mut tries = Vec::new();
    for extension in [first, second] {
        for gz in ["", ".gz", ".GZ"] {
            let mut name = OsString::from(stem.as_os_str());
            name.push(".");
            name.push(extension);
            name.push(gz);
            tries.push(PathBuf::from(name));
        }
    }
    let found = tries.iter().find(|p| p.exists()).cloned();
    found.ok_or_else(|| NiftiError::NoPartner {
        what: wanted.words(),
        wanted: tries.into_iter().next().unwrap_or_default(),
    })
}
