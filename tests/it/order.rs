//! Imports go one way.
