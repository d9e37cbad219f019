//! A tree of folders that holds many studies, and files that are no DICOM at all.
//!
//! Each folder is a study of its own, for copies of one series may lie in several. A series whose
//! images are spread over folders is put together, unless two of the folders have an image at the
//! same place: then each holds a volume of its own.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::instance::{Instance, Scanned};
use super::scan::{ScanOptions, in_folder, read_headers, sort_out};
use super::study::Study;
use crate::error::Error;

/// What lies below a folder.
pub struct Tree {
    /// One a folder that directly holds DICOM, and one a series that is spread over several. In the
    /// order of their folders.
    pub studies: Vec<Study>,
    /// The files that are no DICOM, in order.
    pub foreign: Vec<PathBuf>,
    /// Folders that cannot be listed and links that cannot be followed, with why.
    pub unreadable: Vec<Error>,
}

/// Reads the headers of all DICOM files below a folder, on the threads of the current rayon pool.
///
/// # Errors
/// The folder itself cannot be read; a stop that was asked for. What is wrong with single files
/// stands in the studies.
///
/// # Cost
/// As [`super::scan`].
pub fn scan_tree(folder: &Path, options: &ScanOptions<'_>) -> Result<Tree, Error> {
    let found = in_folder(folder, options)?;
    let unreadable = found.unreadable.into_iter();
    let unreadable = unreadable.map(|(name, fault)| Error::at(folder.join(name), fault)).collect();
    let mut foreign = Vec::new();
    let mut folders: BTreeMap<PathBuf, Files> = BTreeMap::new();
    for (name, scanned) in read_headers(folder, found.files, options)? {
        if matches!(scanned, Scanned::Foreign) {
            foreign.push(folder.join(&name));
        } else {
            let own = name.parent().unwrap_or(Path::new("")).to_owned();
            folders.entry(own).or_default().push((name, scanned));
        }
    }
    for (common, images) in take_spread(&mut folders) {
        folders.entry(common).or_default().extend(images);
    }
    folders.retain(|_, files| !files.is_empty());
    let studies = folders
        .into_iter()
        .map(|(own, files)| {
            let files = files.into_iter().map(|(name, scanned)| within(&own, name, scanned));
            sort_out(&at(folder, &own), files.collect(), options)
        })
        .collect::<Result<_, _>>()?;
    Ok(Tree { studies, foreign, unreadable })
}

fn at(folder: &Path, own: &Path) -> PathBuf {
    if own.as_os_str().is_empty() { folder.to_owned() } else { folder.join(own) }
}

/// The same file, named from its study's folder.
fn within(own: &Path, name: PathBuf, scanned: Scanned) -> (PathBuf, Scanned) {
    let name = name.strip_prefix(own).map(Path::to_owned).unwrap_or(name);
    match scanned {
        Scanned::Image(mut instance) => {
            instance.name = name.to_string_lossy().into_owned();
            (name, Scanned::Image(instance))
        }
        other => (name, other),
    }
}

type Files = Vec<(PathBuf, Scanned)>;

/// Takes the images of series that are spread over folders out of them; with the folder that is
/// above all of theirs.
fn take_spread(folders: &mut BTreeMap<PathBuf, Files>) -> Vec<(PathBuf, Files)> {
    let mut homes: HashMap<String, Vec<PathBuf>> = HashMap::new();
    for (own, files) in &*folders {
        for instance in files.iter().filter_map(image) {
            let homes = homes.entry(instance.series_uid.clone()).or_default();
            if homes.last() != Some(own) {
                homes.push(own.clone());
            }
        }
    }
    let mut spread: Vec<(String, Vec<PathBuf>)> = homes
        .into_iter()
        .filter(|(uid, homes)| !uid.is_empty() && homes.len() > 1 && is_apart(folders, uid, homes))
        .collect();
    spread.sort();
    let mut taken = Vec::new();
    for (uid, homes) in spread {
        let Some(common) = homes.iter().cloned().reduce(|a, b| common(&a, &b)) else { continue };
        let mut images = Vec::new();
        for home in &homes {
            let Some(files) = folders.get_mut(home) else { continue };
            let (own, rest): (Files, Files) = std::mem::take(files)
                .into_iter()
                .partition(|file| image(file).is_some_and(|i| i.series_uid == uid));
            *files = rest;
            images.extend(own);
        }
        taken.push((common, images));
    }
    taken
}

fn image(file: &(PathBuf, Scanned)) -> Option<&Instance> {
    match &file.1 {
        Scanned::Image(instance) => Some(instance),
        _ => None,
    }
}

/// Whether no two of the folders have an image of the series at one place, and all have a place.
fn is_apart(folders: &BTreeMap<PathBuf, Files>, uid: &str, homes: &[PathBuf]) -> bool {
    let mut seen: HashSet<[u64; 3]> = HashSet::new();
    for files in homes.iter().filter_map(|home| folders.get(home)) {
        let mut own = HashSet::new();
        for instance in files.iter().filter_map(image).filter(|i| i.series_uid == uid) {
            for frame in &instance.frames {
                let Some(position) = frame.position else { return false };
                // Adding zero makes one zero of two.
                own.insert(position.map(|v| (v + 0.0).to_bits()));
            }
        }
        if !seen.is_disjoint(&own) {
            return false;
        }
        seen.extend(own);
    }
    true
}

fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}
