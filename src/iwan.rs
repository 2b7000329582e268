//! The improved four-parameter Iwan model of a joint, and its identification from a measured hysteresis loop.
//!
//! A joint that is driven to the displacement x from the virgin state answers with
//!
//! ```text
//! T(x) = F_s f(x / X_s) + k_alpha x,    f(s) = 1 - (1 - s)^chi for s <= 1, f = 1 beyond,    chi = 5/2 + kappa
//! ```
//!
//! and after that with Masing's branches. In the steady loop of amplitude A the branch that loads is
//!
//! ```text
//! T = k_alpha x - F_s f(A / X_s) + 2 F_s f((A + x) / (2 X_s))
//! ```
//!
//! and the other one its mirror image. With A >= X_s, solved for the power, that is the paper's Eq. (24) in which x stands for
//! half the distance from the reversal and T_max = F_s + k_alpha A.
//!
//! [`Record`] finds the reversals in measured data, [`identify`] the parameters and whether the model describes the loop;
//! [`Record::least_squares`] and [`Record::paper`] are the parameters alone.
//!
//! ```
//! use mepc::iwan::{Direction, Iwan, Options, Record, identify};
//!
//! let joint = Iwan::new([266.78, 0.0041, 3280.7, -0.842])?; // N, mm, N/mm
//! let a = 0.02;
//! let steps = (0..=100).map(|k| a * (f64::from(k) / 50.0 - 1.0));
//! let loading: Vec<f64> = steps.collect();
//! let unloading = loading.iter().rev();
//! let displacement: Vec<f64> = loading.iter().chain(unloading).copied().collect();
//! let force: Vec<f64> = (0..displacement.len())
//!     .map(|i| joint.steady(a, displacement[i], if i <= 100 { Direction::Loading } else { Direction::Unloading }))
//!     .collect();
//! let found = identify(Record::new(&displacement, &force)?, &Options::default())?;
//! assert!(found.fit.is_reliable() && (found.fit.joint.kappa + 0.842).abs() < 1e-6);
//! # Ok::<(), mepc::Error>(())
//! ```

mod effects;
mod fit;
mod judge;
pub mod least_squares;
pub mod masing;
mod paper;
mod record;
mod residuals;
mod stop;
mod warning;

pub use fit::{CORRELATED, Estimate, Fit, ILL, Stop};
pub use judge::{Extended, Identification, Options, identify};
pub use paper::TOLERANCE as PAPER_TOLERANCE;
pub use record::{Branch, HalfCycle, Node, Origin, Record};
pub use warning::{Effect, Warning};

use crate::backbone::{Backbone, PowerLaw};
use crate::error::{Error, Kind};
use std::f64::consts::TAU;

/// chi - kappa.
pub const CHI_OFFSET: f64 = 2.5;

/// The names of the parameters, in the order of the C interface.
pub const NAMES: [&str; 4] = ["F_s", "X_s", "k_alpha", "kappa"];

/// Which way the displacement goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The displacement grows.
    Loading,
    /// The displacement falls.
    Unloading,
}

impl Direction {
    /// +1 or -1.
    pub fn sign(self) -> f64 {
        match self {
            Direction::Loading => 1.0,
            Direction::Unloading => -1.0,
        }
    }

    /// The other one.
    pub fn opposite(self) -> Self {
        match self {
            Direction::Loading => Direction::Unloading,
            Direction::Unloading => Direction::Loading,
        }
    }
}

/// A joint with four parameters, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iwan {
    /// F_s: friction force in gross slip.
    pub force: f64,
    /// X_s: displacement at the onset of gross slip, from the virgin state.
    pub displacement: f64,
    /// k_alpha: residual stiffness, that of gross slip.
    pub residual: f64,
    /// Exponent; chi = 5/2 + kappa.
    pub kappa: f64,
}

impl Iwan {
    /// A joint from F_s, X_s, k_alpha, kappa.
    ///
    /// # Errors
    /// [`Kind::BadProperty`]: F_s and X_s must be positive, k_alpha finite, chi = 5/2 + kappa from 1 to 1e6.
    pub fn new(parameters: [f64; 4]) -> Result<Self, Error> {
        let [force, displacement, residual, kappa] = parameters;
        let allowed = [
            (force > 0.0 && force.is_finite(), "finite and > 0"),
            (
                displacement.is_normal() && displacement > 0.0,
                "finite and > 0",
            ),
            (residual.is_finite(), "finite"),
            (
                (1.0..=1e6).contains(&(CHI_OFFSET + kappa)),
                "at least -3/2 (chi = 5/2 + kappa >= 1) and at most 1e6",
            ),
        ];
        for (index, (ok, words)) in allowed.into_iter().enumerate() {
            if !ok {
                let (name, value) = (NAMES[index], parameters[index]);
                return Err(Error::new(
                    Kind::BadProperty,
                    format!("params[{index}] {name} = {value:?}: must be {words}"),
                ));
            }
        }
        Ok(Iwan {
            force,
            displacement,
            residual,
            kappa,
        })
    }

    /// F_s, X_s, k_alpha, kappa.
    pub fn parameters(&self) -> [f64; 4] {
        [self.force, self.displacement, self.residual, self.kappa]
    }

    /// The exponent of the backbone.
    pub fn chi(&self) -> f64 {
        CHI_OFFSET + self.kappa
    }

    fn backbone(&self) -> PowerLaw {
        PowerLaw::new(self.chi())
    }

    /// f(x / X_s), 1 in gross slip.
    fn shape(&self, backbone: &PowerLaw, x: f64) -> f64 {
        let s = x / self.displacement;
        if s < 1.0 { backbone.at(s).f } else { 1.0 }
    }

    /// The force of first loading from the virgin state, odd in x.
    pub fn first_loading(&self, x: f64) -> f64 {
        let friction = self.force * self.shape(&self.backbone(), x.abs());
        friction * x.signum() + self.residual * x
    }

    /// The force in the steady loop between -amplitude and +amplitude. Outside of the loop the curve of first loading
    /// goes on.
    pub fn steady(&self, amplitude: f64, x: f64, direction: Direction) -> f64 {
        if x.abs() > amplitude {
            return self.first_loading(x);
        }
        let backbone = self.backbone();
        let sign = direction.sign();
        let from_reversal = 0.5 * (amplitude + sign * x);
        let friction =
            2.0 * self.shape(&backbone, from_reversal) - self.shape(&backbone, amplitude);
        sign * self.force * friction + self.residual * x
    }

    /// The force at the end of a loop.
    pub fn peak_force(&self, amplitude: f64) -> f64 {
        self.first_loading(amplitude)
    }

    /// The stiffness of first loading and just after a reversal.
    pub fn stick_stiffness(&self) -> f64 {
        self.force / self.displacement * self.chi() + self.residual
    }

    /// The energy dissipated per cycle, closed form: 4 F_s X_s G(A / X_s).
    pub fn dissipation(&self, amplitude: f64) -> f64 {
        let loss = self.backbone().cycle_loss(amplitude / self.displacement);
        4.0 * self.force * self.displacement * loss
    }

    /// Equivalent viscous damping ratio D / (2 pi A T_max): that of a linear oscillator of the loop's secant stiffness.
    pub fn damping_ratio(&self, amplitude: f64) -> f64 {
        self.dissipation(amplitude) / (TAU * amplitude * self.peak_force(amplitude))
    }
}
