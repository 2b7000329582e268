//! Numbers side by side, one for each of some knots.
//!
//! Plain arithmetic, number by number and without branches: the form that compilers turn into vector instructions.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// How many.
pub(super) const WIDTH: usize = 2;

/// Numbers, one per knot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lane(pub(super) [f64; WIDTH]);

/// Conditions, one per knot.
#[derive(Clone, Copy)]
pub(super) struct Mask([bool; WIDTH]);

impl Lane {
    pub(super) const ZERO: Self = Lane([0.0; WIDTH]);
    const ONE: Self = Lane([1.0; WIDTH]);

    /// The same number for all knots.
    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Lane([x; WIDTH])
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Lane(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        Lane(from_fn(|i| {
            if self.0[i] > other.0[i] {
                self.0[i]
            } else {
                other.0[i]
            }
        }))
    }

    #[inline(always)]
    pub(super) fn at_least(self, limit: Self) -> Mask {
        Mask(from_fn(|i| self.0[i] >= limit.0[i]))
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Mask {
    /// Where it holds and x > 0.
    #[inline(always)]
    pub(super) fn and_positive(self, x: Lane) -> Self {
        Mask(from_fn(|i| self.0[i] & (x.0[i] > 0.0)))
    }

    /// Bit i: the condition of knot i.
    #[inline(always)]
    pub(super) fn bits(self) -> u64 {
        let bits = self.0.iter().enumerate();
        bits.fold(0, |bits, (i, holds)| bits | u64::from(*holds) << i)
    }

    /// 1 where it holds, 0 elsewhere.
    #[inline(always)]
    pub(super) fn number(self) -> Lane {
        self.pick(Lane::ONE, Lane::ZERO)
    }

    /// `a` where it holds, `b` elsewhere.
    #[inline(always)]
    pub(super) fn pick(self, a: Lane, b: Lane) -> Lane {
        Lane(from_fn(|i| if self.0[i] { a.0[i] } else { b.0[i] }))
    }
}

impl Add for Lane {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Lane {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul for Lane {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] * other.0[i]))
    }
}

impl Div for Lane {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] / other.0[i]))
    }
}
