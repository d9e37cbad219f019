//! What the coder learns as it goes: the sums of each context, and how an error is made of a code
//! and changes them.

/// Sums of a context of regular mode (T.87, A.2.1 and A.6).
#[derive(Clone, Copy)]
pub(super) struct Regular {
    /// Sum of the errors' magnitudes.
    a: u32,
    /// Sum of the errors, within `-n` to 0 between samples.
    b: i32,
    /// What is added to a prediction.
    c: i32,
    /// Errors counted, at least 1.
    n: u32,
}

/// The smallest k with `n << k >= a` (T.87, A.5.1). `n` is at least 1.
#[inline]
fn golomb_k(a: u32, n: u32) -> u32 {
    let k = n.leading_zeros().saturating_sub(a.leading_zeros());
    k + u32::from(n << k < a)
}

impl Regular {
    pub(super) fn new(a: u32) -> Self {
        Self { a, b: 0, c: 0, n: 1 }
    }

    /// What is added to a prediction, for a positive sign.
    #[inline]
    pub(super) fn bias(&self) -> i32 {
        self.c
    }

    /// The Golomb parameter.
    #[inline]
    pub(super) fn k(&self) -> u32 {
        golomb_k(self.a, self.n)
    }

    /// The error that the number `mapped` stands for (T.87, A.5.2), with `k` as [`Self::k`] gives
    /// it.
    #[inline]
    pub(super) fn unmap(&self, mapped: u32, k: u32, near: i32) -> i32 {
        let error = (mapped >> 1) as i32 ^ -((mapped & 1) as i32);
        let turned = near == 0 && k == 0 && 2 * self.b <= -(self.n as i32);
        error ^ -i32::from(turned)
    }

    /// Counts an error of `error` steps of `step` (T.87, A.6).
    #[inline]
    pub(super) fn update(&mut self, error: i32, step: i32, reset: u32) {
        let mut a = self.a + error.unsigned_abs();
        let mut b = self.b + error * step;
        let mut n = self.n;
        if n == reset {
            a >>= 1;
            // The same as the standard's -((1 - b) >> 1) where b is negative.
            b >>= 1;
            n >>= 1;
        }
        n += 1;
        let count = n as i32;
        let mut c = self.c;
        if b <= -count {
            b = (b + count).max(1 - count);
            c = (c - 1).max(-128);
        } else if b > 0 {
            b = (b - count).min(0);
            c = (c + 1).min(127);
        }
        *self = Self { a, b, c, n };
    }
}

/// Sums of one of the two contexts of a sample that ends a run (T.87, A.7.2).
#[derive(Clone, Copy)]
pub(super) struct RunEnd {
    a: u32,
    n: u32,
    /// Negative errors among them.
    negative: u32,
    /// 1 where the samples at the left and above are the same, within NEAR.
    kind: u32,
}

impl RunEnd {
    pub(super) fn new(a: u32, kind: u32) -> Self {
        Self { a, n: 1, negative: 0, kind }
    }

    /// The Golomb parameter.
    pub(super) fn k(&self) -> u32 {
        golomb_k(self.a + self.kind * (self.n >> 1), self.n)
    }

    /// The error that the number `mapped` stands for, with `k` as [`Self::k`] gives it.
    pub(super) fn unmap(&self, mapped: u32, k: u32) -> i32 {
        let sum = mapped + self.kind;
        let map = sum & 1;
        let size = sum.div_ceil(2) as i32;
        let mostly_negative = k != 0 || 2 * self.negative >= self.n;
        if mostly_negative == (map == 1) { -size } else { size }
    }

    /// Counts an error.
    pub(super) fn update(&mut self, error: i32, mapped: u32, reset: u32) {
        self.negative += u32::from(error < 0);
        self.a += (mapped + 1 - self.kind) >> 1;
        if self.n == reset {
            self.a >>= 1;
            self.n >>= 1;
            self.negative >>= 1;
        }
        self.n += 1;
    }
}
