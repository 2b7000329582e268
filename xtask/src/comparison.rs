//! The demo's table: what the drivers gave for a case and method against each other and the reference.

use anyhow::{Context, Result, bail};

use crate::drivers::{Replayed, Table};
use crate::expected::{self, Expected};
use crate::manifest::{Case, Method};

/// C against Fortran, methods 0 and 1, each quantity over its limit.
const SAME_LAW: f64 = 1e-12;
/// C against Fortran, method 2: the native law is a stiff penalty, the Fortran host has multipliers.
const LAGRANGE: f64 = 2e-3;
/// How far rounding may take a traction beyond mu p.
const COULOMB: f64 = 1e-12;
/// How far the load may be off, over its limit, while a reversal is missing that a full memory dropped.
const FORGETTING: f64 = 0.1;

/// What a case's numbers are measured by.
struct Scales {
    /// Largest mu p, or mu P of a patch.
    limit: f64,
    /// The same as a moment.
    moment: f64,
    energy: f64,
    slip: f64,
}

impl Scales {
    fn new(r: &Replayed) -> Result<Scales> {
        let mu = r.case.mu();
        let (limit, moment) = match &r.patch {
            None => {
                let top = r
                    .history
                    .column("pressure")?
                    .iter()
                    .copied()
                    .fold(0.0, larger);
                (mu * top, 1.0)
            }
            Some(patch) => {
                let forces = expected::product(patch.column("area")?, patch.column("pressure")?);
                let moments = expected::product(&forces, &expected::arms(patch)?);
                (
                    mu * forces.iter().sum::<f64>(),
                    mu * moments.iter().sum::<f64>(),
                )
            }
        };
        let gcr = r.case.gcr();
        Ok(Scales {
            limit,
            moment,
            energy: limit * gcr,
            slip: gcr,
        })
    }

    /// Scale of a column of an output; none where a difference means nothing.
    fn of(&self, column: &str) -> Option<f64> {
        Some(match column.trim_end_matches("_1").trim_end_matches("_2") {
            "traction" | "force" => self.limit,
            "moment" => self.moment,
            "stored_energy" | "dissipated_energy" => self.energy,
            "slip" | "displacement" => self.slip,
            // The drivers may take different ways to the same equilibrium.
            "iterations" => return None,
            // Time, pressure, rotation and statuses are copied or counted.
            _ => 1.0,
        })
    }

    /// Largest difference of two outputs, each column over its scale.
    fn difference(&self, c: &Table, fortran: &Table) -> Result<f64> {
        let mut worst: f64 = 0.0;
        for (name, ours) in c.columns() {
            let theirs = fortran.column(name)?;
            if ours.len() != theirs.len() {
                bail!("{} rows from C, {} from Fortran", ours.len(), theirs.len());
            }
            if let Some(scale) = self.of(name) {
                let differences = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs() / scale);
                worst = differences.fold(worst, larger);
            }
        }
        Ok(worst)
    }
}

/// C against Fortran.
enum Languages {
    /// Largest difference of any number, over its scale.
    Everything(f64),
    /// Peak load and loop area, relative.
    PeakAndArea(f64, f64),
}

/// One line of the table.
pub struct Row {
    case: String,
    method: Method,
    pub patch: bool,
    points: usize,
    steps: usize,
    /// Updates in which the memory was full.
    memory_full: u64,
    /// The case is there to show a full memory.
    fills_memory: bool,
    peak: f64,
    dissipated: f64,
    reference: f64,
    source: &'static str,
    dissipation_error: f64,
    load_error: f64,
    tolerance: [f64; 2],
    languages: Languages,
}

impl Row {
    /// The row of method number `index` of a case.
    pub fn new(r: &Replayed, index: usize, expected: &Expected) -> Result<Row> {
        let (case, c, fortran) = (&r.case, &r.c[index], &r.fortran[index]);
        let method = case.methods()[index];
        let scales = Scales::new(r)?;
        let load = friction_load(case, c)?;
        if load.len() != expected.load.len() {
            bail!(
                "{} rows in the output, {} in the history",
                load.len(),
                expected.load.len()
            );
        }
        let load_scale = if c.find("moment").is_some() {
            scales.moment
        } else {
            scales.limit
        };
        let differences = load
            .iter()
            .zip(&expected.load)
            .map(|(a, b)| distance(a, b) / load_scale);
        let load_error = differences.fold(0.0, larger);

        let dissipated = loop_dissipation(case, c.column("dissipated_energy")?)?;
        let (reference, source, mut tolerance) = match case.circle {
            None => (
                loop_dissipation(case, &expected.dissipated)?,
                expected.source,
                expected.tolerance,
            ),
            // Four hundred steps a turn are not quite a circle for any number of elements.
            Some(radius) => (
                expected::steady_turn(case, method, radius, c.column("pressure")?[0]),
                "circle integral",
                [expected.tolerance[0], 0.01],
            ),
        };
        // The other methods have no reversals to remember.
        let fills_memory = case.nstate.is_some() && method == Method::Memory;
        // The loop itself is larger than those that were forgotten, and as exact as ever.
        if fills_memory {
            tolerance[0] = FORGETTING;
        }
        // Nothing is lost in a loop that only sticks.
        let dissipation_error =
            (dissipated - reference).abs() / reference.abs().max(1e-6 * scales.energy);
        let languages = if method != Method::Lagrange {
            Languages::Everything(scales.difference(c, fortran)?)
        } else {
            let peaks = [load.clone(), friction_load(case, fortran)?].map(|load| peak(&load));
            let area = loop_dissipation(case, fortran.column("dissipated_energy")?)?;
            Languages::PeakAndArea(
                (peaks[1] / peaks[0] - 1.0).abs(),
                (area / dissipated - 1.0).abs(),
            )
        };
        Ok(Row {
            case: case.name.clone(),
            method,
            patch: r.patch.is_some(),
            points: r.patch.as_ref().map_or(1, Table::rows),
            steps: c.rows(),
            memory_full: r.memory_full[index],
            fills_memory,
            peak: peak_over_limit(case, c, &load, load_scale),
            dissipated,
            reference,
            source,
            dissipation_error,
            load_error,
            tolerance,
            languages,
        })
    }

    /// Bounds that this row breaks, in words.
    pub fn broken(&self) -> Vec<String> {
        let mut checks = vec![
            ("peak over mu p", self.peak, 1.0 + COULOMB),
            (
                "load against the reference",
                self.load_error,
                self.tolerance[0],
            ),
            (
                "dissipation against the reference",
                self.dissipation_error,
                self.tolerance[1],
            ),
        ];
        match self.languages {
            Languages::Everything(difference) => {
                checks.push(("C against Fortran", difference, SAME_LAW))
            }
            Languages::PeakAndArea(peak, area) => {
                checks.push(("C against Fortran, peak", peak, LAGRANGE));
                checks.push(("C against Fortran, loop area", area, LAGRANGE));
            }
        }
        let place = format!("{}, {}", self.case, self.method.name());
        let mut broken: Vec<String> = checks
            .into_iter()
            .filter(|(_, value, bound)| !within(*value, *bound))
            .map(|(what, value, bound)| {
                format!("{place}: {what} is {value:.3e}, bound {bound:.3e}")
            })
            .collect();
        if self.fills_memory && self.memory_full == 0 {
            broken.push(format!("{place}: the memory was to be full, and never was"));
        }
        broken
    }
}

/// Two pressure distributions of one total: the same friction force at every step. What differs, in words.
pub fn same_loop(r: &Replayed, earlier: &[Replayed]) -> Result<Vec<String>> {
    let Some(name) = &r.case.same_loop_as else {
        return Ok(Vec::new());
    };
    let other = earlier
        .iter()
        .find(|o| &o.case.name == name)
        .with_context(|| format!("case {name} has not been replayed"))?;
    let limit = Scales::new(r)?.limit;
    let mut broken = Vec::new();
    for ((ours, theirs), method) in r.c.iter().zip(&other.c).zip(r.case.methods()) {
        let (ours, theirs) = (
            friction_load(&r.case, ours)?,
            friction_load(&other.case, theirs)?,
        );
        let differences = ours
            .iter()
            .zip(&theirs)
            .map(|(a, b)| distance(a, b) / limit);
        let difference = differences.fold(0.0, larger);
        if !within(difference, SAME_LAW) {
            let method = method.name();
            broken.push(format!(
                "{}, {method}: differs from {name} by {difference:.3e}",
                r.case.name
            ));
        }
    }
    Ok(broken)
}

/// Traction of a point, friction force or moment of a patch, per step.
fn friction_load(case: &Case, output: &Table) -> Result<Vec<Vec<f64>>> {
    if let Some(moment) = output.find("moment") {
        return Ok(moment.iter().map(|&m| vec![m]).collect());
    }
    if let Some(force) = output.find("force_1") {
        let beside = case.parallel.unwrap_or(0.0);
        let displacement = output.column("displacement_1")?;
        return Ok(force
            .iter()
            .zip(displacement)
            .map(|(f, u)| vec![f - beside * u])
            .collect());
    }
    let first = output.column("traction_1")?;
    Ok(match output.find("traction_2") {
        None => first.iter().map(|&t| vec![t]).collect(),
        Some(second) => first
            .iter()
            .zip(second)
            .map(|(&a, &b)| vec![a, b])
            .collect(),
    })
}

/// Whether a bound holds; NaN breaks it.
fn within(value: f64, bound: f64) -> bool {
    value <= bound
}

/// The larger of two, and NaN rather than a number.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    length(&difference)
}

fn peak(load: &[Vec<f64>]) -> f64 {
    load.iter().map(|l| length(l)).fold(0.0, larger)
}

/// Largest load over what Coulomb allows at that moment.
fn peak_over_limit(case: &Case, output: &Table, load: &[Vec<f64>], load_scale: f64) -> f64 {
    let Some(pressure) = output.find("pressure") else {
        return peak(load) / load_scale;
    };
    let parts = load.iter().zip(pressure).map(|(t, &p)| match p > 0.0 {
        true => length(t) / (case.mu() * p),
        // An open point carries nothing: any traction there breaks the bound.
        false if length(t) == 0.0 => 0.0,
        false => f64::INFINITY,
    });
    parts.fold(0.0, larger)
}

/// Dissipation in the last loop, or in all of the history.
fn loop_dissipation(case: &Case, dissipated: &[f64]) -> Result<f64> {
    let last = dissipated.len() - 1;
    let Some(steps) = case.loop_steps else {
        return Ok(dissipated[last]);
    };
    let Some(start) = last.checked_sub(steps) else {
        bail!("loop_steps = {steps}, but the history has only {last} steps");
    };
    Ok(dissipated[last] - dissipated[start])
}

pub fn print_table(rows: &[Row]) {
    let heading = format!(
        "{:<30} {:<9} {:>6} {:>6} {:>5} {:>9} {:>12} {:>12}  {:<15} {:>8} {:>8}  C - Fortran",
        "case",
        "method",
        "points",
        "steps",
        "full",
        "peak/mu p",
        "dissipated",
        "reference",
        "from",
        "error",
        "load"
    );
    println!("{heading}");
    println!("{}", "-".repeat(heading.len() + 8));
    for row in rows {
        let languages = match row.languages {
            Languages::Everything(d) => format!("{d:.1e}"),
            Languages::PeakAndArea(p, a) => format!("{p:.1e} peak, {a:.1e} area"),
        };
        let full = match row.memory_full {
            0 => "-".to_string(),
            updates => updates.to_string(),
        };
        println!(
            "{:<30} {:<9} {:>6} {:>6} {full:>5} {:>9.6} {:>12.5e} {:>12.5e}  {:<15} {:>8.1e} {:>8.1e}  {languages}",
            row.case,
            row.method.name(),
            row.points,
            row.steps,
            row.peak,
            row.dissipated,
            row.reference,
            row.source,
            row.dissipation_error,
            row.load_error,
        );
    }
    println!(
        "\nfull: updates in which the memory was full and a knot that mattered was dropped (the library's advisory status);\n  \
         what that costs is in the load, until a larger loop wipes out the small ones\n\
         dissipated: in the last loop, or in all where no loop closes; points N/mm (mJ/mm2), patches N.mm (mJ)\n\
         error: of the dissipation, relative; load: largest error of traction, force or moment, over its limit\n\
         Lagrange: prescribed slip needs a stand-in for rigid stick, the standard penalty with gcr/1000, which is the reference\n\
         C - Fortran: largest difference of any number over its scale; Lagrange: relative, of peak and loop area"
    );
    let patches = rows.iter().filter(|r| r.patch).count();
    println!(
        "{} replays of points, {patches} of patches",
        rows.len() - patches
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Row {
        Row {
            case: "loop".to_string(),
            method: Method::Memory,
            patch: false,
            points: 1,
            steps: 10,
            memory_full: 0,
            fills_memory: false,
            peak: 1.0,
            dissipated: 2.0,
            reference: 2.0,
            source: "Masing",
            dissipation_error: 1e-10,
            load_error: 1e-13,
            tolerance: [1e-12, 1e-9],
            languages: Languages::Everything(1e-15),
        }
    }

    #[test]
    fn every_bound_can_break() {
        assert!(good().broken().is_empty());
        let bad = [
            Row {
                peak: 1.0 + 1e-11,
                ..good()
            },
            Row {
                load_error: 2e-12,
                ..good()
            },
            Row {
                dissipation_error: f64::NAN,
                ..good()
            },
            Row {
                languages: Languages::Everything(2e-12),
                ..good()
            },
            Row {
                languages: Languages::PeakAndArea(3e-3, 0.0),
                ..good()
            },
            Row {
                languages: Languages::PeakAndArea(0.0, f64::NAN),
                ..good()
            },
            Row {
                fills_memory: true,
                ..good()
            },
        ];
        for row in bad {
            assert_eq!(row.broken().len(), 1, "{:?}", row.broken());
        }
    }

    #[test]
    fn a_maximum_does_not_lose_nan() {
        assert!([1.0, f64::NAN, 2.0].into_iter().fold(0.0, larger).is_nan());
        assert_eq!([1.0, 3.0, 2.0].into_iter().fold(0.0, larger), 3.0);
    }
}
