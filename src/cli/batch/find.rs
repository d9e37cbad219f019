//! From the inputs as typed to the volumes that are meant. Reads headers of DICOM and the first
//! bytes of other files; no samples.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::board::Board;
use crate::cancel::Cancel;
use crate::cli::job::{Found, Scan};
use crate::cli::options::Run;
use crate::cli::output::is_dash;
use crate::cli::trouble::Trouble;
use crate::error::{Error, Kind};
use crate::source::dicom::{self, Study};
use crate::source::{self, Content, SourceError};

/// What the inputs hold.
#[derive(Default)]
pub(super) struct All {
    pub(super) scans: Vec<Scan>,
    /// Files below folders that are no volume and do not claim to be one.
    pub(super) passed_over: usize,
}

/// All volumes that are meant, in the order of the inputs.
///
/// # Errors
/// A stop that was asked for; nothing at all to be meshed.
pub(super) fn find(run: &Run, board: &Board, cancel: &Cancel) -> Result<All, Trouble> {
    let mut all = All::default();
    let finder = Finder { run, board, cancel };
    for input in &run.inputs {
        let found = if run.recursive && input.is_dir() {
            finder.below(input, &mut all)
        } else {
            finder.one(input, &mut all)
        };
        if let Err(error) = found {
            if error.kind() == Kind::Interrupted {
                return Err(error.into());
            }
            all.broken(input.clone(), error);
        }
    }
    board.clear();
    Ok(all)
}

impl All {
    fn broken(&mut self, path: PathBuf, error: Error) {
        let volume = Found::Broken(error.into());
        self.scans.push(Scan { path, volume, parent: None });
    }
}

struct Finder<'a> {
    run: &'a Run,
    board: &'a Board,
    cancel: &'a Cancel,
}

impl Finder<'_> {
    /// One input that was typed.
    fn one(&self, path: &Path, all: &mut All) -> Result<(), Error> {
        let plain = |volume| Scan { path: path.to_owned(), volume, parent: None };
        let reading = &self.run.extract.reading;
        if is_dash(path) {
            all.scans.push(plain(Found::Stdin));
        } else if reading.raw.is_none() && is_study(path)? {
            let study = self.scan(path, |options| dicom::scan(path, options))?;
            if reading.all_series {
                add_study(study, path, reading.span_gaps, all);
                return Ok(());
            }
            let index = match &reading.series {
                Some(selector) => study.choose(selector)?,
                None => study.default()?,
            };
            let (study, is_choice) = (Arc::new(study), reading.series.is_none());
            all.scans.push(plain(Found::Series { study, index, among: false, is_choice }));
        } else {
            all.scans.push(plain(Found::File));
        }
        Ok(())
    }

    /// Everything below a folder.
    fn below(&self, folder: &Path, all: &mut All) -> Result<(), Error> {
        let tree = self.scan(folder, |options| dicom::scan_tree(folder, options))?;
        let span_gaps = self.run.extract.reading.span_gaps;
        let (before, passed_over) = (all.scans.len(), all.passed_over);
        for study in tree.studies {
            add_study(study, folder, span_gaps, all);
        }
        for error in tree.unreadable {
            all.broken(error.path().unwrap_or(folder).to_owned(), error);
        }
        for path in &tree.foreign {
            if self.cancel.is_raised() {
                return Err(interrupted(folder));
            }
            if let Err(error) = self.foreign(path, folder, &tree.foreign, all) {
                all.broken(path.clone(), error);
            }
        }
        if all.scans.len() == before {
            return Err(nothing_below(folder, all.passed_over - passed_over));
        }
        Ok(())
    }

    /// A file below a folder that is no DICOM by itself.
    fn foreign(
        &self,
        path: &Path,
        base: &Path,
        beside: &[PathBuf],
        all: &mut All,
    ) -> Result<(), Error> {
        let file = || Scan {
            path: path.to_owned(),
            volume: Found::File,
            parent: Some(parent_below(base, path)),
        };
        if is_shadow(path) {
            all.passed_over += 1;
            return Ok(());
        }
        let claim = Claim::of(path);
        if self.run.extract.reading.raw.is_some() {
            match claim {
                Claim::Raw => all.scans.push(file()),
                _ => all.passed_over += 1,
            }
            return Ok(());
        }
        match source::sniff(path) {
            Ok(Content::Nifti) => {
                // A pair is one volume, named by its header.
                let parts = source::files(path);
                let is_image = claim == Claim::Image;
                if !(is_image && parts.iter().skip(1).any(|header| beside.contains(header))) {
                    all.scans.push(file());
                }
            }
            Ok(Content::Zip) => match self.scan(path, |options| dicom::scan(path, options)) {
                Ok(study) => {
                    add_study(study, base, self.run.extract.reading.span_gaps, all);
                }
                Err(e) if e.kind() == Kind::NoSeries => all.passed_over += 1,
                Err(e) => return Err(e),
            },
            Ok(_) if claim == Claim::Dicom => {
                self.scan(path, |options| dicom::scan(path, options))?;
            }
            // It fails when it is opened, and says why.
            Ok(_) | Err(_) if claim.is_volume() => all.scans.push(file()),
            Err(e) if e.kind() == Kind::Unreadable => return Err(e),
            Ok(_) | Err(_) => all.passed_over += 1,
        }
        Ok(())
    }

    fn scan<T>(
        &self,
        path: &Path,
        scan: impl FnOnce(&dicom::ScanOptions<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let progress = |done| self.board.looked_at(path, done);
        let options = dicom::ScanOptions {
            cancel: self.cancel.clone(),
            progress: Some(&progress),
            threads: Some(self.run.threads),
        };
        scan(&options)
    }
}

/// Every volume of a study that should be meshed, and every file of it that should have been;
/// `base` is what the output's tree begins below.
fn add_study(study: Study, base: &Path, span_gaps: bool, all: &mut All) {
    let root = study.root().to_owned();
    for error in study.stray_faults() {
        all.broken(error.path().unwrap_or(&root).to_owned(), error);
    }
    all.passed_over += study.set_aside.iter().map(|a| a.count).sum::<usize>();
    let options = dicom::OpenOptions { span_gaps };
    let mut fit = Vec::new();
    for index in study.all() {
        match study.refusal(index, &options) {
            Some(error) => all.broken(root.clone(), error),
            // A volume that is one file is named like other files, any other like its folder.
            None => match <[PathBuf; 1]>::try_from(study.files(index)) {
                Ok([file]) => fit.push((index, file)),
                Err(_) => fit.push((index, root.clone())),
            },
        }
    }
    let study = Arc::new(study);
    for (index, path) in &fit {
        let among = fit.iter().filter(|(_, other)| other == path).count() > 1;
        all.scans.push(Scan {
            path: path.clone(),
            volume: Found::Series {
                study: Arc::clone(&study),
                index: *index,
                among,
                is_choice: false,
            },
            parent: Some(parent_below(base, path)),
        });
    }
}

/// Whether a file, or the header of the pair whose image it is called, is what macOS leaves beside
/// another on foreign file systems: under its name with `._` before it, in `AppleDouble`.
fn is_shadow(path: &Path) -> bool {
    let is_named_so = path.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(b"._"));
    let is_double =
        |path: &PathBuf| matches!(source::sniff(path), Ok(Content::Foreign("AppleDouble")));
    is_named_so && source::files(path).iter().any(is_double)
}

fn is_study(path: &Path) -> Result<bool, Error> {
    Ok(matches!(source::sniff(path)?, Content::Folder | Content::Dicom | Content::Zip))
}

/// The folder of a path, seen from the input folder.
fn parent_below(folder: &Path, path: &Path) -> PathBuf {
    let inner = path.strip_prefix(folder).unwrap_or(path);
    inner.parent().unwrap_or(Path::new("")).to_owned()
}

fn nothing_below(folder: &Path, n_files: usize) -> Error {
    let error = SourceError::Other {
        kind: Kind::NoSeries,
        message: format!("none of the {n_files} files below this folder is a volume"),
        hint: Some("raw samples are told by --dims and named .raw or .raw.gz".to_owned()),
    };
    Error::at(folder, error)
}

fn interrupted(path: &Path) -> Error {
    Error::at(path, crate::pipeline::RunError::Interrupted)
}

/// What a file says by its name that it is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Claim {
    Volume,
    Image,
    Dicom,
    Raw,
    Nothing,
}

impl Claim {
    fn of(path: &Path) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let plain = name.strip_suffix(".gz").unwrap_or(&name);
        match plain.rsplit_once('.').map(|(_, extension)| extension) {
            Some("nii" | "hdr") => Self::Volume,
            Some("dcm" | "dicom") => Self::Dicom,
            Some("img") => Self::Image,
            Some("raw") => Self::Raw,
            _ => Self::Nothing,
        }
    }

    fn is_volume(self) -> bool {
        matches!(self, Self::Volume | Self::Image)
    }
}
