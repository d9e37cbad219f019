//! `mcubes info`: what an input holds.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::args::InfoArgs;
use super::input;
use super::options::{Reading, Usage, is_dash, reading};
use super::report::{affine, failed};
use super::term::Term;
use crate::cancel::Cancel;
use crate::error::{Error, Kind};
use crate::geom::orientation;
use crate::source::{self, Content, dicom};
use crate::volume::{Meta, Survey};

/// One volume: its facts, and its values where they were looked at.
struct Listed {
    meta: Option<Meta>,
    survey: Option<Survey>,
    is_default: bool,
    title: Option<String>,
    problem: Option<String>,
}

/// Describes each input in turn.
pub(crate) fn run(args: &InfoArgs, cancel: &Cancel) -> Result<Result<(), Kind>, Usage> {
    let reading = reading(&args.reading)?;
    if args.inputs.iter().any(|input| is_dash(input)) {
        return Err(Usage::new("info reads files, not standard input")
            .hint("save it to a file first; ./- names a file"));
    }
    let mut result = Ok(());
    for path in &args.inputs {
        match list(path, &reading, cancel) {
            Ok(volumes) => {
                let told = if args.json {
                    Term::json(&object(path, &volumes))
                } else {
                    Term::text(&text(path, &volumes))
                };
                result = told.and(result);
            }
            Err(error) => {
                Term::error(&error);
                if args.json {
                    let input = path.display().to_string();
                    Term::json(&failed("mcubes-info/1", &input, &(&error).into())).ok();
                }
                result = Err(error.kind());
            }
        }
    }
    Ok(result)
}

fn list(path: &Path, reading: &Reading, cancel: &Cancel) -> Result<Vec<Listed>, Error> {
    let is_dicom = reading.raw.is_none()
        && matches!(source::sniff(path)?, Content::Folder | Content::Dicom | Content::Zip);
    if is_dicom && reading.series.is_none() {
        let options = dicom::ScanOptions { cancel: cancel.clone(), progress: None };
        let study = dicom::scan(path, &options)?;
        let default = study.default();
        if study.volumes.is_empty() {
            default?;
            return Ok(Vec::new());
        }
        let default = default.ok();
        return Ok(study
            .volumes
            .iter()
            .enumerate()
            .map(|(index, volume)| Listed {
                meta: volume.meta.clone(),
                survey: None,
                is_default: default == Some(index),
                title: Some(volume.title()),
                problem: volume.problem.as_ref().map(ToString::to_string),
            })
            .collect());
    }
    let volume = input::open(path, reading, cancel)?;
    let (meta, number) = (volume.meta.clone(), volume.meta.volume_number);
    let survey = source::survey(volume).map_err(|e| Error::at(path, e))?;
    let metas = if is_dicom || reading.raw.is_some() { vec![meta] } else { source::volumes(path)? };
    Ok(metas
        .into_iter()
        .map(|meta| Listed {
            is_default: meta.volume_number == number,
            survey: (meta.volume_number == number).then(|| survey.clone()),
            meta: Some(meta),
            title: None,
            problem: None,
        })
        .collect())
}

fn object(path: &Path, volumes: &[Listed]) -> Value {
    let volumes: Vec<Value> =
        volumes.iter().enumerate().map(|(n, v)| volume_object(n, v)).collect();
    json!({ "schema": "mcubes-info/1", "input": path.display().to_string(), "volumes": volumes })
}

fn volume_object(index: usize, listed: &Listed) -> Value {
    let Some(meta) = &listed.meta else {
        return json!({
            "number": index + 1, "default": false, "title": listed.title, "problem": listed.problem,
        });
    };
    let series = meta.series.as_ref();
    let suggested = listed.survey.as_ref().map(|survey| {
        let each = survey.suggested();
        each.iter().map(|s| json!({ "iso": s.iso, "meaning": s.meaning })).collect::<Vec<_>>()
    });
    json!({
        "number": meta.volume_number,
        "default": listed.is_default,
        "format": meta.format.as_str(),
        "dims": meta.grid.dims.to_array(),
        "spacing": meta.grid.affine.spacing(),
        "affine": affine(&meta.grid.affine),
        "orientation": orientation(&meta.grid.affine),
        "stored": meta.stored.as_str(),
        "slope": meta.rescale.slope(),
        "inter": meta.rescale.inter(),
        "range": listed.survey.as_ref().and_then(|s| s.range).map(|(low, high)| [low, high]),
        "modality": meta.modality,
        "series_uid": series.map(|s| &s.uid),
        "description": series.and_then(|s| s.description.as_ref()).or(meta.description.as_ref()),
        "images": series.map(|s| s.n_images),
        "tilt": series.map_or(0.0, |s| s.tilt_degrees),
        "gaps": meta.gaps_mm,
        "transfer_syntax": series.map(dicom::syntax_names),
        "suggested": suggested,
        "problem": listed.problem,
        "notes": meta.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn text(path: &Path, volumes: &[Listed]) -> String {
    let mut out = format!("{}\n", path.display());
    for listed in volumes {
        // Writing to a string cannot fail.
        let _ = describe(&mut out, listed, volumes.len());
    }
    out
}

fn describe(out: &mut String, listed: &Listed, of: usize) -> std::fmt::Result {
    if let Some(title) = &listed.title {
        let mark =
            if listed.is_default { "  <- meshed unless --series says otherwise" } else { "" };
        writeln!(out, "volume {title}{mark}")?;
    }
    if let Some(problem) = &listed.problem {
        writeln!(out, "  not meshed   {problem}")?;
    }
    let Some(meta) = &listed.meta else { return Ok(()) };
    if listed.title.is_none() && of > 1 {
        writeln!(out, "volume {} of {of}", meta.volume_number)?;
        if listed.survey.is_none() {
            return Ok(());
        }
    }
    let [nx, ny, nz] = meta.grid.dims.to_array();
    let [sx, sy, sz] = meta.grid.affine.spacing();
    writeln!(out, "  format       {}, {}", meta.format.as_str(), meta.stored)?;
    writeln!(out, "  size         {nx} x {ny} x {nz} samples")?;
    writeln!(out, "  spacing      {sx:.4} x {sy:.4} x {sz:.4} mm")?;
    writeln!(out, "  orientation  {}", orientation(&meta.grid.affine))?;
    for row in meta.grid.affine.rows() {
        writeln!(
            out,
            "  affine       {:12.5} {:12.5} {:12.5} {:12.4}",
            row[0], row[1], row[2], row[3]
        )?;
    }
    if meta.rescale.slope() != 1.0 || meta.rescale.inter() != 0.0 {
        writeln!(
            out,
            "  rescale      {} x stored + {}",
            meta.rescale.slope(),
            meta.rescale.inter()
        )?;
    }
    if let Some(series) = &meta.series {
        writeln!(out, "  images       {}", series.n_images)?;
        writeln!(out, "  tilt         {:.2} degrees", series.tilt_degrees)?;
        writeln!(out, "  compression  {}", dicom::syntax_names(series))?;
    }
    if let Some(gaps) = &meta.gaps_mm {
        let (low, high) =
            gaps.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), &g| (l.min(g), h.max(g)));
        writeln!(out, "  gaps         uneven, {low:.3} to {high:.3} mm")?;
    }
    if let Some(survey) = &listed.survey {
        values(out, survey)?;
    }
    for note in &meta.notes {
        writeln!(out, "  note         {note}")?;
    }
    Ok(())
}

fn values(out: &mut String, survey: &Survey) -> std::fmt::Result {
    match survey.range {
        Some((low, high)) => writeln!(out, "  range        {low} to {high}")?,
        None => writeln!(out, "  range        no finite value")?,
    }
    if survey.n_nan > 0 {
        writeln!(out, "  NaN          {} samples", survey.n_nan)?;
    }
    histogram(out, survey)?;
    for suggestion in survey.suggested() {
        writeln!(out, "  --iso {:<10.6} {}", suggestion.iso, suggestion.meaning)?;
    }
    Ok(())
}

/// Sixteen bars, their lengths by the logarithm of the counts.
fn histogram(out: &mut String, survey: &Survey) -> std::fmt::Result {
    const N_BARS: usize = 16;
    const WIDTH: f64 = 50.0;
    let counts = &survey.histogram.counts;
    if counts.len() < 2 {
        return Ok(());
    }
    let each = counts.len().div_ceil(N_BARS);
    let bars: Vec<u64> = counts.chunks(each).map(|c| c.iter().sum()).collect();
    let most = bars.iter().copied().max().unwrap_or(1).max(1) as f64;
    let step = (survey.histogram.high - survey.histogram.low) / counts.len() as f64 * each as f64;
    for (n, &count) in bars.iter().enumerate() {
        let length = WIDTH * (1.0 + count as f64).ln() / (1.0 + most).ln();
        let bar = "#".repeat(length.round() as usize);
        let from = survey.histogram.low + step * n as f64;
        writeln!(out, "  {from:>12.2} |{bar:<50}| {count}")?;
    }
    Ok(())
}
