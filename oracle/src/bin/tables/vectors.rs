//! Point histories with the values that a correct implementation of the law returns: vectors.toml to CSV.

use crate::files::{File, decimals, read};
use crate::paths::Path;
use anyhow::{Context, Result, bail, ensure};
use mepc_oracle::jenkins::Jenkins;
use mepc_oracle::limit::Limit;
use mepc_oracle::masing::Masing;
use mepc_oracle::twin::Twin;
use mepc_oracle::{Backbone, Status};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Slip elements of a twin, and sub-steps of an increment where the path or the limit turns.
const ELEMENTS: u32 = 4000;
const PARTS: u32 = 64;

/// The property names that the vectors use, in the library's order.
const NAMES: [&str; 13] = [
    "mu",
    "gcr",
    "exponent",
    "method",
    "reference_pressure",
    "backbone",
    "beta",
    "cohesion",
    "tau_max",
    "mu_late",
    "slip_late",
    "resolution",
    "fraction",
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    vector: Vec<Vector>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Vector {
    name: String,
    about: String,
    source: Source,
    properties: BTreeMap<String, f64>,
    path: Path,
    /// Pressures, again and again.
    #[serde(default)]
    pressure: Vec<f64>,
    /// Factors on mu, again and again.
    #[serde(default)]
    mu_factor: Vec<f64>,
    /// The direction in the plane of a path along a line.
    direction: Option<[f64; 2]>,
    /// Length of the state; without it the library's default.
    nstate: Option<usize>,
    /// Errors of traction, dissipated and stored energy; without it those of the source.
    tolerance: Option<[f64; 3]>,
    /// Which energies the file lists: 2 both, 1 the dissipated, 0 none. Without it what the source knows.
    energies: Option<u8>,
}

/// Where the expected values come from.
#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Source {
    /// Masing's rules at a constant limit; every closing is a virgin point.
    Masing,
    /// Masing's rules times the limit of the moment (proportional rule).
    ScaledMasing,
    /// A slip that is held from the second row on: T f(d/G) at the least limit so far (consistent rule).
    Held,
    /// One spring of constant stiffness (exponent 1, consistent rule).
    Jenkins,
    /// Slip elements.
    Elements,
}

struct Row {
    slip: [f64; 2],
    pressure: f64,
    factor: f64,
}

#[derive(Default)]
struct Expected {
    traction: [f64; 2],
    dissipated: f64,
    stored: f64,
    status: Option<Status>,
}

pub fn files(path: &std::path::Path) -> Result<Vec<File>> {
    let tables: Tables = read(path)?;
    let mut files: Vec<File> = Vec::new();
    for vector in &tables.vector {
        ensure!(
            files.iter().all(|file| file.name != vector.name),
            "two vectors are called {}",
            vector.name
        );
        let text = vector
            .text()
            .with_context(|| format!("vector {}", vector.name))?;
        files.push(File {
            name: vector.name.clone(),
            text,
        });
    }
    Ok(files)
}

impl Vector {
    fn property(&self, name: &str) -> f64 {
        self.properties.get(name).copied().unwrap_or(0.0)
    }

    fn backbone(&self) -> Backbone {
        match (
            self.property("method"),
            self.property("backbone"),
            self.property("exponent"),
        ) {
            (1.0, ..) => Backbone::PENALTY,
            (_, 1.0, q) => Backbone::Segalman {
                c: q - 2.0,
                beta: self.property("beta"),
            },
            (_, _, chi) => Backbone::Power {
                chi: if chi == 0.0 { 2.5 } else { chi },
            },
        }
    }

    fn limit(&self) -> Limit {
        let (late, length, cap) = (
            self.property("mu_late"),
            self.property("slip_late"),
            self.property("tau_max"),
        );
        Limit {
            mu: self.property("mu"),
            cohesion: self.property("cohesion"),
            cap: if cap > 0.0 { cap } else { f64::INFINITY },
            run_in: (late > 0.0).then_some((late, length)),
        }
    }

    fn directions(&self) -> usize {
        if self.direction.is_some() {
            2
        } else {
            self.path.directions()
        }
    }

    fn rows(&self) -> Vec<Row> {
        let gcr = self.property("gcr");
        let [x, y] = self.direction.unwrap_or([1.0, 1.0]);
        let again = |list: &[f64], k: usize, column: usize| match &self.path {
            Path::Rows { rows } if rows[k].len() > column => rows[k][column],
            _ if list.is_empty() => 1.0,
            _ => list[k % list.len()],
        };
        let points = self.path.points();
        let slips = points
            .iter()
            .map(|[a, b]| [decimals(a * gcr), decimals(b * gcr)]);
        slips
            .enumerate()
            .map(|(k, slip)| Row {
                slip: if self.direction.is_some() {
                    [slip[0] * x, slip[0] * y]
                } else {
                    slip
                },
                pressure: again(&self.pressure, k, 1),
                factor: again(&self.mu_factor, k, 2),
            })
            .collect()
    }

    /// The limit traction of every row; 0 open. The run-in goes with the slip length at the start of an increment.
    fn limits(&self, rows: &[Row]) -> Vec<f64> {
        let (limit, mut length, mut at) = (self.limit(), 0.0, [0.0; 2]);
        rows.iter()
            .map(|row| {
                let d = [row.slip[0] - at[0], row.slip[1] - at[1]];
                at = row.slip;
                let t = limit.at(row.pressure, row.factor, length).traction;
                if row.pressure > 0.0 {
                    length += d[0].hypot(d[1]);
                    t
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// The limit at the reference pressure.
    fn reference(&self) -> f64 {
        self.limit()
            .at(self.property("reference_pressure"), 1.0, 0.0)
            .traction
    }

    fn consistent(&self) -> bool {
        self.property("reference_pressure") > 0.0
    }

    /// Critical slip at a limit.
    fn critical(&self, limit: f64) -> f64 {
        let gcr = self.property("gcr");
        if self.consistent() {
            gcr * (limit / self.reference()).powf(1.0 / self.backbone().exponent())
        } else {
            gcr
        }
    }

    fn expected(&self, rows: &[Row]) -> Result<Vec<Expected>> {
        let limits = self.limits(rows);
        Ok(match self.source {
            Source::Masing | Source::ScaledMasing => self.by_masing(rows, &limits),
            Source::Held => self.held(rows, &limits)?,
            Source::Jenkins => self.by_spring(rows, &limits)?,
            Source::Elements => self.by_elements(rows, &limits),
        })
    }

    fn by_masing(&self, rows: &[Row], limits: &[f64]) -> Vec<Expected> {
        let backbone = self.backbone();
        let unit = self.direction.unwrap_or([1.0, 0.0]);
        let along = |row: &Row| {
            if unit[0].abs() > unit[1].abs() {
                row.slip[0] / unit[0]
            } else {
                row.slip[1] / unit[1]
            }
        };
        let mut point = Masing::new(backbone);
        let (mut lost, mut closed_at, mut before_row, mut energy) = (0.0, None, 0.0, 0.0);
        let mut virgin = true;
        rows.iter()
            .zip(limits)
            .map(|(row, &limit)| {
                let slip = along(row);
                let status = if row.pressure <= 0.0 {
                    lost += energy * (point.dissipated() + point.stored());
                    point = Masing::new(backbone);
                    (closed_at, energy) = (None, 0.0);
                    Some(Status::Open)
                } else {
                    let start = *closed_at.get_or_insert(before_row);
                    energy = limit * self.critical(limit);
                    let before = point.slip();
                    point.move_to((slip - start) / self.critical(limit));
                    let moved = point.slip() != before;
                    virgin &= !moved;
                    // The status after a pause says nothing new; before the first slip the point sticks.
                    if moved {
                        Some(point.status())
                    } else {
                        virgin.then_some(Status::Stick)
                    }
                };
                before_row = slip;
                let t = limit * point.traction();
                Expected {
                    traction: unit.map(|x| t * x),
                    dissipated: lost + energy * point.dissipated(),
                    stored: energy * point.stored(),
                    status,
                }
            })
            .collect()
    }

    /// Held at d: the elements that the least limit so far has pushed back stay there. The work was done at the first limit.
    fn held(&self, rows: &[Row], limits: &[f64]) -> Result<Vec<Expected>> {
        let (backbone, d) = (self.backbone(), rows[1].slip[0]);
        ensure!(
            self.consistent() && limits[0] == limits[1],
            "one limit until the slip is held"
        );
        ensure!(
            rows[1..].iter().all(|row| row.slip[0] == d),
            "the slip is held from the second row on"
        );
        let first = self.critical(limits[0]);
        let work = limits[0] * first * backbone.work(d / first);
        let mut least = limits[0];
        let mut expected = vec![Expected {
            status: Some(Status::Stick),
            ..Expected::default()
        }];
        for &limit in &limits[1..] {
            least = least.min(limit);
            let g = self.critical(least);
            let x = (d / g).min(1.0);
            let stored = least * g * (x * backbone.traction(x) - backbone.work(x));
            expected.push(Expected {
                traction: [least * backbone.traction(x), 0.0],
                dissipated: work - stored,
                stored,
                status: None,
            });
        }
        Ok(expected)
    }

    fn by_spring(&self, rows: &[Row], limits: &[f64]) -> Result<Vec<Expected>> {
        ensure!(
            self.backbone() == Backbone::PENALTY && self.consistent(),
            "exponent 1 and the consistent rule"
        );
        ensure!(
            self.directions() == 1,
            "one direction: there a spring with a limit is exact in one step"
        );
        let stiffness = self.reference() / self.property("gcr");
        let mut spring = Jenkins::new(stiffness);
        let mut at = 0.0;
        Ok(rows
            .iter()
            .zip(limits)
            .map(|(row, &limit)| {
                spring.step([row.slip[0] - at, 0.0], limit, 1);
                at = row.slip[0];
                Expected {
                    traction: spring.traction,
                    stored: spring.traction[0].powi(2) / (2.0 * stiffness),
                    ..Expected::default()
                }
            })
            .collect())
    }

    fn by_elements(&self, rows: &[Row], limits: &[f64]) -> Vec<Expected> {
        let (backbone, gcr) = (self.backbone(), self.property("gcr"));
        let most = limits.iter().copied().fold(0.0, f64::max);
        let mut twin = if self.consistent() {
            Twin::fixed_depths(backbone.exponent(), gcr, self.reference(), most, ELEMENTS)
        } else {
            Twin::fixed_limits(backbone, gcr, ELEMENTS)
        };
        let mut at = [0.0; 2];
        rows.iter()
            .zip(limits)
            .map(|(row, &limit)| {
                twin.step([row.slip[0] - at[0], row.slip[1] - at[1]], limit, PARTS);
                at = row.slip;
                Expected {
                    traction: twin.traction(),
                    dissipated: twin.dissipated(),
                    stored: twin.stored(),
                    status: (row.pressure <= 0.0).then_some(Status::Open),
                }
            })
            .collect()
    }

    fn source(&self) -> String {
        let method = match self.source {
            Source::Masing => "Masing's rules with a stack of reversals".to_string(),
            Source::ScaledMasing => "Masing's rules times the limit traction".to_string(),
            Source::Held => "T f(d/G) at the least limit traction so far".to_string(),
            Source::Jenkins => {
                return "one spring of constant stiffness with the limit traction of the moment"
                    .to_string();
            }
            Source::Elements => {
                let kind = if self.consistent() { "depth" } else { "limit" };
                format!("{ELEMENTS} slip elements of fixed {kind}, {PARTS} sub-steps an increment")
            }
        };
        match self.backbone() {
            Backbone::Power { chi } => format!("{method}; f = 1 - (1 - s)^{chi}"),
            Backbone::Segalman { c, beta } => {
                format!(
                    "{method}; Segalman's f with exponent q = {} and stiffness ratio {beta}",
                    c + 2.0
                )
            }
        }
    }

    /// Errors that are allowed: of a closed form rounding, of elements along a line their number, on curves what the
    /// default state promises (docs/verification.md, item 12), and 2 % of the dissipation.
    fn tolerance(&self, expected: &[Expected], scale: f64) -> [f64; 3] {
        if let Some(tolerance) = self.tolerance {
            return tolerance;
        }
        if self.source != Source::Elements {
            return [1e-12; 3];
        }
        if self.directions() == 1 {
            return [1e-5, 1e-4, 1e-5];
        }
        let traction = if self.property("exponent") == 2.5 {
            4e-3
        } else {
            8e-3
        };
        let total = expected.last().map_or(0.0, |last| last.dissipated) / scale;
        let dissipated = format!("{:.1e}", 0.02 * total)
            .parse()
            .expect("a printed number");
        [traction, dissipated, traction]
    }

    fn text(&self) -> Result<String> {
        if let Some(name) = self
            .properties
            .keys()
            .find(|name| !NAMES.contains(&name.as_str()))
        {
            bail!("{name} is no property");
        }
        let rows = self.rows();
        let expected = self.expected(&rows)?;
        let most = self.limits(&rows).into_iter().fold(0.0, f64::max);
        let tolerance = self.tolerance(&expected, most * self.property("gcr"));
        let directions = self.directions();
        let energies = self.energies.unwrap_or(match self.source {
            Source::ScaledMasing => 0,
            _ => 2,
        });
        let used = NAMES
            .iter()
            .filter_map(|name| Some(format!("{name}={}", self.properties.get(*name)?)));
        let nstate = self.nstate.unwrap_or(if directions == 1 { 44 } else { 84 });
        let mut text = String::new();
        writeln!(text, "# name: {}", self.name)?;
        writeln!(text, "# about: {}", self.about)?;
        writeln!(text, "# source: {}", self.source())?;
        writeln!(text, "# properties: {}", used.collect::<Vec<_>>().join(" "))?;
        writeln!(text, "# nstate: {nstate}")?;
        writeln!(text, "# tolerance_traction: {:e}", tolerance[0])?;
        let mut columns = vec!["time"];
        columns.extend(&["slip_1", "slip_2"][..directions]);
        columns.push("pressure");
        let with_factor = rows.iter().any(|row| row.factor != 1.0);
        if with_factor {
            columns.push("mu_factor");
        }
        columns.extend(&["expected_traction_1", "expected_traction_2"][..directions]);
        // The spring does not count what it loses.
        let with_dissipated = energies > 0 && self.source != Source::Jenkins;
        if with_dissipated {
            writeln!(text, "# tolerance_dissipated_energy: {:e}", tolerance[1])?;
            columns.push("expected_dissipated_energy");
        }
        if energies == 2 {
            writeln!(text, "# tolerance_stored_energy: {:e}", tolerance[2])?;
            columns.push("expected_stored_energy");
        }
        let with_status = expected.iter().any(|e| e.status.is_some());
        if with_status {
            columns.push("expected_status");
        }
        writeln!(text, "{}", columns.join(","))?;
        for (time, (row, expected)) in rows.iter().zip(&expected).enumerate() {
            let mut fields = vec![time.to_string()];
            fields.extend(
                row.slip[..directions]
                    .iter()
                    .map(|slip| (slip + 0.0).to_string()),
            );
            fields.push(row.pressure.to_string());
            if with_factor {
                fields.push(row.factor.to_string());
            }
            fields.extend(expected.traction[..directions].iter().map(|t| value(*t)));
            if with_dissipated {
                fields.push(value(expected.dissipated));
            }
            if energies == 2 {
                fields.push(value(expected.stored));
            }
            if with_status {
                fields.push(
                    expected
                        .status
                        .map_or(-1, |status| status as i32)
                        .to_string(),
                );
            }
            writeln!(text, "{}", fields.join(","))?;
        }
        Ok(text)
    }
}

/// Fifteen digits: more than any tolerance asks for, and the last bits of a mathematical library stay out.
fn value(x: f64) -> String {
    if x == 0.0 {
        "0".to_string()
    } else {
        format!("{x:.14e}")
    }
}
