//! Finds the DICOM files of an input and reads their headers, in parallel. Never the pixels.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::blob::{Blob, Shared};
use super::error::{DicomError, FileFault};
use super::instance::{Instance, Scanned, scan_file};
use super::set_aside::{SetAside, What};
use super::study::Study;
use crate::cancel::Cancel;
use crate::error::{Error, is_circle};

/// How a study is scanned.
#[derive(Clone, Default)]
pub struct ScanOptions<'a> {
    /// Raised to stop.
    pub cancel: Cancel,
    /// Told how many files were looked at. Called from the threads that look.
    pub progress: Option<&'a (dyn Fn(usize) + Sync)>,
    /// Threads that read headers; where nothing is said, those of the current rayon pool.
    pub threads: Option<usize>,
}

/// Scans a folder (all the way down), a file, a zip archive or a DICOMDIR.
///
/// # Errors
/// An input that cannot be read, that holds no DICOM, or a single file that is damaged.
///
/// # Cost
/// One read of some kilobytes a file; a few kilobytes of memory a file.
pub fn scan(path: &Path, options: &ScanOptions<'_>) -> Result<Study, Error> {
    let at = |fault| Error::at(path, fault);
    let metadata = std::fs::metadata(path).map_err(|e| at(FileFault::io(e)))?;
    let found = if metadata.is_dir() {
        in_folder(path, options)?
    } else {
        let mut head = [0; 4];
        let file = Shared::open(path).map_err(|e| at(FileFault::io(e)))?;
        let n = file.fill(&mut head, 0).map_err(|e| at(FileFault::io(e)))?;
        if super::is_zip(head.get(..n).unwrap_or_default()) {
            Found { files: in_archive(path)?, unreadable: Vec::new() }
        } else {
            let blob = Blob::File { path: path.to_owned(), len: metadata.len() };
            return single(path, blob, options);
        }
    };
    read_all(path, found, options)
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
            Ok(Study::build(path, Vec::new(), vec![aside], Vec::new(), 1, &options.cancel))
        }
        Scanned::Image(instance) => {
            Ok(Study::build(path, vec![*instance], Vec::new(), Vec::new(), 1, &options.cancel))
        }
    }
}

/// What lies below an input, each thing by its path from there.
pub(super) struct Found {
    pub(super) files: Vec<(Blob, PathBuf)>,
    /// Folders that cannot be listed, links that cannot be followed.
    pub(super) unreadable: Vec<(PathBuf, FileFault)>,
}

/// All plain files under a folder, links followed, by name.
pub(super) fn in_folder(folder: &Path, options: &ScanOptions<'_>) -> Result<Found, Error> {
    let mut found = Found { files: Vec::new(), unreadable: Vec::new() };
    let inner = |path: &Path| path.strip_prefix(folder).unwrap_or(path).to_owned();
    for entry in walkdir::WalkDir::new(folder).follow_links(true).sort_by_file_name() {
        if options.cancel.is_raised() {
            return Err(Error::at(folder, DicomError::Interrupted));
        }
        let entry = match entry {
            Ok(entry) => entry,
            // A folder that is a link to one of its parents holds nothing new, and a link to
            // nothing holds nothing.
            Err(e) if e.loop_ancestor().is_some() => continue,
            Err(e) => {
                let (at, depth) = (e.path().unwrap_or(folder).to_owned(), e.depth());
                let error = e.into_io_error().unwrap_or_else(|| std::io::ErrorKind::Other.into());
                if depth == 0 {
                    return Err(Error::at(at, FileFault::io(error)));
                }
                if !leads_nowhere(&error) {
                    found.unreadable.push((inner(&at), FileFault::io(error)));
                }
                continue;
            }
        };
        if !entry.file_type().is_file() {
            continue;
        }
        let name = inner(entry.path());
        let len = entry.metadata().map_or(0, |m| m.len());
        found.files.push((Blob::File { path: entry.into_path(), len }, name));
    }
    Ok(found)
}

/// Whether it is the error of a link to nothing, or of links in a circle.
fn leads_nowhere(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory) || is_circle(error)
}

/// All files of a zip archive, by name.
fn in_archive(path: &Path) -> Result<Vec<(Blob, PathBuf)>, Error> {
    let fault =
        |e: &dyn std::error::Error| Error::at(path, FileFault::Zip(super::blob::one_line(e)));
    let shared = Shared::open(path).map_err(|e| Error::at(path, FileFault::io(e)))?;
    let mut archive = zip::ZipArchive::new(shared).map_err(|e| fault(&e))?;
    let mut blobs: Vec<(Blob, PathBuf)> = Vec::new();
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|e| fault(&e))?;
        if !entry.is_file() {
            continue;
        }
        let name =
            entry.name().map_or_else(|_| format!("entry {index}"), std::borrow::Cow::into_owned);
        let len = entry.size();
        drop(entry);
        blobs.push((Blob::Zipped { archive: archive.clone(), index, len }, name.into()));
    }
    blobs.sort_by(|a, b| a.1.as_os_str().cmp(b.1.as_os_str()));
    Ok(blobs)
}

/// Reads all headers into one study.
fn read_all(path: &Path, found: Found, options: &ScanOptions<'_>) -> Result<Study, Error> {
    let broken = |(name, fault)| (name, Scanned::Broken { series_uid: None, fault });
    let mut scanned = read_headers(path, found.files, options)?;
    scanned.extend(found.unreadable.into_iter().map(broken));
    sort_out(path, scanned, options)
}

/// Reads all headers.
pub(super) fn read_headers(
    path: &Path,
    files: Vec<(Blob, PathBuf)>,
    options: &ScanOptions<'_>,
) -> Result<Vec<(PathBuf, Scanned)>, Error> {
    let scanned = on_threads(options.threads, || scan_files(files, options))
        .map_err(|e| Error::at(path, FileFault::io(e)))?;
    // Nothing is known of the files that were left when the run was stopped.
    let all = scanned.into_iter().map(|(name, scanned)| Some((name, scanned?)));
    all.collect::<Option<Vec<_>>>().ok_or_else(|| Error::at(path, DicomError::Interrupted))
}

/// Makes a study of what was read.
pub(super) fn sort_out(
    path: &Path,
    scanned: Vec<(PathBuf, Scanned)>,
    options: &ScanOptions<'_>,
) -> Result<Study, Error> {
    let n_files = scanned.len();
    let (mut instances, mut asides, mut faults) = (Vec::<Instance>::new(), Vec::new(), Vec::new());
    for (name, scanned) in scanned {
        let name = name.to_string_lossy().into_owned();
        match scanned {
            Scanned::Image(instance) => instances.push(*instance),
            Scanned::Foreign => set_aside(&mut asides, What::Foreign, None, name),
            Scanned::Aside { what, series } => {
                set_aside(&mut asides, what, series, name);
            }
            Scanned::Broken { series_uid, fault } => faults.push((name, series_uid, fault)),
        }
    }
    // Pictures of slices are no slices beside any.
    if instances.iter().any(|i| !i.is_capture()) {
        for i in instances.extract_if(.., |i| i.is_capture()) {
            set_aside(&mut asides, What::SecondaryCapture, i.series_number, i.name);
        }
    }
    let only_foreign = asides.iter().all(|a| matches!(a.what, What::Foreign));
    if instances.is_empty() && faults.is_empty() && only_foreign {
        return Err(Error::at(path, DicomError::NoImages { files: n_files }));
    }
    let build = || Study::build(path, instances, asides, faults, n_files, &options.cancel);
    let study =
        on_threads(options.threads, build).map_err(|e| Error::at(path, FileFault::io(e)))?;
    if options.cancel.is_raised() {
        return Err(Error::at(path, DicomError::Interrupted));
    }
    Ok(study)
}

/// Reads the headers of files side by side; nothing of those left when the run is stopped.
fn scan_files(
    files: Vec<(Blob, PathBuf)>,
    options: &ScanOptions<'_>,
) -> Vec<(PathBuf, Option<Scanned>)> {
    let seen = AtomicUsize::new(0);
    files
        .into_par_iter()
        .map(|(blob, name)| {
            if options.cancel.is_raised() {
                return (name, None);
            }
            let scanned = scan_file(blob, name.to_string_lossy().into_owned());
            let done = seen.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(progress) = options.progress {
                progress(done);
            }
            (name, Some(scanned))
        })
        .collect()
}

/// Runs `work` on a pool of so many threads, or on the current one.
fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> std::io::Result<T> {
    let Some(threads) = threads else { return Ok(work()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    pool.map(|pool| pool.install(work)).map_err(std::io::Error::other)
}

fn set_aside(asides: &mut Vec<SetAside>, what: What, series: Option<String>, name: String) {
    match asides.iter_mut().find(|a| a.what == what && a.series_number == series) {
        Some(aside) => aside.count += 1,
        None => asides.push(SetAside { what, series_number: series, count: 1, first: name }),
    }
}
