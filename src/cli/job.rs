//! A volume of the inputs and the meshes that are to be made of it. Nothing here reads samples.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::level::Level;
use super::trouble::Trouble;
use crate::error::readable;
use crate::source;
use crate::source::dicom::Study;

/// One volume of the inputs.
pub(crate) struct Scan {
    /// The input as typed, or as found below it.
    pub(crate) path: PathBuf,
    pub(crate) volume: Found,
    /// The folder in the output's tree that it goes to by itself.
    pub(crate) parent: Option<PathBuf>,
}

/// How the volume is had.
pub(crate) enum Found {
    /// A NIfTI or raw file, opened when it is its turn.
    File,
    /// Raw samples.
    Stdin,
    /// A volume of a study whose headers are read.
    Series {
        study: Arc<Study>,
        index: usize,
        /// Whether others of the same file or folder are meshed beside it.
        among: bool,
        /// Whether it was taken where others might have been, without being asked for.
        is_choice: bool,
    },
    /// Nothing that could be meshed, and why.
    Broken(Trouble),
}

/// One mesh that is to be made.
pub(crate) struct Target {
    pub(crate) level: Level,
    pub(crate) output: Destination,
}

/// Where one mesh goes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Destination {
    File(PathBuf),
    Stdout,
}

impl Destination {
    /// As reports have it.
    pub(crate) fn shown(&self) -> String {
        match self {
            Self::File(path) => readable(path),
            Self::Stdout => "-".to_owned(),
        }
    }

    /// The file, if it is one.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Stdout => None,
        }
    }
}

/// A volume and the meshes that are made of it.
pub(crate) struct Job {
    pub(crate) scan: Scan,
    pub(crate) targets: Vec<Target>,
}

impl Scan {
    /// Whether its bytes come only once: a pipe, a device.
    pub(crate) fn is_read_once(&self) -> bool {
        match self.volume {
            Found::Stdin => true,
            Found::File => source::is_stream(&self.path),
            Found::Series { .. } | Found::Broken(_) => false,
        }
    }

    /// The files that the volume is read from, sorted and without doubles where they are many.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        match &self.volume {
            Found::Stdin => Vec::new(),
            Found::File | Found::Broken(_) => source::files(&self.path),
            Found::Series { study, index, .. } => study.files(*index),
        }
    }

    /// The files that no mesh may replace: those of the volume and of all beside it in its study.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        match &self.volume {
            // Where standard input is a file the system may have a name for it.
            Found::Stdin => vec![PathBuf::from("/dev/stdin")],
            Found::Series { study, .. } => {
                (0..study.volumes.len()).flat_map(|index| study.files(index)).collect()
            }
            Found::File | Found::Broken(_) => self.files(),
        }
    }

    /// The input as reports have it.
    pub(crate) fn shown(&self) -> String {
        match self.volume {
            Found::Stdin => "standard input".to_owned(),
            _ => readable(&self.path),
        }
    }
}
