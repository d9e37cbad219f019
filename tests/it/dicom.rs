//! DICOM: what pydicom and SimpleITK see in a folder is what comes out.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeMap;
use std::path::Path;

use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use mcubes::source::{Planes, Volume};
use mcubes::volume::{Rescale, Sample};
use mcubes::with_planes;
use serde_json::Value;

use crate::support::{repository, scans};

/// All real values of a volume, plane after plane.
pub(crate) fn values(volume: Volume<'_>) -> Result<Vec<f64>, String> {
    fn read<T: Sample>(
        planes: Planes<'_, T>,
        [nx, ny, nz]: [usize; 3],
        rescale: Rescale,
    ) -> Result<Vec<f64>, String> {
        let Planes::Positioned(planes) = planes else { return Err("not positioned".to_owned()) };
        let mut all = Vec::new();
        let mut plane = ndarray::Array2::from_elem((ny, nx), T::default());
        for k in 0..nz {
            planes.read_plane(k, plane.view_mut()).map_err(|e| e.to_string())?;
            all.extend(plane.iter().map(|v| rescale.real(v.to_f64())));
        }
        Ok(all)
    }
    let (dims, rescale) = (volume.meta.grid.dims.to_array(), volume.meta.rescale);
    with_planes!(volume.planes, planes => read(planes, dims, rescale))
}

fn scan(path: &Path) -> Result<Study, mcubes::Error> {
    dicom::scan(path, &ScanOptions::default())
}

fn crc(values: &[f64]) -> String {
    let mut hasher = crc32fast::Hasher::new();
    for v in values {
        hasher.update(&v.to_le_bytes());
    }
    format!("{:08x}", hasher.finalize())
}

fn expected(path: &Path) -> BTreeMap<String, Value> {
    let all: Value = serde_json::from_slice(&std::fs::read(path).expect("read")).expect("JSON");
    let items = all["items"].as_object().expect("items").clone();
    items.into_iter().collect()
}

fn float(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The differences between one volume and what is expected of it.
fn differences(
    study: &Study,
    index: usize,
    expected: &Value,
    tolerance: Option<f64>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    let candidate = &study.volumes[index];
    let volume = match study.open(index, &OpenOptions { span_gaps: true }) {
        Ok(volume) => volume,
        Err(e) => return vec![format!("does not open: {e}")],
    };
    let dims = [&expected["cols"], &expected["rows"], &expected["slices"]]
        .map(|v| v.as_u64().unwrap_or(0) as usize);
    if candidate.dims != dims {
        wrong.push(format!("dims {:?}, expected {dims:?}", candidate.dims));
    }
    let affine = volume.meta.grid.affine;
    for (r, row) in affine.rows().iter().enumerate() {
        for (c, &found) in row.iter().enumerate() {
            let wanted = float(&expected["affine_ras"][r][c]);
            if (found - wanted).abs() > 2e-6 {
                wrong.push(format!("affine [{r}][{c}] {found}, expected {wanted}"));
            }
        }
    }
    if let Some(wanted) = expected["tilt_degrees"].as_f64()
        && (candidate.series.tilt_degrees - wanted).abs() > 1e-3
    {
        wrong.push(format!("tilt {}, expected {wanted}", candidate.series.tilt_degrees));
    }
    if let Some(even) = expected["even"].as_bool() {
        if volume.meta.gaps_mm.is_none() != even {
            wrong.push(format!("even {}, expected {even}", !even));
        } else if let Some(gaps) = &volume.meta.gaps_mm {
            let wanted: Vec<f64> =
                expected["gaps_mm"].as_array().expect("gaps").iter().map(float).collect();
            let off = gaps.iter().zip(&wanted).any(|(a, b)| (a - b).abs() > 1e-4);
            if off || gaps.len() != wanted.len() {
                wrong.push(format!("gaps {gaps:?}, expected {wanted:?}"));
            }
        }
    }
    let order: Vec<Value> = study
        .slices(index)
        .into_iter()
        .map(
            |(name, frame)| {
                if expected["order"][0].is_u64() { Value::from(frame) } else { Value::from(name) }
            },
        )
        .collect();
    if Some(&order) != expected["order"].as_array() {
        wrong.push(format!("order {order:?}, expected {}", expected["order"]));
    }
    let values = match values(volume) {
        Ok(values) => values,
        Err(e) => {
            wrong.push(format!("does not read: {e}"));
            return wrong;
        }
    };
    if let Some(wanted) = expected["crc32_f64"].as_str() {
        let found = crc(&values);
        if found != wanted {
            wrong.push(format!("checksum {found}, expected {wanted}"));
        }
    } else {
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let (low, high) = (float(&expected["min"]), float(&expected["max"]));
        let t = tolerance.unwrap_or(0.02 * (high - low));
        let far = (min - low).abs() > t || (max - high).abs() > t;
        if far || (mean - float(&expected["mean"])).abs() > t / 10.0 {
            wrong.push(format!("{min} to {max}, mean {mean}, expected {expected}"));
        }
    }
    wrong
}

#[test]
#[ignore = "needs the whole collection of scans in MCUBES_SCANS"]
fn every_folder_gives_what_pydicom_and_simpleitk_see() {
    check(&scans().join("dicom"), &expected(&scans().join("expected-dicom.json")));
}

#[test]
fn the_small_copies_give_what_pydicom_and_simpleitk_see() {
    let root = repository("testdata/dicom");
    check(&root, &expected(&root.join("expected.json")));
}

fn check(root: &Path, items: &BTreeMap<String, Value>) {
    let mut wrong = Vec::new();
    for (path, item) in items {
        let full = root.join(path);
        let expect = item["expect"].as_str().expect("expect");
        let study = scan(&full);
        let default = &item["default"];
        let chosen = study.as_ref().ok().and_then(|s| Some((s, s.default().ok()?)));
        let opened = chosen.filter(|(s, i)| s.open(*i, &OpenOptions::default()).is_ok());
        let report = match (&study, opened) {
            (Err(e), _) => format!("{e}"),
            (Ok(s), None) => match s.default().and_then(|i| s.open(i, &OpenOptions::default())) {
                Err(e) => format!("{e}"),
                Ok(_) => "ok".to_owned(),
            },
            (Ok(s), Some((_, i))) => format!(
                "{} | {:?}",
                s.volumes[i].title(),
                s.volumes[i].meta.as_ref().map(|m| &m.notes)
            ),
        };
        eprintln!("{expect:14} {path}: {report}");
        if matches!(expect, "mesh" | "mesh-warn" | "choose") && opened.is_none() {
            wrong.push(format!("{path}: {report}"));
            continue;
        }
        let Some((study, index)) = opened else { continue };
        let meta = study.volumes[index].meta.as_ref().expect("facts");
        let said: Vec<String> = meta.notes.iter().map(ToString::to_string).collect();
        let warned = said.iter().any(|n| !n.contains("double image"));
        let choice = study.choice(index).is_some();
        let as_expected = match expect {
            "mesh" => !warned && !choice,
            "mesh-warn" => warned,
            // A study on its own has a choice of volumes.
            "choose" => choice || study.volumes.len() == 1,
            _ => true,
        };
        if !as_expected {
            wrong.push(format!("{path}: {expect}, but said {said:?}, choice {choice}"));
        }
        if default.is_null() {
            if expect == "error"
                && let Ok(_) = study
                    .open(index, &OpenOptions::default())
                    .map_err(|e| e.to_string())
                    .and_then(values)
            {
                wrong.push(format!("{path}: should be refused"));
            }
            continue;
        }
        let series = &item["series"][default["series"].as_u64().unwrap_or(0) as usize];
        let volume = &series["volumes"][default["volume"].as_u64().unwrap_or(0) as usize];
        let found = differences(study, index, volume, item["lossy_tolerance"].as_f64());
        if !found.is_empty() && expect != "any" {
            wrong.push(format!("{path}: {found:?}"));
        } else if !found.is_empty() {
            eprintln!("   differs (any): {found:?}");
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
