//! Least squares for the contact law behind a spring, its exponent given.
//!
//! At first loading the displacement u of the driven end and the slip g obey g + C F f(g/gcr) = u, with C = 1/K_e; the
//! force is H(u) = F f(g/gcr). Spring and contact together still obey Masing's rule, so a branch of the loop is T = c +
//! k u +- [2 H(d/2) - H(A)], d the distance from the reversal.

use mepc::backbone::{Backbone, PowerLaw};
use mepc::iwan::least_squares::{correlation, inflation, rough_search, search};
use mepc::iwan::masing::{Curve, Masing};
use mepc::iwan::{Fit, Record};
use nalgebra::{DMatrix, DVector};

/// Residuals below this part of the force are rounding.
const ROUNDING: f64 = 1e-9;
/// Unknowns of the curve: F, ln gcr, C.
const UNKNOWNS: usize = 3;

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
    /// Of F_s, gcr, 1/K_e, the stiffness in gross slip and the mean force; None when the data do not determine them at
    /// all.
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

/// The curve of first loading of a contact behind a spring.
#[derive(Clone)]
struct Contact {
    backbone: PowerLaw,
}

/// A record against the contact with some exponent.
pub struct Sprung<'a> {
    problem: Masing<'a, Contact, UNKNOWNS>,
    chi: f64,
}

impl<'a> Sprung<'a> {
    pub fn new(record: &'a Record, chi: f64) -> Self {
        let backbone = PowerLaw::new(chi);
        Sprung {
            problem: Masing::new(record, Contact { backbone }),
            chi,
        }
    }

    /// Starts from the joint's parameters: X_s = gcr + C F_s and the stick stiffness give gcr and C for this chi.
    fn starts(&self, joint: &Fit) -> [DVector<f64>; 3] {
        let (length, unit) = (self.problem.record.amplitude, self.problem.unit);
        let found = joint.joint;
        let x = found.displacement / length;
        let force = found.force / unit;
        let part = (1.0 - 1.0 / found.chi()) / (1.0 - 1.0 / self.chi);
        [part, 0.3, 0.7].map(|part| {
            let gcr = part.clamp(0.05, 0.999) * x;
            DVector::from_column_slice(&[
                force,
                gcr.ln(),
                (x - gcr) / force,
                found.residual * length / unit,
                joint.offset / unit,
            ])
        })
    }

    /// Mean square residual of the best fit, by no more points than that takes.
    pub fn mean_square(&self, joint: &Fit) -> f64 {
        let best = rough_search(&self.problem, self.starts(joint)).expect("three starts");
        best.sum / best.count as f64 * self.problem.unit.powi(2)
    }

    /// The best fit.
    pub fn fit(&self, joint: &Fit) -> SprungFit {
        let (length, unit) = (self.problem.record.amplitude, self.problem.unit);
        let best = search(&self.problem, self.starts(joint)).expect("three starts");
        let gcr = best.parameters[1].exp() * length;
        let (compliance, stiffness) = (length / unit, unit / length);
        let count = best.count;
        let mut residuals = Vec::with_capacity(count);
        self.problem.residuals(&best.parameters, &mut residuals);
        let correlation = correlation(&residuals, self.problem.lengths(), ROUNDING * unit);
        let free = (count - self.problem.unknowns()) as f64;
        let variance = best.sum / free * inflation(correlation, count);
        let units = DVector::from_column_slice(&[unit, gcr, compliance, stiffness, unit]);
        SprungFit {
            chi: self.chi,
            force: best.parameters[0] * unit,
            gcr,
            compliance: best.parameters[2] * compliance,
            residual: best.parameters[3] * stiffness,
            rms: (best.sum / count as f64).sqrt() * unit,
            correlation,
            covariance: best
                .normal
                .try_inverse()
                .map(|inverse| inverse.component_mul(&(&units * units.transpose())) * variance),
        }
    }
}

impl Curve<UNKNOWNS> for Contact {
    /// H(u) and its derivatives by F, ln gcr and C.
    fn at(&self, u: f64, &[force, log_gcr, compliance]: &[f64; UNKNOWNS]) -> (f64, [f64; 3]) {
        let gcr = log_gcr.exp();
        if u >= gcr + compliance * force {
            return (force, [1.0, 0.0, 0.0]);
        }
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
        (force * f, [by_force, by_log_gcr, by_compliance])
    }

    fn bounds(&self) -> [[f64; 2]; UNKNOWNS] {
        [
            [1e-9, f64::INFINITY],
            [1e-6f64.ln(), 20f64.ln()],
            [0.0, f64::INFINITY],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_force() {
        let contact = Contact {
            backbone: PowerLaw::new(2.5),
        };
        let at = [0.9, 0.2f64.ln(), 0.15];
        for u in [0.05, 0.2, 0.33, 0.6] {
            let value = |p: [f64; 3]| contact.at(u, &p);
            let here = value(at);
            for k in 0..3 {
                let h = 1e-6;
                let (mut above, mut below) = (at, at);
                above[k] += h;
                below[k] -= h;
                let rise = (value(above).0 - value(below).0) / (2.0 * h);
                assert!(
                    (rise - here.1[k]).abs() < 1e-7,
                    "{u} {k}: {rise} {}",
                    here.1[k]
                );
            }
        }
    }
}
