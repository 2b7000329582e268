//! The histories and patches that the drivers and the demo replay: cases.toml to CSV. Millimetres, newtons, MPa.

use crate::files::{File, decimals, read};
use anyhow::{Result, bail, ensure};
use mepc_oracle::closed::HertzSphere;
use serde::Deserialize;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    history: Vec<History>,
    patch: Vec<Patch>,
}

/// Columns against time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct History {
    name: String,
    about: String,
    /// Names of the columns after the time.
    columns: Vec<String>,
    /// End of the time, and steps in all.
    time: f64,
    steps: usize,
    /// One wave for each column,
    #[serde(default)]
    waves: Vec<Wave>,
    /// whose amplitudes grow from zero between this time and one unit later, after the columns but the last have risen to
    /// their means;
    loading: Option<f64>,
    /// or corners: times with the values of all columns there: straight in between.
    #[serde(default)]
    corners: Vec<Vec<f64>>,
    /// So many steps from the origin to the first row before time 0 (the last column is the pressure and stays).
    #[serde(default)]
    radial: usize,
}

/// max(least, mean + rate t + amplitude sin(2 pi (frequency t + phase))).
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wave {
    #[serde(default)]
    mean: f64,
    #[serde(default)]
    rate: f64,
    #[serde(default)]
    amplitude: f64,
    #[serde(default)]
    frequency: f64,
    #[serde(default)]
    phase: f64,
    least: Option<f64>,
}

/// Points with area and pressure.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Patch {
    name: String,
    about: String,
    shape: Shape,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Shape {
    /// Rings cut in equal angles, under one pressure.
    Disc {
        radius: f64,
        rings: usize,
        angles: usize,
        pressure: f64,
    },
    /// The contact circle of a sphere on a flat, in rings under their mean pressure.
    Hertz {
        young: f64,
        poisson: f64,
        radius: f64,
        mu: f64,
        approach: f64,
        rings: usize,
        angles: usize,
    },
    /// A square with a round hole, in layers around the hole. `reach`: the pressure falls as a parabola from the hole to
    /// zero at this radius; without it it is uniform.
    SquareWithHole {
        half_side: f64,
        hole: f64,
        layers: usize,
        per_octant: usize,
        force: f64,
        reach: Option<f64>,
    },
}

pub fn files(path: &std::path::Path) -> Result<Vec<File>> {
    let tables: Tables = read(path)?;
    let mut files: Vec<File> = Vec::new();
    for history in &tables.history {
        files.push(table(
            &history.name,
            &history.about,
            &format!("time,{}", history.columns.join(",")),
            &history.rows()?,
        ));
    }
    for patch in &tables.patch {
        files.push(table(
            &patch.name,
            &patch.about,
            "x,y,area,pressure",
            &patch.rows(),
        ));
    }
    for (k, file) in files.iter().enumerate() {
        ensure!(
            files[..k].iter().all(|other| other.name != file.name),
            "two tables are called {}",
            file.name
        );
    }
    Ok(files)
}

fn table(name: &str, about: &str, header: &str, rows: &[Vec<f64>]) -> File {
    let mut text = format!("# {about}\n{header}\n");
    for row in rows {
        let fields: Vec<String> = row.iter().map(|x| decimals(*x).to_string()).collect();
        writeln!(text, "{}", fields.join(",")).expect("writing to a string");
    }
    File {
        name: name.to_string(),
        text,
    }
}

impl Wave {
    /// `part`: of the amplitude.
    fn at(&self, time: f64, part: f64) -> f64 {
        let sine = (TAU * (self.frequency * time + self.phase)).sin();
        let value = self.mean + self.rate * time + part * self.amplitude * sine;
        value.max(self.least.unwrap_or(f64::NEG_INFINITY))
    }
}

impl History {
    fn rows(&self) -> Result<Vec<Vec<f64>>> {
        let at = |time: f64| -> Vec<f64> {
            if self.corners.is_empty() {
                let part = self
                    .loading
                    .map_or(1.0, |loading| (time - loading).clamp(0.0, 1.0));
                let mut row: Vec<f64> = self.waves.iter().map(|wave| wave.at(time, part)).collect();
                let last = row.len() - 1;
                if let Some(loading) = self.loading.filter(|loading| time < *loading) {
                    row[..last].iter_mut().for_each(|x| *x *= time / loading);
                }
                return row;
            }
            let index = self
                .corners
                .iter()
                .rposition(|corner| corner[0] <= time)
                .unwrap_or(0);
            let (a, b) = (
                &self.corners[index],
                &self.corners[(index + 1).min(self.corners.len() - 1)],
            );
            let part = if b[0] > a[0] {
                (time - a[0]) / (b[0] - a[0])
            } else {
                0.0
            };
            a[1..]
                .iter()
                .zip(&b[1..])
                .map(|(a, b)| a + (b - a) * part)
                .collect()
        };
        let end = at(0.0);
        if end.len() != self.columns.len() || self.waves.is_empty() == self.corners.is_empty() {
            bail!(
                "history {}: one wave for each column, or corners with all of them",
                self.name
            );
        }
        let start = (0..self.radial).map(|k| {
            let part = k as f64 / self.radial as f64;
            let mut row: Vec<f64> = end.iter().map(|x| part * x).collect();
            if let Some(last) = row.last_mut() {
                *last = end[end.len() - 1];
            }
            row.insert(0, part - 1.0);
            row
        });
        let rest = (0..=self.steps).map(|k| {
            let time = self.time * k as f64 / self.steps as f64;
            let mut row = at(time);
            row.insert(0, time);
            row
        });
        Ok(start.chain(rest).collect())
    }
}

impl Patch {
    fn rows(&self) -> Vec<Vec<f64>> {
        match self.shape {
            Shape::Disc {
                radius,
                rings,
                angles,
                pressure,
            } => polar_grid(radius, rings, angles, |_, _| pressure),
            Shape::Hertz {
                young,
                poisson,
                radius,
                mu,
                approach,
                rings,
                angles,
            } => {
                let sphere = HertzSphere {
                    young,
                    poisson,
                    radius,
                    mu,
                    approach,
                };
                polar_grid(sphere.contact_radius(), rings, angles, |a, b| {
                    sphere.ring_pressure(a, b)
                })
            }
            Shape::SquareWithHole {
                half_side,
                hole,
                layers,
                per_octant,
                force,
                reach,
            } => {
                let cells = square_with_hole(half_side, hole, layers, per_octant);
                let shape = |[x, y, _]: &[f64; 3]| match reach {
                    None => 1.0,
                    Some(reach) => (1.0 - ((x.hypot(*y) - hole) / (reach - hole)).powi(2)).max(0.0),
                };
                let total: f64 = cells.iter().map(|cell| cell[2] * shape(cell)).sum();
                let row =
                    |cell: &[f64; 3]| vec![cell[0], cell[1], cell[2], force / total * shape(cell)];
                cells.iter().map(row).collect()
            }
        }
    }
}

/// Rings cut in equal angles; `pressure` is the mean over the ring between two radii. The point of a cell has the
/// radius that gives the ring the right moment.
fn polar_grid(
    radius: f64,
    rings: usize,
    angles: usize,
    pressure: impl Fn(f64, f64) -> f64,
) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    for ring in 0..rings {
        let (a, b) = (
            radius * ring as f64 / rings as f64,
            radius * (ring + 1) as f64 / rings as f64,
        );
        let r = 2.0 / 3.0 * (b.powi(3) - a.powi(3)) / (b * b - a * a);
        let area = PI * (b * b - a * a) / angles as f64;
        for k in 0..angles {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / angles as f64).sin_cos();
            rows.push(vec![r * cos, r * sin, area, pressure(a, b)]);
        }
    }
    rows
}

/// Cells between the hole and the square, bounded by rays and by curves that cut each ray's strip into equal
/// areas, so that the areas are exact. Rows of x, y, area.
fn square_with_hole(half_side: f64, hole: f64, layers: usize, per_octant: usize) -> Vec<[f64; 3]> {
    let mut cells = Vec::new();
    let step = PI / 4.0 / per_octant as f64;
    for k in 0..8 * per_octant {
        // Angle from the nearest axis: there the edge is straight across.
        let (low, high) = (k as f64 * step, (k + 1) as f64 * step);
        let axis = (0.5 * (low + high) / (PI / 2.0)).round() * PI / 2.0;
        let tangents = (high - axis).tan() - (low - axis).tan();
        let strip = 0.5 * (half_side * half_side * tangents - hole * hole * step);
        let middle = 0.5 * (low + high);
        let edge = half_side / (middle - axis).cos();
        for layer in 0..layers {
            let part = (layer as f64 + 0.5) / layers as f64;
            let r = (hole * hole + part * (edge * edge - hole * hole)).sqrt();
            cells.push([r * middle.cos(), r * middle.sin(), strip / layers as f64]);
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables() -> Tables {
        read(std::path::Path::new("cases.toml")).expect("the cases")
    }

    fn patch(name: &str) -> Vec<Vec<f64>> {
        let tables = tables();
        tables
            .patch
            .iter()
            .find(|patch| patch.name == name)
            .expect("a patch")
            .rows()
    }

    fn force(name: &str) -> f64 {
        patch(name).iter().map(|row| row[2] * row[3]).sum()
    }

    #[test]
    fn lap_joint_area_and_forces() {
        for (name, expected) in [
            ("lap_patch_327", 327.0),
            ("lap_patch_902", 902.0),
            ("lap_patch_902_cone", 902.0),
        ] {
            assert!((force(name) - expected).abs() < 1e-9, "{name}");
            let area: f64 = patch(name).iter().map(|row| row[2]).sum();
            assert!((area - (400.0 - PI * 12.25)).abs() < 1e-10);
            // The points lie inside the square and outside the hole.
            assert!(
                patch(name)
                    .iter()
                    .all(|r| r[0].abs() < 10.0 && r[1].abs() < 10.0 && r[0].hypot(r[1]) > 3.5)
            );
        }
        // The cone leaves the corners open.
        assert!(patch("lap_patch_902_cone").iter().any(|row| row[3] == 0.0));
    }

    #[test]
    fn sphere_and_disc() {
        // Verification item 14.
        assert!((force("sphere_patch") - 286.79992).abs() < 1e-5);
        let moment: f64 = patch("disc_patch")
            .iter()
            .map(|r| r[2] * r[3] * r[0].hypot(r[1]))
            .sum();
        assert!((moment - 8.0 * 2.0 / 3.0 * PI * 125.0).abs() < 1e-9);
    }

    #[test]
    fn corners_are_met() {
        let tables = tables();
        let nested = tables
            .history
            .iter()
            .find(|history| history.name == "nested_reversals")
            .expect("a history");
        let rows = nested.rows().expect("rows");
        for (k, s) in [0.0, 0.8, -0.2, 0.3, -0.2, -0.8, 0.8]
            .into_iter()
            .enumerate()
        {
            assert!((rows[30 * k][1] - 0.002 * s).abs() < 1e-15);
        }
    }
}
