//! The law as what it stands for: many slip elements side by side.
//!
//! Element i is a spring of stiffness k_i in series with a slider that gives way at the deflection R_i, in one or two
//! tangential directions (radial return). Two kinds:
//!
//! - *fixed limits* (constant limit traction, and the proportional rule): R_i = r_i gcr never changes, stiffnesses scale
//!   with T; with a jump of f' at 1 one more element is there.
//! - *fixed depths* (the consistent rule): R_i = G - x_i, where G = gcr (T/T0)^(1/chi) is the critical slip of the moment
//!   and x_i the depth of the element below the base of the cone. Stiffness is fixed for good: k(x) = T0/gcr^chi
//!   chi (chi-1) x^(chi-2). An element is there while R_i > 0; it is born without deflection, and what it holds when it
//!   dies is dissipated.
//!
//! One return for a whole increment is first order in the increment where the path turns: an increment is cut into
//! sub-steps, straight in slip and in G. Physical units.

use crate::Backbone;

#[derive(Debug, Clone, Copy)]
struct Element {
    /// r_i gcr, or x_i.
    place: f64,
    /// Of T / gcr (fixed limits), or traction per length (fixed depths).
    stiffness: f64,
    deflection: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    FixedLimits,
    /// T0, chi.
    FixedDepths(f64, f64),
}

/// The parallel slip elements of one contact point.
#[derive(Debug, Clone)]
pub struct Twin {
    kind: Kind,
    gcr: f64,
    elements: Vec<Element>,
    limit: f64,
    critical: f64,
    dissipated: f64,
}

impl Twin {
    /// A virgin point of `n` elements of fixed limits.
    pub fn fixed_limits(backbone: Backbone, gcr: f64, n: u32) -> Self {
        let mut elements = Vec::new();
        let mut add = |limit: f64, stiffness: f64| {
            if stiffness > 0.0 {
                elements.push(Element {
                    place: limit * gcr,
                    stiffness,
                    deflection: [0.0; 2],
                });
            }
        };
        // The stiffness between the limits a and b is f'(a) - f'(b); one element at its centre carries it, so that all
        // together saturate at exactly 1. Moment of the stiffness below r about zero:
        let moment = |r: f64| backbone.traction(r) - r * backbone.tangent(r);
        for k in 0..n {
            let (a, b) = (cell(backbone, k, n), cell(backbone, k + 1, n));
            let stiffness = backbone.tangent(a) - backbone.tangent(b);
            add(((moment(b) - moment(a)) / stiffness).clamp(a, b), stiffness);
        }
        add(1.0, backbone.tangent(1.0));
        Twin {
            kind: Kind::FixedLimits,
            gcr,
            elements,
            limit: 0.0,
            critical: 0.0,
            dissipated: 0.0,
        }
    }

    /// A virgin point of `n` elements of fixed depths, for limit tractions up to `largest`; gcr is the critical slip at the
    /// limit traction `reference`.
    pub fn fixed_depths(chi: f64, gcr: f64, reference: f64, largest: f64, n: u32) -> Self {
        let backbone = Backbone::Power { chi };
        let deepest = gcr * (largest / reference).powf(1.0 / chi);
        let scale = reference / gcr.powf(chi);
        let mut elements = Vec::new();
        if chi == 1.0 {
            elements.push(Element {
                place: 0.0,
                stiffness: scale,
                deflection: [0.0; 2],
            });
        } else {
            for k in 0..n {
                // Depths a < b; the cells are those of the backbone, seen from its end.
                let (a, b) = (
                    1.0 - cell(backbone, n - k, n),
                    1.0 - cell(backbone, n - k - 1, n),
                );
                let stiffness = chi * (b.powf(chi - 1.0) - a.powf(chi - 1.0));
                let moment = (chi - 1.0) * (b.powf(chi) - a.powf(chi));
                elements.push(Element {
                    place: deepest * moment / stiffness,
                    stiffness: scale * deepest.powf(chi - 1.0) * stiffness,
                    deflection: [0.0; 2],
                });
            }
        }
        let kind = Kind::FixedDepths(reference, chi);
        Twin {
            kind,
            gcr,
            elements,
            limit: 0.0,
            critical: 0.0,
            dissipated: 0.0,
        }
    }

    /// Slides by `increment` (zero second component for one direction) while the limit traction goes to `limit`, in so
    /// many sub-steps. Zero or less opens the contact; the step after that is a fresh start at its limit.
    pub fn step(&mut self, increment: [f64; 2], limit: f64, parts: u32) {
        if limit <= 0.0 {
            self.dissipated += self.stored();
            self.elements
                .iter_mut()
                .for_each(|element| element.deflection = [0.0; 2]);
            (self.limit, self.critical) = (0.0, 0.0);
            return;
        }
        let critical = match self.kind {
            Kind::FixedLimits => self.gcr,
            Kind::FixedDepths(reference, chi) => self.gcr * (limit / reference).powf(1.0 / chi),
        };
        if self.limit == 0.0 {
            (self.limit, self.critical) = (limit, critical);
        }
        if self.kind == Kind::FixedLimits {
            // Deflections stay, tractions scale with the limit: energy may be created.
            let before = self.stored();
            self.limit = limit;
            self.dissipated += before - self.stored();
        }
        let (from, growth) = (self.critical, critical - self.critical);
        let d = increment.map(|x| x / f64::from(parts));
        for part in 1..=parts {
            let before = self.critical;
            self.critical = if part == parts {
                critical
            } else {
                from + growth * f64::from(part) / f64::from(parts)
            };
            self.slide(d, before);
        }
        self.limit = limit;
    }

    /// `before`: the critical slip at the start.
    fn slide(&mut self, d: [f64; 2], before: f64) {
        let (kind, critical, strength) = (self.kind, self.critical, self.strength());
        let mut lost = 0.0;
        for element in &mut self.elements {
            let u = element.deflection;
            let (limit_before, limit) = match kind {
                Kind::FixedLimits => (element.place, element.place),
                Kind::FixedDepths(..) => (
                    (before - element.place).max(0.0),
                    (critical - element.place).max(0.0),
                ),
            };
            // Born in this sub-step, it has only moved since.
            let lives = if limit_before == 0.0 && limit > 0.0 {
                limit / (critical - before)
            } else {
                1.0
            };
            let mut end = [u[0] + lives * d[0], u[1] + lives * d[1]];
            let length = end[0].hypot(end[1]);
            if length > limit {
                end = end.map(|x| x * limit / length);
                // Mean limit times slip.
                lost += element.stiffness * (limit_before + limit) / 2.0 * (length - limit);
            }
            element.deflection = end;
        }
        self.dissipated += strength * lost;
    }

    fn strength(&self) -> f64 {
        match self.kind {
            Kind::FixedLimits => self.limit / self.gcr,
            Kind::FixedDepths(..) => 1.0,
        }
    }

    /// Traction.
    pub fn traction(&self) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for element in &self.elements {
            sum[0] += element.stiffness * element.deflection[0];
            sum[1] += element.stiffness * element.deflection[1];
        }
        sum.map(|x| x * self.strength())
    }

    /// Elastic energy per area.
    pub fn stored(&self) -> f64 {
        let energy =
            |e: &Element| e.stiffness * (e.deflection[0].powi(2) + e.deflection[1].powi(2)) / 2.0;
        self.strength() * self.elements.iter().map(energy).sum::<f64>()
    }

    /// Energy dissipated per area since the start: by sliding, dying, opening, and (fixed limits) by changes of T.
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
    use crate::{closed, jenkins::Jenkins, masing::Masing};

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
        Twin::fixed_limits(backbone, 1.0, n)
    }

    /// Largest differences of traction, dissipated and stored energy from Masing's rules on a nested history.
    fn difference(mut twin: Twin, backbone: Backbone) -> f64 {
        let mut exact = Masing::new(backbone);
        let mut worst: f64 = 0.0;
        for s in [0.0, 0.3, 0.8, -0.2, 0.3, 0.1, -0.2, -0.8, -1.7, 0.05, 1e-3] {
            twin.step([s - exact.slip(), 0.0], 1.0, 1);
            exact.move_to(s);
            worst = worst
                .max((twin.traction()[0] - exact.traction()).abs())
                .max((twin.stored() - exact.stored()).abs());
            worst = worst.max((twin.dissipated() - exact.dissipated()).abs());
        }
        worst
    }

    #[test]
    fn saturates_at_exactly_one() {
        for backbone in BACKBONES {
            let mut twin = unit(backbone, 400);
            twin.step([3.0, 4.0], 1.0, 1);
            let [x, y] = twin.traction();
            assert!(
                (x - 0.6).abs() < 1e-13 && (y - 0.8).abs() < 1e-13,
                "{backbone:?}"
            );
        }
        let mut twin = Twin::fixed_depths(2.5, 0.3, 1.0, 7.0, 400);
        twin.step([3.0, 4.0], 7.0, 1);
        assert!((twin.traction()[0] - 4.2).abs() < 1e-12);
    }

    #[test]
    fn converges_to_masing() {
        for backbone in BACKBONES {
            let (coarse, fine) = (unit(backbone, 250), unit(backbone, 4000));
            let (coarse, fine) = (difference(coarse, backbone), difference(fine, backbone));
            assert!(fine < 2e-7, "{backbone:?}: {fine:e}");
            // Second order: sixteen times the elements, 1/256 of the error. chi = 1 is one exact element.
            assert!(
                fine < coarse / 60.0 || coarse < 1e-13,
                "{backbone:?}: {coarse:e} {fine:e}"
            );
        }
        // At a constant limit both kinds are one.
        for chi in [1.5, 2.5, 4.0] {
            let twin = Twin::fixed_depths(chi, 1.0, 1.0, 1.0, 4000);
            let error = difference(twin, Backbone::Power { chi });
            assert!(error < 2e-7, "{chi}: {error:e}");
        }
    }

    /// Item 8: a straight history in any direction is the one-dimensional one.
    #[test]
    fn straight_in_any_direction() {
        let (mut along, mut oblique) = (unit(BACKBONES[2], 500), unit(BACKBONES[2], 500));
        for d in [0.7, -1.1, 0.6, -0.3, 2.0, -0.8] {
            along.step([d, 0.0], 1.0, 3);
            oblique.step([0.28 * d, -0.96 * d], 1.0, 3);
            let t = along.traction()[0];
            let [x, y] = oblique.traction();
            assert!((x - 0.28 * t).abs() < 1e-12 && (y + 0.96 * t).abs() < 1e-12);
            assert!((along.dissipated() - oblique.dissipated()).abs() < 1e-12);
        }
    }

    /// Item 13: steady turns of a circle against the integral over the elements.
    #[test]
    fn circle() {
        for (backbone, radius) in [
            (BACKBONES[2], 0.5),
            (BACKBONES[2], 2.0),
            (BACKBONES[4], 1.3),
        ] {
            let mut twin = unit(backbone, 500);
            let mut at = [radius, 0.0];
            twin.step(at, 1.0, 1);
            let mut turn = 0.0;
            for _ in 0..4 {
                let before = twin.dissipated();
                for k in 1..=400 {
                    let phase = std::f64::consts::TAU * f64::from(k) / 400.0;
                    let next = [radius * phase.cos(), radius * phase.sin()];
                    twin.step([next[0] - at[0], next[1] - at[1]], 1.0, 4);
                    at = next;
                }
                turn = twin.dissipated() - before;
            }
            // A polygon of 400 sides dissipates a little less than its circle.
            let exact = closed::circle_dissipation(backbone, radius);
            assert!(
                (turn / exact - 1.0).abs() < 3e-3,
                "{backbone:?}: {turn} {exact}"
            );
        }
    }

    /// Item 11a and c: a slip held while the limit changes, and Mindlin and Deresiewicz' legs.
    #[test]
    fn limit_changes() {
        let held = [
            (1.0, [0.5, 0.5, 0.5, 0.4, 0.4]),
            (1.5, [0.646447, 0.646447, 0.646447, 0.391120, 0.391120]),
            (2.5, [0.823223, 0.823223, 0.823223, 0.383605, 0.383605]),
        ];
        for (chi, printed) in held {
            let mut twin = Twin::fixed_depths(chi, 1.0, 1.0, 2.0, 8000);
            for ((d, limit), printed) in
                [(0.5, 1.0), (0.0, 2.0), (0.0, 1.0), (0.0, 0.4), (0.0, 1.0)]
                    .into_iter()
                    .zip(printed)
            {
                twin.step([d, 0.0], limit, 64);
                assert!(
                    (twin.traction()[0] - printed).abs() < 2e-6,
                    "{chi} {limit}: {}",
                    twin.traction()[0]
                );
            }
        }
        let legs = [
            (0.20, 0.10),
            (0.15, -0.05),
            (0.10, 0.05),
            (-0.12, 0.03),
            (-0.10, -0.04),
            (-0.08, 0.06),
        ];
        for (chi, printed) in [
            (
                1.5,
                [
                    0.29987476, 0.49026781, 0.62964298, 0.44199514, 0.29312901, 0.16818636,
                ],
            ),
            (
                2.5,
                [
                    0.50062523, 0.71976291, 0.92842832, 0.58845332, 0.34479843, 0.11848031,
                ],
            ),
        ] {
            let mut twin = Twin::fixed_depths(chi, 1.0, 1.0, 2.0, 8000);
            twin.step([0.0; 2], 1.0, 1);
            let mut g: f64 = 1.0;
            for ((d, growth), printed) in legs.into_iter().zip(printed) {
                g += growth;
                twin.step([d, 0.0], g.powf(chi), 64);
                assert!(
                    (twin.traction()[0] - printed).abs() < 1e-5,
                    "{chi}: {} {printed}",
                    twin.traction()[0]
                );
            }
        }
    }

    /// chi = 1 is one spring of constant stiffness; deaths and openings are dissipated.
    #[test]
    fn one_element_is_the_jenkins_element() {
        let mut twin = Twin::fixed_depths(1.0, 0.002, 3.0, 3.0, 1);
        let mut spring = Jenkins::new(3.0 / 0.002);
        for (d, limit) in [
            ([1e-3, 0.0], 3.0),
            ([1e-3, 2e-3], 2.0),
            ([-3e-3, 1e-3], 4.0),
            ([0.0, -1e-3], 1.0),
        ] {
            twin.step(d, limit, 50);
            spring.step(d, limit, 50);
            for i in 0..2 {
                assert!((twin.traction()[i] - spring.traction[i]).abs() < 1e-13);
            }
        }
        let (before, held) = (twin.dissipated(), twin.stored());
        twin.step([1.0, 0.0], 0.0, 1);
        assert!(held > 0.0 && (twin.dissipated() - before - held).abs() < 1e-15);
        assert_eq!(twin.traction(), [0.0; 2]);
    }

    /// The proportional rule keeps traction over T and so creates energy when T rises.
    #[test]
    fn proportional_rule_creates_energy() {
        let mut twin = Twin::fixed_limits(BACKBONES[2], 0.002, 100);
        twin.step([0.001, 0.0], 0.3, 1);
        let (t, d) = (twin.traction()[0], twin.dissipated());
        twin.step([0.0, 0.0], 0.9, 1);
        assert!((twin.traction()[0] - 3.0 * t).abs() < 1e-15);
        assert!(twin.dissipated() < d);
    }
}
