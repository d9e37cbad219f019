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

/// The other file of a pair: the same stem, in either case, gzipped or not; what is named most like
/// `path` comes first.
pub(in crate::source) fn partner(path: &Path, wanted: Part) -> Result<PathBuf, NiftiError> {
    let (stem, _) = split(path);
    let extension = |p: &Path| p.extension().and_then(OsStr::to_str).map(str::to_owned);
    let last = extension(path).unwrap_or_default();
    let (own, gz) = if last.eq_ignore_ascii_case("gz") {
        (extension(&path.with_extension("")).unwrap_or_default(), format!(".{last}"))
    } else {
        (last, String::new())
    };
    let lower = wanted.extension().to_owned();
    let upper = lower.to_ascii_uppercase();
    let is_upper = !own.is_empty() && own.bytes().all(|b| b.is_ascii_uppercase());
    let mut tries = Vec::new();
    for extension in if is_upper { [upper, lower] } else { [lower, upper] } {
        for gz in [gz.as_str(), "", ".gz", ".GZ"] {
            let mut name = OsString::from(stem.as_os_str());
            name.push(format!(".{extension}{gz}"));
            tries.push(PathBuf::from(name));
        }
    }
    let found = tries.iter().find(|p| p.exists()).cloned();
    found.ok_or_else(|| NiftiError::NoPartner {
        what: wanted.words(),
        wanted: tries.into_iter().next().unwrap_or_default(),
    })
}
