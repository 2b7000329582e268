//! `cargo xtask demo`: every case of cases/cases.toml through both drivers, against each other and the oracle.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::drivers::{Driver, Table};
use crate::manifest::{self, Case};
use crate::pictures;
use crate::reference::{self, Reference};

/// Names of the methods 0, 1, 2.
pub const METHODS: [&str; 3] = ["memory", "penalty", "Lagrange"];

/// C against Fortran, methods 0 and 1, each quantity over its limit.
const SAME_LAW: f64 = 1e-12;
/// C against Fortran, method 2: the native law is a stiff penalty, the Fortran host has multipliers.
const LAGRANGE: f64 = 2e-3;
/// How far rounding may take a traction beyond mu p.
const COULOMB: f64 = 1e-12;
/// How far the load may be off, over its limit, while a reversal is missing that a full memory dropped.
const FORGETTING: f64 = 0.1;

/// The outputs of one case, method after method.
pub struct Replayed {
    pub case: Case,
    pub patch: Option<Table>,
    pub c: Vec<Table>,
    pub fortran: Vec<Table>,
}

/// What a case's numbers are measured by.
struct Scales {
    /// Largest mu p, or mu P of a patch.
    limit: f64,
    /// The same as a moment.
    moment: f64,
    energy: f64,
    slip: f64,
}

pub fn run(root: &Path, docs: bool) -> Result<()> {
    let c = Driver::c(root)?;
    let fortran = Driver::fortran(root)?;
    let output = root.join("build/demo");
    // Nothing of an earlier run stays among the results.
    if output.exists() {
        std::fs::remove_dir_all(&output).with_context(|| output.display().to_string())?;
    }
    std::fs::create_dir_all(&output).with_context(|| output.display().to_string())?;
    let mut rows = Vec::new();
    let mut broken = Vec::new();
    let mut replayed: Vec<Replayed> = Vec::new();
    for case in manifest::read(&root.join("cases/cases.toml"))? {
        let history = Table::read(&case.history)?;
        let mut r = Replayed {
            patch: case.patch.as_deref().map(Table::read).transpose()?,
            case,
            c: Vec::new(),
            fortran: Vec::new(),
        };
        for method in 0..METHODS.len() as u8 {
            let file = |language: &str| {
                output.join(format!(
                    "{}_{}_{language}.csv",
                    r.case.name,
                    METHODS[usize::from(method)]
                ))
            };
            let (ours, memory_full) = c.replay(&r.case, method, &file("c"))?;
            let (theirs, _) = fortran.replay(&r.case, method, &file("fortran"))?;
            let reference = reference::of(&r.case, method, &history, r.patch.as_ref())?;
            let row = Row::new(&r, method, [&ours, &theirs], memory_full, &reference)
                .with_context(|| format!("case {}, method {method}", r.case.name))?;
            broken.extend(row.broken());
            rows.push(row);
            r.c.push(ours);
            r.fortran.push(theirs);
        }
        broken.extend(same_loop(&r, &replayed)?);
        replayed.push(r);
    }
    print_table(&rows);
    let pictures = pictures::write(&replayed, &output, docs.then_some(root))?;
    println!(
        "\nCSV files and {pictures} pictures in {}",
        output.strip_prefix(root)?.display()
    );
    if !broken.is_empty() {
        bail!("bounds broken:\n  {}", broken.join("\n  "));
    }
    Ok(())
}

/// One line of the table.
struct Row {
    case: String,
    method: u8,
    patch: bool,
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

/// C against Fortran.
enum Languages {
    /// Largest difference of any number, over its scale.
    Everything(f64),
    /// Peak load and loop area, relative.
    PeakAndArea(f64, f64),
}

impl Row {
    fn new(
        r: &Replayed,
        method: u8,
        [c, fortran]: [&Table; 2],
        memory_full: u64,
        reference: &Reference,
    ) -> Result<Row> {
        let case = &r.case;
        let scales = Scales::new(case, r.patch.as_ref(), c)?;
        let load = friction_load(case, c)?;
        if load.len() != reference.load.len() {
            bail!(
                "{} rows in the output, {} in the history",
                load.len(),
                reference.load.len()
            );
        }
        let load_scale = if is_torsion(c) {
            scales.moment
        } else {
            scales.limit
        };
        let load_error = load
            .iter()
            .zip(&reference.load)
            .map(|(a, b)| distance(a, b) / load_scale)
            .fold(0.0, larger);

        let dissipated = loop_dissipation(case, c.column("dissipated_energy")?)?;
        let (expected, source, mut tolerance) = match case.circle {
            None => (
                loop_dissipation(case, &reference.dissipated)?,
                reference.source,
                reference.tolerance,
            ),
            // Four hundred steps a turn are not quite a circle for any number of elements.
            Some(radius) => (
                reference::steady_turn(case, method, radius, c.column("pressure")?[0]),
                "circle integral",
                [reference.tolerance[0], 0.025],
            ),
        };
        // The other methods have no reversals to remember.
        let fills_memory = case.nstate.is_some() && method == 0;
        // The loop itself is larger than those that were forgotten, and as exact as ever.
        if fills_memory {
            tolerance[0] = FORGETTING;
        }
        // Nothing is lost in a loop that only sticks.
        let dissipation_error =
            (dissipated - expected).abs() / expected.abs().max(1e-6 * scales.energy);
        let languages = if method < 2 {
            Languages::Everything(largest_difference(c, fortran, &scales)?)
        } else {
            let peaks = [load, friction_load(case, fortran)?].map(|load| peak(&load));
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
            memory_full,
            fills_memory,
            peak: peak_over_limit(case, c, load_scale)?,
            dissipated,
            reference: expected,
            source,
            dissipation_error,
            load_error,
            tolerance,
            languages,
        })
    }

    /// Bounds that this row breaks, in words.
    fn broken(&self) -> Vec<String> {
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
        let place = format!("{}, {}", self.case, METHODS[usize::from(self.method)]);
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

impl Scales {
    fn new(case: &Case, patch: Option<&Table>, output: &Table) -> Result<Scales> {
        let (limit, moment) = match patch {
            None => {
                let top = output.column("pressure")?.iter().copied().fold(0.0, larger);
                (case.mu() * top, 1.0)
            }
            Some(patch) => {
                let forces = reference::product(patch.column("area")?, patch.column("pressure")?);
                let moments = reference::product(&forces, &reference::arms(patch)?);
                (
                    case.mu() * forces.iter().sum::<f64>(),
                    case.mu() * moments.iter().sum::<f64>(),
                )
            }
        };
        Ok(Scales {
            limit,
            moment,
            energy: limit * case.gcr(),
            slip: case.gcr(),
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
}

fn is_torsion(output: &Table) -> bool {
    output.find("moment").is_some()
}

/// Traction of a point, friction force or moment of a patch, per step.
pub fn friction_load(case: &Case, output: &Table) -> Result<Vec<Vec<f64>>> {
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
fn peak_over_limit(case: &Case, output: &Table, load_scale: f64) -> Result<f64> {
    let load = friction_load(case, output)?;
    let Some(pressure) = output.find("pressure") else {
        return Ok(peak(&load) / load_scale);
    };
    Ok(load
        .iter()
        .zip(pressure)
        .map(|(t, &p)| match p > 0.0 {
            true => length(t) / (case.mu() * p),
            // An open point carries nothing: any traction there breaks the bound.
            false if length(t) == 0.0 => 0.0,
            false => f64::INFINITY,
        })
        .fold(0.0, larger))
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

fn largest_difference(c: &Table, fortran: &Table, scales: &Scales) -> Result<f64> {
    let mut worst: f64 = 0.0;
    for (name, ours) in c.columns() {
        let theirs = fortran.column(name)?;
        let Some(scale) = scales.of(name) else {
            continue;
        };
        if ours.len() != theirs.len() {
            bail!("{} rows from C, {} from Fortran", ours.len(), theirs.len());
        }
        for (a, b) in ours.iter().zip(theirs) {
            worst = larger(worst, (a - b).abs() / scale);
        }
    }
    Ok(worst)
}

/// Two pressure distributions of one total: the same friction force at every step.
fn same_loop(r: &Replayed, earlier: &[Replayed]) -> Result<Vec<String>> {
    let Some(name) = &r.case.same_loop_as else {
        return Ok(Vec::new());
    };
    let other = earlier
        .iter()
        .find(|o| &o.case.name == name)
        .with_context(|| format!("case {name} has not been replayed"))?;
    let mut broken = Vec::new();
    for (method, (ours, theirs)) in r.c.iter().zip(&other.c).enumerate() {
        let limit = Scales::new(&r.case, r.patch.as_ref(), ours)?.limit;
        let difference = friction_load(&r.case, ours)?
            .iter()
            .zip(&friction_load(&other.case, theirs)?)
            .map(|(a, b)| distance(a, b) / limit)
            .fold(0.0, larger);
        if !within(difference, SAME_LAW) {
            broken.push(format!(
                "{}, {}: differs from {name} by {difference:.3e}",
                r.case.name, METHODS[method]
            ));
        }
    }
    Ok(broken)
}

fn print_table(rows: &[Row]) {
    let heading = format!(
        "{:<18} {:<9} {:>6} {:>6} {:>5} {:>9} {:>12} {:>12}  {:<15} {:>8} {:>8}  {}",
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
        "load",
        "C - Fortran"
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
            "{:<18} {:<9} {:>6} {:>6} {:>5} {:>9.6} {:>12.5e} {:>12.5e}  {:<15} {:>8.1e} {:>8.1e}  {}",
            row.case,
            METHODS[usize::from(row.method)],
            row.points,
            row.steps,
            full,
            row.peak,
            row.dissipated,
            row.reference,
            row.source,
            row.dissipation_error,
            row.load_error,
            languages
        );
    }
    println!(
        "\nfull: updates in which the memory was full and the least important reversal was dropped (the library's advisory \
         status);\n  what that costs is in the load, until a larger loop wipes out the small ones\n\
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
            method: 0,
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
