//! Identifiers that every image has one of its own of. They name nothing and keep slices apart that
//! belong together: anonymisers make a study of each file, converters a stack of each frame.

use std::collections::{HashMap, HashSet};

use super::instance::{Frame, Instance};

/// Two images may well be of two studies.
const LEAST_STUDIES: usize = 3;

/// Takes studies of one image, and stacks of one frame, for one where a series has nothing else.
pub(super) fn join(instances: &mut [Instance]) {
    join_studies(instances);
    join_stacks(instances);
}

fn join_studies(instances: &mut [Instance]) {
    // The series, and where the images of each of its studies lie.
    type Places = HashSet<[u64; 3]>;
    let mut series: HashMap<&str, HashMap<Option<&str>, Places>> = HashMap::new();
    for (at, instance) in instances.iter().enumerate().filter(|(_, i)| !i.series_uid.is_empty()) {
        let study = series.entry(&instance.series_uid).or_default();
        let places = study.entry(instance.study_uid.as_deref()).or_default();
        for (frame, n) in instance.frames.iter().zip(0_u64..) {
            // What has no position is nowhere else.
            let nowhere = [at as u64, n, u64::MAX];
            places.insert(frame.position.map_or(nowhere, |p| p.map(f64::to_bits)));
        }
    }
    // Echoes, repeats and copies of a slice may share its study.
    let is_joined = |studies: &HashMap<Option<&str>, Places>| {
        studies.keys().flatten().count() >= LEAST_STUDIES
            && studies.values().all(|places| places.len() == 1)
    };
    let joined: HashSet<String> = series
        .into_iter()
        .filter(|(_, studies)| is_joined(studies))
        .map(|(series, _)| series.to_owned())
        .collect();
    for instance in instances.iter_mut().filter(|i| joined.contains(&i.series_uid)) {
        instance.study_uid = None;
        instance.odd.push("each image has a StudyInstanceUID of its own: taken for one study");
    }
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
