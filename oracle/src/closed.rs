//! Single numbers that have a formula.

use std::f64::consts::{PI, TAU};

use crate::{Backbone, quadrature::integrate};

/// Energy dissipated by one cycle between slips +-a.
pub fn cycle_dissipation(backbone: Backbone, a: f64) -> f64 {
    4.0 * backbone.loss(a)
}

/// The same for the power law, written out: a polynomial up to a = 1, a straight line beyond.
pub fn power_law_cycle(chi: f64, a: f64) -> f64 {
    if a <= 1.0 {
        let rest = 1.0 - a;
        4.0 * a + 4.0 * a * rest.powf(chi) - 8.0 / (chi + 1.0) * (1.0 - rest.powf(chi + 1.0))
    } else {
        4.0 * (a - 2.0 / (chi + 1.0))
    }
}

/// Equivalent damping ratio D / (2 pi a f(a)) of a cycle between +-a.
pub fn damping_ratio(backbone: Backbone, a: f64) -> f64 {
    cycle_dissipation(backbone, a) / (TAU * a * backbone.traction(a))
}

/// Energy stored in gross slip.
pub fn saturated_energy(backbone: Backbone) -> f64 {
    1.0 - backbone.work(1.0)
}

/// Energy dissipated per steady turn of a circle of radius `a`: an element of limit r < a trails on a circle of
/// radius sqrt(a^2 - r^2).
pub fn circle_dissipation(backbone: Backbone, a: f64) -> f64 {
    let top = a.min(1.0);
    let beyond = a - top;
    let sliding = integrate(top, |r, left| {
        backbone.density(r, 1.0 - top + left) * r * ((left + beyond) * (a + r)).sqrt()
    });
    let last = if a > 1.0 {
        backbone.tangent(1.0) * (a * a - 1.0).sqrt()
    } else {
        0.0
    };
    TAU * (sliding + last)
}

/// A sphere on a flat of the same material: Hertz's normal and Mindlin's tangential contact (chi = 3/2).
#[derive(Debug, Clone, Copy)]
pub struct HertzSphere {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Radius of the sphere.
    pub radius: f64,
    /// Friction coefficient.
    pub mu: f64,
    /// Normal approach of distant points.
    pub approach: f64,
}

impl HertzSphere {
    /// Radius of the contact circle.
    pub fn contact_radius(&self) -> f64 {
        (self.radius * self.approach).sqrt()
    }

    /// Normal force.
    pub fn normal_force(&self) -> f64 {
        let plane_strain = self.young / (2.0 * (1.0 - self.poisson.powi(2)));
        4.0 / 3.0 * plane_strain * self.radius.sqrt() * self.approach.powf(1.5)
    }

    /// Pressure in the centre of the contact circle.
    pub fn peak_pressure(&self) -> f64 {
        1.5 * self.normal_force() / (PI * self.contact_radius().powi(2))
    }

    /// Mean pressure over the ring between radii a and b of the contact circle.
    pub fn ring_pressure(&self, a: f64, b: f64) -> f64 {
        let outer = self.contact_radius();
        // Force inside r, over the whole force: 1 - (1 - (r/a)^2)^(3/2).
        let share = |r: f64| 1.0 - (1.0 - (r / outer).powi(2)).max(0.0).powf(1.5);
        self.normal_force() * (share(b) - share(a)) / (PI * (b * b - a * a))
    }

    /// Tangential displacement at which the whole circle slides (Mindlin).
    pub fn critical_slip(&self) -> f64 {
        let shear = self.young / (2.0 * (1.0 + self.poisson));
        let compliance = 2.0 * (2.0 - self.poisson) / shear;
        3.0 * self.mu * self.normal_force() * compliance / (16.0 * self.contact_radius())
    }

    /// Energy per cycle of tangential displacement amplitude `amplitude`.
    pub fn cycle_dissipation(&self, amplitude: f64) -> f64 {
        let gcr = self.critical_slip();
        self.mu
            * self.normal_force()
            * gcr
            * cycle_dissipation(Backbone::Power { chi: 1.5 }, amplitude / gcr)
    }
}

/// A long elastic bar pulled along a rough foundation: force at the end that moves by `a` critical slips.
/// `axial` is E A, `width` the contact width, `limit` mu p.
pub fn bar_force(backbone: Backbone, axial: f64, width: f64, limit: f64, gcr: f64, a: f64) -> f64 {
    (2.0 * axial * width * limit * gcr * backbone.work(a)).sqrt()
}

/// Four-parameter Iwan joint with residual stiffness: T_max, k_t, loop of amplitude A.
#[derive(Debug, Clone, Copy)]
pub struct Iwan {
    /// Force at the onset of gross slip.
    pub force: f64,
    /// Displacement at the onset of gross slip.
    pub displacement: f64,
    /// Residual stiffness.
    pub residual: f64,
    /// Exponent: chi = 5/2 + kappa.
    pub kappa: f64,
}

impl Iwan {
    fn backbone(&self) -> Backbone {
        Backbone::Power {
            chi: 2.5 + self.kappa,
        }
    }

    /// Force at the displacement amplitude.
    pub fn peak_force(&self, amplitude: f64) -> f64 {
        self.force * self.backbone().traction(amplitude / self.displacement)
            + self.residual * amplitude
    }

    /// Stiffness in stick.
    pub fn stick_stiffness(&self) -> f64 {
        self.force / self.displacement * self.backbone().tangent(0.0) + self.residual
    }

    /// Energy per cycle.
    pub fn cycle_dissipation(&self, amplitude: f64) -> f64 {
        self.force
            * self.displacement
            * cycle_dissipation(self.backbone(), amplitude / self.displacement)
    }
}

/// Displacement at gross slip and first stiffness of a patch (limit force `force`) behind the stiffness `series`.
pub fn series_spring(backbone: Backbone, force: f64, gcr: f64, series: f64) -> (f64, f64) {
    let stick = backbone.tangent(0.0) * force / gcr;
    (gcr + force / series, 1.0 / (1.0 / stick + 1.0 / series))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHI_15: Backbone = Backbone::Power { chi: 1.5 };
    const CHI_20: Backbone = Backbone::Power { chi: 2.0 };
    const CHI_25: Backbone = Backbone::Power { chi: 2.5 };

    fn near(value: f64, printed: f64, half_digit: f64) {
        assert!((value - printed).abs() <= half_digit, "{value} {printed}");
    }

    /// Item 5: printed values, the limit of small amplitudes, the damping ratio.
    #[test]
    fn cycles() {
        let amplitudes = [0.1, 0.25, 0.5, 1.0, 2.0];
        let chi_25 = [0.002437, 0.036521, 0.269870, 1.714286, 5.714286];
        let chi_15 = [0.000513, 0.008365, 0.072792, 0.8, 4.8];
        for (i, a) in amplitudes.into_iter().enumerate() {
            near(cycle_dissipation(CHI_25, a), chi_25[i], 5e-7);
            near(cycle_dissipation(CHI_15, a), chi_15[i], 5e-7);
            for chi in [1.0, 1.5, 2.0, 2.5, 3.7] {
                let written_out = power_law_cycle(chi, a);
                near(
                    cycle_dissipation(Backbone::Power { chi }, a),
                    written_out,
                    1e-14,
                );
            }
            if a <= 1.0 {
                near(cycle_dissipation(CHI_20, a), 4.0 / 3.0 * a.powi(3), 1e-14);
            }
        }
        let a = 1e-4;
        near(cycle_dissipation(CHI_25, a) / (2.5 * a.powi(3)), 1.0, 1e-4);
        for (a, zeta) in [(0.5, 0.10435), (1.0, 0.27284), (2.0, 0.45473)] {
            near(damping_ratio(CHI_25, a), zeta, 5e-6);
        }
    }

    /// Item 6.
    #[test]
    fn first_loading() {
        near(saturated_energy(CHI_25), 2.0 / 7.0, 1e-15);
        near(CHI_25.work(1.0), 5.0 / 7.0, 1e-15);
    }

    /// Item 7.
    #[test]
    fn limits_of_the_family() {
        near(CHI_25.tangent(0.0), 2.5, 1e-15);
        near(cycle_dissipation(Backbone::PENALTY, 3.0), 8.0, 1e-14);
        // Vanishing critical slip: all of the path is slid.
        near(1e-9 * cycle_dissipation(CHI_25, 1e9), 4.0, 1e-8);
    }

    /// Item 13, and chi = 1 where only the element at 1 slides.
    #[test]
    fn circles() {
        near(circle_dissipation(CHI_25, 0.5), 0.82187, 5e-6);
        near(circle_dissipation(CHI_25, 2.0), 11.94510, 5e-6);
        near(
            circle_dissipation(Backbone::PENALTY, 2.0),
            TAU * 3f64.sqrt(),
            1e-13,
        );
        assert_eq!(circle_dissipation(Backbone::PENALTY, 0.7), 0.0);
    }

    /// Item 14.
    #[test]
    fn sphere_on_flat() {
        let sphere = HertzSphere {
            young: 192_850.0,
            poisson: 0.29,
            radius: 4.174432,
            mu: 0.2,
            approach: 0.010,
        };
        near(sphere.normal_force(), 286.79992, 5e-6);
        near(sphere.critical_slip(), 2.408451e-3, 5e-10);
        // N.mm; the page gives joule.
        near(
            sphere.cycle_dissipation(1.5 * sphere.critical_slip()),
            0.386816,
            5e-7,
        );
        let a = sphere.contact_radius();
        let rings = 50;
        let force: f64 = (0..rings)
            .map(|k| {
                let (r0, r1) = (a * f64::from(k) / 50.0, a * f64::from(k + 1) / 50.0);
                PI * (r1 * r1 - r0 * r0) * sphere.ring_pressure(r0, r1)
            })
            .sum();
        near(force, sphere.normal_force(), 1e-9);
        near(
            sphere.ring_pressure(0.0, 1e-4 * a),
            sphere.peak_pressure(),
            1e-2,
        );
    }

    /// Item 15: stiffness and gross slip behind a spring, with the lap joint's numbers.
    #[test]
    fn behind_a_spring() {
        let (force, gcr, series) = (0.3 * 900.0, 0.00268, 178e3);
        let (x_s, k_0) = series_spring(CHI_25, force, gcr, series);
        near(x_s, 0.00268 + 0.0015168539, 1e-9);
        near(k_0, 1.0 / (gcr / (2.5 * force) + 1.0 / series), 1e-9);
    }

    /// Item 16.
    #[test]
    fn elastic_bar() {
        for (a, force) in [
            (0.25, 3.70601),
            (0.5, 6.92155),
            (1.0, 11.95229),
            (2.0, 18.51640),
        ] {
            near(bar_force(CHI_25, 100.0, 1.0, 1.0, 1.0, a), force, 5e-6);
        }
    }

    /// Item 17.
    #[test]
    fn iwan_joint() {
        let joint = Iwan {
            force: 266.78,
            displacement: 0.0041,
            residual: 3280.7,
            kappa: -0.842,
        };
        near(joint.peak_force(0.02), 332.394, 5e-4);
        near(joint.stick_stiffness(), 111164.0, 0.5);
        near(joint.cycle_dissipation(0.02), 18.050, 5e-4);
    }
}
