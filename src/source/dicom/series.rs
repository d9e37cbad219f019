//! Images into candidate volumes: grouped by what must agree, split where a series mixes several
//! volumes, doubles dropped.

use std::collections::HashMap;

use super::instance::{Frame, Instance, SPLITTERS};
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
}

#[derive(PartialEq, Eq, Hash)]
struct Key<'a> {
    series_uid: &'a str,
    frame_of_reference: Option<&'a str>,
    modality: Option<&'a str>,
    rows: usize,
    cols: usize,
    samples: (SampleKind, usize),
    apart: &'a str,
    placed: bool,
}

/// Gives images without a frame of reference or modality that of their series, where all images
/// that name one name the same: an attribute that some files have lost is no other volume.
pub(super) fn complete(instances: &mut [Instance]) {
    complete_one(instances, |i| &mut i.frame_of_reference);
    complete_one(instances, |i| &mut i.modality);
}

fn complete_one(instances: &mut [Instance], of: impl Fn(&mut Instance) -> &mut Option<String>) {
    let mut agreed: HashMap<String, Option<String>> = HashMap::new();
    for instance in &mut *instances {
        let Some(value) = of(instance).clone() else { continue };
        let one = agreed.entry(instance.series_uid.clone()).or_insert_with(|| Some(value.clone()));
        if one.as_ref() != Some(&value) {
            *one = None;
        }
    }
    for instance in instances {
        if let Some(Some(value)) = agreed.get(&instance.series_uid) {
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
                series_uid: &instance.series_uid,
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
                groups.push(Group { frames: vec![reference], apart, facing });
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

/// Splits a group whose positions hold several images by what the series mixes: echoes, time
/// points, ... Groups that mix nothing come back as they are.
pub(super) fn split(mut group: Group, instances: &[Instance]) -> Vec<Group> {
    let mut done = Vec::new();
    let mut open = vec![(std::mem::take(&mut group), 0)];
    while let Some((mut group, from)) = open.pop() {
        let runs = sort(&mut group, instances);
        let most = runs.iter().map(std::iter::ExactSizeIterator::len).max().unwrap_or(0);
        let parts = (most > 1)
            .then(|| {
                (from..=SPLITTERS.len())
                    .find_map(|s| Some((s, parts(&group, &runs, s, instances)?)))
            })
            .flatten();
        match parts {
            Some((splitter, parts)) => {
                open.extend(parts.into_iter().rev().map(|part| (part, splitter + 1)));
            }
            None => match repeats(&group, &runs, instances) {
                Some(parts) => done.extend(parts),
                None => done.push(group),
            },
        }
    }
    done
}

/// The parts that one splitter makes of a group, if it tells images at one position apart.
fn parts(
    group: &Group,
    runs: &[std::ops::Range<usize>],
    splitter: usize,
    instances: &[Instance],
) -> Option<Vec<Group>> {
    // The last one is what samples are stored as.
    let name = SPLITTERS.get(splitter).unwrap_or(&"samples");
    let label = |r: &FrameRef| {
        let (instance, frame) = r.get(instances)?;
        match frame.mixed.get(splitter) {
            Some(label) => label.clone(),
            None => Some(instance.layout.stored_type().to_string()),
        }
    };
    let labels: Vec<String> = group.frames.iter().map(|r| label(r).unwrap_or_default()).collect();
    let mut values = labels.clone();
    values.sort_by(|a, b| compare_labels(a, b));
    values.dedup();
    if values.len() < 2 {
        return None;
    }
    let tells_apart = runs.iter().filter(|run| run.len() > 1).all(|run| {
        let mut own: Vec<&String> = labels.get((*run).clone()).unwrap_or_default().iter().collect();
        own.sort();
        own.dedup();
        own.len() > 1
    });
    if !tells_apart {
        return None;
    }
    let part = |value: &String| {
        let frames = group.frames.iter().zip(&labels).filter(|(_, l)| *l == value);
        let mut apart = group.apart.clone();
        let shown = if value.is_empty() { "none" } else { value };
        apart.push(format!("{name} {shown}"));
        Group { frames: frames.map(|(r, _)| *r).collect(), apart, facing: group.facing }
    };
    let parts: Vec<Group> = values.iter().map(part).collect();
    // Values that differ from slice to slice would leave splinters.
    if parts.iter().all(|p| p.frames.len() * values.len() * 2 >= group.frames.len()) {
        return Some(parts);
    }
    ranked(group, runs, &labels, name)
}

/// Where each position holds the same number of images, but their labels differ a little from
/// position to position (trigger times): the first of each, the second of each, ...
fn ranked(
    group: &Group,
    runs: &[std::ops::Range<usize>],
    labels: &[String],
    name: &str,
) -> Option<Vec<Group>> {
    let count = runs.first()?.len();
    if runs.iter().any(|run| run.len() != count) {
        return None;
    }
    let mut parts = vec![Group { facing: group.facing, ..Group::default() }; count];
    for run in runs {
        let mut own: Vec<usize> = run.clone().collect();
        let label = |i: usize| labels.get(i).map_or("", String::as_str);
        own.sort_by(|&a, &b| compare_labels(label(a), label(b)));
        if own.windows(2).any(|w| label(w[0]) == label(w[1])) {
            return None;
        }
        for (part, index) in parts.iter_mut().zip(own) {
            part.frames.extend(group.frames.get(index));
        }
    }
    for (rank, part) in parts.iter_mut().enumerate() {
        part.apart.clone_from(&group.apart);
        part.apart.push(format!("{name} number {} of {count}", rank + 1));
    }
    Some(parts)
}

/// A frame behind its InstanceNumber and its number within its file.
type Numbered = ((i64, u64), FrameRef);

/// The repeats of a group whose positions each hold equally many images that no label tells apart
/// (functional MR): the first of each, the second of each, ... by InstanceNumber, then by the
/// frame. Only where these numbers count all positions of one repeat before the next repeat, or all
/// repeats of one position before the next position; any other order could mix them up.
fn repeats(
    group: &Group,
    runs: &[std::ops::Range<usize>],
    instances: &[Instance],
) -> Option<Vec<Group>> {
    let count = runs.first()?.len();
    if count < 2 || runs.len() < 2 || runs.iter().any(|run| run.len() != count) {
        return None;
    }
    let number = |r: FrameRef| r.get(instances).map(|(i, frame)| (i.number, frame.index));
    let mut positions = Vec::with_capacity(runs.len());
    for run in runs {
        let mut own: Vec<Numbered> = group
            .frames
            .get(run.clone())?
            .iter()
            .map(|&r| Some((number(r)?, r)))
            .collect::<Option<_>>()?;
        own.sort_by_key(|(number, _)| *number);
        if own.windows(2).any(|w| w[0].0 == w[1].0) {
            return None;
        }
        positions.push(own);
    }
    let repeats: Vec<Vec<Numbered>> =
        (0..count).map(|n| positions.iter().filter_map(|p| p.get(n).copied()).collect()).collect();
    if !one_after_another(&repeats) && !one_after_another(&positions) {
        return None;
    }
    let part = |(n, repeat): (usize, &Vec<Numbered>)| {
        let mut apart = group.apart.clone();
        apart.push(format!("repeat {} of {count}", n + 1));
        let frames = repeat.iter().map(|(_, r)| *r).collect();
        Group { frames, apart, facing: group.facing }
    };
    Some(repeats.iter().enumerate().map(part).collect())
}

/// Whether the numbers of each list lie above or below those of every other list.
fn one_after_another(lists: &[Vec<Numbered>]) -> bool {
    let mut spans: Vec<_> = lists
        .iter()
        .filter_map(|list| {
            let numbers = || list.iter().map(|(number, _)| *number);
            Some((numbers().min()?, numbers().max()?))
        })
        .collect();
    spans.sort_unstable();
    spans.windows(2).all(|w| w[0].1 < w[1].0)
}

/// Numbers by value, then everything else by its letters.
fn compare_labels(a: &str, b: &str) -> std::cmp::Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(x), Ok(y)) => x.total_cmp(&y).then_with(|| a.cmp(b)),
        (Ok(_), Err(_)) if !b.is_empty() => std::cmp::Ordering::Less,
        (Err(_), Ok(_)) if !a.is_empty() => std::cmp::Ordering::Greater,
        _ => a.cmp(b),
    }
}
