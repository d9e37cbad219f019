//! What would be done. Opens inputs for their headers, reads no samples, writes nothing.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{Found, Job};
use crate::cancel::Cancel;
use crate::cli::options::Run;
use crate::cli::report::{self, Trouble, grouped};
use crate::cli::term::Term;
use crate::cli::{extract, input};
use crate::error::{Error, Kind};
use crate::pipeline::{self, RunError};
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
    let (mut n_meshes, mut n_failed) = (0, 0);
    let (first, step) = run.shard.unwrap_or((1, 1));
    for (at, job) in jobs.iter().enumerate() {
        // Which shard of as many as there are scans holds this one alone.
        let place = json!([first + at * step, n_scans]);
        if cancel.is_raised() {
            Term::error(&Error::new(RunError::Interrupted));
            return Err(Kind::Interrupted);
        }
        let told = match meta(run, job) {
            Ok(meta) => {
                n_meshes += job.targets.len();
                if run.json {
                    objects(run, job, &meta, &place).iter().try_for_each(Term::json)
                } else {
                    Term::text(&text(run, job, &meta))
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
    term.summary(&format!("{n_meshes} meshes would be made; {n_failed} scans cannot be read"));
    result
}

fn meta(run: &Run, job: &Job) -> Result<Meta, Trouble> {
    match &job.scan.volume {
        Found::Broken(trouble) => Err(trouble.clone()),
        Found::Stdin => {
            let what = "standard input is read once: --dry-run cannot look at it";
            Err(Error::new(RunError::Internal(what)).into())
        }
        _ => {
            let volume = input::open_scan(&job.scan, &run.extract.reading);
            Ok(volume.map_err(|e| e.or_at(&job.scan.path))?.meta)
        }
    }
}

/// Memory on all threads, and triangles of one mesh.
fn estimates(run: &Run, job: &Job, meta: &Meta) -> (u64, u64) {
    let memory = extract::memory(meta, &run.extract, job.targets.len(), run.threads);
    (memory, pipeline::likely_triangles(meta.grid.dims))
}

fn text(run: &Run, job: &Job, meta: &Meta) -> String {
    let [nx, ny, nz] = meta.grid.dims.to_array();
    let (memory, triangles) = estimates(run, job, meta);
    let mut text = format!(
        "{}\n  {} volume {} of {}, {nx} x {ny} x {nz} {}; at most {} MiB of memory\n",
        job.scan.shown(),
        meta.format.as_str(),
        meta.volume_number,
        meta.n_volumes,
        meta.stored,
        memory.div_ceil(1 << 20),
    );
    for target in &job.targets {
        let iso = report::asked(target.level).map_or(String::new(), |iso| format!("--iso {iso} "));
        let about = grouped(triangles);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {iso}-> {}, about {about} triangles", target.output.shown());
    }
    text
}

fn objects(run: &Run, job: &Job, meta: &Meta, place: &Value) -> Vec<Value> {
    let (memory, triangles) = estimates(run, job, meta);
    let object = |target: &super::Target| {
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
    job.targets.iter().map(object).collect()
}
