//! `cargo xtask cases`: the histories and patches of cases/. Millimetres, newtons, MPa.
//!
//! Which law each is replayed on is in cases/cases.toml; the critical slips here must be those there.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use anyhow::Result;
use mepc_oracle::closed::HertzSphere;

use crate::generated::{Generated, decimals, no_strays, settle};

/// Critical slip of the single points, mm.
const GCR: f64 = 0.002;

pub fn run(root: &Path, check: bool) -> Result<()> {
    let directory = root.join("cases");
    let files: Vec<Generated> = all()
        .into_iter()
        .map(|table| Generated {
            path: directory.join(format!("{}.csv", table.name)),
            text: table.text(),
        })
        .collect();
    let count = settle(&files, check, "cargo xtask cases")?;
    no_strays(&directory, "csv", &files)?;
    println!(
        "cases: {count} files {}",
        if check { "up to date" } else { "written" }
    );
    Ok(())
}

/// A CSV file with a line of explanation.
struct Table {
    name: String,
    about: String,
    columns: &'static str,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn text(&self) -> String {
        let mut text = format!("# {}\n{}\n", self.about, self.columns);
        for row in &self.rows {
            let fields: Vec<String> = row.iter().map(|x| decimals(*x, 12).to_string()).collect();
            text.push_str(&fields.join(","));
            text.push('\n');
        }
        text
    }
}

/// A history row for each of 0, 1, .. `steps`, from the time in cycles.
fn history(
    name: &str,
    about: &str,
    columns: &'static str,
    cycles: f64,
    steps: usize,
    row: impl Fn(f64) -> Vec<f64>,
) -> Table {
    let rows = (0..=steps)
        .map(|k| {
            let time = cycles * k as f64 / steps as f64;
            let mut fields = vec![time];
            fields.extend(row(time));
            fields
        })
        .collect();
    Table {
        name: name.to_string(),
        about: about.to_string(),
        columns,
        rows,
    }
}

/// Straight from one turning point (in gcr) to the next, one unit of time each, at constant pressure.
fn zigzag(name: &str, about: &str, pressure: f64, turning_points: &[f64], steps: usize) -> Table {
    let branches = turning_points.len() - 1;
    history(
        name,
        about,
        POINT,
        branches as f64,
        branches * steps,
        |time| {
            let branch = (time as usize).min(branches - 1);
            let (from, to) = (turning_points[branch], turning_points[branch + 1]);
            vec![
                GCR * (from + (to - from) * (time - branch as f64)),
                pressure,
            ]
        },
    )
}

const POINT: &str = "time,slip_1,pressure";
const PLANE: &str = "time,slip_1,slip_2,pressure";
const PATCH: &str = "x,y,area,pressure";

fn all() -> Vec<Table> {
    let mut tables = points();
    tables.extend(curves());
    tables.extend(sphere());
    tables.extend(torsion());
    tables.extend(lap_joint());
    tables
}

fn points() -> Vec<Table> {
    let sine = |amplitude: f64, time: f64| GCR * amplitude * (TAU * time).sin();
    vec![
        zigzag(
            "monotone",
            "first loading to twice the critical slip; mm, MPa",
            10.0,
            &[0.0, 2.0],
            100,
        ),
        history(
            "partial_reversals",
            "three cycles of half the critical slip; mm, MPa",
            POINT,
            3.0,
            360,
            |t| vec![sine(0.5, t), 10.0],
        ),
        zigzag(
            "nested_reversals",
            "a small loop inside a larger one; mm, MPa",
            10.0,
            &[0.0, 0.8, -0.2, 0.3, -0.2, -0.8, 0.8],
            30,
        ),
        zigzag(
            "full_memory",
            "ever smaller loops inside each other, then a large one; mm, MPa",
            10.0,
            &[0.0, 0.8, -0.6, 0.6, -0.4, 0.4, -0.2, 0.2, 1.2, -1.2, 1.2],
            30,
        ),
        zigzag(
            "gross_slip",
            "gross slip and return, three times the critical slip; mm, MPa",
            10.0,
            &[0.0, 3.0, -3.0, 3.0],
            240,
        ),
        history(
            "falling_pressure",
            "four cycles of 1.5 critical slips while the pressure falls from 20 to 4 MPa; mm, MPa",
            POINT,
            4.0,
            480,
            |t| vec![sine(1.5, t), 20.0 - 4.0 * t],
        ),
        history(
            "rising_pressure",
            "four cycles of 1.5 critical slips while the pressure rises from 4 to 20 MPa; mm, MPa",
            POINT,
            4.0,
            480,
            |t| vec![sine(1.5, t), 4.0 + 4.0 * t],
        ),
        history(
            "opening",
            "four cycles of 1.2 critical slips while the contact opens and closes twice; mm, MPa",
            POINT,
            4.0,
            480,
            // Closed for a little more than half of the time.
            |t| vec![sine(1.2, t), (2.0 + 10.0 * (PI * t).cos()).max(0.0)],
        ),
    ]
}

fn curves() -> Vec<Table> {
    let turns = 3.0;
    let per_turn = 400;
    let circle = |name: &str, about: &str, radius: f64| {
        let radial = 80;
        let mut table = history(name, about, PLANE, turns, 3 * per_turn, |t| {
            let (sin, cos) = (TAU * t).sin_cos();
            vec![GCR * radius * cos, GCR * radius * sin, 10.0]
        });
        // A radial start before time 0 of the turns.
        let start = (0..radial).map(|k| {
            let part = k as f64 / radial as f64;
            vec![part - 1.0, GCR * radius * part, 0.0, 10.0]
        });
        table.rows = start.chain(std::mem::take(&mut table.rows)).collect();
        table
    };
    vec![
        circle(
            "circle",
            "radial start, three turns of radius half the critical slip; mm, MPa",
            0.5,
        ),
        circle(
            "circle_gross",
            "radial start, three turns of radius twice the critical slip; mm, MPa",
            2.0,
        ),
        history(
            "figure_eight",
            "three turns of a figure of eight, 1.2 by 0.6 critical slips; mm, MPa",
            PLANE,
            turns,
            3 * per_turn,
            |t| {
                let a = 1.2 * GCR;
                vec![a * (TAU * t).sin(), a / 2.0 * (2.0 * TAU * t).sin(), 10.0]
            },
        ),
    ]
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

/// Verification item 14: a steel sphere of 4.17 mm radius pressed 10 um into a flat.
const SPHERE: HertzSphere = HertzSphere {
    young: 192_850.0,
    poisson: 0.29,
    radius: 4.174432,
    mu: 0.2,
    approach: 0.010,
};

fn sphere() -> Vec<Table> {
    let amplitude = 1.5 * SPHERE.critical_slip();
    vec![
        Table {
            name: "sphere_patch".to_string(),
            about: format!(
                "Hertz pressure of a sphere on a flat: contact radius {:.6} mm, force {:.5} N; mm, mm2, MPa",
                SPHERE.contact_radius(),
                SPHERE.normal_force()
            ),
            columns: PATCH,
            rows: polar_grid(SPHERE.contact_radius(), 14, 24, |a, b| {
                SPHERE.ring_pressure(a, b)
            }),
        },
        history(
            "sphere_history",
            "two cycles of 1.5 critical slips; mm",
            "time,displacement_1",
            2.0,
            320,
            |t| vec![amplitude * (TAU * t).sin()],
        ),
    ]
}

fn torsion() -> Vec<Table> {
    let radius = 5.0;
    vec![
        Table {
            name: "disc_patch".to_string(),
            about: "flat disc of radius 5 mm under uniform pressure; mm, mm2, MPa".to_string(),
            columns: PATCH,
            rows: polar_grid(radius, 14, 24, |_, _| 8.0),
        },
        history(
            "torsion_history",
            "two cycles of rotation about the centre: 1.6 critical slips at the edge; mm, rad",
            "time,displacement_1,displacement_2,rotation",
            2.0,
            320,
            |t| vec![0.0, 0.0, 1.6 * GCR / radius * (TAU * t).sin()],
        ),
    ]
}

/// Half the side of the lap joint's contact and radius of its hole, mm.
const HALF_SIDE: f64 = 10.0;
const HOLE: f64 = 3.5;

/// Cells between the hole and the square, bounded by rays and by curves that cut each ray's strip into equal
/// areas, so that the areas are exact. Rows of x, y, area.
fn square_with_hole(layers: usize, per_octant: usize) -> Vec<[f64; 3]> {
    let mut cells = Vec::new();
    let step = PI / 4.0 / per_octant as f64;
    for k in 0..8 * per_octant {
        // Angle from the nearest axis: there the edge is straight across.
        let (low, high) = (k as f64 * step, (k + 1) as f64 * step);
        let axis = (0.5 * (low + high) / (PI / 2.0)).round() * PI / 2.0;
        let tangents = (high - axis).tan() - (low - axis).tan();
        let strip = 0.5 * (HALF_SIDE * HALF_SIDE * tangents - HOLE * HOLE * step);
        let middle = 0.5 * (low + high);
        let edge = HALF_SIDE / (middle - axis).cos();
        for layer in 0..layers {
            let part = (layer as f64 + 0.5) / layers as f64;
            let r = (HOLE * HOLE + part * (edge * edge - HOLE * HOLE)).sqrt();
            cells.push([r * middle.cos(), r * middle.sin(), strip / layers as f64]);
        }
    }
    cells
}

/// Uniform pressure under the bolt force.
fn uniform(_: f64) -> f64 {
    1.0
}

/// Pressure cone under the bolt head: the head (10 mm across) spreads at 30 degrees through a 5 mm plate to a
/// radius of 7.887 mm; the pressure falls off from the hole as a parabola that reaches zero there.
fn cone(r: f64) -> f64 {
    let reach = 5.0 + 5.0 / 3f64.sqrt();
    (1.0 - ((r - HOLE) / (reach - HOLE)).powi(2)).max(0.0)
}

fn lap_patch(name: &str, about: &str, force: f64, shape: impl Fn(f64) -> f64) -> Table {
    let cells = square_with_hole(8, 4);
    let weight = |[x, y, area]: &[f64; 3]| area * shape(x.hypot(*y));
    let total: f64 = cells.iter().map(weight).sum();
    Table {
        name: name.to_string(),
        about: format!("20 x 20 mm with a 7 mm hole, {about}, bolt force {force} N; mm, mm2, MPa"),
        columns: PATCH,
        rows: cells
            .iter()
            .map(|&[x, y, area]| vec![x, y, area, force / total * shape(x.hypot(y))])
            .collect(),
    }
}

fn lap_joint() -> Vec<Table> {
    let mut tables: Vec<Table> = [327.0, 592.0, 902.0]
        .into_iter()
        .map(|force| {
            lap_patch(
                &format!("lap_patch_{force}"),
                "uniform pressure",
                force,
                uniform,
            )
        })
        .collect();
    tables.push(lap_patch(
        "lap_patch_902_cone",
        "pressure cone of 7.887 mm radius",
        902.0,
        cone,
    ));
    tables.push(history(
        "lap_history",
        "first loading and one cycle of 0.02 mm; mm",
        "time,displacement_1",
        1.25,
        750,
        |t| vec![0.02 * (TAU * t).sin()],
    ));
    tables
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(name: &str) -> Table {
        all().into_iter().find(|t| t.name == name).unwrap()
    }

    fn force(name: &str) -> f64 {
        table(name).rows.iter().map(|r| r[2] * r[3]).sum()
    }

    #[test]
    fn lap_joint_area_and_forces() {
        let area: f64 = square_with_hole(8, 4).iter().map(|c| c[2]).sum();
        assert!((area - (400.0 - PI * 12.25)).abs() < 1e-10);
        for (name, expected) in [
            ("lap_patch_327", 327.0),
            ("lap_patch_902", 902.0),
            ("lap_patch_902_cone", 902.0),
        ] {
            assert!((force(name) - expected).abs() < 1e-9, "{name}");
        }
        // The cone leaves the corners open.
        assert!(table("lap_patch_902_cone").rows.iter().any(|r| r[3] == 0.0));
    }

    /// The cells lie inside the square and outside the hole.
    #[test]
    fn lap_joint_points() {
        for [x, y, area] in square_with_hole(8, 4) {
            assert!(x.abs() < HALF_SIDE && y.abs() < HALF_SIDE && x.hypot(y) > HOLE && area > 0.0);
        }
    }

    #[test]
    fn sphere_carries_its_force() {
        assert!((force("sphere_patch") - SPHERE.normal_force()).abs() < 1e-9);
    }

    #[test]
    fn disc_has_the_moment_of_a_disc() {
        let moment: f64 = table("disc_patch")
            .rows
            .iter()
            .map(|r| r[2] * r[3] * r[0].hypot(r[1]))
            .sum();
        assert!((moment - 8.0 * 2.0 / 3.0 * PI * 125.0).abs() < 1e-9);
    }

    #[test]
    fn zigzag_meets_its_turning_points() {
        let rows = table("nested_reversals").rows;
        for (k, s) in [0.0, 0.8, -0.2, 0.3, -0.2, -0.8, 0.8]
            .into_iter()
            .enumerate()
        {
            assert!((rows[30 * k][1] - GCR * s).abs() < 1e-15);
        }
    }
}
