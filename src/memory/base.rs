//! The base grid in an increment: all its knots move, those beyond their limit are brought back.
//!
//! Knots are treated some at a time, with fixed weights: the sums here are those of a
//! curve without floating knots. The segments that fronts and floating knots divide are put right afterwards.

use super::grid::{Grid, Lanes};
use super::lane::{Lane, WIDTH};
use super::{Curve, Matrix, Vector, is_outside, length};
use std::array::from_fn;

/// What the base grid alone gives.
pub(super) struct Moved<const N: usize> {
    /// Bit k: base knot k slips.
    pub(super) slips: u64,
    /// Energy dissipated by the knots that slip; the segment below the first one is not in it.
    pub(super) dissipated: f64,
    /// Knots that slip turn on their limit: their part of the tangent.
    pub(super) turn: Matrix<N>,
}

impl<const N: usize> Curve<N> {
    /// Moves the base knots by `d`; `end`, empty, gets them.
    #[inline(always)]
    pub(super) fn move_base(&self, grid: &Grid<N>, d: &Vector<N>, end: &mut Curve<N>) -> Moved<N> {
        if N == 1 {
            return self.move_top(grid, d, end);
        }
        let mut sums = Sums::new();
        let mut slips = 0;
        end.base.push([0.0; N]);
        let knots = self.base[1..].as_chunks::<WIDTH>().0;
        for (chunk, (lanes, knots)) in grid.lanes.iter().zip(knots).enumerate() {
            let (knots, bits) = sums.add(lanes, knots, d);
            slips |= bits << (chunk * WIDTH);
            // It has room for as many.
            let _ = end.base.try_extend_from_slice(&knots);
        }
        Moved {
            slips,
            dissipated: sums.dissipated.sum(),
            turn: sums.turn(),
        }
    }

    /// The same in one direction, where the only base knot is r = 1 and cannot turn.
    #[inline(always)]
    fn move_top(&self, grid: &Grid<N>, d: &Vector<N>, end: &mut Curve<N>) -> Moved<N> {
        let node = &grid.nodes[0];
        let e = Vector::from(self.base[1]) + d;
        let slips = is_outside(node.r, &e, d);
        let limited = if slips {
            e.map(|e| node.r.copysign(e))
        } else {
            e
        };
        end.base.push([0.0; N]);
        end.base.push(limited.into());
        Moved {
            slips: u64::from(slips),
            dissipated: length(&(e - limited)) * (1.0 - node.loss_secant),
            turn: Matrix::zeros(),
        }
    }

    /// Traction and stored energy of the base knots alone.
    #[inline(always)]
    pub(super) fn base_sums(&self, grid: &Grid<N>) -> (Vector<N>, f64) {
        let (mut traction, mut stored) = (Vector::zeros(), Vector::<N>::zeros());
        let mut below = Vector::<N>::zeros();
        for (node, e) in grid.nodes.iter().zip(self.base()) {
            let e = Vector::from(*e);
            traction += e * node.weight;
            stored += e.component_mul(&(e * node.energy + below * node.energy_below));
            below = e;
        }
        (traction, stored.sum())
    }
}

/// Sums over the base knots, lane by lane.
struct Sums<const N: usize> {
    dissipated: Lane,
    /// Weight times gain times n n^T: lower triangle.
    turn: [[Lane; N]; N],
}

impl<const N: usize> Sums<N> {
    fn new() -> Self {
        Sums {
            dissipated: Lane::ZERO,
            turn: [[Lane::ZERO; N]; N],
        }
    }

    /// Moves some knots and brings those that slip back onto their limits; gives which do, bit by bit.
    #[inline(always)]
    fn add(
        &mut self,
        lanes: &Lanes,
        knots: &[[f64; N]; WIDTH],
        d: &Vector<N>,
    ) -> ([[f64; N]; WIDTH], u64) {
        let mut e: [Lane; N] = from_fn(|i| Lane(from_fn(|lane| knots[lane][i])) + Lane::all(d[i]));
        let length2 = dot(&e, &e);
        let mut bits = 0;
        // The limit first: where all stick nothing else is asked.
        let reached = length2.at_least(lanes.outside);
        if reached.bits() != 0 {
            let along = dot(&e, &from_fn(|i| Lane::all(d[i])));
            let slips = reached.and_positive(along);
            bits = slips.bits();
            let one = slips.number();
            // Of those that stick the limit itself, so that they stay what they are.
            let length = slips.pick(length2.sqrt(), lanes.r);
            let gain = lanes.r / length;
            let excess = length.max(lanes.r) - lanes.r;
            self.dissipated = self.dissipated + excess * lanes.loss;
            for e in &mut e {
                *e = *e * gain;
            }
            let turn = lanes.turn * gain * one;
            for i in 0..N {
                for j in 0..i + 1 {
                    self.turn[i][j] = self.turn[i][j] + turn * (e[i] * e[j]);
                }
            }
        }
        (from_fn(|lane| from_fn(|i| e[i].0[lane])), bits)
    }

    /// Weight times gain times (I - n n^T).
    #[inline(always)]
    fn turn(&self) -> Matrix<N> {
        let turn = Matrix::<N>::from_fn(|i, j| self.turn[i.max(j)][i.min(j)].sum());
        Matrix::identity() * turn.trace() - turn
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[Lane; N], b: &[Lane; N]) -> Lane {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum = sum + a[i] * b[i];
    }
    sum
}
