//! Echoes and time points whose slices lie beside each other, not at the same positions (a table
//! that came back elsewhere, a patient who was moved): no position holds two images, and without a
//! look at what the scanner was set to they would be taken for one volume of thinner slices.

use std::ops::Range;

use super::instance::{Instance, N_SETTINGS};
use super::order::{self, Facing};
use super::series::{FrameRef, Group};
use super::split::{Labels, SHARE, divide};

/// Gaps that differ by less than this part are those of one grid, written rounded.
const SAME_STEP: f64 = 0.2;

/// Sets overlap where one begins by this part of a step before another one ends: blocks that meet
/// at a slice do not.
const OVERLAP: f64 = 0.1;

/// Of fewer slices one more could be one of them whose setting was written otherwise.
const LEAST_WHOLE: usize = 4;

/// One part for each echo or time point, where each is an even grid by itself, all have about as
/// many slices, and they lie within each other; the last one may be what there is of a repeat that
/// was broken off. Numbers and times of acquisitions say nothing here: slices that are taken in
/// interleaved packages have several.
pub(super) fn sets(group: &Group, instances: &[Instance], all: &[Labels]) -> Option<Vec<Group>> {
    all.iter().take(N_SETTINGS).find_map(|labels| by_setting(group, instances, labels))
}

fn by_setting(group: &Group, instances: &[Instance], labels: &Labels) -> Option<Vec<Group>> {
    let facing = group.facing?;
    let values = labels.values();
    if values.len() < 2 || values.iter().any(|value| value.is_empty()) {
        return None;
    }
    let mut parts = divide(group, labels, &values)?;
    let places = parts.iter().map(|part| places(part, &facing, instances));
    let places: Vec<Vec<f64>> = places.collect::<Option<_>>()?;
    // A slice that is missing now and then is no reason to mix sets.
    if are_shifted(&places, SHARE) {
        return Some(parts);
    }
    // What lies between the slices of a set that lacks none is no part of it.
    let (last, whole) = places.split_last()?;
    let mut ends = whole.iter().filter_map(|set| Some([*set.first()?, *set.last()?])).flatten();
    let first = ends.next()?;
    let (low, high) = ends.fold((first, first), |(low, high), z| (low.min(z), high.max(z)));
    let is_fragment = whole.iter().all(|set| set.len() >= LEAST_WHOLE && set.len() > last.len())
        && last.iter().all(|&z| low < z && z < high)
        && values.iter().all(|value| value.parse::<f64>().is_ok());
    if !is_fragment || !are_shifted(whole, 1.0) {
        return None;
    }
    parts.last_mut()?.broken_off = true;
    Some(parts)
}

/// The positions of a group along the normal, in order.
fn places(group: &Group, facing: &Facing, instances: &[Instance]) -> Option<Vec<f64>> {
    let place = |r: &FrameRef| Some(facing.along(r.get(instances)?.1.position?));
    let all: Vec<f64> = group.frames.iter().map(place).collect::<Option<_>>()?;
    let first = |run: Range<usize>| all.get(run.start).copied();
    order::positions(&all).into_iter().map(first).collect()
}

/// Whether sets of positions have one step, which this share of the gaps of each is wide, and about
/// as many slices, and whether they overlap.
fn are_shifted(sets: &[Vec<f64>], share: f64) -> bool {
    let total: usize = sets.iter().map(Vec::len).sum();
    let Some(step) = sets.first().and_then(|set| usual_gap(set)) else { return false };
    let is_step = |gap: f64| (gap - step).abs() <= SAME_STEP * step;
    let alike = sets.iter().all(|set| {
        let gaps = set.windows(2).map(|w| w[1] - w[0]);
        let n_even = gaps.filter(|&gap| is_step(gap)).count();
        n_even > 0
            && n_even as f64 >= share * (set.len() - 1) as f64
            && set.len().saturating_mul(sets.len() * 2) >= total
    });
    let mut ends: Vec<_> = sets.iter().filter_map(|set| set.first().zip(set.last())).collect();
    ends.sort_by(|a, b| a.0.total_cmp(b.0));
    alike && ends.windows(2).all(|w| w[1].0 + OVERLAP * step < *w[0].1)
}

fn usual_gap(set: &[f64]) -> Option<f64> {
    let mut gaps: Vec<f64> = set.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied()
}
