//! The one integration binary: each module is a list of promises about one part of mcubes, seen
//! through the public library or the command.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops so")]
#![allow(clippy::trivially_copy_pass_by_ref, reason = "two-letter words in tests")]
#![allow(unreachable_pub, reason = "one crate, shared helpers")]

#[path = "../support/mod.rs"]
mod support;

mod batch;
mod cells;
mod cli;
mod cli_dicom;
mod convergence;
mod dicom;
mod dicom_enhanced;
mod dicom_frames;
mod dicom_hostile;
mod dicom_ljpeg;
mod dicom_memory;
mod dicom_mixed;
mod dicom_refused;
mod dicom_segments;
mod dicom_series;
mod dicom_synthetic;
mod dicom_values;
mod jpegls;
mod nifti;
mod nifti_hostile;
mod normals;
mod oracle;
mod order;
mod phantom;
mod placed;
mod raw;
mod read_back;
mod readers;
mod steps;
mod surface;
mod survey;
mod tables;
mod tetra;
mod topology;
mod wrap;
mod writers;
