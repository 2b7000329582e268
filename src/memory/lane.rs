//! N numbers side by side: one for each of N knots, or for each direction.
//!
//! Plain arithmetic, number by number and without branches: the form that compilers turn into vector instructions.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// N numbers, one per knot or direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lane<const N: usize>(pub(super) [f64; N]);

/// N conditions, one per knot.
#[derive(Clone, Copy)]
pub(super) struct Mask<const N: usize>([bool; N]);

impl<const N: usize> Lane<N> {
    pub(super) const ZERO: Self = Lane([0.0; N]);
    const ONE: Self = Lane([1.0; N]);

    /// The same number for all knots.
    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Lane([x; N])
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

    /// Whether `self` >= `limit` and `along` > 0.
    #[inline(always)]
    pub(super) fn reaches(self, limit: Self, along: Self) -> Mask<N> {
        Mask(from_fn(|i| (self.0[i] >= limit.0[i]) & (along.0[i] > 0.0)))
    }

    #[inline(always)]
    pub(super) fn at_most(self, limit: Self) -> Mask<N> {
        Mask(from_fn(|i| self.0[i] <= limit.0[i]))
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl<const N: usize> Mask<N> {
    #[inline(always)]
    pub(super) fn any(self) -> bool {
        self.0.iter().any(|holds| *holds)
    }

    /// 1 where it holds, 0 elsewhere.
    #[inline(always)]
    pub(super) fn number(self) -> Lane<N> {
        self.pick(Lane::ONE, Lane::ZERO)
    }

    /// `a` where it holds, `b` elsewhere.
    #[inline(always)]
    pub(super) fn pick(self, a: Lane<N>, b: Lane<N>) -> Lane<N> {
        Lane(from_fn(|i| if self.0[i] { a.0[i] } else { b.0[i] }))
    }
}

impl<const N: usize> Add for Lane<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> Sub for Lane<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl<const N: usize> Mul for Lane<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] * other.0[i]))
    }
}

impl<const N: usize> Div for Lane<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Lane(from_fn(|i| self.0[i] / other.0[i]))
    }
}
