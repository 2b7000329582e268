//! Tangents of the faces against central differences of their own forces, over random histories.

use crate::mfront::{CONSISTENT, Hypothesis, NO_OPERATOR, Point};
use crate::support::signed;
use crate::umat;

/// Steps of a history, and the part of them whose differences may straddle a kink of the law.
const STEPS: u32 = 300;
const KINKS: f64 = 0.02;
/// Largest error relative to the sticking stiffness.
const SAME: f64 = 1e-6;

/// Compares columns of K with (force(x + h) - force(x - h)) / 2h; tells whether the point is smooth.
struct Check {
    compared: u32,
    kinks: u32,
    worst: f64,
}

impl Check {
    fn new() -> Self {
        Check {
            compared: 0,
            kinks: 0,
            worst: 0.0,
        }
    }

    /// Forces before, at and after, the column of K, the step, and the scale of K.
    fn column(&mut self, forces: [&[f64]; 3], column: &[f64], h: f64, scale: f64) {
        let [minus, at, plus] = forces;
        self.compared += 1;
        let one_sided = |a: &[f64], b: &[f64], i: usize| (a[i] - b[i]) / h;
        // On a kink the two sides differ, by much more than curvature makes.
        let smooth = (0..at.len())
            .all(|i| (one_sided(plus, at, i) - one_sided(at, minus, i)).abs() < 1e-3 * scale);
        if !smooth {
            self.kinks += 1;
            return;
        }
        for i in 0..at.len() {
            let error = ((plus[i] - minus[i]) / (2.0 * h) - column[i]).abs() / scale;
            self.worst = self.worst.max(error);
        }
    }

    fn finish(self, what: &str) {
        println!(
            "{what}: {} columns, {} on kinks, worst {:.1e}",
            self.compared, self.kinks, self.worst
        );
        assert!(self.worst < SAME, "{what}: {:e}", self.worst);
        assert!(
            f64::from(self.kinks) <= KINKS * f64::from(self.compared),
            "{what}: {} kinks",
            self.kinks
        );
    }
}

/// A random walk of openings: closed most of the time, slips of about a critical slip.
fn openings(seed: u64) -> Vec<[f64; 3]> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut slip = [0.0; 2];
    let steps = (0..STEPS).map(|_| {
        for s in &mut slip {
            *s += 0.0012 * signed(&mut random);
        }
        let normal = -0.002 + 0.0015 * signed(&mut random);
        [normal, slip[0], slip[1]]
    });
    steps.collect()
}

#[test]
fn umat_against_differences() {
    for (symbol, layout, ntens, nstate, slots, scale, thickness) in [
        ("umat", 0.0, 2, 44, &[0, 1][..], 1.0, 0.0),
        ("umat", 0.0, 3, 84, &[0, 1, 2], 1.0, 0.0),
        ("umat", 1.0, 6, 84, &[2, 5, 4], 2.0, 0.0),
        ("umat_", 2.0, 6, 84, &[2, 4, 5], 1.0, 0.3),
    ] {
        let props = umat::props(layout, scale, thickness, 0.0);
        let mut point = umat::Point::new(symbol, &props, ntens, nstate);
        let length = scale * if layout == 2.0 { thickness } else { 1.0 };
        let stiffness = 2.5 * 0.3 * 3e4 * 0.002 / 0.002 * length * scale;
        let h = 1e-7 * 0.002 / length;
        let mut check = Check::new();
        for opening in openings(5) {
            let mut dstran = vec![0.0; ntens];
            for (k, slot) in slots.iter().enumerate() {
                dstran[*slot] = opening[k] / length - point.stran[*slot];
            }
            let at = point.trial(&dstran);
            for j in 0..ntens {
                let moved = |by: f64| {
                    let mut dstran = dstran.clone();
                    dstran[j] += by;
                    point.trial(&dstran).stress
                };
                let (minus, plus) = (moved(-h), moved(h));
                let column: Vec<f64> = (0..ntens).map(|i| at.ddsdde[i * ntens + j]).collect();
                check.column([&minus, &at.stress, &plus], &column, h, stiffness);
            }
            point.accept(&dstran, &at);
        }
        check.finish(&format!("{symbol}, layout {layout}, NTENS {ntens}"));
    }
}

#[test]
fn mfront_against_differences() {
    let props = [0.3, 0.002, 2.5, 0.0, 0.0, 0.0, 3e4, -0.001];
    for behaviour in ["MemoryPenaltyContact", "MemoryPenaltyLayer"] {
        for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::Tridimensional] {
            let mut point = Point::new(behaviour, hypothesis, &props, 0.3);
            let length = if behaviour == "MemoryPenaltyLayer" {
                0.3
            } else {
                1.0
            };
            let stiffness = 2.5 * 0.3 * 3e4 * 0.002 / 0.002 * length;
            let h = 1e-7 * 0.002 / length;
            let mut check = Check::new();
            for opening in openings(6) {
                point.open(&opening[..1 + hypothesis.directions()]);
                assert_eq!(point.call(CONSISTENT), 1);
                let (at, state, k) = (
                    point.forces[1].clone(),
                    point.states[1].clone(),
                    point.k.clone(),
                );
                let n = at.len();
                for j in 0..n {
                    let here = point.gradients[1][j];
                    let mut moved = |by: f64| {
                        point.gradients[1][j] = here + by;
                        assert_eq!(point.call(NO_OPERATOR), 1);
                        point.gradients[1][j] = here;
                        point.forces[1].clone()
                    };
                    let (minus, plus) = (moved(-h), moved(h));
                    let column: Vec<f64> = (0..n).map(|i| k[i * n + j]).collect();
                    check.column([&minus, &at, &plus], &column, h, stiffness);
                }
                point.forces[1] = at;
                point.states[1] = state;
                point.accept();
            }
            check.finish(&format!("{behaviour}, {}", hypothesis.name()));
        }
    }
}
