//! The limit traction T and what changes it: pressure, cohesion, a cap, run-in, the caller's factor.
//!
//! T = min(c + mu p, tau_max) while closed (p > 0), with
//! mu = factor [mu_late + (mu_0 - mu_late) exp(-slip length / slip_late)].

use crate::properties::{Properties, RunIn};

/// What of the properties the limit depends on.
#[derive(Clone, Debug)]
pub struct Limit {
    mu: f64,
    cohesion: f64,
    cap: f64,
    run_in: Option<RunIn>,
    /// T0: the limit at the reference pressure, factor and run-in 1.
    reference: f64,
}

/// The limit traction and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traction {
    /// T, traction.
    pub limit: f64,
    /// T' = dT/dp: mu below the cap, 0 at and above it.
    pub slope: f64,
}

impl Limit {
    /// The limit that these properties describe.
    pub fn new(properties: &Properties) -> Self {
        let mut limit = Limit {
            mu: properties.mu,
            cohesion: properties.cohesion,
            cap: properties.tau_max,
            run_in: properties.run_in,
            reference: 0.0,
        };
        limit.reference = limit.of(limit.mu, properties.reference_pressure).limit;
        limit
    }

    /// T0, traction.
    pub fn reference(&self) -> f64 {
        self.reference
    }

    /// T at pressure p, the caller's factor on mu, and the slip length at the start of the increment.
    #[inline(always)]
    pub fn at(&self, pressure: f64, factor: f64, slip_length: f64) -> Traction {
        let mu = match self.run_in {
            None => self.mu,
            Some(late) => late.mu + (self.mu - late.mu) * (-slip_length / late.length).exp(),
        };
        self.of(factor * mu, pressure)
    }

    #[inline(always)]
    fn of(&self, mu: f64, pressure: f64) -> Traction {
        let limit = self.cohesion + mu * pressure;
        if limit < self.cap {
            Traction { limit, slope: mu }
        } else {
            Traction {
                limit: self.cap,
                slope: 0.0,
            }
        }
    }
}
