//! The command line, as typed.

mod ends;
mod info;

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::support::repository;
use super::support::sandbox::{Sandbox, object, stderr};

fn volume(name: &str) -> String {
    repository("testdata").join(name).display().to_string()
}

fn plain() -> String {
    volume("nifti/synth/plain.nii")
}

fn keys(value: &Value) -> BTreeSet<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn wrong_use_is_status_2_before_any_input_is_opened() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.0.path().join("in.stl"), "").unwrap();
    // No input of these exists, save in.stl: a status of 2 shows that none was opened.
    for (args, said) in [
        (vec![], "no input"),
        (vec!["a.nii", "--iso", "300"], "-o is missing"),
        (vec!["a.nii", "--iso", "nan", "-o", "x.stl"], "not a finite number"),
        (vec!["a.nii", "--iso", "1e999", "-o", "x.stl"], "not a finite number"),
        (vec!["a.nii", "--iso", "3", "-o", "x.foo"], "unknown extension .foo"),
        (vec!["a.nii", "--iso", "3", "-o", "x"], "no extension"),
        (vec!["a.nii", "--iso", "3", "-o", "no/x.stl"], "no: there is no such folder"),
        (
            vec!["a.nii", "b.nii", "--iso", "3", "-o", "x.stl"],
            "2 inputs: many meshes need a folder, x.stl is a file",
        ),
        (
            vec!["a.nii", "--iso", "3", "--iso", "4", "-o", "x.stl"],
            "2 iso values: many meshes need a folder",
        ),
        (
            vec!["a.nii", "b.nii", "--iso", "3", "-o", "-"],
            "2 inputs: many meshes need a folder, standard output holds one",
        ),
        (vec!["a.nii", "-", "--iso", "3", "-o", "x/"], "goes with no other input"),
        (vec!["a.nii", "--iso", "3", "-o", "in.stl/"], "is a file"),
        (vec!["a.nii", "--iso", "3", "-o", "x.stl", "--resume"], "--resume keeps its record"),
        (vec!["a.nii", "--iso", "3", "-o", "x.stl", "--shard", "2/2"], "--shard takes its share"),
        (vec!["a.nii", "--iso", "bones", "-o", "x.stl"], "bone, soft, fat, skin, lung"),
        (vec!["a.nii", "--iso", "3", "-o", "x/", "--name", "../{stem}"], "below the output folder"),
        (vec!["a.nii", "--iso", "3", "-o", "x/", "--name", "{name}"], "no field is called {name}"),
        (vec!["a.nii", "--iso", "3", "-o", "x/", "--shard", "4/3"], "is not I/N"),
        (vec!["a.nii", "--iso", "3", "-o", "x/", "--max-memory", "lots"], "not a size"),
        (vec!["a.nii", "--iso", "3", "-o", "no/x/"], "there is no such folder"),
        (vec!["info", "-"], "--dims is missing"),
        (vec!["a.nii", "--iso", "1", "-o", "x.stl", "--normals"], "STL has no vertex normals"),
        (vec!["a.nii", "--iso", "1", "-o", "-", "--normals"], "STL has no vertex normals"),
        (vec!["in.stl", "--iso", "3", "-o", "in.stl"], "the output is the input"),
        (vec!["in.stl", "--iso", "3", "-o", "./in.stl"], "the output is the input"),
        (vec!["a.nii", "--iso", "3", "-o", "-", "--json"], "both want standard output"),
        (vec!["a.nii", "--iso", "3", "-o", "/dev/stdout", "--json"], "both want standard output"),
        (vec!["a.nii", "--iso", "3", "-o", "/dev/fd/1", "--json"], "both want standard output"),
        (vec!["phantom", "torus", "-o", "/dev/stdout", "--json"], "both want standard output"),
        (vec!["-", "--iso", "3", "-o", "x.stl"], "--dims is missing"),
        (vec!["-", "--dims", "2x2x2", "--type", "u8", "-o", "x.stl"], "--iso or --mask is missing"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--dims", "2x2x2"], "--type is missing"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--offset", "4"], "--dims is missing"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--dims", "2x0x2"], "at least 1"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--threads", "0"], "must be at least 1"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--threads", "1000000000"], "at most 1024"),
        (
            vec!["a", "--iso", "3", "-o", "x/", "--jobs", "1025"],
            "--jobs is 1025, it must be at most",
        ),
        (vec!["phantom", "sphere", "-o", "x.nii", "--threads", "1025"], "at most 1024"),
        (vec!["phantom", "torus-like", "-o", "x.nii"], "torus-like"),
        // That two meshes would have one name is known from inputs: the folder comes first.
        (vec!["in.stl", "in.stl", "--iso", "3", "-o", "no/x/"], "no: there is no such folder"),
        // A folder of that name cannot be made: no hint.
        (vec!["a", "--iso", "3", "-o", "in.stl/x.stl"], "in.stl: is a file, a folder is wanted\n"),
        (
            vec!["a", "b", "--iso", "3", "-o", "in.stl/x/y/"],
            "in.stl: is a file, a folder is wanted\n",
        ),
        (vec!["phantom", "torus", "-o", "in.stl/x.nii"], "in.stl: is a file, a folder is wanted\n"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--volume", "0"], "must be at least 1"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--series", "0"], "counts from 1"),
        (vec!["a", "--iso", "3", "--mask", "1", "-o", "x.stl"], "cannot be used with"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--frobnicate"], "unexpected argument"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--inverts"], "hint: is --invert meant?"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--method", "cube"], "values: cubes, tetrahedra]"),
        (vec!["a", "--iso", "3", "-o", "x.stl", "--method", "cube"], "hint: is cubes meant?"),
        (vec!["--iso"], "a value is required"),
        (
            vec!["a", "--iso", "3", "-o", "x.stl", "--crop", "-1:5,0:1,0:1"],
            "\"-1\" is not an index",
        ),
        (vec!["info"], "INPUT"),
    ] {
        let output = sandbox.run(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).starts_with("error: "), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(said), "{args:?}: {}", stderr(&output));
        let mut below = stderr(&output);
        below.drain(..=below.find('\n').unwrap());
        assert!(below.is_empty() || below.starts_with("hint: "), "{args:?}: {below}");
        assert!(below.lines().count() <= 1, "{args:?}: {below}");
        assert!(output.stdout.is_empty(), "{args:?}");
        assert_eq!(sandbox.files(), ["in.stl"], "{args:?}");
    }
}

#[test]
fn the_report_has_the_documented_keys_and_the_numbers_of_the_file() {
    let sandbox = Sandbox::new();
    let head = volume("ct_head.nii.gz");
    for name in ["skull.ply", "skull.stl"] {
        let output = sandbox.run(&[&head, "--iso", "300", "-o", name, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = object(&output);
        let documented = "schema status input format series volume_number modality dims spacing \
            affine orientation tilt gaps stored iso method space output vertices triangles area \
            volume bounds seconds notes";
        for key in documented.split_whitespace() {
            assert!(keys(&report).contains(key), "{key}");
        }
        assert_eq!(keys(&report["seconds"]), BTreeSet::from(["read", "mesh", "write", "total"]));
        assert_eq!(report["schema"], "mcubes/1");
        assert_eq!(report["status"], "ok");
        assert_eq!(report["input"], head);
        assert_eq!(report["dims"], serde_json::json!([190, 240, 95]));
        // What nibabel says of it.
        assert_eq!(report["orientation"], "LPS");
        // What stands in the file, read back.
        let mesh = mcubes::reader::read(&sandbox.0.path().join(name)).unwrap().topology();
        assert!(mesh.closed && mesh.manifold && mesh.outward);
        assert_eq!(report["triangles"], mesh.n_triangles);
        assert_eq!(report["vertices"], mesh.n_vertices);
        for (key, read) in [("area", mesh.area), ("volume", mesh.volume)] {
            let said = report[key].as_f64().unwrap();
            assert!((said - read).abs() <= 1e-6 * read, "{key}: {said}, read back {read}");
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_on_where_they_go() {
    let sandbox = Sandbox::new();
    for format in ["stl", "ply", "obj"] {
        let name = format!("mesh.{format}");
        sandbox.run(&[&plain(), "--iso", "0.5", "-o", &name]);
        let bytes = sandbox.bytes(&name);
        assert!(!bytes.is_empty());
        for threads in ["1", "2", "7"] {
            let args =
                [&plain(), "--iso", "0.5", "-o", "-", "--format", format, "--threads", threads];
            let output = sandbox.run(&args);
            assert_eq!(output.status.code(), Some(0));
            assert!(output.stdout == bytes, "{format}, {threads} threads");
        }
    }
}

#[test]
fn negative_and_bare_fractions_are_iso_values() {
    let sandbox = Sandbox::new();
    for iso in ["-200", "-.5", "-1e3", "-0.0", ".5"] {
        let output = sandbox.run(&[&plain(), "--iso", iso, "-o", "m.stl", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{iso}: {}", stderr(&output));
        assert_eq!(object(&output)["iso"].as_f64(), iso.parse().ok(), "{iso}");
    }
}

#[test]
fn an_iso_value_that_nothing_reaches_is_told_with_the_range_and_leaves_no_file() {
    let sandbox = Sandbox::new();
    let output = sandbox.run(&[&plain(), "--iso", "99999", "-o", "m.stl", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report = object(&output);
    assert_eq!(report["status"], "failed");
    assert_eq!(report["error"]["kind"], "iso-not-reached");
    let message = report["error"]["message"].as_str().unwrap();
    assert!(message.contains("-10000") && message.contains("20000"), "{message}");
    assert!(sandbox.files().is_empty());
}

#[test]
fn what_fails_is_one_line_status_1_and_an_object_of_its_kind() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.0.path().join("text.nii"), "no volume at all\n".repeat(40)).unwrap();
    for (args, kind) in [
        (vec!["nope.nii", "--iso", "3", "-o", "x.stl", "--json"], "not-found"),
        (vec!["text.nii", "--iso", "3", "-o", "x.stl", "--json"], "unknown-format"),
        (vec!["info", "nope.nii", "--json"], "not-found"),
        (vec!["check", "nope.stl", "--json"], "not-found"),
        (vec!["check", "text.nii", "--json"], "unknown-format"),
    ] {
        let output = sandbox.run(&args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        let report = object(&output);
        assert_eq!(report["status"], "failed", "{args:?}");
        assert_eq!(report["error"]["kind"], kind, "{args:?}");
        let text = stderr(&output);
        assert_eq!(text.lines().filter(|l| l.starts_with("error: ")).count(), 1, "{text}");
        assert!(
            text.lines().all(|l| l.starts_with("error: ") || l.starts_with("hint: ")),
            "{text}"
        );
        assert!(!text.contains("os error"), "{text}");
        assert_eq!(sandbox.files(), ["text.nii"]);
    }
}

#[test]
fn normals_are_in_ply_and_obj_the_same_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    let head = volume("ct_head.nii.gz");
    let mesh = |name: &str, more: &str| {
        sandbox.ends(0, &format!("{head} --iso 300 -q -o {name} {more}"));
        (mcubes::reader::read(&sandbox.path(name)).unwrap(), sandbox.bytes(name))
    };
    let (plain, _) = mesh("plain.ply", "");
    assert!(plain.normals.is_empty());
    let (first, bytes) = mesh("1.ply", "--normals --threads 1");
    assert_eq!((&first.vertices, &first.triangles), (&plain.vertices, &plain.triangles));
    assert_eq!(first.normals.len(), first.vertices.len());
    sandbox.ends(0, "check 1.ply");
    for threads in ["2", "7"] {
        assert!(mesh("n.ply", &format!("--normals --threads {threads}")).1 == bytes, "{threads}");
    }
    for (name, more) in [("n.obj", "--normals"), ("text.ply", "--normals --ascii")] {
        assert_eq!(mesh(name, more).0, first, "{name}");
        sandbox.ends(0, &format!("check {name}"));
    }
}

#[test]
fn tetrahedra_pass_the_check_and_are_named_in_the_report() {
    let sandbox = Sandbox::new();
    let words = ["--iso", "300", "--method", "tetrahedra", "--json", "-q", "-o", "skull.ply"];
    let head = volume("ct_head.nii.gz");
    let output = sandbox.run(&[&[head.as_str()], &words[..]].concat());
    let report = object(&output);
    assert_eq!((&report["status"], &report["method"]), (&"ok".into(), &"tetrahedra".into()));
    assert_eq!(sandbox.run(&["check", "skull.ply"]).status.code(), Some(0));
}

#[test]
fn an_open_mesh_does_not_pass_check() {
    let sandbox = Sandbox::new();
    let head = volume("ct_head.nii.gz");
    sandbox.run(&[&head, "--iso", "300", "--open", "-o", "open.ply"]);
    sandbox.run(&[&head, "--iso", "300", "-o", "closed.ply"]);
    let output = sandbox.run(&["check", "closed.ply", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(object(&output)["ok"], true);
    let output = sandbox.run(&["check", "open.ply", "closed.ply"]);
    assert_eq!(output.status.code(), Some(1));
    let output = sandbox.run(&["check", "open.ply", "--json"]);
    let report = object(&output);
    assert_eq!(report["closed"], false);
    assert_eq!(report["manifold"], true, "an open surface is a manifold with boundary");
    assert!(report["defects"]["boundary_edges"].as_u64().unwrap() > 0);
}

#[test]
fn quiet_says_nothing_and_colour_only_comes_when_asked_for() {
    let sandbox = Sandbox::new();
    let output = sandbox.run(&[&plain(), "--iso", "0.5", "-o", "m.stl", "-q"]);
    assert!(output.stderr.is_empty() && output.stdout.is_empty());
    let wrong = ["nope.nii", "--iso", "3", "-o", "x.stl"];
    assert!(!stderr(&sandbox.run(&wrong)).contains('\u{1b}'));
    let always = [&wrong[..], &["--color", "always"]].concat();
    assert!(stderr(&sandbox.run(&always)).contains('\u{1b}'));
}

#[test]
fn an_input_called_like_a_command_is_written_with_its_folder() {
    let sandbox = Sandbox::new();
    std::fs::copy(plain(), sandbox.0.path().join("info")).unwrap();
    let output = sandbox.run(&["./info", "--iso", "0.5", "-o", "m.stl"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn info_lists_the_documented_keys() {
    let sandbox = Sandbox::new();
    let documented = "number default format dims spacing affine orientation stored slope inter \
        range modality series_uid description images tilt gaps transfer_syntax suggested notes";
    for input in ["nifti/synth/plain.nii", "dicom/good-series"] {
        let output = sandbox.run(&["info", &volume(input), "--json"]);
        assert_eq!(output.status.code(), Some(0));
        let report = object(&output);
        assert_eq!(report["schema"], "mcubes-info/1");
        let first = &report["volumes"][0];
        for key in documented.split_whitespace() {
            assert!(keys(first).contains(key), "{input}: {key}");
        }
        // Headers only, for a folder.
        assert_eq!(first["range"].is_null(), input.starts_with("dicom"), "{input}");
    }
}

#[test]
fn help_fits_a_screen_wide_and_completions_and_manual_know_every_option() {
    let sandbox = Sandbox::new();
    let help = String::from_utf8(sandbox.run(&["--help"]).stdout).unwrap();
    assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    assert!(help.contains("{patient_id} {patient_name}"), "{help}");
    let script = String::from_utf8(sandbox.run(&["completions", "bash"]).stdout).unwrap();
    let manual = String::from_utf8(sandbox.run(&["man"]).stdout).unwrap();
    // Each command has its part, and examples stand as they do in the help.
    for line in [".SH \"MCUBES CHECK\"", ".SH \"MCUBES PHANTOM\"", ".SS SYNOPSIS", ".nf", ".fi"] {
        assert!(manual.lines().any(|of_manual| of_manual == line), "{line}");
    }
    assert!(manual.contains("\\-\\-noise"), "{manual}");
    let examples = help.lines().filter(|line| line.starts_with("  mcubes "));
    for example in examples.map(|line| format!("\\&{}", line.replace('-', "\\-"))) {
        assert!(manual.lines().any(|line| line == example), "{example}");
    }
    let options = help.split_whitespace().filter(|word| word.starts_with("--"));
    let options: BTreeSet<&str> = options
        .map(|word| word.trim_end_matches(|c: char| !c.is_ascii_alphanumeric()))
        .filter(|word| word.len() > 2)
        .collect();
    assert!(options.len() > 15, "{options:?}");
    for option in options {
        assert!(script.contains(option), "{option}");
        assert!(manual.contains(&option.replace('-', "\\-")), "{option}");
    }
}

#[test]
fn an_existing_output_is_replaced_only_by_a_whole_mesh() {
    let sandbox = Sandbox::new();
    let target = sandbox.0.path().join("m.stl");
    std::fs::write(&target, "kept").unwrap();
    sandbox.run(&[&plain(), "--iso", "99999", "-o", "m.stl"]);
    assert_eq!(sandbox.bytes("m.stl"), b"kept");
    sandbox.run(&[&plain(), "--iso", "0.5", "-o", "m.stl"]);
    assert!(mcubes::reader::read(Path::new(&target)).is_ok());
    assert_eq!(sandbox.files(), ["m.stl"]);
}

#[test]
fn padding_that_would_be_inside_is_no_surface() {
    let folder = super::support::repository("testdata/dicom/padding-high");
    let sandbox = Sandbox::new();
    let folder = folder.display().to_string();
    let report = object(&sandbox.run(&[&folder, "--iso", "300", "--json", "-o", "x.stl"]));
    // Padding fills the corners of the box: a mesh that took it for bone would reach the border.
    let [low, high] =
        [&report["bounds"][0][0], &report["bounds"][1][0]].map(|v| v.as_f64().unwrap());
    let dims = report["dims"][0].as_f64().unwrap() * report["spacing"][0].as_f64().unwrap();
    assert!(high - low < dims - 2.0, "{report}");
}

#[test]
fn an_open_mesh_has_no_outside_to_be_wound_to() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let output = sandbox.run(&["check", "one.obj", "--json"]);
    let report = object(&output);
    assert_eq!((&report["closed"], &report["outward"]), (&false.into(), &Value::Null));
    assert_eq!(output.status.code(), Some(1));
    let output = sandbox.run(&["check", "one.obj"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("closed NO, manifold yes, outward - (open)"), "{said}");
}

#[test]
fn voxel_indices_are_no_way_out_where_they_are_too_coarse_too() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path("long.raw"), vec![0; 140_000 * 4]).unwrap();
    let long = "long.raw --dims 140000x2x2 --type u8 --iso 1 -o x.stl";
    for space in ["voxel", "ras"] {
        let (said, _) = sandbox.ends(1, &format!("{long} --space {space}"));
        assert!(said.contains("cannot be told apart in the 32-bit floats"), "{said}");
        assert!(said.contains("hint: --downsample makes") && !said.contains("--space"), "{said}");
    }
    let far = "long.raw --dims 140x1000x4 --type u8 --origin 1e9,0,0 --iso 1 -o x.stl";
    let (said, _) = sandbox.ends(1, far);
    assert!(said.contains("hint: --space voxel writes voxel indices instead"), "{said}");
}
