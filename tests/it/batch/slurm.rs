//! The script for Slurm, in the environment that Slurm gives its tasks.
#![cfg(unix)]

use std::process::{Command, Output};

use super::{good_tree, repository};
use crate::support::sandbox::{Sandbox, stderr};

/// Runs one task; `facts` are the variables that Slurm, or whoever submits, sets.
fn task(sandbox: &Sandbox, facts: &[(&str, &str)]) -> Output {
    Command::new("bash")
        .arg(repository("workflows/slurm/mcubes.sbatch"))
        .args(["in", "out", "--iso", "50", "-q"])
        .current_dir(sandbox.path(""))
        .env("MCUBES", env!("CARGO_BIN_EXE_mcubes"))
        .env_remove("MCUBES_SHARDS")
        .envs(facts.iter().copied())
        .output()
        .unwrap()
}

/// One of `count` tasks from `min` to `max`.
fn array<'a>(id: &'a str, [min, max, count]: [&'a str; 3]) -> Vec<(&'a str, &'a str)> {
    vec![
        ("SLURM_ARRAY_TASK_ID", id),
        ("SLURM_ARRAY_TASK_MIN", min),
        ("SLURM_ARRAY_TASK_MAX", max),
        ("SLURM_ARRAY_TASK_COUNT", count),
    ]
}

#[test]
fn tasks_of_an_array_are_the_whole_and_one_is_done_again_by_itself() {
    let sandbox = good_tree();
    for id in ["1", "3"] {
        let done = task(&sandbox, &array(id, ["1", "3", "3"]));
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    }
    // The second was lost, and is submitted alone.
    let mut facts = array("2", ["2", "2", "1"]);
    facts.push(("MCUBES_SHARDS", "3"));
    let done = task(&sandbox, &facts);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    sandbox.ends(0, "in -r --iso 50 -o whole -q");
    let meshes = |folder: &str| {
        let mut all = sandbox.tree(folder);
        all.retain(|(name, _)| !name.starts_with("report-"));
        all
    };
    assert!(meshes("out") == meshes("whole"));
}

#[test]
fn an_array_that_is_no_1_to_n_is_refused_before_anything_is_made() {
    let sandbox = good_tree();
    let mut beyond = array("9", ["9", "9", "1"]);
    beyond.push(("MCUBES_SHARDS", "8"));
    for (facts, said) in [
        (array("7", ["7", "7", "1"]), "1 tasks from 7 to 7 are no 1 to N: submit with --array=1-N"),
        (array("0", ["0", "9", "10"]), "10 tasks from 0 to 9 are no 1 to N"),
        // --array=1-9:2, of which the first alone looks like a first of five.
        (array("1", ["1", "9", "5"]), "5 tasks from 1 to 9 are no 1 to N"),
        (beyond, "task 9 is none of 1 to 8"),
    ] {
        let refused = task(&sandbox, &facts);
        let text = stderr(&refused);
        assert_eq!(refused.status.code(), Some(2), "{facts:?}: {text}");
        assert!(text.starts_with("error: ") && text.lines().count() == 1, "{facts:?}: {text}");
        assert!(text.contains(said), "{facts:?}: {text}");
        assert!(!sandbox.path("out").exists(), "{facts:?}");
    }
}
