//! Ceilings that are charged before anything is allocated for a number that came from a file.

/// The largest plane of samples that is read, in bytes: 32768 × 32768 of `f32`. A header that
/// claims more is refused before its planes are allocated.
pub const MAX_PLANE_BYTES: u64 = 4 << 30;

/// The largest plane in samples, 32768 × 32768: crossings of one layer then fit a `u32`.
pub const MAX_PLANE_SAMPLES: u64 = 1 << 30;

/// The largest header block or metadata element read into memory, in bytes.
pub const MAX_HEADER_BYTES: u64 = 256 << 20;

/// The most memory that listing the frames of one DICOM file takes, in bytes: some hundred
/// thousand frames. Their number is a claim that costs a file a few bytes.
pub const MAX_FRAMES_BYTES: u64 = 256 << 20;

/// Vertex ids are `u32` in every format written, and PLY readers take them as signed: a mesh has at
/// most as many vertices as this.
pub const MAX_VERTICES: u64 = i32::MAX as u64;

/// Binary STL counts its triangles in a `u32`; the other formats are held to the same number.
pub const MAX_TRIANGLES: u64 = u32::MAX as u64;
