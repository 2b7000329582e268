//! The memory curve: what the contact remembers, and how it moves.
//!
//! Everything here is normalised: slip by the critical slip, traction by mu p. The state is a curve e(r),
//! 0 <= r <= 1: the elastic deflection of the slip element whose slip limit is r, with |e(r)| <= r and
//! e(0) = 0. It is kept as sorted knots, linear in between. Two kinds of knot: those of a fixed **base** grid are
//! never dropped, **floating** ones stand where a reversal turned and at the front of the slipping elements.
//!
//! The traction is the sum over the elements, integrated by parts so that only secants of the backbone are needed:
//!
//! ```text
//! t = sum_k (e_k+1 - e_k) / (r_k+1 - r_k) (f(r_k+1) - f(r_k))
//! ```
//!
//! A slip increment d moves every element by d; those beyond their limit slip (radial return). On a straight
//! path that is exact to rounding, for any number of reversals that the floating knots can hold.
//!
//! `step` is the increment, for one direction and for two; `base` moves the base grid, `chain` holds the floating knots
//! that are left, `room` chooses what to drop when they do not fit.

mod base;
mod chain;
mod grid;
mod knot;
mod lane;
mod room;
mod step;

pub use grid::{Grid, Node};

use crate::backbone::Backbone;
use crate::state::{Contact, MAX_BASE, MAX_FLOATING};
use arrayvec::ArrayVec;
use knot::Knot;
use lane::WIDTH;
use nalgebra::{SMatrix, SVector};
use step::Step;

/// A vector in the tangential plane: N = 1 or 2 directions.
pub type Vector<const N: usize> = SVector<f64, N>;
/// A tangent in the tangential plane.
pub type Matrix<const N: usize> = SMatrix<f64, N, N>;

/// Rounding of r and e: what is closer than this is the same.
const SAME: f64 = 1e-14;
/// Rounding leaves this much of |e|^2 beyond a slip limit; only what exceeds it is worth a projection.
pub const ROUNDING: f64 = 1e-13;
/// Room for what a full state holds and every front that one increment can make.
const MOST_KNOTS: usize = 2 * MAX_FLOATING + MAX_BASE;
/// A floating knot whose removal changes the traction by less than this is not needed.
const NEGLIGIBLE: f64 = 1e-14;
/// A segment whose slope agrees with the yield boundary's to this lies along it.
const ALONG_BOUNDARY: f64 = 1e-7;
/// Below this length, relative to r, a secant of the backbone loses digits and the mean of the slopes is better.
const SHORT: f64 = 1e-7;
/// Squared length of an increment too small to have a direction.
const NO_SLIP: f64 = 1e-280;
/// The largest part of the sticking stiffness that may have slipped in a contact called sticking.
const STICK: f64 = 0.99;

/// Length of a vector.
#[inline(always)]
pub fn length<const N: usize>(e: &Vector<N>) -> f64 {
    if N == 1 { e[0].abs() } else { e.norm() }
}

/// `e` brought radially onto the slip limit r.
pub fn onto_limit<const N: usize>(r: f64, e: &Vector<N>) -> Vector<N> {
    e * (r / e.norm())
}

/// Squared length from which a trial deflection is outside the slip limit r.
#[inline(always)]
fn outside(r: f64) -> f64 {
    let limit = (r - SAME).max(0.0);
    limit * limit
}

/// Whether a trial deflection is outside the slip limit r, or at it, and on the way out.
#[inline(always)]
fn is_outside<const N: usize>(r: f64, e: &Vector<N>, d: &Vector<N>) -> bool {
    let outside = if N == 1 {
        e[0].abs() >= r - SAME
    } else {
        e.norm_squared() >= outside(r)
    };
    outside & (d.dot(e) > 0.0)
}

/// A floating knot.
#[derive(Clone, Copy, Debug)]
pub struct Floating<const N: usize> {
    /// Slip limit.
    pub r: f64,
    /// Elastic deflection.
    pub e: Vector<N>,
    /// The base knot next above.
    above: usize,
}

/// A memory curve: the deflections of the base grid, and the floating knots between them.
#[derive(Clone, Debug, Default)]
pub struct Curve<const N: usize> {
    /// Knot 0, which has no deflection, the base knots, and numbers that nobody asks for up to whole lanes.
    base: ArrayVec<[f64; N], { 1 + MAX_BASE }>,
    floating: ArrayVec<Floating<N>, MAX_FLOATING>,
}

/// What an increment gives, normalised.
#[derive(Clone, Debug)]
pub struct Increment<const N: usize> {
    /// Traction over mu p.
    pub traction: Vector<N>,
    /// d traction / d slip increment.
    pub tangent: Matrix<N>,
    /// What the traction loses when the remembered deflections shrink: d traction / d(log of their scale).
    pub shrinkage: Vector<N>,
    /// Stored energy over gcr mu p.
    pub stored: f64,
    /// Energy dissipated by slip over gcr mu p.
    pub dissipated: f64,
    /// Where the contact stands; None for a zero increment, which changes nothing.
    pub contact: Option<Contact>,
    /// A reversal that mattered had to be dropped.
    pub full: bool,
}

impl<const N: usize> Curve<N> {
    /// An empty curve.
    #[inline]
    pub fn new() -> Self {
        Curve {
            base: ArrayVec::new(),
            floating: ArrayVec::new(),
        }
    }

    /// Deflections of the base knots, ascending in r (after them there may be one that nobody asks for).
    #[inline]
    pub fn base(&self) -> &[[f64; N]] {
        &self.base[1..]
    }

    /// The floating knots, ascending in r.
    #[inline]
    pub fn floating(&self) -> &[Floating<N>] {
        &self.floating
    }

    /// Takes the base knots; false when one is longer than its slip limit, or not a number.
    #[inline(always)]
    pub fn set_base(&mut self, grid: &Grid<N>, base: &[[f64; N]]) -> bool {
        self.base.clear();
        self.base.push([0.0; N]);
        if self.base.try_extend_from_slice(base).is_err() {
            return false;
        }
        // In one direction there is one, and it is treated alone.
        while N > 1 && self.base.len() % WIDTH != 1 {
            self.base.push([0.0; N]);
        }
        grid.holds(&self.base[1..])
    }

    /// Sets base knot k (from 0).
    pub fn set_base_knot(&mut self, k: usize, e: Vector<N>) {
        self.base[1 + k] = e.into();
    }

    /// Adds the next floating knot, which lies below base knot `above` (from 0).
    #[inline]
    pub fn push_floating(&mut self, r: f64, e: Vector<N>, above: usize) {
        self.floating.push(Floating { r, e, above });
    }

    /// Empties the memory.
    pub fn forget(&mut self) {
        self.floating.clear();
        self.base.fill([0.0; N]);
    }

    /// All slip elements at their limit in one direction (a unit vector).
    pub fn saturate(&mut self, direction: &Vector<N>, nodes: &[Node]) {
        for (e, node) in self.base[1..].iter_mut().zip(nodes) {
            *e = (direction * node.r).into();
        }
    }

    /// Moves the curve by the slip increment `d` after scaling it by `scale` (pressure rule); `end`, empty, gets the
    /// curve at the end, with at most `room` floating knots. This curve is used up.
    #[inline(always)]
    pub fn advance<B: Backbone>(
        &mut self,
        backbone: &B,
        grid: &Grid<N>,
        d: &Vector<N>,
        scale: f64,
        room: usize,
        end: &mut Curve<N>,
    ) -> Increment<N> {
        let scaled = scale != 1.0;
        if scaled {
            self.scale(scale);
        }
        let moves = d.norm_squared() >= NO_SLIP;
        let d = if moves { *d } else { Vector::zeros() };
        let step = Step {
            backbone,
            grid,
            start: self,
            d: &d,
            moves,
            base_slips: 0,
            floating_slips: 0,
        };
        step.run(scaled, room, end)
    }

    fn scale(&mut self, scale: f64) {
        for e in &mut self.base {
            *e = (Vector::from(*e) * scale).into();
        }
        for knot in &mut self.floating {
            knot.e *= scale;
        }
    }

    /// Base knot number `count` as it is, 0 for the origin.
    #[inline(always)]
    fn settled(&self, grid: &Grid<N>, count: usize) -> Knot<N> {
        match count.checked_sub(1) {
            Some(k) => grid.knot(k, self.base[count].into()),
            None => grid.origin(),
        }
    }
}
