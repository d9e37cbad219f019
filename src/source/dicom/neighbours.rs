//! Images under a volume's UID that are not part of it: how many, and what sets them apart.

use super::candidate::Candidate;
use super::error::DicomError;
use super::instance::{Frame, Instance, frame_name};
use super::layout::{Layout, SampleKind};
use super::series;
use crate::volume::Note;

/// What is said of one volume in the notes of the others.
struct Neighbour {
    apart: Option<String>,
    n_images: usize,
    broken_off: bool,
    is_alone: bool,
}

/// Says of each volume which images under its UID are not part of it, and why: what sets volumes
/// apart by design (an echo, a segment, ...) is no reason for a word.
pub(super) fn note(volumes: &mut [Candidate], instances: &[Instance]) {
    let all: Vec<Neighbour> = volumes
        .iter()
        .map(|v| Neighbour {
            apart: v.apart.clone(),
            n_images: v.series.n_images,
            broken_off: v.broken_off,
            is_alone: is_alone(v),
        })
        .collect();
    let firsts: Vec<Option<(&Instance, &Frame)>> =
        volumes.iter().map(|v| v.frames.first().and_then(|r| r.get(instances))).collect();
    for (index, volume) in volumes.iter_mut().enumerate() {
        let Some(own) = firsts.get(index).copied().flatten() else { continue };
        // An image alone may belong to the series of this name in another study.
        let (is_alone, is_named) = (is_alone(volume), !own.0.series_uid.is_empty());
        let (mut left_out, mut first, mut reasons) = (0, None, Vec::new());
        for (other, (neighbour, frame)) in all.iter().zip(&firsts).enumerate() {
            let of = neighbour.apart == volume.apart || neighbour.broken_off && !volume.broken_off;
            let same = |f: &(&Instance, &Frame)| {
                let same_uid = is_named
                    && (is_alone || neighbour.is_alone)
                    && own.0.series_uid == f.0.series_uid;
                of && other != index && (same_uid || series::same_series(own.0, f.0))
            };
            let Some(frame) = frame.filter(same) else { continue };
            left_out += neighbour.n_images;
            first.get_or_insert_with(|| frame_name(frame));
            if let Some(apart) = neighbour.apart.as_ref().filter(|_| neighbour.broken_off) {
                reasons.push(format!("{apart} was broken off"));
            } else {
                reasons.extend(differences(own, frame));
            }
        }
        let Some(first) = first else { continue };
        // Rising order, so that several neighbours of one kind are one reason.
        reasons.sort();
        reasons.dedup();
        let s = if left_out == 1 { "" } else { "s" };
        let reasons = reasons.join(", ");
        let line = format!("{left_out} image{s} of the same series ({first}): {reasons}");
        if let Some(DicomError::MissingSlices { faults, .. }) = &mut volume.problem {
            faults.clone_from(&line);
        }
        if let Some(DicomError::TooFew { left_out, .. }) = &mut volume.problem {
            left_out.clone_from(&line);
        }
        if let Some(meta) = &mut volume.meta {
            meta.notes.push(Note::Other(format!("left out: {line}")));
        }
    }
}

/// Whether there is but one image, which is no volume.
fn is_alone(volume: &Candidate) -> bool {
    matches!(volume.problem, Some(DicomError::TooFew { .. }))
}

/// What keeps an image out of a volume that begins with another one.
fn differences(own: (&Instance, &Frame), other: (&Instance, &Frame)) -> Vec<String> {
    let (a, b) = (&own.0.layout, &other.0.layout);
    let size = format!("{} rows and {} columns, not {} and {}", b.rows, b.cols, a.rows, a.cols);
    let samples = format!("samples that are {}, not {}", samples(b), samples(a));
    let all = [
        ((a.rows, a.cols) != (b.rows, b.cols)).then_some(size),
        (series::samples(a) != series::samples(b)).then_some(samples),
        attribute(
            "StudyInstanceUID",
            own.0.study_uid.as_ref(),
            other.0.study_uid.as_ref(),
            PartialEq::eq,
        ),
        attribute(
            "FrameOfReferenceUID",
            own.0.frame_of_reference.as_ref(),
            other.0.frame_of_reference.as_ref(),
            PartialEq::eq,
        ),
        attribute("Modality", own.0.modality.as_ref(), other.0.modality.as_ref(), PartialEq::eq),
        // Slices of one volume differ in this, of course.
        attribute("ImagePositionPatient", own.1.position, other.1.position, |_, _| true),
        attribute(
            "ImageOrientationPatient",
            own.1.orientation,
            other.1.orientation,
            series::same_orientation,
        ),
        attribute("PixelSpacing", own.1.spacing, other.1.spacing, series::same_spacing),
    ];
    all.into_iter().flatten().collect()
}

/// What an attribute of another image says against it, if anything.
fn attribute<T>(
    name: &str,
    own: Option<T>,
    other: Option<T>,
    same: impl Fn(&T, &T) -> bool,
) -> Option<String> {
    match (own, other) {
        (Some(own), Some(other)) => (!same(&own, &other)).then(|| format!("another {name}")),
        (Some(_), None) => Some(format!("no {name}")),
        (None, Some(_)) => Some(format!("{name} given")),
        (None, None) => None,
    }
}

fn samples(layout: &Layout) -> &'static str {
    match (layout.kind, layout.bytes) {
        (SampleKind::Bit, _) => "bits",
        (SampleKind::Unsigned | SampleKind::Signed, _) => "integers",
        (SampleKind::Float, 4) => "32-bit floats",
        (SampleKind::Float, _) => "64-bit floats",
    }
}
