//! Finds the DICOM files of an input and reads their headers, in parallel. Never the pixels.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::blob::{Blob, Shared};
use super::error::{DicomError, FileFault};
use super::instance::{Scanned, scan_file};
use super::set_aside::{SetAside, What};
use super::study::Study;
use crate::cancel::Cancel;
use crate::error::Error;

/// How a study is scanned.
#[derive(Clone, Default)]
pub struct ScanOptions<'a> {
    /// Raised to stop.
    pub cancel: Cancel,
    /// Told how many files were looked at. Called from the threads that look.
    pub progress: Option<&'a (dyn Fn(usize) + Sync)>,
}

/// Scans a folder (all the way down), a file, a zip archive or a DICOMDIR, on the threads of the
/// current rayon pool.
///
/// # Errors
/// An input that cannot be read, that holds no DICOM, or a single file that is damaged.
///
/// # Cost
/// One read of some kilobytes a file; a few kilobytes of memory a file.
pub fn scan(path: &Path, options: &ScanOptions<'_>) -> Result<Study, Error> {
    let at = |fault| Error::at(path, fault);
    let metadata = std::fs::metadata(path).map_err(|e| at(FileFault::io(e)))?;
    let blobs = if metadata.is_dir() {
        in_folder(path, options)?
    } else {
        let mut head = [0; 4];
        let file = std::fs::File::open(path).map_err(|e| at(FileFault::io(e)))?;
        let n = super::blob::read_at(&file, &mut head, 0).map_err(|e| at(FileFault::io(e)))?;
        if n == 4 && head == *b"PK\x03\x04" {
            in_archive(path)?
        } else {
            let blob = Blob::File { path: path.to_owned(), len: metadata.len() };
            return single(path, blob, options);
        }
    };
    read_all(path, blobs, options)
}

/// One file; for a DICOMDIR the folder that it lies in.
fn single(path: &Path, blob: Blob, options: &ScanOptions<'_>) -> Result<Study, Error> {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    // The input itself needs no name within the input.
    let scanned = scan_file(blob, String::new());
    match scanned {
        Scanned::Aside { what: What::Directory, .. } => {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            read_all(path, in_folder(folder, options)?, options)
        }
        Scanned::Broken { fault, .. } => Err(Error::at(path, fault)),
        Scanned::Foreign => Err(Error::at(path, FileFault::NotDicom)),
        Scanned::Aside { what, series } => {
            let aside = SetAside { what, series_number: series, count: 1, first: name };
            Ok(Study::build(path, Vec::new(), vec![aside], Vec::new(), 1))
        }
        Scanned::Image(instance) => {
            Ok(Study::build(path, vec![*instance], Vec::new(), Vec::new(), 1))
        }
    }
}

/// All plain files under a folder, links followed, by name.
pub(super) fn in_folder(
    folder: &Path,
    options: &ScanOptions<'_>,
) -> Result<Vec<(Blob, String)>, Error> {
    let mut blobs = Vec::new();
    for entry in walkdir::WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        if options.cancel.is_raised() {
            return Err(Error::at(folder, DicomError::Interrupted));
        }
        let entry = match entry {
            Ok(entry) => entry,
            // A folder that is a link to one of its parents holds nothing new, and a link to
            // nothing holds nothing.
            Err(e) if e.loop_ancestor().is_some() || e.depth() > 0 && is_absent(&e) => continue,
            Err(e) => {
                let at = e.path().unwrap_or(folder).to_owned();
                let error = e.into_io_error().unwrap_or_else(|| std::io::ErrorKind::Other.into());
                return Err(Error::at(at, FileFault::io(error)));
            }
        };
        if !entry.file_type().is_file() {
            continue;
        }
        let name = entry.path().strip_prefix(folder).unwrap_or(entry.path());
        let name = name.to_string_lossy().into_owned();
        let len = entry.metadata().map_or(0, |m| m.len());
        blobs.push((Blob::File { path: entry.into_path(), len }, name));
    }
    Ok(blobs)
}

fn is_absent(error: &walkdir::Error) -> bool {
    error.io_error().is_some_and(|e| e.kind() == std::io::ErrorKind::NotFound)
}

/// All files of a zip archive, by name.
fn in_archive(path: &Path) -> Result<Vec<(Blob, String)>, Error> {
    let fault =
        |e: &dyn std::error::Error| Error::at(path, FileFault::Zip(super::blob::one_line(e)));
    let shared = Shared::open(path).map_err(|e| Error::at(path, FileFault::io(e)))?;
    let mut archive = zip::ZipArchive::new(shared).map_err(|e| fault(&e))?;
    let mut blobs = Vec::new();
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|e| fault(&e))?;
        if !entry.is_file() {
            continue;
        }
        let name =
            entry.name().map_or_else(|_| format!("entry {index}"), std::borrow::Cow::into_owned);
        let len = entry.size();
        drop(entry);
        blobs.push((Blob::Zipped { archive: archive.clone(), index, len }, name));
    }
    blobs.sort_by(|a, b| a.1.cmp(&b.1));
    Ok(blobs)
}

/// Reads all headers into one study.
fn read_all(
    path: &Path,
    blobs: Vec<(Blob, String)>,
    options: &ScanOptions<'_>,
) -> Result<Study, Error> {
    sort_out(path, read_headers(path, blobs, options)?)
}

/// Reads all headers.
pub(super) fn read_headers(
    path: &Path,
    blobs: Vec<(Blob, String)>,
    options: &ScanOptions<'_>,
) -> Result<Vec<(String, Scanned)>, Error> {
    let seen = AtomicUsize::new(0);
    blobs
        .into_par_iter()
        .map(|(blob, name)| {
            if options.cancel.is_raised() {
                return Err(Error::at(path, DicomError::Interrupted));
            }
            let scanned = scan_file(blob, name.clone());
            let done = seen.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(progress) = options.progress {
                progress(done);
            }
            Ok((name, scanned))
        })
        .collect()
}

/// Makes a study of what was read.
pub(super) fn sort_out(path: &Path, scanned: Vec<(String, Scanned)>) -> Result<Study, Error> {
    let n_files = scanned.len();
    let (mut instances, mut asides, mut faults) = (Vec::new(), Vec::new(), Vec::new());
    for (name, scanned) in scanned {
        match scanned {
            Scanned::Image(instance) => instances.push(*instance),
            Scanned::Foreign => set_aside(&mut asides, What::Foreign, None, name),
            Scanned::Aside { what, series } => {
                set_aside(&mut asides, what, series, name);
            }
            Scanned::Broken { series_uid, fault } => faults.push((name, series_uid, fault)),
        }
    }
    let only_foreign = asides.iter().all(|a| matches!(a.what, What::Foreign));
    if instances.is_empty() && faults.is_empty() && only_foreign {
        return Err(Error::at(path, DicomError::NoImages { files: n_files }));
    }
    Ok(Study::build(path, instances, asides, faults, n_files))
}

fn set_aside(asides: &mut Vec<SetAside>, what: What, series: Option<String>, name: String) {
    match asides.iter_mut().find(|a| a.what == what && a.series_number == series) {
        Some(aside) => aside.count += 1,
        None => asides.push(SetAside { what, series_number: series, count: 1, first: name }),
    }
}
