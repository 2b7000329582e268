//! Pictures that more than one command draws, and what they may be called.

use anyhow::{Result, bail};
use mepc_plot::{BLUE, Curve, Figure, GREEN, GREY, ORANGE, RGBColor, Stroke, ramp};
use std::path::Path;

/// Colours of the curves of a family, in their order.
const COLOURS: [RGBColor; 4] = [BLUE, ORANGE, GREEN, GREY];
const STROKES: [Stroke; 2] = [Stroke::Solid, Stroke::Dashed];

/// Refuses a name that promises another format: pictures are SVG.
///
/// # Errors
/// An ending that is not .svg; none at all is taken.
pub fn check(option: &str, file: &Path) -> Result<()> {
    match file.extension() {
        Some(ending) if !ending.eq_ignore_ascii_case("svg") => bail!(
            "{option}: {}: pictures are written as SVG only, not as .{}: call it {} (browsers show it, rsvg-convert and \
             Inkscape turn it into PNG and PDF)",
            file.display(),
            ending.display(),
            file.with_extension("svg").display()
        ),
        _ => Ok(()),
    }
}

/// A figure with unequal axes.
pub fn figure(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Figure {
    Figure {
        title: title.to_string(),
        x_label: x_label.to_string(),
        y_label: y_label.to_string(),
        curves,
        equal_axes: false,
    }
}

/// Colour and stroke of curve `k` of so many.
pub fn style(k: usize, count: usize) -> (RGBColor, Stroke) {
    if count <= COLOURS.len() * STROKES.len() {
        (COLOURS[k % 4], STROKES[k / 4])
    } else {
        // More than can be told apart at a glance: every one a little lighter.
        (ramp(k as f64 / (count - 1) as f64), STROKES[k % 2])
    }
}

/// What a replay gives, in the order of time.
pub struct Replayed {
    /// What is on the x axis of the first panel: its name and unit.
    pub along: &'static str,
    /// What is on the y axis.
    pub across: &'static str,
    /// Unit of the energies.
    pub energy: &'static str,
    /// Per direction, points (x, y).
    pub paths: Vec<Vec<[f64; 2]>>,
    /// Points (time, energy): stored, dissipated.
    pub energies: [Vec<[f64; 2]>; 2],
}

impl Replayed {
    pub fn new(
        along: &'static str,
        across: &'static str,
        energy: &'static str,
        directions: usize,
    ) -> Self {
        Replayed {
            along,
            across,
            energy,
            paths: vec![Vec::new(); directions],
            energies: Default::default(),
        }
    }

    /// Takes a step: (x, y) per direction, and the energies.
    pub fn push(&mut self, time: f64, places: impl Iterator<Item = [f64; 2]>, energies: [f64; 2]) {
        for (path, place) in self.paths.iter_mut().zip(places) {
            path.push(place);
        }
        for (curve, energy) in self.energies.iter_mut().zip(energies) {
            curve.push([time, energy]);
        }
    }

    /// The picture: the paths, and the energies over time.
    ///
    /// # Errors
    /// What cannot be drawn.
    pub fn svg(self, title: &str) -> Result<String> {
        let count = self.paths.len();
        let paths = self.paths.into_iter().enumerate().map(|(k, points)| {
            let (colour, stroke) = style(k, count);
            let label = match count {
                1 => String::new(),
                _ => format!("direction {}", k + 1),
            };
            Curve {
                label,
                points,
                stroke,
                colour,
            }
        });
        let paths = paths.collect();
        let names = ["stored", "dissipated since the start"];
        let colours = [BLUE, ORANGE];
        let energies = self
            .energies
            .into_iter()
            .zip(names.into_iter().zip(colours));
        let energies = energies.map(|(points, (label, colour))| Curve {
            label: label.to_string(),
            points,
            stroke: Stroke::Solid,
            colour,
        });
        mepc_plot::stacked(&[
            figure(title, self.along, self.across, paths),
            figure(
                "Energy",
                "time (as in the history)",
                self.energy,
                energies.collect(),
            ),
        ])
    }
}

/// A loop beside what was made of it.
pub struct Fitted {
    /// For the legend.
    pub label: String,
    /// Displacement (mm) and force (N), as measured.
    pub data: Vec<[f64; 2]>,
    /// The same of the law.
    pub law: Vec<[f64; 2]>,
    /// F_s (N) and X_s (mm).
    pub slip: [f64; 2],
}

/// The picture of a calibration: loops with the law's, and X_s over F_s with gcr + F_s / K_e.
///
/// # Errors
/// What cannot be drawn.
pub fn calibration(loops: Vec<Fitted>, gcr: f64, compliance: f64) -> Result<String> {
    let count = loops.len();
    let slips: Vec<[f64; 2]> = loops.iter().map(|fitted| fitted.slip).collect();
    let mut curves = Vec::new();
    let mut laws = Vec::new();
    for (k, fitted) in loops.into_iter().enumerate() {
        curves.push(Curve {
            label: if k == 0 { "data" } else { "" }.to_string(),
            points: fitted.data,
            stroke: Stroke::Solid,
            colour: GREY,
        });
        laws.push(Curve {
            label: fitted.label,
            points: fitted.law,
            stroke: Stroke::Dashed,
            colour: if count > 1 {
                ramp(k as f64 / count as f64)
            } else {
                ORANGE
            },
        });
    }
    curves.append(&mut laws);
    let loops = figure(
        "Contact law behind a spring",
        "displacement (mm)",
        "force (N)",
        curves,
    );
    let most = slips.iter().fold(0.0, |most: f64, slip| most.max(slip[0]));
    let line = Curve {
        label: "gcr + F_s / K_e".to_string(),
        points: [0.0, 1.05 * most]
            .map(|force| [force, gcr + force * compliance])
            .to_vec(),
        stroke: Stroke::Dashed,
        colour: ORANGE,
    };
    let marks = Curve {
        label: "loops".to_string(),
        points: slips,
        stroke: Stroke::Marks,
        colour: BLUE,
    };
    let line = figure(
        "Displacement at gross slip",
        "F_s (N)",
        "X_s (mm)",
        vec![line, marks],
    );
    mepc_plot::stacked(&[loops, line])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_formats_are_refused() {
        for name in ["l.svg", "a.b/L.SVG", "noending"] {
            check("--picture", Path::new(name)).expect(name);
        }
        for name in ["l.png", "l.pdf", "l.svg.gz"] {
            let words = check("--picture", Path::new(name))
                .expect_err(name)
                .to_string();
            assert!(
                words.starts_with(&format!(
                    "--picture: {name}: pictures are written as SVG only"
                )),
                "{words}"
            );
        }
    }
}
