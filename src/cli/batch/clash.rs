//! No two meshes with one name, and none in the place of a file that a scan is read from. Looks at
//! names in the file system; opens nothing but headers that may name a second file.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::cli::job::{Found, Job, Scan};
use crate::cli::usage::Usage;
use crate::sink::folder_of;

/// Whether the system's file systems mostly take names that differ only in case for one.
const IGNORES_CASE: bool = cfg!(any(windows, target_os = "macos"));

const OTHER_NAME: &str = "choose another name with -o or --name";

/// Refuses meshes that would take each other's place, or that of an input.
///
/// # Errors
/// The first pair that clashes.
pub(super) fn refuse(jobs: &[Job], config: Option<&Path>) -> Result<(), Usage> {
    refuse_doubles(jobs)?;
    refuse_inputs(jobs, config)
}

fn refuse_doubles(jobs: &[Job]) -> Result<(), Usage> {
    let mut taken: HashMap<Cow<'_, OsStr>, &Scan> = HashMap::new();
    let fit = jobs.iter().filter(|job| !matches!(job.scan.volume, Found::Broken(_)));
    for job in fit {
        for target in &job.targets {
            let Some(path) = target.output.path() else { continue };
            let Some(other) = taken.insert(place(path, IGNORES_CASE), &job.scan) else { continue };
            let (a, b) = (other.shown(), job.scan.shown());
            let hint = if other.path == job.scan.path {
                "an input or an --iso given twice? {series} and {iso} in --name tell the meshes of one input apart"
            } else if other.below() != job.scan.below() {
                "--name '{parent}/{file}' keeps folders and extensions apart"
            } else {
                "no --name tells them apart: rename one, or mesh them into two folders"
            };
            let both = if a == b { format!("two meshes of {a}") } else { format!("{a} and {b}") };
            return Err(Usage::new(format!("{both} would both be {}", path.display())).hint(hint));
        }
    }
    Ok(())
}

/// What two paths have in common if they are one place.
fn place(path: &Path, ignores_case: bool) -> Cow<'_, OsStr> {
    match path.to_str() {
        Some(text) if ignores_case => OsString::from(text.to_lowercase()).into(),
        _ => path.as_os_str().into(),
    }
}

/// Holds every mesh against the file of options and every file of every scan.
fn refuse_inputs(jobs: &[Job], config: Option<&Path>) -> Result<(), Usage> {
    let outputs = jobs.iter().flat_map(|job| &job.targets).filter_map(|t| t.output.path());
    // Mostly none is there yet, and inputs need not be looked at.
    let there: HashMap<PathBuf, &Path> =
        outputs.filter_map(|path| Some((path.canonicalize().ok()?, path))).collect();
    if there.is_empty() {
        return Ok(());
    }
    let config = config.and_then(|path| there.get(&path.canonicalize().ok()?));
    if let Some(path) = config {
        let message = format!("{}: the output is the file of --config", path.display());
        return Err(Usage::new(message).hint(OTHER_NAME));
    }
    let mut folders = Folders::default();
    let mut studies = HashSet::new();
    for Job { scan, .. } in jobs {
        // Of a study also what is not meshed: it is an input all the same.
        if let Found::Series { study, .. } = &scan.volume
            && !studies.insert(Arc::as_ptr(study))
        {
            continue;
        }
        for file in scan.inputs() {
            let Some(path) = folders.whole(&file).and_then(|whole| there.get(&whole)) else {
                continue;
            };
            let shown = path.display();
            return Err(if file == scan.path {
                Usage::new(format!("{shown}: the output is the input"))
            } else {
                Usage::new(format!(
                    "{shown}: the output is a file that {} is read from",
                    scan.shown()
                ))
            }
            .hint(OTHER_NAME));
        }
    }
    Ok(())
}

/// Canonical paths of many files in few folders: each folder is looked up once, of each file only
/// whether it is a link.
#[derive(Default)]
struct Folders(HashMap<PathBuf, Option<PathBuf>>);

impl Folders {
    fn whole(&mut self, file: &Path) -> Option<PathBuf> {
        let name: OsString = match file.file_name() {
            Some(name) if !file.is_symlink() => name.to_owned(),
            _ => return file.canonicalize().ok(),
        };
        let folder = folder_of(file);
        let known = self.0.entry(folder.to_owned()).or_insert_with(|| folder.canonicalize().ok());
        Some(known.as_ref()?.join(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn case_tells_places_apart_where_the_system_does() {
        let [a, b] = ["out/Ä.stl", "out/ä.STL"].map(Path::new);
        assert_eq!(place(a, true), place(b, true));
        assert_ne!(place(a, false), place(b, false));
    }
}
