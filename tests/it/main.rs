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
mod containers;
mod convergence;
mod cpu;
mod dicom;
mod dicom_careless;
mod dicom_enhanced;
mod dicom_frames;
mod dicom_hostile;
mod dicom_ljpeg;
mod dicom_lone;
mod dicom_memory;
mod dicom_mixed;
mod dicom_placed;
mod dicom_refused;
mod dicom_repeats;
mod dicom_segments;
mod dicom_series;
mod dicom_synthetic;
mod dicom_values;
mod invariance;
mod jpegls;
mod library;
#[cfg(target_os = "linux")]
mod memory;
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
