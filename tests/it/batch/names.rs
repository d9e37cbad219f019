//! What meshes are called, and what they may not replace.

use super::{good_tree, repository};
use crate::support::sandbox::{Sandbox, stderr};

/// Runs what would replace a file that is read from: wrong use, and all files stay as they are.
fn refuses(sandbox: &Sandbox, words: &str, said: &str) {
    let before = sandbox.tree("");
    let (told, _) = sandbox.ends(2, words);
    assert!(told.starts_with(&format!("error: {said}\n")), "{words}: {told}");
    assert!(sandbox.tree("") == before, "{words}");
}

#[test]
fn no_mesh_takes_the_place_of_a_file_that_is_read() {
    let sandbox = Sandbox::new();
    let synth = repository("testdata/nifti/synth");
    for (from, to) in [
        ("pair_n2.hdr", "q.hdr"),
        ("pair_n2.img", "q.img"),
        // The header of a pair by its content alone.
        ("pair_n2.hdr", "k.nii"),
        ("pair_n2.img", "k.img"),
        ("t_u8_le.nii", "in/a"),
        ("t_i8_le.nii", "in/x.stl"),
    ] {
        sandbox.copy(&synth.join(from), to);
    }
    sandbox.copy(&repository("testdata/dicom/good-series"), "study");
    let slices = std::fs::read_dir(sandbox.path("study")).unwrap();
    let slice = slices.map(|e| e.unwrap().file_name().into_string().unwrap()).max().unwrap();
    let stl = "--iso 50 --format stl -o";
    let read = "the output is a file that";
    refuses(&sandbox, &format!("q.hdr {stl} q.img"), &format!("q.img: {read} q.hdr is read from"));
    refuses(
        &sandbox,
        &format!("q.img {stl} ./q.hdr"),
        &format!("./q.hdr: {read} q.img is read from"),
    );
    refuses(&sandbox, &format!("k.nii {stl} k.img"), &format!("k.img: {read} k.nii is read from"));
    let said = format!("study/{slice}: {read} study is read from");
    refuses(&sandbox, &format!("study {stl} study/{slice}"), &said);
    std::fs::write(sandbox.path("bones.toml"), "iso = 50\n").unwrap();
    let words = "k.nii --format stl --config bones.toml -o ./bones.toml";
    refuses(&sandbox, words, "./bones.toml: the output is the file of --config");
    // The mesh of one scan in the place of another scan.
    let words = "in/a in/x.stl --iso 50 -o in --name {file}";
    refuses(&sandbox, words, "in/x.stl: the output is the input");
    refuses(&sandbox, &format!("{words} --dry-run"), "in/x.stl: the output is the input");
    sandbox.ends(0, "in/a in/x.stl --iso 50 -o in --name {file}-new -q");
}

#[cfg(target_os = "linux")]
#[test]
fn no_mesh_takes_the_place_of_what_standard_input_is_read_from() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/raw/phantom_u8_le.raw"), "a.raw");
    let words = "- --dims 20x24x28 --type u8 --iso 100 --format stl -o a.raw";
    let mut command = sandbox.command(&words.split(' ').collect::<Vec<_>>());
    let stdin = std::fs::File::open(sandbox.path("a.raw")).unwrap();
    let output = command.stdin(stdin).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(sandbox.bytes("a.raw").len(), 20 * 24 * 28);
}

#[test]
fn long_names_keep_what_tells_them_apart() {
    let sandbox = Sandbox::new();
    let volume = repository("testdata/nifti/synth/t_u8_le.nii");
    for last in ["a", "b"] {
        sandbox.copy(&volume, &format!("in/{}{last}.nii", "n".repeat(240)));
    }
    sandbox.ends(0, "in -r --iso 50 --iso 60.5 -o out -q");
    let names = sandbox.names("out");
    assert_eq!(names.len(), 4, "{names:?}");
    assert_eq!(names.iter().filter(|name| name.ends_with("_iso60.5.stl")).count(), 2, "{names:?}");
    sandbox.ends(0, "in -r --iso 50 --iso 60.5 -o pattern -q --name {file}-{iso}");
    assert_eq!(sandbox.names("pattern").len(), 4);
}

#[cfg(target_os = "linux")]
#[test]
fn bytes_that_are_no_text_are_written_as_numbers_in_names_and_reports() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let sandbox = good_tree();
    let name = OsStr::from_bytes(b"b\xff.nii");
    std::fs::copy(sandbox.path("in/a/u8.nii"), sandbox.0.path().join(name)).unwrap();
    let reports = |words: &[&str]| {
        let args = [&[name][..], &words.iter().map(OsStr::new).collect::<Vec<_>>()].concat();
        String::from_utf8(sandbox.run(&args).stdout).unwrap()
    };
    for words in
        [&["--iso", "50", "-o", "out/", "--json"][..], &["--iso", "9999", "-o", "out/", "--json"]]
    {
        let told = reports(words);
        assert!(told.contains(r#""input":"b%FF.nii""#) && !told.contains('\u{fffd}'), "{told}");
    }
    assert_eq!(sandbox.names("out"), ["b%FF.stl"]);
    let info = [OsStr::new("info"), name, OsStr::new("--json")];
    let told = String::from_utf8(sandbox.run(&info).stdout).unwrap();
    assert!(told.contains(r#""input":"b%FF.nii""#), "{told}");
}

/// Both characters become `_`, which no pattern undoes.
#[cfg(unix)]
#[test]
fn names_that_no_pattern_tells_apart_are_not_said_to_be() {
    let sandbox = Sandbox::new();
    let volume = repository("testdata/nifti/synth/t_u8_le.nii");
    for to in ["in/a:b.nii", "in/a?b.nii", "x/c.nii", "y/c.nii", "z/1/c.nii", "z/2/c.nii.gz"] {
        sandbox.copy(&volume, to);
    }
    for (words, hint) in [
        ("in -r --name {parent}/{file}_{series}", "hint: no --name tells them apart: rename one"),
        ("x y -r", "hint: no --name tells them apart: rename one"),
        ("z -r --name {stem}", "hint: --name '{parent}/{file}' keeps"),
    ] {
        let (said, _) = sandbox.ends(2, &format!("{words} --iso 50 -o out"));
        assert!(said.contains(hint), "{words}: {said}");
    }
    sandbox.ends(0, "z -r --iso 50 -q -o out --name {parent}/{file}");
}
