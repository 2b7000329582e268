//! Backbone curves: the traction of first loading, normalised.
//!
//! A backbone f(r) rises from f(0) = 0 to f(1) = 1 and is concave; slip is counted in critical slips and
//! traction in limit tractions. Seen as parallel slip elements (Iwan 1966), -f'' is the stiffness density of the
//! elements whose slip limit is r, and a jump of f' at r = 1 is one more element there.
//!
//! A new backbone is one new file that implements [`Backbone`], an entry in [`Choice`] (the compiler then names the
//! places that choose), and the checks of its properties.

mod power_law;
mod segalman;

pub use power_law::{FiveHalves, PowerLaw};
pub use segalman::Segalman;

/// A backbone and its integrals at one r.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// f, the normalised traction of first loading.
    pub f: f64,
    /// f', at r = 1 the limit from the left.
    pub slope: f64,
    /// F, the integral of f from 0 to r.
    pub integral: f64,
    /// L = 2 F - r f: a closed cycle of amplitude r <= 1 dissipates 4 L(r). L' = f - r f'.
    pub loss: f64,
}

/// The largest r below the end.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// What the memory curve needs to know of a backbone.
pub trait Backbone {
    /// The backbone and its integrals at r in [0, 1].
    fn at(&self, r: f64) -> Values;

    /// The same at r = 1.
    fn end(&self) -> Values;

    /// f'(0), the sticking stiffness.
    fn initial_slope(&self) -> f64;

    /// The backbone over slip limits R = r G, for a curve that ends at G.
    #[inline(always)]
    fn over(&self, critical: f64) -> Over<'_, Self>
    where
        Self: Sized,
    {
        Over {
            backbone: self,
            critical,
            inverse: 1.0 / critical,
        }
    }

    /// A quarter of the energy that a closed cycle of amplitude a dissipates: L(a), and beyond gross slip a straight line.
    fn cycle_loss(&self, a: f64) -> f64 {
        if a <= 1.0 {
            self.at(a).loss
        } else {
            a - 2.0 * (1.0 - self.end().integral)
        }
    }
}

/// A backbone over slip limits R, lengths, up to the critical slip G: f and L' are numbers, f' is per length, F and L
/// are lengths.
#[derive(Clone, Copy, Debug)]
pub struct Over<'a, B> {
    backbone: &'a B,
    /// G.
    critical: f64,
    inverse: f64,
}

impl<B: Backbone> Over<'_, B> {
    /// f(R/G), df/dR, and the integrals over R.
    #[inline(always)]
    pub fn at(&self, limit: f64) -> Values {
        if limit >= self.critical {
            // Not left to the rounding of the quotient: f' may fall to 0 within it.
            return self.end();
        }
        self.scaled(self.backbone.at((limit * self.inverse).min(BELOW_ONE)))
    }

    /// The same at R = G.
    #[inline(always)]
    pub fn end(&self) -> Values {
        self.scaled(self.backbone.end())
    }

    #[inline(always)]
    fn scaled(&self, at: Values) -> Values {
        Values {
            f: at.f,
            slope: at.slope * self.inverse,
            integral: at.integral * self.critical,
            loss: at.loss * self.critical,
        }
    }

    /// df/dR at R = 0.
    #[inline(always)]
    pub fn initial_slope(&self) -> f64 {
        self.backbone.initial_slope() * self.inverse
    }
}

/// The backbone that the properties name.
#[derive(Clone, Debug)]
pub enum Choice {
    /// The power law with the paper's exponent, 5/2 (PROPS 10 = 0).
    FiveHalves(FiveHalves),
    /// The power law with another exponent (PROPS 10 = 0).
    PowerLaw(PowerLaw),
    /// Segalman's four-parameter Iwan model (PROPS 10 = 1).
    Segalman(Segalman),
}

impl Choice {
    /// f'(0), the sticking stiffness.
    pub fn initial_slope(&self) -> f64 {
        match self {
            Choice::FiveHalves(curve) => curve.initial_slope(),
            Choice::PowerLaw(curve) => curve.initial_slope(),
            Choice::Segalman(curve) => curve.initial_slope(),
        }
    }

    /// A quarter of the energy that a closed cycle of amplitude a dissipates, see [`Backbone::cycle_loss`].
    pub fn cycle_loss(&self, a: f64) -> f64 {
        match self {
            Choice::FiveHalves(curve) => curve.cycle_loss(a),
            Choice::PowerLaw(curve) => curve.cycle_loss(a),
            Choice::Segalman(curve) => curve.cycle_loss(a),
        }
    }
}
