//! Does jobs side by side. A failure ends its own scan only, unless the first is to end all.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::board::Board;
use super::record::{Known, Record};
use super::tell::{Outcome, Teller};
use crate::cancel::Cancel;
use crate::cli::extract::{self, How};
use crate::cli::gate::Gate;
use crate::cli::job::{Found, Job, Scan, Target};
use crate::cli::options::Run;
use crate::cli::output::Output;
use crate::error::Kind;
use crate::volume::Note;

/// Goes through all jobs, tells what comes of each, and sums up.
pub(super) fn run(run: &Run, jobs: &[Job], board: &Board, cancel: &Cancel) -> Result<(), Kind> {
    let record = match &run.output {
        Output::Folder(folder) => Some(Record::open(folder, run.shard, run.resume)),
        Output::File(_) | Output::Stdout => None,
    };
    let work = Work {
        run,
        jobs,
        board,
        record,
        gate: Gate::new(run.threads, run.jobs, run.max_memory, jobs.len()),
        // The failure that ends all is no stop of the user's.
        stop: if run.fail_fast { Cancel::new() } else { cancel.clone() },
        asked: cancel,
        next: AtomicUsize::new(0),
        is_ended: AtomicBool::new(false),
        teller: Mutex::new(Teller::new(run, board.term, jobs)),
    };
    let whole = board.whole(jobs.len());
    std::thread::scope(|scope| {
        if run.fail_fast {
            scope.spawn(|| work.listen());
        }
        let workers: Vec<_> = (0..run.jobs.min(jobs.len()))
            .map(|_| {
                scope.spawn(|| {
                    while let Some(job) = work.take() {
                        work.one(job);
                        whole.inc(1);
                    }
                })
            })
            .collect();
        for worker in workers {
            // A panic is told by the runtime; the scan it ended counts as not done.
            let _ = worker.join();
        }
        work.is_ended.store(true, Ordering::Relaxed);
    });
    whole.finish_and_clear();
    let is_interrupted = cancel.is_raised();
    let teller = work.teller.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    teller.sum_up(is_interrupted)
}

struct Work<'a> {
    run: &'a Run,
    jobs: &'a [Job],
    board: &'a Board,
    record: Option<Record>,
    gate: Gate,
    /// Raised by the user's stop and by the failure that ends all.
    stop: Cancel,
    asked: &'a Cancel,
    next: AtomicUsize,
    is_ended: AtomicBool,
    teller: Mutex<Teller<'a>>,
}

impl<'a> Work<'a> {
    /// Hands the user's stop on.
    fn listen(&self) {
        while !self.is_ended.load(Ordering::Relaxed) {
            if self.asked.is_raised() {
                self.stop.raise();
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }

    fn take(&self) -> Option<&'a Job> {
        if self.stop.is_raised() || self.asked.is_raised() {
            return None;
        }
        self.jobs.get(self.next.fetch_add(1, Ordering::Relaxed))
    }

    fn one(&self, job: &'a Job) {
        let Job { scan, targets } = job;
        if let Found::Broken(trouble) = &scan.volume {
            self.gate.pass();
            self.tell(scan, None, Outcome::Failed(trouble.clone()));
            return;
        }
        let extract = &self.run.extract;
        let known = self.record.as_ref().map(|record| Known::of(record, extract, scan));
        let is_done = |target: &&Target| known.as_ref().is_some_and(|known| known.is_done(target));
        let (done, left): (Vec<&Target>, Vec<&Target>) = targets.iter().partition(is_done);
        for target in done {
            self.tell(scan, Some(target), Outcome::Skipped);
        }
        if left.is_empty() {
            self.gate.pass();
            return;
        }
        let bar = self.board.scan(&scan.shown());
        let how = How { extract, gate: &self.gate, cancel: &self.stop, progress: &bar };
        let results = extract::meshes(scan, &left, &how);
        drop(bar);
        for (target, result) in left.into_iter().zip(results) {
            let outcome = match result {
                Ok(mut done) => {
                    if let Some(Err(e)) = known.as_ref().map(|known| known.write_down(target)) {
                        let why = crate::error::system_words(&e);
                        done.notes.push(Note::Other(format!("the record of finished work cannot be written: {why}; --resume will mesh this again")));
                    }
                    Outcome::Done(Box::new(done))
                }
                Err(trouble) => Outcome::Failed(trouble),
            };
            self.tell(scan, Some(target), outcome);
        }
    }

    fn tell(&self, scan: &'a Scan, target: Option<&Target>, outcome: Outcome) {
        let ends_all = self.run.fail_fast
            && matches!(&outcome, Outcome::Failed(t) if t.kind != Kind::Interrupted);
        if ends_all {
            self.stop.raise();
        }
        let mut teller = self.teller.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let told = self.board.say(|| teller.tell(scan, target, outcome));
        if told.is_err() {
            self.stop.raise();
        }
    }
}
