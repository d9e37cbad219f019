//! The main command: from inputs to a list of jobs, through them, to a report. One scan is a list
//! of one.
//!
//! ```text
//! find ─► names ─► shard ─► dry                 ─► report
//!                       └─► work (gate, record) ─► report
//! ```

mod board;
mod dry;
mod find;
mod gate;
mod identity;
pub(super) mod names;
mod record;
mod tell;
mod work;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(super) use board::Bar;
pub(super) use gate::{Gate, Need, Refused};

use super::level::Level;
use super::options::{Output, Run, Usage};
use super::report::Trouble;
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::Kind;
use crate::source;
use crate::source::dicom::Study;

/// One volume of the inputs.
pub(super) struct Scan {
    /// The input as typed, or as found below it.
    pub(super) path: PathBuf,
    pub(super) volume: Found,
    /// The folder in the output's tree that it goes to by itself.
    pub(super) parent: Option<PathBuf>,
}

/// How the volume is had.
pub(super) enum Found {
    /// A NIfTI or raw file, opened when it is its turn.
    File,
    /// Raw samples.
    Stdin,
    /// A volume of a study whose headers are read.
    Series {
        study: Arc<Study>,
        index: usize,
        /// Whether others of the same file or folder are meshed beside it.
        among: bool,
        /// Whether it was taken where others might have been, without being asked for.
        is_choice: bool,
    },
    /// Nothing that could be meshed, and why.
    Broken(Trouble),
}

/// One mesh that is to be made.
pub(super) struct Target {
    pub(super) level: Level,
    pub(super) output: Destination,
}

/// Where one mesh goes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Destination {
    File(PathBuf),
    Stdout,
}

impl Destination {
    /// As reports have it.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Stdout => "-".to_owned(),
        }
    }

    /// The file, if it is one.
    pub(super) fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Stdout => None,
        }
    }
}

/// A volume and the meshes that are made of it.
pub(super) struct Job {
    pub(super) scan: Scan,
    pub(super) targets: Vec<Target>,
}

impl Scan {
    /// Whether its bytes come only once: a pipe, a device.
    pub(super) fn is_read_once(&self) -> bool {
        match self.volume {
            Found::Stdin => true,
            Found::File => source::is_stream(&self.path),
            Found::Series { .. } | Found::Broken(_) => false,
        }
    }

    /// The input as reports have it.
    pub(super) fn shown(&self) -> String {
        match self.volume {
            Found::Stdin => "standard input".to_owned(),
            _ => self.path.display().to_string(),
        }
    }
}

/// Does all that was asked for, and says what came of it.
pub(super) fn run(run: &Run, term: Term, cancel: &Cancel) -> Result<Result<(), Kind>, Usage> {
    let board = board::Board::new(term);
    let found = match find::find(run, &board, cancel) {
        Ok(found) => found,
        Err(trouble) => return Ok(tell::failed_at_once(&trouble)),
    };
    let mut jobs = names::jobs(found.scans, run)?;
    let n_scans = jobs.len();
    if let Some((part, of)) = run.shard {
        let mut at = 0..;
        jobs.retain(|_| at.next().is_some_and(|at: usize| at % of == part - 1));
    }
    if matches!(run.output, Output::Folder(_)) {
        match found.passed_over {
            0 => {}
            1 => term.note("1 file that is no volume was passed over"),
            n => term.note(&format!("{n} files that are no volume were passed over")),
        }
    }
    if run.is_dry {
        return Ok(dry::run(run, &jobs, n_scans, term, cancel));
    }
    Ok(work::run(run, &jobs, &board, cancel))
}
