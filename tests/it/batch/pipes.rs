//! Pipes as inputs: their bytes come only once.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::repository;
use crate::support::sandbox::{Sandbox, stderr};

fn volume() -> std::path::PathBuf {
    repository("testdata/nifti/synth/t_u8_le.nii")
}

/// Runs with a pipe as input that is written once, and kills what waits for a second writer.
fn once(words: &str) -> (Sandbox, Option<i32>, String) {
    let sandbox = Sandbox::new();
    let pipe = sandbox.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut child = sandbox
        .command(&words.split_whitespace().collect::<Vec<_>>())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Not waited for: nobody may ever read it.
    std::thread::spawn(move || {
        let bytes = std::fs::read(volume()).unwrap();
        let mut pipe = std::fs::OpenOptions::new().write(true).open(pipe)?;
        std::io::Write::write_all(&mut pipe, &bytes)
    });
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > Duration::from_secs(50) {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    (sandbox, output.status.code(), stderr(&output))
}

#[test]
fn a_pipe_is_read_once() {
    let plain = Sandbox::new();
    plain.copy(&volume(), "plain.nii");
    plain.ends(0, "plain.nii --iso 50 -o plain.stl -q");
    for (words, mesh) in [
        ("pipe --iso 50 -o piped.stl -q", "piped.stl"),
        // A folder, whose record of finished work looks at the inputs.
        ("pipe --iso 50 -o out/ -q", "out/pipe.stl"),
    ] {
        let (sandbox, status, said) = once(words);
        assert_eq!((status, said.as_str()), (Some(0), ""), "{words}");
        assert!(sandbox.bytes(mesh) == plain.bytes("plain.stl"), "{words}");
    }
    let (_, status, said) = once("info pipe");
    assert_eq!((status, said.as_str()), (Some(0), ""));
}

#[test]
fn what_a_pipe_would_have_to_be_read_again_for_is_refused_or_left_out() {
    let (_, status, said) = once("pipe --iso 30000 -o x.stl");
    assert_eq!(status, Some(1), "{said}");
    assert_eq!(said, "error: pipe: there is no surface at the iso value 30000\n");
    for words in ["pipe -o x.stl", "pipe --iso auto -o x.stl", "pipe -o out/"] {
        let (_, status, said) = once(words);
        assert_eq!(status, Some(2), "{words}: {said}");
        assert!(said.contains("pipe: is no regular file and is read once: "), "{said}");
    }
    let (_, status, said) = once("pipe --iso 50 -o x.stl --dry-run");
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("pipe: is read once: --dry-run cannot look at it"), "{said}");
}
