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
use crate::pipeline::{self, RunError, RunOptions};
use crate::sink::MeshFile;
use crate::source;
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
    let volume = input::open(&options.input, &options.reading, cancel)?;
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
    let surfaces: Vec<(_, &mut dyn crate::sink::Sink)> = vec![(options.surface, &mut file)];
    let reports = pipeline::extract(volume, &place, surfaces, &run);
    bar.finish();
    let report = match reports {
        Ok(reports) => reports.into_iter().next(),
        Err(RunError::IsoNotReached { .. }) => {
            return Err(not_reached(options, source_path, cancel));
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
    let mut notes = meta.notes.clone();
    notes.extend(report.notes.iter().cloned());
    if place.epsilon() > Place::COARSE_EPSILON {
        notes.push(Note::CoarseCoordinates { epsilon: place.epsilon() });
    }
    Ok(Done { meta, report, notes, total_seconds: begun.elapsed().as_secs_f64() })
}

/// The error, with the range that the values do have, from a second look at the data.
fn not_reached(options: &Extract, path: &Path, cancel: &Cancel) -> Error {
    let iso = options.surface.iso;
    let range = match &options.input {
        Input::Path(_) => input::open(&options.input, &options.reading, cancel)
            .ok()
            .and_then(|volume| source::survey(volume).ok())
            .and_then(|survey| survey.range),
        Input::Stdin => None,
    };
    let error = RunError::IsoNotReached { iso, range, open: options.surface.open };
    Error::at(path, error)
}
