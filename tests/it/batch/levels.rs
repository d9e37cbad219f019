use super::repository;
use crate::support::sandbox::{Sandbox, with_status};

fn head() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/ct_head.nii.gz"), "head.nii.gz");
    sandbox
}

#[test]
fn each_iso_value_gives_the_mesh_of_its_own_run() {
    let sandbox = head();
    sandbox.ends(0, "head.nii.gz --iso 300 --iso -200 -o out -q");
    assert_eq!(sandbox.names("out"), ["head_iso-200.stl", "head_iso300.stl"]);
    for iso in ["300", "-200"] {
        sandbox.ends(0, &format!("head.nii.gz --iso {iso} -o alone.stl -q"));
        let name = format!("out/head_iso{iso}.stl");
        assert!(sandbox.bytes("alone.stl") == sandbox.bytes(&name), "{iso}");
    }
}

#[test]
fn an_iso_value_that_is_not_reached_does_not_take_the_others_with_it() {
    let sandbox = head();
    let (said, reported) =
        sandbox.ends(1, "head.nii.gz --iso 300 --iso 99999 --iso -200 -o out --json");
    assert_eq!(sandbox.names("out"), ["head_iso-200.stl", "head_iso300.stl"]);
    assert!(said.contains("done 2, skipped 0, failed 1, not done 0"), "{said}");
    let failed = with_status(&reported, "failed");
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0]["error"]["kind"], "iso-not-reached");
    assert_eq!(failed[0]["asked"], "99999");
}

/// -424.5 is what numpy finds over the values of this file and their counts.
#[test]
fn iso_auto_is_otsus_threshold_and_says_so() {
    let sandbox = head();
    let (_, reported) = sandbox.ends(0, "head.nii.gz --iso auto -o auto.stl --json");
    let iso = reported[0]["iso"].as_f64().unwrap();
    assert_eq!(iso, -424.5);
    let output = sandbox.run(&["info", "head.nii.gz", "--json"]);
    let info = crate::support::sandbox::object(&output);
    let suggested = info["volumes"][0]["suggested"].as_array().unwrap();
    let otsu = suggested.iter().find(|s| s["meaning"].as_str().unwrap().starts_with("Otsu"));
    assert_eq!(otsu.unwrap()["iso"].as_f64(), Some(iso));
    assert_eq!(reported[0]["asked"], "auto");
    assert!(reported[0]["notes"].to_string().contains("Otsu"), "{}", reported[0]["notes"]);
    sandbox.ends(0, &format!("head.nii.gz --iso {iso} -o plain.stl -q"));
    assert!(sandbox.bytes("auto.stl") == sandbox.bytes("plain.stl"));
    std::fs::write(sandbox.path("flat.raw"), [7; 27]).unwrap();
    let (said, _) = sandbox.ends(1, "flat.raw --dims 3x3x3 --type u8 --iso auto -o flat.stl");
    assert!(said.contains("all values are the same"), "{said}");
}

#[test]
fn named_tissues_are_hounsfield_values_of_ct_alone() {
    let sandbox = head();
    let (_, reported) = sandbox.ends(0, "head.nii.gz --iso bone -o bone.stl --json");
    assert_eq!(reported[0]["iso"], 300.0);
    assert!(reported[0]["notes"].to_string().contains("Hounsfield"));
    sandbox.ends(0, "head.nii.gz --iso 300 -o 300.stl -q");
    assert!(sandbox.bytes("bone.stl") == sandbox.bytes("300.stl"));
    sandbox.copy(&repository("testdata/dicom/good-series"), "ct");
    let (said, reported) = sandbox.ends(0, "ct --iso soft -o ct.stl --json");
    assert_eq!((&reported[0]["modality"], &reported[0]["iso"]), (&"CT".into(), &(-30.0).into()));
    assert!(!said.contains("Hounsfield"), "{said}");
    sandbox.copy(&repository("testdata/dicom/mr-anisotropic-rescale"), "mr");
    let (said, reported) = sandbox.ends(1, "mr --iso bone -o mr.stl --json");
    assert_eq!(reported[0]["error"]["kind"], "unfit-series");
    assert!(said.contains("--iso bone is a value of CT, the modality is MR"), "{said}");
}

#[test]
fn labels_have_no_iso_value() {
    let sandbox = Sandbox::new();
    let mut samples = vec![0_u8; 6 * 5 * 4];
    samples[40..80].fill(3);
    std::fs::write(sandbox.path("l.raw"), samples).unwrap();
    let (_, reported) = sandbox
        .ends(0, "l.raw --dims 6x5x4 --type u8 --mask 3 -o out --name {stem}-{label} --json");
    assert!(reported[0]["iso"].is_null());
    assert_eq!(reported[0]["mask"], serde_json::json!([3.0]));
    assert_eq!(sandbox.names("out"), ["l-3.stl"]);
}

#[test]
fn the_note_of_each_iso_value_is_told_once() {
    let sandbox = head();
    let (said, _) = sandbox.ends(0, "head.nii.gz --iso 200 --iso auto --iso bone -o out");
    for note in ["Otsu's threshold", "if these are Hounsfield units"] {
        assert_eq!(said.matches(note).count(), 1, "{said}");
    }
    let mut lines: Vec<&str> = said.lines().filter(|line| line.starts_with("note: ")).collect();
    let n_lines = lines.len();
    lines.sort_unstable();
    lines.dedup();
    assert_eq!(lines.len(), n_lines, "{said}");
}

#[test]
fn a_mesh_that_cannot_be_begun_fails_alone_under_its_own_name() {
    let sandbox = head();
    std::fs::create_dir_all(sandbox.path("out/head_iso300.stl")).unwrap();
    let (_, reported) =
        sandbox.ends(1, "head.nii.gz --iso 200 --iso 300 --iso -200 -o out --json -q");
    assert_eq!(sandbox.names("out"), ["head_iso-200.stl", "head_iso200.stl"]);
    let failed = with_status(&reported, "failed");
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0]["output"], "out/head_iso300.stl");
    let message = failed[0]["error"]["message"].as_str().unwrap();
    assert!(message.starts_with("out/head_iso300.stl: "), "{message}");
}

#[cfg(unix)]
#[test]
fn too_many_iso_values_at_once_are_told_as_such() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/nifti/synth/t_u8_le.nii"), "a.nii");
    let levels: Vec<String> = (40..80).map(|iso| format!("--iso {iso}")).collect();
    let command = format!(
        "ulimit -n 40; exec '{}' a.nii {} -o out --json",
        env!("CARGO_BIN_EXE_mcubes"),
        levels.join(" ")
    );
    let mut shell = std::process::Command::new("sh");
    let output = shell.args(["-c", &command]).current_dir(sandbox.path("")).output().unwrap();
    let reported = crate::support::sandbox::objects(&output);
    let (made, failed) = (with_status(&reported, "ok"), with_status(&reported, "failed"));
    assert!(!made.is_empty() && !failed.is_empty(), "{} of {}", made.len(), reported.len());
    assert_eq!(sandbox.names("out").len(), made.len());
    for object in failed {
        let error = &object["error"];
        assert!(error["message"].as_str().unwrap().ends_with("too many open files"), "{object}");
        assert!(error["hint"].as_str().unwrap().contains("fewer --iso at once"), "{object}");
    }
}
