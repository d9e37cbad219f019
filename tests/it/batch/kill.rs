//! A process that is killed outright, again and again.

use std::process::Stdio;
use std::time::Duration;

use super::good_tree;
use crate::support::sandbox::Sandbox;

const N_POINTS: usize = 24;

/// Enough scans for a run to be caught at any stage.
fn tree() -> Sandbox {
    let sandbox = good_tree();
    for n in 0..6 {
        sandbox.copy(&sandbox.path("in/a"), &format!("in/copy{n}/a"));
        sandbox.copy(&sandbox.path("in/study"), &format!("in/copy{n}/study"));
    }
    sandbox
}

#[cfg(unix)]
#[test]
fn a_run_that_was_killed_anywhere_ends_in_the_same_bytes_when_it_is_resumed() {
    let sandbox = tree();
    let run = |out: &str, more: &str| {
        let words = format!("in -r --iso 50 --iso 60 --format ply -o {out} -q {more}");
        let words: Vec<&str> = words.split_whitespace().collect();
        sandbox.command(&words).stdin(Stdio::null()).spawn().unwrap()
    };
    assert!(run("whole", "").wait().unwrap().success());
    let whole = sandbox.tree("whole");
    assert_eq!(whole.len(), 2 * (5 + 6 * 3));
    // A point is so many meshes and some microseconds, which no load on the machine moves. A run
    // that has ended before it is no point, and tried again.
    let (mut n_runs, mut point) = (0, 0);
    while point < N_POINTS {
        let out = format!("out{n_runs}");
        n_runs += 1;
        assert!(n_runs < 200, "{point} points");
        let mut child = run(&out, "");
        let n_meshes = whole.len() * point / N_POINTS;
        while sandbox.names(&out).len() < n_meshes && child.try_wait().unwrap().is_none() {}
        std::thread::sleep(Duration::from_micros(point as u64 * 211 % 1500));
        child.kill().unwrap();
        if child.wait().unwrap().success() {
            continue;
        }
        for mesh in sandbox.tree(&out) {
            assert!(whole.contains(&mesh), "point {point}: {} is not whole", mesh.0);
        }
        assert!(run(&out, "--resume").wait().unwrap().success(), "point {point}");
        assert!(sandbox.tree(&out) == whole, "point {point}");
        point += 1;
    }
    eprintln!("{N_POINTS} kills in {n_runs} runs");
}

/// One folder, killed until it is done.
#[cfg(unix)]
#[test]
fn a_run_that_is_killed_again_and_again_comes_to_its_end() {
    let sandbox = tree();
    sandbox.ends(0, "in -r --iso 50 -o whole -q");
    let whole = sandbox.tree("whole");
    let mut wait = Duration::from_millis(4);
    let mut most = 0;
    for _ in 0..200 {
        let args = ["in", "-r", "--iso", "50", "-o", "out", "-q", "--resume"];
        let mut child = sandbox.command(&args).stdin(Stdio::null()).spawn().unwrap();
        std::thread::sleep(wait);
        child.kill().unwrap();
        let is_done = child.wait().unwrap().success();
        let n = sandbox.tree("out").len();
        assert!(n >= most, "a finished mesh was lost");
        most = n;
        if is_done {
            assert!(sandbox.tree("out") == whole);
            return;
        }
        wait = wait * 6 / 5;
    }
    panic!("not done after 200 runs");
}
