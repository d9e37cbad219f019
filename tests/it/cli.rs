//! The command line, as typed.

use assert_cmd::Command;
use tempfile::TempDir;

use crate::support::repository;

fn mcubes() -> Command {
    let mut command = Command::cargo_bin("mcubes").unwrap();
    command.env("NO_COLOR", "1").current_dir(repository("."));
    command
}

fn stderr(command: &mut Command, status: i32) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{output:?}");
    assert!(output.stdout.is_empty(), "nothing was asked for");
    String::from_utf8(output.stderr).unwrap()
}

const HEAD: &str = "testdata/ct_head.nii.gz";

#[test]
fn wrong_use_is_exit_2_before_any_input_is_opened() {
    for (arguments, said) in [
        (&["missing.nii", "--iso", "1"][..], "-o is missing"),
        (&["missing.nii", "--iso", "1", "-o", "x.xyz"], "unknown extension .xyz"),
        (&["missing.nii", "--iso", "1", "-o", "nowhere/x.stl"], "no such folder"),
        (&[HEAD, "--iso", "1", "-o", HEAD, "--format", "stl"], "the output is the input"),
        (&["missing.nii", "--iso", "nan", "-o", "x.stl"], "not a finite number"),
        (&["missing.raw", "--iso", "1", "-o", "x.stl", "--dims", "2x2x2"], "--type is missing"),
        (&["-", "--iso", "1", "-o", "x.stl"], "--dims is missing"),
        (&[HEAD, "--iso", "1", "-o", "-", "--json"], "both want standard output"),
        (&[], "no input"),
    ] {
        let said_so = stderr(mcubes().args(arguments), 2);
        assert!(said_so.contains(said), "{arguments:?}: {said_so}");
    }
}

#[test]
fn a_failure_is_exit_1_in_one_line_and_leaves_no_file() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("x.stl");
    for (arguments, said) in [
        (&["missing.nii", "--iso", "1"][..], "missing.nii: does not exist"),
        (&[HEAD, "--iso", "9999"], "the values are -1024 to 3075"),
        (&["README.md", "--iso", "1"], "README.md"),
    ] {
        let said_so = stderr(mcubes().args(arguments).arg("-o").arg(&out), 1);
        assert!(said_so.starts_with("error: ") && said_so.contains(said), "{said_so}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn json_is_one_object_with_the_documented_keys() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("skull.ply");
    let output =
        mcubes().args([HEAD, "--iso", "300", "--json", "-q", "-o"]).arg(&out).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], "mcubes/1");
    assert_eq!(report["status"], "ok");
    assert_eq!(report["dims"], serde_json::json!([190, 240, 95]));
    let keys = "series modality spacing affine orientation tilt gaps stored iso method space output \
                vertices triangles area volume bounds seconds notes format volume_number input";
    for key in keys.split_whitespace() {
        assert!(report.get(key).is_some(), "{key}");
    }
    let output = mcubes().args(["check", "--json"]).arg(&out).output().unwrap();
    assert!(output.status.success());
    let checked: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(checked["ok"], true);
    assert_eq!(checked["triangles"], report["triangles"]);
}

#[test]
fn a_mesh_on_standard_output_is_the_file_and_threads_change_nothing() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("skull.stl");
    mcubes().args([HEAD, "--iso", "300", "--threads", "1", "-o"]).arg(&out).assert().success();
    let file = std::fs::read(&out).unwrap();
    for threads in ["2", "7"] {
        let output = mcubes()
            .args([HEAD, "--iso", "300", "-o", "-", "-q", "--threads", threads])
            .output()
            .unwrap();
        assert!(output.status.success());
        assert!(output.stdout == file, "{threads} threads");
    }
}

#[test]
fn an_open_mesh_fails_the_check() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("open.stl");
    mcubes().args([HEAD, "--iso", "300", "--open", "-o"]).arg(&out).assert().success();
    let output = mcubes().arg("check").arg(&out).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stdout).unwrap().contains("boundary edges"));
}

#[test]
fn padding_that_would_be_inside_is_no_surface() {
    let Some(folder) = crate::support::shared("dicom/synth/padding-high") else { return };
    let output = TempDir::new().unwrap();
    let out = output.path().join("x.stl");
    let report = mcubes()
        .arg(&folder)
        .args(["--iso", "300", "--json", "-q", "-o"])
        .arg(&out)
        .output()
        .unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report.stdout).unwrap();
    // Padding fills the corners of the box: a mesh that took it for bone would reach the border.
    let [low, high] =
        [&report["bounds"][0][0], &report["bounds"][1][0]].map(|v| v.as_f64().unwrap());
    let dims = report["dims"][0].as_f64().unwrap() * report["spacing"][0].as_f64().unwrap();
    assert!(high - low < dims - 2.0, "{report}");
}
