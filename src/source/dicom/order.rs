//! Slices in geometric order: doubles, evenness, gaps, tilt, the grid.

use super::error::DicomError;
use crate::geom::vec3::{Vec3, add, cross, dot, norm, scale, sub};
use crate::geom::{Affine, Dims, DimsError, Grid};

/// Positions closer than this along the normal are one position, in mm, whatever the spacing.
const SAME_MM: f64 = 1e-4;

/// Positions closer than this part of the usual gap are one position; an even grid may be missed
/// by this part of the step.
const TOLERANCE: f64 = 0.01;

/// A gap is a whole multiple of another within this part.
const MULTIPLE: f64 = 0.02;

/// Gaps of one step differ by this part of it at most. 0.625 mm rounded to 0.1 mm gives gaps of 0.6
/// and 0.7 mm, which is 0.16; from half a step on, any gap would be a multiple.
const SPREAD: f64 = 0.3;

/// Around a step that a file gives, which may be rounded, a gap is a multiple of it within this
/// part of the gap, and within [`GIVEN_MOST`] of the step.
const GIVEN: f64 = 0.05;

/// See [`GIVEN`]: of a wide gap the part alone would allow any multiple.
const GIVEN_MOST: f64 = 0.25;

/// Doubles that differ by rounding, or by a table that did not quite come back, are closer than
/// this, in mm.
const DOUBLES_MM: f64 = 0.05;

/// So many equal wide gaps in a row are a spacing of their own, not missing slices.
const DESIGNED_RUN: usize = 3;

/// What all slices of a volume share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facing {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) sample_bytes: usize,
    /// ImageOrientationPatient.
    pub(super) orientation: [f64; 6],
    /// PixelSpacing.
    pub(super) spacing: [f64; 2],
}

impl Facing {
    fn row(&self) -> Vec3 {
        let [a, b, c, ..] = self.orientation;
        [a, b, c]
    }

    fn column(&self) -> Vec3 {
        let [.., d, e, f] = self.orientation;
        [d, e, f]
    }

    /// Row direction × column direction: the way slices are counted.
    pub(super) fn normal(&self) -> Vec3 {
        cross(self.row(), self.column())
    }

    /// The place of a position along the normal, in mm.
    pub(super) fn along(&self, position: Vec3) -> f64 {
        let normal = self.normal();
        dot(position, normal) / norm(normal)
    }
}

/// Runs of places that are one position; `places` are in rising order. Each run is a range of
/// indices.
pub(super) fn positions(places: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut gaps: Vec<f64> =
        places.windows(2).map(|w| w[1] - w[0]).filter(|&g| g > SAME_MM).collect();
    gaps.sort_by(f64::total_cmp);
    let middle = |gaps: &[f64]| gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
    // Where most images have a double beside them, most gaps are none: the usual one is among
    // those that are wide.
    let wide = gaps.get(gaps.partition_point(|&g| g < DOUBLES_MM)..).unwrap_or_default();
    let is_doubled = wide.len() > 1
        && gaps.iter().filter(|&&g| g < DOUBLES_MM).all(|&g| g <= TOLERANCE * middle(wide));
    let usual = middle(if is_doubled { wide } else { &gaps });
    let same = SAME_MM.max(TOLERANCE * usual);
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for (index, &place) in places.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if place - places[run.start] <= same => run.end = index + 1,
            _ => runs.push(index..index + 1),
        }
    }
    runs
}

/// The geometry of slices in order.
pub(super) struct Arranged {
    pub(super) grid: Grid,
    /// Distances along the normal, where they are uneven.
    pub(super) gaps_mm: Option<Vec<f64>>,
    /// The furthest that a slice lies from the even grid, in mm.
    pub(super) off_mm: f64,
    pub(super) tilt_degrees: f64,
    /// Gaps that say that slices are missing.
    pub(super) missing: Option<Missing>,
}

/// Missing slices.
pub(super) struct Missing {
    pub(super) count: usize,
    /// The gap's lower slice (an index) and its width in mm.
    pub(super) gaps: Vec<(usize, f64)>,
    pub(super) step_mm: f64,
}

/// Places slices given by the positions of their first samples (LPS, in order along the normal,
/// no two alike). `alone` is the step of a single slice; `omitting` that of slices of which any may
/// be left out: gaps that are multiples of it say that some were, however even they are.
///
/// # Errors
/// A grid that cannot be; positions that are no geometry.
pub(super) fn arrange(
    facing: &Facing,
    positions: &[Vec3],
    alone: Option<f64>,
    omitting: Option<f64>,
) -> Result<Arranged, ArrangeError> {
    let (Some(&first), Some(&last)) = (positions.first(), positions.last()) else {
        return Err(ArrangeError::TooFew);
    };
    let n = positions.len();
    let normal = facing.normal();
    let step = match alone {
        _ if n > 1 => scale(sub(last, first), 1.0 / (n - 1) as f64),
        Some(step) if step > 0.0 => scale(normal, step),
        _ => return Err(ArrangeError::TooFew),
    };
    let dims =
        Dims::checked(facing.cols as i64, facing.rows as i64, n as i64, facing.sample_bytes)?;
    let [between_rows, between_columns] = facing.spacing;
    let affine = Affine::from_columns(
        ras(scale(facing.row(), between_columns)),
        ras(scale(facing.column(), between_rows)),
        ras(step),
        ras(first),
    );
    if !affine.is_usable() {
        return Err(ArrangeError::Flat);
    }
    let places: Vec<f64> = positions.iter().map(|&p| facing.along(p)).collect();
    let gaps: Vec<f64> = places.windows(2).map(|w| w[1] - w[0]).collect();
    let omitted = omitting
        .and_then(|step| multiples(&gaps, step, |times| step * (GIVEN * times).min(GIVEN_MOST)));
    let off = positions
        .iter()
        .enumerate()
        .map(|(k, &p)| norm(sub(p, add(first, scale(step, k as f64)))))
        .fold(0.0, f64::max);
    let lean = dot(step, normal).abs() / (norm(step) * norm(normal));
    let tilt_degrees = tilt(step, normal, lean);
    let mut grid = Grid::new(dims, affine);
    if off <= TOLERANCE * norm(step) && omitted.is_none() {
        return Ok(Arranged { grid, gaps_mm: None, off_mm: off, tilt_degrees, missing: None });
    }
    grid.plane_origins = Some(positions.iter().copied().map(ras).collect());
    let missing = omitted.or_else(|| find_missing(&gaps));
    Ok(Arranged { grid, gaps_mm: Some(gaps), off_mm: off, tilt_degrees, missing })
}

/// Why positions make no grid.
pub(super) enum ArrangeError {
    TooFew,
    Flat,
    Dims(DimsError),
}

impl From<DimsError> for ArrangeError {
    fn from(error: DimsError) -> Self {
        Self::Dims(error)
    }
}

/// LPS to RAS.
fn ras([x, y, z]: Vec3) -> Vec3 {
    // Adding zero turns a negative zero into a plain one.
    [0.0 - x, 0.0 - y, z + 0.0]
}

/// The angle between step and normal, in degrees. The sine is exact where the cosine is not.
fn tilt(step: Vec3, normal: Vec3, lean: f64) -> f64 {
    let sine = norm(cross(step, normal)) / (norm(step) * norm(normal));
    sine.atan2(lean).to_degrees()
}

/// Gaps that are whole multiples of the narrow ones, where all others are narrow: within
/// [`MULTIPLE`], or within what the narrow ones differ among themselves, as positions that are
/// written rounded make them.
fn find_missing(gaps: &[f64]) -> Option<Missing> {
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let is_narrow = |gap: f64| gap < 1.5 * least;
    let narrow: Vec<f64> = gaps.iter().copied().filter(|&g| is_narrow(g)).collect();
    let step_mm = narrow.iter().sum::<f64>() / narrow.len() as f64;
    let spread = narrow.iter().copied().fold(least, f64::max) - least;
    if spread > SPREAD * step_mm {
        return None;
    }
    // A run of equal wide gaps is how the series was taken.
    let times = |gap: f64| (gap / step_mm).round();
    let designed = |run: &[f64]| run.iter().all(|&g| !is_narrow(g) && times(g) == times(run[0]));
    if gaps.windows(DESIGNED_RUN).any(designed) {
        return None;
    }
    multiples(gaps, step_mm, |times| spread.max(MULTIPLE * times * step_mm))
}

/// The gaps of several steps, where all gaps are whole multiples of the step; how far one may be
/// off is asked for by the multiple.
fn multiples(gaps: &[f64], step_mm: f64, off_mm: impl Fn(f64) -> f64) -> Option<Missing> {
    let mut wide = Vec::new();
    let mut count = 0_usize;
    for (index, &gap) in gaps.iter().enumerate() {
        let times = (gap / step_mm).round();
        if !(1.0..1e4).contains(&times) || (gap - times * step_mm).abs() > off_mm(times) {
            return None;
        }
        if times > 1.0 {
            wide.push((index, gap));
            count += times as usize - 1;
        }
    }
    (!wide.is_empty()).then_some(Missing { count, gaps: wide, step_mm })
}

impl Missing {
    /// The positions with those between added that make the grid even; `items`, one a position,
    /// gets `empty` there.
    pub(super) fn fill<T: Copy>(
        &self,
        positions: &[Vec3],
        items: &mut Vec<T>,
        empty: T,
    ) -> Vec<Vec3> {
        let (mut filled, mut filled_items) = (Vec::new(), Vec::new());
        for (k, (&position, &item)) in positions.iter().zip(items.iter()).enumerate() {
            filled.push(position);
            filled_items.push(item);
            let gap = self.gaps.iter().find(|(below, _)| *below == k);
            let (Some((_, gap)), Some(&next)) = (gap, positions.get(k + 1)) else { continue };
            let times = (gap / self.step_mm).round();
            let step = scale(sub(next, position), 1.0 / times);
            for n in 1..times as usize {
                filled.push(add(position, scale(step, n as f64)));
                filled_items.push(empty);
            }
        }
        *items = filled_items;
        filled
    }

    /// The error, with the gaps told by the files on either side.
    pub(super) fn error(&self, name: impl Fn(usize) -> String, faults: String) -> DicomError {
        let shown: Vec<String> = self
            .gaps
            .iter()
            .take(4)
            .map(|&(k, gap)| format!("{gap:.2} mm between {} and {}", name(k), name(k + 1)))
            .collect();
        let more = self.gaps.len() - shown.len();
        let mut gaps = shown.join(", ");
        if more > 0 {
            gaps = format!("{gaps} and {more} more");
        }
        DicomError::MissingSlices {
            count: self.count,
            gaps,
            step: format!("{:.2}", self.step_mm),
            faults,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::find_missing;

    #[test]
    fn one_double_gap_is_a_missing_slice_and_a_second_spacing_is_none() {
        let missing = find_missing(&[2.0, 2.0, 4.0, 2.0]).expect("a slice is missing");
        assert_eq!((missing.count, missing.gaps), (1, vec![(2, 4.0)]));
        assert!(find_missing(&[2.0, 2.0, 2.0, 4.0, 4.0, 4.0]).is_none());
        assert!(find_missing(&[2.0, 2.0, 3.0, 2.0]).is_none());
        assert!(find_missing(&[1.25, 6.25, 1.25]).is_some_and(|m| m.count == 4));
    }

    #[test]
    fn slices_are_missed_among_gaps_that_rounding_makes_uneven_and_not_among_others() {
        // Steps of 0.625 mm and of 1.25 mm, written to 0.1 mm; one position is left out.
        let missing = find_missing(&[0.6, 0.7, 0.6, 0.6, 1.3, 0.6, 0.7]).expect("one is missing");
        assert_eq!((missing.count, missing.gaps), (1, vec![(4, 1.3)]));
        assert!(find_missing(&[1.2, 1.3, 1.2, 1.3, 2.5, 1.3]).is_some_and(|m| m.count == 1));
        // The same without anything left out; steps that grow; two spacings.
        assert!(find_missing(&[0.6, 0.7, 0.6, 0.6, 0.7]).is_none());
        assert!(find_missing(&[1.0, 1.2, 1.4, 1.7, 2.0, 2.4]).is_none());
        assert!(find_missing(&[0.6, 0.7, 0.6, 1.2, 1.3, 1.2]).is_none());
        assert!(find_missing(&[2.0, 2.1, 2.0, 3.0, 2.1]).is_none());
    }
}
