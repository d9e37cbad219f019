use std::fs::{File, FileTimes};
use std::time::{Duration, SystemTime};

use super::{GOOD, good_tree};
use crate::support::sandbox::{Sandbox, with_status};

const RUN: &str = "in -r --iso 50 -o out --json -q";
const AGAIN: &str = "in -r --iso 50 -o out --json -q --resume";
const RECORD: &str = "out/.mcubes-done.jsonl";

/// The outputs that a second run made again.
fn made_again(sandbox: &Sandbox, words: &str) -> Vec<String> {
    let (said, reported) = sandbox.ends(0, words);
    let (made, kept) = (with_status(&reported, "ok"), with_status(&reported, "skipped"));
    assert_eq!(made.len() + kept.len(), GOOD.len(), "{said}");
    let mut made: Vec<String> =
        made.iter().map(|o| o["output"].as_str().unwrap().replace("out/", "")).collect();
    made.sort();
    made
}

#[test]
fn what_is_done_is_passed_over() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    let before = sandbox.tree("out");
    assert!(made_again(&sandbox, AGAIN).is_empty());
    let (said, _) = sandbox.ends(0, "in -r --iso 50 -o out --resume");
    assert!(said.contains("done 0, skipped 5, failed 0, not done 0"), "{said}");
    assert!(sandbox.tree("out") == before);
    // Without --resume all is made again.
    let (_, reported) = sandbox.ends(0, RUN);
    assert_eq!(with_status(&reported, "ok").len(), 5);
}

#[test]
fn other_options_make_all_again() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    for (more, fresh) in [("--invert", "inverted"), ("--space lps", "lps")] {
        assert_eq!(made_again(&sandbox, &format!("{AGAIN} {more}")), GOOD, "{more}");
        sandbox.ends(0, &format!("in -r --iso 50 -o {fresh} -q {more}"));
        assert!(sandbox.tree("out") == sandbox.tree(fresh), "{more}");
    }
    assert!(made_again(&sandbox, &format!("{AGAIN} --space lps")).is_empty());
    // What does not change a byte changes nothing here.
    let same = format!("{AGAIN} --space lps --threads 1 --jobs 1 --max-memory 1G");
    assert!(made_again(&sandbox, &same).is_empty());
}

#[test]
fn an_input_that_was_changed_is_made_again() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    // Other samples of the same size, under the time of the old ones.
    let path = sandbox.path("in/a/u8.nii");
    let time = std::fs::metadata(&path).unwrap().modified().unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[400] ^= 255;
    std::fs::write(&path, bytes).unwrap();
    File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), ["a/u8.stl"]);
    // The image of a pair, by its time alone.
    let times = FileTimes::new().set_modified(SystemTime::now() + Duration::from_secs(7));
    File::options()
        .write(true)
        .open(sandbox.path("in/b/pair.img"))
        .unwrap()
        .set_times(times)
        .unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), ["b/pair.stl"]);
    // One slice of a series.
    let slices = std::fs::read_dir(sandbox.path("in/study/series")).unwrap();
    let slice = slices.map(|e| e.unwrap().path()).min().unwrap();
    File::options().write(true).open(slice).unwrap().set_times(times).unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), ["study/series.stl"]);
    assert!(made_again(&sandbox, AGAIN).is_empty());
}

#[test]
fn an_output_that_was_changed_or_lost_is_made_again() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    let whole = sandbox.tree("out");
    let mut bytes = sandbox.bytes("out/a/u8.stl");
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(sandbox.path("out/a/u8.stl"), &bytes).unwrap();
    let bytes = sandbox.bytes("out/b/pair.stl");
    std::fs::write(sandbox.path("out/b/pair.stl"), &bytes[..bytes.len() - 1]).unwrap();
    std::fs::remove_file(sandbox.path("out/a/i8.stl")).unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), ["a/i8.stl", "a/u8.stl", "b/pair.stl"]);
    assert!(sandbox.tree("out") == whole);
}

#[test]
fn a_record_that_was_cut_or_spoiled_says_nothing_wrong() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    let whole = sandbox.bytes(RECORD);
    let last = whole[..whole.len() - 1].iter().rposition(|&b| b == b'\n').unwrap() + 1;
    for end in [last + 1, last + (whole.len() - last) / 2, whole.len() - 2] {
        std::fs::write(sandbox.path(RECORD), &whole[..end]).unwrap();
        assert_eq!(made_again(&sandbox, AGAIN).len(), 1, "cut to {end} of {}", whole.len());
        assert!(made_again(&sandbox, AGAIN).is_empty(), "the line after a cut one is whole");
    }
    // The line that was cut lost only its end mark: it is whole.
    std::fs::write(sandbox.path(RECORD), &whole[..whole.len() - 1]).unwrap();
    assert!(made_again(&sandbox, AGAIN).is_empty());
    for spoiled in [&b""[..], b"\0\0\0\0", b"{}\n[]\nnull\n\"x\"\n{\"schema\":7}\n", &[0xff; 4096]]
    {
        std::fs::write(sandbox.path(RECORD), spoiled).unwrap();
        assert_eq!(made_again(&sandbox, AGAIN), GOOD);
        assert!(made_again(&sandbox, AGAIN).is_empty());
    }
    std::fs::remove_file(sandbox.path(RECORD)).unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), GOOD);
}

#[test]
fn another_version_makes_all_again() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    let record = String::from_utf8(sandbox.bytes(RECORD)).unwrap();
    let version = format!("\"version\":\"{}\"", env!("CARGO_PKG_VERSION"));
    assert_eq!(record.matches(&version).count(), 5);
    let other = record.replace(&version, "\"version\":\"0.0.1\"");
    std::fs::write(sandbox.path(RECORD), other).unwrap();
    assert_eq!(made_again(&sandbox, AGAIN), GOOD);
}

#[test]
fn shards_keep_records_of_their_own_that_all_believe() {
    let sandbox = good_tree();
    for part in 1..=2 {
        sandbox.ends(0, &format!("in -r --iso 50 -o out -q --shard {part}/2"));
    }
    assert!(made_again(&sandbox, AGAIN).is_empty());
}

#[test]
fn what_failed_is_tried_again() {
    let sandbox = super::mixed_tree();
    sandbox.ends(1, "in -r --iso 50 -o out -q");
    let (_, reported) = sandbox.ends(1, "in -r --iso 50 -o out --resume --json -q");
    assert_eq!(with_status(&reported, "skipped").len(), 5);
    assert_eq!(with_status(&reported, "failed").len(), 3);
}

#[test]
fn the_image_of_a_pair_is_looked_at_whatever_its_header_is_called() {
    let sandbox = Sandbox::new();
    let synth = super::repository("testdata/nifti/synth");
    sandbox.copy(&synth.join("pair_n2.hdr"), "k.nii");
    sandbox.copy(&synth.join("pair_n2.img"), "k.img");
    sandbox.ends(0, "k.nii --iso 50 -o out/ -q");
    let again = "k.nii --iso 50 -o out/ -q --resume --json";
    assert_eq!(sandbox.ends(0, again).1[0]["status"], "skipped");
    let times = FileTimes::new().set_modified(SystemTime::now() + Duration::from_secs(7));
    File::options().write(true).open(sandbox.path("k.img")).unwrap().set_times(times).unwrap();
    assert_eq!(sandbox.ends(0, again).1[0]["status"], "ok");
}

#[test]
fn a_dry_run_leaves_out_what_resuming_would_pass_over() {
    let sandbox = good_tree();
    sandbox.ends(0, RUN);
    std::fs::remove_file(sandbox.path("out/a/u8.stl")).unwrap();
    let (said, reported) = sandbox.ends(0, "in -r --iso 50 -o out --json --resume --dry-run");
    assert!(said.ends_with("1 mesh would be made, 4 skipped; 0 scans cannot be read\n"), "{said}");
    let planned = with_status(&reported, "planned");
    assert_eq!(planned.len(), 1, "{said}");
    assert_eq!(planned[0]["output"], "out/a/u8.stl");
    assert_eq!(with_status(&reported, "skipped").len(), 4, "{said}");
    // The run that it tells of.
    assert_eq!(made_again(&sandbox, AGAIN), ["a/u8.stl"]);
    let (said, _) = sandbox.ends(0, "in -r --iso 50 -o out --dry-run");
    assert!(said.ends_with("5 meshes would be made; 0 scans cannot be read\n"), "{said}");
}
