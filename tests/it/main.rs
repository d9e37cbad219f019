//! The one integration binary: each module is a list of promises about one part of mcubes, seen
//! through the public library or the command.

#[path = "../support/mod.rs"]
mod support;

mod cli;
mod dicom;
mod dicom_hostile;
mod dicom_synthetic;
mod jpegls;
mod nifti;
mod order;
mod raw;
mod readers;
mod surface;
mod tables;
mod wrap;
mod writers;
