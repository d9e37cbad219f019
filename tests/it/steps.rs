//! Crop, blur, downsample, masks and phantoms, as typed.

use std::path::Path;

use assert_cmd::Command;
use mcubes::geom::{Affine, Dims, Place, Space};
use mcubes::pipeline::{RunOptions, SurfaceOptions, extract};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions, Sink};
use mcubes::source::{blur, downsample, formula};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::repository;

const HEAD: &str = "testdata/ct_head.nii.gz";

fn mcubes() -> Command {
    let mut command = Command::cargo_bin("mcubes").unwrap();
    command.env("NO_COLOR", "1").current_dir(repository("."));
    command
}

/// What is said of a command that ends with `status`.
fn said(arguments: &[&str], status: i32) -> String {
    let output = mcubes().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {output:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// The mesh and the report of a command that is to succeed.
fn meshed(arguments: &[&str]) -> (Vec<u8>, Value) {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("mesh.stl");
    let output = mcubes().args(arguments).args(["-q", "--json", "-o"]).arg(&out).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {output:?}");
    (std::fs::read(out).unwrap(), serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn steps_that_mean_nothing_are_wrong_use() {
    for (option, value, message) in [
        ("--crop", "2:2,0:1,0:1", "the range 2:2 is empty"),
        ("--crop", "0:1,5:2,0:1", "the range 5:2 is empty"),
        ("--crop", "0:1,0:1", "expected three ranges, found 2"),
        ("--crop", "0:1,0:1,3", "\"3\" is not a range FROM:TO"),
        ("--crop", "0.5:1,0:1,0:1", "\"0.5\" is not an index"),
        ("--crop-mm", "-1:-2,0:1,0:1", "the range -1:-2 is backward"),
        ("--crop-mm", "0:nan,0:1,0:1", "\"nan\" is not a finite number"),
        ("--crop-mm", "0:inf,0:1,0:1", "\"inf\" is not a finite number"),
        ("--blur", "-1", "must not be below 0"),
        ("--blur", "nan", "not a finite number"),
        ("--downsample", "0", "not a whole number of at least 1"),
        ("--downsample", "2x2", "expected three numbers, found 2"),
        ("--downsample", "1x0x1", "not a whole number of at least 1"),
        ("--downsample", "1.5", "not a whole number of at least 1"),
    ] {
        let line = said(&["missing.nii", "--iso", "1", "-o", "x.stl", option, value], 2);
        assert!(line.contains(message), "{option} {value}: {line}");
    }
    let both = ["--crop", "0:1,0:1,0:1", "--crop-mm", "0:1,0:1,0:1"];
    let both = [&["missing.nii", "--iso", "1", "-o", "x.stl"][..], &both].concat();
    assert!(said(&both, 2).contains("cannot be used with"));
}

#[test]
fn a_part_that_the_volume_does_not_have_is_a_failure_with_its_size() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("x.stl");
    let out = out.to_str().unwrap();
    for (option, value, message) in [
        ("--crop", "0:191,0:1,0:1", "crop i 0:191: the volume has i 0:190"),
        ("--crop", "0:1,0:1,95:96", "crop k 95:96: the volume has k 0:95"),
        ("--crop", "0:1,0:1,0:18446744073709551615", "the volume has k 0:95"),
        ("--crop-mm", "0:1,0:1,900:901", "the crop box does not touch the volume"),
    ] {
        let line = said(&[HEAD, "--iso", "300", "-o", out, option, value], 1);
        assert!(line.contains(message), "{option} {value}: {line}");
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }
}

#[test]
fn steps_that_change_nothing_change_no_byte() {
    let plain = meshed(&[HEAD, "--iso", "300"]).0;
    let whole = ["--crop", "0:190,0:240,0:95", "--blur", "0.001", "--downsample", "1"];
    assert!(meshed(&[&[HEAD, "--iso", "300"][..], &whole].concat()).0 == plain);
    let whole = ["--crop-mm", "-999:999,-999:999,-999:999", "--downsample", "1x1x1"];
    assert!(meshed(&[&[HEAD, "--iso", "300"][..], &whole].concat()).0 == plain);
}

/// Otsu of the file's own values, 100, is beyond all means.
#[test]
fn an_automatic_threshold_is_that_of_what_is_meshed() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("sparse.raw");
    let is_bright = |n: usize| [n, n / 16, n / 256].iter().all(|x| x % 4 == 1);
    let samples: Vec<u8> = (0..16 * 16 * 16).map(|n| if is_bright(n) { 200 } else { 0 }).collect();
    std::fs::write(&file, samples).unwrap();
    let raw = [file.to_str().unwrap(), "--dims", "16x16x16", "--type", "u8", "--iso", "auto"];
    let report = meshed(&[&raw[..], &["--downsample", "2"]].concat()).1;
    // Means are counted in bins.
    assert!((report["iso"].as_f64().unwrap() - 12.5).abs() < 0.01, "{report}");
    assert_eq!(meshed(&raw).1["iso"], 100.0);
}

#[test]
fn a_box_in_millimetres_is_the_least_box_of_samples_around_it_in_the_outputs_space() {
    // The head's i and j run left and posterior: x = 91.855 - 1.01 i, y = 117.215 - 1.01 j.
    let samples = meshed(&[HEAD, "--iso", "300", "--crop", "60:121,40:102,20:61"]);
    let x = format!("{}:{}", 91.855 - 1.01 * 119.5, 91.855 - 1.01 * 60.5);
    let y = format!("{}:{}", 117.215 - 1.01 * 100.9, 117.215 - 1.01 * 40.2);
    let ras = meshed(&[HEAD, "--iso", "300", "--crop-mm", &format!("{x},{y},0:99")]);
    assert_eq!(ras.1["dims"], serde_json::json!([61, 62, 41]));
    assert!(ras.0 == samples.0);
    let voxels = ["--space", "voxel", "--crop-mm", "60.5:119.5,40.2:100.9,20:59.6"];
    let voxel = meshed(&[&[HEAD, "--iso", "300"][..], &voxels].concat());
    assert_eq!(voxel.1["dims"], ras.1["dims"]);
    // Indices stay those of the whole volume.
    let low = voxel.1["bounds"][0].as_array().unwrap();
    assert!(
        low.iter().zip([60.0, 40.0, 20.0]).all(|(v, least)| v.as_f64().unwrap() > least - 0.01)
    );
    let lps = format!("{},{},0:99", "4.735:30.75", "-76.6:-15.4");
    let lps = meshed(&[HEAD, "--iso", "300", "--space", "lps", "--crop-mm", &lps]);
    assert_eq!(lps.1["bounds"][0][2], ras.1["bounds"][0][2]);
}

#[test]
fn blocks_larger_than_the_volume_are_the_whole_volume() {
    let (_, report) = meshed(&[HEAD, "--iso", "-2000", "--downsample", "100000"]);
    assert_eq!((&report["dims"], &report["triangles"]), (&serde_json::json!([1, 1, 1]), &8.into()));
    let huge = ["--downsample", "9223372036854775807x1x95"];
    let (_, report) = meshed(&[&[HEAD, "--iso", "-2000"][..], &huge].concat());
    assert_eq!(report["dims"], serde_json::json!([1, 240, 1]));
}

#[test]
fn a_part_of_a_gzipped_file_is_verified_to_the_end() {
    let folder = TempDir::new().unwrap();
    let cut = folder.path().join("cut.nii.gz");
    let bytes = std::fs::read(repository(HEAD)).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() - 4]).unwrap();
    let out = folder.path().join("x.stl");
    let (cut, out) = (cut.to_str().unwrap(), out.to_str().unwrap());
    let line = said(&[cut, "--iso", "300", "--crop", "0:190,0:240,0:9", "-o", out], 1);
    assert!(line.starts_with("error: "), "{line}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}

/// A raw volume of 12 x 10 x 8 with a box of `value` in the middle.
fn raw(folder: &Path, value: u8) -> Vec<String> {
    let path = folder.join("box.raw");
    let samples: Vec<u8> = (0..960)
        .map(|n| (n % 12, n / 12 % 10, n / 120))
        .map(|(i, j, k)| {
            let inside = (3..9).contains(&i) && (3..7).contains(&j) && (2..6).contains(&k);
            if inside { value } else { 0 }
        })
        .collect();
    std::fs::write(&path, samples).unwrap();
    let words = [path.to_str().unwrap(), "--dims", "12x10x8", "--type", "u8"];
    words.map(str::to_owned).to_vec()
}

#[test]
fn a_volume_of_two_values_is_meshed_at_the_half_whatever_is_done_to_it() {
    let folder = TempDir::new().unwrap();
    let input = raw(folder.path(), 7);
    let input: Vec<&str> = input.iter().map(String::as_str).collect();
    for steps in [
        &[][..],
        &["--invert"],
        &["--open"],
        &["--blur", "0.8"],
        &["--downsample", "2"],
        &["--crop", "1:9,0:10,0:8", "--blur", "0.5", "--downsample", "1x2x2", "--space", "voxel"],
    ] {
        let (mesh, report) = meshed(&[&input[..], steps].concat());
        assert_eq!(report["iso"], 3.5, "{steps:?}");
        assert!(report["notes"][0].as_str().unwrap().contains("meshed at the half"));
        assert!(meshed(&[&input[..], steps, &["--iso", "3.5"]].concat()).0 == mesh, "{steps:?}");
    }
    // A part where nothing is: no second value.
    let out = folder.path().join("x.stl");
    let empty = ["--crop", "0:2,0:10,0:8", "-o", out.to_str().unwrap()];
    assert!(said(&[&input[..], &empty].concat(), 1).contains("an iso value is needed"));
}

#[test]
fn a_mask_is_taken_before_the_blur_and_the_means() {
    let folder = TempDir::new().unwrap();
    let input = raw(folder.path(), 7);
    let input: Vec<&str> = input.iter().map(String::as_str).collect();
    for steps in [&["--blur", "0.8"][..], &["--downsample", "2"], &["--open"]] {
        let labels = meshed(&[&input[..], steps, &["--mask", "9,7,-3"]].concat()).0;
        assert!(labels == meshed(&[&input[..], steps, &["--iso", "3.5"]].concat()).0, "{steps:?}");
    }
}

#[test]
fn labels_that_no_sample_has_are_said_to_be_missing() {
    let folder = TempDir::new().unwrap();
    let input = raw(folder.path(), 7);
    let input: Vec<&str> = input.iter().map(String::as_str).collect();
    let out = folder.path().join("x.stl");
    for labels in ["9", "7.5,300,-1"] {
        let missing = ["--mask", labels, "--blur", "1", "-o", out.to_str().unwrap()];
        let line = said(&[&input[..], &missing].concat(), 1);
        assert!(line.contains("no sample has one of the values asked for"), "{line}");
    }
}

#[test]
fn slices_that_are_not_in_the_box_are_not_decoded() {
    let folder = TempDir::new().unwrap();
    for file in repository("testdata/dicom/ts-jpegls").read_dir().unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    // Bytes in the midst of one slice's compressed pixels, which only decoding can find.
    let broken = folder.path().join("IM001.dcm");
    let mut bytes = std::fs::read(&broken).unwrap();
    let n = bytes.len();
    // Where JPEG begins.
    let start = bytes.windows(3).rposition(|w| w == [0xff, 0xd8, 0xff]).unwrap();
    bytes[start + 40..n - 16].fill(0xff);
    std::fs::write(&broken, bytes).unwrap();
    let out = TempDir::new().unwrap();
    let mesh = out.path().join("x.stl");
    let input = [folder.path().to_str().unwrap(), "--iso", "300", "-o", mesh.to_str().unwrap()];
    assert!(said(&input, 1).contains("IM001.dcm"));
    // It is the first or the last of 24.
    let parts = ["1:24", "0:23"].map(|k| {
        let crop = format!("4:40,4:30,{k}");
        let output = mcubes().args(input).args(["--crop", &crop]).output().unwrap();
        output.status.success()
    });
    assert!(parts[0] != parts[1], "{parts:?}");
}

#[test]
fn uneven_planes_cannot_be_blurred_but_cropped_and_downsampled() {
    let folder = repository("testdata/dicom/uneven-two-spacings");
    let folder = folder.to_str().unwrap();
    let out = TempDir::new().unwrap();
    let mesh = out.path().join("x.stl");
    let mesh = mesh.to_str().unwrap();
    let line = said(&[folder, "--iso", "300", "--blur", "1", "-o", mesh], 1);
    assert!(line.contains("the planes are not evenly spaced, so they cannot be blurred"), "{line}");
    meshed(&[folder, "--iso", "300", "--downsample", "2x2x1"]);
}

#[test]
fn a_phantom_says_what_is_true_of_it_and_can_be_read_back() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("ball.nii.gz");
    let file = path.to_str().unwrap();
    let kind = ["phantom", "sphere", "--dims", "30x40x50", "--spacing", "2", "--type", "f32"];
    let output = mcubes().args(kind).args(["--json", "-o", file]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    // A radius of 0.8 of half the shortest extent.
    let radius = 0.8 * 29.0;
    let wanted = 4.0 * std::f64::consts::PI * radius * radius;
    assert!((report["area"].as_f64().unwrap() / wanted - 1.0).abs() < 1e-12);
    assert_eq!((&report["schema"], &report["euler"]), (&"mcubes-phantom/1".into(), &2.into()));
    let line = String::from_utf8(output.stderr).unwrap();
    assert!(line.contains("area") && line.contains("Euler number 2"), "{line}");
    assert_eq!(meshed(&[file, "--iso", "500"]).1["dims"], report["dims"]);
    // The same bytes again, and unzipped on standard output.
    let output = mcubes().args(kind).args(["-o", "-", "--threads", "1"]).output().unwrap();
    let unzipped = folder.path().join("ball.nii");
    std::fs::write(&unzipped, output.stdout).unwrap();
    let [a, b] = [file, unzipped.to_str().unwrap()].map(|f| meshed(&[f, "--iso", "500"]).0);
    assert!(a == b);
}

#[test]
fn phantoms_that_cannot_be_are_wrong_use() {
    for (arguments, message) in [
        (&["ball", "-o", "x.nii"][..], "ball is no phantom"),
        (&["sphere", "-o", "x.stl"], "x.stl: neither .nii nor .nii.gz"),
        (&["sphere", "-o", "x.gz"], "neither .nii nor .nii.gz"),
        (&["sphere", "-o", "nowhere/x.nii"], "no such folder"),
        (&["sphere", "-o", "src"], "the output is a folder"),
        (&["sphere", "-o", "-", "--json"], "both want standard output"),
        (&["sphere"], "--output"),
        (&["sphere", "-o", "x.nii", "--dims", "0"], "at least 1"),
        (&["sphere", "-o", "x.nii", "--dims", "4x4"], "expected three numbers"),
        (&["sphere", "-o", "x.nii", "--spacing", "-1"], "must be above 0"),
        (&["sphere", "-o", "x.nii", "--noise", "nan"], "not a finite number"),
        (&["sphere", "-o", "x.nii", "--noise", "-1"], "must not be below 0"),
        (&["sphere", "-o", "x.nii", "--type", "i12"], "expected one of"),
        (&["sphere", "-o", "x.nii", "--threads", "0"], "at least 1"),
    ] {
        let line = said(&[&["phantom"][..], arguments].concat(), 2);
        assert!(line.contains(message), "{arguments:?}: {line}");
    }
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("x.nii");
    for (option, value) in [("--dims", "99999999999x9x9"), ("--spacing", "1e-42")] {
        said(&["phantom", "sphere", "-o", out.to_str().unwrap(), option, value], 1);
        assert!(!out.exists());
    }
}

#[test]
fn a_formula_is_blurred_and_downsampled_like_any_volume() {
    let dims = Dims::checked(40, 40, 40, 4).unwrap();
    let affine = Affine::from_columns([0.5, 0., 0.], [0., 0.5, 0.], [0., 0., 0.5], [-9.75; 3]);
    let field = |x: f64, y: f64, z: f64| (6.0 - (x * x + y * y + z * z).sqrt()) as f32;
    let folder = TempDir::new().unwrap();
    for sigma in [0.0, 0.4] {
        let volume = formula(dims, affine, field).unwrap();
        let volume = downsample(blur(volume, sigma).unwrap(), [2; 3]).unwrap();
        let place = Place::new(&volume.meta.grid, Space::Ras).unwrap();
        let options = MeshOptions::new(MeshFormat::Ply);
        let mut file = MeshFile::create(&folder.path().join("p.ply"), &options).unwrap();
        let surfaces: Vec<(_, &mut dyn Sink)> = vec![(SurfaceOptions::at(0.0), &mut file)];
        let report = extract(volume, &place, surfaces, &RunOptions::default()).unwrap().remove(0);
        // The step is a sixth of the radius, and means of a distance are above it: 2.2 % less.
        let wanted = 4.0 / 3.0 * std::f64::consts::PI * 216.0;
        assert!((report.measure.volume / wanted - 1.0).abs() < 0.04, "{report:?}");
    }
}
