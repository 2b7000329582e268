//! Verification item 10: the tangents to slip and to pressure, against differences and closed forms.

mod support;

use approx::assert_abs_diff_eq;
use mepc::{Matrix, Vector};
use support::tangent::TangentCheck;
use support::{Point, consistent, decades, segalman, signed, state_size, turned, unit, with};

fn laws() -> Vec<Vec<f64>> {
    let mut all = consistent(&unit(2.5));
    all.resize(16, 0.0);
    // Cohesion, cap, run-in.
    all[11..15].copy_from_slice(&[0.2, 2.0, 0.7, 5.0]);
    vec![
        unit(1.5),
        unit(2.5),
        segalman(-0.7, 0.2),
        consistent(&unit(1.0)),
        consistent(&unit(1.5)),
        consistent(&unit(2.5)),
        consistent(&unit(4.0)),
        all,
    ]
}

/// At most 1 % of the samples may be left out (fronts and middles that come and go, the kink of the cap); their number is printed.
#[test]
fn v10_tangents_against_differences() {
    let seed = 12;
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut line, mut plane) = (TangentCheck::default(), TangentCheck::default());
    for props in laws() {
        for knots in [4, 24] {
            line.walk::<1>(&props, state_size(1, knots), &mut random, 800);
            plane.walk::<2>(&props, state_size(2, knots), &mut random, 800);
        }
    }
    println!("seed {seed}, one direction: {line:?}");
    println!("seed {seed}, two directions: {plane:?}");
    for check in [line, plane] {
        assert!(check.left_out * 100 <= check.samples, "{check:?}");
        assert!(check.slip < 1e-6 && check.pressure < 1e-6);
        assert!(check.full > 100, "hardly ever full");
    }
}

/// First loading along a line: d t/d s = f' along it and f / s across, wherever the front is.
#[test]
fn first_loading_has_a_closed_form() {
    for chi in [1.5, 2.0, 2.5] {
        for props in [unit(chi), consistent(&unit(chi))] {
            let point = Point::<2>::new(&props);
            for s in [1e-6, 1e-3, 0.1, 0.25, 0.5, 0.9, 0.999] {
                for direction in [[0.6, -0.8], [0.0, 1.0]] {
                    let tangent = point.trial(direction.map(|x| s * x), 1.0).0.dtraction_dslip;
                    let n = Vector::from(direction);
                    let along = n * n.transpose();
                    let f = -(chi * f64::ln_1p(-s)).exp_m1();
                    let expected = along * (chi * (1.0 - s).powf(chi - 1.0))
                        + (Matrix::identity() - along) * (f / s);
                    assert_abs_diff_eq!(tangent, expected, epsilon = 1e-9);
                }
            }
        }
    }
}

/// A trap: a loop that closes almost exactly puts the front on a knot, and the secant between them is rounding. The stiffness along
/// the line is that of the branch inside or of the branch outside, or between them.
#[test]
fn a_front_on_a_knot() {
    for props in [unit(2.5), consistent(&unit(1.5))] {
        let chi = props[2];
        let slope = |r: f64| chi * (1.0 - r).powf(chi - 1.0);
        for direction in [[1.0, 0.0], [0.6, -0.8]] {
            for size in [0.4, 0.31, 1e-3] {
                for beside in [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-10, 1e-9] {
                    for d in [size * (1.0 + beside), size * (1.0 - beside)] {
                        let mut point = Point::<2>::new(&props);
                        point.step(direction.map(|x| 0.5 * x), 1.0);
                        point.step(direction.map(|x| -size * x), 1.0);
                        let tangent = point.trial(direction.map(|x| d * x), 1.0).0.dtraction_dslip;
                        let n = Vector::from(direction);
                        let along = n.dot(&(tangent * n));
                        let (outside, inside) = (slope(0.5), slope(0.5 * size));
                        assert!(
                            along > outside - 1e-6 && along < inside + 1e-6,
                            "size {size}, beside {beside:e}: {along}"
                        );
                    }
                }
            }
        }
    }
}

/// Gross slip that turns: all elements lie on their limits, and the front elements turn together; nothing of it is noise.
#[test]
fn elements_that_move_along_their_limits_turn_together() {
    let seed = 117;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for chi in [1.5, 2.0, 2.5] {
        for _ in 0..500 {
            let mut point = Point::<2>::new(&unit(chi));
            let n = turned([1.0, 0.0], 7.0 * random.f64());
            point.step(n.map(|x| 2.0 * x), 1.0);
            // Across, on the circle of the last element or straight on, which is outwards.
            let across = decades(&mut random, -12.0, -6.0);
            let back = [0.0, 0.5 * across * across][random.usize(0..2)];
            let step = [-across * n[1] - back * n[0], across * n[0] - back * n[1]];
            let response = point.step(step, 1.0);
            let n = Vector::from(n);
            assert_abs_diff_eq!(response.traction, n, epsilon = 1e-4);
            // No stiffness along the slip; across no more than the sticking one.
            assert!(
                (response.dtraction_dslip * n).norm() < 1e-4 * chi,
                "{across:e}"
            );
            let m = Vector::from(turned([n[0], n[1]], std::f64::consts::FRAC_PI_2));
            let stiffness = m.dot(&(response.dtraction_dslip * m));
            assert!(
                stiffness > 0.5 && stiffness < chi * (1.0 + 1e-9),
                "{across:e}: {stiffness}"
            );
        }
    }
}

/// At De = 0 = d the derivative by the pressure is that of a rising one: what sticks keeps its traction (consistent rule).
#[test]
fn at_rest_the_rising_side() {
    for props in [consistent(&unit(1.5)), consistent(&unit(2.5))] {
        for path in [
            vec![[0.5, 0.0]],
            vec![[0.5, 0.1], [-0.3, 0.2]],
            vec![[4.0, 3.0], [-0.1, 0.2]],
        ] {
            let mut point = Point::<2>::new(&props);
            for d in path {
                point.step(d, 1.0);
            }
            let rest = point.trial([0.0; 2], 1.0).0;
            let up = point.trial([0.0; 2], 1.0 + 1e-6).0;
            assert_abs_diff_eq!(
                (up.traction - rest.traction) / 1e-6,
                rest.dtraction_dpressure,
                epsilon = 1e-8
            );
            assert_eq!(rest.dtraction_dpressure.norm(), 0.0);
            // A slip, however small, makes the stiffness that of the branch.
            let tiny = point.trial([-1e-12, 0.0], 1.0).0.dtraction_dslip;
            let along = tiny * Vector::from([-1.0, 0.0]);
            assert_abs_diff_eq!(
                along,
                rest.dtraction_dslip * Vector::from([-1.0, 0.0]),
                epsilon = 0.6 * props[2]
            );
        }
    }
}

/// One direction: d tau/dp = s T' (chi/G - f'(R*)) G/chi, with the front R*; in gross slip s mu.
#[test]
fn pressure_tangent_in_one_direction() {
    let seed = 311;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut point = Point::<1>::new(&consistent(&unit(2.5)));
    let mut gross = 0;
    for _ in 0..500 {
        let (d, p) = (signed(&mut random), 0.5 + random.f64());
        let response = point.step([d], p);
        let (chi, k) = (2.5, response.dtraction_dslip[(0, 0)]);
        let g = p.powf(1.0 / chi);
        let size = response.dtraction_dpressure[0].abs();
        if response.contact as i32 == 3 {
            gross += 1;
            assert_eq!(k, 0.0);
            assert_abs_diff_eq!(size, 1.0, epsilon = 1e-15);
        } else if response.contact as i32 == 2 {
            // k = T f'(R*)
            assert_abs_diff_eq!(size, (chi / g - k / p) * g / chi, epsilon = 1e-12);
        }
    }
    assert!(gross > 50);
    // The cap: no derivative at it and beyond.
    let point = Point::<1>::new(&with(&consistent(&unit(2.5)), 13, 2.0));
    assert_abs_diff_eq!(
        point.trial([3.0], 1.9).0.dtraction_dpressure[0],
        1.0,
        epsilon = 1e-15
    );
    for p in [2.0, 5.0] {
        assert_eq!(point.trial([3.0], p).0.dtraction_dpressure[0], 0.0);
    }
}
