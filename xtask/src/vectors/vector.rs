//! One test vector: a law, a history, the expected values, and the file they make.

use std::fmt::Write;

use mepc_oracle::masing::Masing;
use mepc_oracle::twin::{PressureRule, Twin};
use mepc_oracle::{Backbone, Status};

/// Slip elements of the twin.
pub const ELEMENTS: u32 = 4000;

/// Tolerances of the exact laws: traction over mu p, energies over mu p gcr.
pub const EXACT: Tolerance = Tolerance {
    traction: 1e-12,
    dissipated: 1e-12,
    stored: 1e-12,
};
/// What a twin of 4000 elements leaves out on straight histories.
pub const TWIN_STRAIGHT: Tolerance = Tolerance {
    traction: 1e-6,
    dissipated: 1e-6,
    stored: 1e-6,
};

#[derive(Clone, Copy)]
pub struct Tolerance {
    pub traction: f64,
    pub dissipated: f64,
    pub stored: f64,
}

/// The properties that the vectors use.
#[derive(Clone)]
pub struct Law {
    pub mu: f64,
    pub gcr: f64,
    pub chi: f64,
    pub method: u8,
    pub rule: u8,
    pub base_knots: u8,
    /// Some(beta) for Segalman's backbone.
    pub beta: Option<f64>,
    pub nstate: Option<u32>,
}

impl Law {
    pub fn power(mu: f64, gcr: f64, chi: f64) -> Law {
        Law {
            mu,
            gcr,
            chi,
            method: 0,
            rule: 0,
            base_knots: 16,
            beta: None,
            nstate: None,
        }
    }

    pub fn segalman(mu: f64, gcr: f64, c: f64, beta: f64) -> Law {
        Law {
            beta: Some(beta),
            ..Law::power(mu, gcr, c)
        }
    }

    pub fn nstate(self, nstate: u32) -> Law {
        Law {
            nstate: Some(nstate),
            ..self
        }
    }

    pub fn backbone(&self) -> Backbone {
        match (self.method, self.beta) {
            (1, _) => Backbone::PENALTY,
            (_, Some(beta)) => Backbone::Segalman { c: self.chi, beta },
            (_, None) => Backbone::Power { chi: self.chi },
        }
    }

    pub fn twin(&self) -> Twin {
        let rule = match self.rule {
            0 => PressureRule::Dissipative,
            _ => PressureRule::Proportional,
        };
        Twin::new(self.backbone(), self.mu, self.gcr, rule, ELEMENTS)
    }

    /// The property array without the trailing entries that have their default.
    pub fn props(&self) -> String {
        let (backbone, beta) = (self.beta.map_or(0.0, |_| 1.0), self.beta.unwrap_or(0.0));
        let all = [
            self.mu,
            self.gcr,
            self.chi,
            f64::from(self.method),
            f64::from(self.rule),
            0.005,
            0.0,
            0.0,
            f64::from(self.base_knots),
            backbone,
            beta,
        ];
        let defaults = [
            f64::NAN,
            f64::NAN,
            f64::NAN,
            0.0,
            0.0,
            0.005,
            0.0,
            0.0,
            16.0,
            0.0,
            0.0,
        ];
        let used = (0..all.len())
            .rfind(|&i| all[i] != defaults[i])
            .map_or(0, |i| i + 1);
        all[..used]
            .iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(",")
    }
}

/// End of a step.
#[derive(Clone, Copy)]
pub struct Step {
    pub slip: [f64; 2],
    pub pressure: f64,
}

#[derive(Clone, Copy)]
pub struct Expected {
    pub traction: [f64; 2],
    pub dissipated: f64,
    pub stored: f64,
    pub status: Option<Status>,
}

/// Which energies the file lists.
#[derive(Clone, Copy, PartialEq)]
pub enum Energies {
    Both,
    Dissipated,
    None,
}

pub struct Vector {
    pub name: String,
    pub about: &'static str,
    pub source: String,
    pub law: Law,
    pub directions: usize,
    pub steps: Vec<Step>,
    pub expected: Vec<Expected>,
    pub energies: Energies,
    pub tolerance: Tolerance,
}

impl Vector {
    /// One direction at constant pressure: Masing's rules. Slips in mm.
    pub fn straight(
        name: impl Into<String>,
        about: &'static str,
        law: Law,
        pressure: f64,
        slips: &[f64],
    ) -> Vector {
        Vector::oblique(name, about, law, pressure, slips, None)
    }

    /// The same along a direction in the plane.
    pub fn oblique(
        name: impl Into<String>,
        about: &'static str,
        law: Law,
        pressure: f64,
        slips: &[f64],
        direction: Option<[f64; 2]>,
    ) -> Vector {
        let [x, y] = direction.unwrap_or([1.0, 0.0]);
        let (limit, energy) = (law.mu * pressure, law.mu * pressure * law.gcr);
        let mut point = Masing::new(law.backbone());
        let mut steps = Vec::new();
        let mut expected = Vec::new();
        for &slip in slips {
            let before = point.slip();
            point.move_to(slip / law.gcr);
            let moved = point.slip() != before;
            let virgin =
                expected.iter().all(|e: &Expected| e.traction == [0.0; 2]) && point.slip() == 0.0;
            let t = limit * point.traction();
            steps.push(Step {
                slip: [slip * x, slip * y],
                pressure,
            });
            expected.push(Expected {
                traction: [t * x, t * y],
                dissipated: energy * point.dissipated(),
                stored: energy * point.stored(),
                // The status after a pause says nothing new; before the first slip the point sticks.
                status: match (moved, virgin) {
                    (true, _) => Some(point.status()),
                    (false, true) => Some(Status::Stick),
                    (false, false) => None,
                },
            });
        }
        Vector {
            name: name.into(),
            about,
            source: source(&law, "Masing's rules with a stack of reversals"),
            law,
            directions: if direction.is_some() { 2 } else { 1 },
            steps,
            expected,
            energies: Energies::Both,
            tolerance: EXACT,
        }
    }

    /// Any path and pressure: the parallel slip elements.
    pub fn twin(
        name: &str,
        about: &'static str,
        law: Law,
        directions: usize,
        steps: Vec<Step>,
    ) -> Vector {
        let mut twin = law.twin();
        let mut at = [0.0; 2];
        let expected: Vec<Expected> = steps
            .iter()
            .map(|step| {
                twin.step([step.slip[0] - at[0], step.slip[1] - at[1]], step.pressure);
                at = step.slip;
                Expected {
                    traction: twin.traction(),
                    dissipated: twin.dissipated(),
                    stored: twin.stored(),
                    status: (step.pressure <= 0.0).then_some(Status::Open),
                }
            })
            .collect();
        let one_element = law.backbone() == Backbone::PENALTY;
        let mut vector = Vector {
            name: name.to_string(),
            about,
            source: if one_element {
                "one slip element with radial return, which is the standard penalty law".to_string()
            } else {
                source(
                    &law,
                    &format!("twin N={ELEMENTS}, parallel slip elements with radial return"),
                )
            },
            law,
            directions,
            steps,
            expected,
            energies: Energies::Both,
            tolerance: if one_element { EXACT } else { TWIN_STRAIGHT },
        };
        if directions == 2 && !one_element {
            vector.tolerance = curved(&vector);
        }
        vector
    }

    pub fn tolerance(self, traction: f64, energy: f64) -> Vector {
        Vector {
            tolerance: Tolerance {
                traction,
                dissipated: energy,
                stored: energy,
            },
            ..self
        }
    }

    pub fn energies(self, energies: Energies) -> Vector {
        Vector { energies, ..self }
    }

    pub fn nstate(&self) -> u32 {
        let default = if self.directions == 1 { 25 } else { 64 };
        self.law.nstate.unwrap_or(default)
    }

    pub fn text(&self) -> String {
        let mut out = String::new();
        let t = &self.tolerance;
        let mut line = |text: String| {
            out.push_str(&text);
            out.push('\n');
        };
        line(format!("# name: {}", self.name));
        line(format!("# about: {}", self.about));
        line(format!("# source: {}", self.source));
        line(format!("# props: {}", self.law.props()));
        line(format!("# nstate: {}", self.nstate()));
        line(format!("# tolerance_traction: {:e}", t.traction));
        let mut columns: Vec<&str> = vec!["time"];
        columns.extend(&["slip_1", "slip_2"][..self.directions]);
        columns.push("pressure");
        columns.extend(&["expected_traction_1", "expected_traction_2"][..self.directions]);
        if self.energies != Energies::None {
            line(format!("# tolerance_dissipated_energy: {:e}", t.dissipated));
            columns.push("expected_dissipated_energy");
        }
        if self.energies == Energies::Both {
            line(format!("# tolerance_stored_energy: {:e}", t.stored));
            columns.push("expected_stored_energy");
        }
        let with_status = self.expected.iter().any(|e| e.status.is_some());
        if with_status {
            columns.push("expected_status");
        }
        line(columns.join(","));
        for (time, (step, expected)) in self.steps.iter().zip(&self.expected).enumerate() {
            let mut row = time.to_string();
            let mut add = |text: String| write!(row, ",{text}").expect("writing to a string");
            for slip in &step.slip[..self.directions] {
                add((slip + 0.0).to_string());
            }
            add(step.pressure.to_string());
            for traction in &expected.traction[..self.directions] {
                add(value(*traction));
            }
            if self.energies != Energies::None {
                add(value(expected.dissipated));
            }
            if self.energies == Energies::Both {
                add(value(expected.stored));
            }
            if with_status {
                add(expected.status.map_or(-1, |s| s as i32).to_string());
            }
            line(row);
        }
        out
    }
}

/// Fifteen digits: more than any tolerance asks for, and the last bits of a mathematical library stay out.
pub fn value(x: f64) -> String {
    if x == 0.0 {
        "0".to_string()
    } else {
        format!("{x:.14e}")
    }
}

pub fn source(law: &Law, method: &str) -> String {
    match law.backbone() {
        Backbone::Power { chi } => format!("{method}; f = 1 - (1 - s)^{chi}"),
        Backbone::Segalman { c, beta } => {
            format!("{method}; Segalman's f with exponent {c} and stiffness ratio {beta}")
        }
    }
}

/// Tolerances for a curved path: what the default base grid promises. The dissipation is held to 2.5 % of the
/// whole, the stored energy like the traction.
pub fn curved(vector: &Vector) -> Tolerance {
    let law = &vector.law;
    let top = vector.steps.iter().map(|s| s.pressure).fold(0.0, f64::max);
    let total = vector.expected.last().map_or(0.0, |e| e.dissipated) / (law.mu * top * law.gcr);
    let traction = if law.chi == 2.5 { 0.0075 } else { 0.01 };
    let dissipated = format!("{:.1e}", 0.025 * total)
        .parse()
        .expect("a printed number");
    Tolerance {
        traction,
        dissipated,
        stored: traction,
    }
}
