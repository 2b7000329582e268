//! What the oracle says about a case: friction load and dissipation at every step.

use anyhow::{Result, bail};
use mepc_oracle::masing::Masing;
use mepc_oracle::spring::SpringPatch;
use mepc_oracle::twin::{PressureRule, Twin};
use mepc_oracle::{Backbone, closed};

use crate::drivers::Table;
use crate::manifest::Case;

/// Slip elements of the twin.
const ELEMENTS: u32 = 4000;

/// A second opinion on one case and method.
pub struct Reference {
    /// Where it comes from, for the table.
    pub source: &'static str,
    /// Friction load per step: traction components, force or moment.
    pub load: Vec<Vec<f64>>,
    /// Dissipated since the start.
    pub dissipated: Vec<f64>,
    /// Largest error of the load, over its limit, and of the dissipation, relative.
    pub tolerance: [f64; 2],
}

/// Backbone and critical slip that stand for a method; method 2 outside of a Lagrange host is the standard penalty
/// with gcr/1000.
fn law(case: &Case, method: u8) -> (Backbone, f64) {
    match method {
        0 => (Backbone::Power { chi: case.chi() }, case.gcr()),
        1 => (Backbone::PENALTY, case.gcr()),
        _ => (Backbone::PENALTY, case.gcr() / 1000.0),
    }
}

/// The reference for a single point or, given the patch, for its force (or moment, under rotation).
pub fn of(case: &Case, method: u8, history: &Table, patch: Option<&Table>) -> Result<Reference> {
    match patch {
        None => of_point(case, method, history),
        Some(patch) => of_patch(case, method, history, patch),
    }
}

/// Dissipation per steady turn of a circle case, per area.
pub fn steady_turn(case: &Case, method: u8, radius: f64, pressure: f64) -> f64 {
    let (backbone, gcr) = law(case, method);
    let radius = radius * case.gcr() / gcr;
    case.mu() * pressure * gcr * closed::circle_dissipation(backbone, radius)
}

fn of_point(case: &Case, method: u8, history: &Table) -> Result<Reference> {
    let (backbone, gcr) = law(case, method);
    let pressure = history.column("pressure")?;
    let slip = history.column("slip_1")?;
    let constant = pressure.iter().all(|&p| p == pressure[0] && p > 0.0);
    let Some(across) = history.find("slip_2") else {
        return Ok(if constant {
            masing(backbone, case.mu() * pressure[0], gcr, slip)
        } else {
            slip_elements(backbone, case.mu(), gcr, slip, None, pressure)
        });
    };
    Ok(slip_elements(
        backbone,
        case.mu(),
        gcr,
        slip,
        Some(across),
        pressure,
    ))
}

fn masing(backbone: Backbone, limit: f64, gcr: f64, slip: &[f64]) -> Reference {
    let mut point = Masing::new(backbone);
    let (load, dissipated) = slip
        .iter()
        .map(|g| {
            point.move_to(g / gcr);
            (
                vec![limit * point.traction()],
                limit * gcr * point.dissipated(),
            )
        })
        .unzip();
    Reference {
        source: "Masing",
        load,
        dissipated,
        tolerance: [1e-12, 1e-9],
    }
}

fn slip_elements(
    backbone: Backbone,
    mu: f64,
    gcr: f64,
    slip: &[f64],
    across: Option<&[f64]>,
    pressure: &[f64],
) -> Reference {
    let mut twin = Twin::new(backbone, mu, gcr, PressureRule::Dissipative, ELEMENTS);
    let mut at = [0.0; 2];
    let (load, dissipated) = (0..slip.len())
        .map(|k| {
            let next = [slip[k], across.map_or(0.0, |s| s[k])];
            twin.step([next[0] - at[0], next[1] - at[1]], pressure[k]);
            at = next;
            let directions = if across.is_some() { 2 } else { 1 };
            (twin.traction()[..directions].to_vec(), twin.dissipated())
        })
        .unzip();
    let exact = backbone == Backbone::PENALTY;
    Reference {
        source: if exact {
            "one element"
        } else {
            "4000 elements"
        },
        load,
        dissipated,
        // What the base grid promises on curved paths, and the memory under continuous changes of pressure.
        tolerance: if exact {
            [1e-12, 1e-9]
        } else {
            [0.0075, 0.025]
        },
    }
}

fn of_patch(case: &Case, method: u8, history: &Table, patch: &Table) -> Result<Reference> {
    let (backbone, gcr) = law(case, method);
    let mu = case.mu();
    let forces: Vec<f64> = product(patch.column("area")?, patch.column("pressure")?);
    if history.find("pressure_scale").is_some() {
        bail!(
            "case {}: no reference for a patch under changing pressure",
            case.name
        );
    }
    let displacement = history.column("displacement_1")?;
    let Some(rotation) = history.find("rotation") else {
        let limit = mu * forces.iter().sum::<f64>();
        let mut whole = SpringPatch::new(backbone, limit, gcr, case.series);
        let (load, dissipated) = displacement
            .iter()
            .map(|&u| {
                whole.move_to(u);
                (vec![whole.force()], whole.dissipated())
            })
            .unzip();
        return Ok(Reference {
            source: "Masing",
            load,
            dissipated,
            // The slip behind a spring is known to the accuracy of an equilibrium.
            tolerance: if case.series.is_some() {
                [1e-9, 1e-8]
            } else {
                [1e-12, 1e-9]
            },
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
    let (load, dissipated) = rotation
        .iter()
        .map(|angle| {
            let (mut moment, mut loss) = (0.0, 0.0);
            for ((point, force), arm) in points.iter_mut().zip(&forces).zip(&arms) {
                point.move_to(angle * arm / gcr);
                moment += mu * force * arm * point.traction();
                loss += mu * force * gcr * point.dissipated();
            }
            (vec![moment], loss)
        })
        .unzip();
    Ok(Reference {
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
