//! Tangents against central differences along random walks.

use super::{Point, decades, signed};
use mepc::Vector;

/// Relative error up to which a tangent is one; item 10.
pub const SAME: f64 = 1e-6;

/// Comparison of tangents and central differences. A sample counts as left out when no step of three tells the tangent: a front
/// or a middle appears or vanishes between + and -, or the limit meets its cap.
#[derive(Debug, Default)]
pub struct TangentCheck {
    pub samples: u32,
    pub left_out: u32,
    /// Steps that dropped a knot that mattered.
    pub full: u32,
    /// Worst of the rest.
    pub slip: f64,
    pub pressure: f64,
}

impl TangentCheck {
    /// A random walk with both derivatives compared at every step, with a state of this size.
    pub fn walk<const N: usize>(
        &mut self,
        props: &[f64],
        nstate: usize,
        random: &mut fastrand::Rng,
        steps: u32,
    ) {
        let mut point = Point::<N>::with_state_size(props, nstate);
        let mut pressure = 1.0;
        for _ in 0..steps {
            let length = decades(random, -2.5, 0.3);
            let direction: [f64; N] = std::array::from_fn(|_| signed(random));
            let slip: [f64; N] = (Vector::from(direction).normalize() * length).into();
            let next = if random.bool() {
                pressure
            } else {
                decades(random, -0.5, 0.5)
            };
            self.slip_tangent(&point, slip, next);
            if next != pressure {
                self.pressure_tangent(&point, slip, next);
            }
            self.full += u32::from(point.step(slip, next).memory_full);
            pressure = next;
        }
    }

    fn count(&mut self, errors: [f64; 3], slip: bool) {
        self.samples += 1;
        let best = errors.into_iter().fold(f64::INFINITY, f64::min);
        if best > SAME {
            self.left_out += 1;
        } else if slip {
            self.slip = self.slip.max(best);
        } else {
            self.pressure = self.pressure.max(best);
        }
    }

    /// d traction / d slip, each column by itself; relative to the tangent, or to a tenth of the sticking one where it is small.
    fn slip_tangent<const N: usize>(&mut self, point: &Point<N>, slip: [f64; N], p: f64) {
        let tangent = point.trial(slip, p).0.dtraction_dslip;
        let scale = tangent
            .norm()
            .max(0.1 * point.law.sticking_stiffness(point.gcr, p));
        for j in 0..N {
            // Rounding asks for long steps, fronts that come and go for short ones.
            let errors = [1e-4, 1e-5, 1e-6].map(|part| {
                let h = part * Vector::from(slip).norm();
                let at = |h: f64| {
                    let mut moved = slip;
                    moved[j] += h;
                    point.trial(moved, p).0.traction
                };
                // Fourth order.
                let difference =
                    ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                (tangent.column(j) - difference).norm() / scale
            });
            self.count(errors, true);
        }
    }

    /// d traction / d pressure, relative to dT/dp or itself; at an unchanged pressure it is one-sided, see tests/tangents.rs.
    fn pressure_tangent<const N: usize>(&mut self, point: &Point<N>, slip: [f64; N], p: f64) {
        let derivative = point.trial(slip, p).0.dtraction_dpressure;
        let errors = [1e-4, 1e-5, 1e-6].map(|part| {
            let h = part * p;
            let at = |h: f64| point.trial(slip, p + h).0.traction;
            let difference = ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            (derivative - difference).norm() / derivative.norm().max(1.0)
        });
        self.count(errors, false);
    }
}
