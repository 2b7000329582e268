//! The law as what it stands for: many slip elements side by side.
//!
//! Element i is a spring of stiffness w_i in series with a slider that gives way at the deflection r_i, in one
//! or two tangential directions (radial return). The stiffness between the limits a and b is f'(a) - f'(b), and
//! one element at the centre of that stiffness carries it, so that all elements together saturate at exactly 1;
//! a jump of f' at 1 is one more element there. Physical units: slip in length, traction and pressure in
//! force per area, energy in force per length.

use crate::Backbone;

/// What a change of pressure does to the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PressureRule {
    /// Stiffness that arrives with rising pressure arrives unloaded.
    Dissipative,
    /// Deflections are kept, so that tractions scale with the pressure both ways.
    Proportional,
}

#[derive(Debug, Clone, Copy)]
struct Element {
    limit: f64,
    stiffness: f64,
    deflection: [f64; 2],
}

/// The parallel slip elements of one contact point.
#[derive(Debug, Clone)]
pub struct Twin {
    mu: f64,
    gcr: f64,
    rule: PressureRule,
    elements: Vec<Element>,
    pressure: f64,
    dissipated: f64,
}

impl Twin {
    /// A virgin point of `n` elements (and one more when f' jumps at 1).
    pub fn new(backbone: Backbone, mu: f64, gcr: f64, rule: PressureRule, n: u32) -> Self {
        let mut elements = Vec::new();
        let mut add = |limit: f64, stiffness: f64| {
            if stiffness > 0.0 {
                elements.push(Element {
                    limit,
                    stiffness,
                    deflection: [0.0; 2],
                });
            }
        };
        // Moment of the stiffness below r about zero.
        let moment = |r: f64| backbone.traction(r) - r * backbone.tangent(r);
        for k in 0..n {
            let (a, b) = (cell(backbone, k, n), cell(backbone, k + 1, n));
            let stiffness = backbone.tangent(a) - backbone.tangent(b);
            add(((moment(b) - moment(a)) / stiffness).clamp(a, b), stiffness);
        }
        add(1.0, backbone.tangent(1.0));
        Twin {
            mu,
            gcr,
            rule,
            elements,
            pressure: 0.0,
            dissipated: 0.0,
        }
    }

    /// Slides by `increment` (zero second component for one direction) while the pressure goes to `pressure`.
    pub fn step(&mut self, increment: [f64; 2], pressure: f64) {
        self.change_pressure(pressure);
        if self.pressure == 0.0 {
            return;
        }
        let d = [increment[0] / self.gcr, increment[1] / self.gcr];
        let mut plastic_work = 0.0;
        for element in &mut self.elements {
            let trial = [element.deflection[0] + d[0], element.deflection[1] + d[1]];
            let length = trial[0].hypot(trial[1]);
            element.deflection = trial;
            if length > element.limit {
                let shrink = element.limit / length;
                element.deflection = [trial[0] * shrink, trial[1] * shrink];
                plastic_work += element.stiffness * element.limit * (length - element.limit);
            }
        }
        self.dissipated += self.mu * self.pressure * self.gcr * plastic_work;
    }

    /// Before the slip: what the elements store, and lose, when the pressure changes.
    fn change_pressure(&mut self, pressure: f64) {
        let before = self.stored();
        let new = pressure.max(0.0);
        let scale = if new == 0.0 {
            0.0
        } else if new > self.pressure && self.rule == PressureRule::Dissipative {
            self.pressure / new
        } else {
            1.0
        };
        for element in &mut self.elements {
            for e in &mut element.deflection {
                *e *= scale;
            }
        }
        self.pressure = new;
        self.dissipated += before - self.stored();
    }

    /// Traction.
    pub fn traction(&self) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for element in &self.elements {
            sum[0] += element.stiffness * element.deflection[0];
            sum[1] += element.stiffness * element.deflection[1];
        }
        let limit = self.mu * self.pressure;
        [limit * sum[0], limit * sum[1]]
    }

    /// Elastic energy per area.
    pub fn stored(&self) -> f64 {
        let sum: f64 = self
            .elements
            .iter()
            .map(|e| e.stiffness * (e.deflection[0].powi(2) + e.deflection[1].powi(2)) / 2.0)
            .sum();
        self.mu * self.pressure * self.gcr * sum
    }

    /// Energy dissipated per area since the start: by sliding and by changes of pressure.
    pub fn dissipated(&self) -> f64 {
        self.dissipated
    }
}

/// End of cell k of n. Cells shrink where the stiffness is dense: the error of one cell is its stiffness times
/// its width, and equal parts of the integral of sqrt(-f'') make that the same in all.
fn cell(backbone: Backbone, k: u32, n: u32) -> f64 {
    let part = f64::from(k) / f64::from(n);
    match backbone {
        Backbone::Power { chi } => 1.0 - (1.0 - part).powf(2.0 / chi),
        Backbone::Segalman { c, .. } => part.powf(2.0 / (c + 2.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{closed, masing::Masing};

    const BACKBONES: [Backbone; 6] = [
        Backbone::Power { chi: 1.0 },
        Backbone::Power { chi: 1.5 },
        Backbone::Power { chi: 2.5 },
        Backbone::Power { chi: 4.0 },
        Backbone::Segalman {
            c: -0.842,
            beta: 0.5,
        },
        Backbone::Segalman { c: 0.0, beta: 2.0 },
    ];

    fn unit(backbone: Backbone, n: u32) -> Twin {
        Twin::new(backbone, 1.0, 1.0, PressureRule::Dissipative, n)
    }

    /// Largest differences of traction, dissipated and stored energy from Masing's rules on a nested history.
    fn difference(backbone: Backbone, n: u32) -> f64 {
        let (mut twin, mut exact) = (unit(backbone, n), Masing::new(backbone));
        let mut worst: f64 = 0.0;
        for s in [0.0, 0.3, 0.8, -0.2, 0.3, 0.1, -0.2, -0.8, -1.7, 0.05, 1e-3] {
            twin.step([s - exact.slip(), 0.0], 1.0);
            exact.move_to(s);
            worst = worst
                .max((twin.traction()[0] - exact.traction()).abs())
                .max((twin.dissipated() - exact.dissipated()).abs())
                .max((twin.stored() - exact.stored()).abs());
        }
        worst
    }

    #[test]
    fn saturates_at_exactly_one() {
        for backbone in BACKBONES {
            let mut twin = unit(backbone, 400);
            twin.step([3.0, 4.0], 1.0);
            let [x, y] = twin.traction();
            assert!(
                (x - 0.6).abs() < 1e-13 && (y - 0.8).abs() < 1e-13,
                "{backbone:?}"
            );
        }
    }

    #[test]
    fn converges_to_masing() {
        for backbone in BACKBONES {
            let (coarse, fine) = (difference(backbone, 250), difference(backbone, 4000));
            assert!(fine < 2e-7, "{backbone:?}: {fine:e}");
            // Second order: sixteen times the elements, 1/256 of the error. chi = 1 is one exact element.
            assert!(
                fine < coarse / 60.0 || coarse < 1e-13,
                "{backbone:?}: {coarse:e} {fine:e}"
            );
        }
    }

    /// Item 8: a straight history in any direction is the one-dimensional one.
    #[test]
    fn straight_in_any_direction() {
        let (mut along, mut oblique) = (unit(BACKBONES[2], 500), unit(BACKBONES[2], 500));
        for d in [0.7, -1.1, 0.6, -0.3, 2.0, -0.8] {
            along.step([d, 0.0], 1.0);
            oblique.step([0.28 * d, -0.96 * d], 1.0);
            let t = along.traction()[0];
            let [x, y] = oblique.traction();
            assert!((x - 0.28 * t).abs() < 1e-12 && (y + 0.96 * t).abs() < 1e-12);
            assert!((along.dissipated() - oblique.dissipated()).abs() < 1e-12);
        }
    }

    /// Item 13: steady turns of a circle against the integral over the elements.
    #[test]
    fn circle() {
        for (backbone, radius, turn_steps, tolerance) in [
            (BACKBONES[2], 0.5, 2000, 4e-3),
            (BACKBONES[2], 2.0, 2000, 4e-3),
            (BACKBONES[4], 1.3, 2000, 6e-3),
        ] {
            let mut twin = unit(backbone, 1000);
            let mut at = [radius, 0.0];
            twin.step(at, 1.0);
            let mut turn = 0.0;
            for _ in 0..3 {
                let before = twin.dissipated();
                for k in 1..=turn_steps {
                    let phase = std::f64::consts::TAU * f64::from(k) / f64::from(turn_steps);
                    let next = [radius * phase.cos(), radius * phase.sin()];
                    twin.step([next[0] - at[0], next[1] - at[1]], 1.0);
                    at = next;
                }
                turn = twin.dissipated() - before;
            }
            let exact = closed::circle_dissipation(backbone, radius);
            assert!(
                (turn / exact - 1.0).abs() < tolerance,
                "{backbone:?}: {turn} {exact}"
            );
        }
    }

    /// Item 11 of the verification page, in physical units.
    #[test]
    fn pressure_rises_and_falls() {
        let (mu, gcr) = (0.3, 0.002);
        let k1 = mu * 1.0 / gcr;
        let g = 0.5 * gcr;
        let new = || Twin::new(Backbone::PENALTY, mu, gcr, PressureRule::Dissipative, 10);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");

        let mut rising = new();
        rising.step([g, 0.0], 1.0);
        rising.step([0.0, 0.0], 2.0);
        rising.step([-g, 0.0], 2.0);
        close(rising.traction()[0], -0.5 * k1 * gcr);
        rising.step([0.0, 0.0], 1.0);
        close(rising.traction()[0], -0.25 * k1 * gcr);
        close(rising.dissipated(), 0.375 * k1 * g * g);

        let mut falling = new();
        falling.step([g, 0.0], 2.0);
        falling.step([0.0, 0.0], 1.0);
        falling.step([-g, 0.0], 1.0);
        close(falling.traction()[0], 0.0);
        close(falling.dissipated(), k1 * g * g / 2.0);

        let mut opened = new();
        opened.step([g, 0.0], 1.0);
        opened.step([0.0, 0.0], 0.0);
        opened.step([0.0, 0.0], 1.0);
        close(opened.traction()[0], 0.0);
        close(opened.dissipated(), k1 * g * g / 2.0);
    }

    /// Slip, a rise of pressure, more slip: some elements catch up, the others have been unloaded.
    #[test]
    fn pressure_rise_then_loading_has_a_closed_form() {
        let backbone = BACKBONES[2];
        for (s, ratio, d) in [(0.6, 0.5, 0.2), (0.6, 0.5, 0.5), (0.9, 0.25, 0.4)] {
            let mut twin = unit(backbone, 4000);
            twin.step([s, 0.0], ratio);
            twin.step([d, 0.0], 1.0);
            let exact = closed::loading_after_pressure_rise(backbone, s, ratio, d);
            assert!(
                (twin.traction()[0] - exact).abs() < 1e-6,
                "{} {exact}",
                twin.traction()[0]
            );
        }
    }

    /// The proportional rule keeps traction over pressure and so creates energy when the pressure rises.
    #[test]
    fn proportional_rule_creates_energy() {
        let mut twin = Twin::new(BACKBONES[2], 0.3, 0.002, PressureRule::Proportional, 100);
        twin.step([0.001, 0.0], 1.0);
        let (t, d) = (twin.traction()[0], twin.dissipated());
        twin.step([0.0, 0.0], 3.0);
        assert!((twin.traction()[0] - 3.0 * t).abs() < 1e-15);
        assert!(twin.dissipated() < d);
    }
}
