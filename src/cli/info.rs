//! `mcubes info`: what an input holds.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::args::InfoArgs;
use super::input::{self, Opening};
use super::options::{self, Input, Reading, reading};
use super::report::{affine, failed};
use super::study;
use super::term::Term;
use super::usage::Usage;
use crate::cancel::Cancel;
use crate::error::{Error, Kind, readable};
use crate::geom::orientation;
use crate::source::{self, Content, dicom, grouped};
use crate::volume::{Meta, Note, Survey};

/// One volume: its facts, and its values where they were looked at.
struct Listed {
    meta: Meta,
    survey: Option<Survey>,
    is_default: bool,
}

impl Listed {
    /// What the header gave rise to, and what the samples did.
    fn notes(&self) -> impl Iterator<Item = &Note> {
        self.meta.notes.iter().chain(self.survey.iter().flat_map(|survey| &survey.notes))
    }
}

/// What an input holds.
enum Shown {
    /// DICOM, of which only headers were read.
    Study(Box<dicom::Study>),
    Volumes(Vec<Listed>),
}

/// Describes each input in turn.
pub(crate) fn run(args: &InfoArgs, term: Term, cancel: &Cancel) -> Result<Result<(), Kind>, Usage> {
    let reading = reading(&args.reading)?;
    let inputs: Vec<(&PathBuf, Input)> = args
        .inputs
        .iter()
        .map(|path| Ok((path, options::source(path.clone(), &reading)?)))
        .collect::<Result<_, Usage>>()?;
    let opening = Opening { term, cancel: cancel.clone(), threads: None };
    let mut result = Ok(());
    for (path, input) in inputs {
        match look(&input, &reading, &opening) {
            Ok(shown) => {
                let told = match shown {
                    Shown::Study(study) if args.json => Term::json(&study::object(path, &study)),
                    Shown::Study(study) => Term::text(&study::text(path, &study)),
                    Shown::Volumes(volumes) if args.json => Term::json(&object(path, &volumes)),
                    Shown::Volumes(volumes) => Term::text(&text(path, &volumes)),
                };
                result = told.and(result);
            }
            Err(error) => {
                Term::error(&error);
                if args.json {
                    let input = readable(path);
                    Term::json(&failed("mcubes-info/1", &input, &(&error).into())).ok();
                }
                result = Err(error.kind());
                if error.kind() == Kind::Interrupted {
                    break;
                }
            }
        }
    }
    Ok(result)
}

fn look(input: &Input, reading: &Reading, opening: &Opening) -> Result<Shown, Error> {
    let path = match input {
        Input::Path(path) => path.as_path(),
        Input::Stdin => Path::new("standard input"),
    };
    let is_dicom = reading.raw.is_none()
        && matches!(source::sniff(path)?, Content::Folder | Content::Dicom | Content::Zip);
    if is_dicom && reading.series.is_none() {
        let study = input::study(path, opening)?;
        if study.volumes.is_empty() {
            study.default()?;
        }
        return Ok(Shown::Study(Box::new(study)));
    }
    let volume = input::open(input, reading, opening)?;
    let (meta, number) = (volume.meta.clone(), volume.meta.volume_number);
    let survey = source::survey(volume, &opening.cancel).map_err(|e| Error::at(path, e))?;
    let is_alone = is_dicom || reading.raw.is_some();
    let metas = if is_alone { vec![meta] } else { source::volumes_beside(&meta) };
    let listed = |meta: Meta| Listed {
        is_default: meta.volume_number == number,
        survey: (meta.volume_number == number).then(|| survey.clone()),
        meta,
    };
    Ok(Shown::Volumes(metas.into_iter().map(listed).collect()))
}

fn object(path: &Path, volumes: &[Listed]) -> Value {
    let volumes: Vec<Value> = volumes.iter().map(volume_object).collect();
    json!({ "schema": "mcubes-info/1", "input": readable(path), "volumes": volumes })
}

fn volume_object(listed: &Listed) -> Value {
    let meta = &listed.meta;
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
        "series_number": series.and_then(|s| s.number.as_ref()),
        "description": series.and_then(|s| s.description.as_ref()).or(meta.description.as_ref()),
        "images": series.map(|s| s.n_images),
        "tilt": meta.tilt_degrees(),
        "gaps": meta.gaps_mm,
        "transfer_syntax": series.map(dicom::syntax_names),
        "suggested": suggested,
        "problem": Value::Null,
        "notes": listed.notes().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn text(path: &Path, volumes: &[Listed]) -> String {
    let mut out = format!("{}\n", readable(path));
    for listed in volumes {
        // Writing to a string cannot fail.
        let _ = describe(&mut out, listed, volumes.len());
    }
    out
}

fn describe(out: &mut String, listed: &Listed, of: usize) -> std::fmt::Result {
    let meta = &listed.meta;
    if of > 1 {
        writeln!(out, "volume {} of {of}", meta.volume_number)?;
        if listed.survey.is_none() {
            return Ok(());
        }
    }
    if meta.series.is_some() {
        let words = [meta.modality.as_deref(), meta.description.as_deref()];
        let words: Vec<&str> = words.into_iter().flatten().collect();
        writeln!(out, "  series       {}: {}", meta.volume_number, words.join(", "))?;
    }
    let [nx, ny, nz] = meta.grid.dims.to_array();
    let [sx, sy, sz] = meta.grid.affine.spacing();
    writeln!(out, "  format       {}, {}", meta.format.as_str(), meta.stored)?;
    writeln!(out, "  size         {nx} x {ny} x {nz} samples")?;
    let [sx, sy, sz] = [sx, sy, sz].map(|mm| fixed(mm, 4));
    writeln!(out, "  spacing      {sx} x {sy} x {sz} mm")?;
    writeln!(out, "  orientation  {}", orientation(&meta.grid.affine))?;
    for row in meta.grid.affine.rows() {
        // No minus before a zero.
        let [i, j, k, origin] = row.map(|x| x + 0.0);
        let [i, j, k, origin] = [fixed(i, 5), fixed(j, 5), fixed(k, 5), fixed(origin, 4)];
        writeln!(out, "  affine       {i:>12} {j:>12} {k:>12} {origin:>12}")?;
    }
    if meta.rescale.slope() != 1.0 || meta.rescale.inter() != 0.0 {
        writeln!(
            out,
            "  rescale      {} x stored + {}",
            number(meta.rescale.slope()),
            number(meta.rescale.inter())
        )?;
    }
    if let Some(series) = &meta.series {
        writeln!(out, "  images       {}", series.n_images)?;
    }
    let tilt = meta.tilt_degrees();
    if meta.series.is_some() || tilt >= 0.005 {
        writeln!(out, "  tilt         {tilt:.2} degrees")?;
    }
    if let Some(series) = &meta.series {
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
    for note in listed.notes() {
        writeln!(out, "  note         {note}")?;
    }
    Ok(())
}

fn values(out: &mut String, survey: &Survey) -> std::fmt::Result {
    match survey.range {
        Some((low, high)) => writeln!(out, "  range        {} to {}", number(low), number(high))?,
        None => writeln!(out, "  range        no finite value")?,
    }
    for (name, n) in [("NaN", survey.n_nan), ("infinite", survey.n_infinite)] {
        if n > 0 {
            let s = if n == 1 { "" } else { "s" };
            writeln!(out, "  {name:<12} {} sample{s}", grouped(n))?;
        }
    }
    histogram(out, survey)?;
    for suggestion in survey.suggested() {
        // To six decimals, without those that say nothing.
        let iso = match suggestion.iso {
            iso if (1e-3..1e9).contains(&iso.abs()) => (iso * 1e6).round() / 1e6,
            iso => iso,
        };
        writeln!(out, "  --iso {:<10} {}", number(iso), suggestion.meaning)?;
    }
    Ok(())
}

/// A number in full, or with an exponent where that would be a row of zeros.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-5..1e12).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

/// A number with so many decimals, or with an exponent where it would not fit its column.
fn fixed(x: f64, decimals: usize) -> String {
    if x.abs() < 1e7 { format!("{x:.decimals$}") } else { format!("{x:.3e}") }
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
    // Halves, so that nothing overflows.
    let low = survey.histogram.low / 2.0;
    let step = (survey.histogram.high / 2.0 - low) / counts.len() as f64 * each as f64;
    writeln!(out, "  values from   samples, bars by the logarithm of their number")?;
    for (n, &count) in bars.iter().enumerate() {
        let length = WIDTH * (1.0 + count as f64).ln() / (1.0 + most).ln();
        let bar = "#".repeat(length.round() as usize);
        let from = 2.0 * (low + step * n as f64);
        writeln!(out, "  {:>12} |{bar:<50}| {}", fixed(from, 2), grouped(count))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{fixed, number};

    #[test]
    fn extreme_numbers_stay_short() {
        let told = [f64::MAX, -1e15, 1e-300, 0.0, 0.25, -1024.0, 1e-3].map(number);
        let short = ["1.7976931348623157e308", "-1e15", "1e-300", "0", "0.25", "-1024", "0.001"];
        assert_eq!(told, short);
        assert_eq!([1.5, -1e30, 9e6].map(|x| fixed(x, 2)), ["1.50", "-1.000e30", "9000000.00"]);
    }
}
