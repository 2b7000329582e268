//! `mepc identify`: a measured loop to the four parameters of the improved Iwan model.

use crate::channels::{Columns, Units};
use crate::numbers::{self, beside, short, with_error};
use crate::{Outcome, check_outputs, print, say, write, wrong_use};
use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use mepc::iwan::{
    Direction, Estimate, Extended, Fit, Identification, Iwan, NAMES, Options, PAPER_TOLERANCE,
    Record, Stop, Warning, identify,
};
use mepc_plot::{BLUE, Curve, Figure, GREEN, GREY, ORANGE, Stroke};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::PathBuf;

/// Identify the four parameters of the improved Iwan model from a measured hysteresis loop.
///
/// The file holds cycles of one or of several amplitudes in the order of time, about any centre, with noise in the
/// force. Reversals are found in the data; where the amplitude changes, all cycles are in one fit. A time lag between
/// displacement and force is found and taken out. Whether the model describes the loop is judged.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc identify loop.csv
  mepc identify test.csv --displacement 'u (um)' --displacement-unit um --force 'F (kN)' --force-unit kN
  mepc identify loop.csv --json --bootstrap 500 | jq .kappa
  mepc identify loop.csv --picture loop.svg
  mepc identify steps.csv --cycle 3
  mepc identify lap_joint.csv --model stop

The model: T = F_s [1 - (1 - x/X_s)^chi] + k_alpha x at first loading, chi = 5/2 + kappa; Masing's branches after that.
Exit code 3: the parameters must not be used; \"reasons\" in the JSON has them in single words: gross_slip,
undetermined, cancelling, bound (an end of what was searched), misfit, shape, branches, peak, bearing, lag,
backlash, viscous, hardening, asymmetry, drift, change. A model that describes the loop is under \"extended\".")]
pub struct Arguments {
    /// Displacement and force, CSV with a header (- for standard input).
    #[arg(value_name = "LOOP.csv")]
    file: PathBuf,
    #[command(flatten)]
    columns: Columns,
    /// Least squares over both branches, or the paper's own procedure (Eq. (24)).
    #[arg(long, value_enum, default_value_t = Method::LeastSquares)]
    method: Method,
    /// The joint alone, or with stops: slip, then bearing (lap joints in clearance holes).
    #[arg(long, value_enum, default_value_t = Model::FourParameter)]
    model: Model,
    /// Fit this cycle only, counted from the first reversal.
    #[arg(long, value_name = "N", value_parser = |text: &str| numbers::whole::<u32>(text, 1..=u64::from(u32::MAX)))]
    cycle: Option<u32>,
    /// Use these rows only, counted from 1 where the numbers begin, as if the file had no others.
    #[arg(long, value_name = "A:B", value_parser = rows)]
    rows: Option<Range<usize>>,
    /// The displacement is late by so many samples (0: leave a lag) [default: found, and taken out where it is
    /// significant].
    #[arg(long, value_name = "SAMPLES", allow_negative_numbers = true, value_parser = numbers::argument)]
    lag: Option<f64>,
    /// The paper's procedure: the data leave the residual line where they are away from it by this part of F_s.
    #[arg(long, value_name = "PART", default_value_t = PAPER_TOLERANCE, value_parser = part)]
    tolerance: f64,
    /// Standard errors and 95 % intervals from so many resampled loops instead of the linearised ones (least squares
    /// only).
    #[arg(long, value_name = "N", value_parser = |text: &str| numbers::whole::<u32>(text, 20..=100_000))]
    bootstrap: Option<u32>,
    /// Seed of the resampling.
    #[arg(long, default_value_t = 1, value_parser = |text: &str| numbers::whole::<u64>(text, 0..=u64::MAX))]
    seed: u64,
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Draw data, fit and residuals into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

fn part(text: &str) -> Result<f64, String> {
    let part = numbers::argument(text)?;
    if part > 0.0 && part < 1.0 {
        Ok(part)
    } else {
        Err(format!("{text} is not above 0 and below 1"))
    }
}

/// Rows A to B, both counted from 1 and included.
fn rows(text: &str) -> Result<Range<usize>, String> {
    let words =
        || format!("'{text}' is not A:B, two whole numbers from 1 on, the second not smaller");
    let (first, last) = text.split_once(':').ok_or_else(words)?;
    let number = |text: &str| numbers::whole::<usize>(text, 1..=u64::MAX).map_err(|_| words());
    let (first, last) = (number(first)?, number(last)?);
    if last < first {
        return Err(words());
    }
    Ok(first - 1..last)
}

/// The paper's procedure misses a loop when its rms residual is so many times that of least squares.
const MISSES: f64 = 2.0;

/// What is fitted.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Model {
    FourParameter,
    Stop,
}

/// How the parameters are found.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    LeastSquares,
    Paper,
}

/// Runs the command.
///
/// # Errors
/// Bad input, or a file that cannot be written.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let file = arguments.file.display().to_string();
    if arguments.method == Method::Paper && arguments.bootstrap.is_some() {
        // What the procedure leaves is no noise that could be drawn from.
        return Err(wrong_use(
            "--bootstrap does not go with --method paper: resampled loops say nothing about how far it misses",
        ));
    }
    if arguments.method == Method::Paper && arguments.model == Model::Stop {
        return Err(wrong_use(
            "--model stop does not go with --method paper: the paper's procedure knows no stop",
        ));
    }
    check_outputs(
        &[("--picture", arguments.picture.as_deref())],
        &[&arguments.file],
    )?;
    let named = |error: mepc::Error| anyhow!("{file}: {}", crate::sentence(&error));
    let (record, units) = read(arguments, &file)?;
    let options = Options {
        lag: arguments.lag,
        stop: arguments.model == Model::Stop,
    };
    let mut found = identify(record, &options).map_err(named)?;
    let paper = match arguments.model {
        Model::FourParameter => Some(found.record.paper(arguments.tolerance)),
        Model::Stop => None,
    };
    let best = found.fit.rms;
    let misses = match &paper {
        Some(Ok(paper)) if paper.rms > MISSES * best => {
            let [ours, theirs] = [paper.rms, best].map(|rms| 100.0 * rms / found.fit.peak);
            Some(format!(
                "the paper's procedure misses this loop: rms {ours:.2} % of T_max, by least squares {theirs:.2} %"
            ))
        }
        _ => None,
    };
    let mut paper = match (arguments.method, paper) {
        (Method::Paper, Some(paper)) => {
            // Whether the parameters may be used is for the better method to say.
            let warnings = found.fit.warnings.into_iter().filter(|w| {
                w.reason().is_some()
                    || matches!(
                        w,
                        Warning::LagTakenOut(_) | Warning::AmplitudeChanges { .. }
                    )
            });
            found.fit = Fit {
                warnings: warnings.collect(),
                ..paper.map_err(named)?
            };
            None
        }
        (_, paper) => paper.and_then(Result::ok),
    };
    if let Some(paper) = &mut paper {
        paper.residuals = Vec::new();
    }
    if let Some(count) = arguments.bootstrap {
        resample(&found.record, &mut found.fit, arguments, count)?;
    }
    let fit = &found.fit;
    let mut warnings: Vec<String> = fit.warnings.iter().map(told).collect();
    if arguments.method == Method::Paper {
        warnings.extend(misses.clone());
    }
    let report = Report {
        file: &file,
        record: &found.record,
        fit,
        found: &found,
        warnings: &warnings,
        method: arguments.method,
        paper,
        misses,
        bootstrap: arguments.bootstrap,
        units,
    };
    if let Some(path) = &arguments.picture {
        write(Some(path), &report.picture()?)?;
    }
    for warning in &warnings {
        say(&format!("{file}: warning: {warning}"));
    }
    if arguments.json {
        print(&format!("{:#}\n", report.json()))?;
    } else {
        print(&report.table())?;
    }
    Ok(if fit.is_reliable() {
        Outcome::Done
    } else {
        Outcome::Flagged
    })
}

/// A warning, with the option that belongs to it.
fn told(warning: &Warning) -> String {
    let option = match warning {
        Warning::LagTakenOut(_) => " (--lag 0 leaves it)",
        Warning::AmplitudeChanges { .. } => " (--cycle N or --rows A:B choose some)",
        Warning::Bears(_) => "; use --model stop",
        _ => "",
    };
    format!("{warning}{option}")
}

/// The record of the file: the rows and the cycle that were asked for.
fn read(arguments: &Arguments, file: &str) -> Result<(Record, Units)> {
    let mut channels = arguments.columns.read(&arguments.file)?;
    let units = channels.units;
    if let Some(rows) = &arguments.rows {
        let count = channels.force.len();
        if rows.end > count {
            return Err(anyhow!(
                "{file}: --rows {}:{}: there are {count} rows",
                rows.start + 1,
                rows.end
            ));
        }
        for column in [&mut channels.displacement, &mut channels.force] {
            column.truncate(rows.end);
            column.drain(..rows.start);
        }
    }
    let record = channels.record()?;
    let Some(cycle) = arguments.cycle else {
        return Ok((record, units));
    };
    let cycles = record.cycles();
    let Some(rows) = cycles.get(cycle as usize - 1) else {
        return Err(anyhow!(
            "{file}: --cycle {cycle}: {} whole cycles were found",
            cycles.len()
        ));
    };
    let record = record
        .with_rows(rows.clone())
        .map_err(|error| anyhow!("{file}: --cycle {cycle}: {}", crate::sentence(&error)))?;
    Ok((record, units))
}

/// Replaces standard errors and intervals by those of refitted loops: the fit plus residuals drawn in blocks, so that
/// what is alike in neighbours stays so.
fn resample(record: &Record, fit: &mut Fit, arguments: &Arguments, count: u32) -> Result<()> {
    let points = fit.residuals.len();
    // The exponent 1/3 balances what is lost inside the blocks against how many there are.
    let block = (points as f64).cbrt().ceil() as usize;
    // Residuals of a fit with five unknowns are a little smaller than the noise.
    let grown = (points as f64 / (points as f64 - 5.0)).sqrt();
    let indices: Vec<usize> = record.branches.iter().flat_map(|b| b.points()).collect();
    let smooth: Vec<f64> = indices
        .iter()
        .zip(&fit.residuals)
        .map(|(&index, residual)| record.force[index] - residual)
        .collect();
    let mut random = fastrand::Rng::with_seed(arguments.seed);
    let bar = ProgressBar::new(u64::from(count));
    bar.set_style(ProgressStyle::with_template(
        "resampling {bar:40} {pos}/{len} {eta}",
    )?);
    let mut drawn: [Vec<f64>; 4] = Default::default();
    let mut failed = 0;
    for _ in 0..count {
        let mut force = record.force.clone();
        let mut at = 0;
        while at < points {
            let from = random.usize(..points);
            for k in 0..block.min(points - at) {
                let residual = fit.residuals[(from + k) % points];
                force[indices[at + k]] = smooth[at + k] + grown * residual;
            }
            at += block;
        }
        let sample = record.with_force(force);
        match sample.least_squares_from(fit) {
            Ok(refit) => {
                for (values, value) in drawn.iter_mut().zip(refit.joint.parameters()) {
                    values.push(value);
                }
            }
            Err(_) => failed += 1,
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if 10 * failed > count {
        return Err(anyhow!(
            "--bootstrap: {failed} of {count} resampled loops could not be identified: the data do not determine the parameters"
        ));
    }
    for (k, values) in drawn.iter_mut().enumerate() {
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        fit.standard_errors[k] = (square / (n - 1.0)).sqrt();
        let quantile = |q: f64| values[((q * (n - 1.0)).round()) as usize];
        fit.intervals[k] = [quantile(0.025), quantile(0.975)];
    }
    Ok(())
}

/// Everything that is told about a fit.
struct Report<'a> {
    file: &'a str,
    record: &'a Record,
    fit: &'a Fit,
    found: &'a Identification,
    warnings: &'a [String],
    method: Method,
    paper: Option<Fit>,
    /// Words, when the paper's procedure fits much worse than least squares.
    misses: Option<String>,
    bootstrap: Option<u32>,
    /// Of the file.
    units: Units,
}

impl Report<'_> {
    fn joint(&self) -> &Iwan {
        &self.fit.joint
    }

    /// Damping from the measured area and the fitted peak.
    fn measured_damping(&self) -> f64 {
        let a = self.record.amplitude;
        self.record.loop_area() / (std::f64::consts::TAU * a * self.fit.peak)
    }

    fn method_name(&self) -> &'static str {
        match self.method {
            Method::LeastSquares => "least squares",
            Method::Paper => "paper",
        }
    }

    fn table(&self) -> String {
        let (record, fit, joint) = (self.record, self.fit, self.joint());
        let a = record.amplitude;
        // The table is in the units of the file, all else in mm and N.
        let units = self.units;
        let (length, force) = (units.length.name(), units.force.name());
        let names = [
            force.to_string(),
            length.to_string(),
            format!("{force}/{length}"),
            String::new(),
        ];
        let mut text = format!(
            "{}: {} points on {} half cycles, amplitude {} {length} about {} {length}, mean force {} {force}\n\n",
            self.file,
            record.points(),
            record.half_cycles.len(),
            short(units.length(a)),
            beside(units.length(record.centre), units.length(a)),
            beside(units.force(fit.offset), units.force(fit.peak)),
        );
        let (values, errors_of) = (
            units.joint(joint.parameters()),
            units.joint(fit.standard_errors),
        );
        let low = units.joint(fit.intervals.map(|interval| interval[0]));
        let high = units.joint(fit.intervals.map(|interval| interval[1]));
        // The lines of the paper's procedure know nothing of how far they are off.
        let has_errors = self.method == Method::LeastSquares;
        let (errors, more) = match self.bootstrap {
            _ if !has_errors => (
                "scatter",
                "of the straight lines; there are no standard errors".to_string(),
            ),
            Some(count) => (
                "std. error",
                format!("95 % interval ({count} resampled loops)"),
            ),
            None => ("std. error", "95 % interval (linearised)".to_string()),
        };
        let _ = writeln!(
            text,
            "{:12}{:>14}{errors:>14}   {more}",
            self.method_name(),
            "value",
        );
        for k in 0..4 {
            let interval = if has_errors {
                let [low, high] = [low[k], high[k]].map(|end| with_error(end, errors_of[k]));
                format!("   {low} .. {high}")
            } else {
                String::new()
            };
            let _ = writeln!(
                text,
                "{:12}{:>14}{:>14}{interval}",
                format!("{} {}", NAMES[k], bracket(&names[k])).trim_end(),
                with_error(values[k], errors_of[k]),
                format!("{:.1e}", errors_of[k]),
            );
        }
        text += "\n";
        let measured = |value: f64| match value {
            _ if value.is_nan() => "no whole branch".to_string(),
            _ => short(value),
        };
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:38}{value}");
        };
        line("chi of the joint, 5/2 + kappa", short(joint.chi()));
        line(
            &format!("stick stiffness ({force}/{length})"),
            short(units.stiffness(joint.stick_stiffness())),
        );
        line(
            &format!("force at the amplitude T_max ({force})"),
            short(units.force(fit.peak)),
        );
        if let Some(stop) = &fit.stop {
            for (side, clearance) in ["above", "below"].into_iter().zip(stop.clearances) {
                let words = clearance.map_or("not reached".to_string(), |clearance| {
                    plus(scaled(clearance, units.length(1.0)))
                });
                line(&format!("clearance {side} the middle ({length})"), words);
            }
            line(
                &format!("stop stiffness ({force}/{length})"),
                plus(scaled(stop.stiffness, units.stiffness(1.0))),
            );
        }
        if let Some(lag) = self.found.lag {
            line("lag of the displacement (samples)", plus(lag));
        }
        line(
            &format!("loop area measured / fitted ({force}.{length})"),
            format!(
                "{} / {}",
                measured(units.energy(record.loop_area())),
                short(units.energy(joint.dissipation(a)))
            ),
        );
        line(
            "equivalent damping measured / fitted",
            format!(
                "{} / {}",
                measured(self.measured_damping()),
                short(self.fitted_damping())
            ),
        );
        line(
            &format!("residual, rms ({force})"),
            format!(
                "{} = {:.2} % of T_max",
                beside(units.force(fit.rms), units.force(fit.peak)),
                100.0 * fit.misfit()
            ),
        );
        if let Some(paper) = &self.paper {
            let values = units.joint(paper.joint.parameters()).map(short).join(", ");
            line("by the paper's procedure", values);
        }
        if let Some(misses) = &self.misses {
            let _ = writeln!(text, "\n{misses}");
        }
        if !fit.is_reliable() {
            let _ = writeln!(text, "\nnot reliable: {}", fit.reasons().join(", "));
        }
        if let Some(extended) = &self.found.extended {
            let parameters = units
                .joint(extended.fit.joint.parameters())
                .map(short)
                .join(", ");
            let what = match &extended.fit.stop {
                Some(_) if extended.effects.is_empty() => vec!["stops".to_string()],
                _ => extended
                    .effects
                    .iter()
                    .map(|(effect, size)| format!("{} {}", effect.name(), short(size.value)))
                    .collect(),
            };
            let _ = writeln!(
                text,
                "extended by {}: {} = {parameters}; residual {:.2} % of T_max",
                what.join(", "),
                NAMES.join(", "),
                100.0 * extended.fit.misfit()
            );
        }
        text
    }

    /// Damping from the fitted area and peak.
    fn fitted_damping(&self) -> f64 {
        let a = self.record.amplitude;
        self.joint().dissipation(a) / (std::f64::consts::TAU * a * self.fit.peak)
    }

    fn json(&self) -> Value {
        let (record, fit, joint) = (self.record, self.fit, self.joint());
        let a = record.amplitude;
        let by_name = |values: [Value; 4]| -> Value {
            NAMES
                .iter()
                .map(ToString::to_string)
                .zip(values)
                .collect::<serde_json::Map<_, _>>()
                .into()
        };
        let numbers = |values: [f64; 4]| by_name(values.map(|v| json!(v)));
        let errors = numbers(fit.standard_errors);
        let (errors, intervals, scatter) = match self.method {
            Method::LeastSquares => (
                errors,
                by_name(fit.intervals.map(|i| json!(i))),
                Value::Null,
            ),
            Method::Paper => (Value::Null, Value::Null, errors),
        };
        let largest = fit.residuals.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
        json!({
            "F_s": joint.force,
            "X_s": joint.displacement,
            "k_alpha": joint.residual,
            "kappa": joint.kappa,
            "chi_joint": joint.chi(),
            "units": { "length": "mm", "force": "N" },
            "method": self.method_name(),
            "model": if fit.stop.is_some() { "stop" } else { "four-parameter" },
            "reliable": fit.is_reliable(),
            "reasons": fit.reasons(),
            "warnings": self.warnings,
            "standard_errors": errors,
            "interval_95": intervals,
            "scatter_of_the_lines": scatter,
            "bootstrap": self.bootstrap,
            "amplitude": a,
            "centre": record.centre,
            "mean_force": fit.offset,
            "points": record.points(),
            "half_cycles": record.half_cycles.len(),
            "cycles": record.cycles().len(),
            "amplitude_changes": record.origin.is_some(),
            "lag": self.found.lag.map(estimate),
            "stop": fit.stop.as_ref().map(stop),
            "T_max": fit.peak,
            "stick_stiffness": joint.stick_stiffness(),
            "loop_area_measured": record.loop_area(),
            "loop_area_fitted": joint.dissipation(a),
            "damping_measured": self.measured_damping(),
            "damping_fitted": self.fitted_damping(),
            "misfit": fit.misfit(),
            "residual_rms": fit.rms,
            "residual_max": largest,
            "paper": self.paper.as_ref().map(|paper| numbers(paper.joint.parameters())),
            "extended": self.found.extended.as_ref().map(extended),
        })
    }

    fn picture(&self) -> Result<String> {
        let (record, fit) = (self.record, self.fit);
        let a = record.amplitude;
        let stop = |x: f64| fit.stop.map_or(0.0, |stop| stop.force(x));
        let fitted = |direction: Direction| {
            let path = (0..=400).map(|k| a * (f64::from(k) / 200.0 - 1.0));
            path.map(move |x| {
                let force = fit.joint.steady(a, x, direction) + stop(x) + fit.offset;
                [x + record.centre, force]
            })
        };
        let mut closed: Vec<[f64; 2]> = fitted(Direction::Loading).collect();
        let back: Vec<[f64; 2]> = fitted(Direction::Unloading).collect();
        closed.extend(back.into_iter().rev());
        let curve = |label: &str, points, stroke, colour| Curve {
            label: label.to_string(),
            points,
            stroke,
            colour,
        };
        let mut data = Vec::new();
        let mut residuals: Vec<Curve> = Vec::new();
        let mut rest = fit.residuals.as_slice();
        for branch in &record.branches {
            let (ours, others) = rest.split_at(branch.count());
            rest = others;
            let x = |index: usize| record.displacement[index];
            data.extend(branch.points().map(|i| [x(i), record.force[i]]));
            let (name, colour) = match branch.direction {
                Direction::Loading => ("loading", BLUE),
                Direction::Unloading => ("unloading", GREEN),
            };
            // One entry in the legend stands for all branches of a direction.
            let named = residuals.iter().any(|curve| curve.label == name);
            let points = branch.points().zip(ours).map(|(i, &r)| [x(i), r]);
            residuals.push(curve(
                if named { "" } else { name },
                points.collect(),
                Stroke::Solid,
                colour,
            ));
        }
        let figure = |title: String, y_label: &str, curves| Figure {
            title,
            x_label: "displacement (mm)".to_string(),
            y_label: y_label.to_string(),
            curves,
            equal_axes: false,
        };
        let values = fit.joint.parameters().map(short).join(", ");
        let flag = if fit.is_reliable() {
            ""
        } else {
            " (not reliable)"
        };
        mepc_plot::stacked(&[
            figure(
                format!("F_s, X_s, k_alpha, kappa: {values}{flag}"),
                "force (N)",
                vec![
                    curve("data", data, Stroke::Solid, GREY),
                    curve(self.method_name(), closed, Stroke::Dashed, ORANGE),
                ],
            ),
            figure(
                "Residual, data less fit".to_string(),
                "force (N)",
                residuals,
            ),
        ])
        .context("picture")
    }
}

/// In another unit, that is so many times smaller.
fn scaled(estimate: Estimate, factor: f64) -> Estimate {
    Estimate {
        value: factor * estimate.value,
        error: factor * estimate.error,
    }
}

/// A value with its standard error, for the table.
fn plus(estimate: Estimate) -> String {
    format!(
        "{} (std. error {:.1e})",
        with_error(estimate.value, estimate.error),
        estimate.error
    )
}

/// The same for JSON.
fn estimate(estimate: Estimate) -> Value {
    json!({ "value": estimate.value, "standard_error": estimate.error })
}

fn stop(stop: &Stop) -> Value {
    json!({
        "clearance_above": stop.clearances[0].map(estimate),
        "clearance_below": stop.clearances[1].map(estimate),
        "stiffness": estimate(stop.stiffness),
    })
}

/// The model with more unknowns.
fn extended(extended: &Extended) -> Value {
    let fit = &extended.fit;
    let effects = extended.effects.iter();
    let effects: serde_json::Map<String, Value> = effects
        .map(|(effect, size)| (effect.name().to_string(), estimate(*size)))
        .collect();
    let mut all = serde_json::Map::new();
    for (k, name) in NAMES.iter().enumerate() {
        all.insert(name.to_string(), json!(fit.joint.parameters()[k]));
    }
    let errors: serde_json::Map<String, Value> = NAMES
        .iter()
        .zip(fit.standard_errors)
        .map(|(name, error)| (name.to_string(), json!(error)))
        .collect();
    all.insert("standard_errors".to_string(), errors.into());
    all.insert("effects".to_string(), effects.into());
    all.insert("stop".to_string(), fit.stop.as_ref().map(stop).into());
    all.insert("misfit".to_string(), json!(fit.misfit()));
    all.into()
}

fn bracket(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!("({unit})")
    }
}
