//! What ends a run from outside: signals, limits, readers that go away.

use std::io::Read;
use std::process::{Command, Stdio};

use super::{plain, volume};
use crate::support::sandbox::{Sandbox, objects, stderr};

/// The shell's limit counts in blocks of 512 or 1,024 bytes; the mesh has 12 MB.
#[cfg(unix)]
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

/// What goes to standard output waits in a temporary file, which is what was too small.
#[cfg(unix)]
#[test]
fn a_temporary_file_of_a_phantom_is_told_as_what_it_is() {
    for more in ["", " --noise 9 --threads 1"] {
        let sandbox = Sandbox::new();
        let command = format!(
            "ulimit -f 100; exec '{}' phantom sphere -o -{more}",
            env!("CARGO_BIN_EXE_mcubes"),
        );
        let mut shell = Command::new("sh");
        shell.args(["-c", &command]).current_dir(sandbox.path("")).env("TMPDIR", sandbox.path(""));
        let output = shell.stdout(Stdio::null()).output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.starts_with("error: standard output: the temporary file in "), "{said}");
        assert!(said.contains("hint: TMPDIR names another folder"), "{said}");
    }
}

/// A run that is stopped half way leaves its folder as it was.
#[cfg(unix)]
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

#[cfg(unix)]
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

#[test]
fn limits_and_temporary_files_are_told_as_what_they_are() {
    let sandbox = Sandbox::new();
    let output = sandbox.run(&[&plain(), "--iso", "0.5", "-o", "x.stl", "--max-memory", "1"]);
    assert!(stderr(&output).contains("the limit is 1 byte\n"), "{}", stderr(&output));
    let output = sandbox.run(&[&plain(), "--iso", "0.5", "-o", "x.stl", "--max-memory", "1025"]);
    assert!(stderr(&output).contains("the limit is 1 025 bytes\n"), "{}", stderr(&output));
    let mut command = sandbox.command(&[&plain(), "--iso", "0.5", "-o", "-"]);
    let output = command.env("TMPDIR", "/nowhere").output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("the temporary file in /nowhere cannot be written: there is no such folder"),
        "{said}"
    );
    assert!(said.contains("hint: TMPDIR names another folder for it"), "{said}");
}

/// A command that is sent `signal` once it has read more than `n_bytes`; its status, or nothing
/// where it went on for a minute.
#[cfg(target_os = "linux")]
fn stopped_after(sandbox: &Sandbox, words: &str, n_bytes: u64) -> Option<i32> {
    let mut child = sandbox
        .command(&words.split(' ').collect::<Vec<_>>())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let facts = format!("/proc/{}/io", child.id());
    let read = || {
        let text = std::fs::read_to_string(&facts).unwrap_or_default();
        let n = text.lines().find_map(|line| line.strip_prefix("rchar: "));
        n.and_then(|n| n.parse::<u64>().ok()).unwrap_or(u64::MAX)
    };
    while read() <= n_bytes {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(child.try_wait().unwrap(), None, "{words}: ended before it was stopped");
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    status_in_a_minute(&mut child)
}

#[cfg(unix)]
fn status_in_a_minute(child: &mut std::process::Child) -> Option<i32> {
    let began = std::time::Instant::now();
    loop {
        match child.try_wait().unwrap() {
            Some(status) => return status.code(),
            None if began.elapsed().as_secs() > 60 => {
                child.kill().unwrap();
                child.wait().unwrap();
                return None;
            }
            None => std::thread::sleep(std::time::Duration::from_millis(5)),
        }
    }
}

/// Zeros that take no room on the disk, and some time to be counted.
#[cfg(target_os = "linux")]
#[test]
fn one_signal_stops_a_look_at_all_values() {
    const N_BYTES: u64 = 1 << 30;
    let sandbox = Sandbox::new();
    let file = std::fs::File::create(sandbox.path("big.raw")).unwrap();
    file.set_len(N_BYTES).unwrap();
    let raw = "big.raw --dims 1024x1024x1024 --type u8";
    for (words, n_bytes) in [
        (format!("info {raw}"), 16 << 20),
        (format!("info {raw} --json"), 16 << 20),
        (format!("{raw} --iso auto -o x.stl"), 16 << 20),
        // The second look, for the range.
        (format!("{raw} --iso 200 -o x.stl"), N_BYTES + (16 << 20)),
    ] {
        assert_eq!(stopped_after(&sandbox, &words, n_bytes), Some(130), "{words}");
        assert_eq!(sandbox.files(), ["big.raw"], "{words}");
    }
}

/// The pipe is opened by the command after its handlers stand, and never has an end.
#[cfg(unix)]
#[test]
fn one_signal_ends_check_wherever_it_is() {
    let sandbox = Sandbox::new();
    let pipe = sandbox.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for signal in ["-INT", "-TERM"] {
        let mut child = sandbox.command(&["check", "pipe"]).spawn().unwrap();
        let _held = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        assert_eq!(status_in_a_minute(&mut child), Some(130), "{signal}");
    }
}

/// Whether a command is at its input by now.
#[cfg(target_os = "linux")]
fn is_waiting(id: u32) -> bool {
    let tasks = std::fs::read_dir(format!("/proc/{id}/task")).into_iter().flatten().flatten();
    let names = tasks.map(|task| std::fs::read_to_string(task.path().join("comm")));
    names.flatten().any(|name| name == "input\n")
}

/// A pipe that nobody writes to keeps even waiting whoever opens it.
#[cfg(target_os = "linux")]
#[test]
fn one_signal_ends_a_wait_for_a_pipe() {
    for words in [
        "pipe --iso 50 -o x.stl",
        "pipe --iso 50 -o out/",
        "pipe --dims 9x9x9 --type u8 --iso 50 -o x.ply",
        "pair.hdr --iso 50 -o x.stl",
        "info pipe",
        "- --dims 9x9x9 --type u8 --iso 50 -o x.stl",
        "info - --dims 9x9x9 --type u8",
    ] {
        let sandbox = Sandbox::new();
        for pipe in ["pipe", "pair.img"] {
            assert!(Command::new("mkfifo").arg(sandbox.path(pipe)).status().unwrap().success());
        }
        std::fs::copy(volume("nifti/synth/pair_n2.hdr"), sandbox.path("pair.hdr")).unwrap();
        let mut child = sandbox
            .command(&words.split(' ').collect::<Vec<_>>())
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let _held = child.stdin.take();
        while !is_waiting(child.id()) {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        assert_eq!(status_in_a_minute(&mut child), Some(130), "{words}");
        let mut files = sandbox.files();
        files.sort();
        assert_eq!(files, ["pair.hdr", "pair.img", "pipe"], "{words}");
    }
}

/// The mesh is begun, and then nothing more comes.
#[cfg(unix)]
#[test]
fn one_signal_ends_a_wait_for_the_rest_of_a_stream() {
    use std::io::Write;
    let mut plane = vec![0_u8; 64 * 64];
    plane[64 * 32 + 32] = 200;
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(&plane.repeat(100)).unwrap();
    let gzip = gzip.finish().unwrap();
    for bytes in [&plane.repeat(100), &gzip[..gzip.len() / 2]] {
        let sandbox = Sandbox::new();
        let words = "- --dims 64x64x1000 --type u8 --iso 100 -o m.ply -q";
        let mut child = sandbox
            .command(&words.split(' ').collect::<Vec<_>>())
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(bytes).unwrap();
        while sandbox.files().is_empty() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert_eq!(status_in_a_minute(&mut child), Some(130));
        assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
    }
}

/// `/dev/full` takes nothing, as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_an_error() {
    let sandbox = Sandbox::new();
    for words in [&["--help"][..], &["--version"], &["info", "--help"], &["help"], &["man"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = sandbox.command(words).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).starts_with("error: standard output: "), "{}", stderr(&output));
    }
}

/// Two meshes at a pipe: the second is never opened for writing by anybody.
#[cfg(unix)]
#[test]
fn a_signal_that_ends_check_is_told_as_json_of_the_mesh_it_was_at() {
    let sandbox = Sandbox::new();
    sandbox.ends(0, &format!("{} --iso 50 -o a.stl -q", volume("nifti/synth/t_u8_le.nii")));
    let pipe = sandbox.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let args = ["check", "a.stl", "pipe", "never.stl", "--json"];
    let child =
        sandbox.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let _held = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let told = objects(&output);
    assert_eq!(told.len(), 2, "{told:?}");
    assert_eq!(told[0]["ok"], true);
    assert_eq!(
        (&told[1]["input"], &told[1]["error"]["kind"]),
        (&"pipe".into(), &"interrupted".into())
    );
}

/// More than a pipe holds, of which one byte is taken.
#[cfg(unix)]
#[test]
fn one_signal_ends_a_run_whose_output_nobody_takes() {
    let sandbox = Sandbox::new();
    let head = volume("ct_head.nii.gz");
    let words = format!("{head} --iso 300 -o - -q");
    let phantom = "phantom sphere -o -".to_owned();
    for words in [words, phantom] {
        let args: Vec<&str> = words.split(' ').collect();
        let mut child =
            sandbox.command(&args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut out = child.stdout.take().unwrap();
        out.read_exact(&mut [0]).unwrap();
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        assert_eq!(status_in_a_minute(&mut child), Some(130), "{words}");
        assert!(sandbox.files().is_empty(), "{words}: {:?}", sandbox.files());
    }
}
