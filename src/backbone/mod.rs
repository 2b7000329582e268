//! Backbone curves: the traction of first loading, normalised.
//!
//! A backbone f(r) rises from f(0) = 0 to f(1) = 1 and is concave; slip is counted in critical slips and
//! traction in mu p. Seen as parallel slip elements (Iwan 1966), -f'' is the stiffness density of the
//! elements whose slip limit is r, and a jump of f' at r = 1 is one more element there.
//!
//! A new backbone is one new file that implements [`Backbone`], an entry in [`Choice`] (the compiler then names the
//! places that choose), and the checks of its properties.

mod power_law;
mod segalman;

pub use power_law::PowerLaw;
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
    /// G = 2 F - r f: a closed cycle of amplitude r <= 1 dissipates 4 G(r).
    pub loss: f64,
}

/// What the memory curve needs to know of a backbone.
pub trait Backbone {
    /// The backbone and its integrals at r in [0, 1].
    fn at(&self, r: f64) -> Values;

    /// f'(0), the sticking stiffness.
    fn initial_slope(&self) -> f64;

    /// Knot k = 0..=count of the base grid: equal parts of the integral of sqrt(-f''), which spreads
    /// the interpolation error of a curved slip path evenly. 0 for k = 0 and 1 for k = count.
    fn grid(&self, k: usize, count: usize) -> f64;

    /// A quarter of the energy that a closed cycle of amplitude a dissipates: G(a), and beyond gross slip a straight line.
    fn cycle_loss(&self, a: f64) -> f64 {
        if a <= 1.0 {
            self.at(a).loss
        } else {
            a - 2.0 * (1.0 - self.at(1.0).integral)
        }
    }
}

/// The backbone that the properties name.
#[derive(Clone, Debug)]
pub enum Choice {
    /// The paper's power law (PROPS 10 = 0).
    PowerLaw(PowerLaw),
    /// Segalman's four-parameter Iwan model (PROPS 10 = 1).
    Segalman(Segalman),
}
