//! What the meshes are called: patterns, and fields that cannot leave the output folder.

use std::path::{Component, Path, PathBuf};

use super::clash;
use crate::cli::job::{Destination, Found, Job, Scan, Target};
use crate::cli::level::Level;
use crate::cli::options::Run;
use crate::cli::output::Output;
use crate::cli::pattern::{Field, Pattern};
use crate::cli::usage::Usage;
use crate::error::readable;
use crate::source::dicom::PatientField;

/// The most bytes of one name that all file systems take, less what a temporary name adds.
const MAX_NAME: usize = 200;

impl Scan {
    fn field(&self, field: Field, level: Level, labels: &str) -> String {
        match field {
            Field::Stem => tame(&self.stem()),
            Field::File => tame(&self.file()),
            Field::Parent => self.folders().join("/"),
            Field::Series => self.series().unwrap_or_else(|| "1".to_owned()),
            Field::Modality => tame(&self.modality().unwrap_or_else(|| "none".to_owned())),
            Field::Iso => level.to_string(),
            Field::Label => tame(labels),
            Field::Patient(field) => {
                tame(&self.patient(field).unwrap_or_else(|| "none".to_owned()))
            }
        }
    }

    /// The folders that `{parent}` stands for: of what was found, those below the input; of what
    /// was typed, those typed.
    fn folders(&self) -> Vec<String> {
        let typed = || self.path.parent().unwrap_or(Path::new(""));
        folder_names(self.parent.as_deref().unwrap_or_else(typed)).collect()
    }

    /// What `{parent}/{file}` stands for.
    pub(super) fn below(&self) -> Vec<String> {
        let mut names = self.folders();
        names.push(tame(&self.file()));
        names
    }

    fn file(&self) -> String {
        let name = self.path.file_name().map(readable);
        // `.` and `..` have no name of their own.
        let name = name.or_else(|| {
            let whole = self.path.canonicalize().ok()?;
            Some(readable(whole.file_name()?))
        });
        name.unwrap_or_else(|| "mesh".to_owned())
    }

    /// The name without what says that it is a volume.
    fn stem(&self) -> String {
        let name = self.file();
        if self.path.is_dir() {
            return name;
        }
        let plain = strip(&name, &["gz"]).unwrap_or(&name);
        let known = ["nii", "hdr", "img", "raw", "dcm", "dicom", "zip"];
        strip(plain, &known).unwrap_or(plain).to_owned()
    }

    /// The number that `--series` knows the volume by.
    pub(super) fn series(&self) -> Option<String> {
        match &self.volume {
            Found::Series { index, .. } => Some((index + 1).to_string()),
            _ => None,
        }
    }

    fn patient(&self, field: PatientField) -> Option<String> {
        match &self.volume {
            Found::Series { study, index, .. } => study.patient(*index, field),
            _ => None,
        }
    }

    fn order(&self) -> (&Path, Option<usize>) {
        let index = match &self.volume {
            Found::Series { index, .. } => Some(*index),
            _ => None,
        };
        (&self.path, index)
    }

    fn modality(&self) -> Option<String> {
        match &self.volume {
            Found::Series { study, index, .. } => study.volumes.get(*index)?.modality.clone(),
            _ => None,
        }
    }

    /// The name where no pattern is given.
    fn plain_name(&self, level: Level, several_levels: bool) -> PathBuf {
        let mut suffix = String::new();
        if let Found::Series { index, among: true, .. } = &self.volume {
            suffix = format!("_series{}", index + 1);
        }
        if several_levels {
            suffix = format!("{suffix}_iso{level}");
        }
        let below = self.parent.as_deref().unwrap_or(Path::new(""));
        folder_names(below).chain([tame_before(&self.stem(), &suffix)]).collect()
    }
}

/// The folders of a path by their names, which lead nowhere else.
fn folder_names(path: &Path) -> impl Iterator<Item = String> {
    path.components().filter_map(|c| match c {
        Component::Normal(name) => Some(tame(&readable(name))),
        _ => None,
    })
}

/// The name below the output folder, without extension, that a pattern gives a mesh.
fn pattern_name(pattern: &Pattern, scan: &Scan, level: Level, labels: &str) -> PathBuf {
    let name = pattern.filled(|field| scan.field(field, level, labels));
    name.split('/').filter(|part| !part.is_empty() && *part != ".").map(tame).collect()
}

/// The name before an extension that is one of `known`, if anything is left.
fn strip<'a>(name: &'a str, known: &[&str]) -> Option<&'a str> {
    let (stem, extension) = name.rsplit_once('.')?;
    let is_known = known.iter().any(|k| extension.eq_ignore_ascii_case(k));
    (is_known && !stem.is_empty()).then_some(stem)
}

/// A file name that every system takes and that names no other folder.
fn tame(text: &str) -> String {
    tame_before(text, "")
}

/// The same with `suffix`, which needs no taming, behind it. Where it would be too long it is cut
/// before the suffix, and a checksum of all of `text` keeps names apart that begin alike.
fn tame_before(text: &str, suffix: &str) -> String {
    if suffix.len() > MAX_NAME / 2 {
        return tame(&format!("{text}{suffix}"));
    }
    let bad = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let mut name: String = text.chars().map(|c| if bad(c) { '_' } else { c }).collect();
    if name.is_empty() || name.chars().all(|c| c == '.' || c == ' ') {
        name = "_".repeat(name.len().max(1));
    }
    if name.len() + suffix.len() > MAX_NAME {
        let sum = format!("-{:08x}", crc32fast::hash(text.as_bytes()));
        while name.len() + sum.len() + suffix.len() > MAX_NAME && name.pop().is_some() {}
        name.push_str(&sum);
    }
    name + suffix
}

/// Gives each mesh its place. The order depends on the inputs alone, not on how they were typed:
/// by path, then by the number of the series.
///
/// # Errors
/// Two meshes with one name, a mesh that would replace an input.
pub(super) fn jobs(scans: Vec<Scan>, run: &Run) -> Result<Vec<Job>, Usage> {
    let labels: Vec<String> = run.extract.mask.iter().flatten().map(ToString::to_string).collect();
    let labels = labels.join("+");
    let place = |scan: &Scan, level: Level| match &run.output {
        Output::Stdout => Destination::Stdout,
        Output::File(path) => Destination::File(path.clone()),
        Output::Folder(folder) => {
            let name = match &run.pattern {
                Some(pattern) => pattern_name(pattern, scan, level, &labels),
                None => scan.plain_name(level, run.levels.len() > 1),
            };
            Destination::File(folder.join(with_extension(name, run.extract.mesh.format.as_str())))
        }
    };
    let mut jobs: Vec<Job> = scans
        .into_iter()
        .map(|scan| {
            let target = |&level| Target { level, output: place(&scan, level) };
            Job { targets: run.levels.iter().map(target).collect(), scan }
        })
        .collect();
    jobs.sort_by(|a, b| a.scan.order().cmp(&b.scan.order()));
    clash::refuse(&jobs, run.config.as_deref())?;
    Ok(jobs)
}

/// The name with the format's extension, unless it has it.
fn with_extension(name: PathBuf, extension: &str) -> PathBuf {
    if name.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)) {
        return name;
    }
    let mut name = name.into_os_string();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_names() {
        assert_eq!(tame("a/../b"), "a_.._b");
        assert_eq!(tame(".."), "__");
        assert_eq!(tame(""), "_");
        assert_eq!(tame("Müller^Ä\n"), "Müller^Ä_");
        assert!(tame(&"ä".repeat(300)).len() <= MAX_NAME);
        assert_ne!(tame(&format!("{}1", "ä".repeat(300))), tame(&format!("{}2", "ä".repeat(300))));
        let long = tame_before(&".".repeat(300), "_series12_iso-300.5");
        assert!(long.ends_with("_series12_iso-300.5") && long.len() <= MAX_NAME, "{long}");
        assert!(tame_before("a", &format!("_iso{}", 1e-300)).len() <= MAX_NAME);
    }
}
