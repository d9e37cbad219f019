//! One volume to its meshes, one an iso value: read once, or once more where padding acts.

use std::cell::RefCell;
use std::error::Error as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::gate::{Gate, Need, Refused};
use super::input;
use super::job::{Destination, Found, Scan, Target};
use super::level::{self, Chosen, Level};
use super::options::Extract;
use super::report::Done;
use super::signals::while_taken;
use super::trouble::Trouble;
use crate::cancel::Cancel;
use crate::error::{Error, Kind, is_too_many_open};
use crate::geom::{Grid, Place, Space};
use crate::pipeline::{self, Progress, Report, RunError, RunOptions, SurfaceOptions};
use crate::sink::{MeshFile, MeshFormat, SPOOL_BYTES, Sink};
use crate::source::{self, SourceError, Volume, is_active};
use crate::volume::{Inside, Meta, Note, StoredType};

/// What all scans of a run have in common.
pub(crate) struct How<'a> {
    pub(crate) extract: &'a Extract,
    pub(crate) gate: &'a Gate,
    pub(crate) cancel: &'a Cancel,
    pub(crate) progress: &'a dyn Progress,
}

type Made = Result<Done, Trouble>;

/// Bytes of memory that the meshes of a volume take at once.
pub(crate) fn memory(meta: &Meta, extract: &Extract, n_meshes: usize, threads: usize) -> u64 {
    // Slices are decoded, padding taken out, as `f64`.
    let steps = &extract.steps;
    let is_wide = meta.series.is_some() || meta.padding.is_some() || steps.are_means();
    let sample = if is_wide { StoredType::F64 } else { meta.stored }.size();
    let spooled = if extract.mesh.format == MeshFormat::Stl { 0 } else { SPOOL_BYTES as u64 };
    let spooled = spooled.min(pipeline::likely_triangles(meta.grid.dims).saturating_mul(8 * 13));
    let options = RunOptions { threads, ..RunOptions::default() };
    let method = extract.surface.method;
    pipeline::working_bytes(meta.grid.dims, sample, method, n_meshes, spooled, &options)
        .saturating_add(steps.held_bytes(meta))
}

/// What comes of each target, in their order.
pub(crate) fn meshes(scan: &Scan, targets: &[&Target], how: &How<'_>) -> Vec<Made> {
    let path = match scan.volume {
        Found::Stdin => PathBuf::from("standard input"),
        _ => scan.path.clone(),
    };
    let all = |error: Error| {
        let trouble = Trouble::from(error.or_at(&path));
        targets.iter().map(|_| Err(trouble.clone())).collect()
    };
    let volume = match input::open_scan(scan, &how.extract.reading, how.cancel) {
        Ok(volume) => volume,
        Err(error) => {
            how.gate.pass();
            return all(error);
        }
    };
    let meta = volume.meta.clone();
    let sample_bytes = meta.grid.dims.n_samples().saturating_mul(meta.stored.size() as u64);
    let memory = |threads| memory(&meta, how.extract, targets.len(), threads);
    let permit = match how.gate.enter(&Need { sample_bytes, memory: &memory }, how.cancel) {
        Ok(permit) => permit,
        Err(Refused::Interrupted) => return all(Error::new(RunError::Interrupted)),
        Err(Refused::TooLarge { needed, limit }) => {
            return all(Error::new(RunError::TooLarge { needed, limit }));
        }
    };
    let work = Work {
        scan,
        how,
        path: &path,
        opened: RefCell::new(Some(volume)),
        threads: permit.threads,
        begun: Instant::now(),
    };
    work.meshes(&meta, targets)
}

/// A target whose iso value is known.
struct Member<'a> {
    /// Its place among the targets.
    at: usize,
    target: &'a Target,
    iso: f64,
    note: Option<Note>,
}

struct Work<'a> {
    scan: &'a Scan,
    how: &'a How<'a>,
    path: &'a Path,
    /// The volume as it was opened, until it is used.
    opened: RefCell<Option<Volume<'static>>>,
    threads: usize,
    begun: Instant,
}

impl Work<'_> {
    fn meshes(&self, meta: &Meta, targets: &[&Target]) -> Vec<Made> {
        let mut made: Vec<(usize, Made)> = Vec::new();
        // What is read at once. A volume with its padding taken out is another for each iso value.
        let mut together: Vec<Member<'_>> = Vec::new();
        let mut apart: Vec<Vec<Member<'_>>> = Vec::new();
        for (at, target) in targets.iter().enumerate() {
            // A threshold is that of what is meshed; two values are those of the file.
            let looked_at = || match target.level {
                Level::Auto => self.stepped(),
                _ => self.part(),
            };
            match level::resolve(target.level, meta, self.how.cancel, looked_at) {
                Ok(Chosen { iso, note }) => {
                    let member = Member { at, target, iso, note };
                    if target.level != Level::Labels && is_active(meta, self.inside(iso)) {
                        apart.push(vec![member]);
                    } else {
                        together.push(member);
                    }
                }
                Err(error) => made.push((at, Err(error.or_at(self.path).into()))),
            }
        }
        for members in apart.into_iter().chain([together]).filter(|m| !m.is_empty()) {
            let places: Vec<usize> = members.iter().map(|m| m.at).collect();
            match self.read_once(members) {
                Ok(results) => made.extend(results),
                Err(error) => {
                    let trouble = Trouble::from(error.or_at(self.path));
                    made.extend(places.into_iter().map(|at| (at, Err(trouble.clone()))));
                }
            }
        }
        made.sort_by_key(|(at, _)| *at);
        made.into_iter().map(|(_, result)| result).collect()
    }

    fn inside(&self, iso: f64) -> Inside {
        Inside { iso, side: self.how.extract.surface.side }
    }

    fn whole(&self) -> Result<Volume<'static>, Error> {
        match self.opened.take() {
            Some(volume) => Ok(volume),
            None if self.scan.is_read_once() => {
                Err(Error::new(RunError::Internal("what is read once was opened again")))
            }
            None => input::open_scan(self.scan, &self.how.extract.reading, self.how.cancel),
        }
    }

    /// The part of the volume that is meshed, as it is stored.
    fn part(&self) -> Result<Volume<'static>, Error> {
        self.how.extract.steps.part(self.whole()?).map_err(Error::new)
    }

    /// The volume with what was asked of it done to it, labels seen to.
    fn stepped(&self) -> Result<Volume<'static>, Error> {
        let Extract { steps, mask, .. } = self.how.extract;
        steps.apply(self.whole()?, mask.as_deref()).map_err(Error::new)
    }

    /// The same with its padding seen to.
    fn shaped(&self, iso: f64) -> Result<Volume<'static>, Error> {
        let volume = self.stepped()?;
        Ok(match self.how.extract.mask {
            Some(_) => volume,
            None => source::pad_out(volume, self.inside(iso)),
        })
    }

    /// Meshes for each member while the volume is read once, with their places among the targets.
    fn read_once(&self, members: Vec<Member<'_>>) -> Result<Vec<(usize, Made)>, Error> {
        let extract = self.how.extract;
        let volume = self.shaped(members.first().map_or(0.0, |m| m.iso))?;
        let meta = volume.meta.clone();
        let place = place(&meta.grid, extract.space)?;
        let n_members = members.len();
        let mut made: Vec<(usize, Made)> = Vec::new();
        let mut begun: Vec<(Member<'_>, MeshFile)> = Vec::new();
        for member in members {
            match while_taken(|| create(&member.target.output, extract)) {
                Ok(file) => begun.push((member, file)),
                Err(error) => made.push((member.at, Err(among(&error, n_members)))),
            }
        }
        if begun.is_empty() {
            return Ok(made);
        }
        match self.fill(volume, &place, &mut begun) {
            Ok(reports) => made.extend(begun.into_iter().zip(reports).map(|(member, report)| {
                let (member, file) = member;
                let at = member.at;
                let made = match report.filter(|report| report.n_triangles > 0) {
                    Some(report) => self.put(member, file, report, &meta, &place),
                    None => Err(self.not_reached(member.iso)),
                };
                (at, made.map_err(|error| error.or_at(self.path).into()))
            })),
            Err(error) => {
                let trouble = among(&error.or_at(self.path), n_members);
                made.extend(begun.iter().map(|(member, _)| (member.at, Err(trouble.clone()))));
            }
        }
        Ok(made)
    }

    /// Fills the files; no report where the iso value is not reached.
    fn fill(
        &self,
        volume: Volume<'static>,
        place: &Place,
        begun: &mut [(Member<'_>, MeshFile)],
    ) -> Result<Vec<Option<Report>>, Error> {
        let surfaces = begun.iter_mut().map(|(member, file)| {
            let surface = SurfaceOptions { iso: member.iso, ..self.how.extract.surface };
            (surface, file as &mut dyn Sink)
        });
        let options = RunOptions {
            threads: self.threads,
            slab_planes: None,
            cancel: self.how.cancel.clone(),
            progress: Some(self.how.progress),
        };
        match pipeline::extract(volume, place, surfaces.collect(), &options) {
            Ok(reports) => Ok(reports.into_iter().map(Some).collect()),
            Err(RunError::IsoNotReached { .. }) => Ok(begun.iter().map(|_| None).collect()),
            Err(error @ RunError::Sink(_)) => Err(at_output(begun, error)),
            Err(error) => Err(Error::new(error)),
        }
    }

    /// Gives a mesh its name.
    fn put(
        &self,
        member: Member<'_>,
        file: MeshFile,
        report: Report,
        meta: &Meta,
        place: &Place,
    ) -> Result<Done, Error> {
        let output = member.target.output.clone();
        while_taken(|| file.commit()).map_err(|e| at(&output, e))?;
        let mut notes: Vec<Note> = member.note.into_iter().collect();
        notes.extend(meta.notes.iter().cloned());
        notes.extend(report.notes.iter().cloned());
        if place.epsilon() > Place::COARSE_EPSILON {
            notes.push(Note::CoarseCoordinates { epsilon: place.epsilon() });
        }
        Ok(Done {
            level: member.target.level,
            iso: member.iso,
            output,
            meta: meta.clone(),
            report,
            notes,
            total_seconds: self.begun.elapsed().as_secs_f64(),
        })
    }

    /// The error, with the range that the values do have, from a second look at the data where
    /// there can be one.
    fn not_reached(&self, iso: f64) -> Error {
        let look = || source::survey(self.stepped().ok()?, self.how.cancel).ok()?.range;
        let range = if self.scan.is_read_once() { None } else { look() };
        if self.how.cancel.is_raised() {
            return Error::new(RunError::Interrupted);
        }
        let Extract { surface, mask, .. } = self.how.extract;
        Error::new(match range {
            Some((_, high)) if mask.is_some() && high <= 0.0 => RunError::NoLabel,
            _ => RunError::IsoNotReached { iso, range, open: surface.open },
        })
    }
}

/// The map to the output's coordinates. Where these are too coarse indices mostly are not; if they
/// are, --space voxel is no way out.
fn place(grid: &Grid, space: Space) -> Result<Place, Error> {
    Place::new(grid, space).map_err(|e| match Place::new(grid, Space::Voxel) {
        Ok(_) => Error::new(RunError::from(e)),
        Err(_) => Error::new(SourceError::Other {
            kind: Kind::OutOfRangeSpace,
            message: e.to_string(),
            hint: Some("--downsample makes an axis of fewer samples".to_owned()),
        }),
    })
}

/// Starts a mesh file; the folders that it is to stand in are made with it.
fn create(output: &Destination, extract: &Extract) -> Result<MeshFile, Error> {
    let file = match output {
        Destination::Stdout => MeshFile::stdout(&extract.mesh),
        Destination::File(path) => MeshFile::create_with_folders(path, &extract.mesh),
    };
    file.map_err(|e| at(output, e))
}

fn at(output: &Destination, error: impl crate::error::Failure) -> Error {
    match output {
        Destination::File(path) => Error::at(path, error),
        Destination::Stdout => Error::at("standard output", error),
    }
}

/// What went wrong with one of so many meshes, which have a file each open at once.
fn among(error: &Error, n_meshes: usize) -> Trouble {
    let mut trouble = Trouble::from(error);
    let mut cause = error.source();
    while let Some(inner) = cause.filter(|_| n_meshes > 1) {
        if inner.downcast_ref().is_some_and(is_too_many_open) {
            let hint = "raise the limit (ulimit -n), or give fewer --iso at once";
            trouble.hint = Some(hint.to_owned());
        }
        cause = inner.source();
    }
    trouble
}

/// A sink does not say which it is; where there are several their folder is named.
fn at_output(begun: &[(Member<'_>, MeshFile)], error: RunError) -> Error {
    match begun {
        [(member, _)] => at(&member.target.output, error),
        _ => match begun.first().and_then(|(m, _)| m.target.output.path()?.parent()) {
            Some(folder) => Error::at(folder, error),
            None => Error::new(error),
        },
    }
}
