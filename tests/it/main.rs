//! The one integration binary: each module is a list of promises about one part of mcubes, seen
//! through the public library or the command.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops so")]

#[path = "../support/mod.rs"]
mod support;

mod cli;
mod dicom;
mod jpegls;
mod nifti;
mod order;
mod raw;
mod readers;
mod surface;
mod survey;
mod tables;
mod wrap;
mod writers;
