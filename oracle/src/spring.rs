//! A rigid patch behind a spring: the displacement is prescribed beyond the spring, the slip follows.

use crate::{Backbone, masing::Masing};

/// Patch of limit force `force` and critical slip `gcr` behind the stiffness `series`; physical units. With a
/// constant critical slip the patch slides as one point, whatever its pressure distribution.
#[derive(Debug, Clone)]
pub struct SpringPatch {
    point: Masing,
    force: f64,
    gcr: f64,
    series: Option<f64>,
}

impl SpringPatch {
    /// A virgin patch; `series` = `None` moves the patch itself.
    pub fn new(backbone: Backbone, force: f64, gcr: f64, series: Option<f64>) -> Self {
        SpringPatch {
            point: Masing::new(backbone),
            force,
            gcr,
            series,
        }
    }

    /// Moves the end of the spring to `displacement`.
    pub fn move_to(&mut self, displacement: f64) {
        let Some(series) = self.series else {
            self.point.move_to(displacement / self.gcr);
            return;
        };
        // The spring pulls less and the contact more as the slip grows: bisect their difference. A trial starts
        // from the same memory each time.
        let excess = |slip: f64| {
            let mut trial = self.point.clone();
            trial.move_to(slip);
            series * (displacement - slip * self.gcr) - self.force * trial.traction()
        };
        let reach = self.force / series;
        let mut low = (displacement - reach) / self.gcr - 1e-9;
        let mut high = (displacement + reach) / self.gcr + 1e-9;
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if excess(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.point.move_to(0.5 * (low + high));
    }

    /// Slip of the patch.
    pub fn slip(&self) -> f64 {
        self.point.slip() * self.gcr
    }

    /// Friction force.
    pub fn force(&self) -> f64 {
        self.point.traction() * self.force
    }

    /// Energy stored in the contact.
    pub fn stored(&self) -> f64 {
        self.point.stored() * self.force * self.gcr
    }

    /// Energy dissipated in the contact since the start.
    pub fn dissipated(&self) -> f64 {
        self.point.dissipated() * self.force * self.gcr
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed;

    const CHI_25: Backbone = Backbone::Power { chi: 2.5 };

    #[test]
    fn stiffness_gross_slip_and_cycle() {
        let (force, gcr, series) = (270.0, 0.00268, 178e3);
        let (x_s, k_0) = closed::series_spring(CHI_25, force, gcr, series);
        let mut patch = SpringPatch::new(CHI_25, force, gcr, Some(series));
        patch.move_to(1e-9);
        assert!((patch.force() / (1e-9 * k_0) - 1.0).abs() < 1e-5);
        patch.move_to(0.999 * x_s);
        assert!(patch.force() < force);
        patch.move_to(x_s);
        assert!((patch.force() / force - 1.0).abs() < 1e-9);

        let amplitude = 0.02;
        patch.move_to(amplitude);
        let before = patch.dissipated();
        patch.move_to(-amplitude);
        patch.move_to(amplitude);
        let slip = (amplitude - force / series) / gcr;
        let cycle = force * gcr * closed::cycle_dissipation(CHI_25, slip);
        assert!(((patch.dissipated() - before) / cycle - 1.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_spring_it_is_the_backbone() {
        let mut patch = SpringPatch::new(CHI_25, 2.0, 0.5, None);
        patch.move_to(0.25);
        assert_eq!(patch.slip(), 0.25);
        assert!((patch.force() - 2.0 * CHI_25.traction(0.5)).abs() < 1e-15);
    }
}
