//! Folders with things in them that are no plain files: links in circles, folders that cannot be
//! listed, names that are no text.
#![cfg(unix)]

use std::os::unix::fs::symlink;

use super::{GOOD, good_tree, repository};
use crate::support::sandbox::{Sandbox, stderr, with_status};

fn volume() -> std::path::PathBuf {
    repository("testdata/nifti/synth/t_u8_le.nii")
}

#[test]
fn links_in_a_circle_are_passed_over_as_those_to_nothing_are() {
    let sandbox = good_tree();
    symlink("x", sandbox.path("in/a/x")).unwrap();
    symlink("nothing", sandbox.path("in/a/y")).unwrap();
    symlink("u8.nii/z", sandbox.path("in/a/z")).unwrap();
    symlink("x", sandbox.path("in/study/series/x")).unwrap();
    sandbox.ends(0, "in -r --iso 50 -o out -q");
    assert_eq!(sandbox.names("out"), GOOD);
    sandbox.ends(0, "in/study/series --iso 50 -o alone.stl -q");
    let (said, _) = sandbox.ends(1, "in/a/x --iso 50 -o x.stl");
    assert!(said.contains("its symbolic links lead in a circle") && !said.contains("os error"));
}

#[test]
fn what_cannot_be_looked_into_is_one_failure_and_the_rest_goes_on() {
    let sandbox = good_tree();
    // No system follows a link to a name of so many letters.
    symlink("n".repeat(300), sandbox.path("in/a/long")).unwrap();
    let shut = sandbox.path("in/study/shut");
    std::fs::create_dir(&shut).unwrap();
    std::fs::set_permissions(&shut, std::os::unix::fs::PermissionsExt::from_mode(0o000)).unwrap();
    // Root may look into anything.
    let is_shut = std::fs::read_dir(&shut).is_err();
    let (said, reported) = sandbox.ends(1, "in -r --iso 50 -o out --json");
    let failed = with_status(&reported, "failed");
    assert_eq!(failed.len(), 1 + usize::from(is_shut), "{said}");
    assert_eq!(failed[0]["input"], "in/a/long");
    assert_eq!(failed[0]["error"]["kind"], "unreadable");
    assert!(!said.contains("os error"), "{said}");
    assert_eq!(sandbox.names("out"), GOOD);
}

#[test]
fn one_slice_that_cannot_be_read_is_one_failure() {
    let sandbox = Sandbox::new();
    let series = crate::support::dicom::Series::axial(8);
    series.write(&sandbox.path("in"));
    let mut names: Vec<_> =
        std::fs::read_dir(sandbox.path("in")).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    // DICOM by its first bytes, and not even a header.
    let whole = std::fs::read(&names[3]).unwrap();
    std::fs::write(&names[3], &whole[..150]).unwrap();
    let (said, _) = sandbox.ends(1, "in -r --iso 500 -o out");
    assert!(said.contains("done 0, skipped 0, failed 1, not done 0"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_read_and_kept_apart() {
    use std::os::unix::ffi::OsStrExt;
    let sandbox = Sandbox::new();
    let folder = |bytes: &[u8]| sandbox.path("in").join(std::ffi::OsStr::from_bytes(bytes));
    std::fs::create_dir_all(folder(b"d\xff")).unwrap();
    for name in [&b"a\xff.nii"[..], b"a\xfe.nii", b"d\xff/b.nii"] {
        std::fs::copy(volume(), folder(name)).unwrap();
    }
    let dicom = repository("testdata/dicom/good-series");
    for name in [&b"s\xff"[..], b"s\xfe"] {
        std::fs::create_dir(folder(name)).unwrap();
        for entry in std::fs::read_dir(&dicom).unwrap() {
            let entry = entry.unwrap();
            std::fs::copy(entry.path(), folder(name).join(entry.file_name())).unwrap();
        }
    }
    sandbox.ends(0, "in -r --iso 50 -o out -q");
    let names = ["a%FE.stl", "a%FF.stl", "d%FF/b.stl", "s%FE.stl", "s%FF.stl"];
    assert_eq!(sandbox.names("out"), names);
}

#[test]
fn line_breaks_in_names_do_not_break_lines() {
    let sandbox = Sandbox::new();
    sandbox.copy(&volume(), "in/new\nline.nii");
    std::fs::write(sandbox.path("in/bad\nname.nii"), "no volume").unwrap();
    std::fs::create_dir(sandbox.path("o\nut")).unwrap();
    let output = sandbox.run(&["in", "-r", "--iso", "50", "-o", "o\nut"]);
    let said = stderr(&output);
    assert!(said.contains("o?ut/new_line.stl: "), "{said}");
    let begins = ["error: ", "hint: ", "note: ", "o?ut/", "done ", "  "];
    assert!(said.lines().all(|line| begins.iter().any(|b| line.starts_with(b))), "{said}");
}
