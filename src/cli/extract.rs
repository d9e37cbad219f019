//! The main command: one volume to one mesh.

use std::path::Path;

use super::bar::Bar;
use super::input;
use super::options::{Extract, Input, Output};
use super::report::{self, Done};
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::{Error, Kind};
use crate::geom::Place;
use crate::pipeline::{self, RunError, RunOptions, Side, SurfaceOptions};
use crate::sink::MeshFile;
use crate::source::{self, Volume};
use crate::volume::Note;

/// Meshes, and says what came of it. Gives back whether it was done.
pub(crate) fn run(options: &Extract, term: Term, cancel: &Cancel) -> Result<(), Kind> {
    let input = match &options.input {
        Input::Path(path) => path.display().to_string(),
        Input::Stdin => "standard input".to_owned(),
    };
    match mesh(options, term, cancel) {
        Ok(done) => {
            for note in &done.notes {
                term.note(&note.to_string());
            }
            term.summary(&done.summary());
            term.details(&done.details());
            if options.json {
                Term::json(&report::done(&input, options, &done));
            }
            Ok(())
        }
        Err(error) => {
            Term::error(&error);
            if options.json {
                Term::json(&report::failed(&input, &error));
            }
            Err(error.kind())
        }
    }
}

fn mesh(options: &Extract, term: Term, cancel: &Cancel) -> Result<Done, Error> {
    let begun = std::time::Instant::now();
    let source_path = match &options.input {
        Input::Path(path) => path.as_path(),
        Input::Stdin => Path::new("standard input"),
    };
    let (surface, mut notes) = surface(options, source_path, cancel)?;
    let volume = shaped(options, &surface, source_path, cancel)?;
    let meta = volume.meta.clone();
    let place = Place::new(&meta.grid, options.space)
        .map_err(|e| Error::at(source_path, RunError::from(e)))?;
    let mut file = match &options.output {
        Output::File(path) => {
            MeshFile::create(path, &options.mesh).map_err(|e| Error::at(path, e))?
        }
        Output::Stdout => MeshFile::stdout(&options.mesh).map_err(Error::new)?,
    };
    let bar = Bar::new(term, meta.grid.dims.nz());
    let run = RunOptions {
        threads: options.threads,
        slab_planes: None,
        cancel: cancel.clone(),
        progress: Some(&bar),
    };
    let surfaces: Vec<(_, &mut dyn crate::sink::Sink)> = vec![(surface, &mut file)];
    let reports = pipeline::extract(volume, &place, surfaces, &run);
    bar.finish();
    let report = match reports {
        Ok(reports) => reports.into_iter().next(),
        Err(RunError::IsoNotReached { .. }) => {
            return Err(not_reached(options, &surface, source_path, cancel));
        }
        Err(error @ RunError::Sink(_)) => {
            return Err(match &options.output {
                Output::File(path) => Error::at(path, error),
                Output::Stdout => Error::new(error),
            });
        }
        Err(error) => return Err(Error::at(source_path, error)),
    };
    let Some(report) = report else {
        return Err(Error::new(RunError::Internal("a run without a report")));
    };
    file.commit().map_err(|e| match &options.output {
        Output::File(path) => Error::at(path, e),
        Output::Stdout => Error::new(e),
    })?;
    notes.extend(meta.notes.iter().cloned());
    notes.extend(report.notes.iter().cloned());
    if place.epsilon() > Place::COARSE_EPSILON {
        notes.push(Note::CoarseCoordinates { epsilon: place.epsilon() });
    }
    Ok(Done { iso: surface.iso, meta, report, notes, total_seconds: begun.elapsed().as_secs_f64() })
}

/// The surface that is meant. Without an iso value the volume is looked at: one of 0 and one other
/// value has its surface halfway.
fn surface(
    options: &Extract,
    path: &Path,
    cancel: &Cancel,
) -> Result<(SurfaceOptions, Vec<Note>), Error> {
    if options.iso.is_some() || options.mask.is_some() {
        return Ok((options.surface, Vec::new()));
    }
    let volume = input::open(&options.input, &options.reading, cancel)?;
    let half = options.steps.part(volume).and_then(|part| source::two_values(part, cancel));
    if cancel.is_raised() {
        return Err(Error::at(path, RunError::Interrupted));
    }
    let half = half.map_err(|e| Error::at(path, e))?;
    let Some(iso) = half else { return Err(Error::at(path, RunError::NoIso)) };
    let note = Note::Other(format!("the volume holds two values: meshed at the half, {iso}"));
    Ok((SurfaceOptions { iso, ..options.surface }, vec![note]))
}

/// The volume with what was asked of it done to it, and its padding out of the way.
fn shaped(
    options: &Extract,
    surface: &SurfaceOptions,
    path: &Path,
    cancel: &Cancel,
) -> Result<Volume<'static>, Error> {
    let volume = input::open(&options.input, &options.reading, cancel)?;
    let volume =
        options.steps.apply(volume, options.mask.as_deref()).map_err(|e| Error::at(path, e))?;
    if options.mask.is_some() {
        return Ok(volume);
    }
    Ok(source::pad_out(volume, surface.iso, surface.side == Side::Below))
}

/// The error, with the range that the values do have, from a second look at the data.
fn not_reached(options: &Extract, surface: &SurfaceOptions, path: &Path, cancel: &Cancel) -> Error {
    let iso = surface.iso;
    let range = match &options.input {
        Input::Path(_) => shaped(options, surface, path, cancel)
            .ok()
            .and_then(|volume| source::survey(volume).ok())
            .and_then(|survey| survey.range),
        Input::Stdin => None,
    };
    let error = match range {
        Some((_, high)) if options.mask.is_some() && high <= 0.0 => RunError::NoLabel,
        _ => RunError::IsoNotReached { iso, range, open: surface.open },
    };
    Error::at(path, error)
}
