//! The promise, on volumes of every kind.
