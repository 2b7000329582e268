//! One direction: Masing's rules with a limit that changes.
//!
//! The curve is 1-Lipschitz. So everything below the outermost element that slips, slips too, straight up to one front;
//! above it stand the reversals that are still open.

use super::{AT_APEX, Increment, NEGLIGIBLE, ON_CONE, Outcome};
use crate::backbone::{Backbone, Over, Values};
use crate::memory::{Matrix, Vector};
use crate::state::{Contact, Knot, Knots};

/// An element slips when it is outside its limit by this part of it, and rounding cannot tell.
const OUTSIDE: f64 = 4e-16;
/// An element this close to its limit slips when it is pushed outwards.
const AT_LIMIT: f64 = 1e-14;

/// A place on the curve with the backbone there.
#[derive(Clone, Copy, Default)]
struct Place {
    r: f64,
    u: f64,
    at: Values,
}

/// Moves the curve `start` by an increment; `end`, empty before, gets the curve at the end.
#[inline(always)]
pub fn step<B: Backbone>(
    backbone: &B,
    start: &mut Knots<1>,
    increment: &Increment<1>,
    end: &mut Knots<1>,
) -> Outcome<1> {
    let (d, critical) = (increment.slip[0], increment.critical);
    let growth = critical - increment.before;
    let curve = backbone.over(critical);
    let initial_slope = curve.initial_slope();
    let mut forgotten: f64 = 0.0;

    // 0. A new branch with no room for it: the least important knot goes before the step, so that one step and many agree.
    if start.len() == increment.room
        && start[0].u[0] * d < 0.0
        && start[0].u[0].abs() >= start[0].r * (1.0 - ON_CONE)
    {
        forgotten = forget_least(&backbone.over(increment.before), start, 0);
    }

    // 1. Trial: every element moves by d, every limit by the growth.
    let mut trial = Knots::<1>::new();
    let (mut apex, mut dead, mut first) = (d, 0.0, 0);
    if growth > 0.0 {
        // The old apex: below it, the elements born on the way lie on a straight line.
        apex = 0.0;
        trial.push(Knot { r: growth, u: [d] });
    } else if growth < 0.0 {
        let died = Died::new(start, -growth);
        (apex, first) = (died.cut + d, died.count);
        dead = died.dissipation(&backbone.over(increment.before), start, d) * increment.limit_ratio;
    }
    for knot in &start[first..] {
        let (r, below) = (knot.r + growth, trial.last().map_or(0.0, |knot| knot.r));
        if r > below {
            trial.push(Knot { r, u: [knot.u[0] + d] });
        }
    }
    match trial.last_mut() {
        Some(last) => last.r = critical,
        None => trial.push(Knot { r: critical, u: [apex] }),
    }

    // 2. What slips, in direction s: all up to the outermost knot outside the cone.
    let s = 1f64.copysign(if growth > 0.0 { d } else { apex });
    let excess = |knot: &Knot<1>| s * knot.u[0] - knot.r;
    let outwards = s * d > growth;
    let slips = |knot: &Knot<1>| {
        let excess = excess(knot);
        excess > OUTSIDE * knot.r || (outwards && excess >= -AT_LIMIT * knot.r)
    };
    let slipping = trial.iter().rposition(slips).map_or(0, |index| index + 1);
    let over = if growth > 0.0 { 0.0 } else { apex.abs() };

    // 3. Dissipation of what slips by e(R), over T; e is linear between the knots of the trial curve.
    let mut work = Work::new(over, growth);
    for knot in &trial[..slipping] {
        work.up_to(knot.r, excess(knot).max(0.0), curve.at(knot.r));
    }

    // 4. The front: e falls to zero along a straight line, and everything below it is on the cone.
    let mut outcome = Outcome {
        traction: Vector::<1>::zeros(),
        by_slip: Matrix::<1>::zeros(),
        by_growth: Vector::<1>::zeros(),
        stored: 0.0,
        dissipated: 0.0,
        contact: Contact::Stick,
        forgotten,
    };
    let mut last = Place::default();
    if slipping == trial.len() {
        let at = curve.at(critical);
        outcome.traction[0] = s;
        outcome.by_growth[0] = s * initial_slope;
        outcome.stored = critical - at.integral;
        outcome.dissipated = work.finish(initial_slope, s * d - growth) + work.excess + dead;
        outcome.contact = Contact::GrossSlip;
        end.push(Knot { r: critical, u: [s * critical] });
        return outcome;
    }
    if slipping > 0 || over > 0.0 {
        let above = &trial[slipping];
        let part = work.excess / (work.excess - excess(above));
        let r = (work.r + (above.r - work.r) * part).min(above.r);
        let at = curve.at(r);
        work.up_to(r, 0.0, at);
        last = Place { r, u: s * r, at };
        outcome.traction[0] = s * at.f;
        outcome.stored = r * at.f - at.integral;
        outcome.by_slip[(0, 0)] = at.slope;
        outcome.by_growth[0] = s * (initial_slope - at.slope);
        outcome.contact = Contact::of(false, at.slope, initial_slope);
        if r > AT_APEX * critical {
            end.push(Knot { r, u: [last.u] });
        }
    } else if growth > 0.0 {
        // Nothing slips: the born elements share d in equal parts of the growth.
        let stiffness = curve.at(growth).f / growth;
        outcome.by_slip[(0, 0)] = stiffness;
        outcome.by_growth[0] = d / growth * (initial_slope - stiffness);
    } else {
        outcome.by_slip[(0, 0)] = initial_slope;
    }
    outcome.dissipated = work.finish(initial_slope, s * d - growth) + dead;

    // 5. What sticks has moved with d: Eqs. (1) and (2), segment by segment. A knot that does not matter any more goes.
    for index in slipping..trial.len() {
        let knot = &trial[index];
        let (r, u) = (knot.r, knot.u[0]);
        let at = curve.at(r);
        if let Some(above) = trial.get(index + 1) {
            let (low, high) = (r - last.r, above.r - r);
            let off = ((u - last.u) * high - (above.u[0] - u) * low).abs();
            // Its distance from the chord alone nearly always tells that it matters.
            if low <= AT_APEX * critical {
                continue;
            }
            if off <= 1e-9 * low * high {
                let kink = ((at.f - last.at.f) * high - (curve.at(above.r).f - at.f) * low).abs();
                if off * kink < NEGLIGIBLE * low * high * (low + high) {
                    continue;
                }
            }
        } else if r - last.r <= AT_APEX * critical {
            // The front is on the last knot.
            end.pop();
            end.push(*knot);
            break;
        }
        let m = (u - last.u) / (r - last.r);
        outcome.traction[0] += m * (at.f - last.at.f);
        outcome.stored += m * (at.f * u - last.at.f * last.u) - m * m * (at.integral - last.at.integral);
        last = Place { r, u, at };
        end.push(*knot);
    }

    // 6. When they are too many the least important goes, the front never.
    let kept = usize::from(slipping > 0 || over > 0.0);
    while end.len() > increment.room {
        outcome.forgotten = outcome.forgotten.max(forget_least(&curve, end, kept));
    }
    outcome
}

/// The work of slip: D / T = sum (e_a - e_b)/h (L_b - L_a) - growth/2 int e theta k dR, where theta = e / (s d - growth) is the
/// share of the step in which an element slips (its limit grows meanwhile) and k = -f'' the stiffness of the elements.
struct Work {
    growth: f64,
    r: f64,
    excess: f64,
    at: Values,
    dissipated: f64,
    /// int e^2 k dR but for its end at the apex.
    squares: f64,
    at_apex: f64,
}

impl Work {
    /// `excess`: e at the apex.
    #[inline(always)]
    fn new(excess: f64, growth: f64) -> Self {
        Work {
            growth,
            r: 0.0,
            excess,
            at: Values::default(),
            dissipated: 0.0,
            squares: 0.0,
            at_apex: excess,
        }
    }

    /// Goes on to the place R where the excess is e.
    #[inline(always)]
    fn up_to(&mut self, r: f64, e: f64, at: Values) {
        if r > self.r {
            let fall = (self.excess - e) / (r - self.r);
            self.dissipated += fall * (at.loss - self.at.loss);
            if self.growth != 0.0 {
                self.squares -= 2.0 * fall * (e * at.f - self.excess * self.at.f)
                    + 2.0 * fall * fall * (at.integral - self.at.integral);
            }
        }
        (self.r, self.excess, self.at) = (r, e, at);
    }

    /// `speed`: how fast an element leaves its limit in the whole step, s d - growth.
    #[inline(always)]
    fn finish(&self, initial_slope: f64, speed: f64) -> f64 {
        if self.growth == 0.0 || speed <= 0.0 {
            return self.dissipated;
        }
        let squares = self.squares + self.at_apex * self.at_apex * initial_slope;
        self.dissipated - self.growth / 2.0 * squares / speed
    }
}

/// The elements that die at the apex when the cone shrinks.
struct Died {
    /// How far the apex moves into the old curve, length.
    depth: f64,
    /// How many old knots die.
    count: usize,
    /// The old curve's deflection at that depth.
    cut: f64,
}

impl Died {
    fn new(start: &Knots<1>, depth: f64) -> Self {
        let mut below = Knot { r: 0.0, u: [0.0] };
        let mut count = 0;
        while count + 1 < start.len() && start[count].r <= depth {
            below = start[count];
            count += 1;
        }
        let above = start[count];
        let part = (depth - below.r) / (above.r - below.r);
        let cut = below.u[0] + part * (above.u[0] - below.u[0]);
        Died { depth, count, cut }
    }

    /// What they dissipate, over the old T: an element of limit R dies when the share R / depth of the step is done, with
    /// v = u + d R / depth, and has slipped by |v| in the share theta = v / c, c = s d + depth. The integral over the dead of
    /// depth/2 v theta k dR.
    #[cold]
    fn dissipation<B: Backbone>(&self, curve: &Over<'_, B>, start: &Knots<1>, d: f64) -> f64 {
        let mut sum = 0.0;
        let mut segment = |a: &Place, b: &Place| {
            let speed = d * 1f64.copysign(a.u + b.u) + self.depth;
            if b.r > a.r && speed > 0.0 {
                let m = (b.u - a.u) / (b.r - a.r);
                let ends = b.u * b.u * b.at.slope - a.u * a.u * a.at.slope;
                let middle = 2.0 * m * (b.u * b.at.f - a.u * a.at.f)
                    - 2.0 * m * m * (b.at.integral - a.at.integral);
                sum += (middle - ends) / speed;
            }
        };
        let mut below = Place {
            at: curve.at(0.0),
            ..Place::default()
        };
        let cut = Knot { r: self.depth, u: [self.cut] };
        for knot in start[..self.count].iter().chain([&cut]) {
            let u = knot.u[0] + d * (knot.r / self.depth);
            let place = Place { r: knot.r, u, at: curve.at(knot.r) };
            if below.u * u < 0.0 {
                // Theta changes its sign where v does.
                let r = below.r + below.u / (below.u - u) * (place.r - below.r);
                let zero = Place { r, u: 0.0, at: curve.at(r) };
                segment(&below, &zero);
                segment(&zero, &place);
            } else {
                segment(&below, &place);
            }
            below = place;
        }
        sum * self.depth / 2.0
    }
}

/// Drops the knot, from number `first` on and below the last, that changes the traction least; gives that part of T.
#[cold]
fn forget_least<B: Backbone>(curve: &Over<'_, B>, knots: &mut Knots<1>, first: usize) -> f64 {
    let (mut least, mut index) = (f64::INFINITY, first);
    for k in first..knots.len().saturating_sub(1) {
        let a = k.checked_sub(1).map_or(Knot { r: 0.0, u: [0.0] }, |below| knots[below]);
        let (b, c) = (knots[k], knots[k + 1]);
        let (low, high) = (b.r - a.r, c.r - b.r);
        let [fa, fb, fc] = [a.r, b.r, c.r].map(|r| curve.at(r).f);
        let off = (b.u[0] - a.u[0]) * high - (c.u[0] - b.u[0]) * low;
        let kink = (fb - fa) * high - (fc - fb) * low;
        let importance = (off * kink).abs() / (low * high * (low + high));
        if importance < least {
            (least, index) = (importance, k);
        }
    }
    knots.remove(index);
    least
}
