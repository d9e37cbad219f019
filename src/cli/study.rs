//! A DICOM study as `mcubes info` lists it: a table for people, objects for scripts.
//!
//! Says what the headers say; no samples are read here.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::report::affine;
use crate::error::readable;
use crate::geom::orientation;
use crate::source::dicom::{self, Candidate, Study};
use crate::volume::Meta;

/// The widest line of the table, in columns.
const WIDTH: usize = 100;

/// Columns that the description is given at least.
const DESCRIPTION: usize = 12;

/// Numbers of volumes named at most where several share a note.
const NUMBERS: usize = 8;

/// The study as one JSON object.
pub(crate) fn object(path: &Path, study: &Study) -> Value {
    let default = study.default().ok();
    let volumes = study.volumes.iter().enumerate();
    let volumes: Vec<Value> =
        volumes.map(|(index, volume)| volume_object(volume, default == Some(index))).collect();
    let aside: Vec<Value> = study
        .set_aside
        .iter()
        .map(|a| json!({ "what": a.what.name(1), "count": a.count, "first": a.first }))
        .collect();
    let faults: Vec<Value> = study
        .faults
        .iter()
        .map(|(name, fault)| json!({ "file": name, "problem": fault.to_string() }))
        .collect();
    json!({
        "schema": "mcubes-info/1",
        "input": readable(path),
        "volumes": volumes,
        "set_aside": aside,
        "left_out": faults,
    })
}

/// One volume of a study; what only the samples tell is null.
fn volume_object(volume: &Candidate, is_default: bool) -> Value {
    let meta = volume.meta.as_ref();
    let grid = meta.map(|m| &m.grid);
    json!({
        "number": volume.number,
        "default": is_default,
        "format": "dicom",
        "dims": volume.dims,
        "spacing": grid.map(|g| g.affine.spacing()),
        "affine": grid.map(|g| affine(&g.affine)),
        "orientation": grid.map(|g| orientation(&g.affine)),
        "stored": meta.map(|m| m.stored.as_str()),
        "slope": meta.map(|m| m.rescale.slope()),
        "inter": meta.map(|m| m.rescale.inter()),
        "range": Value::Null,
        "modality": volume.modality,
        "series_uid": volume.series.uid,
        "series_number": volume.series.number,
        "description": volume.series.description,
        "part": volume.apart,
        "images": volume.series.n_images,
        "tilt": meta.map(tilt),
        "gaps": meta.and_then(|m| m.gaps_mm.as_ref()),
        "transfer_syntax": dicom::syntax_names(&volume.series),
        "suggested": Value::Null,
        "problem": volume.problem.as_ref().map(ToString::to_string),
        "notes": meta.map_or_else(Vec::new, notes),
    })
}

/// The study as a table of at most [`WIDTH`] columns, and what else is to be said below it.
pub(crate) fn text(path: &Path, study: &Study) -> String {
    let default = study.default().ok();
    let mut out = match (study.volumes.len(), default) {
        (1, _) => format!("{}: 1 volume\n", readable(path)),
        (n, None) => format!("{}: {n} volumes, none of them fit\n", readable(path)),
        (n, Some(_)) => format!(
            "{}: {n} volumes; * is meshed unless --series chooses another\n",
            readable(path)
        ),
    };
    table(&mut out, study, default.filter(|_| study.volumes.len() > 1));
    let problems = |v: &Candidate| v.problem.iter().map(ToString::to_string).collect();
    for (problem, numbers) in shared(study, problems) {
        let s = if numbers.len() == 1 { "" } else { "s" };
        line(&mut out, &format!("refused: volume{s} {}: {problem}", listed(&numbers)));
    }
    let placed = study.volumes.iter().filter(|v| v.meta.is_some()).count();
    for (note, numbers) in shared(study, |v| v.meta.as_ref().map_or_else(Vec::new, notes)) {
        if numbers.len() == placed {
            line(&mut out, &format!("note: {note}"));
        } else {
            line(&mut out, &format!("note: volume {}: {note}", listed(&numbers)));
        }
    }
    line(&mut out, "--series N shows a volume in full and looks at its values");
    out
}

fn line(out: &mut String, text: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{text}");
}

const HEAD: [&str; 11] =
    ["", "#", "ser", "mod", "description", "imgs", "size", "spacing mm", "axes", "tilt°", "gaps"];

/// Whether a column's text stands at its right end.
const RIGHT: [bool; 11] = [false, true, true, false, false, true, true, true, false, true, true];

/// The column that gives way where the line would be too long.
const ELASTIC: usize = 4;

fn table(out: &mut String, study: &Study, default: Option<usize>) {
    let rows: Vec<([String; 11], String)> = study
        .volumes
        .iter()
        .enumerate()
        .map(|(index, volume)| {
            (cells(volume, default == Some(index)), dicom::short_syntax_names(&volume.series))
        })
        .collect();
    let mut widths = HEAD.map(|head| head.chars().count());
    for (row, _) in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let last = rows.iter().map(|(_, syntax)| syntax.len()).max().unwrap_or(0).max("pixels".len());
    let used: usize = widths.iter().sum::<usize>() + 2 * widths.len() + last;
    let too_much = used.saturating_sub(WIDTH);
    widths[ELASTIC] =
        widths[ELASTIC].saturating_sub(too_much).max(DESCRIPTION.min(widths[ELASTIC]));
    let head = HEAD.map(str::to_owned);
    put(out, &head, &widths, "pixels");
    for ((mut row, syntax), volume) in rows.into_iter().zip(&study.volumes) {
        row[ELASTIC] = description(volume, widths[ELASTIC]);
        put(out, &row, &widths, &syntax);
    }
}

fn put(out: &mut String, row: &[String; 11], widths: &[usize; 11], last: &str) {
    let mut text = String::new();
    for ((cell, &width), right) in row.iter().zip(widths).zip(RIGHT) {
        let _ =
            if right { write!(text, "{cell:>width$}  ") } else { write!(text, "{cell:<width$}  ") };
    }
    line(out, &format!("{text}{last}"));
}

/// All columns but the last; the description is whole.
fn cells(volume: &Candidate, is_default: bool) -> [String; 11] {
    let none = || "-".to_owned();
    let [nx, ny, nz] = volume.dims;
    let meta = volume.meta.as_ref();
    let spacing = |meta: &Meta| {
        let each = meta.grid.affine.spacing().map(|mm| short(mm, 3));
        each.join("x")
    };
    let gaps = |meta: &Meta| {
        let Some(gaps) = &meta.gaps_mm else { return "even".to_owned() };
        let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let most = gaps.iter().copied().fold(0.0, f64::max);
        format!("{}-{}", short(least, 2), short(most, 2))
    };
    [
        if is_default { "*" } else { "" }.to_owned(),
        volume.number.to_string(),
        volume.series.number.clone().unwrap_or_else(none),
        volume.modality.clone().unwrap_or_else(none),
        description(volume, usize::MAX),
        volume.series.n_images.to_string(),
        format!("{nx}x{ny}x{nz}"),
        meta.map_or_else(none, spacing),
        meta.map_or_else(none, |m| orientation(&m.grid.affine)),
        meta.map_or_else(none, |m| short(tilt(m), 1)),
        meta.map_or_else(none, gaps),
    ]
}

/// The series' description, and what sets the volume apart within it, which is cut last.
fn description(volume: &Candidate, width: usize) -> String {
    let own = volume.series.description.as_deref().unwrap_or_default();
    let apart = volume.apart.as_deref().unwrap_or_default();
    if own.is_empty() || apart.is_empty() {
        return cut(&format!("{own}{apart}"), width);
    }
    let room = width.saturating_sub(apart.chars().count() + 2);
    if room < 6 { cut(apart, width) } else { format!("{}, {apart}", cut(own, room)) }
}

/// At most `width` characters, the last an ellipsis where some are missing.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut kept: String = text.chars().take(width.saturating_sub(1)).collect();
    kept.push('…');
    kept
}

/// A number without the zeros that say nothing.
fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if decimals == 0 { &text } else { text.trim_end_matches('0').trim_end_matches('.') };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn tilt(meta: &Meta) -> f64 {
    meta.series.as_ref().map_or(0.0, |s| s.tilt_degrees)
}

fn notes(meta: &Meta) -> Vec<String> {
    meta.notes.iter().map(ToString::to_string).collect()
}

/// Each line once, with the numbers of the volumes that it is about.
fn shared(study: &Study, lines: impl Fn(&Candidate) -> Vec<String>) -> Vec<(String, Vec<usize>)> {
    let mut all: Vec<(String, Vec<usize>)> = Vec::new();
    for volume in &study.volumes {
        for line in lines(volume) {
            match all.iter_mut().find(|(known, _)| *known == line) {
                Some((_, numbers)) => numbers.push(volume.number),
                None => all.push((line, vec![volume.number])),
            }
        }
    }
    all
}

fn listed(numbers: &[usize]) -> String {
    let shown: Vec<String> = numbers.iter().take(NUMBERS).map(ToString::to_string).collect();
    let more = numbers.len() - shown.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_texts_are_cut_to_what_says_something() {
        assert_eq!(short(1.0, 3), "1");
        assert_eq!(short(0.451_17, 3), "0.451");
        assert_eq!(short(-0.000_1, 2), "0");
        assert_eq!(short(100.0, 0), "100");
        assert_eq!(cut("thorax", 6), "thorax");
        assert_eq!(cut("thorax", 5), "thor…");
    }
}
