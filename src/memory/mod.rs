//! The memory curve: what the contact remembers, and how it moves.
//!
//! The state is a curve u(R), 0 <= R <= G: the elastic deflection (a length) of the slip element whose slip limit is
//! R (a length). u(0) = 0 and |u(R)| <= R: the curve stays inside a cone whose apex is the contact's present position.
//! G is the critical slip at the present limit traction T. The curve is kept as knots (R_k, u_k), linear in between, the
//! last one at R = G. With the backbone f(R/G), slopes m = du/dR and f' = df/dR:
//!
//! ```text
//! tau = T sum_k m_k [f_k+1 - f_k]                                                    (1) traction
//! psi = T sum_k [ m.(f_k+1 u_k+1 - f_k u_k) - |m|^2 (F_k+1 - F_k) ]                  (2) stored energy
//! ```
//!
//! An increment is a slip d together with a growth De of the cone from G - De to G. Elements are born at the apex when
//! it grows and die there when it shrinks; an old element keeps its distance x = G - R from the base of the cone, its
//! stiffness and its deflection. So every knot goes to (R + De, u + d), and what is then outside the cone slips.
//!
//! [`line`] is the law for one direction, [`plane`] for two. See docs/theory.md for the derivation.

pub mod line;
pub mod plane;

use crate::backbone::Backbone;
use crate::state::{Contact, Knots};
use nalgebra::{SMatrix, SVector};
use std::any::Any;

/// A vector in the tangential plane: N = 1 or 2 directions.
pub type Vector<const N: usize> = SVector<f64, N>;
/// A tangent in the tangential plane.
pub type Matrix<const N: usize> = SMatrix<f64, N, N>;

/// A knot whose removal changes the traction by less than this part of T is not needed.
const NEGLIGIBLE: f64 = 1e-14;
/// A knot nearer to the apex than this part of G is not kept: secants below it are rounding.
const AT_APEX: f64 = 1e-15;
/// A deflection within this part of its slip limit is on the cone.
const ON_CONE: f64 = 1e-6;
/// The largest part of the sticking stiffness that may have slipped in a contact called sticking.
const STICK: f64 = 0.99;

/// A slip increment together with a change of the critical slip. All lengths have one unit, in which G is about 1.
#[derive(Clone, Copy, Debug)]
pub struct Increment<const N: usize> {
    /// d: slip, length.
    pub slip: Vector<N>,
    /// G before: where the curve at the start ends; 0 when it is empty.
    pub before: f64,
    /// G at the end; > 0.
    pub critical: f64,
    /// T before over T at the end: the weight of what dies.
    pub limit_ratio: f64,
    /// How many knots the end may have.
    pub room: usize,
    /// How fine a turning path is kept (two directions).
    pub resolution: f64,
    /// The part of T that the last increment gave up: halving finer than that is of no use (two directions).
    pub forgotten: f64,
}

/// What an increment gives. Tractions over T, lengths in the unit of the increment.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<const N: usize> {
    /// tau / T.
    pub traction: Vector<N>,
    /// d(tau / T) / d slip at constant G, per length; [i][j]: component i by slip j.
    pub by_slip: Matrix<N>,
    /// (d tau / dG) / T at constant slip and constant stiffness of every element, per length.
    pub by_growth: Vector<N>,
    /// psi / T, length.
    pub stored: f64,
    /// Dissipation of the increment over T, length.
    pub dissipated: f64,
    /// Where the contact stands.
    pub contact: Contact,
    /// The largest part of T that was given up for want of room.
    pub forgotten: f64,
}

impl Contact {
    /// Gross slip when the end of the curve slipped; otherwise by how much of the stiffness has slipped.
    fn of(gross: bool, slope_at_front: f64, initial_slope: f64) -> Self {
        if gross {
            Contact::GrossSlip
        } else if slope_at_front >= STICK * initial_slope {
            Contact::Stick
        } else {
            Contact::MicroSlip
        }
    }
}

/// Moves the curve `start` by an increment; `end`, empty before, gets the curve at the end. N is 1 or 2.
#[inline(always)]
pub fn step<B: Backbone, const N: usize>(
    backbone: &B,
    start: &mut Knots<N>,
    increment: &Increment<N>,
    end: &mut Knots<N>,
) -> Outcome<N> {
    // Which N it is, is known when this is compiled.
    let mut outcome: Option<Outcome<N>> = None;
    if let (Some(outcome), Some(start), Some(increment), Some(end)) = (
        same::<_, Option<Outcome<1>>>(&mut outcome),
        same(start),
        same(&mut increment.clone()),
        same(end),
    ) {
        *outcome = Some(line::step(backbone, start, increment, end));
    } else if let (Some(outcome), Some(start), Some(increment), Some(end)) = (
        same::<_, Option<Outcome<2>>>(&mut outcome),
        same(start),
        same(&mut increment.clone()),
        same(end),
    ) {
        *outcome = Some(plane::step(backbone, start, increment, end));
    }
    outcome.expect("a law has one direction or two")
}

/// A value as what it is.
#[inline(always)]
fn same<A: 'static, B: 'static>(value: &mut A) -> Option<&mut B> {
    (value as &mut dyn Any).downcast_mut()
}
