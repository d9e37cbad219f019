//! Many scans in one run.

mod config;
mod entries;
mod find;
mod kill;
mod levels;
mod names;
mod pipes;
mod resume;
mod run;
mod slurm;
mod tree;

use super::support::repository;
use super::support::sandbox::Sandbox;

/// A small tree of good volumes: NIfTI, a pair, gzip and a DICOM series, in folders.
fn good_tree() -> Sandbox {
    let sandbox = Sandbox::new();
    let synth = repository("testdata/nifti/synth");
    for (from, to) in [
        ("t_u8_le.nii", "in/a/u8.nii"),
        ("t_i8_le.nii", "in/a/i8.nii"),
        ("n2_u8_le.nii.gz", "in/b/c/deep.nii.gz"),
        ("pair_n2.hdr", "in/b/pair.hdr"),
        ("pair_n2.img", "in/b/pair.img"),
    ] {
        sandbox.copy(&synth.join(from), to);
    }
    sandbox.copy(&repository("testdata/dicom/good-series"), "in/study/series");
    std::fs::write(sandbox.path("in/a/notes.txt"), "no volume").unwrap();
    sandbox
}

/// What [`good_tree`] gives below the output folder.
const GOOD: [&str; 5] = ["a/i8.stl", "a/u8.stl", "b/c/deep.stl", "b/pair.stl", "study/series.stl"];

/// [`good_tree`] with volumes among them that cannot be meshed, each for another reason.
fn mixed_tree() -> Sandbox {
    let sandbox = good_tree();
    let bad = repository("testdata/nifti/bad");
    sandbox.copy(&bad.join("trunc_data.nii"), "in/a/cut.nii");
    sandbox.copy(&bad.join("bitpix_wrong.nii"), "in/b/c/header.nii");
    std::fs::write(sandbox.path("in/b/text.nii"), "no volume at all\n".repeat(40)).unwrap();
    sandbox
}

/// The kinds of what fails in [`mixed_tree`], with the inputs.
const BAD: [(&str, &str); 3] = [
    ("in/a/cut.nii", "truncated-data"),
    ("in/b/c/header.nii", "bad-header"),
    ("in/b/text.nii", "unknown-format"),
];
