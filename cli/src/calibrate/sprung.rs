//! Least squares for the contact law behind a spring, its exponent given.
//!
//! At first loading the displacement u of the driven end and the slip g obey g + C F f(g/gcr) = u, with C = 1/K_e; the force is
//! H(u) = F f(g/gcr). Spring and contact together still obey Masing's rule, so a branch of the loop is
//! T = c + k u +- [2 H(d/2) - H(A)], d the distance from the reversal.

use mepc::backbone::{Backbone, PowerLaw};
use mepc::iwan::least_squares::{Problem, correlation, inflation, search};
use mepc::iwan::{Fit, Point, Record};
use nalgebra::{DMatrix, DVector};

/// Residuals below this part of the force are rounding.
const ROUNDING: f64 = 1e-9;

/// What was found.
pub struct SprungFit {
    /// The exponent that was given.
    pub chi: f64,
    /// Friction force in gross slip.
    pub force: f64,
    /// Critical slip.
    pub gcr: f64,
    /// 1 / K_e.
    pub compliance: f64,
    /// Stiffness in gross slip.
    pub residual: f64,
    /// Root mean square residual.
    pub rms: f64,
    /// Correlation of neighbouring residuals.
    pub correlation: f64,
    /// Of F_s, gcr, 1/K_e, the stiffness in gross slip and the mean force; None when the data do not determine them at all.
    covariance: Option<DMatrix<f64>>,
}

impl SprungFit {
    /// K_e; None is rigid.
    pub fn series(&self) -> Option<f64> {
        (self.compliance > 0.0).then(|| 1.0 / self.compliance)
    }

    /// Displacement at gross slip, gcr + F_s / K_e.
    pub fn displacement(&self) -> f64 {
        self.gcr + self.force * self.compliance
    }

    /// Variance of a quantity with these derivatives by F_s, gcr, 1/K_e and the stiffness in gross slip.
    pub fn variance(&self, derivatives: [f64; 4]) -> f64 {
        let [force, gcr, compliance, residual] = derivatives;
        let row = DVector::from_column_slice(&[force, gcr, compliance, residual, 0.0]);
        self.covariance
            .as_ref()
            .map_or(f64::INFINITY, |covariance| (covariance * &row).dot(&row))
    }
}

/// A record, scaled by its amplitude and its largest force.
pub struct Sprung {
    backbone: PowerLaw,
    chi: f64,
    points: Vec<Point>,
    /// How many of them each branch has.
    branches: Vec<usize>,
    length: f64,
    force: f64,
}

impl Sprung {
    pub fn new(record: &Record, chi: f64) -> Self {
        let force = record
            .force
            .iter()
            .fold(0.0, |most: f64, f| most.max(f.abs()));
        Sprung {
            backbone: PowerLaw::new(chi),
            chi,
            points: record.scaled(force),
            branches: record.branches.iter().map(|b| b.points.len()).collect(),
            length: record.amplitude,
            force,
        }
    }

    /// Starts from the joint's parameters: X_s = gcr + C F_s and the stick stiffness give gcr and C for this chi.
    pub fn fit(&self, joint: &Fit) -> SprungFit {
        let found = joint.joint;
        let x = found.displacement / self.length;
        let force = found.force / self.force;
        let part = (1.0 - 1.0 / found.chi()) / (1.0 - 1.0 / self.chi);
        let start = |part: f64| {
            let gcr = part.clamp(0.05, 0.999) * x;
            DVector::from_column_slice(&[
                force,
                gcr.ln(),
                (x - gcr) / force,
                found.residual * self.length / self.force,
                joint.offset / self.force,
            ])
        };
        let every = |stride| Sprung {
            backbone: self.backbone.clone(),
            points: self.points.iter().step_by(stride).cloned().collect(),
            branches: Vec::new(),
            ..*self
        };
        let best = search(self, every, [part, 0.3, 0.7].map(start)).expect("three starts");
        let gcr = best.parameters[1].exp() * self.length;
        let (compliance, stiffness) = (self.length / self.force, self.force / self.length);
        let correlation = self.correlation(&best.parameters);
        let count = self.points.len();
        let free = (count - self.bounds().len()) as f64;
        let variance = best.sum / free * inflation(correlation, count);
        let units =
            DVector::from_column_slice(&[self.force, gcr, compliance, stiffness, self.force]);
        SprungFit {
            chi: self.chi,
            force: best.parameters[0] * self.force,
            gcr,
            compliance: best.parameters[2] * compliance,
            residual: best.parameters[3] * stiffness,
            rms: (best.sum / count as f64).sqrt() * self.force,
            correlation,
            covariance: best
                .normal
                .try_inverse()
                .map(|inverse| inverse.component_mul(&(&units * units.transpose())) * variance),
        }
    }

    fn correlation(&self, unknowns: &DVector<f64>) -> f64 {
        let mut gradient = [0.0; 5];
        let residuals: Vec<f64> = (0..self.points.len())
            .map(|index| self.residual(unknowns, index, &mut gradient))
            .collect();
        correlation(&residuals, self.branches.iter().copied(), ROUNDING)
    }

    /// H(u) and its derivatives by F, ln gcr and C.
    fn first_loading(&self, u: f64, force: f64, gcr: f64, compliance: f64) -> [f64; 4] {
        let shape = |g: f64| {
            if g < gcr {
                let values = self.backbone.at(g / gcr);
                (values.f, values.slope / gcr)
            } else {
                (1.0, 0.0)
            }
        };
        // The left side grows and is concave in g: Newton from g = 0 comes up from below and never passes the root.
        let mut g = 0.0;
        for _ in 0..100 {
            let (f, slope) = shape(g);
            let step = (u - g - compliance * force * f) / (1.0 + compliance * force * slope);
            g += step;
            if step.abs() <= 1e-15 * u.abs() {
                break;
            }
        }
        let (f, slope) = shape(g);
        let yielding = 1.0 + compliance * force * slope;
        let by_force = f - force * slope * compliance * f / yielding;
        // d f / d ln gcr at fixed g is -slope g.
        let by_log_gcr = -force * slope * g / yielding;
        let by_compliance = -force * slope * force * f / yielding;
        [force * f, by_force, by_log_gcr, by_compliance]
    }
}

impl Problem for Sprung {
    fn residual(&self, unknowns: &DVector<f64>, index: usize, gradient: &mut [f64]) -> f64 {
        let p = &self.points[index];
        let (force, gcr, compliance) = (unknowns[0], unknowns[1].exp(), unknowns[2]);
        let here = self.first_loading(p.distance, force, gcr, compliance);
        let end = self.first_loading(p.amplitude, force, gcr, compliance);
        for k in 0..3 {
            gradient[k] = p.sign * (2.0 * here[k + 1] - end[k + 1]);
        }
        gradient[3] = p.displacement;
        gradient[4] = 1.0;
        p.sign * (2.0 * here[0] - end[0]) + unknowns[3] * p.displacement + unknowns[4] - p.force
    }

    fn count(&self) -> usize {
        self.points.len()
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        vec![
            [1e-9, f64::INFINITY],
            [1e-6f64.ln(), 20f64.ln()],
            [0.0, f64::INFINITY],
            free,
            free,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_force() {
        let sprung = Sprung {
            backbone: PowerLaw::new(2.5),
            chi: 2.5,
            points: Vec::new(),
            branches: Vec::new(),
            length: 1.0,
            force: 1.0,
        };
        let at = [0.9, 0.2f64.ln(), 0.15];
        for u in [0.05, 0.2, 0.33, 0.6] {
            let value = |p: [f64; 3]| sprung.first_loading(u, p[0], p[1].exp(), p[2]);
            let here = value(at);
            for k in 0..3 {
                let h = 1e-6;
                let (mut above, mut below) = (at, at);
                above[k] += h;
                below[k] -= h;
                let rise = (value(above)[0] - value(below)[0]) / (2.0 * h);
                assert!(
                    (rise - here[k + 1]).abs() < 1e-7,
                    "{u} {k}: {rise} {}",
                    here[k + 1]
                );
            }
        }
    }
}
