//! Signals, limits and readers that go away: what ends a run from outside.
#![cfg(unix)]

use std::process::{Command, Stdio};

use crate::support::repository;
use crate::support::sandbox::{Sandbox, stderr};

fn volume(name: &str) -> String {
    repository("testdata").join(name).display().to_string()
}

/// The shell's limit counts in blocks of 512 or 1,024 bytes; the mesh has 12 MB.
#[test]
fn a_limit_on_the_size_of_files_is_an_error_of_the_write_and_leaves_nothing() {
    let sandbox = Sandbox::new();
    let command = format!(
        "ulimit -f 2000; exec '{}' '{}' --iso 300 -o skull.stl",
        env!("CARGO_BIN_EXE_mcubes"),
        volume("ct_head.nii.gz")
    );
    let output =
        Command::new("sh").args(["-c", &command]).current_dir(sandbox.path("")).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).starts_with("error: skull.stl: cannot be written"));
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}

/// A run that is stopped half way leaves its folder as it was.
#[test]
fn a_signal_stops_the_run_with_status_130_and_leaves_nothing() {
    use std::io::Write;
    for signal in ["-INT", "-TERM"] {
        let sandbox = Sandbox::new();
        let args = "- --dims 64x64x100000 --type u8 --iso 100 -o m.ply -q";
        let mut child = sandbox
            .command(&args.split(' ').collect::<Vec<_>>())
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let mut plane = vec![0_u8; 64 * 64];
        plane[64 * 32 + 32] = 200;
        let mut asked = false;
        let status = loop {
            // Planes go on coming, slowly: far more are promised than will ever be sent.
            let _ = stdin.write_all(&plane);
            std::thread::sleep(std::time::Duration::from_millis(1));
            if !asked && !sandbox.files().is_empty() {
                let id = child.id().to_string();
                assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
                asked = true;
            }
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
        };
        assert!(asked, "ended before it had begun to write");
        assert_eq!(status.code(), Some(130), "{signal}");
        assert!(sandbox.files().is_empty(), "{signal}: {:?}", sandbox.files());
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let sandbox = Sandbox::new();
    let head = volume("ct_head.nii.gz");
    let mut child = sandbox
        .command(&[&head, "--iso", "300", "-o", "-", "-q"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(output.stderr.is_empty());
}
