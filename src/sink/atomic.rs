//! Files that appear under their name only when they are whole.
//!
//! A regular target is written to a temporary file in its folder and renamed. What cannot be
//! replaced by renaming (standard output, pipes, devices) is given the temporary file's bytes at
//! the end. A target that is not committed leaves nothing. Nothing is synced to disk.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::SinkError;

/// More symbolic links than this in a row are a circle.
const MAX_LINKS: usize = 40;

/// Where the bytes go when they are whole.
enum Goal {
    /// Renamed to this path; whether folders are made for it.
    Rename(NamedTempFile, PathBuf, bool),
    /// Copied to a file that is open already.
    Copy(File, File),
    /// Copied to standard output.
    Stdout(File),
}

/// A file in the making.
pub(crate) struct Target {
    goal: Goal,
}

impl Target {
    /// Prepares to write `path`. A symbolic link is followed: the file it points to is made or
    /// replaced, and the link stays.
    pub(crate) fn create(path: &Path) -> Result<Self, SinkError> {
        Self::start(path, false)
    }

    /// The same, and makes the folders that are missing above it once the file is whole: one that
    /// comes to nothing leaves no folder either. Until then its bytes lie in the nearest folder that
    /// is there, on the file system that the new ones will be on.
    pub(crate) fn create_with_folders(path: &Path) -> Result<Self, SinkError> {
        Self::start(path, true)
    }

    fn start(path: &Path, makes_folders: bool) -> Result<Self, SinkError> {
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(SinkError::IsFolder),
            Ok(found) if !found.is_file() || is_descriptor(path) => {
                let file = OpenOptions::new().write(true).open(path).map_err(SinkError::Io)?;
                return Ok(Self { goal: Goal::Copy(unnamed()?, file) });
            }
            _ => {}
        }
        let path = follow(path).map_err(SinkError::Io)?;
        let folder = folder_of(&path);
        let folder = if makes_folders { nearest(folder) } else { folder };
        if !folder.is_dir() {
            return Err(SinkError::NoFolder(folder.to_owned()));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".mcubes-").suffix(".part");
        #[cfg(unix)]
        {
            // The umask takes its bits from these, as for any new file.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder).map_err(|e| SinkError::Io(bare(e)))?;
        #[cfg(unix)]
        if let Ok(replaced) = fs::metadata(&path) {
            // Who may read what is replaced may read what replaces it, and nobody else. Some file
            // systems have no modes to set.
            use std::os::unix::fs::PermissionsExt;
            let mode = replaced.permissions().mode() & 0o777;
            let mode = fs::Permissions::from_mode(mode);
            let _ = file.as_file().set_permissions(mode);
        }
        Ok(Self { goal: Goal::Rename(file, path, makes_folders) })
    }

    /// Prepares to write standard output.
    pub(crate) fn stdout() -> Result<Self, SinkError> {
        Ok(Self { goal: Goal::Stdout(unnamed()?) })
    }

    /// The file that takes the bytes for now, open for reading and writing.
    pub(crate) fn file(&self) -> &File {
        match &self.goal {
            Goal::Rename(temporary, ..) => temporary.as_file(),
            Goal::Copy(file, _) | Goal::Stdout(file) => file,
        }
    }

    /// The error of writing to [`Self::file`].
    pub(crate) fn fault(&self, e: io::Error) -> SinkError {
        match &self.goal {
            Goal::Rename(..) => SinkError::Io(e),
            Goal::Copy(..) | Goal::Stdout(_) => temporary(e),
        }
    }

    /// The folder for further temporary files, where it is not the system's.
    pub(super) fn folder(&self) -> Option<&Path> {
        match &self.goal {
            Goal::Rename(temporary, ..) => Some(folder_of(temporary.path())),
            Goal::Copy(..) | Goal::Stdout(_) => None,
        }
    }

    /// Puts the bytes where they belong. A reader that has closed its pipe wants no more of them,
    /// which is no error.
    pub(crate) fn commit(self) -> Result<(), SinkError> {
        let copied = match self.goal {
            Goal::Rename(temporary, path, makes_folders) => {
                if makes_folders {
                    fs::create_dir_all(folder_of(&path)).map_err(SinkError::Io)?;
                }
                return match temporary.persist(path) {
                    Ok(_) => Ok(()),
                    Err(e) => Err(SinkError::Io(e.error)),
                };
            }
            Goal::Copy(from, mut to) => copy(from, &mut to),
            Goal::Stdout(from) => copy(from, &mut io::stdout().lock()),
        };
        match copied {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(SinkError::Io(e)),
            _ => Ok(()),
        }
    }
}

fn copy(mut from: File, to: &mut impl io::Write) -> io::Result<()> {
    from.rewind()?;
    io::copy(&mut from, to)?;
    to.flush()
}

/// A temporary file without a name, in the system's folder for them.
fn unnamed() -> Result<File, SinkError> {
    tempfile::tempfile().map_err(temporary)
}

fn temporary(error: io::Error) -> SinkError {
    SinkError::Temporary { folder: tempfile::env::temp_dir(), error: bare(error) }
}

/// The system's error without the temporary name that `tempfile` adds to it. Its number is only in
/// the words then, and says more than its kind.
fn bare(e: io::Error) -> io::Error {
    if e.get_ref().is_none() {
        return e;
    }
    let text = e.to_string();
    let number = text.split_once("(os error ").and_then(|(_, end)| end.split(')').next());
    match number.and_then(|number| number.parse().ok()) {
        Some(number) => io::Error::from_raw_os_error(number),
        None => io::Error::from(e.kind()),
    }
}

/// Whether the path names an open file of this process, which must be written to, not replaced.
fn is_descriptor(path: &Path) -> bool {
    ["/dev/stdout", "/dev/stderr"].iter().any(|name| path == Path::new(name))
        || path.starts_with("/dev/fd")
        || path.starts_with("/proc")
}

/// The folder that a file stands in; `.` for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The folder itself, or what there is above it, which may be no folder: a file, a link to nothing.
fn nearest(folder: &Path) -> &Path {
    let mut above = folder.ancestors();
    above.find(|above| above.symlink_metadata().is_ok()).unwrap_or(Path::new("."))
}

/// The path at the end of a row of symbolic links, which need not exist.
fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&path) {
            Ok(to) => path = folder_of(&path).join(to),
            // Not a link, or nothing there yet.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}
