//! The main command: from inputs to a list of jobs, through them, to a report. One scan is a list
//! of one.
//!
//! ```text
//! find ─► names ─► shard ─► dry                 ─► report
//!                       └─► work (gate, record) ─► report
//! ```

mod board;
mod clash;
mod dry;
mod find;
mod identity;
mod names;
mod record;
mod tell;
mod work;

use super::options::Run;
use super::output::Output;
use super::term::Term;
use super::usage::Usage;
use crate::cancel::Cancel;
use crate::error::Kind;

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
