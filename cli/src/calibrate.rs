//! `mepc calibrate`: measured loops to the properties of the contact law and the stiffness behind it.

mod sprung;

use crate::channels::Columns;
use crate::numbers::{self, exact, short};
use crate::pictures::{self, Fitted};
use crate::replay::Springs;
use crate::units::{Force, Length};
use crate::{Outcome, check_outputs, loops, print, say, write, wrong_use};
use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use mepc::iwan::{CORRELATED, Effect, Fit, ILL, Options, Record, Warning, identify};
use serde_json::{Value, json};
use sprung::{Sprung, SprungFit};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Exponents for which the loop is fitted, beside the chosen one.
const EXPONENTS: [f64; 5] = [1.5, 2.0, 2.5, 3.0, 4.0];
/// Half of a 95 % interval in standard errors.
const LIKELY: f64 = 1.96;
/// The exponent unless the loops say otherwise, and where theirs is looked for.
const USUAL: f64 = 2.5;
const CHI_RANGE: [f64; 2] = [1.1, 8.0];
const SECTIONS: usize = 14;
const GOLDEN: f64 = 0.618_033_988_75;
/// An exponent is another one when its sum of squares is so many variances above the least (chance: once in 1000), and
/// its residual greater by this part of T_max.
const ANOTHER: f64 = 10.8;
const MATTERS: f64 = 5e-4;
/// A lag is shown when the sum of squares without it is so many variances more.
const LAG_SHOWN: f64 = 20.0;
/// Friction coefficients outside of this are none of dry contact.
const COEFFICIENTS: [f64; 2] = [0.01, 2.0];
/// Preloads that differ by less than this part are the same.
const SAME: f64 = 0.05;
/// How gcr may move with the pressure: exponents that are tried, and how many.
const POWERS: [f64; 2] = [-1.0, 2.0];
const POWER_STEPS: usize = 300;

/// From measured loops to the properties of the contact law (mu, gcr, chi) and the series stiffness K_e.
///
/// The joint is taken as contact of one preload behind a spring K_e (the plates), with a spring k_alpha beside (the
/// bolt). One loop gives mu P, the displacement X_s = gcr + F_s/K_e, and k_alpha; gcr and K_e come apart only through
/// the shape of the loop, and there the exponent chi of the contact must be known. Loops at two or more preloads
/// separate them by the slope of X_s over F_s, and from three on they tell how gcr moves with the pressure.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc calibrate loop.csv --preload 900 --area 361.52
  mepc calibrate p300.csv p700.csv p1100.csv --preload 300 --preload 700 --preload 1100 --area 361.52
  mepc calibrate loop.csv --preload 900 --area 361.52 --chi 2 --json
  mepc calibrate loop.csv --preload .2 --preload-unit kip --area .56 --area-unit in2

Exit code 3: the properties must not be used; \"reasons\" in the JSON has them in single words: those of a loop
(mepc help identify), mu, chi, preloads, K_e.")]
pub struct Arguments {
    /// Loops, CSV with a header; one per preload.
    #[arg(required = true, value_name = "LOOP.csv")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Bolt preload of each loop, in their order.
    #[arg(long, required = true, value_name = "N", allow_negative_numbers = true, value_parser = numbers::positive)]
    preload: Vec<f64>,
    /// Unit of the preloads [default: that of --force-unit, else N].
    #[arg(long, value_name = "UNIT", value_enum)]
    preload_unit: Option<Force>,
    /// Contact area.
    #[arg(long, value_name = "A", allow_negative_numbers = true, value_parser = numbers::positive)]
    area: f64,
    /// Unit of the area [default: in2 with --displacement-unit in or mil, m2 with m, else mm2].
    #[arg(long, value_name = "UNIT", value_enum)]
    area_unit: Option<Area>,
    /// Exponent of the contact law, assumed [default: 2.5, or that of the loops where they say otherwise].
    #[arg(long, value_name = "CHI", value_parser = exponent)]
    chi: Option<f64>,
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Draw the loops, the law's loops, and X_s over F_s into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

/// A unit of area.
#[derive(Clone, Copy, ValueEnum)]
enum Area {
    Mm2,
    Cm2,
    M2,
    In2,
}

impl Arguments {
    /// The preloads in N.
    fn preloads(&self) -> Vec<f64> {
        let unit = self.preload_unit.or(self.columns.force_unit());
        let newtons = unit.unwrap_or(Force::N).size();
        self.preload.iter().map(|p| p * newtons).collect()
    }

    /// The area in mm2.
    fn area(&self) -> f64 {
        let unit = self
            .area_unit
            .unwrap_or(match self.columns.displacement_unit() {
                Some(Length::In | Length::Mil) => Area::In2,
                Some(Length::M) => Area::M2,
                _ => Area::Mm2,
            });
        self.area
            * match unit {
                Area::Mm2 => 1.0,
                Area::Cm2 => 1e2,
                Area::M2 => 1e6,
                Area::In2 => 25.4 * 25.4,
            }
    }
}

fn exponent(text: &str) -> Result<f64, String> {
    let chi = numbers::argument(text)?;
    if (1.1..=20.0).contains(&chi) {
        Ok(chi)
    } else {
        Err(format!(
            "{text} is not from 1.1 to 20 (chi = 1 has no shape to tell gcr and K_e apart)"
        ))
    }
}

/// One loop and what was found in it.
struct Case {
    file: String,
    preload: f64,
    record: Record,
    joint: Fit,
    /// The law behind a spring, for the exponent that is used.
    sprung: SprungFit,
    /// The same for other exponents.
    others: Vec<SprungFit>,
    /// A root mean square residual up to this is as good as the best, at 95 %.
    as_good: f64,
    /// For the picture: the loop as measured, and the law's.
    drawn: Option<[Vec<[f64; 2]>; 2]>,
}

/// Where the exponent comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Source {
    Given,
    Usual,
    Identified,
}

/// The exponent of the contact.
#[derive(Clone, Copy)]
struct Exponent {
    used: f64,
    source: Source,
    /// That of the least sum of squares over all loops.
    identified: f64,
    /// Whether the one that is used fits as well.
    fits: bool,
}

/// Runs the command.
///
/// # Errors
/// Bad input.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    if arguments.files.len() != arguments.preload.len() {
        return Err(wrong_use(format!(
            "--preload: {} loops and {} preloads, one is needed for each",
            arguments.files.len(),
            arguments.preload.len()
        )));
    }
    let inputs: Vec<&Path> = arguments.files.iter().map(PathBuf::as_path).collect();
    check_outputs(&[("--picture", arguments.picture.as_deref())], &inputs)?;
    let loops: Vec<(String, Record, Fit)> = arguments
        .files
        .iter()
        .map(|file| {
            let name = file.display().to_string();
            let record = arguments.columns.read(file)?.record()?;
            let (record, fit) =
                judged(record).map_err(|error| anyhow!("{name}: {}", crate::sentence(&error)))?;
            Ok((name, record, fit))
        })
        .collect::<Result<_>>()?;
    let exponent = exponent_of(&loops, arguments.chi);
    let mut cases: Vec<Case> = loops
        .into_iter()
        .zip(arguments.preloads())
        .map(|((file, record, joint), preload)| case(file, preload, record, joint, exponent.used))
        .collect();
    if arguments.picture.is_some() {
        for case in &mut cases {
            case.drawn = Some(drawn(&case.record, case)?);
        }
    }
    let result = Calibration::new(&cases, arguments, exponent)?;
    for case in &cases {
        for warning in &case.joint.warnings {
            say(&format!("{}: warning: {warning}", case.file));
        }
    }
    for warning in &result.warnings {
        say(&format!("warning: {warning}"));
    }
    if let Some(file) = &arguments.picture {
        let loops = cases.iter_mut().filter_map(|case| {
            let [data, law] = case.drawn.take()?;
            Some(Fitted {
                label: format!("law, {} N", short(case.preload)),
                data,
                law,
                slip: [case.sprung.force, case.sprung.displacement()],
            })
        });
        let compliance = result.series.map_or(0.0, |series| 1.0 / series.value);
        let svg = pictures::calibration(loops.collect(), result.gcr.value, compliance)?;
        write(Some(file), &svg)?;
    }
    if arguments.json {
        print(&format!("{:#}\n", result.json(&cases)))?;
    } else {
        print(&result.table(&cases))?;
    }
    Ok(if result.reasons.is_empty() {
        Outcome::Done
    } else {
        Outcome::Flagged
    })
}

/// A loop as [`identify`] judges it. A contact behind a spring is not quite a joint of four parameters, and a lag may
/// seem to make up for that: it is taken out only where such a contact does not describe the loop as well.
fn judged(record: Record) -> Result<(Record, Fit), mepc::Error> {
    let found = identify(record.clone(), &Options::default())?;
    if found.lag.is_none() {
        return Ok((found.record, found.fit));
    }
    let options = Options {
        lag: Some(0.0),
        ..Options::default()
    };
    let mut with_lag = identify(record, &options)?;
    let contact = EXPONENTS
        .map(|chi| Sprung::new(&with_lag.record, chi).mean_square(&with_lag.fit))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let shown = 1.0 + LAG_SHOWN / with_lag.record.points() as f64;
    if contact > shown * found.fit.rms.powi(2) {
        return Ok((found.record, found.fit));
    }
    with_lag.fit.warnings.retain(|warning| {
        !matches!(
            warning,
            Warning::LeftOut {
                effect: Effect::Lag,
                ..
            }
        )
    });
    Ok((with_lag.record, with_lag.fit))
}

/// The exponent that is asked for, or the usual one if the loops allow it, or theirs.
fn exponent_of(loops: &[(String, Record, Fit)], given: Option<f64>) -> Exponent {
    // Sum of squares over the variance of the loops: their four-parameter fits are as free in shape.
    let sum = |chi: f64| -> f64 {
        let each = loops.iter().map(|(_, record, joint)| {
            let square = Sprung::new(record, chi).mean_square(joint);
            let floor = (MATTERS * joint.peak).powi(2);
            square * record.points() as f64 / joint.rms.powi(2).max(floor)
        });
        each.sum()
    };
    let used = given.unwrap_or(USUAL);
    let at_used = sum(used);
    let [mut low, mut high] = CHI_RANGE.map(f64::ln);
    let at = |log: f64| sum(log.exp());
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_a, mut at_b) = (at(a), at(b));
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - GOLDEN * (high - low);
            at_a = at(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + GOLDEN * (high - low);
            at_b = at(b);
        }
    }
    let (best, least) = if at_a < at_b { (a, at_a) } else { (b, at_b) };
    let (identified, least) = if at_used < least {
        (used, at_used)
    } else {
        (best.exp(), least)
    };
    let matters = loops.iter().any(|(_, record, joint)| {
        let [worse, better] =
            [used, identified].map(|chi| Sprung::new(record, chi).mean_square(joint));
        (worse - better).max(0.0).sqrt() > MATTERS * joint.peak
    });
    let fits = at_used - least <= ANOTHER || !matters;
    let (used, source) = match given {
        Some(given) => (given, Source::Given),
        None if fits => (USUAL, Source::Usual),
        None => (identified, Source::Identified),
    };
    Exponent {
        used,
        source,
        identified,
        fits: fits || source == Source::Identified,
    }
}

fn case(file: String, preload: f64, record: Record, mut joint: Fit, chi: f64) -> Case {
    // What is said about the shape of the four-parameter model, and about its parameters, is not about the contact law.
    joint.warnings.retain(|warning| {
        !matches!(
            warning,
            Warning::IllDetermined { .. } | Warning::ChiAtBound(_) | Warning::Correlated(_)
        )
    });
    let fit = |chi| Sprung::new(&record, chi).fit(&joint);
    let sprung = fit(chi);
    let others: Vec<SprungFit> = EXPONENTS
        .into_iter()
        .filter(|c| *c != chi)
        .map(fit)
        .collect();
    let best = others.iter().map(|o| o.rms).fold(sprung.rms, f64::min);
    // Sums of squares that differ by the 95 % point of F(1, n), and what is rounding anyway.
    let as_good = best * (1.0 + 3.84 / record.points() as f64).sqrt() + 1e-6 * joint.peak;
    Case {
        file,
        preload,
        record,
        joint,
        sprung,
        others,
        as_good,
        drawn: None,
    }
}

/// The loop as measured, and that of the law as fitted to it: displacement from the middle, force from its mean.
fn drawn(record: &Record, case: &Case) -> Result<[Vec<[f64; 2]>; 2]> {
    let indices = record.branches.iter().flat_map(|b| b.points());
    let data = indices.map(|i| {
        [
            record.displacement[i] - record.centre,
            record.force[i] - case.joint.offset,
        ]
    });
    let sprung = &case.sprung;
    let springs = Springs {
        series: sprung.series(),
        parallel: sprung.residual,
    };
    let props = [sprung.force / case.preload, sprung.gcr, sprung.chi];
    let law = loops::contact_loop(&props, case.preload, springs, record.amplitude)?;
    Ok([data.collect(), law])
}

/// Standard error of the sum of `weights` times what each loop says. A loop is as uncertain as its own fit says, or as
/// the loops scatter about what they have in common (`residuals` of so many unknowns), whichever is more.
fn standard_error(weights: &[f64], variances: &[f64], residuals: &[f64], unknowns: usize) -> f64 {
    let scatter = match residuals.len().saturating_sub(unknowns) {
        0 => 0.0,
        free => residuals.iter().map(|r| r * r).sum::<f64>() / free as f64,
    };
    let parts = weights.iter().zip(variances);
    parts
        .map(|(weight, variance)| weight * weight * variance.max(scatter))
        .sum::<f64>()
        .sqrt()
}

/// A value and its standard error.
#[derive(Clone, Copy)]
struct Estimate {
    value: f64,
    error: f64,
}

impl Estimate {
    /// Least squares through the origin for what the loops say as a multiple of `along`; the variance is that of the
    /// quantity with these derivatives.
    fn multiple(
        cases: &[Case],
        along: fn(&Case) -> f64,
        of: fn(&SprungFit) -> f64,
        derivatives: [f64; 4],
    ) -> Self {
        let square: f64 = cases.iter().map(|c| along(c).powi(2)).sum();
        let weights: Vec<f64> = cases.iter().map(|c| along(c) / square).collect();
        let values = cases.iter().map(|c| of(&c.sprung));
        let value: f64 = weights.iter().zip(values).map(|(w, v)| w * v).sum();
        let residuals = cases.iter().map(|c| of(&c.sprung) - value * along(c));
        let variances = cases.iter().map(|c| c.sprung.variance(derivatives));
        let (residuals, variances): (Vec<_>, Vec<_>) = residuals.zip(variances).unzip();
        Estimate {
            value,
            error: standard_error(&weights, &variances, &residuals, 1),
        }
    }

    /// F_s = mu P.
    fn friction(cases: &[Case]) -> Self {
        Self::multiple(cases, |c| c.preload, |s| s.force, [1.0, 0.0, 0.0, 0.0])
    }

    fn mean(cases: &[Case], of: fn(&SprungFit) -> f64, derivatives: [f64; 4]) -> Self {
        Self::multiple(cases, |_| 1.0, of, derivatives)
    }

    /// Intercept and slope of X_s over F_s: gcr and 1/K_e. Not finite when the forces are the same.
    fn line(cases: &[Case]) -> [Self; 2] {
        let count = cases.len() as f64;
        let mean = |of: &dyn Fn(&SprungFit) -> f64| {
            cases.iter().map(|c| of(&c.sprung)).sum::<f64>() / count
        };
        let (force, displacement) = (mean(&|s| s.force), mean(&SprungFit::displacement));
        let square = count * mean(&|s| (s.force - force).powi(2));
        let weights: Vec<f64> = cases
            .iter()
            .map(|c| (c.sprung.force - force) / square)
            .collect();
        let displacements = cases.iter().map(|c| c.sprung.displacement());
        let slope = weights.iter().zip(displacements).map(|(w, x)| w * x).sum();
        let intercept = displacement - slope * force;
        let residuals: Vec<f64> = cases
            .iter()
            .map(|c| c.sprung.displacement() - intercept - slope * c.sprung.force)
            .collect();
        // Both X_s = gcr + F_s/K_e and F_s of a loop are uncertain: what counts is how far they lead off the line
        // together.
        let variances: Vec<f64> = cases
            .iter()
            .map(|Case { sprung, .. }| {
                sprung.variance([sprung.compliance - slope, 1.0, sprung.force, 0.0])
            })
            .collect();
        let at_zero: Vec<f64> = weights.iter().map(|w| 1.0 / count - force * w).collect();
        [(intercept, at_zero), (slope, weights)].map(|(value, weights)| Estimate {
            value,
            error: standard_error(&weights, &variances, &residuals, 2),
        })
    }
}

/// How gcr moves with the pressure: X_s = gcr (p/p0)^power + F_s/K_e.
struct Power {
    best: f64,
    /// Powers that the loops allow at 95 %; an end of what was tried is none.
    interval: [Option<f64>; 2],
    /// Whether the loops allow the constant gcr, and the consistent rule's power 1/chi.
    constant: bool,
    consistent: bool,
    /// gcr at the mean pressure and K_e by the consistent rule.
    by_rule: [f64; 2],
}

impl Power {
    /// Of three loops at least.
    fn new(cases: &[Case], chi: f64) -> Option<Self> {
        if cases.len() < 3 {
            return None;
        }
        let mean = cases.iter().map(|c| c.preload).sum::<f64>() / cases.len() as f64;
        // The best gcr and 1/K_e for a power, with the sum of squares over the variances of X_s.
        let at = |power: f64| -> (f64, [f64; 2]) {
            let rows: Vec<[f64; 4]> = cases
                .iter()
                .map(|case| {
                    let one = &case.sprung;
                    let variance = one.variance([one.compliance, 1.0, one.force, 0.0]);
                    let weight = 1.0 / variance.max(1e-12 * one.displacement().powi(2));
                    let grown = (case.preload / mean).powf(power);
                    [weight, grown, one.force, one.displacement()]
                })
                .collect();
            let sum =
                |of: &dyn Fn(&[f64; 4]) -> f64| rows.iter().map(|r| r[0] * of(r)).sum::<f64>();
            let [aa, ab, bb] = [
                sum(&|r| r[1] * r[1]),
                sum(&|r| r[1] * r[2]),
                sum(&|r| r[2] * r[2]),
            ];
            let [ay, by] = [sum(&|r| r[1] * r[3]), sum(&|r| r[2] * r[3])];
            let determinant = aa * bb - ab * ab;
            let gcr = (ay * bb - by * ab) / determinant;
            let compliance = (by * aa - ay * ab) / determinant;
            let left = sum(&|r| (r[3] - gcr * r[1] - compliance * r[2]).powi(2));
            (left, [gcr, compliance])
        };
        let power = |k: usize| POWERS[0] + (POWERS[1] - POWERS[0]) * k as f64 / POWER_STEPS as f64;
        let sums: Vec<f64> = (0..=POWER_STEPS).map(|k| at(power(k)).0).collect();
        // At power 1 gcr moves as F_s does, and nothing tells it from the spring.
        let finite = |k: &usize| sums[*k].is_finite();
        let best = (0..=POWER_STEPS)
            .filter(finite)
            .min_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
        let likely = |sum: f64| sum - sums[best] <= LIKELY * LIKELY;
        let ends = [
            (0..=best).rev().take_while(|&k| likely(sums[k])).last(),
            (best..=POWER_STEPS).take_while(|&k| likely(sums[k])).last(),
        ];
        let (consistent, [gcr, compliance]) = at(1.0 / chi);
        Some(Power {
            best: power(best),
            interval: ends.map(|end| {
                let end = end.filter(|&k| k > 0 && k < POWER_STEPS);
                end.map(power)
            }),
            constant: likely(at(0.0).0),
            consistent: likely(consistent),
            by_rule: [gcr, 1.0 / compliance],
        })
    }
}

/// The properties, and what they rest on.
struct Calibration {
    mu: Estimate,
    gcr: Estimate,
    chi: Exponent,
    power: Option<Power>,
    /// K_e; None is rigid.
    series: Option<Estimate>,
    residual: Estimate,
    preloads: f64,
    area: f64,
    /// Mean pressure of the preloads: the reference pressure of the law.
    pressure: f64,
    /// Intercept and inverse slope of X_s over F_s, from two or more preloads.
    separated: bool,
    /// Why the properties must not be used as they are.
    reasons: Vec<&'static str>,
    warnings: Vec<String>,
}

impl Calibration {
    fn new(cases: &[Case], arguments: &Arguments, chi: Exponent) -> Result<Self> {
        let mut warnings = Vec::new();
        let mut reasons = Vec::new();
        for reason in cases.iter().flat_map(|case| case.joint.reasons()) {
            // The contact behind a spring has a shape of its own.
            if reason != "bound" && !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
        let mu = Estimate::friction(cases);
        if cases.len() > 1 {
            for case in cases {
                let one = case.sprung.force / case.preload;
                if (one / mu.value - 1.0).abs() > 0.05 {
                    warnings.push(format!(
                        "{}: F_s/P = {one:.3}, all loops together {:.3}: mu depends on the preload, or a preload is wrong",
                        case.file, mu.value
                    ));
                }
            }
        }
        let [least, most] = COEFFICIENTS;
        if !(least..=most).contains(&mu.value) {
            reasons.push("mu");
            warnings.push(format!(
                "mu = {} is not from {least} to {most}: are preload ({} N) and force in the right units?",
                short(mu.value),
                short(cases[0].preload)
            ));
        }
        let crossed = cases.iter().enumerate().find_map(|(k, a)| {
            let others = cases[k + 1..].iter();
            let mut against = others.filter(|b| {
                let more = b.preload / a.preload - 1.0;
                more.abs() > SAME && more * (b.sprung.force - a.sprung.force) < 0.0
            });
            against.next().map(|b| (a, b))
        });
        if let Some((a, b)) = crossed {
            reasons.push("preloads");
            warnings.push(format!(
                "{} and {}: preloads {} and {} N, but F_s = {} and {} N: friction grows with the preload; are the preloads in the \
                 order of the files?",
                a.file,
                b.file,
                short(a.preload),
                short(b.preload),
                short(a.sprung.force),
                short(b.sprung.force)
            ));
        }
        let spread = {
            let most = cases.iter().map(|c| c.preload).fold(0.0, f64::max);
            let least = cases
                .iter()
                .map(|c| c.preload)
                .fold(f64::INFINITY, f64::min);
            most / least
        };
        let separated = cases.len() > 1 && spread > 1.2;
        let [gcr, compliance] = if separated {
            Estimate::line(cases)
        } else {
            if cases.len() > 1 {
                warnings.push(
                    "the preloads are too close to separate gcr and K_e: means over the loops are given".to_string(),
                );
            }
            [
                Estimate::mean(cases, |s| s.gcr, [0.0, 1.0, 0.0, 0.0]),
                Estimate::mean(cases, |s| s.compliance, [0.0, 0.0, 1.0, 0.0]),
            ]
        };
        // Of a joint, gcr is above zero and 1/K_e not below; the comparisons are false for what is not a number.
        let determined = gcr.value > LIKELY * gcr.error
            && compliance.value
                >= -LIKELY * compliance.error - 1e-6 * gcr.value / cases[0].sprung.force;
        if separated && !determined {
            let list = |of: &dyn Fn(&Case) -> f64| {
                let values: Vec<String> = cases.iter().map(|case| short(of(case))).collect();
                values.join(", ")
            };
            let line = if gcr.value.is_finite() {
                format!(
                    "; the line through them gives gcr = {} mm with a standard error of {} mm",
                    short(gcr.value),
                    short(gcr.error)
                )
            } else {
                String::new()
            };
            bail!(
                "the loops do not separate contact and elastic compliance: at the preloads {} N they have F_s = {} N and \
                 X_s = {} mm, where F_s = mu P grows with the preload, and X_s = gcr + F_s/K_e with F_s{line}",
                list(&|c| c.preload),
                list(&|c| c.sprung.force),
                list(&|c| c.sprung.displacement()),
            );
        }
        let says = format!(
            "chi = {} of the contact fits worse than chi = {}",
            short(chi.used),
            short(chi.identified)
        );
        match chi.source {
            Source::Given if !chi.fits => {
                reasons.push("chi");
                warnings.push(format!("{says}, which the loops have (see the table)"));
            }
            Source::Identified => warnings.push(format!(
                "chi = {USUAL} of the contact fits worse than chi = {}, which is taken from the loops",
                short(chi.identified)
            )),
            _ => {}
        }
        for case in cases {
            if case.sprung.correlation > CORRELATED {
                warnings.push(format!(
                    "{}: neighbouring residuals are alike (correlation {:.2}): the loop is not quite that of a contact with \
                     chi = {} behind a spring; the standard errors are enlarged as for noise of that kind, a bias is not in them",
                    case.file,
                    case.sprung.correlation,
                    short(chi.used)
                ));
            }
        }
        let force = cases.iter().map(|c| c.sprung.force).fold(0.0, f64::max);
        // A compliance that is rounding against the whole displacement is a rigid body.
        let series = (compliance.value * force > 1e-6 * gcr.value.abs()).then(|| Estimate {
            value: 1.0 / compliance.value,
            error: compliance.error / compliance.value.powi(2),
        });
        let ill = |name: &str, estimate: Estimate| {
            let part = estimate.error / estimate.value;
            (part > ILL).then(|| {
                format!(
                    "{name} is ill-determined: standard error {:.0} %",
                    100.0 * part
                )
            })
        };
        warnings.extend(ill("mu", mu));
        warnings.extend(ill("gcr", gcr));
        match series {
            Some(series) => warnings.extend(ill("K_e", series)),
            None if compliance.error * force > ILL * gcr.value => warnings.push(format!(
                "K_e is ill-determined: anything above {} N/mm is likely",
                short(1.0 / (compliance.value + LIKELY * compliance.error))
            )),
            None => {}
        }
        if let Some(series) = series.filter(|series| series.error > series.value) {
            reasons.push("K_e");
            warnings.push(format!(
                "K_e = {} N/mm has a standard error of {:.0} %: the loops say nothing of it, and gcr with it",
                short(series.value),
                100.0 * series.error / series.value
            ));
        }
        if !determined && reasons.is_empty() {
            reasons.push("undetermined");
        }
        let power = Power::new(cases, chi.used).filter(|_| separated);
        let preloads = cases.iter().map(|c| c.preload).sum::<f64>() / cases.len() as f64;
        Ok(Calibration {
            mu,
            gcr,
            chi,
            power,
            series,
            residual: Estimate::mean(cases, |s| s.residual, [0.0, 0.0, 0.0, 1.0]),
            preloads,
            area: arguments.area(),
            pressure: preloads / arguments.area(),
            separated,
            reasons,
            warnings,
        })
    }

    /// mu, gcr, exponent, method 0 (memory), reference pressure.
    fn properties(&self) -> [f64; 5] {
        [
            self.mu.value,
            self.gcr.value,
            self.chi.used,
            0.0,
            self.pressure,
        ]
    }

    fn props(&self) -> String {
        self.properties()
            .map(|value| exact(numbers::read(&short(value)).unwrap_or(value)))
            .join(",")
    }

    fn table(&self, cases: &[Case]) -> String {
        let mut text = format!("{:28}{:>12}{:>12}\n", "", "value", "std. error");
        let mut line = |name: &str, value: String, error: Option<f64>, why: &str| {
            let error = error.map_or(String::new(), |error| format!("{error:.1e}"));
            let _ = writeln!(text, "{name:28}{value:>12}{error:>12}   {why}");
        };
        line(
            "mu",
            short(self.mu.value),
            Some(self.mu.error),
            "F_s / preload: the loop gives F_s, mu is as good as the preload",
        );
        let how = if self.separated {
            "X_s over F_s at the preloads: intercept"
        } else {
            "from the shape of the loop, for this chi"
        };
        line("gcr (mm)", short(self.gcr.value), Some(self.gcr.error), how);
        let how = match self.chi.source {
            Source::Given => "of the contact: assumed",
            Source::Usual => "of the contact: the usual one, the loops allow it",
            Source::Identified => "of the contact: the one that fits the loops best",
        };
        line("chi", short(self.chi.used), None, how);
        let how = if self.separated {
            "X_s over F_s at the preloads: 1 / slope"
        } else {
            "what is left of X_s: F_s / (X_s - gcr)"
        };
        line(
            "series K_e (N/mm)",
            self.series.map_or("rigid".to_string(), |s| short(s.value)),
            self.series.map(|s| s.error),
            how,
        );
        line(
            "parallel k_alpha (N/mm)",
            short(self.residual.value),
            Some(self.residual.error),
            "stiffness in gross slip",
        );
        line(
            "reference pressure (MPa)",
            short(self.pressure),
            None,
            &format!(
                "mean preload {} N / area {} mm2",
                short(self.preloads),
                short(self.area)
            ),
        );
        if let Some(power) = &self.power {
            let [low, high] = power
                .interval
                .map(|end| end.map_or("open".to_string(), |end| format!("{end:.2}")));
            line(
                "power of gcr over pressure",
                format!("{:.2}", power.best),
                None,
                &format!(
                    "95 %: {low} .. {high}; the law has 1/chi = {:.2}, which the loops {}",
                    1.0 / self.chi.used,
                    if power.consistent {
                        "allow"
                    } else {
                        "do not allow: gcr holds at the reference pressure"
                    }
                ),
            );
        }
        for case in cases {
            let joint = &case.joint.joint;
            let _ = writeln!(
                text,
                "\n{}, preload {} N: F_s {} N, X_s {} mm, stick stiffness {} N/mm, chi of the joint {}\n\
                 {:>8}{:>14}{:>14}{:>18}",
                case.file,
                short(case.preload),
                short(joint.force),
                short(joint.displacement),
                short(joint.stick_stiffness()),
                short(joint.chi()),
                "chi",
                "gcr (mm)",
                "K_e (N/mm)",
                "rms (% of T_max)"
            );
            let mut fits: Vec<&SprungFit> = case.others.iter().chain([&case.sprung]).collect();
            fits.sort_by(|a, b| a.chi.total_cmp(&b.chi));
            for fit in fits {
                let note = if fit.rms <= case.as_good {
                    "   fits as well as any"
                } else {
                    ""
                };
                let _ = writeln!(
                    text,
                    "{:>8}{:>14}{:>14}{:>18}{note}",
                    short(fit.chi),
                    short(fit.gcr),
                    fit.series().map_or("rigid".to_string(), short),
                    format!("{:.4}", 100.0 * fit.rms / case.joint.peak),
                );
            }
        }
        text += if self.separated {
            "\nThe slope of X_s = gcr + F_s/K_e over F_s separates gcr and K_e; chi is still seen in the shape only (rms).\n"
        } else {
            "\nRows that fit as well cannot be told apart by this loop, and rows whose rms differ by less than what the model \
             leaves out\nshould not. A second loop at another preload separates gcr (constant) from F_s/K_e (grows with the \
             preload).\n"
        };
        if self.reasons.is_empty() {
            let _ = writeln!(text, "\nNext: mepc deck abaqus --props {}", self.props());
        } else {
            let _ = writeln!(text, "\nnot reliable: {}", self.reasons.join(", "));
        }
        text
    }

    fn json(&self, cases: &[Case]) -> Value {
        let row = |fit: &SprungFit| json!({ "chi_contact": fit.chi, "gcr": fit.gcr, "K_e": fit.series(), "residual_rms": fit.rms });
        let loops: Vec<Value> = cases
            .iter()
            .map(|case| {
                let joint = &case.joint.joint;
                json!({
                    "file": case.file,
                    "preload": case.preload,
                    "F_s": joint.force,
                    "X_s": joint.displacement,
                    "k_alpha": joint.residual,
                    "kappa": joint.kappa,
                    "chi_joint": joint.chi(),
                    "points": case.record.points(),
                    "reliable": case.joint.is_reliable(),
                    "reasons": case.joint.reasons(),
                    "warnings": case.joint.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
                    "used_chi": row(&case.sprung),
                    "other_chi": case.others.iter().map(row).collect::<Vec<_>>(),
                    "rms_as_good_as_the_best": case.as_good,
                })
            })
            .collect();
        json!({
            "mu": self.mu.value,
            "gcr": self.gcr.value,
            "chi_contact": self.chi.used,
            "chi_is": match self.chi.source {
                Source::Given => "assumed",
                Source::Usual => "usual",
                Source::Identified => "identified",
            },
            "chi_identified": self.chi.identified,
            "K_e": self.series.map(|series| series.value),
            "k_alpha": self.residual.value,
            "standard_errors": {
                "mu": self.mu.error,
                "gcr": self.gcr.error,
                "K_e": self.series.map(|series| series.error),
                "k_alpha": self.residual.error,
            },
            "reliable": self.reasons.is_empty(),
            "reasons": self.reasons,
            "reference_pressure": self.pressure,
            "gcr_over_pressure": self.power.as_ref().map(|power| json!({
                "power": power.best,
                "interval_95": power.interval,
                "constant_gcr_fits": power.constant,
                "consistent_rule_fits": power.consistent,
                "consistent_rule": { "gcr": power.by_rule[0], "K_e": power.by_rule[1] },
            })),
            "gcr_and_K_e_from": if self.separated { "several preloads" } else { "shape of the loop" },
            "props": self.properties(),
            "units": { "length": "mm", "force": "N" },
            "warnings": self.warnings,
            "loops": loops,
        })
    }
}
