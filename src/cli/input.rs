//! Opens what an input turns out to be: NIfTI, DICOM or raw.

use std::path::Path;

use super::batch::{Found, Scan};
use super::options::Reading;
use crate::cancel::Cancel;
use crate::error::Error;
use crate::source::{self, Content, OpenOptions, RawInput, Volume, dicom};

/// The volume of a scan.
pub(crate) fn open_scan(scan: &Scan, reading: &Reading) -> Result<Volume<'static>, Error> {
    match &scan.volume {
        Found::Stdin => match &reading.raw {
            Some(options) => source::open_raw(RawInput::Stdin, options),
            None => Err(internal("no layout of standard input")),
        },
        Found::File => open_file(&scan.path, reading),
        Found::Series { study, index, is_choice, .. } => {
            open_series(study, *index, reading, *is_choice)
        }
        Found::Broken(_) => Err(internal("a scan that is broken was opened")),
    }
}

/// The volume of a path that is meant.
pub(crate) fn open(
    path: &Path,
    reading: &Reading,
    cancel: &Cancel,
) -> Result<Volume<'static>, Error> {
    if reading.raw.is_some() {
        return open_file(path, reading);
    }
    match source::sniff(path)? {
        Content::Folder | Content::Dicom | Content::Zip => {
            let options = dicom::ScanOptions { cancel: cancel.clone(), progress: None };
            let study = dicom::scan(path, &options)?;
            let index = match &reading.series {
                Some(selector) => study.choose(selector)?,
                None => study.default()?,
            };
            open_series(&study, index, reading, reading.series.is_none())
        }
        _ => open_file(path, reading),
    }
}

fn open_file(path: &Path, reading: &Reading) -> Result<Volume<'static>, Error> {
    match &reading.raw {
        Some(options) => source::open_raw(RawInput::Path(path.to_owned()), options),
        None => source::open(path, &OpenOptions { volume: reading.volume }),
    }
}

/// A volume of a study; with a note on the others where it was taken without being asked for.
fn open_series(
    study: &dicom::Study,
    index: usize,
    reading: &Reading,
    is_choice: bool,
) -> Result<Volume<'static>, Error> {
    let options = dicom::OpenOptions { span_gaps: reading.span_gaps };
    let mut volume = study.open(index, &options)?;
    if is_choice {
        volume.meta.notes.extend(study.choice(index));
    }
    Ok(volume)
}

fn internal(what: &'static str) -> Error {
    Error::new(crate::pipeline::RunError::Internal(what))
}
