//! Echoes, time points, b-values and kernels whose slices lie beside each other, not at the same
//! positions (a table that came back elsewhere, a patient who was moved): no position holds two
//! images, and without a look at what the scanner was set to they would be taken for one volume of
//! thinner slices. Sets are split only where that is plain: slices of one volume differ in their
//! settings too, station by station, package by package, or in the last digit.

use std::ops::Range;

use super::instance::{ECHO_NUMBER, Instance};
use super::order::{self, Facing};
use super::series::{FrameRef, Group};
use super::split::{Labels, SHARE, divide};

/// Gaps that differ by less than this part are those of one grid, written rounded.
const SAME_STEP: f64 = 0.2;

/// Echo times are others where they differ by more than this part.
const OTHER_TIME: f64 = 0.02;

/// Of fewer slices one more could be one of them whose setting was written otherwise, and a few
/// packages could be sets.
const LEAST_WHOLE: usize = 4;

/// One part for each echo, time point, b-value or kernel, where each is an even grid by itself, all
/// have about as many slices, and they lie within each other; the last one may be what there is of a repeat that
/// was broken off. Numbers and times of acquisitions say nothing here: slices that are taken in
/// interleaved packages have several.
pub(super) fn sets(group: &Group, instances: &[Instance], all: &[Labels]) -> Option<Vec<Group>> {
    // Numbers of echoes that have one time between them number something else.
    let one_time = all.first().is_some_and(|times| times.values().len() == 1 && times.is_given());
    let settings = all.iter().enumerate().filter(|(_, labels)| labels.is_setting);
    let settings = settings.filter(|(slot, _)| !(one_time && *slot == ECHO_NUMBER));
    settings.into_iter().find_map(|(_, labels)| by_setting(group, instances, labels))
}

fn by_setting(group: &Group, instances: &[Instance], labels: &Labels) -> Option<Vec<Group>> {
    let facing = group.facing?;
    let values = labels.values();
    if values.len() < 2 || values.iter().any(|value| value.is_empty()) || are_close(&values) {
        return None;
    }
    let mut parts = divide(group, labels, &values)?;
    let places = parts.iter().map(|part| places(part, &facing, instances));
    let places: Vec<Vec<f64>> = places.collect::<Option<_>>()?;
    if are_one_grid(group, instances, &places) {
        return None;
    }
    // A slice that is missing now and then is no reason to mix sets.
    if are_shifted(&places, SHARE) {
        return Some(parts);
    }
    // What lies between the slices of a set that lacks none is no part of it.
    let (last, whole) = places.split_last()?;
    let mut ends = whole.iter().filter_map(|set| Some([*set.first()?, *set.last()?])).flatten();
    let first = ends.next()?;
    let (low, high) = ends.fold((first, first), |(low, high), z| (low.min(z), high.max(z)));
    let is_fragment = whole.iter().all(|set| set.len() > last.len())
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

/// Whether values are fractions that are nearly the same: echo times measured, not set.
fn are_close(values: &[&String]) -> bool {
    let numbers: Vec<f64> = values.iter().filter_map(|value| value.parse().ok()).collect();
    let are_whole = numbers.iter().all(|x| x.fract() == 0.0);
    !are_whole && numbers.windows(2).any(|w| w[1] - w[0] <= OTHER_TIME * w[1].abs())
}

/// Whether all slices together lie as far apart as the headers say that slices do.
fn are_one_grid(group: &Group, instances: &[Instance], sets: &[Vec<f64>]) -> bool {
    let mut all: Vec<f64> = sets.concat();
    all.sort_by(f64::total_cmp);
    let Some(step) = usual_gap(&all) else { return false };
    let is_step = |gap: f64| (gap - step).abs() <= SAME_STEP * step;
    let said = |r: &FrameRef| r.get(instances).and_then(|(_, frame)| frame.slice_spacing);
    all.windows(2).all(|w| is_step(w[1] - w[0]))
        && group.frames.iter().all(|r| said(r).is_some_and(|gap| is_step(gap.abs())))
}

/// Whether sets of positions have one step, which this share of the gaps of each is wide, and about
/// as many slices, and whether they lie within each other: between two slices of one there is one
/// of another, as often as the two are in the same place at all.
fn are_shifted(sets: &[Vec<f64>], share: f64) -> bool {
    let total: usize = sets.iter().map(Vec::len).sum();
    let Some(step) = sets.first().and_then(|set| usual_gap(set)) else { return false };
    let is_step = |w: &&[f64]| (w[1] - w[0] - step).abs() <= SAME_STEP * step;
    sets.iter().enumerate().all(|(own, set)| {
        let others = || sets.iter().enumerate().filter(|(n, _)| *n != own).map(|(_, set)| set);
        let low = others().filter_map(|set| set.first()).copied().fold(f64::INFINITY, f64::min);
        let high = others().filter_map(|set| set.last()).copied().fold(f64::NEG_INFINITY, f64::max);
        let is_between = |w: &&[f64]| others().flatten().any(|&z| w[0] < z && z < w[1]);
        let even: Vec<&[f64]> = set.windows(2).filter(is_step).collect();
        let shared: Vec<&[f64]> =
            even.iter().copied().filter(|w| w[1] > low && w[0] < high).collect();
        let n_between = shared.iter().filter(|w| is_between(w)).count();
        set.len() >= LEAST_WHOLE
            && even.len() as f64 >= share * (set.len() - 1) as f64
            && set.len().saturating_mul(sets.len() * 2) >= total
            && (sets.len() == 1
                || !shared.is_empty() && n_between as f64 >= SHARE * shared.len() as f64)
    })
}

fn usual_gap(set: &[f64]) -> Option<f64> {
    let mut gaps: Vec<f64> = set.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied()
}
