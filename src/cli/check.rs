//! `mcubes check`: whether meshes keep the promise.

use std::fmt::Write;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

use super::args::CheckArgs;
use super::report::{failed, measured};
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::{Error, Kind, readable};
use crate::mesh::{Defects, Topology};
use crate::pipeline::RunError;
use crate::reader;
use crate::source::{SourceError, grouped};

/// How often a look is taken at whether the user wants to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Looks at each mesh in turn; an error where one cannot be read or has a defect.
pub(crate) fn run(args: &CheckArgs, cancel: &Cancel) -> Result<(), Kind> {
    let mut result = Ok(());
    for path in &args.meshes {
        match look(path, cancel) {
            Ok(topology) => {
                if !is_ok(&topology) {
                    result = Err(Kind::Internal);
                }
                let told = if args.json {
                    Term::json(&object(path, &topology))
                } else {
                    Term::text(&text(path, &topology))
                };
                result = told.and(result);
            }
            Err(error) => {
                Term::error(&error);
                if args.json {
                    let input = readable(path);
                    Term::json(&failed("mcubes-check/1", &input, &(&error).into())).ok();
                }
                result = Err(error.kind());
                if error.kind() == Kind::Interrupted {
                    break;
                }
            }
        }
    }
    result
}

/// Reads a mesh and measures it, on a thread of its own: neither looks at a flag. Where the user stops
/// first the thread is left behind, and ends with the process.
fn look(path: &Path, cancel: &Cancel) -> Result<Topology, Error> {
    let (send, looked_at) = sync_channel(1);
    let of = path.to_owned();
    let work = move || send.send(reader::read(&of).map(|mesh| mesh.topology()));
    let name = "mesh".to_owned();
    let thread = thread::Builder::new().name(name).spawn(work);
    thread.map_err(|e| Error::at(path, SourceError::Io(e)))?;
    loop {
        match looked_at.recv_timeout(LOOK) {
            Ok(looked_at) => return looked_at,
            Err(RecvTimeoutError::Timeout) if !cancel.is_raised() => {}
            Err(RecvTimeoutError::Timeout) => return Err(Error::at(path, RunError::Interrupted)),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::at(path, RunError::Internal("the look at a mesh ended early")));
            }
        }
    }
}

fn is_ok(topology: &Topology) -> bool {
    topology.closed
        && topology.manifold
        && topology.outward
        && topology.defects == Defects::default()
}

fn named(defects: &Defects) -> [(&'static str, u64); 9] {
    [
        ("boundary_edges", defects.boundary_edges),
        ("nonmanifold_edges", defects.nonmanifold_edges),
        ("nonmanifold_vertices", defects.nonmanifold_vertices),
        ("inconsistent_edges", defects.inconsistent_edges),
        ("zero_area_faces", defects.zero_area_faces),
        ("duplicate_faces", defects.duplicate_faces),
        ("coincident_vertices", defects.coincident_vertices),
        ("unused_vertices", defects.unused_vertices),
        ("nonfinite_vertices", defects.nonfinite_vertices),
    ]
}

fn object(path: &Path, topology: &Topology) -> Value {
    let defects: serde_json::Map<String, Value> =
        named(&topology.defects).into_iter().map(|(k, n)| (k.to_owned(), n.into())).collect();
    json!({
        "schema": "mcubes-check/1",
        "path": readable(path),
        "ok": is_ok(topology),
        "closed": topology.closed,
        "manifold": topology.manifold,
        // An open mesh has no outside.
        "outward": topology.closed.then_some(topology.outward),
        "vertices": topology.n_vertices,
        "triangles": topology.n_triangles,
        "components": topology.n_components,
        "euler": topology.euler,
        "area": topology.area,
        "volume": topology.volume,
        "defects": defects,
    })
}

fn text(path: &Path, topology: &Topology) -> String {
    let word = |yes: bool| if yes { "yes" } else { "NO" };
    let mut out = format!(
        "{}: {}\n  closed {}, manifold {}, outward {}\n  {} triangles, {} vertices, {} components, Euler number {}\n  area {}, volume {}\n",
        readable(path),
        if is_ok(topology) { "ok" } else { "NOT OK" },
        word(topology.closed),
        word(topology.manifold),
        if topology.closed { word(topology.outward) } else { "- (open)" },
        grouped(topology.n_triangles),
        grouped(topology.n_vertices),
        topology.n_components,
        topology.euler,
        measured(topology.area),
        measured(topology.volume),
    );
    for (name, n) in named(&topology.defects) {
        if n > 0 {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "  {n} {}", name.replace('_', " "));
        }
    }
    out
}
