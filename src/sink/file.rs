//! The sink that writes one mesh file.
//!
//! What stands with the vertices goes straight to the file. Faces of formats that have both wait
//! in memory, beyond a bound in an unnamed temporary file beside the target, and follow at the
//! end. The header is written first with its counts open, and again when they are known.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use tempfile::SpooledTempFile;

use super::atomic::Target;
use super::format::{Layout, MeshOptions};
use super::{Encoded, Encoder, MeshFormat, Sink, SinkError};
use crate::geom::Space;

/// Faces kept in memory, in bytes.
pub(crate) const SPOOL_BYTES: usize = 64 << 20;

/// Small patches are gathered to writes of this many bytes.
const WRITE_BYTES: usize = 256 << 10;

/// A mesh file in the making. [`MeshFile::commit`] gives it its name; dropped before, it leaves
/// nothing behind.
pub struct MeshFile {
    target: Target,
    layout: Box<dyn Layout>,
    options: MeshOptions,
    /// A second handle on the target's file.
    out: BufWriter<File>,
    faces: Option<BufWriter<SpooledTempFile>>,
    n_vertex_bytes: u64,
    n_face_bytes: u64,
    finished: bool,
}

impl MeshFile {
    /// Starts a file that will stand at `path`. An existing file is replaced at the end; a
    /// symbolic link is followed; a pipe or device is written to at the end.
    ///
    /// # Errors
    /// The path is a folder, its folder is missing, or the system does not let it be written.
    pub fn create(path: &Path, options: &MeshOptions) -> Result<Self, SinkError> {
        Self::start(Target::create(path)?, *options)
    }

    /// As [`MeshFile::create`], and makes the folders that are missing above the file when it gets its
    /// name.
    ///
    /// # Errors
    /// What stands in the place of a folder is none, or the system does not let it be written.
    pub fn create_with_folders(path: &Path, options: &MeshOptions) -> Result<Self, SinkError> {
        Self::start(Target::create_with_folders(path)?, *options)
    }

    /// Starts a file that goes to standard output when it is whole.
    ///
    /// # Errors
    /// There is no room for a temporary file.
    pub fn stdout(options: &MeshOptions) -> Result<Self, SinkError> {
        Self::start(Target::stdout()?, *options)
    }

    fn start(target: Target, options: MeshOptions) -> Result<Self, SinkError> {
        let layout = options.layout();
        let file = target.file().try_clone().map_err(|e| target.fault(e))?;
        let mut out = BufWriter::with_capacity(WRITE_BYTES, file);
        out.write_all(&layout.header(0, 0)).map_err(|e| target.fault(e))?;
        let faces = (options.format != MeshFormat::Stl).then(|| {
            let spool = match target.folder() {
                Some(folder) => tempfile::spooled_tempfile_in(SPOOL_BYTES, folder),
                None => tempfile::spooled_tempfile(SPOOL_BYTES),
            };
            BufWriter::with_capacity(WRITE_BYTES, spool)
        });
        Ok(Self {
            target,
            layout,
            options,
            out,
            faces,
            n_vertex_bytes: 0,
            n_face_bytes: 0,
            finished: false,
        })
    }

    /// Gives the finished file its name, or copies it to where it goes.
    ///
    /// # Errors
    /// The file was not finished, or the system does not let it be put there.
    pub fn commit(mut self) -> Result<(), SinkError> {
        if !self.finished {
            return Err(SinkError::Internal("a mesh file was committed before it was finished"));
        }
        self.out.flush().map_err(|e| self.target.fault(e))?;
        self.target.commit()
    }

    fn check(&self, n_vertices: u64, n_triangles: u64) -> Result<(), SinkError> {
        let format = self.options.format;
        for (what, found, limit) in [
            ("triangles", n_triangles, format.max_triangles()),
            ("vertices", n_vertices, format.max_vertices()),
        ] {
            if found > limit {
                return Err(SinkError::TooMany { what, found, limit });
            }
        }
        if let Some((vertex, face)) = self.layout.strides()
            && (vertex.saturating_mul(n_vertices) != self.n_vertex_bytes
                || face.saturating_mul(n_triangles) != self.n_face_bytes)
        {
            return Err(SinkError::Internal("the patches written are not the totals given"));
        }
        Ok(())
    }

    fn complete(&mut self, n_vertices: u64, n_triangles: u64) -> io::Result<()> {
        if let Some(faces) = self.faces.take() {
            let mut faces = faces.into_inner().map_err(io::IntoInnerError::into_error)?;
            faces.rewind()?;
            self.out.flush()?;
            match faces.into_inner() {
                tempfile::SpooledData::InMemory(bytes) => {
                    self.out.get_mut().write_all(bytes.get_ref())?;
                }
                // From file to file, which the system may do by itself.
                tempfile::SpooledData::OnDisk(mut file) => {
                    io::copy(&mut file, self.out.get_mut())?;
                }
            }
        }
        self.out.write_all(self.layout.footer())?;
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&self.layout.header(n_vertices, n_triangles))?;
        self.out.flush()
    }
}

impl Sink for MeshFile {
    fn encoder(&self) -> Arc<dyn Encoder> {
        self.layout.encoder()
    }

    fn space(&self) -> Option<Space> {
        Some(self.options.space)
    }

    fn normals(&self) -> bool {
        self.options.normals && self.options.format != MeshFormat::Stl
    }

    fn append(&mut self, encoded: &Encoded) -> Result<(), SinkError> {
        self.n_vertex_bytes += encoded.vertices.len() as u64;
        self.n_face_bytes += encoded.faces.len() as u64;
        self.out.write_all(&encoded.vertices).map_err(|e| self.target.fault(e))?;
        match &mut self.faces {
            Some(faces) => faces.write_all(&encoded.faces),
            None => self.out.write_all(&encoded.faces),
        }
        .map_err(|e| self.target.fault(e))
    }

    fn finish(&mut self, n_vertices: u64, n_triangles: u64) -> Result<(), SinkError> {
        self.check(n_vertices, n_triangles)?;
        self.complete(n_vertices, n_triangles).map_err(|e| self.target.fault(e))?;
        self.finished = true;
        Ok(())
    }
}
