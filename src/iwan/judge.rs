//! Identification with a judgement: parameters, and every reason why they must not be used.

use super::effects;
use super::fit::{Estimate, Fit, ROUNDING};
use super::record::{Origin, Record};
use super::residuals::Residuals;
use super::stop;
use super::warning::{Effect, Warning};
use crate::error::Error;

/// A stop is looked for where the shape of the residuals is more than this part of T_max.
const SHAPE: f64 = 0.003;
/// Stops describe the loop when they leave no more than this part of the square of the shape.
const LEFT: f64 = 0.25;
/// A past whose residual is smaller by this factor is the right one.
const BETTER: f64 = 1.05;

/// How to identify.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The displacement is late by so many samples; None: what is found is taken out.
    pub lag: Option<f64>,
    /// Fit stops as well: slip, then bearing.
    pub stop: bool,
}

/// A model with more unknowns that describes the loop better.
#[derive(Clone, Debug)]
pub struct Extended {
    /// What was added, with its size in samples (lag), displacement (backlash) or force.
    pub effects: Vec<(Effect, Estimate)>,
    /// The joint with it; its stops, if these were added.
    pub fit: Fit,
}

/// What was identified.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The record that was fitted, without the lag.
    pub record: Record,
    /// The parameters, and what is wrong with them.
    pub fit: Fit,
    /// The lag that was taken out, in samples.
    pub lag: Option<Estimate>,
    /// Where the model does not describe the loop, one that does.
    pub extended: Option<Extended>,
}

/// The parameters by least squares, and whether the model describes the loop.
///
/// # Errors
/// As [`Record::least_squares`].
pub fn identify(record: Record, options: &Options) -> Result<Identification, Error> {
    let mut record = record;
    if let Some(late) = options.lag.filter(|late| *late != 0.0) {
        record = record.without_lag(late)?;
    }
    let (mut record, mut fit) = past(record, options.stop)?;
    let mut lag = None;
    let mut found = effects::found(&record, &fit, true)?;
    let mut extended = None;
    let bears = !options.stop && bears(&record, &fit, found.as_ref())?;
    if bears {
        let mut bearing = stop::fit(&record)?;
        bearing.warnings.clear();
        fit.warnings.extend(bearing.stop.map(Warning::Bears));
        extended = Some(Extended {
            effects: Vec::new(),
            fit: bearing,
        });
        found = None;
    }
    // A lag is no fault of the joint: it is taken out, and what is left is judged.
    if let Some(size) = found
        .as_ref()
        .filter(|found| found.explain && options.lag.is_none())
        .and_then(|found| found.size(Effect::Lag))
    {
        record = record.without_lag(size.value)?;
        fit = of(&record, options.stop)?;
        fit.warnings.push(Warning::LagTakenOut(size));
        lag = Some(size);
        found = effects::found(&record, &fit, false)?;
    }
    if let Some(found) = found.filter(|found| found.explain) {
        if found.spoil(&fit) {
            for &(effect, size) in &found.effects {
                fit.warnings.push(Warning::LeftOut { effect, size });
            }
        }
        extended = Some(Extended {
            effects: found.effects,
            fit: found.fit,
        });
    }
    let residuals = shape(&record, &fit);
    let judged = residuals.warnings(fit.peak, fit.misfit());
    fit.warnings.extend(judged);
    if record.origin.is_some() {
        let amplitudes = || record.half_cycles.iter().map(|half| half.amplitude);
        let least = amplitudes().fold(f64::INFINITY, f64::min);
        fit.warnings.push(Warning::AmplitudeChanges {
            cycles: record.cycles().len(),
            least: least / record.amplitude,
            grows: amplitudes().next() < amplitudes().next_back(),
        });
    }
    Ok(Identification {
        record,
        fit,
        lag,
        extended,
    })
}

fn shape(record: &Record, fit: &Fit) -> Residuals {
    Residuals::new(record, &fit.residuals, ROUNDING * record.force_unit())
}

/// Whether stops describe a loop that the model does not, and better than the effects that were found.
fn bears(record: &Record, fit: &Fit, found: Option<&effects::Found>) -> Result<bool, Error> {
    let before = shape(record, fit).shape;
    if !before.is_plain() || before.square.max(0.0).sqrt() < SHAPE * fit.peak.abs() {
        return Ok(false);
    }
    let (record, _) = effects::thinned(record)?;
    let bearing = stop::fit(&record)?;
    let after = shape(&record, &bearing).shape;
    let describes = !after.is_plain() || after.square < LEFT * before.square;
    let better = found
        .filter(|found| found.explain)
        .is_none_or(|found| bearing.rms * bearing.rms < found.squares[1]);
    let reached = bearing
        .stop
        .is_some_and(|stop| stop.clearances.iter().any(Option::is_some));
    Ok(describes && better && reached)
}

fn of(record: &Record, stop: bool) -> Result<Fit, Error> {
    if stop {
        stop::fit(record)
    } else {
        record.least_squares()
    }
}

/// The fit, where amplitudes change with the past that explains the record better.
fn past(record: Record, stop: bool) -> Result<(Record, Fit), Error> {
    let fit = of(&record, stop)?;
    let other = match record.origin {
        None => return Ok((record, fit)),
        Some(Origin::Centre) => Origin::Start,
        Some(Origin::Start) => Origin::Centre,
    };
    if let Some(record) = record.with_origin(other)
        && let Ok(other) = of(&record, stop)
        && other.rms * BETTER < fit.rms
    {
        return Ok((record, other));
    }
    Ok((record, fit))
}
