//! `mepc calibrate`: measured loops to the properties of the contact law and the stiffness behind it.

mod sprung;

use crate::channels::Columns;
use crate::numbers::{self, exact, short};
use crate::pictures::{self, Fitted};
use crate::replay::Springs;
use crate::{Outcome, check_outputs, loops, print, say, write, wrong_use};
use anyhow::{Result, anyhow, bail};
use mepc::iwan::{CORRELATED, Fit, ILL, Record, Warning};
use serde_json::{Value, json};
use sprung::{Sprung, SprungFit};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Exponents for which the loop is fitted, beside the chosen one.
const EXPONENTS: [f64; 5] = [1.5, 2.0, 2.5, 3.0, 4.0];
/// Half of a 95 % interval in standard errors.
const LIKELY: f64 = 1.96;

/// From measured loops to the properties of the contact law (mu, gcr, chi) and the series stiffness K_e.
///
/// The joint is taken as contact of one preload behind a spring K_e (the plates), with a spring k_alpha beside (the bolt). One
/// loop gives mu P, the displacement X_s = gcr + F_s/K_e, and k_alpha; gcr and K_e come apart only through the shape of the
/// loop, and there an exponent chi must be assumed. Loops at two or more preloads separate them by the slope of X_s over F_s.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc calibrate loop.csv --preload 900 --area 361.52
  mepc calibrate p300.csv p700.csv p1100.csv --preload 300 --preload 700 --preload 1100 --area 361.52
  mepc calibrate loop.csv --preload 900 --area 361.52 --chi 2 --json")]
pub struct Arguments {
    /// Loops, CSV with a header; one per preload.
    #[arg(required = true, value_name = "LOOP.csv")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Bolt preload of each loop, in their order, N.
    #[arg(long, required = true, value_name = "N", allow_negative_numbers = true, value_parser = numbers::positive)]
    preload: Vec<f64>,
    /// Contact area, mm2.
    #[arg(long, value_name = "A", allow_negative_numbers = true, value_parser = numbers::positive)]
    area: f64,
    /// Exponent of the contact law, assumed.
    #[arg(long, default_value_t = 2.5, value_parser = exponent)]
    chi: f64,
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Draw the loops, the law's loops, and X_s over F_s into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
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
    joint: Fit,
    /// The law behind a spring, for the assumed exponent.
    sprung: SprungFit,
    /// The same for other exponents.
    others: Vec<SprungFit>,
    /// A root mean square residual up to this is as good as the best, at 95 %.
    as_good: f64,
    peak: f64,
    /// For the picture: the loop as measured, and the law's.
    drawn: Option<[Vec<[f64; 2]>; 2]>,
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
    let mut cases: Vec<Case> = arguments
        .files
        .iter()
        .zip(&arguments.preload)
        .map(|(file, &preload)| {
            let record = arguments.columns.read(file)?.record()?;
            let mut case = case(&file.display().to_string(), preload, &record, arguments.chi)?;
            if arguments.picture.is_some() {
                case.drawn = Some(drawn(&record, &case)?);
            }
            Ok(case)
        })
        .collect::<Result<_>>()?;
    let result = Calibration::new(&cases, arguments)?;
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
    Ok(if result.reliable {
        Outcome::Done
    } else {
        Outcome::Flagged
    })
}

fn case(file: &str, preload: f64, record: &Record, chi: f64) -> Result<Case> {
    let mut joint = record
        .least_squares()
        .map_err(|error| anyhow!("{file}: {}", crate::sentence(&error)))?;
    // What is said about the shape of the four-parameter model, and about its parameters, is not about the contact law.
    joint.warnings.retain(|warning| {
        let about_the_shape = matches!(
            warning,
            Warning::IllDetermined { .. } | Warning::ChiAtBound(_) | Warning::Misfit(_)
        );
        warning.is_severe() || !about_the_shape
    });
    let fit = |chi| Sprung::new(record, chi).fit(&joint);
    let sprung = fit(chi);
    let others: Vec<SprungFit> = EXPONENTS
        .into_iter()
        .filter(|c| *c != chi)
        .map(fit)
        .collect();
    let best = others.iter().map(|o| o.rms).fold(sprung.rms, f64::min);
    let peak = joint.joint.peak_force(record.amplitude);
    // Sums of squares that differ by the 95 % point of F(1, n), and what is rounding anyway.
    let as_good = best * (1.0 + 3.84 / record.points() as f64).sqrt() + 1e-6 * peak;
    Ok(Case {
        file: file.to_string(),
        preload,
        joint,
        sprung,
        others,
        as_good,
        peak,
        drawn: None,
    })
}

/// The loop as measured, and that of the law as fitted to it: displacement from the middle, force from its mean.
fn drawn(record: &Record, case: &Case) -> Result<[Vec<[f64; 2]>; 2]> {
    let indices = record
        .branches
        .iter()
        .flat_map(|b| b.points.iter().copied());
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

/// Standard error of the sum of `weights` times what each loop says. A loop is as uncertain as its own fit says, or as the loops
/// scatter about what they have in common (`residuals` of so many unknowns), whichever is more.
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
    /// Least squares through the origin for what the loops say as a multiple of `along`; the variance is that of the quantity
    /// with these derivatives.
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
        // Both X_s = gcr + F_s/K_e and F_s of a loop are uncertain: what counts is how far they lead off the line together.
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

/// The properties, and what they rest on.
struct Calibration {
    mu: Estimate,
    gcr: Estimate,
    chi: f64,
    /// K_e; None is rigid.
    series: Option<Estimate>,
    residual: Estimate,
    pressure: f64,
    /// Intercept and inverse slope of X_s over F_s, from two or more preloads.
    separated: bool,
    /// False when the properties must not be used as they are.
    reliable: bool,
    warnings: Vec<String>,
}

impl Calibration {
    fn new(cases: &[Case], arguments: &Arguments) -> Result<Self> {
        let mut warnings = Vec::new();
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
        let spread = {
            let most = arguments.preload.iter().fold(0.0, |m: f64, p| m.max(*p));
            let least = arguments
                .preload
                .iter()
                .fold(f64::INFINITY, |m, p| m.min(*p));
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
        for case in cases {
            if case.sprung.rms > case.as_good {
                warnings.push(format!(
                    "{}: chi = {} fits worse than other exponents (see the table)",
                    case.file, arguments.chi
                ));
            }
            if case.sprung.correlation > CORRELATED {
                warnings.push(format!(
                    "{}: neighbouring residuals are alike (correlation {:.2}): the loop is not quite that of a contact with \
                     chi = {} behind a spring; the standard errors are enlarged as for noise of that kind, a bias is not in them",
                    case.file, case.sprung.correlation, arguments.chi
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
        let pressure = arguments.preload.iter().sum::<f64>() / cases.len() as f64 / arguments.area;
        Ok(Calibration {
            mu,
            gcr,
            chi: arguments.chi,
            series,
            residual: Estimate::mean(cases, |s| s.residual, [0.0, 0.0, 0.0, 1.0]),
            pressure,
            separated,
            reliable: determined && cases.iter().all(|case| case.joint.is_reliable()),
            warnings,
        })
    }

    fn props(&self) -> String {
        [self.mu.value, self.gcr.value, self.chi]
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
            "from the shape of the loop, for the assumed chi"
        };
        line("gcr (mm)", short(self.gcr.value), Some(self.gcr.error), how);
        line("chi", short(self.chi), None, "assumed");
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
            "mean pressure (MPa)",
            short(self.pressure),
            None,
            "preload / area; friction depends on the preload alone",
        );
        for case in cases {
            let joint = &case.joint.joint;
            let _ = writeln!(
                text,
                "\n{}, preload {} N: F_s {} N, X_s {} mm, stick stiffness {} N/mm\n\
                 {:>8}{:>14}{:>14}{:>18}",
                case.file,
                short(case.preload),
                short(joint.force),
                short(joint.displacement),
                short(joint.stick_stiffness()),
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
                    format!("{:.4}", 100.0 * fit.rms / case.peak),
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
        if self.reliable {
            let _ = writeln!(text, "\nNext: mepc deck abaqus --props {}", self.props());
        }
        text
    }

    fn json(&self, cases: &[Case]) -> Value {
        let row = |fit: &SprungFit| json!({ "chi": fit.chi, "gcr": fit.gcr, "K_e": fit.series(), "residual_rms": fit.rms });
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
                    "reliable": case.joint.is_reliable(),
                    "warnings": case.joint.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
                    "assumed_chi": row(&case.sprung),
                    "other_chi": case.others.iter().map(row).collect::<Vec<_>>(),
                    "rms_as_good_as_the_best": case.as_good,
                })
            })
            .collect();
        json!({
            "mu": self.mu.value,
            "gcr": self.gcr.value,
            "chi": self.chi,
            "chi_is": "assumed",
            "K_e": self.series.map(|series| series.value),
            "k_alpha": self.residual.value,
            "standard_errors": {
                "mu": self.mu.error,
                "gcr": self.gcr.error,
                "K_e": self.series.map(|series| series.error),
                "k_alpha": self.residual.error,
            },
            "reliable": self.reliable,
            "mean_pressure": self.pressure,
            "gcr_and_K_e_from": if self.separated { "several preloads" } else { "shape of the loop, assumed chi" },
            "props": [self.mu.value, self.gcr.value, self.chi],
            "units": { "length": "mm", "force": "N" },
            "warnings": self.warnings,
            "loops": loops,
        })
    }
}
