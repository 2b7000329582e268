//! Knots of the curve, the segments between them, and what they add up to.

use super::grid::Grid;
use super::{ALONG_BOUNDARY, Matrix, SHORT, Vector};
use crate::backbone::Values;

/// How a knot moves with the increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    /// Inside its slip limit: it moves with the increment.
    Sticking,
    /// Beyond its slip limit, brought back onto it.
    Slipping,
    /// The front between slipping elements and the sticking ones above it.
    FrontBelowStick,
    /// The front between sticking elements and the slipping ones above it.
    FrontAboveStick,
}

/// One knot of the curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot<const N: usize> {
    /// Slip limit.
    pub(super) r: f64,
    /// Elastic deflection.
    pub(super) e: Vector<N>,
    pub(super) values: Values,
    /// The base knot next above (for a floating knot), or the knot itself.
    pub(super) above: usize,
    pub(super) motion: Motion,
    /// Knots that slip: r / |trial|. Fronts: 1 / (1 - n.m), how fast the front moves with the increment.
    pub(super) gain: f64,
    /// Fronts: slope m of the trial curve on the side that sticks.
    pub(super) inner: Vector<N>,
}

impl<const N: usize> Knot<N> {
    #[inline]
    pub(super) fn new(r: f64, e: Vector<N>, values: Values, above: usize) -> Self {
        Knot {
            r,
            e,
            values,
            above,
            motion: Motion::Sticking,
            gain: 0.0,
            inner: Vector::zeros(),
        }
    }

    /// Knot 0. It has no limit and no deflection: whenever something slips, it does.
    #[inline]
    pub(super) fn origin(trial: &Vector<N>, grid: &Grid<N>) -> Self {
        let values = Values {
            slope: grid.initial_slope,
            ..Values::default()
        };
        let mut knot = Knot::new(0.0, *trial, values, 0);
        knot.motion = Motion::Slipping;
        knot
    }

    pub(super) fn slips(&self) -> bool {
        self.motion == Motion::Slipping
    }

    pub(super) fn is_front(&self) -> bool {
        matches!(
            self.motion,
            Motion::FrontBelowStick | Motion::FrontAboveStick
        )
    }

    /// How far a trial knot is beyond its limit, if it slips.
    #[inline]
    pub(super) fn excess(&self) -> f64 {
        if self.slips() {
            (self.e.norm() - self.r).max(0.0)
        } else {
            0.0
        }
    }
}

/// Secant of G between two knots.
#[inline]
pub(super) fn loss_secant<const N: usize>(a: &Knot<N>, b: &Knot<N>) -> f64 {
    if b.r > a.r {
        (b.values.loss - a.values.loss) / (b.r - a.r)
    } else {
        0.0
    }
}

/// The front on the trial segment from a slipping knot to a sticking one, or back: where |trial| = r.
///
/// Its gain is 1 / (1 - n.m), large where the segment lies along the yield boundary.
#[inline]
pub(super) fn front<const N: usize>(below: &Knot<N>, above: &Knot<N>) -> Knot<N> {
    let width = above.r - below.r;
    let m = (above.e - below.e) / width;
    // |trial|^2 - r^2 = a u^2 + 2 b u + c with u counted from the knot below.
    let a = m.norm_squared() - 1.0;
    let b = below.e.dot(&m) - below.r;
    let c = below.e.norm_squared() - below.r * below.r;
    // The root where the sign changes the right way, without cancellation; c has the sign of the knot below.
    let u = if below.slips() {
        let c = c.max(0.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        if b > 0.0 {
            -(b + root) / a
        } else if c > 0.0 {
            c / (root - b)
        } else {
            0.0
        }
    } else {
        let c = c.min(0.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        if b > 0.0 {
            -c / (b + root)
        } else {
            (root - b) / a
        }
    };
    // Rounding alone leads out of the segment, or to no number at all where it lies along the boundary.
    let u = if u.is_finite() {
        u.clamp(0.0, width)
    } else {
        width
    };
    let r = below.r + u;
    let trial = below.e + m * u;
    let direction = trial / trial.norm();
    let mut front = Knot::new(r, direction * r, Values::default(), above.above);
    front.inner = m;
    let closing = 1.0 - direction.dot(&m);
    // Along the boundary the front moves at any speed; the number stays finite.
    front.gain = 1.0
        / if closing.abs() < 0.5 * ALONG_BOUNDARY {
            0.5 * ALONG_BOUNDARY
        } else {
            closing
        };
    front
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
    #[inline]
    pub(super) fn between(a: &Knot<N>, b: &Knot<N>) -> Self {
        let width = b.r - a.r;
        let inverse_width = 1.0 / width;
        Segment {
            // At r = 1 the slope may jump or be steep: there the secant itself is better.
            secant: if width < SHORT * b.r && b.r < 1.0 {
                0.5 * (a.values.slope + b.values.slope)
            } else {
                (b.values.f - a.values.f) * inverse_width
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

/// Traction, stored energy and consistent tangent, knot by knot.
///
/// With weights w = secant below - secant above, the traction is the sum of w e. A sticking knot moves with the
/// increment, a slipping one turns on its limit, a front also shifts along r.
pub(super) struct Sums<const N: usize> {
    pub(super) traction: Vector<N>,
    pub(super) stored: f64,
    pub(super) dissipated: f64,
    /// The part of the tangent that is a multiple of the identity, and the rest.
    pub(super) stick: f64,
    pub(super) turn: Matrix<N>,
    /// The same derivative applied to the deflections, which shrink when new pressure arrives unloaded.
    pub(super) remembered: Vector<N>,
}

impl<const N: usize> Sums<N> {
    pub(super) fn new() -> Self {
        Sums {
            traction: Vector::zeros(),
            stored: 0.0,
            dissipated: 0.0,
            stick: 0.0,
            turn: Matrix::zeros(),
            remembered: Vector::zeros(),
        }
    }

    /// Traction and stored energy of a segment, `times` over.
    #[inline]
    pub(super) fn add_segment(
        &mut self,
        a: &Knot<N>,
        b: &Knot<N>,
        segment: &Segment<N>,
        times: f64,
    ) {
        self.traction += (b.e - a.e) * (segment.secant * times);
        let stored = segment.slope.dot(&(b.e * b.values.f - a.e * a.values.f))
            - segment.slope.norm_squared() * (b.values.integral - a.values.integral);
        self.stored += stored * times;
    }

    /// Adds what a knot between two segments gives to the tangent.
    #[inline]
    pub(super) fn add(&mut self, knot: &Knot<N>, lower: &Segment<N>, upper: &Segment<N>) {
        let weight = lower.secant - upper.secant;
        if knot.slips() {
            // Knot 0 has no limit to turn on.
            if knot.r > 0.0 {
                self.add_slipping(&(knot.e / knot.r), weight * knot.gain);
            }
            return;
        }
        self.stick += weight;
        self.remembered += knot.e * weight;
        if knot.is_front() {
            self.add_shift(knot, lower, upper);
        }
    }

    /// A knot that slips in the direction n turns on its limit.
    #[inline]
    pub(super) fn add_slipping(&mut self, n: &Vector<N>, weight: f64) {
        // In one direction there is nowhere to turn.
        if N > 1 {
            self.stick += weight;
            self.turn -= n * (n * weight).transpose();
        }
    }

    /// A front shifts along r.
    #[inline]
    pub(super) fn add_shift(&mut self, front: &Knot<N>, lower: &Segment<N>, upper: &Segment<N>) {
        let (slipping, turn) = if front.motion == Motion::FrontBelowStick {
            (lower.secant, lower.slope - front.inner)
        } else {
            (upper.secant, front.inner - upper.slope)
        };
        let n = front.e / front.r;
        let slowing = front.values.slope - slipping;
        let shift = if N == 1 {
            // How fast the front moves and how far the slopes differ cancel.
            n * slowing
        } else {
            turn * (slowing * front.gain)
        };
        self.turn += shift * n.transpose();
        self.remembered += shift * n.dot(&front.e);
    }
}
