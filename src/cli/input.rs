//! Opens what an input turns out to be: NIfTI, DICOM or raw.

use std::path::Path;

use super::bar::Headers;
use super::options::{Input, Reading};
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::Error;
use crate::source::{self, Content, OpenOptions, RawInput, Volume, dicom};

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

/// The volume that is meant.
pub(crate) fn open(
    input: &Input,
    reading: &Reading,
    opening: &Opening,
) -> Result<Volume<'static>, Error> {
    let raw = match input {
        Input::Path(path) => RawInput::Path(path.clone()),
        Input::Stdin => RawInput::Stdin,
    };
    if let Some(options) = &reading.raw {
        return source::open_raw(raw, options);
    }
    let Input::Path(path) = input else {
        return Err(Error::new(crate::pipeline::RunError::Internal("no layout of standard input")));
    };
    match source::sniff(path)? {
        Content::Folder | Content::Dicom | Content::Zip => {
            let study = study(path, opening)?;
            let index = match &reading.series {
                Some(selector) => study.choose(selector)?,
                None => study.default()?,
            };
            let options = dicom::OpenOptions { span_gaps: reading.span_gaps };
            let mut volume = study.open(index, &options)?;
            if reading.series.is_none() {
                volume.meta.notes.extend(study.choice(index));
            }
            Ok(volume)
        }
        _ => source::open(path, &OpenOptions { volume: reading.volume }),
    }
}
