//! First-loading curves, their derivatives and integrals, straight from the formulas.

use crate::quadrature::integrate;

/// Traction of the first loading against slip, both normalised: 0 at 0, 1 from slip 1 on, concave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Backbone {
    /// f = 1 - (1 - s)^chi, chi >= 1. chi = 1 is the standard penalty, chi = 3/2 Cattaneo-Mindlin.
    Power {
        /// Exponent, at least 1.
        chi: f64,
    },
    /// Segalman's four-parameter Iwan element: density r^c up to 1 plus one element of finite stiffness at 1.
    Segalman {
        /// Exponent of the density, in (-1, 0].
        c: f64,
        /// Stiffness of the element at 1 over the stiffness of all others.
        beta: f64,
    },
}

impl Backbone {
    /// The straight line of the standard penalty method.
    pub const PENALTY: Backbone = Backbone::Power { chi: 1.0 };

    /// chi of the power law: a critical slip that follows the limit goes with its 1/chi-th power. Segalman's curve is not
    /// self-similar: infinite, which is a constant critical slip.
    pub fn exponent(self) -> f64 {
        match self {
            Backbone::Power { chi } => chi,
            Backbone::Segalman { .. } => f64::INFINITY,
        }
    }

    /// Traction f(s), s >= 0.
    pub fn traction(self, s: f64) -> f64 {
        if s >= 1.0 {
            return 1.0;
        }
        match self {
            // 1 - (1 - s)^chi without cancellation at small s.
            Backbone::Power { chi } => -(chi * (-s).ln_1p()).exp_m1(),
            Backbone::Segalman { c, beta } => {
                ((1.0 + beta) * (c + 2.0) * s - s.powf(c + 2.0)) / norm(c, beta)
            }
        }
    }

    /// Tangent f'(s); at s = 1 its limit from the left, which is the stiffness of the element at 1.
    pub fn tangent(self, s: f64) -> f64 {
        if s > 1.0 {
            return 0.0;
        }
        match self {
            Backbone::Power { chi } => chi * (1.0 - s).powf(chi - 1.0),
            Backbone::Segalman { c, beta } => {
                (c + 2.0) * (1.0 + beta - s.powf(c + 1.0)) / norm(c, beta)
            }
        }
    }

    /// Density -f'' of the elements with slip limit r < 1; `gap` is 1 - r, exact near 1.
    pub fn density(self, r: f64, gap: f64) -> f64 {
        match self {
            Backbone::Power { chi: 1.0 } => 0.0,
            Backbone::Power { chi } => chi * (chi - 1.0) * gap.powf(chi - 2.0),
            Backbone::Segalman { c, beta } => (c + 2.0) * (c + 1.0) * r.powf(c) / norm(c, beta),
        }
    }

    /// Work of the first loading up to s: the integral of f.
    pub fn work(self, s: f64) -> f64 {
        if s > 1.0 {
            return self.work(1.0) + s - 1.0;
        }
        match self {
            Backbone::Power { chi } if s < 0.1 => {
                // The same as a binomial series: the closed form cancels here.
                let (mut term, mut sum, mut j) = (-s, 0.0, 1.0);
                while f64::abs(term) > 1e-18 * f64::abs(sum) {
                    term *= -s * (chi + 1.0 - j) / (j + 1.0);
                    sum += term;
                    j += 1.0;
                }
                sum
            }
            Backbone::Power { chi } => s - (1.0 - (1.0 - s).powf(chi + 1.0)) / (chi + 1.0),
            Backbone::Segalman { c, beta } => {
                ((1.0 + beta) * (c + 2.0) * s * s / 2.0 - s.powf(c + 3.0) / (c + 3.0))
                    / norm(c, beta)
            }
        }
    }

    /// Energy dissipated by the first loading up to s: each element slides (s - r) under the force r.
    pub fn loss(self, s: f64) -> f64 {
        if s == 0.0 {
            return 0.0;
        }
        if s > 0.5 {
            // Work less what the elements store.
            return 2.0 * self.work(s) - s * self.traction(s);
        }
        // The closed form cancels at small s: sum over the elements instead.
        integrate(s, |r, left| self.density(r, 1.0 - s + left) * r * left)
    }
}

fn norm(c: f64, beta: f64) -> f64 {
    (c + 1.0) + beta * (c + 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Backbone; 8] = [
        Backbone::Power { chi: 1.0 },
        Backbone::Power { chi: 1.5 },
        Backbone::Power { chi: 2.5 },
        Backbone::Power { chi: 3.7 },
        Backbone::Segalman {
            c: -0.842,
            beta: 0.5,
        },
        Backbone::Segalman { c: -0.5, beta: 0.0 },
        Backbone::Segalman { c: -0.2, beta: 1.0 },
        Backbone::Segalman { c: 0.0, beta: 0.0 },
    ];

    #[test]
    fn derivatives_and_integrals_belong_together() {
        let h = 1e-5;
        for b in ALL {
            for s in [0.05, 0.3, 0.5, 0.7, 0.95] {
                let slope = (b.traction(s + h) - b.traction(s - h)) / (2.0 * h);
                assert!((slope - b.tangent(s)).abs() < 1e-7, "{b:?} tangent at {s}");
                let density = (b.tangent(s - h) - b.tangent(s + h)) / (2.0 * h);
                assert!(
                    (density - b.density(s, 1.0 - s)).abs() < 1e-5,
                    "{b:?} density at {s}"
                );
                let traction = (b.work(s + h) - b.work(s - h)) / (2.0 * h);
                assert!((traction - b.traction(s)).abs() < 1e-8, "{b:?} work at {s}");
            }
            assert_eq!(b.traction(0.0), 0.0);
            assert!((b.traction(1.0 - 1e-15) - 1.0).abs() < 1e-13, "{b:?}");
            assert_eq!(b.traction(7.0), 1.0);
        }
    }

    /// The sum over elements and the difference work - stored are two derivations of one number.
    #[test]
    fn loss_by_elements_is_loss_by_balance() {
        for b in ALL {
            for s in [0.05, 0.2, 0.4999] {
                let balance = 2.0 * b.work(s) - s * b.traction(s);
                assert!(
                    (b.loss(s) - balance).abs() < 1e-14,
                    "{b:?} at {s}: {} {balance}",
                    b.loss(s)
                );
            }
        }
    }

    /// The series at small slip and the closed form are one function.
    #[test]
    fn work_of_small_slips() {
        for chi in [1.0, 1.2, 2.0, 2.5, 3.7, 60.0] {
            let b = Backbone::Power { chi };
            let closed = 0.1 - (1.0 - 0.9f64.powf(chi + 1.0)) / (chi + 1.0);
            assert!((b.work(0.1 - 1e-16) - closed).abs() < 1e-15, "{chi}");
            assert!((b.work(1e-9) / (chi * 0.5e-18) - 1.0).abs() < 1e-6, "{chi}");
            assert_eq!(b.work(0.0), 0.0);
        }
    }

    /// Item 5 of the verification page: loss of a small slip.
    #[test]
    fn small_slips_keep_their_digits() {
        for chi in [1.5, 2.5, 3.7] {
            let b = Backbone::Power { chi };
            let s = 1e-7;
            let leading = chi * (chi - 1.0) * s * s * s / 6.0;
            assert!((b.loss(s) / leading - 1.0).abs() < 1e-6);
            assert!((b.traction(1e-12) / (chi * 1e-12) - 1.0).abs() < 1e-11);
        }
    }

    /// Item 1 of the verification page.
    #[test]
    fn printed_backbone_values() {
        let expected = [
            (0.1, 0.231567, 0.146185),
            (0.25, 0.512861, 0.350481),
            (0.5, 0.823223, 0.646447),
            (0.75, 0.968750, 0.875),
        ];
        for (s, f25, f15) in expected {
            assert!((Backbone::Power { chi: 2.5 }.traction(s) - f25).abs() < 5e-7);
            assert!((Backbone::Power { chi: 1.5 }.traction(s) - f15).abs() < 5e-7);
        }
    }

    /// Segalman's curve with c = 0 and no stiffness at 1 is the parabola of the power law.
    #[test]
    fn the_two_families_meet() {
        let segalman = Backbone::Segalman { c: 0.0, beta: 0.0 };
        let power = Backbone::Power { chi: 2.0 };
        for s in [0.0, 0.1, 0.6, 1.0, 3.0] {
            assert!((segalman.traction(s) - power.traction(s)).abs() < 1e-15);
            assert!((segalman.loss(s) - power.loss(s)).abs() < 1e-15);
        }
    }
}
