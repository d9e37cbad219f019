//! The command in an empty folder of its own.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// A folder that goes away with it.
pub struct Sandbox(pub tempfile::TempDir);

impl Sandbox {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Something in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn command<S: AsRef<OsStr>>(&self, args: &[S]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mcubes"));
        command.args(args).current_dir(self.0.path()).env_remove("NO_COLOR");
        command
    }

    pub fn run<S: AsRef<OsStr>>(&self, args: &[S]) -> Output {
        self.command(args).stdin(Stdio::null()).output().unwrap()
    }

    /// Runs words divided by spaces, which must end with this status; what it said and reported.
    pub fn ends(&self, status: i32, words: &str) -> (String, Vec<Value>) {
        let output = self.run(&words.split_whitespace().collect::<Vec<_>>());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(status), "{words}: {said}");
        let reported = if words.contains("--json") { objects(&output) } else { Vec::new() };
        (said, reported)
    }

    /// The names of the files that are there.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.path().join(name)).unwrap()
    }

    /// Copies a file, or a folder with all that is in it, to a path in the sandbox.
    pub fn copy(&self, from: &Path, to: &str) {
        let to = self.path(to);
        for entry in walkdir::WalkDir::new(from) {
            let entry = entry.unwrap();
            let inner = entry.path().strip_prefix(from).unwrap();
            let to = if inner.as_os_str().is_empty() { to.clone() } else { to.join(inner) };
            if entry.file_type().is_dir() {
                std::fs::create_dir_all(&to).unwrap();
            } else {
                std::fs::create_dir_all(to.parent().unwrap()).unwrap();
                std::fs::copy(entry.path(), &to).unwrap();
            }
        }
    }

    /// Every file below a folder that is no record and no temporary file, with its bytes.
    pub fn tree(&self, folder: &str) -> Vec<(String, Vec<u8>)> {
        let folder = self.path(folder);
        let files = walkdir::WalkDir::new(&folder).sort_by_file_name().into_iter().flatten();
        files
            .filter(|e| e.file_type().is_file())
            .filter(|e| !e.file_name().to_string_lossy().starts_with(".mcubes-"))
            .map(|e| {
                let name = e.path().strip_prefix(&folder).unwrap().display().to_string();
                (name, std::fs::read(e.path()).unwrap())
            })
            .collect()
    }

    /// The names of [`Self::tree`].
    pub fn names(&self, folder: &str) -> Vec<String> {
        self.tree(folder).into_iter().map(|(name, _)| name).collect()
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The one JSON object on standard output.
pub fn object(output: &Output) -> Value {
    let mut objects = objects(output);
    assert_eq!(objects.len(), 1, "{objects:?}");
    objects.remove(0)
}

/// The JSON objects on standard output, one a line.
pub fn objects(output: &Output) -> Vec<Value> {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Those of the objects that have this status.
pub fn with_status<'v>(objects: &'v [Value], status: &str) -> Vec<&'v Value> {
    objects.iter().filter(|o| o["status"] == status).collect()
}
