//! The coded samples, line by line (T.87, annex A). Holds two lines and the contexts; never more.

use super::bits::Bits;
use super::context::{Regular, RunEnd};
use super::preset::Coding;
use crate::source::dicom::bits::Fault;

/// The order of a run's Golomb code, by how long runs have been (T.87, A.2.1).
const J: [u8; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// 9³ triples of quantised gradients, a triple and its negative being one (T.87, A.3.4).
const CONTEXTS: usize = 365;

/// The decoder between two restart markers.
///
/// Lines have a sample before their first and one after their last: position `x + 1` is sample `x`.
/// The one before is the line above's first sample, the one after repeats the last (T.87, A.2.1,
/// figure A.1 and its text).
pub(super) struct Scan {
    coding: Coding,
    regular: [Regular; CONTEXTS],
    run_end: [RunEnd; 2],
    run_index: usize,
    above: Vec<i32>,
    line: Vec<i32>,
    /// The part of each context number that the line above settles.
    settled: Vec<i32>,
}

impl Scan {
    /// For lines of `cols` samples; `None` where there is no memory for them.
    pub(super) fn new(coding: Coding, cols: usize) -> Option<Self> {
        let zeros = |len: usize| {
            let mut zeros = Vec::new();
            zeros.try_reserve_exact(len).ok()?;
            zeros.resize(len, 0);
            Some(zeros)
        };
        // A.2.1: the same for all contexts.
        let a = ((coding.range + 32) / 64).max(2).unsigned_abs();
        Some(Self {
            coding,
            regular: [Regular::new(a); CONTEXTS],
            run_end: [RunEnd::new(a, 0), RunEnd::new(a, 1)],
            run_index: 0,
            above: zeros(cols.checked_add(2)?)?,
            line: zeros(cols.checked_add(2)?)?,
            settled: zeros(cols)?,
        })
    }

    /// Forgets all that was learned, lines too, as after a restart marker (T.87, C.2.5).
    pub(super) fn restart(&mut self) {
        let a = ((self.coding.range + 32) / 64).max(2).unsigned_abs();
        self.regular.fill(Regular::new(a));
        self.run_end = [RunEnd::new(a, 0), RunEnd::new(a, 1)];
        self.run_index = 0;
        self.above.fill(0);
        self.line.fill(0);
    }

    /// Decodes a line and lends its samples.
    pub(super) fn line(&mut self, bits: &mut Bits<'_>) -> Result<&[i32], Fault> {
        if let (Some(before), Some(&first)) = (self.line.first_mut(), self.above.get(1)) {
            *before = first;
        }
        self.settle();
        if self.coding.near == 0 {
            self.samples::<true>(bits)?;
        } else {
            self.samples::<false>(bits)?;
        }
        std::mem::swap(&mut self.above, &mut self.line);
        if let [.., last, after] = &mut self.above[..] {
            *after = *last;
        }
        Ok(self.above.get(1..=self.settled.len()).unwrap_or_default())
    }

    /// Quantises the two gradients of each sample that lie in the line above (T.87, A.3.3).
    fn settle(&mut self) {
        let coding = &self.coding;
        for (settled, above) in self.settled.iter_mut().zip(self.above.windows(3)) {
            if let &[c, b, d] = above {
                *settled = 81 * quantise(coding, d - b) + 9 * quantise(coding, b - c);
            }
        }
    }

    /// The samples of a line, from left to right.
    #[inline(never)]
    fn samples<const LOSSLESS: bool>(&mut self, bits: &mut Bits<'_>) -> Result<(), Fault> {
        let coding = Coding { near: if LOSSLESS { 0 } else { self.coding.near }, ..self.coding };
        let cols = self.settled.len();
        let mut x = 0;
        while x < cols {
            let (c, b) = (self.above[x], self.above[x + 1]);
            let a = self.line[x];
            let context = self.settled[x] + quantise(&coding, c - a);
            if context == 0 {
                x = self.run(&coding, bits, x)?;
            } else {
                let negative = context >> 31;
                let sums = &mut self.regular[context.unsigned_abs() as usize % CONTEXTS];
                // A.4.1 and A.4.2: the median of a, b and a + b - c, and the context's bias.
                let median = (a + b - c).clamp(a.min(b), a.max(b));
                let guess = median + ((sums.bias() ^ negative) - negative);
                let guess = guess.clamp(0, coding.maxval);
                let k = sums.k();
                let mapped = bits.golomb(k, coding.limit - coding.qbpp - 1, coding.qbpp)?;
                if mapped > coding.range as u32 {
                    return Err(Fault::Code);
                }
                let error = sums.unmap(mapped, k, coding.near);
                sums.update(error, 2 * coding.near + 1, coding.reset);
                self.line[x + 1] = rebuild(&coding, guess, (error ^ negative) - negative);
                x += 1;
            }
        }
        Ok(())
    }

    /// A run from sample `x` on, with the sample that ends it unless the line does (T.87, A.7).
    /// Gives the sample after it.
    fn run(&mut self, coding: &Coding, bits: &mut Bits<'_>, x: usize) -> Result<usize, Fault> {
        let a = self.line[x];
        let rest = &mut self.line[x + 1..=self.settled.len()];
        let mut length = 0;
        while length < rest.len() {
            let order = J[self.run_index];
            if bits.bit()? {
                let step = 1 << order;
                length += step;
                if length <= rest.len() {
                    self.run_index = (self.run_index + 1).min(J.len() - 1);
                }
            } else {
                length += bits.number(order.into())? as usize;
                if length >= rest.len() {
                    return Err(Fault::Code);
                }
                break;
            }
        }
        let length = length.min(rest.len());
        rest[..length].fill(a);
        let end = x + length;
        if end == self.settled.len() {
            return Ok(end);
        }
        self.line[end + 1] = self.run_end(coding, bits, a, self.above[end + 1])?;
        self.run_index = self.run_index.saturating_sub(1);
        Ok(end + 1)
    }

    /// The sample that ends a run of samples `a`, under a sample `b` (T.87, A.7.2).
    fn run_end(
        &mut self,
        coding: &Coding,
        bits: &mut Bits<'_>,
        a: i32,
        b: i32,
    ) -> Result<i32, Fault> {
        let same = (a - b).abs() <= coding.near;
        let sums = &mut self.run_end[usize::from(same)];
        let k = sums.k();
        // The longest code of a run takes its share of the limit.
        let limit = coding.limit - u32::from(J[self.run_index]) - 1;
        let mapped = bits.golomb(k, limit - coding.qbpp - 1, coding.qbpp)?;
        if mapped > coding.range as u32 {
            return Err(Fault::Code);
        }
        let error = sums.unmap(mapped, k);
        sums.update(error, mapped, coding.reset);
        let (guess, error) = match same {
            true => (a, error),
            false if a > b => (b, -error),
            false => (b, error),
        };
        Ok(rebuild(coding, guess, error))
    }
}

/// One of nine steps for a gradient (T.87, A.3.3). The thresholds rise, so that counting those
/// that are reached is the standard's chain of comparisons.
#[inline]
fn quantise(coding: &Coding, gradient: i32) -> i32 {
    let size = gradient.abs();
    let reached = i32::from(size > coding.near)
        + i32::from(size >= coding.t1)
        + i32::from(size >= coding.t2)
        + i32::from(size >= coding.t3);
    let negative = gradient >> 31;
    (reached ^ negative) - negative
}

/// The sample that is `error` steps from `guess`, errors being counted round a ring (T.87, A.4.5).
#[inline]
fn rebuild(coding: &Coding, guess: i32, error: i32) -> i32 {
    let step = 2 * coding.near + 1;
    let mut sample = guess + error * step;
    if sample < -coding.near {
        sample += coding.range * step;
    } else if sample > coding.maxval + coding.near {
        sample -= coding.range * step;
    }
    sample.clamp(0, coding.maxval)
}
