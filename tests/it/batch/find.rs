use super::{good_tree, repository};
use crate::support::sandbox::Sandbox;

#[test]
fn two_outputs_with_one_name_are_refused_before_any_work() {
    let sandbox = Sandbox::new();
    let synth = repository("testdata/nifti/synth");
    sandbox.copy(&synth.join("t_u8_le.nii"), "in/head.nii");
    sandbox.copy(&synth.join("n2_u8_le.nii.gz"), "in/head.nii.gz");
    let (said, _) = sandbox.ends(2, "in -r --iso 50 -o out");
    assert!(said.contains("in/head.nii and in/head.nii.gz would both be out/head.stl"), "{said}");
    assert!(said.contains("hint: --name '{parent}/{file}'"), "{said}");
    assert_eq!(sandbox.files(), ["in"]);
    sandbox.ends(0, "in -r --iso 50 -o out -q --name {parent}/{file}");
    assert_eq!(sandbox.names("out"), ["head.nii.gz.stl", "head.nii.stl"]);
    // The folders below the input folder, even where one is called like it.
    sandbox.copy(&synth.join("t_u8_le.nii"), "in/in/head.nii");
    sandbox.ends(0, "in -r --iso 50 -o deep -q --name {parent}/{file}");
    let names = ["head.nii.gz.stl", "head.nii.stl", "in/head.nii.stl"];
    assert_eq!(sandbox.names("deep"), names);
    sandbox.ends(0, "in/in/head.nii --iso 50 -o typed -q --name {parent}/{file}");
    assert_eq!(sandbox.names("typed"), ["in/in/head.nii.stl"]);
    sandbox.ends(2, "in/head.nii --iso 1 --iso 2 -o out --name {stem}");
    sandbox.ends(2, "in/head.nii in/head.nii --iso 1 -o out");
}

#[test]
fn no_field_leads_out_of_the_output_folder() {
    let sandbox = Sandbox::new();
    let volume = repository("testdata/nifti/synth/t_u8_le.nii");
    for name in ["...nii", "a:b*c.nii", "new\nline.nii"] {
        sandbox.copy(&volume, &format!("in/{name}"));
    }
    sandbox.ends(0, "in -r --iso 50 -o out -q");
    let mut names = sandbox.names("out");
    names.sort();
    assert_eq!(names, ["__.stl", "a_b_c.stl", "new_line.stl"]);
    assert_eq!(sandbox.files().len(), 2);
}

#[test]
fn patterns_are_filled_in() {
    let sandbox = good_tree();
    sandbox.ends(
        0,
        "in -r --iso 50 --iso 60.5 -o out -q --format ply --name {modality}/{parent}-{stem}.{iso}",
    );
    let names = sandbox.names("out");
    assert_eq!(names.len(), 10, "{names:?}");
    assert!(names.contains(&"none/a-u8.50.ply".to_owned()), "{names:?}");
    assert!(names.contains(&"none/b/c-deep.60.5.ply".to_owned()), "{names:?}");
    assert!(names.contains(&"CT/study-series.60.5.ply".to_owned()), "{names:?}");
}

#[test]
fn a_pair_is_one_volume_and_an_image_without_header_has_its_reason() {
    let sandbox = good_tree();
    sandbox.copy(&repository("testdata/nifti/synth/pair_n2.img"), "in/b/alone.img");
    let (said, reported) = sandbox.ends(1, "in/b -r --iso 50 -o out --json -q");
    assert_eq!(sandbox.names("out"), ["c/deep.stl", "pair.stl"]);
    let failed = crate::support::sandbox::with_status(&reported, "failed");
    assert_eq!(failed.len(), 1, "{said}");
    assert_eq!(failed[0]["input"], "in/b/alone.img");
}

#[test]
fn every_series_of_a_study_is_meshed_where_all_are_asked_for() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/dicom/good-series"), "in/one");
    sandbox.copy(&repository("testdata/dicom/mr-anisotropic-rescale"), "in/two");
    // All files in one folder: two series of one study, as far as names go.
    for (n, folder) in ["in/one", "in/two"].iter().enumerate() {
        for entry in std::fs::read_dir(sandbox.path(folder)).unwrap() {
            let entry = entry.unwrap();
            let name = format!("flat/{n}-{}", entry.file_name().into_string().unwrap());
            sandbox.copy(&entry.path(), &name);
        }
    }
    let (_, reported) = sandbox.ends(0, "flat --series all --iso 50 -o all --json -q");
    assert_eq!(sandbox.names("all"), ["flat_series1.stl", "flat_series2.stl"]);
    let numbers: Vec<_> = reported.iter().map(|o| o["volume_number"].as_u64().unwrap()).collect();
    assert_eq!(numbers.iter().sum::<u64>(), 3);
    // The same volumes wherever their files lie.
    sandbox.ends(0, "in -r --iso 50 -o apart -q");
    let bytes = |tree: Vec<(String, Vec<u8>)>| {
        let mut all: Vec<Vec<u8>> = tree.into_iter().map(|(_, bytes)| bytes).collect();
        all.sort();
        all
    };
    assert!(bytes(sandbox.tree("all")) == bytes(sandbox.tree("apart")));
}

#[test]
fn a_series_in_two_folders_is_one_volume_and_two_copies_of_it_are_two() {
    let sandbox = Sandbox::new();
    let series = repository("testdata/dicom/good-series");
    sandbox.copy(&series, "whole/s");
    sandbox.ends(0, "whole/s --iso 50 -o whole.stl -q");
    for (n, entry) in walkdir::WalkDir::new(&series).sort_by_file_name().into_iter().enumerate() {
        let entry = entry.unwrap();
        if entry.file_type().is_file() {
            let name = entry.file_name().to_string_lossy();
            sandbox.copy(entry.path(), &format!("spread/s/{}/{name}", n % 2));
        }
    }
    sandbox.ends(0, "spread -r --iso 50 -o spread.out -q");
    assert_eq!(sandbox.names("spread.out"), ["s.stl"]);
    assert!(sandbox.bytes("spread.out/s.stl") == sandbox.bytes("whole.stl"));
    sandbox.copy(&series, "copies/a");
    sandbox.copy(&series, "copies/b");
    sandbox.ends(0, "copies -r --iso 50 -o copies.out -q");
    assert_eq!(sandbox.names("copies.out"), ["a.stl", "b.stl"]);
}

#[test]
fn an_archive_below_a_folder_is_a_study() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/dicom/study.zip"), "in/deep/study.zip");
    let (_, alone) = sandbox.ends(0, "in/deep/study.zip --series all --iso 50 -o a --json -q");
    let (_, below) = sandbox.ends(0, "in -r --iso 50 -o b --json -q");
    assert_eq!(alone.len(), below.len());
    let strip = |names: Vec<String>| -> Vec<String> {
        names.iter().map(|n| n.trim_start_matches("deep/").to_owned()).collect()
    };
    assert_eq!(strip(sandbox.names("a")), strip(sandbox.names("b")));
}

#[test]
fn raw_files_below_a_folder_share_one_layout() {
    let sandbox = Sandbox::new();
    for name in ["in/a.raw", "in/b/c.raw"] {
        let path = sandbox.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut samples = vec![0_u8; 6 * 5 * 4];
        samples[40..80].fill(200);
        std::fs::write(path, samples).unwrap();
    }
    std::fs::write(sandbox.path("in/readme.txt"), "about").unwrap();
    sandbox.ends(0, "in -r --dims 6x5x4 --type u8 --iso 100 -o out -q");
    assert_eq!(sandbox.names("out"), ["a.stl", "b/c.stl"]);
}

#[test]
fn the_patient_is_read_only_where_a_name_is_to_tell() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/dicom/good-series"), "in/s");
    let mut text = Vec::new();
    for entry in std::fs::read_dir(sandbox.path("in/s")).unwrap() {
        text.extend(std::fs::read(entry.unwrap().path()).unwrap());
    }
    // As pydicom has it of these files.
    let (id, name) = ("LEAKCHECK-ID", "LEAKCHECK^NAME");
    for word in [id, name] {
        assert!(text.windows(word.len()).any(|w| w == word.as_bytes()), "{word} is in the files");
    }
    sandbox.ends(0, "in -r --iso 50 -o out -q --name {patient_id}/{patient_name}_{series}");
    assert_eq!(sandbox.names("out"), [format!("{id}/{name}_1.stl")]);
    let (said, reported) = sandbox.ends(0, "in -r --iso 50 -o plain --json");
    let all =
        format!("{said}{reported:?}{}", String::from_utf8_lossy(&sandbox.bytes("plain/s.stl")));
    assert!(!all.contains("LEAKCHECK"), "{said}");
}

#[test]
fn a_volume_that_is_not_there_is_not_another_one() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/nifti/synth/t_u8_le.nii"), "a.nii");
    let (said, _) = sandbox.ends(1, "a.nii --series 2 --iso 50 -o a.stl");
    assert!(said.contains("a.nii: no series 2; there are 1"), "{said}");
    sandbox.ends(0, "a.nii --series 1 --iso 50 -o a.stl -q");
    let series = repository("testdata/dicom/good-series");
    let (said, _) = sandbox.ends(1, &format!("{} --volume 2 --iso 300 -o b.stl", series.display()));
    assert!(said.contains("volume 2 was asked for"), "{said}");
    sandbox.ends(0, &format!("{} --volume 1 --iso 300 -o b.stl -q", series.display()));
}

#[test]
fn a_dry_run_plans_what_is_left_of_the_volume() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/ct_head.nii.gz"), "head.nii.gz");
    let dims = |more: &str| {
        let words = format!("head.nii.gz --iso 300 -o a.stl --dry-run --json {more}");
        sandbox.ends(0, &words).1[0]["dims"].to_string()
    };
    assert_eq!(dims("--downsample 4"), "[48,60,24]");
    assert_eq!(dims("--crop 0:10,0:20,0:30"), "[10,20,30]");
    sandbox.ends(1, "head.nii.gz --iso 300 -o a.stl --dry-run --crop 0:1000,0:20,0:30");
    assert_eq!(sandbox.files(), ["head.nii.gz"]);
}

#[test]
fn what_macos_leaves_beside_files_is_passed_over() {
    let sandbox = good_tree();
    let shadow = [&b"\0\x05\x16\x07\0\x02\0\0Mac OS X        "[..], &[0; 400]].concat();
    for name in ["a/._u8.nii", "b/._pair.hdr", "b/._pair.img", "study/series/._IM0.dcm"] {
        std::fs::write(sandbox.path("in").join(name), &shadow).unwrap();
    }
    let (said, _) = sandbox.ends(0, "in -r --iso 50 -o out");
    assert_eq!(sandbox.names("out"), super::GOOD);
    assert!(said.contains("5 files that are no volume were passed over"), "{said}");
    // What only has such a name is a volume like any other.
    sandbox.copy(&sandbox.path("in/a/u8.nii"), "in/a/._own.nii");
    sandbox.ends(0, "in/a -r --iso 50 -o own -q");
    assert_eq!(sandbox.names("own"), ["._own.stl", "i8.stl", "u8.stl"]);
}
