//! What references without the library say about a case: friction load and dissipation at every step.

use anyhow::{Result, bail};
use mepc_oracle::masing::Masing;
use mepc_oracle::spring::SpringPatch;
use mepc_oracle::{Backbone, closed};

use crate::drivers::{Replayed, Table};
use crate::manifest::{Case, Method};

/// Slip elements, and parts of a step, where nothing simpler is exact.
const ELEMENTS: usize = 2000;
const PARTS: usize = 8;
/// The same where there is one element only.
const PARTS_OF_ONE: usize = 500;

/// A second opinion on one case and method.
pub struct Expected {
    /// Where it comes from, for the table.
    pub source: &'static str,
    /// Friction load per step: traction components, force or moment.
    pub load: Vec<Vec<f64>>,
    /// Dissipated since the start.
    pub dissipated: Vec<f64>,
    /// Largest error of the load, over its limit, and of the dissipation, relative.
    pub tolerance: [f64; 2],
}

/// Exponent and critical slip that stand for a method; method 2 outside of a Lagrange host is the standard penalty
/// with gcr/1000.
fn law(case: &Case, method: Method) -> (f64, f64) {
    match method {
        Method::Memory => (case.chi(), case.gcr()),
        Method::Penalty => (1.0, case.gcr()),
        Method::Lagrange => (1.0, case.gcr() / 1000.0),
    }
}

pub fn of(r: &Replayed, method: Method) -> Result<Expected> {
    match &r.patch {
        None => of_point(&r.case, method, &r.history),
        Some(patch) => of_patch(&r.case, method, &r.history, patch),
    }
}

/// Dissipation per steady turn of a circle case, per area.
pub fn steady_turn(case: &Case, method: Method, radius: f64, pressure: f64) -> f64 {
    let (chi, gcr) = law(case, method);
    let radius = radius * case.gcr() / gcr;
    case.mu() * pressure * gcr * closed::circle_dissipation(Backbone::Power { chi }, radius)
}

fn of_point(case: &Case, method: Method, history: &Table) -> Result<Expected> {
    let (chi, gcr) = law(case, method);
    let pressure = history.column("pressure")?;
    let slip = history.column("slip_1")?;
    let across = history.find("slip_2");
    let constant = pressure.iter().all(|&p| p == pressure[0] && p > 0.0);
    if across.is_none() && constant {
        let mut point = Masing::new(Backbone::Power { chi });
        let limit = case.mu() * pressure[0];
        let gcr = match case.reference_pressure {
            0.0 => gcr,
            p0 => gcr * (pressure[0] / p0).powf(1.0 / chi),
        };
        let step = |g: &f64| {
            point.move_to(g / gcr);
            (
                vec![limit * point.traction()],
                limit * gcr * point.dissipated(),
            )
        };
        let (load, dissipated) = slip.iter().map(step).unzip();
        return Ok(Expected {
            source: "Masing",
            load,
            dissipated,
            tolerance: [1e-12, 1e-9],
        });
    }
    let most = pressure.iter().copied().fold(0.0, f64::max);
    let mut elements = Elements::new(case, chi, gcr, most);
    let parts = if chi == 1.0 { PARTS_OF_ONE } else { PARTS };
    let (mut at, mut before) = ([0.0; 2], 0.0);
    let step = |k: usize| {
        let next = [slip[k], across.map_or(0.0, |s| s[k])];
        let d = [next[0] - at[0], next[1] - at[1]].map(|d| d / parts as f64);
        for part in 1..=parts {
            let share = part as f64 / parts as f64;
            // A contact that opens or closes does so with the whole pressure.
            let p = match before > 0.0 && pressure[k] > 0.0 {
                true => before + (pressure[k] - before) * share,
                false => pressure[k],
            };
            elements.step(d, p);
        }
        (at, before) = (next, pressure[k]);
        let directions = if across.is_some() { 2 } else { 1 };
        (
            elements.traction[..directions].to_vec(),
            elements.dissipated(),
        )
    };
    let (load, dissipated) = (0..slip.len()).map(step).unzip();
    // One element is exact but for what slips within a part of a step; else what the memory promises on curved paths.
    let (source, tolerance) = match chi {
        1.0 => ("one element", [1e-3, 5e-3]),
        _ => ("2000 elements", [0.0075, 0.025]),
    };
    Ok(Expected {
        source,
        load,
        dissipated,
        tolerance,
    })
}

/// Parallel slip elements (Iwan) of the power law. Each has its distance x from the base of the cone and a stiffness
/// c chi (chi - 1) x^(chi - 2) dx, and slips at the deflection G - x; without any when G < x.
/// Consistent rule: G = gcr (p/p0)^(1/chi), c fixed. Proportional rule: G = gcr, c goes with the pressure.
struct Elements {
    mu: f64,
    chi: f64,
    gcr: f64,
    reference_pressure: f64,
    /// Distance from the base, part of the stiffness, deflection.
    elements: Vec<(f64, f64, [f64; 2])>,
    pressure: f64,
    traction: [f64; 2],
    work: f64,
    stored: f64,
}

impl Elements {
    fn new(case: &Case, chi: f64, gcr: f64, most: f64) -> Self {
        let p0 = case.reference_pressure;
        let reach = if p0 > 0.0 {
            gcr * (most / p0).powf(1.0 / chi)
        } else {
            gcr
        };
        let edge = |k: usize| reach * k as f64 / ELEMENTS as f64;
        let cell = |k: usize| {
            let (a, b) = (edge(k), edge(k + 1));
            let weight = chi * (b.powf(chi - 1.0) - a.powf(chi - 1.0));
            // The centre of the cell's stiffness: with it all elements together saturate at exactly mu p.
            let moment = (chi - 1.0) * (b.powf(chi) - a.powf(chi));
            (moment / weight, weight, [0.0; 2])
        };
        let elements = if chi == 1.0 {
            vec![(0.0, 1.0, [0.0; 2])]
        } else {
            (0..ELEMENTS).map(cell).collect()
        };
        Elements {
            mu: case.mu(),
            chi,
            gcr,
            reference_pressure: p0,
            elements,
            pressure: 0.0,
            traction: [0.0; 2],
            work: 0.0,
            stored: 0.0,
        }
    }

    fn step(&mut self, d: [f64; 2], pressure: f64) {
        let p0 = self.reference_pressure;
        let (critical, at) = match p0 {
            0.0 => (self.gcr, pressure.max(0.0)),
            _ => (self.gcr * (pressure.max(0.0) / p0).powf(1.0 / self.chi), p0),
        };
        let c = self.mu * at / self.gcr.powf(self.chi);
        let before = self.traction;
        (self.traction, self.stored) = ([0.0; 2], 0.0);
        for (x, weight, u) in &mut self.elements {
            let limit = if pressure > 0.0 {
                (critical - *x).max(0.0)
            } else {
                0.0
            };
            let trial = [u[0] + d[0], u[1] + d[1]];
            let length = trial[0].hypot(trial[1]);
            *u = if length > limit {
                trial.map(|v| v * limit / length)
            } else {
                trial
            };
            for i in 0..2 {
                self.traction[i] += c * *weight * u[i];
                self.stored += 0.5 * c * *weight * u[i] * u[i];
            }
        }
        if pressure > 0.0 {
            let mean = [0, 1].map(|i| 0.5 * (before[i] + self.traction[i]));
            self.work += mean[0] * d[0] + mean[1] * d[1];
        }
        self.pressure = pressure;
    }

    /// What was put in and is no longer stored.
    fn dissipated(&self) -> f64 {
        self.work - self.stored
    }
}

fn of_patch(case: &Case, method: Method, history: &Table, patch: &Table) -> Result<Expected> {
    let (chi, gcr) = law(case, method);
    let backbone = Backbone::Power { chi };
    let mu = case.mu();
    let forces: Vec<f64> = product(patch.column("area")?, patch.column("pressure")?);
    if history.find("pressure_scale").is_some() || case.reference_pressure != 0.0 {
        bail!(
            "case {}: no reference for a patch under changing pressure",
            case.name
        );
    }
    let displacement = history.column("displacement_1")?;
    let Some(rotation) = history.find("rotation") else {
        let limit = mu * forces.iter().sum::<f64>();
        let mut whole = SpringPatch::new(backbone, limit, gcr, case.series);
        let step = |&u: &f64| {
            whole.move_to(u);
            (vec![whole.force()], whole.dissipated())
        };
        let (load, dissipated) = displacement.iter().map(step).unzip();
        // The slip behind a spring is known to the accuracy of an equilibrium.
        let tolerance = if case.series.is_some() {
            [1e-9, 1e-8]
        } else {
            [1e-12, 1e-9]
        };
        return Ok(Expected {
            source: "Masing",
            load,
            dissipated,
            tolerance,
        });
    };
    if displacement.iter().any(|&u| u != 0.0) || case.series.is_some() {
        bail!(
            "case {}: no reference for a rotation with a displacement or a spring",
            case.name
        );
    }
    // Each point goes back and forth along its own circle about the origin.
    let arms: Vec<f64> = arms(patch)?;
    let mut points = vec![Masing::new(backbone); forces.len()];
    let step = |angle: &f64| {
        let (mut moment, mut loss) = (0.0, 0.0);
        for ((point, force), arm) in points.iter_mut().zip(&forces).zip(&arms) {
            point.move_to(angle * arm / gcr);
            moment += mu * force * arm * point.traction();
            loss += mu * force * gcr * point.dissipated();
        }
        (vec![moment], loss)
    };
    let (load, dissipated) = rotation.iter().map(step).unzip();
    Ok(Expected {
        source: "Masing",
        load,
        dissipated,
        tolerance: [1e-12, 1e-9],
    })
}

/// Distances of a patch's points from the origin.
pub fn arms(patch: &Table) -> Result<Vec<f64>> {
    let (x, y) = (patch.column("x")?, patch.column("y")?);
    Ok(x.iter().zip(y).map(|(x, y)| x.hypot(*y)).collect())
}

/// Products of two columns.
pub fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}
