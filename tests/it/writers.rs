//! Mesh files written, read back by other readers.
