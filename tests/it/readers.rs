//! Mesh files read back, and their topology.
