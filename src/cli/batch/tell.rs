//! What is said of each mesh as it ends, and of all at the end.

use std::collections::HashSet;
use std::fmt::Write;
use std::time::Instant;

use crate::cli::job::{Job, Scan, Target};
use crate::cli::options::Run;
use crate::cli::output::Output;
use crate::cli::report::{self, Done};
use crate::cli::term::{Term, one_line};
use crate::cli::trouble::Trouble;
use crate::error::Kind;

/// What came of a mesh.
pub(super) enum Outcome {
    Done(Box<Done>),
    /// It was there already.
    Skipped,
    Failed(Trouble),
}

/// Tells, counts and remembers.
pub(super) struct Teller<'a> {
    run: &'a Run,
    term: Term,
    began: Instant,
    n_meshes: usize,
    n_done: usize,
    n_skipped: usize,
    failed: Vec<Trouble>,
    /// What was noted of which scan, by its place in memory: meshes of one scan share most notes.
    noted: HashSet<(usize, String)>,
    /// Standard output could not be written to.
    is_mute: bool,
}

impl<'a> Teller<'a> {
    pub(super) fn new(run: &'a Run, term: Term, jobs: &[Job]) -> Self {
        Self {
            run,
            term,
            began: Instant::now(),
            n_meshes: jobs.iter().map(|job| job.targets.len()).sum(),
            n_done: 0,
            n_skipped: 0,
            failed: Vec::new(),
            noted: HashSet::new(),
            is_mute: false,
        }
    }

    fn is_batch(&self) -> bool {
        matches!(self.run.output, Output::Folder(_))
    }

    /// Tells what came of one mesh of a scan, or of all of them alike where no target is named. An
    /// error where it cannot be told.
    pub(super) fn tell(
        &mut self,
        scan: &'a Scan,
        target: Option<&Target>,
        outcome: Outcome,
    ) -> Result<(), Kind> {
        let told = match outcome {
            Outcome::Done(done) => self.done(scan, &done),
            Outcome::Skipped => {
                self.n_skipped += 1;
                target.map_or(Ok(()), |t| self.object(|| report::skipped(scan, t)))
            }
            Outcome::Failed(trouble) => self.failure(scan, target, trouble),
        };
        self.is_mute |= told.is_err();
        told
    }

    fn done(&mut self, scan: &'a Scan, done: &Done) -> Result<(), Kind> {
        self.n_done += 1;
        let of = if self.is_batch() { format!("{}: ", scan.shown()) } else { String::new() };
        for note in done.notes.iter().map(ToString::to_string) {
            let line = format!("{of}{note}");
            if self.noted.insert((std::ptr::from_ref(scan).addr(), note)) {
                self.term.note(&line);
            }
        }
        self.term.summary(&one_line(&done.summary(&self.run.extract)));
        self.term.details(&done.details());
        self.object(|| report::done(&scan.shown(), &self.run.extract, done))
    }

    fn failure(
        &mut self,
        scan: &Scan,
        target: Option<&Target>,
        trouble: Trouble,
    ) -> Result<(), Kind> {
        // What was stopped among many is only counted.
        if !self.is_batch() || trouble.kind != Kind::Interrupted {
            Term::trouble(&trouble);
        }
        let told = self.object(|| {
            let mut object = report::failed("mcubes/1", &scan.shown(), &trouble);
            if let (Some(target), Some(object)) = (target, object.as_object_mut()) {
                object.insert("asked".to_owned(), report::asked(target.level).into());
                object.insert("output".to_owned(), target.output.shown().into());
            }
            object
        });
        if trouble.kind != Kind::Interrupted {
            if target.is_none() {
                // A scan that is broken as a whole fails once for all its meshes.
                self.n_meshes = (self.n_meshes + 1).saturating_sub(self.run.levels.len());
            }
            self.failed.push(trouble);
        }
        told
    }

    fn object(&self, object: impl FnOnce() -> serde_json::Value) -> Result<(), Kind> {
        if self.run.json { Term::json(&object()) } else { Ok(()) }
    }

    /// Says what came of all; an error that stands for the worst of it.
    pub(super) fn sum_up(self, is_interrupted: bool) -> Result<(), Kind> {
        let n_failed = self.failed.len();
        let n_left = self.n_meshes.saturating_sub(self.n_done + self.n_skipped + n_failed);
        if self.is_batch() {
            self.term.summary(&self.table(n_left));
        }
        if self.is_mute {
            return Err(Kind::Unwritable);
        }
        if is_interrupted && n_left > 0 {
            return Err(Kind::Interrupted);
        }
        match self.failed.first() {
            Some(trouble) => Err(trouble.kind),
            None if n_left > 0 => Err(Kind::Internal),
            None => Ok(()),
        }
    }

    fn table(&self, n_left: usize) -> String {
        let seconds = self.began.elapsed().as_secs_f64();
        let mut table = format!(
            "done {}, skipped {}, failed {}, not done {n_left}; {seconds:.1} s",
            self.n_done,
            self.n_skipped,
            self.failed.len(),
        );
        let width = self.failed.iter().map(|t| t.kind.as_str().len()).max().unwrap_or(0);
        for trouble in &self.failed {
            // Writing to a string cannot fail.
            let message = one_line(&trouble.message);
            let _ = write!(table, "\n  {:width$}  {message}", trouble.kind.as_str());
        }
        table
    }
}

/// Tells of a run that ended before there was a list of scans.
pub(super) fn failed_at_once(trouble: &Trouble) -> Result<(), Kind> {
    Term::trouble(trouble);
    Err(trouble.kind)
}
