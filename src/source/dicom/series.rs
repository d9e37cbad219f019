//! Images into groups by what must agree, each in order along its normal. What a series mixes at
//! the same positions is split afterwards (`split`).

use std::collections::HashMap;

use super::instance::{Frame, Instance};
use super::layout::{Layout, SampleKind};
use super::order::{self, Facing};

/// Direction cosines and spacings that differ by less than this part are the same.
const SAME: f64 = 2e-3;

/// A frame by its file's number and its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameRef {
    pub(super) instance: usize,
    pub(super) frame: usize,
}

impl FrameRef {
    /// A slice that no frame was stored for: all zero.
    pub(super) const EMPTY: Self = Self { instance: usize::MAX, frame: usize::MAX };

    pub(super) fn get(self, instances: &[Instance]) -> Option<(&Instance, &Frame)> {
        let instance = instances.get(self.instance)?;
        Some((instance, instance.frames.get(self.frame)?))
    }
}

/// Frames that belong together.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub(super) frames: Vec<FrameRef>,
    /// What sets it apart from others under the same UID, in words.
    pub(super) apart: Vec<String>,
    /// How its frames lie; nothing where they do not say.
    pub(super) facing: Option<Facing>,
    /// Whether it is what there is of a repeat that was broken off.
    pub(super) broken_off: bool,
}

#[derive(PartialEq, Eq, Hash)]
struct Key<'a> {
    series: SeriesKey<'a>,
    frame_of_reference: Option<&'a str>,
    modality: Option<&'a str>,
    rows: usize,
    cols: usize,
    samples: (SampleKind, usize),
    apart: &'a str,
    placed: bool,
}

/// What names a series.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct SeriesKey<'a> {
    uid: &'a str,
    /// Two studies may hold one SeriesInstanceUID: exports that count series from 1.
    study: Option<&'a str>,
    /// SeriesNumber and SeriesDescription, where there is no SeriesInstanceUID to go by.
    instead: Option<(Option<&'a str>, Option<&'a str>)>,
}

pub(super) fn series_key(instance: &Instance) -> SeriesKey<'_> {
    SeriesKey {
        uid: &instance.series_uid,
        study: instance.study_uid.as_deref(),
        instead: instance
            .series_uid
            .is_empty()
            .then_some((instance.series_number.as_deref(), instance.description.as_deref())),
    }
}

/// Whether two images are of one series.
pub(super) fn same_series(a: &Instance, b: &Instance) -> bool {
    series_key(a) == series_key(b)
}

/// Gives images without a study, a frame of reference or a modality that of their series, where all
/// images that name one name the same: an attribute that some files have lost is no other volume.
pub(super) fn complete(instances: &mut [Instance]) {
    complete_one(instances, |i| &mut i.study_uid);
    complete_one(instances, |i| &mut i.frame_of_reference);
    complete_one(instances, |i| &mut i.modality);
}

fn complete_one(instances: &mut [Instance], of: impl Fn(&mut Instance) -> &mut Option<String>) {
    type Series = (String, Option<String>);
    let series = |i: &Instance| -> Series {
        let number = i.series_number.clone().filter(|_| i.series_uid.is_empty());
        (i.series_uid.clone(), number)
    };
    let mut agreed: HashMap<Series, Option<String>> = HashMap::new();
    for instance in &mut *instances {
        let Some(value) = of(instance).clone() else { continue };
        let one = agreed.entry(series(instance)).or_insert_with(|| Some(value.clone()));
        if one.as_ref() != Some(&value) {
            *one = None;
        }
    }
    for instance in instances {
        if let Some(Some(value)) = agreed.get(&series(instance)) {
            of(instance).get_or_insert_with(|| value.clone());
        }
    }
}

/// Groups all frames by what must agree for a volume. The order of groups and frames follows the
/// order of `instances`.
pub(super) fn group(instances: &[Instance]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut by_key: HashMap<Key<'_>, Vec<usize>> = HashMap::new();
    for (i, instance) in instances.iter().enumerate() {
        for (f, frame) in instance.frames.iter().enumerate() {
            let facing = facing(instance, frame);
            let key = Key {
                series: series_key(instance),
                frame_of_reference: instance.frame_of_reference.as_deref(),
                modality: instance.modality.as_deref(),
                rows: instance.layout.rows,
                cols: instance.layout.cols,
                samples: samples(&instance.layout),
                apart: &frame.apart,
                placed: facing.is_some(),
            };
            let alike = by_key.entry(key).or_default();
            let found = alike
                .iter()
                .copied()
                .find(|&g| groups.get(g).is_some_and(|group| same_facing(group.facing, facing)));
            let reference = FrameRef { instance: i, frame: f };
            if let Some(group) = found.and_then(|g| groups.get_mut(g)) {
                group.frames.push(reference);
            } else {
                alike.push(groups.len());
                let apart =
                    if frame.apart.is_empty() { Vec::new() } else { vec![frame.apart.clone()] };
                groups.push(Group { frames: vec![reference], apart, facing, broken_off: false });
            }
        }
    }
    groups
}

/// What must agree of the samples. Integers of any sign and width can be slices of one volume: each
/// is read as its own header says.
pub(super) fn samples(layout: &Layout) -> (SampleKind, usize) {
    match layout.kind {
        SampleKind::Bit => (SampleKind::Bit, 0),
        SampleKind::Unsigned | SampleKind::Signed => (SampleKind::Signed, 0),
        SampleKind::Float => (SampleKind::Float, layout.bytes),
    }
}

/// How a frame lies, if it says so in full.
fn facing(instance: &Instance, frame: &Frame) -> Option<Facing> {
    frame.position?;
    Some(Facing {
        rows: instance.layout.rows,
        cols: instance.layout.cols,
        sample_bytes: instance.layout.bytes,
        orientation: frame.orientation?,
        spacing: frame.spacing?,
    })
}

fn same_facing(a: Option<Facing>, b: Option<Facing>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return a.is_none() && b.is_none() };
    same_orientation(&a.orientation, &b.orientation) && same_spacing(&a.spacing, &b.spacing)
}

pub(super) fn same_orientation(a: &[f64; 6], b: &[f64; 6]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME)
}

pub(super) fn same_spacing(a: &[f64; 2], b: &[f64; 2]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME * x.abs())
}

/// A frame, its file, and its place along the normal.
type Placed<'a> = (f64, &'a Instance, FrameRef);

/// A group's frames in order along the normal, and the runs of frames at one position.
pub(super) fn sort(group: &mut Group, instances: &[Instance]) -> Vec<std::ops::Range<usize>> {
    let Some(facing) = group.facing else { return Vec::new() };
    let mut placed: Vec<Placed<'_>> = group
        .frames
        .iter()
        .filter_map(|&r| {
            let (instance, frame) = r.get(instances)?;
            Some((facing.along(frame.position?), instance, r))
        })
        .collect();
    let lower = |a: &Placed<'_>, b: &Placed<'_>| {
        (a.1.number, &a.1.name, a.2.frame).cmp(&(b.1.number, &b.1.name, b.2.frame))
    };
    placed.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| lower(a, b)));
    let places: Vec<f64> = placed.iter().map(|p| p.0).collect();
    let runs = order::positions(&places);
    for run in &runs {
        if let Some(same) = placed.get_mut(run.clone()) {
            same.sort_by(lower);
        }
    }
    group.frames = placed.into_iter().map(|p| p.2).collect();
    runs
}
