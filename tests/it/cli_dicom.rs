//! DICOM on the command line: what is listed, what is said, and what never is.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::dicom::{SECRET, Series};
use crate::support::repository;

/// Runs in `folder`; standard output, standard error.
fn run(folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    let mut command = Command::cargo_bin("mcubes").unwrap();
    let output = command.env("NO_COLOR", "1").current_dir(folder).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{output:?}");
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr))
}

/// A study of a large axial series, a small one without one of its slices, and a lone image.
fn study() -> TempDir {
    let folder = TempDir::new().unwrap();
    let root = folder.path().join("study");
    Series { number: 7, ..Series::axial(28) }.write(&root.join("large"));
    let mut small = Series::axial(12);
    (small.uid, small.number) = ("1.2.826.0.1.3680043.9.7.2".to_owned(), 3);
    small.positions.remove(5);
    small.write(&root.join("small"));
    let mut lone = Series::axial(1);
    (lone.uid, lone.number) = ("1.2.826.0.1.3680043.9.7.3".to_owned(), 12);
    lone.write(&root.join("lone"));
    let scout = Series { image_type: "ORIGINAL\\PRIMARY\\LOCALIZER", ..lone };
    scout.write(&root.join("scout"));
    folder
}

#[test]
fn info_lists_a_study_as_a_table_of_a_hundred_columns() {
    let folder = study();
    let (out, _) = run(folder.path(), &["info", "study"], 0);
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with("study: 3 volumes; * is meshed"), "{out}");
    let cells = |line: usize| lines[line].split_whitespace().collect::<Vec<_>>();
    assert_eq!(cells(1)[..6], ["#", "ser", "mod", "description", "imgs", "size"], "{out}");
    let size = |n: usize| format!("40x36x{n}");
    let (small, large) = (size(11), size(28));
    assert_eq!(cells(2)[..6], ["1", "3", "CT", "ellipsoid", "11", &small]);
    assert_eq!(
        cells(3),
        [
            "*",
            "2",
            "7",
            "CT",
            "ellipsoid",
            "28",
            &large,
            "1.2x1.3x1.5",
            "LPS",
            "0",
            "even",
            "explicit",
            "LE"
        ]
    );
    assert!(lines[1..5].iter().all(|l| l.chars().count() <= 100), "{out}");
    assert!(out.contains("refused: volume 1: 1 slice is missing: 3.00 mm between"), "{out}");
    assert!(out.contains("refused: volume 3: a single image"), "{out}");
    assert!(out.contains("set aside: 1 localizer"), "{out}");
}

#[test]
fn info_as_json_has_all_of_each_volume() {
    let folder = study();
    let (out, _) = run(folder.path(), &["info", "study", "--json"], 0);
    let object: Value = serde_json::from_str(&out).unwrap();
    let volumes = object["volumes"].as_array().unwrap();
    assert_eq!(volumes.len(), 3);
    for key in [
        "number",
        "default",
        "format",
        "dims",
        "spacing",
        "affine",
        "orientation",
        "stored",
        "slope",
        "inter",
        "range",
        "modality",
        "series_uid",
        "description",
        "images",
        "tilt",
        "gaps",
        "transfer_syntax",
        "suggested",
        "notes",
        "problem",
    ] {
        assert!(volumes.iter().all(|v| v.get(key).is_some()), "{key}");
    }
    assert_eq!(volumes[1]["default"], true);
    assert_eq!(volumes[1]["gaps"], Value::Null);
    assert_eq!(volumes[0]["gaps"].as_array().map(Vec::len), Some(10));
    assert_eq!(volumes[2]["dims"], serde_json::json!([40, 36, 1]));
    assert_eq!(object["set_aside"][0]["what"], "localizer");
    // A volume that is asked for is looked into.
    let (out, _) = run(folder.path(), &["info", "study", "--json", "--series", "2"], 0);
    let object: Value = serde_json::from_str(&out).unwrap();
    assert!(object["volumes"][0]["range"].is_array(), "{out}");
}

#[test]
fn a_gap_is_spanned_only_when_asked_and_that_is_said() {
    let folder = study();
    let mesh = ["study", "--series", "1", "--iso", "500", "-o", "small.stl"];
    let (_, refused) = run(folder.path(), &mesh, 1);
    assert!(refused.contains("hint: copy the missing images, or --gaps span"), "{refused}");
    let (_, said) = run(folder.path(), &[&mesh[..], &["--gaps", "span"]].concat(), 0);
    assert!(said.contains("meshed across gaps as asked: 1 slice is missing"), "{said}");
}

#[test]
fn no_output_and_no_mesh_tells_who_the_patient_is() {
    let folder = study();
    std::fs::write(folder.path().join("study/cut"), &Series::axial(3).image(1, 1)[..400]).unwrap();
    for (arguments, status) in [
        (&["info", "study"][..], 0),
        (&["info", "study", "--json"], 0),
        (&["info", "study", "--series", "2"], 0),
        (&["study", "--series", "1", "--iso", "500", "-o", "small.obj"], 1),
        (&["study", "--iso", "500", "-o", "a.stl", "-v", "--json"], 0),
        (&["study", "--iso", "500", "-o", "a.ply"], 0),
        (&["study", "--iso", "500", "-o", "a.obj"], 0),
        (&["study/cut", "--iso", "500", "-o", "b.obj"], 1),
    ] {
        let (out, err) = run(folder.path(), arguments, status);
        assert!(!out.contains(SECRET) && !err.contains(SECRET), "{arguments:?}: {out}{err}");
    }
    for mesh in ["a.stl", "a.ply", "a.obj"] {
        let bytes = std::fs::read(folder.path().join(mesh)).unwrap();
        assert!(!bytes.windows(SECRET.len()).any(|w| w == SECRET.as_bytes()), "{mesh}");
    }
}

#[test]
fn info_of_standard_input_wants_to_know_what_it_is() {
    let folder = TempDir::new().unwrap();
    let (_, said) = run(folder.path(), &["info", "-"], 2);
    assert!(said.contains("--dims is missing"), "{said}");
    let mut command = Command::cargo_bin("mcubes").unwrap();
    let arguments = ["info", "-", "--dims", "2x2x2", "--type", "u8"];
    let output = command.args(arguments).write_stdin([1, 2, 3, 4, 5, 6, 7, 9]).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.contains("range        1 to 9"), "{said}");
}

#[test]
fn the_folder_for_temporary_files_is_named_where_it_is_to_blame() {
    let folder = TempDir::new().unwrap();
    // Several frames in an archive are inflated to a temporary file.
    let frames = std::fs::read(repository("testdata/dicom/enhanced-ct-shuffled.dcm")).unwrap();
    let file = std::fs::File::create(folder.path().join("frames.zip")).unwrap();
    let mut archive = zip::ZipWriter::new(file);
    archive.start_file("e.dcm", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut archive, &frames).unwrap();
    archive.finish().unwrap();
    let arguments = ["frames.zip", "--iso", "0", "-o", "x.stl"];
    run(folder.path(), &arguments, 0);
    let mut command = Command::cargo_bin("mcubes").unwrap();
    command.env("TMPDIR", "/nowhere").current_dir(folder.path()).args(arguments);
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    let wanted = "e.dcm: the temporary file in /nowhere cannot be written: there is no such folder";
    assert!(said.contains(wanted), "{said}");
}
