//! `mcubes check`: whether meshes keep the promise.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::args::CheckArgs;
use super::report::{failed, measured};
use super::term::Term;
use crate::error::{Kind, readable};
use crate::mesh::{Defects, Topology};
use crate::reader;
use crate::source::grouped;

/// Looks at each mesh in turn; an error where one cannot be read or has a defect.
pub(crate) fn run(args: &CheckArgs) -> Result<(), Kind> {
    let mut result = Ok(());
    for path in &args.meshes {
        match reader::read(path) {
            Ok(mesh) => {
                let topology = mesh.topology();
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
            }
        }
    }
    result
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
