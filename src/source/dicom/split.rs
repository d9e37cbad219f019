//! What a series mixes at the same positions (echoes, phases, tube voltages, repeats) becomes
//! volumes of their own. Where positions hold one image each, only what the scanner was set to for
//! whole volumes (echoes, time points, ...) and lies beside each other is split (`shifted`).

use std::cmp::Ordering;
use std::collections::HashSet;
use std::ops::Range;

use super::image_type;
use super::instance::{CLOCK, Frame, IMAGE_TYPE, Instance, SETTINGS, SPLITTERS};
use super::series::{FrameRef, Group, sort};
use super::shifted;

/// Where this share of the positions holds the same number of images, all of them were meant to;
/// a part of such a group covers this share of the positions or is a fragment.
pub(super) const SHARE: f64 = 0.75;

/// Splits a group whose positions hold several images by what the series mixes: echoes, time
/// points, ... Groups that mix nothing come back as they are.
///
/// Values that say the same at all positions come first, whichever attribute has them; then the
/// order of values at each position; then the order of the images.
pub(super) fn split(group: Group, instances: &[Instance]) -> Vec<Group> {
    let mut done = Vec::new();
    let mut open = vec![group];
    while let Some(mut group) = open.pop() {
        let runs = sort(&mut group, instances);
        // Images that all lie at one position are no volumes, however they are split.
        if runs.len() < 2 {
            done.push(group);
            continue;
        }
        let one_each = runs.iter().all(|run| run.len() < 2);
        let all = attributes(&group, instances, one_each);
        let told: Vec<&Labels> =
            all.iter().filter(|labels| !one_each && labels.tell_apart(&runs)).collect();
        let by_value = |of| told.iter().find_map(|labels| by_value(&group, &runs, labels, of));
        let parts = by_value(Parts::Whole);
        if let Some(parts) = parts.or_else(|| shifted::sets(&group, instances, &all)) {
            open.extend(parts.into_iter().rev());
            continue;
        }
        // A value that is written otherwise in one slice is not what tells whole repeats apart.
        let parts = told.iter().find_map(|labels| by_rank(&group, &runs, labels));
        if let Some(parts) = parts.or_else(|| repeats(&group, &runs, instances)) {
            done.extend(parts);
            continue;
        }
        match by_value(Parts::BrokenOff).or_else(|| by_value(Parts::Stacks)) {
            Some(parts) => open.extend(parts.into_iter().rev()),
            None => done.push(group),
        }
    }
    done
}

/// One attribute's value in each frame of a group.
pub(super) struct Labels {
    name: String,
    /// Set by the scanner for whole volumes.
    pub(super) is_setting: bool,
    is_clock: bool,
    is_image_type: bool,
    of: Vec<String>,
}

impl Labels {
    /// Whether positions with several images hold several values.
    fn tell_apart(&self, runs: &[Range<usize>]) -> bool {
        runs.iter().filter(|run| run.len() > 1).all(|run| {
            let own = self.of.get(run.clone()).unwrap_or_default();
            own.iter().any(|label| Some(label) != own.first())
        })
    }

    /// Whether each frame has a value.
    pub(super) fn is_given(&self) -> bool {
        self.of.iter().all(|label| !label.is_empty())
    }

    /// The values there are, in order.
    pub(super) fn values(&self) -> Vec<&String> {
        let mut values: Vec<&String> = self.of.iter().collect();
        values.sort_by(|a, b| self.compare(a, b));
        values.dedup();
        values
    }

    fn compare(&self, a: &str, b: &str) -> Ordering {
        let rank = |label| self.is_image_type.then(|| image_type::rank(label));
        rank(a).cmp(&rank(b)).then_with(|| compare_labels(a, b))
    }

    fn get(&self, index: usize) -> &str {
        self.of.get(index).map_or("", String::as_str)
    }
}

/// All that may tell images at one position apart, the surest first: what the scanner was set to,
/// then the dimensions that a multi-frame file counts (PS3.3, C.7.6.17), then the type of samples.
/// Where positions hold one image each, the settings alone.
fn attributes(group: &Group, instances: &[Instance], settings_alone: bool) -> Vec<Labels> {
    type Label<'a> = &'a dyn Fn(&Instance, &Frame) -> Option<String>;
    let each = |name: String, slot: Option<usize>, label: Label<'_>| {
        let own = |r: &FrameRef| {
            let (instance, frame) = r.get(instances)?;
            label(instance, frame)
        };
        let is_setting = slot.is_some() && SETTINGS.contains(&name.as_str());
        let plain = |label: String| if is_setting { as_number(label) } else { label };
        let of = group.frames.iter().map(|r| own(r).map(plain).unwrap_or_default()).collect();
        let (is_clock, is_image_type) = (slot == Some(CLOCK), slot == Some(IMAGE_TYPE));
        Labels { name, is_setting, is_clock, is_image_type, of }
    };
    let mut all = Vec::new();
    for (slot, name) in SPLITTERS.iter().enumerate() {
        if settings_alone && !SETTINGS.contains(name) {
            continue;
        }
        let label = |_: &Instance, f: &Frame| f.mixed.get(slot).cloned().flatten();
        all.push(each((*name).to_owned(), Some(slot), &label));
    }
    if settings_alone {
        return all;
    }
    let frames = || group.frames.iter().filter_map(|r| r.get(instances));
    let n_dimensions = frames().map(|(_, f)| f.dimensions.len()).max().unwrap_or(0);
    for dimension in 0..n_dimensions.min(MOST_DIMENSIONS) {
        let label = |_: &Instance, f: &Frame| f.dimensions.get(dimension).cloned();
        all.push(each(format!("dimension {} index", dimension + 1), None, &label));
    }
    all.push(each("samples".to_owned(), None, &|i, _| Some(i.layout.stored_type().to_string())));
    all
}

/// A number as it is written shortest: 10.0 is no other echo time than 10.
fn as_number(label: String) -> String {
    let number = label.parse::<f64>().ok().filter(|number| number.is_finite());
    number.map_or(label, |number| number.to_string())
}

/// Dimensions looked at: files have two to five.
const MOST_DIMENSIONS: usize = 16;

/// What the values of an attribute may come to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parts {
    /// A volume each.
    Whole,
    /// A volume each but for the first or the last, a repeat that was broken off.
    BrokenOff,
    /// Stacks that share a few positions, as a table that goes to and fro makes them. Numbers of
    /// acquisitions count blocks of slices as well.
    Stacks,
}

/// One part for each value, if they come to that.
fn by_value(
    group: &Group,
    runs: &[Range<usize>],
    labels: &Labels,
    of: Parts,
) -> Option<Vec<Group>> {
    let values = labels.values();
    let mut covered = vec![0_usize; values.len()];
    // Positions that no other value has.
    let mut alone = vec![0_usize; values.len()];
    for run in runs {
        let own: HashSet<&String> = labels.of.get(run.clone())?.iter().collect();
        let is_alone = own.len() == 1;
        for label in own {
            let at = values.binary_search_by(|v| labels.compare(v, label)).ok()?;
            *covered.get_mut(at)? += 1;
            *alone.get_mut(at)? += usize::from(is_alone);
        }
    }
    if of != Parts::BrokenOff {
        let are_whole = match of {
            Parts::Stacks => labels.is_setting && are_stacks(&covered),
            _ => all_whole(&covered, runs, labels.is_clock),
        };
        return are_whole.then(|| divide(group, labels, &values)).flatten();
    }
    // Words and times of day do not say which repeat was the first or the last.
    let counts = !labels.is_clock && values.iter().all(|value| value.parse::<f64>().is_ok());
    let broken = if covered.first() < covered.last() { 0 } else { covered.len().checked_sub(1)? };
    let share = SHARE * runs.len() as f64;
    let is_whole = |(at, &n): (usize, &usize)| at == broken || n as f64 >= share;
    let are_whole = covered.len() > 1 && covered.iter().enumerate().all(is_whole);
    if !counts || *alone.get(broken)? > 0 || !are_whole {
        return None;
    }
    let mut parts = divide(group, labels, &values)?;
    parts.get_mut(broken)?.broken_off = true;
    Some(parts)
}

/// One part for each value.
pub(super) fn divide(group: &Group, labels: &Labels, values: &[&String]) -> Option<Vec<Group>> {
    let mut parts: Vec<Group> = Vec::with_capacity(values.len());
    for (n, value) in values.iter().enumerate() {
        let mut apart = group.apart.clone();
        // A time of day is nobody's business.
        apart.push(match value.as_str() {
            _ if labels.is_clock => numbered(&labels.name, n, values.len()),
            "" => format!("{} none", labels.name),
            value => format!("{} {value}", labels.name),
        });
        parts.push(Group { frames: Vec::new(), apart, ..*group });
    }
    for (reference, label) in group.frames.iter().zip(&labels.of) {
        let at = values.binary_search_by(|v| labels.compare(v, label)).ok()?;
        parts.get_mut(at)?.frames.push(*reference);
    }
    Some(parts)
}

/// Whether parts that cover so many positions are each a volume. An attribute that counts blocks
/// of slices, or slices, would leave fragments.
fn all_whole(covered: &[usize], runs: &[Range<usize>], is_clock: bool) -> bool {
    let mut lengths: Vec<usize> = runs.iter().map(ExactSizeIterator::len).collect();
    lengths.sort_unstable();
    let share = SHARE * runs.len() as f64;
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
    let n_usual = lengths.iter().filter(|&&n| n == usual).count();
    let is_complete = usual > 1 && n_usual as f64 >= share;
    if is_complete || is_clock {
        return covered.iter().all(|&n| n as f64 >= share);
    }
    are_stacks(covered)
}

/// Whether parts that cover so many positions are of about the same length: stacks that overlap, or a
/// repeat that was broken off late.
fn are_stacks(covered: &[usize]) -> bool {
    let total: usize = covered.iter().sum();
    covered.iter().all(|&n| n > 1 && n.saturating_mul(covered.len() * 2) >= total)
}

/// Where each position holds the same number of images, but their labels differ from position to
/// position (trigger times, numbers that are counted on): the first of each, the second of each, ...
fn by_rank(group: &Group, runs: &[Range<usize>], labels: &Labels) -> Option<Vec<Group>> {
    let count = runs.first()?.len();
    if runs.iter().any(|run| run.len() != count) {
        return None;
    }
    // Words have no order that means anything.
    if labels.of.iter().any(|label| label.parse::<f64>().is_err()) {
        return None;
    }
    let mut parts = vec![Group { frames: Vec::new(), apart: Vec::new(), ..*group }; count];
    for run in runs {
        let mut own: Vec<usize> = run.clone().collect();
        own.sort_by(|&a, &b| compare_labels(labels.get(a), labels.get(b)));
        if own.windows(2).any(|w| labels.get(w[0]) == labels.get(w[1])) {
            return None;
        }
        for (part, index) in parts.iter_mut().zip(own) {
            part.frames.extend(group.frames.get(index));
        }
    }
    for (rank, part) in parts.iter_mut().enumerate() {
        part.apart.clone_from(&group.apart);
        part.apart.push(numbered(&labels.name, rank, count));
    }
    Some(parts)
}

fn numbered(name: &str, rank: usize, count: usize) -> String {
    // "acquisition number number 1" is a stammer.
    let number = if name.ends_with("number") || name == "time" { "" } else { " number" };
    format!("{name}{number} {} of {count}", rank + 1)
}

/// A frame behind its InstanceNumber and its number within its file.
type Numbered = ((i64, u64), FrameRef);

/// The repeats of a group whose positions each hold equally many images that no label tells apart
/// (functional MR): the first of each, the second of each, ... by InstanceNumber, then by the
/// frame. Only where these numbers count all positions of one repeat before the next repeat, or all
/// repeats of one position before the next position; any other order could mix them up.
fn repeats(group: &Group, runs: &[Range<usize>], instances: &[Instance]) -> Option<Vec<Group>> {
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
        Group { frames, apart, ..*group }
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
fn compare_labels(a: &str, b: &str) -> Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(x), Ok(y)) => x.total_cmp(&y).then_with(|| a.cmp(b)),
        (Ok(_), Err(_)) if !b.is_empty() => Ordering::Less,
        (Err(_), Ok(_)) if !a.is_empty() => Ordering::Greater,
        _ => a.cmp(b),
    }
}
