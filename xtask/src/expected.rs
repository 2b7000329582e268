//! What references without the library say about a case: friction load and dissipation at every step.

use anyhow::{Result, bail};
use mepc_oracle::masing::Masing;
use mepc_oracle::spring::SpringPatch;
use mepc_oracle::twin::Twin;
use mepc_oracle::{Backbone, closed};

use crate::drivers::{Replayed, Table};
use crate::manifest::{Case, Method};

/// Slip elements, and parts of a step, where nothing simpler is exact.
const ELEMENTS: u32 = 2000;
const PARTS: u32 = 8;
/// The same where there is one element only.
const PARTS_OF_ONE: u32 = 500;

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
    let (limit, n) = (|p: f64| case.mu() * p, ELEMENTS);
    let most = limit(pressure.iter().copied().fold(0.0, f64::max));
    let mut twin = match case.reference_pressure {
        0.0 => Twin::fixed_limits(Backbone::Power { chi }, gcr, n),
        p0 => Twin::fixed_depths(chi, gcr, limit(p0), most, n),
    };
    let parts = if chi == 1.0 { PARTS_OF_ONE } else { PARTS };
    let mut at = [0.0; 2];
    let step = |k: usize| {
        let next = [slip[k], across.map_or(0.0, |s| s[k])];
        twin.step(
            [next[0] - at[0], next[1] - at[1]],
            limit(pressure[k]),
            parts,
        );
        at = next;
        let directions = if across.is_some() { 2 } else { 1 };
        (twin.traction()[..directions].to_vec(), twin.dissipated())
    };
    let (load, dissipated) = (0..slip.len()).map(step).unzip();
    // One element is exact but for what slips within a part of a step, and so are many on a straight path but for their
    // number; else what the memory promises on curved paths.
    let (source, tolerance) = match (chi, across) {
        (1.0, _) => ("one element", [1e-4, 1e-4]),
        (_, None) => ("2000 elements", [1e-6, 1e-5]),
        _ => ("2000 elements", [2e-3, 1e-2]),
    };
    Ok(Expected {
        source,
        load,
        dissipated,
        tolerance,
    })
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
