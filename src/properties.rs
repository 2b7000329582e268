//! PROPS: the one array of properties that every host passes, checked once.

use crate::backbone::{Choice, PowerLaw, Segalman};
use crate::error::{Error, Kind, Number};

/// How many entries are common to all hosts; a host's own entries follow.
pub const COMMON: usize = 12;

/// The names of the common entries, in their order.
const NAMES: [&str; COMMON] = [
    "mu",
    "gcr",
    "chi",
    "method",
    "pressure_rule",
    "fraction",
    "kn",
    "gap0",
    "base_knots",
    "backbone",
    "beta",
    "reserved",
];

/// What missing trailing entries are taken to be (mu and gcr are required).
const DEFAULTS: [f64; COMMON] = [
    f64::NAN,
    f64::NAN,
    2.5,
    0.0,
    0.0,
    0.005,
    0.0,
    0.0,
    16.0,
    0.0,
    0.0,
    0.0,
];

/// The largest power-law exponent taken; beyond it the law is rigid stick to every printed digit.
const CHI_MAX: f64 = 1e6;
/// The largest beta; the curve has long been a straight line.
const BETA_MAX: f64 = 1e100;

/// What the contact does up to gross slip (PROPS 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The memory law.
    Memory,
    /// The standard penalty method: a linear elastic slip up to Coulomb's limit.
    Penalty,
    /// Rigid stick; in a host without Lagrange multipliers the penalty method with gcr / 1000.
    Lagrange,
}

/// What becomes of the memory when the pressure rises (PROPS 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PressureRule {
    /// New stiffness arrives unloaded; dissipation is never negative.
    Dissipative,
    /// Tractions scale with the pressure both ways, the paper's Eq. (17); it can create energy.
    Proportional,
}

/// The common properties, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Properties {
    /// Friction coefficient.
    pub mu: f64,
    /// Critical slip, length; 0 where the host's characteristic length decides.
    pub gcr: f64,
    /// Exponent of the backbone.
    pub chi: f64,
    /// What the contact does up to gross slip.
    pub method: Method,
    /// What becomes of the memory when the pressure rises.
    pub pressure_rule: PressureRule,
    /// Critical slip as a fraction of the characteristic length, used when gcr = 0.
    pub fraction: f64,
    /// Normal penalty stiffness, pressure per length (interface form).
    pub kn: f64,
    /// Initial clearance, length (interface form).
    pub gap0: f64,
    /// Knots of the base grid for two directions.
    pub base_knots: usize,
    /// True for Segalman's backbone, false for the power law.
    pub segalman: bool,
    /// Segalman's stiffness ratio.
    pub beta: f64,
}

impl Properties {
    /// Checks PROPS; trailing entries may be missing, entries past the common ones are the host's.
    ///
    /// # Errors
    /// [`Kind::BadProperty`] names the entry, its number, its value and what it may be.
    pub fn new(props: &[f64]) -> Result<Self, Error> {
        if props.len() < 2 {
            return Err(Error::new(
                Kind::BadProperty,
                format!(
                    "nprops = {}: mu and gcr (PROPS 1 and 2) are required",
                    props.len()
                ),
            ));
        }
        let mut values = DEFAULTS;
        for (value, given) in values.iter_mut().zip(props) {
            *value = *given;
        }
        let check = |index: usize, allowed: &str, ok: bool| {
            if ok && values[index].is_finite() {
                return Ok(values[index]);
            }
            Err(Error::new(
                Kind::BadProperty,
                format!(
                    "PROPS({}) {} = {:?}: must be {allowed}",
                    index + 1,
                    NAMES[index],
                    Number(values[index])
                ),
            ))
        };
        let [
            mu,
            gcr,
            chi,
            method,
            rule,
            fraction,
            kn,
            gap0,
            base_knots,
            backbone,
            beta,
            reserved,
        ] = values;
        check(
            9,
            "0 (power law) or 1 (Segalman)",
            backbone == 0.0 || backbone == 1.0,
        )?;
        let segalman = backbone == 1.0;
        check(0, "finite and >= 0", mu >= 0.0)?;
        check(
            1,
            "finite and >= 0 (0: fraction x characteristic length)",
            gcr >= 0.0,
        )?;
        if segalman {
            check(
                2,
                "given, > -1 and <= 0 for Segalman's backbone",
                chi > -1.0 && chi <= 0.0,
            )?;
        } else {
            check(
                2,
                "from 1 to 1e6 for the power law",
                (1.0..=CHI_MAX).contains(&chi),
            )?;
        }
        let known = [Method::Memory, Method::Penalty, Method::Lagrange];
        let named = (0..known.len()).find(|&number| number as f64 == method);
        check(
            3,
            "0 (memory), 1 (penalty) or 2 (Lagrange)",
            named.is_some(),
        )?;
        check(
            4,
            "0 (dissipative) or 1 (proportional)",
            rule == 0.0 || rule == 1.0,
        )?;
        check(5, "finite and > 0", fraction > 0.0)?;
        check(6, "finite and >= 0", kn >= 0.0)?;
        check(7, "finite", true)?;
        let whole = (1.0..=64.0).contains(&base_knots) && base_knots.fract() == 0.0;
        check(8, "a whole number from 1 to 64", whole)?;
        if segalman {
            check(10, "from 0 to 1e100", (0.0..=BETA_MAX).contains(&beta))?;
        } else {
            check(10, "0 unless backbone is 1 (Segalman)", beta == 0.0)?;
        }
        check(11, "0", reserved == 0.0)?;
        Ok(Properties {
            mu,
            gcr,
            chi,
            method: known[named.unwrap_or(0)],
            pressure_rule: if rule == 0.0 {
                PressureRule::Dissipative
            } else {
                PressureRule::Proportional
            },
            fraction,
            kn,
            gap0,
            base_knots: base_knots as usize,
            segalman,
            beta,
        })
    }

    /// The backbone these properties ask for.
    pub fn backbone(&self) -> Choice {
        if self.method != Method::Memory {
            Choice::PowerLaw(PowerLaw::new(1.0))
        } else if self.segalman {
            Choice::Segalman(Segalman::new(self.chi, self.beta))
        } else {
            Choice::PowerLaw(PowerLaw::new(self.chi))
        }
    }

    /// The critical slip for a host that offers a characteristic length (0: it offers none).
    ///
    /// # Errors
    /// [`Kind::BadProperty`] when neither gives a positive length.
    pub fn critical_slip(&self, characteristic_length: f64) -> Result<f64, Error> {
        let gcr = if self.gcr > 0.0 {
            self.gcr
        } else if characteristic_length > 0.0 && characteristic_length.is_finite() {
            self.fraction * characteristic_length
        } else {
            0.0
        };
        // A subnormal length would lose digits, and its reciprocal overflows.
        if gcr.is_normal() {
            return Ok(gcr);
        }
        Err(Error::new(
            Kind::BadProperty,
            format!(
                "PROPS(2) gcr = {:?} with a characteristic length of {:?}: a host \
                 without a characteristic length needs gcr > 0",
                self.gcr,
                Number(characteristic_length)
            ),
        ))
    }
}
