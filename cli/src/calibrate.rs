//! `mepc calibrate`: measured loops to the properties of the contact law and the stiffness behind it.

mod sprung;

use crate::identify::Columns;
use crate::numbers::{self, exact, short};
use crate::{Outcome, print, say};
use anyhow::{Result, anyhow, bail};
use mepc::iwan::{Fit, Record};
use serde_json::{Value, json};
use sprung::{Sprung, SprungFit};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Exponents for which the loop is fitted, beside the chosen one.
const EXPONENTS: [f64; 5] = [1.5, 2.0, 2.5, 3.0, 4.0];

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
}

/// Runs the command.
///
/// # Errors
/// Bad input.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    if arguments.files.len() != arguments.preload.len() {
        bail!(
            "--preload: {} loops and {} preloads, one is needed for each",
            arguments.files.len(),
            arguments.preload.len()
        );
    }
    let cases: Vec<Case> = arguments
        .files
        .iter()
        .zip(&arguments.preload)
        .map(|(file, &preload)| {
            let record = arguments.columns.read(file)?;
            case(&file.display().to_string(), preload, &record, arguments.chi)
        })
        .collect::<Result<_>>()?;
    let result = Calibration::new(&cases, arguments);
    for case in &cases {
        for warning in &case.joint.warnings {
            say(&format!("{}: warning: {warning}", case.file));
        }
    }
    for warning in &result.warnings {
        say(&format!("warning: {warning}"));
    }
    if arguments.json {
        print(&format!("{:#}\n", result.json(&cases)))?;
    } else {
        print(&result.table(&cases))?;
    }
    Ok(if cases.iter().all(|case| case.joint.is_reliable()) {
        Outcome::Done
    } else {
        Outcome::Flagged
    })
}

fn case(file: &str, preload: f64, record: &Record, chi: f64) -> Result<Case> {
    let joint = record
        .least_squares()
        .map_err(|error| anyhow!("{file}: {}", error.message))?;
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
    })
}

/// The properties, and what they rest on.
struct Calibration {
    mu: f64,
    gcr: f64,
    chi: f64,
    series: Option<f64>,
    residual: f64,
    pressure: f64,
    /// Intercept and inverse slope of X_s over F_s, from two or more preloads.
    separated: bool,
    warnings: Vec<String>,
}

impl Calibration {
    fn new(cases: &[Case], arguments: &Arguments) -> Self {
        let mut warnings = Vec::new();
        let sum = |f: &dyn Fn(&Case) -> f64| cases.iter().map(f).sum::<f64>();
        let count = cases.len() as f64;
        // Least squares through the origin: F_s = mu P.
        let mu = sum(&|c| c.sprung.force * c.preload) / sum(&|c| c.preload * c.preload);
        if cases.len() > 1 {
            for case in cases {
                let one = case.sprung.force / case.preload;
                if (one / mu - 1.0).abs() > 0.05 {
                    warnings.push(format!(
                        "{}: F_s/P = {one:.3}, the others say {mu:.3}: mu depends on the preload, or a preload is wrong",
                        case.file
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
        let (gcr, compliance) = if separated {
            let (f, x) = (
                sum(&|c| c.sprung.force) / count,
                sum(&|c| c.sprung.displacement()) / count,
            );
            let slope = sum(&|c| (c.sprung.force - f) * (c.sprung.displacement() - x))
                / sum(&|c| (c.sprung.force - f).powi(2));
            (x - slope * f, slope)
        } else {
            if cases.len() > 1 {
                warnings.push(
                    "the preloads are too close to separate gcr and K_e: means over the loops are given".to_string(),
                );
            }
            (
                sum(&|c| c.sprung.gcr) / count,
                sum(&|c| c.sprung.compliance) / count,
            )
        };
        if gcr <= 0.0 || compliance < 0.0 {
            warnings.push(format!(
                "X_s over F_s gives gcr = {} mm and 1/K_e = {compliance:e} mm/N: the loops are not those of one joint",
                short(gcr)
            ));
        }
        for case in cases {
            if !separated && case.sprung.rms > case.as_good {
                warnings.push(format!(
                    "{}: chi = {} fits worse than other exponents (see the table)",
                    case.file, arguments.chi
                ));
            }
        }
        Calibration {
            mu,
            gcr,
            chi: arguments.chi,
            // A compliance that is rounding against the whole displacement is a rigid body.
            series: (compliance * cases[0].sprung.force > 1e-6 * gcr.abs())
                .then(|| 1.0 / compliance),
            residual: sum(&|c| c.sprung.residual) / count,
            pressure: sum(&|c| c.preload) / count / arguments.area,
            separated,
            warnings,
        }
    }

    fn props(&self) -> String {
        [self.mu, self.gcr, self.chi]
            .map(|value| exact(numbers::read(&short(value)).unwrap_or(value)))
            .join(",")
    }

    fn series_words(&self) -> String {
        self.series.map_or("rigid".to_string(), short)
    }

    fn table(&self, cases: &[Case]) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String, why: &str| {
            let _ = writeln!(text, "{name:28}{value:>12}   {why}");
        };
        line(
            "mu",
            short(self.mu),
            "F_s / preload: the loop gives F_s, mu is as good as the preload",
        );
        let how = if self.separated {
            "X_s over F_s at the preloads: intercept"
        } else {
            "from the shape of the loop, for the assumed chi"
        };
        line("gcr (mm)", short(self.gcr), how);
        line("chi", short(self.chi), "assumed");
        let how = if self.separated {
            "X_s over F_s at the preloads: 1 / slope"
        } else {
            "what is left of X_s: F_s / (X_s - gcr)"
        };
        line("series K_e (N/mm)", self.series_words(), how);
        line(
            "parallel k_alpha (N/mm)",
            short(self.residual),
            "stiffness in gross slip",
        );
        line(
            "mean pressure (MPa)",
            short(self.pressure),
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
        let _ = writeln!(text, "\nNext: mepc deck abaqus --props {}", self.props());
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
            "mu": self.mu,
            "gcr": self.gcr,
            "chi": self.chi,
            "chi_is": "assumed",
            "K_e": self.series,
            "k_alpha": self.residual,
            "mean_pressure": self.pressure,
            "gcr_and_K_e_from": if self.separated { "several preloads" } else { "shape of the loop, assumed chi" },
            "props": [self.mu, self.gcr, self.chi],
            "units": { "length": "mm", "force": "N" },
            "warnings": self.warnings,
            "loops": loops,
        })
    }
}
