//! A separable Gaussian over the samples that count: along i and j within a plane, then along k
//! over a window of planes. Knows nothing of where planes come from.
//!
//! Each sum of weighted samples goes with the sum of the weights, of samples that exist and count,
//! and is divided by it once at the end: borders and holes are renormalised.

use super::lend::Pool;
use super::valid::Valid;
use crate::geom::Dims;
use crate::source::{SourceError, buffer};
use crate::volume::Sample;

/// Weights of one axis, and for each index the sum of those that lie within the axis.
struct Axis {
    /// By distance, the nearest first.
    weights: Vec<f64>,
    totals: Vec<f64>,
}

impl Axis {
    /// `sigma` in samples, cut off as scipy's `gaussian_filter` does: at `int(4 sigma + 0.5)`
    /// samples, and at the axis's length, beyond which there is nothing to weigh.
    fn new(sigma: f64, n: usize) -> Result<Self, SourceError> {
        let radius = ((4.0 * sigma + 0.5) as usize).min(n - 1);
        let weight =
            |d: usize| if d == 0 { 1.0 } else { (-0.5 * (d as f64 / sigma).powi(2)).exp() };
        let weights: Vec<f64> = (0..=radius).map(weight).collect();
        // Sums of the first weights, so that totals cost one step an index.
        let sums: Vec<f64> = weights
            .iter()
            .scan(0.0, |sum, w| {
                *sum += w;
                Some(*sum)
            })
            .collect();
        let upto = |d: usize| sums.get(d.min(radius)).copied().unwrap_or(0.0);
        let mut totals: Vec<f64> = buffer(n)?;
        for (i, total) in totals.iter_mut().enumerate() {
            *total = upto(i) + upto(n - 1 - i) - 1.0;
        }
        Ok(Self { weights, totals })
    }

    fn radius(&self) -> usize {
        self.weights.len() - 1
    }
}

/// A plane blurred along i and j.
#[derive(Default)]
pub(super) struct Blurred {
    sums: Vec<f64>,
    /// Sums of weights, and which samples count, where not all do.
    holes: Option<Holes>,
}

struct Holes {
    weights: Vec<f64>,
    counts: Vec<bool>,
}

/// The filter for one volume.
pub(super) struct Gaussian {
    dims: Dims,
    axes: [Axis; 3],
    scratch: Pool<f64>,
    rows: Pool<f64>,
}

impl Gaussian {
    /// `sigma` in samples along i, j, k.
    pub(super) fn new(dims: Dims, sigma: [f64; 3]) -> Result<Self, SourceError> {
        let [nx, ny, nz] = dims.to_array();
        let axes = [Axis::new(sigma[0], nx)?, Axis::new(sigma[1], ny)?, Axis::new(sigma[2], nz)?];
        let scratch = Pool::new(dims.plane_len());
        let rows = Pool::new(nx + 2 * axes[0].radius());
        Ok(Self { dims, axes, scratch, rows })
    }

    /// Planes on either side of one that take part in its blur.
    pub(super) fn radius(&self) -> usize {
        self.axes[2].radius()
    }

    /// Blurs a plane along i and j into the buffers of `spare`.
    pub(super) fn within_plane<T: Sample>(
        &self,
        from: &[T],
        valid: &Valid<T>,
        spare: Blurred,
    ) -> Result<Blurred, SourceError> {
        let n = self.dims.plane_len();
        let mut sums = spare.sums;
        if sums.len() != n {
            sums = buffer(n)?;
        }
        if valid.all() || from.iter().all(|&x| valid.holds(x)) {
            self.along_i_and_j(
                |p, row| fill(row, from.get(p..).unwrap_or_default(), Sample::to_f64),
                &mut sums,
            )?;
            return Ok(Blurred { sums, holes: None });
        }
        let mut weights: Vec<f64> = buffer(n)?;
        let value = |x: T| if valid.holds(x) { x.to_f64() } else { 0.0 };
        let count = |x: T| f64::from(u8::from(valid.holds(x)));
        self.along_i_and_j(
            |p, row| fill(row, from.get(p..).unwrap_or_default(), value),
            &mut sums,
        )?;
        self.along_i_and_j(
            |p, row| fill(row, from.get(p..).unwrap_or_default(), count),
            &mut weights,
        )?;
        let counts = from.iter().map(|&x| valid.holds(x)).collect();
        Ok(Blurred { sums, holes: Some(Holes { weights, counts }) })
    }

    /// Sums along i, then along j; `load` fills a row from the sample at a place.
    fn along_i_and_j(
        &self,
        load: impl Fn(usize, &mut [f64]),
        out: &mut [f64],
    ) -> Result<(), SourceError> {
        let nx = self.dims.nx();
        let [along_i, along_j, _] = &self.axes;
        let radius = along_i.radius();
        let mut scratch = self.scratch.lend()?;
        // A row with zeros on either side: what is not there weighs nothing.
        let mut padded = self.rows.lend()?;
        padded.fill(0.0);
        for (j, row) in scratch.chunks_exact_mut(nx).enumerate() {
            load(j * nx, padded.get_mut(radius..radius + nx).unwrap_or_default());
            let part = |first: usize| padded.get(first..first + nx);
            row.copy_from_slice(part(radius).unwrap_or_default());
            for (d, &weight) in along_i.weights.iter().enumerate().skip(1) {
                add(row, weight, part(radius - d), part(radius + d));
            }
        }
        let row_at = |j: usize| scratch.get(j * nx..(j + 1) * nx);
        for (j, row) in out.chunks_exact_mut(nx).enumerate() {
            row.copy_from_slice(row_at(j).unwrap_or_default());
            for (d, &weight) in along_j.weights.iter().enumerate().skip(1) {
                add(row, weight, j.checked_sub(d).and_then(row_at), row_at(j + d));
            }
        }
        Ok(())
    }

    /// Blurs along k into plane `k` of the result; `at` gives the planes within the radius.
    pub(super) fn across<'p>(
        &self,
        k: usize,
        at: impl Fn(usize) -> Option<&'p Blurred>,
        out: &mut [f64],
    ) {
        let nx = self.dims.nx();
        let [along_i, along_j, along_k] = &self.axes;
        let planes: Vec<(f64, Option<&Blurred>, Option<&Blurred>)> = along_k
            .weights
            .iter()
            .enumerate()
            .map(|(d, &weight)| {
                let below = k.checked_sub(d).and_then(&at);
                (weight, below, if d == 0 { None } else { at(k + d) })
            })
            .collect();
        let whole = planes
            .iter()
            .all(|(_, a, b)| [a, b].into_iter().flatten().all(|plane| plane.holes.is_none()));
        let total_k = along_k.totals.get(k).copied().unwrap_or(1.0);
        let mut weights = vec![0.0; if whole { 0 } else { nx }];
        for (j, row) in out.chunks_exact_mut(nx).enumerate() {
            let place = j * nx..(j + 1) * nx;
            let total_j = along_j.totals.get(j).copied().unwrap_or(1.0);
            row.fill(0.0);
            for &(weight, a, b) in &planes {
                let part = |p: &'p Blurred| p.sums.get(place.clone());
                add(row, weight, a.and_then(part), b.and_then(part));
            }
            if whole {
                for (x, &total_i) in row.iter_mut().zip(&along_i.totals) {
                    *x /= total_i * (total_j * total_k);
                }
                continue;
            }
            weights.fill(0.0);
            for &(weight, a, b) in &planes {
                for plane in [a, b].into_iter().flatten() {
                    if let Some(holes) = &plane.holes {
                        add(&mut weights, weight, holes.weights.get(place.clone()), None);
                    } else {
                        add(&mut weights, weight * total_j, Some(&along_i.totals), None);
                    }
                }
            }
            let counts = at(k).and_then(|p| p.holes.as_ref()?.counts.get(place.clone()));
            for (i, (x, &weight)) in row.iter_mut().zip(&weights).enumerate() {
                let counts = counts.is_none_or(|c| c.get(i).copied().unwrap_or(false));
                *x = if counts { *x / weight } else { f64::NAN };
            }
        }
    }
}

/// A row of samples as numbers.
fn fill<T: Copy>(row: &mut [f64], from: &[T], number: impl Fn(T) -> f64) {
    for (to, &x) in row.iter_mut().zip(from) {
        *to = number(x);
    }
}

/// Adds the weighted sum of two rows, or of the one that is there.
fn add(to: &mut [f64], weight: f64, a: Option<&[f64]>, b: Option<&[f64]>) {
    match (a, b) {
        (Some(a), Some(b)) => {
            for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
                *to += weight * (a + b);
            }
        }
        (Some(one), None) | (None, Some(one)) => {
            for (to, one) in to.iter_mut().zip(one) {
                *to += weight * one;
            }
        }
        (None, None) => {}
    }
}
