//! What has to be known before identified parameters are used, and what makes them unfit for use.

use super::NAMES;
use super::fit::{Estimate, FEW_POINTS, Stop};
use std::fmt;

/// A standard error of F_s or X_s beyond this part says nothing of it.
const NOTHING: f64 = 1.0;

/// Something that the model leaves out, of one more unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The displacement is late by so many samples.
    Lag,
    /// Play: the displacement moves so far at a reversal before anything follows.
    Backlash,
    /// A force in proportion to the velocity; its greatest value.
    Viscous,
    /// A force in proportion to the cube of the displacement; its value at the amplitude.
    Hardening,
    /// A force in proportion to the square of the displacement, that is of one sign on both sides; its value at the
    /// amplitude.
    Asymmetry,
    /// A force that grows in proportion to time; from the first to the last point.
    Drift,
    /// The loop grows in proportion to time; by so much at its largest force, from the first to the last point.
    Change,
}

impl Effect {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Lag => "lag",
            Effect::Backlash => "backlash",
            Effect::Viscous => "viscous",
            Effect::Hardening => "hardening",
            Effect::Asymmetry => "asymmetry",
            Effect::Drift => "drift",
            Effect::Change => "change",
        }
    }
}

/// Something that the user of the parameters has to know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// The data do not show that gross slip was reached: the parameters are an extrapolation.
    NoGrossSlip {
        /// X_s over the amplitude, as fitted.
        reach: f64,
    },
    /// So few points in one direction.
    FewPoints(usize),
    /// So few points in gross slip.
    FewGrossSlipPoints(usize),
    /// Parameter `index` has this standard error, relative (kappa: absolute).
    IllDetermined {
        /// Index into [`NAMES`].
        index: usize,
        /// The standard error.
        error: f64,
    },
    /// chi stands at an end of its range.
    ChiAtBound(f64),
    /// The displacement scatters by this part of the amplitude.
    NoisyDisplacement(f64),
    /// Friction and residual stiffness cancel: F_s is so many times the half range of the force.
    NoJoint(f64),
    /// X_s, over the amplitude, stands at an end of its range.
    DisplacementAtBound(f64),
    /// Neighbouring residuals are alike, with this correlation: the loop is not quite one of the model.
    Correlated(f64),
    /// The amplitude grows or falls; cycles of so many amplitudes went into one fit.
    AmplitudeChanges {
        /// Whole cycles.
        cycles: usize,
        /// The least amplitude over the greatest.
        least: f64,
        /// Whether the last half cycle is longer than the first.
        grows: bool,
    },
    /// A time lag of the displacement in samples was found and taken out.
    LagTakenOut(Estimate),
    /// The root mean square residual is this part of T_max.
    Misfit(f64),
    /// The part of the residuals that is no noise is this part of T_max.
    Shape(f64),
    /// The branches that load and those that unload differ by this part of T_max.
    Branches(f64),
    /// The measured force at the ends of the loop differs from the fitted one by this part of it.
    Peak(f64),
    /// The model leaves this out; with it the loop is described.
    LeftOut {
        /// What it is.
        effect: Effect,
        /// How much: samples, displacement or force.
        size: Estimate,
    },
    /// The joint bears on stops; with them the loop is described.
    Bears(Stop),
}

impl Warning {
    /// True when the data cannot give the parameters at all, whatever the model.
    pub fn is_extrapolation(&self) -> bool {
        matches!(
            self.reason(),
            Some("gross_slip" | "cancelling" | "undetermined")
        )
    }

    /// Why the parameters must not be used as they are, in one word; None where they may.
    pub fn reason(&self) -> Option<&'static str> {
        match self {
            Warning::NoGrossSlip { .. } => Some("gross_slip"),
            Warning::NoJoint(_) => Some("cancelling"),
            Warning::IllDetermined { index, error } if *index < 2 && *error > NOTHING => {
                Some("undetermined")
            }
            Warning::ChiAtBound(_) | Warning::DisplacementAtBound(_) => Some("bound"),
            Warning::Misfit(_) => Some("misfit"),
            Warning::Shape(_) => Some("shape"),
            Warning::Branches(_) => Some("branches"),
            Warning::Peak(_) => Some("peak"),
            Warning::LeftOut { effect, .. } => Some(effect.name()),
            Warning::Bears(_) => Some("bearing"),
            _ => None,
        }
    }
}

/// A value and its standard error, with three digits.
struct Plus(Estimate);

impl fmt::Display for Plus {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = |value: f64| {
            let exponent = value.abs().log10().floor();
            if (-3.0..4.0).contains(&exponent) {
                format!("{value:.*}", (2.0 - exponent).max(0.0) as usize)
            } else {
                format!("{value:.2e}")
            }
        };
        write!(
            out,
            "{} (standard error {})",
            digits(self.0.value),
            digits(self.0.error)
        )
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NoGrossSlip { reach } if *reach >= 1.0 => write!(
                out,
                "no gross slip in the data (X_s would be {reach:.2} amplitudes): F_s, X_s, k_alpha and kappa are an extrapolation; \
                 measure with a larger amplitude"
            ),
            Warning::NoGrossSlip { reach } => write!(
                out,
                "the data do not show gross slip: X_s is {reach:.2} amplitudes, but a curve with X_s beyond the amplitude fits no \
                 worse than their scatter and misfit allow; F_s, X_s, k_alpha and kappa are an extrapolation"
            ),
            Warning::NoJoint(ratio) => write!(
                out,
                "F_s is {ratio:.1} times the half range of the force, and k_alpha takes it back: the loop is not one of this model"
            ),
            Warning::DisplacementAtBound(x) => write!(
                out,
                "X_s = {x:.3} amplitudes is the end of the range that was searched: nothing can be said of X_s and kappa"
            ),
            Warning::NoisyDisplacement(part) => write!(
                out,
                "the displacement scatters by {:.1} % of the amplitude: X_s and kappa come out too small, by more than the \
                 standard errors tell",
                100.0 * part
            ),
            Warning::FewPoints(count) => {
                write!(
                    out,
                    "only {count} points in one direction, {FEW_POINTS} are few"
                )
            }
            Warning::FewGrossSlipPoints(count) => write!(
                out,
                "only {count} points in gross slip: k_alpha and F_s rest on them"
            ),
            Warning::IllDetermined { index: 3, error } => {
                write!(out, "kappa is ill-determined: standard error {error:.2}")
            }
            Warning::IllDetermined { index, error } => write!(
                out,
                "{} is ill-determined: standard error {:.0} %",
                NAMES[*index],
                100.0 * error
            ),
            Warning::ChiAtBound(chi) if *chi > 2.0 => write!(
                out,
                "chi = {chi} is the end of the range that was searched: gross slip is approached exponentially; F_s, k_alpha and \
                 chi F_s/X_s hold, X_s and kappa do not"
            ),
            Warning::ChiAtBound(chi) => write!(
                out,
                "chi = {chi} is the end of the range that was searched: the loop has another shape"
            ),
            Warning::Correlated(correlation) => write!(
                out,
                "neighbouring residuals are alike (correlation {correlation:.2}): the loop is not quite of this model; \
                 the standard errors are enlarged as for noise of that kind, a bias is not in them"
            ),
            Warning::AmplitudeChanges {
                cycles,
                least,
                grows,
            } => write!(
                out,
                "the amplitude {}: {cycles} cycles from {least:.2} of the largest amplitude on are in one fit",
                if *grows { "grows" } else { "changes" }
            ),
            Warning::LagTakenOut(lag) => write!(
                out,
                "the displacement is late by {} samples: taken out",
                Plus(*lag)
            ),
            Warning::Misfit(part) => write!(
                out,
                "the model does not describe the loop: the residual is {:.1} % of T_max",
                100.0 * part
            ),
            Warning::Shape(part) => write!(
                out,
                "the residuals have a shape that noise does not have, {:.1} % of T_max: the loop is of another kind",
                100.0 * part
            ),
            Warning::Branches(part) => write!(
                out,
                "loading and unloading differ by {:.1} % of T_max: in this model they mirror each other",
                100.0 * part
            ),
            Warning::Peak(part) => write!(
                out,
                "the measured force at the ends of the loop is {:.1} % from the fitted T_max",
                100.0 * part
            ),
            Warning::LeftOut { effect, size } => {
                let size = Plus(*size);
                match effect {
                    Effect::Lag => write!(
                        out,
                        "the displacement is late by {size} samples, which was left in: X_s and kappa are wrong"
                    ),
                    Effect::Backlash => write!(
                        out,
                        "backlash: at every reversal the displacement moves by {size} before the force follows; the model has none"
                    ),
                    Effect::Viscous => write!(
                        out,
                        "a viscous part of the force, {size} at the largest velocity: the model has none"
                    ),
                    Effect::Hardening => write!(
                        out,
                        "the stiffness in gross slip is not constant: a force with the cube of the displacement, {size} at the \
                         amplitude, describes the loop better"
                    ),
                    Effect::Asymmetry => write!(
                        out,
                        "the loop is not the same on both sides: a force with the square of the displacement, {size} at the \
                         amplitude, describes it better"
                    ),
                    Effect::Drift => write!(
                        out,
                        "the force drifts by {size} from the first point to the last"
                    ),
                    Effect::Change => write!(
                        out,
                        "the loop changes: its largest force grows by {size} from the first cycle to the last"
                    ),
                }
            }
            Warning::Bears(stop) => {
                let [above, below] = stop
                    .clearances
                    .map(|side| side.map_or("not reached".to_string(), |c| Plus(c).to_string()));
                write!(
                    out,
                    "the joint slips and then bears: a model with stops at {above} above and {below} below the middle, stiffness \
                     {}, describes the loop",
                    Plus(stop.stiffness)
                )
            }
        }
    }
}
