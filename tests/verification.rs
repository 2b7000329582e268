//! Verification: the values that the law must give, one function or more per item of docs/verification.md.
//!
//! Expected values are printed digits (held to 1e-6), closed forms (1e-12), Masing's rules and the brute-force
//! slip elements of `mepc-oracle`; none comes from the library. Slip in critical slips, traction in mu p unless said. Item 10 is
//! in tests/properties.rs and tests/tangents.rs, 11 in tests/pressure.rs, 12 and 13 in tests/curves.rs.

mod support;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use mepc::{Matrix, Vector};
use mepc_oracle::closed::{self, HertzSphere, Iwan};
use mepc_oracle::masing::Masing;
use mepc_oracle::spring::SpringPatch;
use mepc_oracle::{Backbone, Status};
use std::f64::consts::{PI, TAU};
use support::structures::{Bar, Patch};
use support::{
    Point, decades, integral, paths, power, segalman, signed, state_size, turned, unit, with,
};

const CHI_15: Backbone = Backbone::Power { chi: 1.5 };
const CHI_25: Backbone = Backbone::Power { chi: 2.5 };

/// Tractions at the ends of straight branches, one step each.
fn tractions(props: &[f64], path: &[f64]) -> Vec<f64> {
    let mut point = Point::<1>::new(props);
    path.iter()
        .map(|&s| point.move_to([s], 1.0).traction[0])
        .collect()
}

/// Energy dissipated by one cycle between slips +-a, after a first loading to a.
fn cycle(props: &[f64], a: f64, pressure: f64) -> f64 {
    let mut point = Point::<1>::new(props);
    point.move_to([a], pressure);
    point.move_to([-a], pressure).dissipated + point.move_to([a], pressure).dissipated
}

#[test]
fn v01_backbone() {
    let printed = [
        (0.1, 0.231567, 0.146185),
        (0.25, 0.512861, 0.350481),
        (0.5, 0.823223, 0.646447),
        (0.75, 0.968750, 0.875),
    ];
    for (s, chi_25, chi_15) in printed {
        assert_abs_diff_eq!(tractions(&unit(2.5), &[s])[0], chi_25, epsilon = 1e-6);
        assert_abs_diff_eq!(tractions(&unit(1.5), &[s])[0], chi_15, epsilon = 1e-6);
    }
    // In physical units and both ways, against the formula; f = 1 beyond gcr.
    let (mu, gcr, p) = (0.37, 0.00268, 41.0);
    for chi in [1.0, 1.3, 1.5, 2.0, 2.5, 3.7, 8.0] {
        for s in [
            1e-9, 1e-4, 0.03, 0.1, 0.25, 0.5, 0.75, 0.999, 1.0, 1.5, 20.0,
        ] {
            for sign in [1.0, -1.0] {
                let mut point = Point::<1>::new(&power(mu, gcr, chi));
                let tau = point.move_to([sign * s * gcr], p).traction[0];
                let expected = sign * mu * p * (1.0 - (1.0 - f64::min(s, 1.0)).powf(chi));
                assert_abs_diff_eq!(tau, expected, epsilon = 1e-12 * mu * p);
            }
        }
    }
    for (c, beta) in [(-0.842, 0.0), (-0.5, 0.3), (0.0, 2.0)] {
        let backbone = Backbone::Segalman { c, beta };
        for s in [1e-6, 0.1, 0.5, 0.9, 1.0, 3.0] {
            let t = tractions(&segalman(c, beta), &[s])[0];
            assert_abs_diff_eq!(t, backbone.traction(s), epsilon = 1e-12);
        }
    }
}

#[test]
fn v02_nested_path() {
    let path = [0.0, 0.8, -0.2, 0.3, -0.2, -0.8, -1.0];
    let printed = [
        0.0, 0.982111, -0.664335, 0.361386, -0.664335, -0.982111, -1.0,
    ];
    let t = tractions(&unit(2.5), &path);
    for (t, printed) in t.iter().zip(printed) {
        assert_abs_diff_eq!(*t, printed, epsilon = 1e-6);
    }
    // The loop closes on the point where it left, to the last digits.
    assert_abs_diff_eq!(t[2], t[4], epsilon = 1e-12);
    assert_abs_diff_eq!(t[1], -t[5], epsilon = 1e-12);
    let mut exact = Masing::new(CHI_25);
    for (t, s) in t.iter().zip(path) {
        exact.move_to(s);
        assert_abs_diff_eq!(*t, exact.traction(), epsilon = 1e-12);
    }
}

#[test]
fn v03_origin_moves_with_gross_slip() {
    let zero = tractions(&unit(2.5), &[5.0, 4.515717])[1];
    assert_abs_diff_eq!(zero, 0.0, epsilon = 2e-6); // half a digit of s times the slope of about 2
    // t = 1 - 2 f(x) = 0 half way down: x = 1 - 2^(-1/chi), s = 5 - 2 x.
    let s = 5.0 - 2.0 * (1.0 - 0.5f64.powf(1.0 / 2.5));
    assert_abs_diff_eq!(s, 4.515717, epsilon = 1e-6);
    assert_abs_diff_eq!(tractions(&unit(2.5), &[5.0, s])[1], 0.0, epsilon = 1e-12);
    let t = tractions(&unit(2.5), &[5.0, 3.001, 3.0, 2.0]);
    assert!(t[1] > -1.0);
    assert_abs_diff_eq!(t[2], -1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(t[3], -1.0, epsilon = 1e-12);
}

#[test]
fn v04_back_to_zero_slip() {
    for (chi, printed) in [(2.5, -0.646447), (1.5, -0.292893), (2.0, -0.5)] {
        let t = tractions(&unit(chi), &[1.0, 0.0])[1];
        assert_abs_diff_eq!(t, printed, epsilon = 1e-6);
        let formula = 1.0 - 2.0 * (1.0 - 0.5f64.powf(chi));
        assert_abs_diff_eq!(t, formula, epsilon = 1e-12);
    }
}

#[test]
fn v05_dissipation_per_cycle() {
    let amplitudes = [0.1, 0.25, 0.5, 1.0, 2.0];
    let chi_25 = [0.002437, 0.036521, 0.269870, 1.714286, 5.714286];
    let chi_15 = [0.000513, 0.008365, 0.072792, 0.8, 4.8];
    for (i, a) in amplitudes.into_iter().enumerate() {
        assert_abs_diff_eq!(cycle(&unit(2.5), a, 1.0), chi_25[i], epsilon = 1e-6);
        assert_abs_diff_eq!(cycle(&unit(1.5), a, 1.0), chi_15[i], epsilon = 1e-6);
        for chi in [1.0, 1.2, 1.5, 2.0, 2.5, 3.7] {
            let exact = closed::power_law_cycle(chi, a);
            assert_abs_diff_eq!(cycle(&unit(chi), a, 1.0), exact, epsilon = 1e-12);
        }
        if a <= 1.0 {
            let d = cycle(&unit(2.0), a, 1.0);
            assert_abs_diff_eq!(d, 4.0 / 3.0 * a.powi(3), epsilon = 1e-12);
        }
        let backbone = Backbone::Segalman {
            c: -0.842,
            beta: 0.3,
        };
        let exact = closed::cycle_dissipation(backbone, a);
        assert_abs_diff_eq!(
            cycle(&segalman(-0.842, 0.3), a, 1.0),
            exact,
            epsilon = 1e-12
        );
    }
    // Small amplitudes keep their digits: D -> (2/3) chi (chi - 1) a^3, the next term is of the order of a.
    for chi in [1.5, 2.5, 3.7] {
        for a in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
            let leading = 2.0 / 3.0 * chi * (chi - 1.0) * a * a * a;
            let d = cycle(&unit(chi), a, 1.0);
            assert_relative_eq!(d, leading, epsilon = 0.0, max_relative = 2.0 * a + 1e-6);
        }
    }
    for (a, printed) in [(0.5, 0.10435), (1.0, 0.27284), (2.0, 0.45473)] {
        let f = tractions(&unit(2.5), &[a])[0];
        let ratio = cycle(&unit(2.5), a, 1.0) / (TAU * a * f);
        assert_abs_diff_eq!(ratio, printed, epsilon = 1e-5);
    }
    // Physical units.
    let (mu, gcr, p) = (0.42, 0.0031, 18.0);
    let d = cycle(&power(mu, gcr, 2.5), 0.7 * gcr, p);
    let exact = mu * p * gcr * closed::power_law_cycle(2.5, 0.7);
    assert_relative_eq!(d, exact, max_relative = 1e-12);
}

#[test]
fn v06_stored_energy_and_work_of_first_loading() {
    for chi in [1.0, 1.5, 2.5, 4.0] {
        for slip in [1.0, 7.0] {
            let stored = Point::<1>::new(&unit(chi)).move_to([slip], 1.0).stored;
            assert_abs_diff_eq!(stored, 1.0 / (chi + 1.0), epsilon = 1e-12);
        }
        // The work is what the traction says, not what the energies add up to.
        let work = integral(&|s| tractions(&unit(chi), &[s])[0], 0.0, 1.0, 1e-13);
        assert_abs_diff_eq!(work, chi / (chi + 1.0), epsilon = 1e-11);
        let first = Point::<1>::new(&unit(chi)).move_to([1.0], 1.0);
        assert_abs_diff_eq!(first.stored + first.dissipated, work, epsilon = 1e-11);
    }
    let stored = Point::<1>::new(&unit(2.5)).move_to([1.0], 1.0).stored;
    assert_abs_diff_eq!(stored, 2.0 / 7.0, epsilon = 1e-12);
    let (c, beta) = (-0.6, 0.4);
    let stored = Point::<1>::new(&segalman(c, beta))
        .move_to([2.0], 1.0)
        .stored;
    let exact = closed::saturated_energy(Backbone::Segalman { c, beta });
    assert_abs_diff_eq!(stored, exact, epsilon = 1e-12);
}

#[test]
fn v07_initial_tangent_penalty_and_lagrange_limit() {
    let (mu, gcr, p) = (0.3, 0.002, 25.0);
    for chi in [1.0, 1.5, 2.5, 6.0] {
        let stiffness = mu * p * chi / gcr;
        let point = Point::<1>::new(&power(mu, gcr, chi));
        let plane = Point::<2>::new(&power(mu, gcr, chi));
        // The second is shorter than any knot is apart from the origin.
        for tiny in [0.0, 1e-15 * gcr, 1e-12 * gcr] {
            let tangent = point.trial([tiny], p).0.dtraction_dslip[(0, 0)];
            assert_relative_eq!(tangent, stiffness, max_relative = 1e-10);
            let tangent = plane.trial([0.6 * tiny, -0.8 * tiny], p).0.dtraction_dslip;
            assert_relative_eq!(
                tangent,
                Matrix::identity() * stiffness,
                epsilon = 1e-10 * stiffness
            );
        }
    }

    let amplitude = 5.0 * gcr;
    let penalty = 4.0 * mu * p * (amplitude - gcr);
    let chi_1 = cycle(&power(mu, gcr, 1.0), amplitude, p);
    assert_relative_eq!(chi_1, penalty, max_relative = 1e-12);
    let method_1 = cycle(&with(&power(mu, gcr, 2.5), 4, 1.0), amplitude, p);
    assert_relative_eq!(method_1, penalty, max_relative = 1e-12);
    let t = Point::<1>::new(&with(&power(mu, gcr, 2.5), 4, 1.0)).move_to([0.3 * gcr], p);
    assert_relative_eq!(t.traction[0], 0.3 * mu * p, max_relative = 1e-12);

    // gcr -> 0 of the memory law, and method 2, here the penalty with gcr / 1000.
    let lagrange = 4.0 * mu * p * amplitude;
    let short = cycle(&power(mu, 1e-9 * gcr, 2.5), amplitude, p);
    assert_relative_eq!(short, lagrange, max_relative = 1e-9);
    let method_2 = with(&power(mu, gcr, 2.5), 4, 2.0);
    let stiff = cycle(&method_2, amplitude, p);
    let exact = 4.0 * mu * p * (amplitude - 1e-3 * gcr);
    assert_relative_eq!(stiff, exact, max_relative = 1e-12);
}

/// A random history along a line: turning points of any size, gross slip now and then.
fn turning_points(random: &mut fastrand::Rng, count: usize) -> Vec<f64> {
    (0..count)
        .map(|_| signed(random) * [0.1, 0.5, 1.0, 3.0][random.usize(0..4)])
        .collect()
}

#[test]
fn v08_rotation() {
    let (mu, gcr, p) = (0.3, 0.002, 25.0);
    let mut random = fastrand::Rng::with_seed(8);
    for chi in [1.0, 1.5, 2.5, 3.3] {
        let props = power(mu, gcr, chi);
        for angle in [0.0, 0.3, PI / 4.0, PI / 2.0, 2.0, PI, 4.0, -1.1] {
            let mut line = Point::<1>::with_state_size(&props, state_size(1, 64));
            let mut plane = Point::<2>::with_state_size(&props, state_size(2, 64));
            let mut exact = Masing::new(Backbone::Power { chi });
            for s in turning_points(&mut random, 40) {
                let along = turned([s * gcr, 0.0], angle);
                let (one, two) = (line.move_to([s * gcr], p), plane.move_to(along, p));
                exact.move_to(s);
                let t = mu * p * exact.traction();
                let expected = turned([t, 0.0], angle);
                assert_abs_diff_eq!(one.traction[0], t, epsilon = 1e-12 * mu * p);
                assert_abs_diff_eq!(two.traction[0], expected[0], epsilon = 1e-12 * mu * p);
                assert_abs_diff_eq!(two.traction[1], expected[1], epsilon = 1e-12 * mu * p);
                let energy = mu * p * gcr;
                assert_abs_diff_eq!(two.stored, one.stored, epsilon = 1e-12 * energy);
                assert_abs_diff_eq!(
                    two.dissipated,
                    one.dissipated,
                    epsilon = 1e-12 * energy * s.abs().max(1.0)
                );
                // Along the line the two tangents agree, too.
                let n = Vector::from(turned([1.0, 0.0], angle));
                let slope = n.dot(&(two.dtraction_dslip * n));
                let stiffness = mu * p * chi / gcr;
                assert_abs_diff_eq!(
                    slope,
                    one.dtraction_dslip[(0, 0)],
                    epsilon = 1e-9 * stiffness
                );
            }
        }
    }
    // A curved path: traction and tangent turn with it.
    let walk = paths::random_walk(&mut random, 400, 0.4);
    for angle in [0.7, PI / 2.0, 3.0] {
        let (mut straight, mut rotated) =
            (Point::<2>::new(&unit(2.5)), Point::<2>::new(&unit(2.5)));
        let columns = [turned([1.0, 0.0], angle), turned([0.0, 1.0], angle)].map(Vector::from);
        let q = Matrix::<2>::from_columns(&columns);
        for &at in &walk {
            let (a, b) = (
                straight.move_to(at, 1.0),
                rotated.move_to(turned(at, angle), 1.0),
            );
            assert_abs_diff_eq!(q * a.traction, b.traction, epsilon = 1e-10);
            assert_abs_diff_eq!(
                q * a.dtraction_dslip * q.transpose(),
                b.dtraction_dslip,
                epsilon = 1e-6
            );
            assert_abs_diff_eq!(a.dissipated, b.dissipated, epsilon = 1e-10);
        }
    }
}

#[test]
fn v09_step_size() {
    let seed = 9;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut worst_t, mut worst_d) = (0.0f64, 0.0f64);
    for chi in [1.0, 1.5, 2.5] {
        let props = unit(chi);
        for _ in 0..3 {
            let path = turning_points(&mut random, 12);
            // Room for every reversal of this path.
            let roomy = Point::<1>::with_state_size(&props, state_size(1, 20));
            let (t, d) = one_step_or_a_thousand(roomy, &path, |s| [s]);
            (worst_t, worst_d) = (worst_t.max(t), worst_d.max(d));
            let roomy = Point::<2>::with_state_size(&props, state_size(2, 20));
            let (t, d) = one_step_or_a_thousand(roomy, &path, |s| [0.6 * s, -0.8 * s]);
            (worst_t, worst_d) = (worst_t.max(t), worst_d.max(d));
        }
    }
    println!("enough slots: traction {worst_t:.1e}, dissipation {worst_d:.1e}");
    assert!(worst_t < 1e-12, "{worst_t:e}");
    assert!(worst_d < 1e-9, "{worst_d:e}");

    let mut full = 0.0f64;
    for chi in [1.5, 2.5] {
        let props = unit(chi);
        // Ever smaller reversals: more than four knots can hold, and then than nine.
        let spiral: Vec<f64> = (0..14).map(|k| 0.95 * (-0.85f64).powi(k)).collect();
        let mut histories = vec![spiral];
        histories.extend((0..6).map(|_| turning_points(&mut random, 30)));
        for path in histories {
            for nstate in [state_size(1, 4), state_size(1, 9)] {
                let point = Point::<1>::with_state_size(&props, nstate);
                let (t, d) = one_step_or_a_thousand(point, &path, |s| [s]);
                full = full.max(t).max(d);
            }
            for nstate in [state_size(2, 4), state_size(2, 9)] {
                let point = Point::<2>::with_state_size(&props, nstate);
                let (t, d) = one_step_or_a_thousand(point, &path, |s| [0.6 * s, -0.8 * s]);
                full = full.max(t).max(d);
            }
        }
    }
    println!("more reversals than slots: {full:.1e}");
    assert!(full < 1e-9, "{full:e}");
}

/// Thirty nested loops, each a little smaller than the one before: what dropped reversals cost (README, State variables).
#[test]
fn v09_what_a_full_memory_costs() {
    for (nstate, bound) in [(state_size(1, 16), 0.01), (state_size(1, 4), 0.2)] {
        let mut worst = 0.0f64;
        for shrinks in [0.95, 0.9, 0.8, 0.7f64] {
            let mut point = Point::<1>::with_state_size(&unit(2.5), nstate);
            let mut exact = Masing::new(Backbone::Power { chi: 2.5 });
            let mut full = false;
            for k in 0..30 {
                let (from, to) = (point.slip[0], 1.2 * (-shrinks).powi(k));
                for part in 1..=100 {
                    let s = from + (to - from) * f64::from(part) / 100.0;
                    let response = point.move_to([s], 1.0);
                    full |= response.memory_full;
                    exact.move_to(s);
                    worst = worst.max((response.traction[0] - exact.traction()).abs());
                }
            }
            assert!(full, "{nstate}: the memory is never full");
        }
        println!("{nstate} state variables: {:.2} % of mu p", 100.0 * worst);
        assert!(worst < bound, "{nstate}: {worst}");
    }
}

/// Worst differences of traction and of the dissipation of a branch between one step and a thousand.
fn one_step_or_a_thousand<const N: usize>(
    start: Point<N>,
    path: &[f64],
    along: impl Fn(f64) -> [f64; N],
) -> (f64, f64) {
    let (mut coarse, mut fine) = (start.clone(), start);
    let (mut traction, mut dissipation) = (0.0f64, 0.0f64);
    for &s in path {
        let one = coarse.move_to(along(s), 1.0);
        let (thousand, dissipated) = fine.move_in_steps(along(s), 1.0, 1000);
        traction = traction.max((one.traction - thousand.traction).norm());
        dissipation = dissipation.max((one.dissipated - dissipated).abs());
        zero_increment_changes_nothing(&coarse, &one.traction);
        zero_increment_changes_nothing(&fine, &thousand.traction);
    }
    (traction, dissipation)
}

fn zero_increment_changes_nothing<const N: usize>(point: &Point<N>, traction: &Vector<N>) {
    let (response, end) = point.trial([0.0; N], 1.0);
    assert_eq!(point.state, end);
    assert_eq!(response.dissipated, 0.0);
    assert!(!response.memory_full);
    assert_abs_diff_eq!(response.traction, *traction, epsilon = 1e-15);
}

#[test]
fn v14_sphere_on_a_flat() {
    let sphere = HertzSphere {
        young: 192_850.0,
        poisson: 0.29,
        radius: 4.174432,
        mu: 0.2,
        approach: 0.010,
    };
    let gcr = sphere.critical_slip();
    assert_abs_diff_eq!(sphere.normal_force(), 286.79992, epsilon = 1e-5);
    assert_abs_diff_eq!(gcr, 2.408451e-3, epsilon = 1e-9);
    // The contact circle in rings, each a point under its mean pressure.
    let radius = sphere.contact_radius();
    let ends = |k: u32| {
        (
            radius * f64::from(k) / 40.0,
            radius * f64::from(k + 1) / 40.0,
        )
    };
    let mut patch = Patch::new(
        &power(sphere.mu, gcr, 1.5),
        (0..40)
            .map(ends)
            .map(|(a, b)| (PI * (b * b - a * a), sphere.ring_pressure(a, b))),
        None,
    );
    let amplitude = 1.5 * gcr;
    patch.move_to(0.4 * gcr);
    let mindlin = sphere.mu * sphere.normal_force() * CHI_15.traction(0.4);
    assert_relative_eq!(patch.force(), mindlin, max_relative = 1e-9);
    patch.move_to(amplitude);
    let dissipated = patch.dissipated;
    patch.move_to(-amplitude);
    patch.move_to(amplitude);
    let joule = 1e-3 * (patch.dissipated - dissipated);
    assert_abs_diff_eq!(joule, 3.86816e-4, epsilon = 1e-9);
}

#[test]
fn v15_patch_and_series_spring() {
    let (mu, gcr, series) = (0.37, 0.00268, 178e3);
    let props = power(mu, gcr, 2.5);
    let mut random = fastrand::Rng::with_seed(15);
    // Any pressure distribution of the same total gives the same force.
    for _ in 0..5 {
        let points: Vec<(f64, f64)> = (0..60)
            .map(|_| (random.f64(), decades(&mut random, -2.0, 2.0)))
            .collect();
        let total: f64 = points.iter().map(|(area, p)| area * p).sum();
        let mut patch = Patch::new(&props, points, None);
        let mut exact = Masing::new(CHI_25);
        for s in [0.3, 0.8, -0.2, 0.4, -1.7, 2.5, 2.0] {
            patch.move_to(s * gcr);
            exact.move_to(s);
            assert_abs_diff_eq!(
                patch.force(),
                mu * total * exact.traction(),
                epsilon = 1e-12 * mu * total
            );
        }
    }

    // Behind a spring.
    let (area, pressure) = (361.52, 1.64);
    let limit = mu * area * pressure;
    let points = [(0.2 * area, 3.0 * pressure), (0.8 * area, 0.5 * pressure)];
    let mut patch = Patch::new(&props, points, Some(series));
    let (gross, stiffness) = closed::series_spring(CHI_25, limit, gcr, series);
    assert_relative_eq!(gross, gcr + limit / series, max_relative = 1e-14);
    let contact = patch.response(0.0).1;
    assert_relative_eq!(
        contact * series / (contact + series),
        stiffness,
        max_relative = 1e-12
    );
    patch.move_to(1e-9 * gross);
    assert_relative_eq!(
        patch.force() / (1e-9 * gross),
        stiffness,
        max_relative = 1e-7
    );
    patch.move_to(0.99 * gross);
    assert!(patch.force() < (1.0 - 1e-9) * limit);
    patch.move_to(gross);
    assert_relative_eq!(patch.force(), limit, max_relative = 1e-12);

    let mut patch = Patch::new(&props, points, Some(series));
    let mut exact = SpringPatch::new(CHI_25, limit, gcr, Some(series));
    let path = [0.3, 0.9, 0.2, 0.6, -0.4, -2.0, 3.0, 2.6, 2.9, -3.0];
    for displacement in path.map(|part| part * gross) {
        patch.move_to(displacement);
        exact.move_to(displacement);
        assert_abs_diff_eq!(patch.slip, exact.slip(), epsilon = 1e-10 * gcr);
        assert_abs_diff_eq!(patch.force(), exact.force(), epsilon = 1e-10 * limit);
        assert_abs_diff_eq!(
            patch.dissipated,
            exact.dissipated(),
            epsilon = 1e-10 * limit * gcr
        );
    }
    println!(
        "Newton iterations per step: {:.1}",
        f64::from(patch.iterations) / path.len() as f64
    );
    assert!(patch.iterations <= 8 * path.len() as u32);
}

#[test]
fn v16_elastic_bar() {
    let bar = || Bar::new(&unit(2.5), 100.0, 160.0, 8000);
    let exact = |a: f64| closed::bar_force(CHI_25, 100.0, 1.0, 1.0, 1.0, a);
    for (a, printed) in [
        (0.25, 3.70601),
        (0.5, 6.92155),
        (1.0, 11.95229),
        (2.0, 18.51640),
    ] {
        let (force, iterations) = bar().move_to(a);
        println!("a = {a}: {force:.6}, {iterations} iterations");
        assert_abs_diff_eq!(exact(a), printed, epsilon = 1e-5);
        // Elements of length h leave (h / decay length)^2 / 24 = 4e-7.
        assert_relative_eq!(force, exact(a), max_relative = 1e-6);
        assert!(iterations <= 12);
    }
    // The whole bar obeys Masing's rules, too.
    let mut bar = bar();
    bar.move_to(1.0);
    let (force, _) = bar.move_to(0.0);
    assert_abs_diff_eq!(force, exact(1.0) - 2.0 * exact(0.5), epsilon = 1e-5);
    let (force, _) = bar.move_to(1.0);
    assert_relative_eq!(force, exact(1.0), max_relative = 1e-6);
}

#[test]
fn v17_iwan_loop() {
    let joint = Iwan {
        force: 266.78,
        displacement: 0.0041,
        residual: 3280.7,
        kappa: -0.842,
    };
    let amplitude = 0.02;
    // The law in parallel with a spring: mu p times the area is F_s, gcr is X_s, chi = 5/2 + kappa.
    let mut point = Point::<1>::new(&power(0.29, joint.displacement, 2.5 + joint.kappa));
    let area = 361.52;
    let pressure = joint.force / (0.29 * area);
    let stiffness = area * point.trial([0.0], pressure).0.dtraction_dslip[(0, 0)] + joint.residual;
    let peak = area * point.move_to([amplitude], pressure).traction[0] + joint.residual * amplitude;
    let there = point.move_to([-amplitude], pressure);
    let lowest = area * there.traction[0] - joint.residual * amplitude;
    let loss = area * (there.dissipated + point.move_to([amplitude], pressure).dissipated);
    for (value, printed, exact, digits) in [
        (peak, 332.394, joint.peak_force(amplitude), 5e-4),
        (-lowest, 332.394, joint.peak_force(amplitude), 5e-4),
        (stiffness, 111_164.0, joint.stick_stiffness(), 0.5),
        (loss, 18.050, joint.cycle_dissipation(amplitude), 5e-4),
    ] {
        assert_abs_diff_eq!(value, printed, epsilon = digits);
        assert_relative_eq!(value, exact, max_relative = 1e-12);
    }
}

/// Contact status of the states along a history, as the numbers of the state table say.
#[test]
fn status_follows_the_slip_elements() {
    let mut point = Point::<1>::new(&unit(2.5));
    let mut exact = Masing::new(CHI_25);
    let mut seen = [0; 4];
    let mut random = fastrand::Rng::with_seed(18);
    for _ in 0..500 {
        let s = signed(&mut random) * decades(&mut random, -3.0, 0.5);
        let response = point.move_to([s], 1.0);
        exact.move_to(s);
        assert_eq!(response.contact as i32, exact.status() as i32, "at {s}");
        assert_eq!(point.state[0], f64::from(response.contact as u8));
        seen[exact.status() as usize] += 1;
    }
    assert!(seen[Status::Stick as usize] > 5 && seen[Status::MicroSlip as usize] > 5);
    assert!(seen[Status::GrossSlip as usize] > 5);
    point.step([0.1], 0.0);
    assert_eq!(point.state[0], f64::from(Status::Open as u8));
}
