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

use crate::backbone::{Backbone, Over, Values};
use crate::state::{Contact, Knot, Knots};
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

/// A slip increment together with a change of the critical slip. All lengths have one unit, in which fourth powers of G and
/// of the slip are numbers.
#[derive(Debug)]
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
#[derive(Debug)]
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

impl<const N: usize> Outcome<N> {
    /// All zero.
    #[inline(always)]
    pub fn new() -> Self {
        Outcome {
            traction: Vector::zeros(),
            by_slip: Matrix::zeros(),
            by_growth: Vector::zeros(),
            stored: 0.0,
            dissipated: 0.0,
            contact: Contact::Open,
            forgotten: 0.0,
        }
    }
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

/// Moves the curve `start`, which is used up, by an increment; `end`, empty before, gets the curve at the end, and
/// `outcome`, all zero before, what the increment gives. N is 1 or 2.
#[inline(always)]
pub fn step<B: Backbone, const N: usize>(
    backbone: &B,
    start: &mut Knots<N>,
    increment: &mut Increment<N>,
    end: &mut Knots<N>,
    outcome: &mut Outcome<N>,
) {
    // Which N it is, is known when this is compiled.
    if let Some(start) = same(start)
        && let (Some(increment), Some(end), Some(outcome)) =
            (same(increment), same(end), same(outcome))
    {
        line::step(backbone, start, increment, end, outcome);
    } else if let Some(start) = same(start)
        && let (Some(increment), Some(end), Some(outcome)) =
            (same(increment), same(end), same(outcome))
    {
        plane::step(backbone, start, increment, end, outcome);
    }
}

/// A value as what it is.
#[inline(always)]
fn same<A: 'static, B: 'static>(value: &mut A) -> Option<&mut B> {
    (value as &mut dyn Any).downcast_mut()
}

/// Where the apex moves to in a curve whose cone shrinks by `depth`: how many knots die, and the deflection there.
#[inline(always)]
fn cut<const N: usize>(knots: &Knots<N>, depth: f64) -> (usize, Vector<N>) {
    let (mut r, mut u) = (0.0, Vector::zeros());
    let mut count = 0;
    while count + 1 < knots.len() && knots[count].r <= depth {
        (r, u) = (knots[count].r, knots[count].u.into());
        count += 1;
    }
    let above = &knots[count];
    let part = (depth - r) / (above.r - r);
    (count, u * (1.0 - part) + Vector::from(above.u) * part)
}

/// What the dead dissipate, over the old T: an element of limit R dies when the share R / depth of the step is done, with
/// v = u + d R / depth, and slips |v| in the share |v| / c before, c = d.v/|v| + depth: depth/2 int v.(v/c) k dR. `curve` is the
/// backbone before, `died` and `cut` what [`cut`] gave.
#[cold]
fn dissipation_of_dead<B: Backbone, const N: usize>(
    curve: &Over<'_, B>,
    knots: &Knots<N>,
    (died, cut): (usize, Vector<N>),
    depth: f64,
    d: &Vector<N>,
) -> f64 {
    let mut below = (0.0, Vector::zeros(), Vector::zeros(), Values::default());
    let mut sum = 0.0;
    let mut to = |r: f64, v: Vector<N>| {
        let length = v.norm();
        let speed = if length > 0.0 {
            v.dot(d) / length + depth
        } else {
            depth
        };
        // No element slips for longer than the step.
        let shared = v / speed.max(length).max(f64::MIN_POSITIVE);
        let at = curve.at(r);
        let (r0, v0, shared0, at0) = below;
        if r > r0 {
            let (slope, slope_shared) = ((v - v0) / (r - r0), (shared - shared0) / (r - r0));
            sum += slope.dot(&(shared * at.f - shared0 * at0.f))
                + slope_shared.dot(&(v * at.f - v0 * at0.f))
                - 2.0 * slope.dot(&slope_shared) * (at.integral - at0.integral);
        }
        below = (r, v, shared, at);
    };
    let mut previous = (0.0, Vector::zeros());
    let cut = Knot {
        r: depth,
        u: cut.into(),
    };
    for knot in knots[..died].iter().chain([&cut]) {
        let v = Vector::from(knot.u) + d * (knot.r / depth);
        // Where |v| is least its direction changes fast.
        let rise = v - previous.1;
        let (along, squared) = (-previous.1.dot(&rise), rise.norm_squared());
        if along > 0.0 && along < squared {
            let part = along / squared;
            to(
                previous.0 + part * (knot.r - previous.0),
                previous.1 + rise * part,
            );
        }
        to(knot.r, v);
        previous = (knot.r, v);
    }
    let (_, v, shared, at) = below;
    (sum - v.dot(&shared) * at.slope) * depth / 2.0
}

/// Drops the knot, from number `first` on and below the last, that changes the traction least; gives that part of T:
/// |off the chord| |kink of f|.
#[cold]
fn forget_least<B: Backbone, const N: usize>(
    curve: &Over<'_, B>,
    knots: &mut Knots<N>,
    first: usize,
) -> f64 {
    let (mut least, mut index) = (f64::INFINITY, first);
    let mut below = (
        Knot {
            r: 0.0,
            u: [0.0; N],
        },
        0.0,
    );
    for k in 0..knots.len() - 1 {
        let (b, c) = (knots[k], knots[k + 1]);
        let (a, fa) = below;
        let [fb, fc] = [b.r, c.r].map(|r| curve.at(r).f);
        let (low, high) = (b.r - a.r, c.r - b.r);
        let kink = (fb - fa) / low - (fc - fb) / high;
        let part = low / (low + high);
        let off = Vector::from(b.u) - Vector::from(a.u) * (1.0 - part) - Vector::from(c.u) * part;
        let importance = off.norm() * kink.abs();
        if k >= first && importance < least {
            (least, index) = (importance, k);
        }
        below = (b, fb);
    }
    knots.remove(index);
    least
}
