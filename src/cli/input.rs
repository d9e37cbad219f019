//! Opens what an input turns out to be: NIfTI, DICOM or raw.

use std::path::Path;

use super::bar::Headers;
use super::job::{Found, Scan};
use super::options::{Input, Reading};
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::Error;
use crate::source::dicom::{DicomError, Selector};
use crate::source::{self, Content, OpenOptions, RawInput, SourceError, Volume, dicom};

/// How inputs are looked into: where progress is shown, what stops it, on how many threads.
#[derive(Clone)]
pub(crate) struct Opening {
    pub(crate) term: Term,
    pub(crate) cancel: Cancel,
    pub(crate) threads: Option<usize>,
}

/// What a DICOM folder, file or archive holds.
pub(crate) fn study(path: &Path, opening: &Opening) -> Result<dicom::Study, Error> {
    let headers = Headers::new(opening.term);
    let progress = |n_files| headers.set(n_files);
    let options = dicom::ScanOptions {
        cancel: opening.cancel.clone(),
        progress: Some(&progress),
        threads: opening.threads,
    };
    dicom::scan(path, &options)
}

/// The volume of a scan.
pub(crate) fn open_scan(
    scan: &Scan,
    reading: &Reading,
    cancel: &Cancel,
) -> Result<Volume<'static>, Error> {
    match &scan.volume {
        Found::Stdin => open_plain(&Input::Stdin, reading, cancel),
        Found::File => open_plain(&Input::Path(scan.path.clone()), reading, cancel),
        Found::Series { study, index, is_choice, .. } => {
            open_series(study, *index, reading, *is_choice)
        }
        Found::Broken(_) => Err(internal("a scan that is broken was opened")),
    }
}

/// The volume that is meant.
pub(crate) fn open(
    input: &Input,
    reading: &Reading,
    opening: &Opening,
) -> Result<Volume<'static>, Error> {
    if let Input::Path(path) = input
        && reading.raw.is_none()
        && matches!(source::sniff(path)?, Content::Folder | Content::Dicom | Content::Zip)
    {
        let study = study(path, opening)?;
        let index = match &reading.series {
            Some(selector) => study.choose(selector)?,
            None => study.default()?,
        };
        return open_series(&study, index, reading, reading.series.is_none());
    }
    open_plain(input, reading, &opening.cancel)
}

/// NIfTI, or raw samples.
fn open_plain(input: &Input, reading: &Reading, cancel: &Cancel) -> Result<Volume<'static>, Error> {
    let raw = match input {
        Input::Path(path) => RawInput::Path(path.clone()),
        Input::Stdin => RawInput::Stdin,
    };
    if let Some(options) = &reading.raw {
        return source::open_raw(raw, options, cancel);
    }
    // Such a file holds no series but itself.
    let is_other = match &reading.series {
        None | Some(Selector::Number(1)) => None,
        Some(Selector::Number(number)) => Some(number.to_string()),
        Some(Selector::Uid(uid)) => Some(uid.clone()),
    };
    if let (Some(asked), Input::Path(path)) = (is_other, input) {
        return Err(Error::at(path, DicomError::NoSuchSeries { asked, of: 1 }));
    }
    match input {
        Input::Path(path) => source::open(path, &OpenOptions { volume: reading.volume }, cancel),
        Input::Stdin => Err(internal("no layout of standard input")),
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
    if let Some(asked) = reading.volume.filter(|&n| n > 1) {
        return Err(Error::new(SourceError::NoSuchVolume { asked, of: 1 }));
    }
    if is_choice {
        volume.meta.notes.extend(study.choice(index));
    }
    Ok(volume)
}

fn internal(what: &'static str) -> Error {
    Error::new(crate::pipeline::RunError::Internal(what))
}
