//! Every volume of a study: which are to be meshed where all are, what stands in the way of the
//! others, the files of each, and the patient where a file name is to tell.

use std::path::{Path, PathBuf};

use super::candidate::Candidate;
use super::error::{DicomError, FileFault, Tag};
use super::header;
use super::study::{Fault, OpenOptions, Study};
use super::tags;
use super::walk::walk_keeping;
use crate::error::Error;

/// A fault that stands for those of a whole series, and how many more there are.
pub(super) type Stray = (String, FileFault, usize);

/// What tells who the patient is. Read only when asked for here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatientField {
    /// `PatientID`.
    Id,
    /// `PatientName`.
    Name,
}

impl PatientField {
    fn tag(self) -> Tag {
        match self {
            Self::Id => tags::PATIENT_ID,
            Self::Name => tags::PATIENT_NAME,
        }
    }
}

impl Study {
    /// The volumes that are meshed where all are asked for: those with slices in space, fit or not;
    /// segmentations only where there is nothing else; where nothing has slices in space all that
    /// there is. Indices into `volumes`.
    pub fn all(&self) -> Vec<usize> {
        let plausible = || self.volumes.iter().enumerate().filter(|(_, v)| v.is_plausible());
        let images: Vec<usize> =
            plausible().filter(|(_, v)| !v.is_segmentation).map(|(i, _)| i).collect();
        if !images.is_empty() {
            return images;
        }
        let segmentations: Vec<usize> = plausible().map(|(i, _)| i).collect();
        if segmentations.is_empty() { (0..self.volumes.len()).collect() } else { segmentations }
    }

    /// The errors of files that cannot be used and that no volume here speaks of: one a series, at
    /// the path of its first file.
    pub fn stray_faults(&self) -> Vec<Error> {
        let at = |name: &str| {
            if self.root.is_dir() { self.root.join(name) } else { self.root.clone() }
        };
        self.strays
            .iter()
            .map(|(name, fault, more)| match more {
                0 => Error::at(at(name), fault.clone()),
                _ => self.file_error(name, fault, *more),
            })
            .collect()
    }

    /// Why a volume would not be opened.
    pub fn refusal(&self, index: usize, options: &OpenOptions) -> Option<Error> {
        let problem = self.volumes.get(index)?.obstacle(options.span_gaps)?;
        Some(self.error(problem.clone()))
    }

    /// The folder, file or archive that was scanned.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The plain files that a volume is read from, in order and without doubles; the archive where
    /// it lies in one.
    pub fn files(&self, index: usize) -> Vec<PathBuf> {
        let frames = self.volumes.get(index).map(|v| v.frames.as_slice()).unwrap_or_default();
        let mut files: Vec<PathBuf> = frames
            .iter()
            .filter_map(|r| r.get(&self.instances))
            .map(|(instance, _)| instance.blob.path().unwrap_or(&self.root).to_owned())
            .collect();
        files.sort();
        files.dedup();
        files
    }

    /// What the first file of a volume says of the patient, if anything. Reads that header again.
    pub fn patient(&self, index: usize, field: PatientField) -> Option<String> {
        let mut frames = self.volumes.get(index)?.frames.iter();
        let (instance, _) = frames.find_map(|r| r.get(&self.instances))?;
        let walked = instance.blob.with_stream(|s| walk_keeping(s, &[field.tag()])).ok()?;
        header::label(&header::parse(&walked).ok()?, field.tag())
    }
}

/// Whether a volume has a gap that is put down to this file, which so has its failure already.
fn names_for_a_gap(volume: &Candidate, name: &str) -> bool {
    let Some(DicomError::MissingSlices { faults, .. }) = &volume.problem else { return false };
    faults.strip_prefix(name).is_some_and(|rest| rest.starts_with(": "))
}

/// The faults of series that have no volume, one a series.
pub(super) fn strays(volumes: &[Candidate], faults: &[Fault]) -> Vec<Stray> {
    let mut strays: Vec<(Option<&String>, Stray)> = Vec::new();
    for (name, uid, fault) in faults {
        let uid = uid.as_ref();
        if uid.is_some_and(|u| volumes.iter().any(|v| v.is_plausible() && v.series.uid == *u)) {
            continue;
        }
        if volumes.iter().any(|v| names_for_a_gap(v, name)) {
            continue;
        }
        match strays.iter_mut().find(|(other, _)| uid.is_some() && *other == uid) {
            Some((_, (_, _, more))) => *more += 1,
            None => strays.push((uid, (name.clone(), fault.clone(), 0))),
        }
    }
    strays.into_iter().map(|(_, stray)| stray).collect()
}
