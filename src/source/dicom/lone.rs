//! Identifiers that every image has one of its own of. They name nothing and keep slices apart that
//! belong together: anonymisers make a study or a series of each file, converters a stack of each
//! frame.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use super::instance::{Frame, Instance};
use super::series::series_key;

/// Two images may well be of two studies, or of a patient who was moved.
const LEAST: usize = 3;

/// This share of the places makes all of them: a few images may keep the value that others have.
const NEARLY_ALL: f64 = 0.75;

const SERIES: &str = "each image has a SeriesInstanceUID of its own: taken for one series";

const STUDIES: &str = "each image has a StudyInstanceUID of its own: taken for one study";

const FRAMES: &str =
    "each image has a FrameOfReferenceUID of its own: taken to lie in one frame of reference";

/// Takes series, studies and frames of reference of one image, and stacks of one frame, for one
/// where there is nearly nothing else.
pub(super) fn join(instances: &mut [Instance]) {
    // No UID says that they are one series: all else that names it must, and each has its place.
    let named = |i: &Instance| {
        let is_placed = i.frames.iter().all(|frame| frame.position.is_some());
        let series = (i.study_uid.clone()?, i.series_number.clone()?, i.description.clone());
        (is_placed && !i.series_uid.is_empty()).then_some((series, i.modality.clone()))
    };
    let lone = each_its_own(instances, named, |i| Some(&i.series_uid));
    for instance in chosen(instances, &lone) {
        instance.series_uid.clear();
        instance.odd.push(SERIES);
    }
    let studies = |i: &Instance| (!i.series_uid.is_empty()).then(|| i.series_uid.clone());
    let lone = each_its_own(instances, studies, |i| i.study_uid.as_deref());
    for instance in chosen(instances, &lone) {
        instance.study_uid = None;
        instance.odd.push(STUDIES);
    }
    let lone =
        each_its_own(instances, |i| Some(series_key(i)), |i| i.frame_of_reference.as_deref());
    for instance in chosen(instances, &lone) {
        instance.frame_of_reference = None;
        instance.odd.push(FRAMES);
    }
    join_stacks(instances);
}

fn chosen<'a>(
    instances: &'a mut [Instance],
    which: &'a [bool],
) -> impl Iterator<Item = &'a mut Instance> {
    instances.iter_mut().zip(which).filter_map(|(instance, &is)| is.then_some(instance))
}

/// Of each image whether its series, where it has one, has a value of its own at nearly each place.
fn each_its_own<'a, S: Hash + Eq>(
    instances: &'a [Instance],
    series: impl Fn(&'a Instance) -> Option<S>,
    value: impl Fn(&'a Instance) -> Option<&'a str>,
) -> Vec<bool> {
    // The values of each series, and where the images that have one of them lie.
    let mut all: HashMap<S, HashMap<Option<&str>, HashSet<[u64; 3]>>> = HashMap::new();
    for (at, instance) in instances.iter().enumerate() {
        let Some(series) = series(instance) else { continue };
        let places = all.entry(series).or_default().entry(value(instance)).or_default();
        for (frame, n) in instance.frames.iter().zip(0_u64..) {
            // What has no position is nowhere else.
            let nowhere = [at as u64, n, u64::MAX];
            places.insert(frame.position.map_or(nowhere, |p| p.map(f64::to_bits)));
        }
    }
    // Echoes, repeats and copies of a slice may share its value.
    let is_joined = |values: &HashMap<Option<&str>, HashSet<[u64; 3]>>| {
        let named = values.iter().filter(|(value, _)| value.is_some());
        let lone = named.filter(|(_, places)| places.len() == 1).count();
        let n_places: usize = values.values().map(HashSet::len).sum();
        lone >= LEAST && lone as f64 >= NEARLY_ALL * n_places as f64
    };
    all.retain(|_, values| is_joined(values));
    instances.iter().map(|i| series(i).is_some_and(|series| all.contains_key(&series))).collect()
}

fn join_stacks(instances: &mut [Instance]) {
    // The frames of a file, or the images of a series that are alone in their files.
    let key = |(at, i): (usize, &Instance)| (i.series_uid.clone(), (i.n_frames > 1).then_some(at));
    let mut stacks: HashMap<_, Lone<'_>> = HashMap::new();
    for (at, instance) in instances.iter().enumerate() {
        let lone = stacks.entry(key((at, instance))).or_default();
        instance.frames.iter().for_each(|frame| lone.add(stack(frame)));
    }
    let joined: HashSet<_> =
        stacks.into_iter().filter(|(_, lone)| lone.is_each_its_own()).map(|(key, _)| key).collect();
    for (at, instance) in instances.iter_mut().enumerate() {
        if joined.contains(&key((at, instance))) {
            instance.frames.iter_mut().for_each(|frame| frame.apart.clear());
            instance.odd.push("each image has a StackID of its own: taken for one stack");
        }
    }
}

/// The stack that sets a frame apart, if one does.
fn stack(frame: &Frame) -> Option<&str> {
    frame.segment.is_none().then_some(&*frame.apart).filter(|apart| apart.starts_with("stack "))
}

/// The values that the images of a series have.
#[derive(Default)]
struct Lone<'a> {
    values: HashSet<&'a str>,
    n: usize,
}

impl<'a> Lone<'a> {
    fn add(&mut self, value: Option<&'a (impl AsRef<str> + ?Sized)>) {
        self.n += 1;
        self.values.extend(value.map(AsRef::as_ref));
    }

    /// Whether there are several images and each has a value that no other one has.
    fn is_each_its_own(&self) -> bool {
        self.n > 1 && self.values.len() == self.n
    }
}
