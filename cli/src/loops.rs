//! `mepc loop`: from parameters to loops, energy per cycle and damping.

use crate::numbers::{self, exact, short};
use crate::pictures::{figure, style};
use crate::props::Props;
use crate::replay::{Motion, Patch, Points, Springs};
use crate::table::csv_line;
use crate::{Outcome, check_outputs, print, props, write};
use anyhow::{Result, anyhow, bail, ensure};
use clap::ArgAction;
use mepc::iwan::{Direction, Iwan};
use mepc::{Law, Properties, Vector, default_state_size};
use mepc_plot::{BLUE, Curve, Figure, ORANGE, Stroke};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

/// From parameters to steady loops, energy per cycle and damping against amplitude.
///
/// The loops go to --output (CSV: amplitude,displacement,force; first loading is left out), the energies to standard output, or
/// the other way round: without --output the loops go to standard output and the energies to standard error. Any consistent units;
/// pictures name mm and N.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc loop --iwan 266.78,0.0041,3280.7,-0.842 --amplitude 0.005,0.01,0.02 --output loops.csv --picture loops.svg
  mepc loop --props mu=.3,gcr=.00268 --preload 900 --series 178e3 --parallel 3.3e3 --amplitude 0.02
  mepc loop --props mu=.3,gcr=.002 --preload 900 --amplitude 0.001 --noise 0.01 --seed 7

A reference pressure, if one is given, is here a force on the whole contact, as the preload is.")]
#[command(group = clap::ArgGroup::new("model").required(true).args(["iwan", "props"]))]
pub struct Arguments {
    /// The joint as a whole.
    #[arg(long, value_name = "F_s,X_s,k_alpha,kappa", allow_hyphen_values = true, value_parser = joint)]
    iwan: Option<Iwan>,
    #[arg(long, value_name = "mu,gcr,..", allow_hyphen_values = true, value_parser = props::read, help = props::HELP,
        requires = "preload")]
    props: Option<Props>,
    /// Normal force on the contact (with --props).
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = numbers::positive, conflicts_with = "iwan")]
    preload: Option<f64>,
    /// Stiffness in series with the contact (with --props; default: rigid).
    #[arg(long, value_name = "K_e", allow_negative_numbers = true, value_parser = numbers::positive, conflicts_with = "iwan")]
    series: Option<f64>,
    /// Stiffness beside the contact (with --props; default: none).
    #[arg(long, value_name = "K_p", allow_negative_numbers = true, value_parser = numbers::positive, conflicts_with = "iwan")]
    parallel: Option<f64>,
    /// Displacement amplitudes.
    #[arg(long, required = true, value_name = "A,..", value_delimiter = ',', action = ArgAction::Set,
        allow_negative_numbers = true, value_parser = numbers::positive)]
    amplitude: Vec<f64>,
    /// Points per branch.
    #[arg(long, default_value_t = 200, value_parser = |text: &str| numbers::whole::<u32>(text, 3..=1_000_000))]
    points: u32,
    /// Cycles of each amplitude.
    #[arg(long, default_value_t = 1, value_parser = |text: &str| numbers::whole::<u32>(text, 1..=1000))]
    cycles: u32,
    /// Normal noise on the force, standard deviation as a part of the peak force.
    #[arg(long, value_name = "PART", default_value_t = 0.0, value_parser = noise)]
    noise: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1, value_parser = |text: &str| numbers::whole::<u64>(text, 0..=u64::MAX))]
    seed: u64,
    /// Write the loops there.
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Draw the loops into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
    /// Draw energy and damping against amplitude into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    energy_picture: Option<PathBuf>,
}

fn joint(text: &str) -> Result<Iwan, String> {
    let values: Vec<f64> = text
        .split(',')
        .map(numbers::argument)
        .collect::<Result<_, _>>()?;
    let parameters: [f64; 4] = values.try_into().map_err(|values: Vec<f64>| {
        format!("{} numbers, F_s,X_s,k_alpha,kappa are four", values.len())
    })?;
    Iwan::new(parameters).map_err(|error| crate::sentence(&error))
}

fn noise(text: &str) -> Result<f64, String> {
    let noise = numbers::argument(text)?;
    if (0.0..=10.0).contains(&noise) {
        Ok(noise)
    } else {
        Err(format!("{text} is not from 0 to 10"))
    }
}

/// A steady loop: the points of loading, then of unloading, and the two energies.
struct Cycle {
    amplitude: f64,
    points: Vec<[f64; 2]>,
    /// Counted along the loop: by the law, or by the area of the points.
    energy: f64,
    closed_form: f64,
}

impl Cycle {
    fn peak(&self) -> f64 {
        self.points
            .iter()
            .fold(0.0, |most: f64, p| most.max(p[1].abs()))
    }

    /// Equivalent damping ratio, the energy per cycle being one of the two; none without a force.
    fn damping(&self, energy: f64) -> f64 {
        if energy == 0.0 {
            return 0.0;
        }
        energy / (TAU * self.amplitude * self.peak())
    }
}

/// What makes loops.
#[expect(clippy::large_enum_variant, reason = "one is made, and never moved")]
enum Model {
    Joint(Iwan),
    Contact {
        law: Box<Law<1>>,
        points: Points,
        springs: Springs,
        preload: f64,
    },
}

impl Model {
    fn new(arguments: &Arguments) -> Result<Self> {
        if let Some(joint) = arguments.iwan {
            return Ok(Model::Joint(joint));
        }
        let (Some(props), Some(preload)) = (&arguments.props, arguments.preload) else {
            bail!("--props needs --preload");
        };
        let springs = Springs {
            series: arguments.series,
            parallel: arguments.parallel.unwrap_or(0.0),
        };
        Model::contact(&props.0, preload, springs)
    }

    fn contact(props: &[f64], preload: f64, springs: Springs) -> Result<Self> {
        let named = |error: mepc::Error| anyhow!("--props: {error}");
        let law =
            Law::<1>::new(props, default_state_size(props, 1).map_err(named)?).map_err(named)?;
        law.critical_slip(0.0).map_err(named)?;
        if law.properties().run_in.is_some() {
            bail!(
                "--props: mu_late: a loop while mu changes is not steady; give mu alone, as it is then"
            );
        }
        Ok(Model::Contact {
            law: Box::new(law),
            // The critical slip is the same everywhere: one point stands for any distribution of the preload.
            points: Points {
                x: vec![0.0],
                y: vec![0.0],
                area: vec![1.0],
                pressure: vec![preload],
                places: None,
            },
            springs,
            preload,
        })
    }

    fn cycle(&self, amplitude: f64, points: usize) -> Result<Cycle> {
        // Sinusoidal in time, as a test machine drives.
        let path = (0..points).map(|k| -amplitude * (PI * k as f64 / (points - 1) as f64).cos());
        let mut path: Vec<f64> = path.collect();
        path[points - 1] = amplitude;
        let back: Vec<f64> = path.iter().map(|x| -x).collect();
        match self {
            Model::Joint(joint) => {
                let branch = |path: &[f64], direction| -> Vec<[f64; 2]> {
                    path.iter()
                        .map(|&x| [x, joint.steady(amplitude, x, direction)])
                        .collect()
                };
                let mut points = branch(&path, Direction::Loading);
                points.extend(branch(&back, Direction::Unloading));
                Ok(Cycle {
                    amplitude,
                    energy: area(&points),
                    closed_form: joint.dissipation(amplitude),
                    points,
                })
            }
            Model::Contact {
                law,
                points,
                springs,
                preload,
            } => {
                let mut patch = Patch::new(law, points, *springs)?;
                let mut go = |x: f64| -> Result<([f64; 2], f64, f64)> {
                    patch.advance(&Motion {
                        displacement: Vector::<1>::new(x),
                        rotation: 0.0,
                        pressure_scale: 1.0,
                    })?;
                    Ok(([x, patch.total_force()[0]], patch.dissipated, patch.slip[0]))
                };
                // First loading, and the branch down to the start of the loop.
                go(amplitude)?;
                let (_, before, _) = go(-amplitude)?;
                let mut loop_points = Vec::new();
                let (mut after, mut largest_slip) = (before, 0.0);
                for &x in path.iter().chain(&back) {
                    let (point, dissipated, slip) = go(x)?;
                    loop_points.push(point);
                    after = dissipated;
                    largest_slip = f64::max(largest_slip, slip);
                }
                let gcr = law
                    .critical_slip(0.0)
                    .map_err(|error| anyhow!("--props: {error}"))?;
                let properties = law.properties();
                let limit = limit(properties, *preload);
                // The critical slip under this pressure, from the stiffness f'(0) T / G.
                let stiffness = law.sticking_stiffness(gcr, *preload);
                let critical = match stiffness {
                    0.0 => gcr,
                    _ => limit * properties.initial_slope() / stiffness,
                };
                let unit = limit * critical;
                let a = largest_slip / critical;
                let loss = properties.backbone().cycle_loss(a);
                Ok(Cycle {
                    amplitude,
                    points: loop_points,
                    energy: after - before,
                    closed_form: 4.0 * unit * loss,
                })
            }
        }
    }
}

/// The limit traction under a pressure, without run-in.
pub fn limit(properties: &Properties, pressure: f64) -> f64 {
    (properties.cohesion + properties.mu * pressure).min(properties.tau_max)
}

/// Displacement and force of a steady loop of a contact (properties and normal force) behind and beside springs, the ends met.
///
/// # Errors
/// Bad properties, or no equilibrium.
pub fn contact_loop(
    props: &[f64],
    preload: f64,
    springs: Springs,
    amplitude: f64,
) -> Result<Vec<[f64; 2]>> {
    const POINTS: usize = 200;
    let mut points = Model::contact(props, preload, springs)?
        .cycle(amplitude, POINTS)?
        .points;
    points.extend(points.first().copied());
    Ok(points)
}

/// Area of a closed polygon.
fn area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points
        .iter()
        .zip(next)
        .map(|(a, b)| 0.5 * (a[1] + b[1]) * (b[0] - a[0]))
        .sum()
}

/// Runs the command.
///
/// # Errors
/// Bad parameters, or files that cannot be written.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    check_outputs(
        &[
            ("--output", arguments.output.as_deref()),
            ("--picture", arguments.picture.as_deref()),
            ("--energy-picture", arguments.energy_picture.as_deref()),
        ],
        &[],
    )?;
    let model = Model::new(arguments)?;
    let cycles: Vec<Cycle> = arguments
        .amplitude
        .iter()
        .map(|&amplitude| model.cycle(amplitude, arguments.points as usize))
        .collect::<Result<_>>()?;

    for cycle in &cycles {
        let sum =
            cycle.energy + cycle.closed_form + cycle.peak() + cycle.damping(cycle.closed_form);
        ensure!(
            sum.is_finite(),
            "--amplitude {:e}: the loop's force or energy is not a finite number",
            cycle.amplitude
        );
    }
    // Streams of neighbouring seeds go together; those of what they give first do not.
    let mut random = fastrand::Rng::with_seed(arguments.seed).fork();
    let mut text = String::from("amplitude,displacement,force\n");
    for cycle in &cycles {
        let deviation = arguments.noise * cycle.peak();
        for _ in 0..arguments.cycles {
            for &[x, force] in &cycle.points {
                let noise = if deviation > 0.0 {
                    // Box and Muller: two even numbers to a normal one.
                    let (u, v) = (1.0 - random.f64(), random.f64());
                    deviation * (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
                } else {
                    0.0
                };
                text += &csv_line(&[cycle.amplitude, x, force + noise]);
            }
        }
    }
    write(arguments.output.as_deref(), &text)?;

    let energies = energies(&cycles);
    if arguments.output.is_some() {
        print(&energies)?;
    } else {
        // The table is extra here: a closed standard error does not make the loop wrong.
        let _ = write!(std::io::stderr(), "{energies}");
    }
    if let Some(file) = &arguments.picture {
        write(Some(file), &loops_figure(&cycles).svg()?)?;
    }
    if let Some(file) = &arguments.energy_picture {
        write(Some(file), &energy_picture(&model, &cycles)?)?;
    }
    Ok(Outcome::Done)
}

/// The table of energies: CSV, so that it can be used again.
fn energies(cycles: &[Cycle]) -> String {
    let mut text = String::from("amplitude,peak_force,energy,energy_closed_form,damping\n");
    for cycle in cycles {
        let _ = writeln!(
            text,
            "{},{},{},{},{}",
            exact(cycle.amplitude),
            short(cycle.peak()),
            short(cycle.energy),
            short(cycle.closed_form),
            short(cycle.damping(cycle.closed_form))
        );
    }
    text
}

fn loops_figure(cycles: &[Cycle]) -> Figure {
    let count = cycles.len();
    let curves = cycles.iter().enumerate().map(|(k, cycle)| {
        let mut points = cycle.points.clone();
        points.extend(cycle.points.first());
        let (colour, stroke) = style(k, count);
        Curve {
            label: format!("A = {} mm", short(cycle.amplitude)),
            points,
            stroke,
            colour,
        }
    });
    figure(
        "Steady loops",
        "displacement (mm)",
        "force (N)",
        curves.collect(),
    )
}

/// Points of the curves of [`energy_picture`].
const SAMPLES: u32 = 200;

fn energy_picture(model: &Model, cycles: &[Cycle]) -> Result<String> {
    let mut cycles: Vec<&Cycle> = cycles.iter().collect();
    cycles.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let largest = cycles.last().map_or(0.0, |c| c.amplitude);
    // From near zero, so that a single amplitude has a curve too. The closed form needs no more than the ends of a loop.
    let fine: Vec<Cycle> = (1..=SAMPLES)
        .map(|k| model.cycle(largest * f64::from(k) / f64::from(SAMPLES), 3))
        .collect::<Result<_>>()?;
    let panel = |title: &str, y_label: &str, value: &dyn Fn(&Cycle, f64) -> f64| {
        let exact = fine.iter().map(|c| [c.amplitude, value(c, c.closed_form)]);
        let counted = cycles.iter().map(|c| [c.amplitude, value(c, c.energy)]);
        let curves = vec![
            Curve {
                label: "closed form".to_string(),
                points: exact.collect(),
                stroke: Stroke::Solid,
                colour: BLUE,
            },
            Curve {
                label: "along the loop".to_string(),
                points: counted.collect(),
                stroke: Stroke::Marks,
                colour: ORANGE,
            },
        ];
        figure(title, "amplitude (mm)", y_label, curves)
    };
    mepc_plot::stacked(&[
        panel("Energy per cycle", "energy (N.mm)", &|_, energy| energy),
        panel(
            "Equivalent damping ratio",
            "D / (2 pi A T_max)  (-)",
            &|cycle, energy| cycle.damping(energy),
        ),
    ])
}
