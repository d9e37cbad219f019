//! What `info` and reports say of a volume.

use std::io::Write;

use super::{plain, volume};
use crate::nifti_hostile::small;
use crate::support::sandbox::{Sandbox, object};

/// A volume whose slices lean: the sform's k steps by 1 along y and along z.
fn leaning() -> Vec<u8> {
    let mut bytes = small(1);
    bytes[304..308].copy_from_slice(&1_f32.to_le_bytes());
    bytes
}

#[test]
fn the_tilt_of_a_sheared_affine_is_told() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path("lean.nii"), leaning()).unwrap();
    let output = sandbox.run(&["info", "lean.nii", "--json"]);
    let told = [
        object(&output)["volumes"][0]["tilt"].as_f64(),
        sandbox.ends(0, "lean.nii --iso 500 -o x.stl --json").1[0]["tilt"].as_f64(),
    ];
    for tilt in told {
        assert!((tilt.unwrap() - 45.0).abs() < 1e-9, "{told:?}");
    }
    let text = |path: &str| String::from_utf8(sandbox.run(&["info", path]).stdout).unwrap();
    assert!(text("lean.nii").contains("tilt         45.00 degrees"), "{}", text("lean.nii"));
    assert!(!text(&plain()).contains("tilt"));
    let output = sandbox.run(&["info", &volume("dicom/good-series"), "--series", "1", "--json"]);
    assert_eq!(object(&output)["volumes"][0]["tilt"], 0.0);
}

#[test]
fn what_only_the_end_of_a_stream_shows_is_told() {
    let sandbox = Sandbox::new();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(&[small(1), vec![0; 7]].concat()).unwrap();
    let bytes = [gzip.finish().unwrap(), b"and more".to_vec()].concat();
    std::fs::write(sandbox.path("tail.nii.gz"), bytes).unwrap();
    let report = object(&sandbox.run(&["info", "tail.nii.gz", "--json"]));
    let notes = report["volumes"][0]["notes"].to_string();
    let text = String::from_utf8(sandbox.run(&["info", "tail.nii.gz"]).stdout).unwrap();
    for note in ["7 bytes after the last sample", "8 bytes after the end of the gzip stream"] {
        assert_eq!((notes.matches(note).count(), text.matches(note).count()), (1, 1), "{text}");
    }
}

#[test]
fn values_at_the_ends_of_all_numbers_stay_numbers() {
    let sandbox = Sandbox::new();
    for values in [[-1.7e308, 1.7e308], [0.0, 1.7e308]] {
        let bytes: Vec<u8> =
            (0..64).flat_map(|n| f64::to_le_bytes(values[usize::from(n > 20)])).collect();
        std::fs::write(sandbox.path("far.raw"), bytes).unwrap();
        let args = ["info", "far.raw", "--dims", "4x4x4", "--type", "f64"];
        let text = String::from_utf8(sandbox.run(&args).stdout).unwrap();
        assert!(text.contains("range") && !text.contains("inf") && !text.contains("NaN"), "{text}");
        let (_, reported) =
            sandbox.ends(0, "far.raw --dims 4x4x4 --type f64 --iso auto -o x.stl --json");
        assert!(reported[0]["iso"].as_f64().is_some(), "{}", reported[0]);
    }
}

#[test]
fn samples_that_are_infinite_or_nan_are_counted() {
    let sandbox = Sandbox::new();
    let samples =
        [0.5_f32, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NAN, 2.5, 0.0];
    let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(sandbox.path("a.raw"), bytes).unwrap();
    let output = sandbox.run(&["info", "a.raw", "--dims", "2x2x2", "--type", "f32"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for line in ["  range        0 to 2.5", "  NaN          1 sample", "  infinite     3 samples"] {
        assert!(text.lines().any(|of_text| of_text == line), "{line}: {text}");
    }
}
