//! Opens what an input turns out to be: NIfTI, DICOM or raw.

use super::options::{Input, Reading};
use crate::cancel::Cancel;
use crate::error::Error;
use crate::source::{self, Content, OpenOptions, RawInput, Volume, dicom};
use crate::volume::Note;

/// The volume that is meant.
pub(crate) fn open(
    input: &Input,
    reading: &Reading,
    cancel: &Cancel,
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
            let options = dicom::ScanOptions { cancel: cancel.clone(), progress: None };
            let study = dicom::scan(path, &options)?;
            let index = match &reading.series {
                Some(selector) => study.choose(selector)?,
                None => study.default()?,
            };
            let options = dicom::OpenOptions { span_gaps: reading.span_gaps };
            let mut volume = study.open(index, &options)?;
            let others = study.volumes.iter().enumerate().filter(|(i, _)| *i != index);
            let others: Vec<String> = others.map(|(_, v)| v.title()).collect();
            if reading.series.is_none() && !others.is_empty() {
                let chosen =
                    study.volumes.get(index).map(dicom::Candidate::title).unwrap_or_default();
                volume.meta.notes.push(Note::Other(format!(
                    "volume {chosen} is meshed; --series N chooses another: {}",
                    others.join("; ")
                )));
            }
            Ok(volume)
        }
        _ => source::open(path, &OpenOptions { volume: reading.volume }),
    }
}
