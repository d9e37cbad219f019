//! The record of finished work in an output folder: a line a mesh, written after the mesh has its
//! name, so that a line is never there without a whole mesh.
//!
//! A line that was cut short, by a kill or a full disk, says nothing and is passed over. Meshes are
//! believed only if size and checksum are those of the line.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde_json::{Value, json};

use super::identity;
use crate::cli::job::{Scan, Target};
use crate::cli::options::Extract;

/// How the record's files begin; each shard has one of its own, so that shards may run on machines
/// that share a folder.
const PREFIX: &str = ".mcubes-done";

/// The layout of a line.
const SCHEMA: &str = "mcubes-done/1";

/// What must be the same for a mesh to be believed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Made {
    version: &'static str,
    options: String,
    input: String,
}

impl Made {
    /// Of this input, as its identity says, with these options, by this version.
    fn new(extract: &Extract, target: &Target, input: String) -> Self {
        // Every option that decides the bytes is in here, whatever options there are.
        let options = format!("{extract:?} {:?}", target.level);
        Self { version: env!("CARGO_PKG_VERSION"), options, input }
    }
}

/// The record of one output folder.
pub(super) struct Record {
    folder: PathBuf,
    own: PathBuf,
    known: HashMap<String, Vec<Value>>,
    file: Mutex<Option<File>>,
}

impl Record {
    /// Of a folder that need not exist yet. What is known is read only to `resume`.
    pub(super) fn open(folder: &Path, shard: Option<(usize, usize)>, resume: bool) -> Self {
        let own = match shard {
            Some((part, of)) => format!("{PREFIX}-{part}-of-{of}.jsonl"),
            None => format!("{PREFIX}.jsonl"),
        };
        let known = if resume { read_all(folder) } else { HashMap::new() };
        Self { own: folder.join(own), folder: folder.to_owned(), known, file: Mutex::new(None) }
    }

    /// Whether the mesh at `path` is there, whole, and made just so.
    fn has(&self, path: &Path, made: &Made) -> bool {
        let lines = self.known.get(&self.key(path)).map(Vec::as_slice).unwrap_or_default();
        let mut alike = lines.iter().filter(|line| {
            line["version"] == made.version
                && line["options"] == made.options
                && line["input"] == made.input
        });
        let Some(first) = alike.next() else { return false };
        let Ok((size, sum)) = identity::of_output(path) else { return false };
        std::iter::once(first).chain(alike).any(|l| l["size"] == size && l["crc32"] == sum)
    }

    /// Writes down that the mesh at `path` is whole.
    ///
    /// # Errors
    /// The mesh cannot be read back, the record not written.
    fn add(&self, path: &Path, made: &Made) -> io::Result<()> {
        let (size, crc32) = identity::of_output(path)?;
        let line = json!({
            "schema": SCHEMA,
            "output": self.key(path),
            "version": made.version,
            "options": made.options,
            "input": made.input,
            "size": size,
            "crc32": crc32,
        });
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        if file.is_none() {
            *file = Some(open_for_lines(&self.own)?);
        }
        let Some(file) = file.as_mut() else { return Ok(()) };
        // One call, so that lines of several processes do not mix.
        file.write_all(format!("{line}\n").as_bytes())
    }

    /// The mesh's path below the folder.
    fn key(&self, path: &Path) -> String {
        path.strip_prefix(&self.folder).unwrap_or(path).to_string_lossy().into_owned()
    }
}

/// What a record knows of the meshes of one scan.
pub(super) struct Known<'a> {
    record: &'a Record,
    extract: &'a Extract,
    /// What the scan is read from, where that can be read again.
    input: Option<String>,
}

impl<'a> Known<'a> {
    pub(super) fn of(record: &'a Record, extract: &'a Extract, scan: &Scan) -> Self {
        Self { record, extract, input: identity::of_input(scan).ok() }
    }

    fn made<'t>(&self, target: &'t Target) -> Option<(&'t Path, Made)> {
        let input = self.input.clone()?;
        Some((target.output.path()?, Made::new(self.extract, target, input)))
    }

    /// Whether the mesh is there already; never where there is no resuming.
    pub(super) fn is_done(&self, target: &Target) -> bool {
        self.made(target).is_some_and(|(path, made)| self.record.has(path, &made))
    }

    /// Writes down that the mesh is whole.
    ///
    /// # Errors
    /// The mesh cannot be read back, the record not written.
    pub(super) fn write_down(&self, target: &Target) -> io::Result<()> {
        self.made(target).map_or(Ok(()), |(path, made)| self.record.add(path, &made))
    }
}

/// Opens a record to add to it; a line that was cut short is ended first.
fn open_for_lines(path: &Path) -> io::Result<File> {
    let mut file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        let mut last = [0];
        file.read_exact(&mut last)?;
        if last != *b"\n" {
            file.write_all(b"\n")?;
        }
    }
    Ok(file)
}

/// All whole lines of all records of a folder, by output.
fn read_all(folder: &Path) -> HashMap<String, Vec<Value>> {
    let mut known: HashMap<String, Vec<Value>> = HashMap::new();
    let Ok(entries) = std::fs::read_dir(folder) else { return known };
    for entry in entries.flatten() {
        if !entry.file_name().to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        let Ok(bytes) = std::fs::read(entry.path()) else { continue };
        for line in bytes.split(|&b| b == b'\n') {
            let Ok(line) = serde_json::from_slice::<Value>(line) else { continue };
            if line["schema"] == SCHEMA
                && let Some(output) = line["output"].as_str()
            {
                known.entry(output.to_owned()).or_default().push(line);
            }
        }
    }
    known
}
