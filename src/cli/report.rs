//! What came of a scan: a line for people, an object for programs (`docs/json.md`).

use serde_json::{Value, json};

use super::job::{Destination, Scan, Target};
use super::level::Level;
use super::options::Extract;
use super::trouble::Trouble;
use crate::error::readable;
use crate::geom::{Affine, Space, orientation};
use crate::pipeline::Report;
use crate::source::grouped;
use crate::volume::{Meta, Note};

/// A mesh that was written.
pub(crate) struct Done {
    pub(crate) level: Level,
    /// The real value that it came to.
    pub(crate) iso: f64,
    pub(crate) output: Destination,
    pub(crate) meta: Meta,
    pub(crate) report: Report,
    pub(crate) notes: Vec<Note>,
    pub(crate) total_seconds: f64,
}

impl Done {
    pub(crate) fn summary(&self, options: &Extract) -> String {
        let Report { n_vertices, n_triangles, measure, .. } = &self.report;
        // Voxel coordinates have no unit.
        let (square, cubic) = match options.space {
            Space::Voxel => ("", ""),
            Space::Ras | Space::Lps => (" mm²", " mm³"),
        };
        let to = match &self.output {
            Destination::File(path) => format!("{}: ", readable(path)),
            Destination::Stdout => String::new(),
        };
        format!(
            "{to}{} triangles, {} vertices, area {}{square}, volume {}{cubic}, {:.2} s",
            grouped(*n_triangles),
            grouped(*n_vertices),
            measured(measure.area),
            measured(measure.volume),
            self.total_seconds
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
    let Done { level, iso, output, meta, report, notes, total_seconds } = done;
    let measure = &report.measure;
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
        "tilt": meta.tilt_degrees(),
        "gaps": meta.gaps_mm,
        "stored": meta.stored.as_str(),
        // Labels have no level.
        "iso": (*level != Level::Labels).then_some(iso),
        "asked": asked(*level),
        "mask": options.mask,
        "method": options.surface.method.as_str(),
        "space": options.space.as_str(),
        "normals": options.mesh.normals,
        "output": output.shown(),
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

/// The iso value in the words it was asked for with; nothing where none was.
pub(crate) fn asked(level: Level) -> Option<String> {
    (!matches!(level, Level::Halfway | Level::Labels)).then(|| level.to_string())
}

/// The object of a mesh that is there already.
pub(crate) fn skipped(scan: &Scan, target: &Target) -> Value {
    json!({
        "schema": "mcubes/1",
        "status": "skipped",
        "input": scan.shown(),
        "asked": asked(target.level),
        "output": target.output.shown(),
    })
}

/// The object of an input that failed, in the schema of the command.
pub(crate) fn failed(schema: &str, input: &str, trouble: &Trouble) -> Value {
    let Trouble { kind, message, hint } = trouble;
    json!({
        "schema": schema,
        "status": "failed",
        "input": input,
        "error": { "kind": kind.as_str(), "message": message, "hint": hint },
    })
}

/// Four rows of four.
pub(crate) fn affine(affine: &Affine) -> Value {
    let [x, y, z] = affine.rows();
    json!([x, y, z, [0.0, 0.0, 0.0, 1.0]])
}

/// An area or a volume with as many digits as are of use.
pub(crate) fn measured(x: f64) -> String {
    match x.abs() {
        big if (1e4..1e15).contains(&big) => {
            let sign = if x < 0.0 { "-" } else { "" };
            format!("{sign}{}", grouped(big.round() as u64))
        }
        middle if (1.0..1e4).contains(&middle) => format!("{x:.2}"),
        _ => format!("{x:.4e}"),
    }
}
