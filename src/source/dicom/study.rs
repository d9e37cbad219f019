//! A study: its candidate volumes, which is meshed, what was set aside.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::candidate::{Candidate, assess};
use super::error::{DicomError, FileFault};
use super::every::{Stray, strays};
use super::instance::Instance;
use super::lone;
use super::neighbours;
use super::pixels::Pixels;
use super::planes;
use super::series;
use super::set_aside::{SetAside, What};
use super::split;
use crate::cancel::Cancel;
use crate::error::Error;
use crate::source::Volume;
use crate::volume::Note;

/// Other volumes named at most in a note; `mcubes info` lists them all.
const MOST_NAMED: usize = 6;

/// What a folder, file or archive of DICOM holds.
#[derive(Clone)]
pub struct Study {
    /// The volumes, and what nearly is one, in the order of their numbers.
    pub volumes: Vec<Candidate>,
    /// What is no slice, by kind.
    pub set_aside: Vec<SetAside>,
    /// Files that are DICOM and cannot be used, relative to the input, with what is wrong.
    pub faults: Vec<(String, FileFault)>,
    /// Files looked at.
    pub n_files: usize,
    /// Faults that no volume here speaks of, one a series, with the number of others in it.
    pub(super) strays: Vec<Stray>,
    pub(super) cancel: Cancel,
    pub(super) root: PathBuf,
    pub(super) instances: Arc<Vec<Instance>>,
}

/// How a volume is chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selector {
    /// By its number, from 1.
    Number(usize),
    /// By its SeriesInstanceUID; the largest volume of it, of a segmentation the first segment.
    Uid(String),
}

/// How a volume is opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// Meshes across gaps that say that slices are missing.
    pub span_gaps: bool,
}

/// A fault, and the series it belongs to where that could be read.
pub(super) type Fault = (String, Option<String>, FileFault);

impl Study {
    /// Builds the candidates out of what a scan found.
    pub(super) fn build(
        root: &Path,
        mut instances: Vec<Instance>,
        set_aside: Vec<SetAside>,
        faults: Vec<Fault>,
        n_files: usize,
        cancel: &Cancel,
    ) -> Self {
        instances.sort_by(|a, b| series_order(a, b).then_with(|| a.name.cmp(&b.name)));
        series::complete(&mut instances);
        lone::join(&mut instances);
        let mut volumes: Vec<Candidate> = series::group(&instances)
            .into_iter()
            .flat_map(|group| split::split(group, &instances))
            .filter_map(|group| assess(group, &instances, cancel))
            .collect();
        let key = |c: &Candidate| {
            let (i, frame) = c.frames.first().and_then(|r| r.get(&instances))?;
            let number = number_key(i.series_number.as_deref());
            Some((number, i.series_uid.clone(), frame.segment))
        };
        // Stable, so that parts of one series stay in the order of what sets them apart.
        volumes.sort_by_cached_key(key);
        let n_volumes = volumes.len();
        for (index, volume) in volumes.iter_mut().enumerate() {
            volume.number = index + 1;
            if let Some(meta) = &mut volume.meta {
                meta.volume_number = index + 1;
                meta.n_volumes = n_volumes;
            }
        }
        neighbours::note(&mut volumes, &instances);
        note_set_aside(&mut volumes, &set_aside);
        note_faults(&mut volumes, &faults);
        let strays = strays(&volumes, &faults);
        let faults = faults.into_iter().map(|(name, _, fault)| (name, fault)).collect();
        Self {
            strays,
            volumes,
            set_aside,
            faults,
            n_files,
            root: root.to_owned(),
            instances: Arc::new(instances),
            cancel: cancel.clone(),
        }
    }

    /// The volume that is meshed where none is asked for: the one with the most slices, the first
    /// of them by SeriesNumber; a segmentation only where there is nothing else, and of it the first
    /// segment. An index into `volumes`.
    ///
    /// # Errors
    /// Nothing that could be a volume. A volume that is refused for a gap or a bad file is still
    /// the one: a smaller one is never taken in its place unasked.
    pub fn default(&self) -> Result<usize, Error> {
        let plausible = || self.volumes.iter().enumerate().filter(|(_, v)| v.is_plausible());
        let images = plausible().filter(|(_, v)| !v.is_segmentation);
        largest(images).or_else(|| largest(plausible())).ok_or_else(|| {
            let blamed = self.faults.first();
            match (blamed, self.volumes.iter().max_by_key(|v| v.dims[2])) {
                (Some((name, fault)), _) => self.file_error(name, fault, self.faults.len() - 1),
                (None, Some(Candidate { problem: Some(problem), .. })) => {
                    self.error(problem.clone())
                }
                _ => {
                    self.error(DicomError::NoSeries { found: describe(&self.set_aside, |_| true) })
                }
            }
        })
    }

    /// The volume asked for, as an index into `volumes`.
    ///
    /// # Errors
    /// [`DicomError::NoSuchSeries`].
    pub fn choose(&self, selector: &Selector) -> Result<usize, Error> {
        let (found, asked) = match selector {
            Selector::Number(number) => {
                let index = number.checked_sub(1).filter(|&i| i < self.volumes.len());
                (index, number.to_string())
            }
            Selector::Uid(uid) => {
                let of = self.volumes.iter().enumerate().filter(|(_, v)| v.series.uid == *uid);
                (largest(of), uid.clone())
            }
        };
        let of = self.volumes.len();
        found.ok_or_else(|| self.error(DicomError::NoSuchSeries { asked, of }))
    }

    /// Opens a volume: its facts and its planes, decoded as they are asked for, on the thread that
    /// asks.
    ///
    /// # Errors
    /// The volume's `problem`; a file that cannot be read.
    pub fn open(&self, index: usize, options: &OpenOptions) -> Result<Volume<'static>, Error> {
        let no_such = || {
            let (asked, of) = ((index + 1).to_string(), self.volumes.len());
            self.error(DicomError::NoSuchSeries { asked, of })
        };
        let candidate = self.volumes.get(index).ok_or_else(no_such)?;
        if let Some(problem) = candidate.obstacle(options.span_gaps) {
            return Err(self.error(problem.clone()));
        }
        let mut meta = candidate.meta.clone().ok_or_else(no_such)?;
        if let Some(spanned) = &candidate.problem {
            meta.notes.push(Note::Other(format!("meshed across gaps as asked: {spanned}")));
        }
        let pixels = Pixels::prepare(&candidate.frames, &self.instances, &self.cancel).map_err(
            |(name, fault)| {
                if self.cancel.is_raised() {
                    self.error(DicomError::Interrupted)
                } else {
                    self.file_error(&name, &fault, 0)
                }
            },
        )?;
        Ok(Volume { planes: planes::open(pixels, &meta, candidate.uniform), meta })
    }

    /// The files of a volume in the order of its slices, relative to the input, each with the
    /// number of its frame, from 0. Slices of a segmentation that no frame is stored for are not
    /// among them.
    pub fn slices(&self, index: usize) -> Vec<(&str, u64)> {
        let frames = self.volumes.get(index).map(|v| v.frames.as_slice()).unwrap_or_default();
        frames
            .iter()
            .filter_map(|r| r.get(&self.instances))
            .map(|(instance, frame)| (self.name_of(instance), frame.index))
            .collect()
    }

    /// A file's name; where the file is the input, the input's.
    fn name_of<'a>(&'a self, instance: &'a Instance) -> &'a str {
        if instance.name.is_empty() {
            self.root.file_name().and_then(|n| n.to_str()).unwrap_or_default()
        } else {
            &instance.name
        }
    }

    pub(super) fn error(&self, problem: DicomError) -> Error {
        Error::at(&self.root, problem)
    }

    /// An error about one file, at the file's own path.
    pub(super) fn file_error(&self, name: &str, fault: &FileFault, more: usize) -> Error {
        self.error(DicomError::File { name: name.to_owned(), fault: fault.clone(), more })
    }

    /// What to say where a volume was taken without being asked for and there are others: which
    /// it is, and which the others are. Nothing where there is no choice.
    pub fn choice(&self, index: usize) -> Option<Note> {
        let taken = self.volumes.get(index)?;
        let others: Vec<String> = self
            .volumes
            .iter()
            .enumerate()
            .filter(|(other, volume)| *other != index && volume.is_plausible())
            .map(|(_, volume)| volume.title())
            .collect();
        (!others.is_empty()).then(|| {
            let shown = others.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join("; ");
            let more = others.len().saturating_sub(MOST_NAMED);
            let more = if more > 0 { format!("; and {more} more") } else { String::new() };
            let title = taken.title();
            Note::Other(format!(
                "volume {title} is meshed; --series N chooses another: {shown}{more}"
            ))
        })
    }
}

/// The one with the most slices, the first of them; only the first segment of a segmentation counts.
fn largest<'a>(of: impl Iterator<Item = (usize, &'a Candidate)>) -> Option<usize> {
    let mut best: Option<(usize, usize)> = None;
    let mut before = None;
    for (index, volume) in of {
        let is_later_segment = volume.is_segmentation && before == Some(&volume.series.uid);
        before = Some(&volume.series.uid);
        if is_later_segment {
            continue;
        }
        if best.is_none_or(|(_, most)| volume.dims[2] > most) {
            best = Some((index, volume.dims[2]));
        }
    }
    best.map(|(index, _)| index)
}

/// SeriesNumber as a number where it is one; series without come last.
fn number_key(number: Option<&str>) -> (bool, i64, String) {
    let text = number.unwrap_or_default();
    (text.is_empty(), text.parse().unwrap_or(i64::MAX), text.to_owned())
}

fn series_order(a: &Instance, b: &Instance) -> std::cmp::Ordering {
    number_key(a.series_number.as_deref())
        .cmp(&number_key(b.series_number.as_deref()))
        .then_with(|| a.series_uid.cmp(&b.series_uid))
}

/// The kinds of what was set aside, with their counts.
fn describe(set_aside: &[SetAside], shown: impl Fn(What) -> bool) -> String {
    let mut counts: Vec<(What, usize)> = Vec::new();
    for aside in set_aside.iter().filter(|a| shown(a.what)) {
        match counts.iter_mut().find(|(what, _)| *what == aside.what) {
            Some((_, count)) => *count += aside.count,
            None => counts.push((aside.what, aside.count)),
        }
    }
    let all: Vec<String> =
        counts.iter().map(|(what, n)| format!("{n} {}", what.name(*n))).collect();
    all.join(", ")
}

/// Says of each volume what was set aside beside it; directories and files that are no DICOM are
/// not worth a word.
fn note_set_aside(volumes: &mut [Candidate], set_aside: &[SetAside]) {
    let found = describe(set_aside, |what| !matches!(what, What::Directory | What::Foreign));
    if found.is_empty() {
        return;
    }
    for meta in volumes.iter_mut().filter_map(|v| v.meta.as_mut()) {
        meta.notes.push(Note::Other(format!("set aside: {found}")));
    }
}

/// Says of each volume which files could not be used that are or may be part of its series.
fn note_faults(volumes: &mut [Candidate], faults: &[Fault]) {
    for volume in volumes {
        let own: Vec<&Fault> = faults
            .iter()
            .filter(|(_, uid, _)| uid.as_ref().is_none_or(|uid| *uid == volume.series.uid))
            .collect();
        let Some((name, _, fault)) = own.first() else { continue };
        let more = own.len() - 1;
        let line = DicomError::File { name: name.clone(), fault: fault.clone(), more }.to_string();
        if let Some(DicomError::MissingSlices { faults, .. }) = &mut volume.problem {
            faults.clone_from(&line);
        }
        if let Some(meta) = &mut volume.meta {
            meta.notes.push(Note::Other(format!("left out: {line}")));
        }
    }
}
