//! Planes of a plain file, from any place and any thread: one system call a plane, straight into
//! the buffer that is lent.

use std::fs::File;
use std::io;

use ndarray::ArrayViewMut2;

use super::layout::{IntoPlanes, Layout};
use super::{Planes, PositionedPlanes, SourceError};
use crate::volume::Sample;

/// A regular, uncompressed file whose size has been checked against its layout.
pub(super) struct FilePlanes {
    file: FileAt,
    layout: Layout,
}

impl FilePlanes {
    pub(super) fn new(file: File, layout: Layout) -> Self {
        Self { file: FileAt::new(file), layout }
    }

    /// Fills `out` with the samples from byte `start`.
    fn read<T: Sample>(
        &self,
        start: u64,
        mut out: ArrayViewMut2<'_, T>,
    ) -> Result<(), SourceError> {
        let rows = out.as_slice_mut().ok_or(SourceError::PlaneBuffer)?;
        let bytes = bytemuck::cast_slice_mut::<T, u8>(rows);
        let n = self.file.fill(bytes, start)?;
        // The file was long enough when it was opened, so it has shrunk since.
        if n < bytes.len() {
            return Err(self.layout.ends_early(start + n as u64));
        }
        self.layout.to_native(rows);
        Ok(())
    }
}

impl<T: Sample> PositionedPlanes<T> for FilePlanes {
    fn read_plane(&self, k: usize, out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        self.read(self.layout.plane_start(k), out)
    }

    fn read_rows(
        &self,
        k: usize,
        first: usize,
        out: ArrayViewMut2<'_, T>,
    ) -> Result<bool, SourceError> {
        let row_bytes = (self.layout.dims.nx() * size_of::<T>()) as u64;
        self.read(self.layout.plane_start(k) + first as u64 * row_bytes, out)?;
        Ok(true)
    }
}

impl IntoPlanes for FilePlanes {
    fn planes<T: Sample>(self) -> Planes<'static, T> {
        Planes::Positioned(Box::new(self))
    }
}

/// A file read at positions that each call names, without moving a shared cursor where the system
/// can do that.
pub(super) struct FileAt {
    #[cfg(any(unix, windows))]
    file: File,
    #[cfg(not(any(unix, windows)))]
    file: std::sync::Mutex<File>,
}

impl FileAt {
    pub(super) fn new(file: File) -> Self {
        #[cfg(not(any(unix, windows)))]
        let file = std::sync::Mutex::new(file);
        Self { file }
    }

    /// Fills `out` from byte `start`; how many bytes there were, fewer only at the file's end.
    pub(super) fn fill(&self, out: &mut [u8], start: u64) -> io::Result<usize> {
        let mut done = 0;
        while let Some(rest) = out.get_mut(done..).filter(|rest| !rest.is_empty()) {
            match self.read_at(rest, start + done as u64) {
                Ok(0) => break,
                Ok(n) => done += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        Ok(done)
    }

    /// Fills what one call gives of `out` from byte `at`.
    #[cfg(unix)]
    pub(super) fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        std::os::unix::fs::FileExt::read_at(&self.file, out, at)
    }

    #[cfg(windows)]
    pub(super) fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        std::os::windows::fs::FileExt::seek_read(&self.file, out, at)
    }

    #[cfg(not(any(unix, windows)))]
    pub(super) fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.seek(SeekFrom::Start(at))?;
        file.read(out)
    }
}
