//! What came of a scan: a line for people, an object for programs (`docs/json.md`).

use serde_json::{Value, json};

use super::options::{Extract, Output};
use crate::error::Error;
use crate::geom::{Affine, orientation};
use crate::pipeline::Report;
use crate::volume::{Meta, Note};

/// A mesh that was written.
pub(crate) struct Done {
    pub(crate) iso: f64,
    pub(crate) meta: Meta,
    pub(crate) report: Report,
    pub(crate) notes: Vec<Note>,
    pub(crate) total_seconds: f64,
}

impl Done {
    pub(crate) fn summary(&self) -> String {
        let Report { n_vertices, n_triangles, measure, .. } = &self.report;
        format!(
            "{n_triangles} triangles, {n_vertices} vertices, area {:.6e}, volume {:.6e}, {:.2} s",
            measure.area, measure.volume, self.total_seconds
        )
    }

    pub(crate) fn details(&self) -> String {
        let seconds = self.report.seconds;
        let [nx, ny, nz] = self.meta.grid.dims.to_array();
        format!(
            "{nx} x {ny} x {nz} {} samples\nread {:.3} s, mesh {:.3} s, write {:.3} s (over all threads)\n",
            self.meta.stored, seconds.read, seconds.mesh, seconds.write
        )
    }
}

/// The object of a mesh that was written.
pub(crate) fn done(input: &str, options: &Extract, done: &Done) -> Value {
    let Done { iso, meta, report, notes, total_seconds } = done;
    let measure = &report.measure;
    let output = match &options.output {
        Output::File(path) => path.display().to_string(),
        Output::Stdout => "-".to_owned(),
    };
    json!({
        "schema": "mcubes/1",
        "status": "ok",
        "input": input,
        "format": meta.format.as_str(),
        "series": meta.series.as_ref().map(|s| &s.uid),
        "volume_number": meta.volume_number,
        "modality": meta.modality,
        "dims": meta.grid.dims.to_array(),
        "spacing": meta.grid.affine.spacing(),
        "affine": affine(&meta.grid.affine),
        "orientation": orientation(&meta.grid.affine),
        "tilt": meta.series.as_ref().map_or(0.0, |s| s.tilt_degrees),
        "gaps": meta.gaps_mm,
        "stored": meta.stored.as_str(),
        "iso": iso,
        "method": "cubes",
        "space": options.space.as_str(),
        "output": output,
        "vertices": report.n_vertices,
        "triangles": report.n_triangles,
        "area": measure.area,
        "volume": measure.volume,
        "bounds": [measure.bounds.min, measure.bounds.max],
        "seconds": {
            "read": report.seconds.read,
            "mesh": report.seconds.mesh,
            "write": report.seconds.write,
            "total": total_seconds,
        },
        "notes": notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

/// The object of a scan that could not be meshed.
pub(crate) fn failed(input: &str, error: &Error) -> Value {
    json!({
        "schema": "mcubes/1",
        "status": "failed",
        "input": input,
        "error": { "kind": error.kind().as_str(), "message": error.to_string(), "hint": error.hint() },
    })
}

/// Four rows of four.
pub(crate) fn affine(affine: &Affine) -> Value {
    let [x, y, z] = affine.rows();
    json!([x, y, z, [0.0, 0.0, 0.0, 1.0]])
}
