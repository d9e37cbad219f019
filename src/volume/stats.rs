//! What the values of a volume are: range, histogram, and the iso values they suggest.

use super::tally::Tally;
use super::{Meta, Note, Rescale, Sample};

/// The most bars of a histogram.
const N_BARS: usize = 256;

/// What is known of a volume once all its samples have been seen. Values are real ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// The least and the greatest finite value; nothing where there is none. Padding does not
    /// count.
    pub range: Option<(f64, f64)>,
    /// Samples in the volume.
    pub n_samples: u64,
    /// Samples that are NaN.
    pub n_nan: u64,
    /// Samples that are infinite.
    pub n_infinite: u64,
    /// Samples that stand for "nothing here".
    pub n_padding: u64,
    /// How many samples lie where; empty where there is no range.
    pub histogram: Histogram,
    /// Otsu's threshold: the value that parts the finite samples into two groups, `< otsu` and
    /// `>= otsu`, with the greatest variance between them. Nothing where there is but one value.
    pub otsu: Option<f64>,
    /// What was noticed while reading.
    pub notes: Vec<Note>,
    modality: Option<String>,
    /// Half of the least value above 0, where 0 is the least and stands for nothing.
    above_zero: Option<f64>,
}

/// Counts in bars of equal width.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    /// The lower end of the first bar.
    pub low: f64,
    /// The upper end of the last bar.
    pub high: f64,
    /// Samples in each bar, at most 256 bars. Bars of integers hold whole numbers of values.
    pub counts: Vec<u64>,
}

/// An iso value worth trying.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// The value.
    pub iso: f64,
    /// What its surface should show, in a few words.
    pub meaning: &'static str,
}

impl Survey {
    /// Sums up a volume's counts.
    pub(crate) fn new<T: Sample>(meta: &Meta, mut tally: Tally<T>, notes: Vec<Note>) -> Self {
        let rescale = meta.rescale;
        // What the rescale takes beyond `f64` is infinite, as samples may be.
        let (counts, beyond): (Vec<_>, Vec<_>) =
            tally.finish().into_iter().partition(|(v, _)| rescale.real(*v).is_finite());
        let is_finite =
            |(low, high): &(f64, f64)| [low, high].iter().all(|v| rescale.real(**v).is_finite());
        let stored = tally.range().filter(is_finite).or_else(|| ends(&counts));
        let range = stored.map(|(low, high)| in_order(rescale.real(low), rescale.real(high)));
        let is_integer = !matches!(T::TYPE, super::StoredType::F32 | super::StoredType::F64);
        Self {
            range,
            n_samples: tally.n_samples,
            n_nan: tally.n_nan,
            n_infinite: tally.n_infinite + beyond.iter().map(|(_, n)| n).sum::<u64>(),
            n_padding: tally.n_padding,
            histogram: stored
                .map(|range| histogram(&counts, range, is_integer, rescale))
                .unwrap_or_default(),
            otsu: otsu(&counts, rescale),
            notes,
            modality: meta.modality.clone(),
            above_zero: above_zero(&counts, is_integer && size_of::<T>() <= 2, rescale),
        }
    }

    /// Iso values within the range and what each would show, the most telling first.
    pub fn suggested(&self) -> Vec<Suggestion> {
        let Some((low, high)) = self.range else { return Vec::new() };
        let mut all = Vec::new();
        let mut add = |iso: f64, meaning| all.push(Suggestion { iso, meaning });
        // Hounsfield units: air is -1000, water 0.
        let looks_like_ct = (-4096.0..=-900.0).contains(&low) && (300.0..=65_535.0).contains(&high);
        match self.modality.as_deref() {
            Some("CT") => {
                add(300.0, "bone (CT, HU)");
                add(-300.0, "skin (CT, HU)");
            }
            None if looks_like_ct => {
                add(300.0, "bone, if these are Hounsfield units");
                add(-300.0, "skin, if these are Hounsfield units");
            }
            _ => {}
        }
        if let Some(otsu) = self.otsu {
            add(otsu, "Otsu: parts dark from bright best");
        }
        if let Some(iso) = self.above_zero {
            add(iso, "everything above 0: a mask, or all labels as one");
        }
        all.retain(|s| low < s.iso && s.iso <= high);
        all
    }
}

/// The first and the last value.
fn ends(counts: &[(f64, u64)]) -> Option<(f64, f64)> {
    Some((counts.first()?.0, counts.last()?.0))
}

fn in_order(a: f64, b: f64) -> (f64, f64) {
    if a <= b { (a, b) } else { (b, a) }
}

/// Bars over `range` (stored values, as are `counts`).
fn histogram(
    counts: &[(f64, u64)],
    (low, high): (f64, f64),
    is_integer: bool,
    rescale: Rescale,
) -> Histogram {
    // Halves, so that no difference overflows.
    let span = high / 2.0 - low / 2.0;
    let (n_bars, width) = if is_integer {
        let n_values = 2.0 * span + 1.0;
        let width = (n_values / N_BARS as f64).ceil();
        ((n_values / width).ceil() as usize, width / 2.0)
    } else if span > 0.0 {
        (N_BARS, span / N_BARS as f64)
    } else {
        (1, 0.0)
    };
    let mut bars = vec![0; n_bars];
    for (value, n) in counts {
        let at = (value / 2.0 - low / 2.0) / width;
        if let Some(bar) = bars.get_mut((at as usize).min(n_bars - 1)) {
            *bar += n;
        }
    }
    let end = if is_integer { low + 2.0 * width * n_bars as f64 } else { high };
    // The end of the last bar may lie beyond the last value, and the rescale take it beyond `f64`.
    let end = if rescale.real(end).is_finite() { end } else { high };
    let (low, high) = (rescale.real(low), rescale.real(end));
    if low <= high {
        return Histogram { low, high, counts: bars };
    }
    bars.reverse();
    Histogram { low: high, high: low, counts: bars }
}

/// N. Otsu, "A threshold selection method from gray-level histograms" (1979), on the values that
/// occur; the threshold is put half way to the next value.
fn otsu(counts: &[(f64, u64)], rescale: Rescale) -> Option<f64> {
    let (low, high) = ends(counts)?;
    let span = high / 2.0 - low / 2.0;
    if span <= 0.0 {
        return None;
    }
    let place = |v: f64| (v / 2.0 - low / 2.0) / span;
    let total: f64 = counts.iter().map(|(_, n)| *n as f64).sum();
    let sum: f64 = counts.iter().map(|(v, n)| place(*v) * *n as f64).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let mut best: Option<(f64, f64)> = None;
    for pair in counts.windows(2) {
        let &[(v, n), (next, _)] = pair else { continue };
        below += n as f64;
        sum_below += place(v) * n as f64;
        let above = total - below;
        let apart = sum_below / below - (sum - sum_below) / above;
        let between = below * above * apart * apart;
        if best.is_none_or(|(most, _)| between > most) {
            best = Some((between, v / 2.0 + next / 2.0));
        }
    }
    best.map(|(_, threshold)| rescale.real(threshold))
}

/// Half of the least value above 0, where values are whole, none is negative and a tenth at least
/// are 0.
fn above_zero(counts: &[(f64, u64)], is_whole: bool, rescale: Rescale) -> Option<f64> {
    let &[(least, zeros), (next, _), ..] = counts else { return None };
    let total: u64 = counts.iter().map(|(_, n)| n).sum();
    let background = least == 0.0 && rescale.real(0.0) == 0.0 && rescale.slope() > 0.0;
    (is_whole && background && zeros >= total / 10).then(|| rescale.real(next / 2.0))
}
