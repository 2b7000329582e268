//! One direction: Masing's rules with a limit that changes.
//!
//! The curve is 1-Lipschitz. So everything below the outermost element that slips, slips too, straight up to one front;
//! above it stand the reversals that are still open.

use super::{
    AT_APEX, Increment, NEGLIGIBLE, ON_CONE, Outcome, cut, dissipation_of_dead, forget_least,
};
use crate::backbone::{Backbone, Values};
use crate::state::{Contact, Knot, Knots};

/// An element slips when it is outside its limit by this part of it, and rounding cannot tell.
const OUTSIDE: f64 = 4e-16;
/// An element this close to its limit slips when it is pushed outwards.
const AT_LIMIT: f64 = 1e-14;

/// A place on the curve at the end with the backbone there.
#[derive(Default)]
struct Place {
    r: f64,
    u: f64,
    at: Values,
}

/// Moves the curve `start`, which is used up, by an increment; `end`, empty before, gets the curve at the end.
#[inline(always)]
pub fn step<B: Backbone>(
    backbone: &B,
    start: &mut Knots<1>,
    increment: &Increment<1>,
    end: &mut Knots<1>,
    outcome: &mut Outcome<1>,
) {
    let (d, critical) = (increment.slip[0], increment.critical);
    let growth = critical - increment.before;
    let curve = backbone.over(critical);
    let initial_slope = curve.initial_slope();

    // 0. A new branch with no room for it: the least important knot goes before the step, so that one step and many agree.
    if start.len() == increment.room
        && start[0].u[0] * d < 0.0
        && start[0].u[0].abs() >= start[0].r * (1.0 - ON_CONE)
    {
        outcome.forgotten = forget_least(&backbone.over(increment.before), start, 0);
    }

    // 1. Trial: every element moves by d, every limit by the growth.
    let (mut apex, mut dead, mut shift) = (d, 0.0, d);
    if growth != 0.0 {
        (apex, dead) = grow(backbone, start, increment, growth);
        shift = 0.0;
    }
    let trial = &start[..];
    let last = trial.len() - 1;
    let deflection = |knot: &Knot<1>| knot.u[0] + shift;

    // 2. What slips, in direction s: all up to the outermost knot outside the cone.
    let s = 1f64.copysign(if growth > 0.0 { d } else { apex });
    let excess = |knot: &Knot<1>| s * deflection(knot) - knot.r;
    let speed = s * d - growth;
    let reach = if speed > 0.0 { -AT_LIMIT } else { OUTSIDE };
    let slipping = trial
        .iter()
        .rposition(|knot| excess(knot) > reach * knot.r)
        .map_or(0, |index| index + 1);

    // 3. Dissipation of what slips by e(R), over T; e is linear between the knots of the trial curve.
    let mut work = Work {
        excess: apex.abs(),
        ..Work::default()
    };
    if growth != 0.0 {
        work.squares = apex * apex * initial_slope;
    }
    for knot in &trial[..slipping.min(last)] {
        work.up_to(knot.r, excess(knot).max(0.0), curve.at(knot.r), growth);
    }
    if slipping > last {
        work.up_to(critical, excess(&trial[last]).max(0.0), curve.end(), growth);
        outcome.traction[0] = s;
        outcome.by_growth[0] = s * initial_slope;
        outcome.stored = critical - curve.end().integral;
        outcome.dissipated = work.done(speed, growth) + work.excess + dead;
        outcome.contact = Contact::GrossSlip;
        end.push(Knot {
            r: critical,
            u: [s * critical],
        });
        return;
    }

    // 4. The front: e falls to zero along a straight line, and everything below it is on the cone.
    let mut below = Place::default();
    let mut fronts = 0;
    if work.excess > 0.0 || slipping > 0 {
        let above = &trial[slipping];
        let part = work.excess / (work.excess - excess(above).min(0.0));
        let r = (work.r + (above.r - work.r) * part).min(above.r);
        let at = curve.at(r);
        work.up_to(r, 0.0, at, growth);
        below = Place { r, u: s * r, at };
        outcome.traction[0] = s * at.f;
        outcome.stored = r * at.f - at.integral;
        outcome.by_slip[0] = at.slope;
        outcome.by_growth[0] = s * (initial_slope - at.slope);
        outcome.contact = Contact::of(false, at.slope, initial_slope);
        if r > AT_APEX * critical {
            end.push(Knot { r, u: [below.u] });
            fronts = 1;
        }
    } else {
        outcome.contact = Contact::Stick;
        outcome.by_slip[0] = initial_slope;
        if growth > 0.0 {
            // Nothing slips: the born elements share d in equal parts of the growth.
            outcome.by_slip[0] = curve.at(growth).f / growth;
            outcome.by_growth[0] = d / growth * (initial_slope - outcome.by_slip[0]);
        }
    }
    outcome.dissipated = work.done(speed, growth) + dead;

    // 5. What sticks has moved with d: Eqs. (1) and (2), segment by segment. A knot that does not matter any more goes.
    for (index, knot) in trial.iter().enumerate().skip(slipping) {
        let (r, u) = (knot.r, deflection(knot));
        let low = r - below.r;
        if low <= AT_APEX * critical {
            if index == last {
                // The front is on the last knot.
                end.pop();
                end.push(Knot { r, u: [u] });
            }
            continue;
        }
        let at = if index == last {
            curve.end()
        } else {
            curve.at(r)
        };
        if index < last {
            let above = &trial[index + 1];
            let high = above.r - r;
            let off = ((u - below.u) * high - (deflection(above) - u) * low).abs();
            // Its distance from the chord alone nearly always tells that it matters.
            if off <= 1e-9 * low * high {
                let kink = ((at.f - below.at.f) * high - (curve.at(above.r).f - at.f) * low).abs();
                if off * kink < NEGLIGIBLE * low * high * (low + high) {
                    continue;
                }
            }
        }
        let m = (u - below.u) / low;
        outcome.traction[0] += m * (at.f - below.at.f);
        outcome.stored +=
            m * (at.f * u - below.at.f * below.u) - m * m * (at.integral - below.at.integral);
        below = Place { r, u, at };
        end.push(Knot { r, u: [u] });
    }

    // 6. When they are too many the least important goes, the front never.
    while end.len() > increment.room {
        outcome.forgotten = outcome.forgotten.max(forget_least(&curve, end, fronts));
    }
}

/// The trial curve of a cone that grows, in place of the one before; gives its apex and the dissipation of what dies.
#[inline(never)]
fn grow<B: Backbone>(
    backbone: &B,
    knots: &mut Knots<1>,
    increment: &Increment<1>,
    growth: f64,
) -> (f64, f64) {
    let d = increment.slip[0];
    let (mut apex, mut dead) = (0.0, 0.0);
    if growth < 0.0 {
        let died = cut(knots, -growth);
        let curve = backbone.over(increment.before);
        dead = increment.limit_ratio
            * dissipation_of_dead(&curve, knots, died, -growth, &increment.slip);
        knots.drain(..died.0);
        apex = died.1[0] + d;
    }
    for knot in knots.iter_mut() {
        knot.r += growth;
        knot.u[0] += d;
    }
    if growth > 0.0 {
        // The old apex: below it, the elements born on the way lie on a straight line.
        knots.insert(0, Knot { r: growth, u: [d] });
    }
    // The end of the curve is exact.
    if let Some(last) = knots.last_mut() {
        last.r = increment.critical;
    }
    (apex, dead)
}

/// The work of slip: D / T = sum (e_a - e_b)/h (L_b - L_a) - growth/2 int e theta k dR, where theta = e / (s d - growth) is the
/// share of the step in which an element slips (its limit grows meanwhile) and k = -f'' the stiffness of the elements.
#[derive(Default)]
struct Work {
    /// The place reached, and e there.
    r: f64,
    excess: f64,
    at: Values,
    /// The first sum.
    sum: f64,
    /// int e^2 k dR.
    squares: f64,
}

impl Work {
    /// Goes on to the place R where the excess is e.
    #[inline(always)]
    fn up_to(&mut self, r: f64, e: f64, at: Values, growth: f64) {
        if r > self.r {
            let fall = (self.excess - e) / (r - self.r);
            self.sum += fall * (at.loss - self.at.loss);
            if growth != 0.0 {
                self.squares -= 2.0 * fall * (e * at.f - self.excess * self.at.f)
                    + 2.0 * fall * fall * (at.integral - self.at.integral);
            }
        }
        (self.r, self.excess, self.at) = (r, e, at);
    }

    /// `speed`: how fast an element leaves its limit in the whole step, s d - growth.
    #[inline(always)]
    fn done(&self, speed: f64, growth: f64) -> f64 {
        if growth == 0.0 || speed <= 0.0 {
            return self.sum;
        }
        self.sum - 0.5 * growth * self.squares / speed
    }
}
