use super::{BAD, GOOD, good_tree, mixed_tree, repository};
use crate::support::sandbox::{Sandbox, with_status};

#[test]
fn every_volume_below_a_folder_is_meshed_and_the_outputs_lie_as_the_inputs() {
    let sandbox = good_tree();
    let (said, _) = sandbox.ends(0, "in --recursive --iso 50 -o out");
    assert!(said.contains("done 5, skipped 0, failed 0, not done 0"), "{said}");
    assert!(said.contains("1 file that is no volume was passed over"), "{said}");
    assert_eq!(sandbox.names("out"), GOOD);
    for name in GOOD {
        let mesh = mcubes::reader::read(&sandbox.path("out").join(name)).unwrap().topology();
        assert!(mesh.closed && mesh.manifold && mesh.outward, "{name}");
    }
}

#[test]
fn a_mesh_of_a_batch_is_the_mesh_of_its_own_run() {
    let sandbox = good_tree();
    sandbox.ends(0, "in -r --iso 50 -o out -q");
    let inputs = ["a/i8.nii", "a/u8.nii", "b/c/deep.nii.gz", "b/pair.hdr", "study/series"];
    for (input, name) in inputs.iter().zip(GOOD) {
        sandbox.ends(0, &format!("in/{input} --iso 50 -o alone.stl -q"));
        assert!(sandbox.bytes("alone.stl") == sandbox.bytes(&format!("out/{name}")), "{input}");
    }
}

#[test]
fn one_failure_does_not_stop_the_rest_and_each_has_its_reason() {
    let sandbox = mixed_tree();
    let (said, reported) = sandbox.ends(1, "in --recursive --iso 50 -o out --json");
    assert!(said.contains("done 5, skipped 0, failed 3, not done 0"), "{said}");
    assert_eq!(sandbox.names("out"), GOOD);
    assert_eq!(reported.len(), 8);
    assert_eq!(with_status(&reported, "ok").len(), 5);
    let table = said.split("done 5").nth(1).unwrap();
    for (input, kind) in BAD {
        let own = reported.iter().find(|o| o["input"] == input).unwrap();
        assert_eq!((&own["status"], &own["error"]["kind"]), (&"failed".into(), &kind.into()));
        assert!(table.lines().any(|l| l.contains(kind) && l.contains(input)), "{table}");
    }
}

#[test]
fn objects_are_of_one_scan_each_and_told_of_a_whole_mesh() {
    let sandbox = good_tree();
    let (_, reported) = sandbox.ends(0, "in -r --iso 50 --iso 60 -o out --json -q");
    assert_eq!(reported.len(), 10);
    for object in &reported {
        assert_eq!(object["schema"], "mcubes/1");
        let path = sandbox.path(object["output"].as_str().unwrap());
        let mesh = mcubes::reader::read(&path).unwrap().topology();
        assert_eq!(object["triangles"], mesh.n_triangles);
        let iso = object["iso"].as_f64().unwrap();
        assert_eq!(object["asked"], iso.to_string());
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(name.ends_with(&format!("_iso{iso}.stl")), "{name}");
    }
}

#[test]
fn fail_fast_begins_nothing_after_the_first_failure() {
    let sandbox = mixed_tree();
    let (said, reported) = sandbox.ends(1, "in -r --iso 50 -o out --jobs 1 --fail-fast --json");
    // By name `in/a/cut.nii` is the first.
    assert_eq!(reported.len(), 1);
    assert_eq!(reported[0]["input"], "in/a/cut.nii");
    assert!(said.contains("failed 1, not done 7"), "{said}");
    assert!(sandbox.names("out").is_empty());
}

#[test]
fn the_bytes_do_not_depend_on_jobs_threads_or_memory() {
    let sandbox = good_tree();
    sandbox.ends(0, "in -r --iso 50 -o one --format ply --jobs 1 --threads 1 -q");
    sandbox.ends(0, "in -r --iso 50 -o many --format ply --jobs 4 --threads 8 -q");
    sandbox.ends(0, "in -r --iso 50 -o tight --format ply --max-memory 64M -q");
    assert!(sandbox.tree("one") == sandbox.tree("many"));
    assert!(sandbox.tree("one") == sandbox.tree("tight"));
}

#[test]
fn a_scan_that_needs_more_than_the_memory_given_is_refused() {
    let sandbox = good_tree();
    let (said, reported) =
        sandbox.ends(1, "in/a/u8.nii in/a/i8.nii --iso 50 -o out --max-memory 1M --json");
    assert!(reported.iter().all(|o| o["error"]["kind"] == "too-large"), "{said}");
    assert!(sandbox.names("out").is_empty());
}

#[test]
fn a_dry_run_says_what_would_be_done_and_writes_nothing() {
    let sandbox = mixed_tree();
    let before = sandbox.files();
    let (said, planned) = sandbox.ends(1, "in -r --iso 50 -o out --dry-run --json");
    assert_eq!(sandbox.files(), before);
    let mut outputs: Vec<&str> =
        with_status(&planned, "planned").iter().map(|o| o["output"].as_str().unwrap()).collect();
    outputs.sort_unstable();
    assert_eq!(outputs, GOOD.map(|name| format!("out/{name}")));
    // What only the samples can show is not seen; headers are looked at.
    assert_eq!(with_status(&planned, "failed").len(), 3, "{said}");
    for object in with_status(&planned, "planned") {
        // The shard that is this scan alone.
        let [part, of] = [0, 1].map(|n| object["shard"][n].as_u64().unwrap());
        let (_, own) =
            sandbox.ends(0, &format!("in -r --iso 50 -o out --dry-run --json --shard {part}/{of}"));
        assert_eq!(own.iter().collect::<Vec<_>>(), [object]);
        assert!(object["estimate"]["memory"].as_u64().unwrap() > 0);
        assert!(object["estimate"]["triangles"].as_u64().unwrap() > 0);
    }
    let output = sandbox.run(&["in", "-r", "--iso", "50", "-o", "out", "--dry-run"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(GOOD.iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn shards_are_the_whole_and_have_nothing_in_common() {
    let sandbox = good_tree();
    sandbox.ends(0, "in -r --iso 50 --iso 60 -o whole -q");
    let mut meshes = Vec::new();
    for part in 1..=3 {
        sandbox.ends(0, &format!("in -r --iso 50 --iso 60 -o part{part} -q --shard {part}/3"));
        meshes.extend(sandbox.tree(&format!("part{part}")));
    }
    meshes.sort();
    assert!(meshes == sandbox.tree("whole"));
    // More shards than scans: some have nothing to do, which is no failure.
    sandbox.ends(0, "in -r --iso 50 -o part9 -q --shard 9/9");
    assert!(sandbox.names("part9").is_empty());
    // The order of the inputs does not matter.
    sandbox.ends(0, "in/b in/a -r --iso 50 -o ab -q --shard 2/2");
    sandbox.ends(0, "in/a in/b -r --iso 50 -o ba -q --shard 2/2");
    assert_eq!(sandbox.names("ab"), sandbox.names("ba"));
}

#[test]
fn files_and_folders_may_be_mixed() {
    let sandbox = good_tree();
    sandbox.ends(0, "in/a/u8.nii in/b in/study -r --iso 50 -o out -q");
    assert_eq!(sandbox.names("out"), ["c/deep.stl", "pair.stl", "series.stl", "u8.stl"]);
}

#[test]
fn a_folder_without_a_volume_and_a_missing_input_are_failures() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("empty")).unwrap();
    let (_, reported) = sandbox.ends(1, "empty gone.nii --recursive --iso 1 -o out --json");
    let kinds: Vec<_> = reported.iter().map(|o| o["error"]["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds.len(), 2);
    assert!(kinds.contains(&"no-series") && kinds.contains(&"not-found"), "{kinds:?}");
}

#[test]
fn one_scan_into_a_folder_is_named_like_its_input() {
    let sandbox = Sandbox::new();
    sandbox.copy(&repository("testdata/nifti/synth/t_u8_le.nii"), "head.nii");
    sandbox.ends(0, "head.nii --iso 50 -o new/ --format obj -q");
    assert_eq!(sandbox.names("new"), ["head.obj"]);
}

/// What runs is stopped, what is finished stays.
#[cfg(unix)]
#[test]
fn a_signal_ends_a_batch_with_status_130_and_its_table() {
    let sandbox = Sandbox::new();
    let head = repository("testdata/ct_head.nii.gz");
    for n in 0..60 {
        sandbox.copy(&head, &format!("in/{n}.nii.gz"));
    }
    for signal in ["-INT", "-TERM"] {
        let args = ["in", "-r", "--iso", "300", "-o", "out", "--format", "ply"];
        let child = sandbox.command(&args).stderr(std::process::Stdio::piped()).spawn().unwrap();
        while sandbox.names("out").is_empty() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let id = child.id().to_string();
        assert!(std::process::Command::new("kill").args([signal, &id]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.contains("not done") && !said.contains("not done 0"), "{said}");
        let all = std::fs::read_dir(sandbox.path("out")).unwrap();
        let names: Vec<String> =
            all.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        assert!(names.iter().all(|n| !n.contains(".part")), "{names:?}");
        for name in sandbox.names("out") {
            assert!(mcubes::reader::read(&sandbox.path("out").join(name)).is_ok());
        }
        std::fs::remove_dir_all(sandbox.path("out")).unwrap();
    }
}

#[test]
fn a_scan_that_fails_leaves_no_folder_behind() {
    let sandbox = good_tree();
    // Not reached once it is read; cut.
    let synth = repository("testdata/nifti/synth/t_u8_le.nii");
    sandbox.copy(&repository("testdata/nifti/bad/trunc_data.nii"), "in/cut/deep/a.nii");
    sandbox.ends(1, "in -r --iso 50 --format ply -o out -q");
    let folders = |name: &str| {
        let all = walkdir::WalkDir::new(sandbox.path(name)).into_iter().flatten();
        all.filter(|e| e.file_type().is_dir()).count()
    };
    // out, a, b, b/c, study.
    assert_eq!(folders("out"), 5);
    sandbox.ends(1, "in -r --iso 99999 -o nothing -q");
    assert!(!sandbox.path("nothing").exists());
    // A file where a folder is wanted fails its own scans alone.
    sandbox.copy(&synth, "mixed/u8");
    let (said, _) = sandbox.ends(1, "in/a in/b -r --iso 50 -o mixed --name {parent}/{stem}/{iso}");
    let error = "mixed/u8/50.stl: cannot be written: the folder mixed/u8 does not exist";
    assert!(said.contains(error), "{said}");
    assert!(said.contains("done 3, skipped 0, failed 1, not done 0"), "{said}");
}
