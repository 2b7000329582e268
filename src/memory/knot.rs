//! Knots of the curve, the segments between them, and the fronts of slip.

use super::{ALONG_BOUNDARY, SHORT, Vector};
use crate::backbone::Values;

/// Narrower than any segment that matters, and wide enough to divide the longest slip.
const NARROW: f64 = 1e-100;

/// A knot of the curve at the end of a step, or at its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot<const N: usize> {
    // In this order: with e next to f compilers load the two as one, which has to wait until both have been stored.
    /// Slip limit.
    pub(super) r: f64,
    /// The backbone at r, its slope and its integral.
    pub(super) f: f64,
    pub(super) slope: f64,
    pub(super) integral: f64,
    /// Elastic deflection.
    pub(super) e: Vector<N>,
    /// The base knot next above (for a floating knot), or the knot itself.
    pub(super) above: u32,
    pub(super) is_front: bool,
}

impl<const N: usize> Knot<N> {
    #[inline(always)]
    pub(super) fn new(r: f64, e: Vector<N>, values: &Values, above: usize, is_front: bool) -> Self {
        Knot {
            r,
            e,
            f: values.f,
            slope: values.slope,
            integral: values.integral,
            above: above as u32,
            is_front,
        }
    }
}

/// A knot of the trial curve.
#[derive(Clone, Copy)]
pub(super) struct Trial<const N: usize> {
    pub(super) r: f64,
    pub(super) e: Vector<N>,
    /// G(r)
    pub(super) loss: f64,
    pub(super) slips: bool,
    /// How far it is beyond its limit.
    pub(super) excess: f64,
}

impl<const N: usize> Trial<N> {
    #[inline(always)]
    pub(super) fn new(r: f64, e: Vector<N>, loss: f64, slips: bool) -> Self {
        let excess = if slips {
            (super::length(&e) - r).max(0.0)
        } else {
            0.0
        };
        Trial {
            r,
            e,
            loss,
            slips,
            excess,
        }
    }

    /// Energy dissipated between two knots: the integral of -f'' r times the excess, by parts.
    #[inline(always)]
    pub(super) fn dissipated(&self, above: &Self) -> f64 {
        let width = above.r - self.r;
        // The loss, which is known last, comes last. Not by zero in either case: compilers divide first, and some hosts
        // trap that.
        let slope = (self.excess - above.excess) / width.max(NARROW);
        if width > 0.0 {
            slope * (above.loss - self.loss)
        } else {
            0.0
        }
    }
}

/// Where slipping elements and sticking ones meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Front<const N: usize> {
    pub(super) r: f64,
    /// Direction of the deflection.
    pub(super) n: Vector<N>,
    /// The elements above it stick (and those below slip), or the other way round.
    pub(super) stick_above: bool,
    /// 1 / (1 - n.m), how fast the front moves with the increment (two directions).
    pub(super) gain: f64,
    /// Slope m of the trial curve (two directions).
    pub(super) inner: Vector<N>,
}

/// The front on the trial segment from a slipping knot to a sticking one, or back: where |trial| = r. None where the
/// segment lies along the yield boundary and the front moves at any speed.
#[inline(always)]
pub(super) fn front<const N: usize>(
    below: &Trial<N>,
    above: &Trial<N>,
    d: &Vector<N>,
) -> Option<Front<N>> {
    let width = above.r - below.r;
    let rise = above.e - below.e;
    if N == 1 {
        // What slips is deflected along the increment, and the excess falls linearly.
        let n = d.map(|d| 1f64.copysign(d));
        let excess = (n.dot(&below.e) - below.r).max(0.0);
        let closing = (excess + (above.r - n.dot(&above.e))).max(f64::MIN_POSITIVE);
        let front = Front {
            r: below.r + width * (excess / closing),
            n,
            stick_above: below.slips,
            // Nobody asks for these.
            gain: 1.0,
            inner: n,
        };
        return (closing > ALONG_BOUNDARY * width).then_some(front);
    }
    // s from 0 to 1 along the segment: what is outside, |trial|^2 - r^2 or its opposite, is a s^2 + 2 b s + c and falls from
    // c >= 0 to zero. The root without cancellation.
    let sign = if below.slips { 1.0 } else { -1.0 };
    let a = sign * (rise.norm_squared() - width * width);
    let b = sign * (below.e.dot(&rise) - below.r * width);
    let c = (sign * (below.e.norm_squared() - below.r * below.r)).max(0.0);
    let root = (b * b - a * c).max(0.0).sqrt();
    let (part, whole) = if b > 0.0 {
        (b + root, -a)
    } else {
        (c, root - b)
    };
    // Rounding alone leads out of the segment, or leaves nothing to divide by where it lies along the boundary.
    let whole = whole.max(f64::MIN_POSITIVE);
    let s = part.min(whole) / whole;
    let r = below.r + width * s;
    let trial = below.e + rise * s;
    // At the root the quadratic falls with 2 root, which is 2 r (width - n.rise) or its opposite.
    let along = ALONG_BOUNDARY * width * r;
    let front = Front {
        r,
        n: trial / trial.norm().max(f64::MIN_POSITIVE),
        stick_above: below.slips,
        gain: sign * width * r / root.max(along),
        inner: rise / width,
    };
    (root > along).then_some(front)
}

/// A segment between two knots.
#[derive(Clone, Copy)]
pub(super) struct Segment<const N: usize> {
    /// Secant of the backbone.
    pub(super) secant: f64,
    /// Slope of the deflection.
    pub(super) slope: Vector<N>,
}

impl<const N: usize> Segment<N> {
    #[inline(always)]
    pub(super) fn between(a: &Knot<N>, b: &Knot<N>) -> Self {
        let width = b.r - a.r;
        let inverse_width = 1.0 / width;
        let secant = (b.f - a.f) * inverse_width;
        Segment {
            secant: if width < SHORT * b.r {
                short_secant(b.r, 0.5 * (a.slope + b.slope), secant)
            } else {
                secant
            },
            slope: (b.e - a.e) * inverse_width,
        }
    }

    /// Above r = 1 there is nothing.
    pub(super) fn beyond() -> Self {
        Segment {
            secant: 0.0,
            slope: Vector::zeros(),
        }
    }
}

/// The secant of a short segment that ends at r, where its own quotient loses digits.
#[cold]
fn short_secant(r: f64, mean_slope: f64, secant: f64) -> f64 {
    // At r = 1 the slope may jump or be steep: there the quotient is better.
    if r < 1.0 { mean_slope } else { secant }
}

/// How much the traction changes when a floating knot is taken out, as the quotient of two numbers: its distance from
/// the chord of its neighbours, times the kink of the backbone there.
#[inline(always)]
pub(super) fn weight<const N: usize>(
    below: &Knot<N>,
    knot: &Knot<N>,
    above: &Knot<N>,
) -> (f64, f64) {
    let (low, high) = (knot.r - below.r, above.r - knot.r);
    let off = (knot.e - below.e) * high - (above.e - knot.e) * low;
    let kink = (knot.f - below.f) * high - (above.f - knot.f) * low;
    (super::length(&off) * kink.abs(), low * high * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slipping knot at its limit below one that is this much inside its own: the segment between them meets the yield boundary,
    /// or lies along it.
    fn beside_the_boundary<const N: usize>(n: Vector<N>, inside: f64) -> Option<Front<N>> {
        let below = Trial::new(0.3, n * 0.3, 0.0, true);
        let above = Trial::new(0.6, n * (0.6 - inside), 0.0, false);
        front(&below, &above, &(n * 1e-3))
    }

    #[test]
    fn a_segment_along_the_yield_boundary_has_no_front() {
        for (inside, is_there) in [(1e-5, true), (1e-10, false), (0.0, false)] {
            let line = beside_the_boundary(Vector::from([-1.0]), inside);
            let plane = beside_the_boundary(Vector::from([0.6, 0.8]), inside);
            assert_eq!((line.is_some(), plane.is_some()), (is_there, is_there));
        }
    }
}
