//! PROPS: the one array of properties that every host passes, checked once.
//!
//! Zero and missing trailing entries mean the default.

use crate::backbone::{Choice, FiveHalves, PowerLaw, Segalman};
use crate::error::{Error, Kind};
use crate::number::{finite, within};

/// How many entries are common to all hosts; a host's own entries follow.
pub const COMMON: usize = 20;

/// The names of the common entries, in their order.
pub const NAMES: [&str; COMMON] = [
    "mu",
    "gcr",
    "exponent",
    "method",
    "reference_pressure",
    "fraction",
    "kn",
    "gap0",
    "normal_exponent",
    "backbone",
    "beta",
    "cohesion",
    "tau_max",
    "mu_late",
    "slip_late",
    "resolution",
    "reserved17",
    "reserved18",
    "reserved19",
    "reserved20",
];

/// The exponent of the power law where none is given: the paper's.
pub const DEFAULT_EXPONENT: f64 = 2.5;
/// The critical slip over the characteristic length where none is given.
pub const DEFAULT_FRACTION: f64 = 0.005;
/// How fine a turning path is kept where nothing is said.
pub const DEFAULT_RESOLUTION: f64 = 1e-3;

/// The largest power-law exponent taken; beyond it the law is rigid stick to every printed digit.
const EXPONENT_MAX: f64 = 1e6;
/// The largest beta; the curve has long been a straight line.
const BETA_MAX: f64 = 1e100;
/// The largest exponent of the normal stiffness.
const NORMAL_EXPONENT_MAX: f64 = 100.0;
/// Coefficients, tractions and lengths up to here (and lengths down to its reciprocal) have squares that are numbers.
const LARGEST: f64 = 1e100;
/// The largest pressure, cohesion, cap and stiffness taken: what follows from them is still a number.
pub(crate) const HIGHEST: f64 = 1e300;

/// What the contact does up to gross slip (PROPS 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The memory law.
    Memory,
    /// The standard penalty method: a linear elastic slip up to the limit.
    Penalty,
    /// Rigid stick; in a host without Lagrange multipliers the penalty method with gcr / 1000.
    Lagrange,
}

/// The common properties, checked, defaults filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct Properties {
    /// Friction coefficient.
    pub mu: f64,
    /// Critical slip at the reference pressure, length; 0 where the host's characteristic length decides.
    pub gcr: f64,
    /// Exponent: chi of the power law, q of Segalman's backbone.
    pub exponent: f64,
    /// What the contact does up to gross slip.
    pub method: Method,
    /// Reference pressure of the consistent rule; 0 is the proportional rule.
    pub reference_pressure: f64,
    /// Critical slip as a fraction of the characteristic length, used when gcr = 0.
    pub fraction: f64,
    /// Normal stiffness: pressure at unit penetration (interface form).
    pub kn: f64,
    /// Initial clearance, length; negative is interference (interface form).
    pub gap0: f64,
    /// Exponent m of the normal stiffness: p = kn (-gap)^m.
    pub normal_exponent: f64,
    /// True for Segalman's backbone, false for the power law.
    pub segalman: bool,
    /// Segalman's stiffness ratio.
    pub beta: f64,
    /// Cohesion: limit traction at no pressure.
    pub cohesion: f64,
    /// Cap of the limit traction; infinite where there is none.
    pub tau_max: f64,
    /// Friction coefficient after long slip, where it changes.
    pub run_in: Option<RunIn>,
    /// How fine a turning path is kept (two directions).
    pub resolution: f64,
}

/// How the friction coefficient goes to its late value with the slip length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunIn {
    /// Friction coefficient after long slip.
    pub mu: f64,
    /// Slip length over which the difference falls to 1/e.
    pub length: f64,
}

impl Properties {
    /// Checks PROPS; zero and missing trailing entries are defaults, entries past the common ones are the host's.
    ///
    /// # Errors
    /// [`Kind::BadProperty`] names the entry, its number, its value and what it may be.
    pub fn new(props: &[f64]) -> Result<Self, Error> {
        let mut values = [0.0; COMMON];
        for (value, given) in values.iter_mut().zip(props) {
            *value = *given;
        }
        let refuse = |index: usize, expected: &'static str| {
            Err(Error::about(Kind::BadProperty, "PROPS", expected)
                .index(index)
                .name(NAMES[index])
                .number(values[index]))
        };
        if let Some(index) = values.iter().position(|value| !finite(*value)) {
            return refuse(index, "must be finite");
        }
        // What must not be negative, and how large it may be.
        for (index, largest, expected) in [
            (0, LARGEST, "must be from 0 to 1e100"),
            (
                1,
                LARGEST,
                "must be from 0 (fraction x characteristic length) to 1e100",
            ),
            (4, HIGHEST, "must be from 0 (proportional rule) to 1e300"),
            (5, LARGEST, "must be from 0 (.005) to 1e100"),
            (6, HIGHEST, "must be from 0 to 1e300"),
            (11, HIGHEST, "must be from 0 to 1e300"),
            (12, HIGHEST, "must be from 0 (no cap) to 1e300"),
            (13, LARGEST, "must be from 0 (= mu) to 1e100"),
            (14, LARGEST, "must be from 0 to 1e100"),
        ] {
            if values[index] < 0.0 || values[index] > largest {
                return refuse(index, expected);
            }
        }
        let or = |index: usize, default: f64| match values[index] {
            0.0 => default,
            given => given,
        };
        if values[1] != 0.0 && values[1] < 1.0 / LARGEST {
            return refuse(1, "must be 0, or from 1e-100 to 1e100");
        }
        if values[9] != 0.0 && values[9] != 1.0 {
            return refuse(9, "must be 0 (power law) or 1 (Segalman)");
        }
        let segalman = values[9] == 1.0;
        let exponent = if segalman {
            values[2]
        } else {
            or(2, DEFAULT_EXPONENT)
        };
        if segalman && !(exponent > 1.0 && exponent <= 2.0) {
            return refuse(2, "must be given, > 1 and <= 2, for Segalman's backbone");
        }
        if !segalman && !(1.0..=EXPONENT_MAX).contains(&exponent) {
            return refuse(2, "must be 0 (2.5), or from 1 to 1e6, for the power law");
        }
        let known = [Method::Memory, Method::Penalty, Method::Lagrange];
        let Some(method) = (0..known.len()).find(|&number| number as f64 == values[3]) else {
            return refuse(3, "must be 0 (memory), 1 (penalty) or 2 (Lagrange)");
        };
        let method = known[method];
        if segalman && method == Method::Memory && values[4] > 0.0 {
            return refuse(
                4,
                "must be 0 with Segalman's backbone: it is not self-similar, so that no rule for a changing critical slip exists",
            );
        }
        if !within(values[7], LARGEST) {
            return refuse(7, "must be from -1e100 to 1e100");
        }
        let normal_exponent = or(8, 1.0);
        if !(1.0..=NORMAL_EXPONENT_MAX).contains(&normal_exponent) {
            return refuse(8, "must be 0 (1), or from 1 to 100");
        }
        if segalman && !(0.0..=BETA_MAX).contains(&values[10]) {
            return refuse(10, "must be from 0 to 1e100");
        }
        if !segalman && values[10] != 0.0 {
            return refuse(10, "must be 0 unless backbone is 1 (Segalman)");
        }
        if values[13] > 0.0 && values[14] == 0.0 {
            return refuse(14, "must be > 0 where mu_late is given");
        }
        if values[14] > 0.0 && values[13] == 0.0 {
            return refuse(13, "must be > 0 where slip_late is given");
        }
        if values[14] > 0.0 && values[14] < 1.0 / LARGEST {
            return refuse(14, "must be 0, or from 1e-100 to 1e100");
        }
        let resolution = or(15, DEFAULT_RESOLUTION);
        if !(1e-6..=0.1).contains(&resolution) {
            return refuse(15, "must be 0 (1e-3), or from 1e-6 to 0.1");
        }
        if let Some(index) = (16..COMMON).find(|&index| values[index] != 0.0) {
            return refuse(index, "must be 0");
        }
        let [mu, cohesion] = [values[0], values[11]];
        if values[13] > 0.0 && values[4] > 0.0 && mu == 0.0 && cohesion == 0.0 {
            return refuse(
                13,
                "must be 0 where mu and cohesion are 0 and a reference pressure is given: the critical slip at that pressure would mean nothing",
            );
        }
        Ok(Properties {
            mu,
            gcr: values[1],
            exponent,
            method,
            reference_pressure: values[4],
            fraction: or(5, DEFAULT_FRACTION),
            kn: values[6],
            gap0: values[7],
            normal_exponent,
            segalman,
            beta: values[10],
            cohesion,
            tau_max: or(12, f64::INFINITY),
            run_in: (values[13] > 0.0).then_some(RunIn {
                mu: values[13],
                length: values[14],
            }),
            resolution,
        })
    }

    /// The backbone these properties ask for.
    pub fn backbone(&self) -> Choice {
        if self.method != Method::Memory {
            Choice::PowerLaw(PowerLaw::new(1.0))
        } else if self.segalman {
            Choice::Segalman(Segalman::new(self.exponent, self.beta))
        } else if self.exponent == 2.5 {
            Choice::FiveHalves(FiveHalves)
        } else {
            Choice::PowerLaw(PowerLaw::new(self.exponent))
        }
    }

    /// f'(0) of the backbone.
    pub fn initial_slope(&self) -> f64 {
        self.backbone().initial_slope()
    }

    /// The critical slip for a host that offers a characteristic length (0: it offers none).
    ///
    /// # Errors
    /// [`Kind::BadProperty`] when neither gives a length from 1e-100 to 1e100.
    pub fn critical_slip(&self, characteristic_length: f64) -> Result<f64, Error> {
        if self.gcr > 0.0 {
            return Ok(self.gcr);
        }
        // By bits: a comparison with a NaN raises a flag that hosts trap.
        if (1..=LARGEST.to_bits()).contains(&characteristic_length.to_bits()) {
            let gcr = self.fraction * characteristic_length;
            if (1.0 / LARGEST..=LARGEST).contains(&gcr) {
                return Ok(gcr);
            }
        }
        Err(Error::about(
            Kind::BadProperty,
            "PROPS",
            "a host without a characteristic length needs gcr > 0 (otherwise gcr is fraction x characteristic length)",
        )
        .index(1)
        .name("gcr")
        .text(format!(
            "{:?} with a characteristic length of {}",
            self.gcr,
            crate::number::Number(characteristic_length)
        )))
    }
}
