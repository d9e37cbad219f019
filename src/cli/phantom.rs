//! `mcubes phantom`: a volume made by a formula, and what is true of its surface.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::PhantomArgs;
use super::options;
use super::output::{both_on_stdout, is_dash, is_stdout, no_folder};
use super::report::{affine, measured};
use super::signals::while_taken;
use super::term::Term;
use super::usage::Usage;
use crate::cancel::Cancel;
use crate::error::{Error, Kind, readable};
use crate::phantom::Phantom;
use crate::sink::folder_of;

/// Writes the volume, and says what came of it.
pub(crate) fn run(
    args: &PhantomArgs,
    term: Term,
    cancel: &Cancel,
) -> Result<Result<(), Kind>, Usage> {
    let path = output(&args.output, args.json)?;
    let threads = options::threads(args.threads)?;
    let phantom = Phantom {
        shape: args.shape,
        dims: args.dims,
        spacing_mm: args.spacing,
        noise: args.noise,
        seed: args.seed,
        stored: args.stored,
    };
    let begun = Instant::now();
    let write = || phantom.write(path, threads, cancel);
    // A file is written with looks at the flag, and may be half there.
    let is_file = path.is_some_and(|path| path.is_file() || !path.exists());
    let written = if is_file { write() } else { while_taken(write) };
    let made = written.and_then(|()| {
        let object = done(&phantom, &args.output, begun.elapsed().as_secs_f64());
        object.map_err(|e| Error::at(&args.output, e))
    });
    match made {
        Ok(object) => {
            term.summary(&summary(&phantom));
            Ok(if args.json { Term::json(&object) } else { Ok(()) })
        }
        Err(error) => {
            Term::error(&error);
            if args.json {
                Term::json(&failed(&phantom, &args.output, &error)).ok();
            }
            Ok(Err(error.kind()))
        }
    }
}

/// The file to be written, or none for standard output.
fn output(path: &Path, json: bool) -> Result<Option<&Path>, Usage> {
    if json && (is_dash(path) || is_stdout(path)) {
        return Err(both_on_stdout(path, "volume"));
    }
    if is_dash(path) {
        return Ok(None);
    }
    let shown = path.display();
    if path.is_dir() {
        return Err(Usage::new(format!("{shown}: the output is a folder"))
            .hint(format!("-o {}", path.join("phantom.nii.gz").display())));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(no_folder(folder, folder));
    }
    let unzipped = match path.extension() {
        Some(end) if end.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.to_owned(),
    };
    if !unzipped.extension().is_some_and(|end| end.eq_ignore_ascii_case("nii")) {
        return Err(Usage::new(format!("{shown}: neither .nii nor .nii.gz")));
    }
    Ok(Some(path))
}

fn summary(phantom: &Phantom) -> String {
    let truth = phantom.truth();
    let [nx, ny, nz] = phantom.dims;
    let mut known = Vec::new();
    if let Some(area) = truth.area_mm2 {
        known.push(format!("area {} mm²", measured(area)));
    }
    if let Some(volume) = truth.volume_mm3 {
        known.push(format!("volume {} mm³", measured(volume)));
    }
    if let Some(euler) = truth.euler {
        known.push(format!("Euler number {euler}"));
    }
    let known = if known.is_empty() { "no formula for it".to_owned() } else { known.join(", ") };
    format!(
        "{}: {nx} x {ny} x {nz} {} samples; the surface at {}: {known}",
        phantom.shape,
        phantom.stored,
        phantom.shape.iso()
    )
}

fn done(
    phantom: &Phantom,
    output: &Path,
    seconds: f64,
) -> Result<Value, crate::phantom::PhantomError> {
    let meta = phantom.volume()?.meta;
    let truth = phantom.truth();
    Ok(json!({
        "schema": "mcubes-phantom/1",
        "status": "ok",
        "kind": phantom.shape.as_str(),
        "output": readable(output),
        "dims": meta.grid.dims.to_array(),
        "spacing": meta.grid.affine.spacing(),
        "affine": affine(&meta.grid.affine),
        "stored": meta.stored.as_str(),
        "slope": meta.rescale.slope(),
        "inter": meta.rescale.inter(),
        "noise": phantom.noise,
        "seed": phantom.seed,
        "iso": phantom.shape.iso(),
        "area": truth.area_mm2,
        "volume": truth.volume_mm3,
        "euler": truth.euler,
        "seconds": seconds,
    }))
}

fn failed(phantom: &Phantom, output: &Path, error: &Error) -> Value {
    json!({
        "schema": "mcubes-phantom/1",
        "status": "failed",
        "kind": phantom.shape.as_str(),
        "output": readable(output),
        "error": { "kind": error.kind().as_str(), "message": error.to_string(), "hint": error.hint() },
    })
}
