//! What would be done. Opens inputs for their headers, reads no samples, writes nothing.

use std::fmt::Write;

use serde_json::{Value, json};

use super::record::{Known, Record};
use crate::cancel::Cancel;
use crate::cli::job::{Found, Job, Target};
use crate::cli::options::{Extract, Run};
use crate::cli::output::Output;
use crate::cli::term::{Term, one_line};
use crate::cli::trouble::Trouble;
use crate::cli::{extract, input, report};
use crate::error::{Error, Kind};
use crate::pipeline::{self, Method, RunError};
use crate::source::{SourceError, grouped};
use crate::volume::Meta;

/// Tells of each job what would be read, chosen and written.
pub(super) fn run(
    run: &Run,
    jobs: &[Job],
    n_scans: usize,
    term: Term,
    cancel: &Cancel,
) -> Result<(), Kind> {
    let mut result = Ok(());
    let (mut n_meshes, mut n_done, mut n_failed) = (0, 0, 0);
    let record = match &run.output {
        Output::Folder(folder) if run.resume => Some(Record::open(folder, run.shard, true)),
        _ => None,
    };
    let (first, step) = run.shard.unwrap_or((1, 1));
    for (at, job) in jobs.iter().enumerate() {
        // Which shard of as many as there are scans holds this one alone.
        let place = json!([first + at * step, n_scans]);
        if cancel.is_raised() {
            Term::error(&Error::new(RunError::Interrupted));
            return Err(Kind::Interrupted);
        }
        let known = record.as_ref().map(|record| Known::of(record, &run.extract, &job.scan));
        let is_done = |target: &&Target| known.as_ref().is_some_and(|known| known.is_done(target));
        let (done, left): (Vec<&Target>, Vec<&Target>) = job.targets.iter().partition(is_done);
        n_done += done.len();
        if run.json {
            let skipped = |target: &&Target| Term::json(&report::skipped(&job.scan, target));
            result = result.and(done.iter().try_for_each(skipped));
        }
        if left.is_empty() {
            continue;
        }
        let told = match plan(run, job, left.len(), cancel) {
            Ok(plan) => {
                n_meshes += left.len();
                if run.json {
                    objects(job, &left, &plan, &place).iter().try_for_each(Term::json)
                } else {
                    Term::text(&text(job, &left, &plan))
                }
            }
            Err(trouble) => {
                n_failed += 1;
                Term::trouble(&trouble);
                let told = if run.json {
                    let mut object = report::failed("mcubes/1", &job.scan.shown(), &trouble);
                    object["shard"] = place;
                    Term::json(&object)
                } else {
                    Ok(())
                };
                told.and(Err(trouble.kind))
            }
        };
        result = result.and(told);
    }
    let (es, s) = (if n_meshes == 1 { "" } else { "es" }, if n_failed == 1 { "" } else { "s" });
    let made = format!("{n_meshes} mesh{es} would be made");
    let there = if run.resume { format!(", {n_done} skipped") } else { String::new() };
    term.summary(&format!("{made}{there}; {n_failed} scan{s} cannot be read"));
    result
}

/// A scan as it would be meshed.
struct Plan {
    /// After crop, blur and downsample.
    meta: Meta,
    /// Bytes, on all threads.
    memory: u64,
    /// Of one mesh.
    triangles: u64,
}

fn plan(run: &Run, job: &Job, n_meshes: usize, cancel: &Cancel) -> Result<Plan, Trouble> {
    match &job.scan.volume {
        Found::Broken(trouble) => Err(trouble.clone()),
        _ if job.scan.is_read_once() => {
            let (kind, hint) = (Kind::Unreadable, None);
            let message = "is read once: --dry-run cannot look at it".to_owned();
            Err(Error::at(job.scan.shown(), SourceError::Other { kind, message, hint }).into())
        }
        _ => {
            let Extract { steps, mask, surface, .. } = &run.extract;
            let volume = input::open_scan(&job.scan, &run.extract.reading, cancel)
                .map_err(|e| e.or_at(&job.scan.path))?;
            let memory = extract::memory(&volume.meta, &run.extract, n_meshes, run.threads);
            let volume =
                steps.apply(volume, mask.as_deref()).map_err(|e| Error::at(&job.scan.path, e))?;
            let each = if surface.method == Method::Tetrahedra { 3 } else { 1 };
            let triangles = each * pipeline::likely_triangles(volume.meta.grid.dims);
            Ok(Plan { meta: volume.meta, memory, triangles })
        }
    }
}

fn text(job: &Job, left: &[&Target], plan: &Plan) -> String {
    let Plan { meta, memory, triangles } = plan;
    let [nx, ny, nz] = meta.grid.dims.to_array();
    let mut text = format!(
        "{}\n  {} volume {} of {}, {nx} x {ny} x {nz} {}; at most {} MiB of memory\n",
        one_line(&job.scan.shown()),
        meta.format.as_str(),
        meta.volume_number,
        meta.n_volumes,
        meta.stored,
        memory.div_ceil(1 << 20),
    );
    for target in left {
        let iso = report::asked(target.level).map_or(String::new(), |iso| format!("--iso {iso} "));
        let (output, about) = (one_line(&target.output.shown()), grouped(*triangles));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {iso}-> {output}, about {about} triangles");
    }
    text
}

fn objects(job: &Job, left: &[&Target], plan: &Plan, place: &Value) -> Vec<Value> {
    let Plan { meta, memory, triangles } = plan;
    let object = |target: &&Target| {
        json!({
            "schema": "mcubes/1",
            "status": "planned",
            "input": job.scan.shown(),
            "format": meta.format.as_str(),
            "series": meta.series.as_ref().map(|s| &s.uid),
            "volume_number": meta.volume_number,
            "modality": meta.modality,
            "dims": meta.grid.dims.to_array(),
            "stored": meta.stored.as_str(),
            "asked": report::asked(target.level),
            "output": target.output.shown(),
            "shard": place,
            "estimate": { "memory": memory, "triangles": triangles },
            "notes": meta.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    };
    left.iter().map(object).collect()
}
