//! Several images at one position: copies are dropped, different ones are in each other's way.

use rayon::prelude::*;

use super::error::{DicomError, others};
use super::instance::{Instance, frame_name};
use super::pixels::Pixels;
use super::series::{FrameRef, Group};
use crate::cancel::Cancel;
use crate::volume::Note;

/// Keeps one frame a position. Doubles of the same samples are dropped with a note; different
/// images at one position are an error.
pub(super) fn drop_doubles(
    group: &Group,
    runs: &[std::ops::Range<usize>],
    instances: &[Instance],
    cancel: &Cancel,
    notes: &mut Vec<Note>,
) -> (Vec<FrameRef>, Option<DicomError>) {
    if runs.is_empty() {
        return (group.frames.clone(), None);
    }
    // Samples are compared side by side: a folder may hold every image twice.
    let settled: Vec<Position> = runs
        .par_iter()
        .map(|run| {
            let same = group.frames.get(run.clone()).unwrap_or_default();
            one_position(same, instances, cancel)
        })
        .collect();
    let (mut kept, mut dropped, mut conflicts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut faulty, mut count) = (Vec::new(), 0);
    for position in settled {
        kept.extend(position.kept);
        dropped.extend(position.dropped);
        count += usize::from(!position.conflicts.is_empty());
        conflicts.extend(position.conflicts);
        faulty.extend(position.faulty);
    }
    if !dropped.is_empty() {
        let count = dropped.len();
        let s = if count == 1 { "" } else { "s" };
        let first = dropped.first().cloned().unwrap_or_default();
        notes.push(Note::Other(format!("{count} double image{s} left out ({first})")));
    }
    if let Some(first) = faulty.first() {
        let more = others(faulty.len() - 1);
        notes.push(Note::Other(format!(
            "left out, as a whole image is in its place: {first}{more}"
        )));
    }
    let problem = (count > 0).then(|| {
        conflicts.truncate(3);
        DicomError::Conflict { count, names: conflicts.join(", ") }
    });
    (kept, problem)
}

/// What is left of the frames at one position, and the names of the others.
#[derive(Default)]
struct Position {
    kept: Option<FrameRef>,
    dropped: Vec<String>,
    conflicts: Vec<String>,
    /// Damaged ones in whose place there is a whole one, with what is wrong.
    faulty: Vec<String>,
}

fn one_position(same: &[FrameRef], instances: &[Instance], cancel: &Cancel) -> Position {
    let mut position = Position::default();
    for &other in same {
        let Some(b) = other.get(instances) else { continue };
        let Some(a) = position.kept.and_then(|best| best.get(instances)) else {
            position.kept = Some(other);
            continue;
        };
        if let Some(fault) = &b.0.fault {
            position.faulty.push(format!("{}: {fault}", frame_name(b)));
        } else if let Some(fault) = &a.0.fault {
            position.faulty.push(format!("{}: {fault}", frame_name(a)));
            position.kept = Some(other);
        } else if !cancel.is_raised() && Pixels::same_frame(a, b, cancel) {
            position.dropped.push(frame_name(b));
        } else {
            position.conflicts.push(format!("{} and {}", frame_name(a), frame_name(b)));
        }
    }
    position
}
