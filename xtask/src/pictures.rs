//! The demo's pictures: the loop of every case, and those that lay cases or methods over each other.

use std::path::Path;

use anyhow::{Context, Result};
use mepc_plot::{BLUE, Curve, Figure, GREEN, GREY, ORANGE, RGBColor, Stroke};

use crate::drivers::{Replayed, Table};
use crate::generated;

const MICRO: f64 = 1000.0;

/// A column as it goes on an axis.
struct Quantity {
    column: &'static str,
    label: &'static str,
    factor: f64,
}

const fn quantity(column: &'static str, label: &'static str, factor: f64) -> Quantity {
    Quantity {
        column,
        label,
        factor,
    }
}

const SLIP_1: Quantity = quantity("slip_1", "slip g₁ (µm)", MICRO);
const TRACTION_1: Quantity = quantity("traction_1", "traction τ₁ (MPa)", 1.0);
const TRACTION_2: Quantity = quantity("traction_2", "traction τ₂ (MPa)", 1.0);
const SLIP: Quantity = quantity("slip_1", "slip g (µm)", MICRO);
const TRACTION: Quantity = quantity("traction_1", "traction τ (MPa)", 1.0);
const TIME: Quantity = quantity("time", "time (s)", 1.0);
const DISSIPATED: Quantity = quantity("dissipated_energy", "dissipated energy (mJ/mm²)", 1.0);
const DISPLACEMENT: Quantity = quantity("displacement_1", "displacement u (µm)", MICRO);
const FORCE: Quantity = quantity("force_1", "force F (N)", 1.0);
const ROTATION: Quantity = quantity("rotation", "rotation θ (mrad)", 1000.0);
const MOMENT: Quantity = quantity("moment", "moment M (N mm)", 1.0);

/// Writes all pictures; with `docs` also the copy in the documentation. Returns how many there are.
pub fn write(cases: &[Replayed], output: &Path, docs: Option<&Path>) -> Result<usize> {
    let mut pictures = Vec::new();
    for r in cases {
        pictures.extend(of_case(r)?);
    }
    let find = |name: &str| {
        cases
            .iter()
            .find(|r| r.case.name == name)
            .with_context(|| format!("cases.toml has no case {name}"))
    };
    pictures.push((
        "three_methods_point".to_string(),
        three_methods(
            find("gross_slip")?,
            "Three methods, single point",
            &SLIP,
            &TRACTION,
        )?,
    ));
    let lap = three_methods(
        find("lap_902")?,
        "Three methods, lap joint, preload 902 N",
        &DISPLACEMENT,
        &FORCE,
    )?;
    if let Some(root) = docs {
        generated::write(&root.join("docs/loops.svg"), &lap.svg()?)?;
    }
    pictures.push(("three_methods_lap".to_string(), lap));
    let preloads = [
        (find("lap_327")?, "327 N, µ = 0.29", GREEN),
        (find("lap_592")?, "592 N, µ = 0.37", ORANGE),
        (find("lap_902")?, "902 N, µ = 0.42", BLUE),
    ];
    pictures.push((
        "three_preloads".to_string(),
        figure(
            "Lap joint, three preloads",
            &DISPLACEMENT,
            &FORCE,
            preloads.map(|(r, label, colour)| {
                curve(&r.c[0], &DISPLACEMENT, &FORCE, label, Stroke::Solid, colour)
            }),
        )?,
    ));
    pictures.push((
        "two_pressure_fields".to_string(),
        figure(
            "Lap joint without springs, two pressure fields",
            &DISPLACEMENT,
            &FORCE,
            [
                curve(
                    &find("lap_902_bare")?.c[0],
                    &DISPLACEMENT,
                    &FORCE,
                    "uniform pressure",
                    Stroke::Solid,
                    BLUE,
                ),
                curve(
                    &find("lap_902_bare_cone")?.c[0],
                    &DISPLACEMENT,
                    &FORCE,
                    "pressure cone",
                    Stroke::Marks,
                    ORANGE,
                ),
            ],
        )?,
    ));
    let rules = |name: &str| -> Result<[&Replayed; 2]> {
        Ok([find(name)?, find(&format!("{name}_proportional"))?])
    };
    let [consistent, _] = rules("pulsing_pressure")?;
    let mut held = two_rules(
        rules("pulsing_pressure")?,
        "Pulsing pressure, held slip",
        &TRACTION,
    )?;
    held.curves.push(curve(
        &consistent.c[0],
        &TIME,
        &quantity("pressure", "", consistent.case.mu()),
        "limit µp",
        Stroke::Dashed,
        GREY,
    )?);
    pictures.push(("two_rules_traction".to_string(), held));
    let title = "Pulsing pressure, small cycles of slip: energy dissipated since the start";
    pictures.push((
        "two_rules_energy".to_string(),
        two_rules(rules("pulsing_slip")?, title, &DISSIPATED)?,
    ));
    for (name, figure) in &pictures {
        generated::write(&output.join(format!("{name}.svg")), &figure.svg()?)?;
    }
    Ok(pictures.len())
}

/// The loop of a case under the memory law, from both drivers, and what else shows it.
fn of_case(r: &Replayed) -> Result<Vec<(String, Figure)>> {
    let name = &r.case.name;
    let title = r.case.title.as_str();
    let memory = &r.c[0];
    let pair = |x: &Quantity, y: &Quantity| both_languages(r, title, x, y);
    if memory.find("moment").is_some() {
        return Ok(vec![(name.clone(), pair(&ROTATION, &MOMENT)?)]);
    }
    if memory.find("force_1").is_some() {
        return Ok(vec![(name.clone(), pair(&DISPLACEMENT, &FORCE)?)]);
    }
    if memory.find("slip_2").is_some() {
        let mut path = pair(&TRACTION_1, &TRACTION_2)?;
        path.title = format!("{title}: traction path");
        path.equal_axes = true;
        path.curves.push(coulomb_circle(r)?);
        return Ok(vec![
            (name.clone(), pair(&SLIP_1, &TRACTION_1)?),
            (format!("{name}_traction_path"), path),
        ]);
    }
    let mut pictures = vec![(name.clone(), pair(&SLIP, &TRACTION)?)];
    let pressure = memory.column("pressure")?;
    if pressure.iter().any(|p| p != &pressure[0]) {
        let mut against_time = pair(&TIME, &TRACTION)?;
        against_time.title = format!("{title}: traction and its limit");
        against_time.curves.extend(coulomb_limits(r)?);
        pictures.push((format!("{name}_time"), against_time));
    }
    Ok(pictures)
}

fn both_languages(r: &Replayed, title: &str, x: &Quantity, y: &Quantity) -> Result<Figure> {
    let curves = vec![
        curve(&r.c[0], x, y, "C driver", Stroke::Solid, BLUE),
        curve(&r.fortran[0], x, y, "Fortran driver", Stroke::Marks, ORANGE),
    ];
    figure(title, x, y, curves)
}

fn three_methods(r: &Replayed, title: &str, x: &Quantity, y: &Quantity) -> Result<Figure> {
    let looks = [
        (Stroke::Solid, BLUE),
        (Stroke::Dashed, ORANGE),
        (Stroke::Solid, GREEN),
    ];
    // The memory law comes last, on top.
    let curves = [2, 1, 0].map(|method| {
        let label = ["memory effect", "standard penalty", "Lagrange multipliers"][method];
        curve(&r.c[method], x, y, label, looks[method].0, looks[method].1)
    });
    figure(title, x, y, curves)
}

/// A quantity against time under the consistent and the proportional rule.
fn two_rules(
    [consistent, proportional]: [&Replayed; 2],
    title: &str,
    y: &Quantity,
) -> Result<Figure> {
    let curves = [
        curve(
            &proportional.c[0],
            &TIME,
            y,
            "proportional rule (the paper's)",
            Stroke::Dashed,
            ORANGE,
        ),
        curve(
            &consistent.c[0],
            &TIME,
            y,
            "consistent rule",
            Stroke::Solid,
            BLUE,
        ),
    ];
    figure(title, &TIME, y, curves)
}

/// The limit +-mu p against time.
fn coulomb_limits(r: &Replayed) -> Result<Vec<Curve>> {
    let mu = r.case.mu();
    [("limit ±µp", 1.0), ("", -1.0)]
        .into_iter()
        .map(|(label, sign)| {
            let limit = quantity("pressure", "", sign * mu);
            curve(&r.c[0], &TIME, &limit, label, Stroke::Dashed, GREY)
        })
        .collect()
}

/// The limit mu p in the plane of tractions.
fn coulomb_circle(r: &Replayed) -> Result<Curve> {
    let limit = r.case.mu() * r.c[0].column("pressure")?[0];
    Ok(Curve {
        label: "limit µp".to_string(),
        points: (0..=360)
            .map(|degree| f64::from(degree).to_radians())
            .map(|angle| [limit * angle.cos(), limit * angle.sin()])
            .collect(),
        stroke: Stroke::Dashed,
        colour: GREY,
    })
}

fn figure(
    title: &str,
    x: &Quantity,
    y: &Quantity,
    curves: impl IntoIterator<Item = Result<Curve>>,
) -> Result<Figure> {
    Ok(Figure {
        title: title.to_string(),
        x_label: x.label.to_string(),
        y_label: y.label.to_string(),
        curves: curves.into_iter().collect::<Result<_>>()?,
        equal_axes: false,
    })
}

fn curve(
    table: &Table,
    x: &Quantity,
    y: &Quantity,
    label: &str,
    stroke: Stroke,
    colour: RGBColor,
) -> Result<Curve> {
    let horizontal = table.column(x.column)?;
    let vertical = table.column(y.column)?;
    Ok(Curve {
        label: label.to_string(),
        points: horizontal
            .iter()
            .zip(vertical)
            .map(|(h, v)| [h * x.factor, v * y.factor])
            .collect(),
        stroke,
        colour,
    })
}
