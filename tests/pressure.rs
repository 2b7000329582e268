//! Verification item 11: changing pressure under both rules, and all else that acts through the limit traction.
//!
//! Expected values are printed digits, closed forms, slip elements of fixed depth and springs of constant stiffness of
//! `mepc-oracle`. mu = gcr = 1 and p0 = 1 unless said.

mod support;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use mepc::{Kind, Law, Vector};
use mepc_oracle::Backbone;
use mepc_oracle::jenkins::Jenkins;
use mepc_oracle::limit::Limit;
use mepc_oracle::masing::Masing;
use mepc_oracle::twin::Twin;
use support::{Point, consistent, decades, segalman, signed, state_size, unit, with};

/// Tractions after increments (slip, pressure at its end).
fn tractions(props: &[f64], increments: &[(f64, f64)]) -> Vec<f64> {
    let mut point = Point::<1>::new(props);
    increments
        .iter()
        .map(|&(d, p)| point.step([d], p).traction[0])
        .collect()
}

/// 11a: what sticks keeps its traction while the pressure rises; a fall takes it, and it does not come back.
#[test]
fn v11a_held_slip() {
    for (chi, printed) in [
        (1.0, [0.5, 0.5, 0.5, 0.4, 0.4]),
        (1.5, [0.646447, 0.646447, 0.646447, 0.391120, 0.391120]),
        (2.5, [0.823223, 0.823223, 0.823223, 0.383605, 0.383605]),
    ] {
        let t = tractions(
            &consistent(&unit(chi)),
            &[(0.5, 1.0), (0.0, 2.0), (0.0, 1.0), (0.0, 0.4), (0.0, 1.0)],
        );
        for (t, printed) in t.iter().zip(printed) {
            assert_abs_diff_eq!(*t, printed, epsilon = 1e-6);
        }
        assert_abs_diff_eq!(t[0], t[2], epsilon = 1e-14);
        assert_abs_diff_eq!(t[3], t[4], epsilon = 1e-14);
        // At the lower pressure it is the backbone of that pressure.
        let g = 0.4f64.powf(1.0 / chi);
        let fallen = 0.4 * Backbone::Power { chi }.traction(0.5 / g);
        assert_abs_diff_eq!(t[3], fallen, epsilon = 1e-12);
    }
}

/// 11b: the ripple. The first fall counts, and the next thousand cycles nothing.
#[test]
fn v11b_ripple() {
    for (chi, first, later) in [
        (1.0, 0.3, 0.3),
        (1.5, 0.41434, 0.39737),
        (2.5, 0.59004, 0.54781),
    ] {
        for direction in [[1.0, 0.0], [0.6, -0.8]] {
            let mut point = Point::<2>::new(&consistent(&unit(chi)));
            let n = Vector::from(direction);
            point.step(direction.map(|x| 0.3 * x), 1.0);
            let mut settled = f64::NAN;
            for cycle in 0..1000 {
                let [up, down, back] = [1.1, 0.9, 1.0].map(|p| {
                    let response = point.step([0.0; 2], p);
                    assert!(response.dissipated >= -1e-15, "{:e}", response.dissipated);
                    response.traction.dot(&n)
                });
                if cycle == 0 {
                    assert_abs_diff_eq!(up, first, epsilon = 5e-6);
                    assert_abs_diff_eq!(down, later, epsilon = 5e-6);
                    settled = back;
                }
                assert_abs_diff_eq!(back, settled, epsilon = 1e-12);
            }
        }
    }
}

/// 11c: Mindlin and Deresiewicz' legs. One call a leg, ten, or a thousand.
#[test]
fn v11c_legs_of_mindlin_and_deresiewicz() {
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
        let mut totals = Vec::new();
        for parts in [1, 10, 1000] {
            for direction in [[1.0, 0.0], [-0.28, 0.96]] {
                let mut point = Point::<2>::new(&consistent(&unit(chi)));
                point.step([0.0; 2], 1.0);
                let (mut g, mut dissipated) = (1.0, 0.0);
                for ((d, growth), printed) in legs.into_iter().zip(printed) {
                    let mut t = f64::NAN;
                    for part in 1..=parts {
                        let now: f64 = g + growth * f64::from(part) / f64::from(parts);
                        let step = direction.map(|x| x * d / f64::from(parts));
                        let response = point.step(step, now.powf(chi));
                        dissipated += response.dissipated;
                        t = response.traction.dot(&Vector::from(direction));
                    }
                    g += growth;
                    assert_abs_diff_eq!(t, printed, epsilon = 1e-8);
                }
                totals.push((
                    point.step([0.0; 2], g.powf(chi)).traction.norm(),
                    dissipated,
                ));
            }
        }
        for total in &totals {
            assert_abs_diff_eq!(total.0, totals[0].0, epsilon = 1e-10);
            assert_abs_diff_eq!(total.1, totals[0].1, epsilon = 1e-9);
        }
    }
}

/// Random straight histories in slip and in G: one call or a hundred, traction and dissipation, in one direction and oblique.
#[test]
fn v11c_one_call_or_a_hundred() {
    let seed = 211;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut traction, mut dissipated) = (0.0f64, 0.0f64);
    for chi in [1.0, 1.5, 2.5, 4.0] {
        let mut one = Point::<2>::with_state_size(&consistent(&unit(chi)), state_size(2, 64));
        let mut many = one.clone();
        let mut g = 1.0;
        for point in [&mut one, &mut many] {
            point.step([0.0; 2], 1.0);
        }
        for _ in 0..60 {
            let d = signed(&mut random) * decades(&mut random, -2.0, 0.3);
            let to: f64 = match random.u32(0..3) {
                0 => g,
                1 => (g * (1.0 + 0.2 * signed(&mut random))).clamp(0.4, 2.0),
                _ => 0.4 + 1.6 * random.f64(),
            };
            let a = one.step([0.8 * d, 0.6 * d], to.powf(chi));
            let (mut b, mut lost) = (a.clone(), 0.0);
            for part in 1..=100 {
                let now = g + (to - g) * f64::from(part) / 100.0;
                b = many.step([0.008 * d, 0.006 * d], now.powf(chi));
                lost += b.dissipated;
            }
            g = to;
            traction = traction.max((a.traction - b.traction).norm());
            dissipated = dissipated.max((a.dissipated - lost).abs());
        }
    }
    println!("traction {traction:.1e}, dissipation {dissipated:.1e}");
    assert!(traction < 1e-10 && dissipated < 1e-9);
}

/// 11d: with chi = 1, and with method 1, any limit history is that of the spring of constant stiffness.
#[test]
fn v11d_constant_stiffness() {
    let seed = 212;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for props in [
        consistent(&unit(1.0)),
        with(&consistent(&unit(2.5)), 4, 1.0),
    ] {
        let mut line = Point::<1>::new(&props);
        let mut oblique = Point::<2>::new(&props);
        let (mut spring, mut slanted) = (Jenkins::new(1.0), Jenkins::new(1.0));
        let mut pressure = 1.0;
        let mut worst = 0.0f64;
        for _ in 0..3000 {
            let d = signed(&mut random) * decades(&mut random, -3.0, 0.5);
            pressure = match random.u32(0..6) {
                0 => decades(&mut random, -1.0, 1.0),
                1..=3 => pressure * (1.0 + 0.1 * signed(&mut random)),
                _ => pressure,
            };
            let along = [0.28 * d, -0.96 * d];
            spring.step([d, 0.0], pressure, 1);
            slanted.step(along, pressure, 1);
            let (a, b) = (line.step([d], pressure), oblique.step(along, pressure));
            worst = worst.max((a.traction[0] - spring.traction[0]).abs());
            worst = worst.max((b.traction - Vector::from(slanted.traction)).norm());
        }
        println!("worst {worst:.1e}");
        assert!(worst < 1e-12 * 10.0, "{worst:e}");
    }
}

/// 11d in two directions: against the spring in 2000 parts, and the difference is the parts'.
#[test]
fn v11d_constant_stiffness_on_curved_paths() {
    let seed = 213;
    println!("seed {seed}");
    let mut worst = [0.0f64; 2];
    for (index, parts) in [200, 2000].into_iter().enumerate() {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut plane = Point::<2>::new(&consistent(&unit(1.0)));
        let mut spring = Jenkins::new(1.0);
        let mut pressure = 1.0;
        for _ in 0..400 {
            let d = [signed(&mut random), signed(&mut random)];
            pressure = (pressure * (1.0 + 0.3 * signed(&mut random))).clamp(0.3, 3.0);
            spring.step(d, pressure, parts);
            let t = plane.step(d, pressure).traction;
            worst[index] = worst[index].max((t - Vector::from(spring.traction)).norm() / pressure);
        }
    }
    println!("200 parts {:.1e}, 2000 parts {:.1e}", worst[0], worst[1]);
    assert!(worst[1] < 1e-3 && worst[1] < 0.15 * worst[0]);
}

/// A contact under a force that is held while the pressure pulses: slip that holds the force, found by bisection.
fn slip_under_force(point: &Point<1>, force: f64, pressure: f64) -> f64 {
    let excess = |d: f64| point.trial([d], pressure).0.traction[0] - force;
    let (mut low, mut high) = (-2.0, 2.0);
    assert!(excess(low) < 0.0 && excess(high) > 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}

/// 11e: it settles in the first cycle and does not walk, ten thousand cycles.
#[test]
fn v11e_a_force_held_under_pulsing_pressure_does_not_walk() {
    for chi in [1.0, 1.5, 2.5] {
        let mut point = Point::<1>::new(&consistent(&unit(chi)));
        let first = slip_under_force(&point, 0.5, 1.0);
        point.step([first], 1.0);
        let cycle = |point: &mut Point<1>| {
            for p in [1.1, 0.9, 1.0] {
                let d = slip_under_force(point, 0.5, p);
                point.step([d], p);
            }
            point.slip[0]
        };
        let settled = cycle(&mut point);
        assert!(settled > first - 1e-12 && settled < first + 0.2);
        for _ in 1..200 {
            cycle(&mut point);
        }
        assert_abs_diff_eq!(point.slip[0], settled, epsilon = 1e-9);
        // Then by hand, at the slip that holds the force: nothing moves any more.
        let t = point.step([0.0], 1.0).traction[0];
        for _ in 0..10_000 {
            point.step([0.0], 1.1);
            point.step([0.0], 0.9);
        }
        assert_abs_diff_eq!(point.step([0.0], 1.0).traction[0], t, epsilon = 1e-9);
    }
}

/// The proportional rule: traction over T does not see the pressure, and energy that it creates is told.
#[test]
fn v11_proportional_rule() {
    for props in [unit(1.0), unit(2.5), segalman(-0.5, 0.3)] {
        let mut random = fastrand::Rng::with_seed(214);
        let mut point = Point::<1>::with_state_size(&props, state_size(1, 40));
        let backbone = if props.len() > 9 {
            Backbone::Segalman { c: -0.5, beta: 0.3 }
        } else {
            Backbone::Power { chi: props[2] }
        };
        let mut exact = Masing::new(backbone);
        let mut before = 0.0;
        for _ in 0..200 {
            let (s, p) = (1.5 * signed(&mut random), decades(&mut random, -1.0, 1.0));
            let response = point.move_to([s], p);
            exact.move_to(s);
            assert_abs_diff_eq!(
                response.traction[0],
                p * exact.traction(),
                epsilon = 1e-12 * p
            );
            assert_abs_diff_eq!(
                response.dtraction_dpressure[0],
                exact.traction(),
                epsilon = 1e-12
            );
            let held = point.step([0.0], 2.0 * p);
            assert_abs_diff_eq!(
                held.traction[0],
                2.0 * response.traction[0],
                epsilon = 1e-12 * p
            );
            assert_abs_diff_eq!(held.dissipated, -response.stored, epsilon = 1e-12 * p);
            before = held.stored;
        }
        assert!(before >= 0.0);
    }
}

/// Random histories of slip and limit in one direction, against elements of fixed depth.
#[test]
fn v11_elements_of_fixed_depth() {
    let seed = 215;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for chi in [1.5, 2.5, 4.0] {
        let mut point = Point::<1>::with_state_size(&consistent(&unit(chi)), state_size(1, 64));
        let mut twin = Twin::fixed_depths(chi, 1.0, 1.0, 4.0, 4000);
        let (mut pressure, mut worst, mut energy, mut lost) = (1.0, 0.0f64, 0.0f64, 0.0);
        for _ in 0..200 {
            let d = signed(&mut random) * decades(&mut random, -2.0, 0.2);
            pressure = match random.u32(0..8) {
                0 => 0.0,
                1..=4 => decades(&mut random, -1.0, 0.6),
                _ => {
                    if pressure == 0.0 {
                        1.0
                    } else {
                        pressure
                    }
                }
            };
            let response = point.step([d], pressure);
            twin.step([d, 0.0], pressure, 128);
            lost += response.dissipated;
            worst = worst
                .max((response.traction[0] - twin.traction()[0]).abs())
                .max((response.stored - twin.stored()).abs());
            energy = energy.max((lost - twin.dissipated()).abs() / lost.max(1.0));
        }
        println!(
            "chi {chi}: traction and stored energy {worst:.1e}, dissipated {energy:.1e} of {lost:.1}"
        );
        // The elements' dissipation is first order in their sub-steps.
        assert!(worst < 1e-5 && energy < 1e-3);
    }
}

/// The limit traction: cohesion, cap, the caller's factor and the run-in act through T and in no other way.
#[test]
fn all_that_changes_the_limit_acts_through_it() {
    let mut props = unit(2.5);
    props.resize(16, 0.0);
    let (c, cap, late, length) = (0.3, 3.0, 0.4, 2.5);
    props[4] = 1.0;
    props[11..15].copy_from_slice(&[c, cap, late, length]);
    let limit = Limit {
        mu: 1.0,
        cohesion: c,
        cap,
        run_in: Some((late, length)),
    };
    let mut random = fastrand::Rng::with_seed(216);
    let mut point = Point::<1>::new(&props);
    // The same limits by pressures alone: there T0 is that of the reference pressure.
    let mut plain = Point::<1>::new(&with(&unit(2.5), 5, 1.0 + c));
    let (mut path, mut worst) = (0.0, 0.0f64);
    for _ in 0..500 {
        let d = signed(&mut random) * decades(&mut random, -2.0, 0.2);
        let pressure = decades(&mut random, -1.0, 1.0);
        point.mu_factor = if random.bool() {
            1.0
        } else {
            2.0 * random.f64()
        };
        let t = limit.at(pressure, point.mu_factor, path);
        path += d.abs();
        let (a, b) = (point.step([d], pressure), plain.step([d], t.traction));
        assert_relative_eq!(point.state[2], t.traction, max_relative = 1e-14);
        assert_relative_eq!(point.state[5], path, max_relative = 1e-12);
        worst = worst
            .max((a.traction[0] - b.traction[0]).abs())
            .max((a.dissipated - b.dissipated).abs());
        assert_abs_diff_eq!(
            a.dtraction_dpressure[0],
            t.slope * b.dtraction_dpressure[0],
            epsilon = 1e-11
        );
        if t.traction == cap {
            assert_eq!(a.dtraction_dpressure[0], 0.0);
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-11);
}

/// The slip length that the run-in counts is that at the start of the increment; it goes on over openings.
#[test]
fn run_in_is_explicit() {
    let mut props = unit(2.5);
    props.resize(15, 0.0);
    props[13..15].copy_from_slice(&[0.5, 2.0]);
    let mut point = Point::<1>::new(&props);
    let first = point.step([10.0], 1.0);
    assert_eq!(first.traction[0], 1.0);
    let second = point.step([10.0], 1.0);
    assert_abs_diff_eq!(
        second.traction[0],
        0.5 + 0.5 * (-5.0f64).exp(),
        epsilon = 1e-15
    );
    point.step([3.0], 0.0);
    assert_eq!(point.state[5], 20.0);
    let closed = point.step([10.0], 1.0);
    assert_abs_diff_eq!(
        closed.traction[0],
        0.5 + 0.5 * (-10.0f64).exp(),
        epsilon = 1e-15
    );
}

/// No limit while closed: consistent, the memory is gone and T grows from nothing; proportional, it is kept.
#[test]
fn a_limit_of_zero() {
    for (props, kept) in [(consistent(&unit(2.5)), false), (unit(2.5), true)] {
        let mut point = Point::<1>::new(&props);
        let before = point.step([0.4], 1.0);
        point.mu_factor = 0.0;
        let none = point.step([0.1], 1.0);
        assert_eq!((none.traction[0], none.stored), (0.0, 0.0));
        assert_abs_diff_eq!(none.dissipated, before.stored, epsilon = 1e-15);
        assert_eq!(point.state[10] > 0.0, kept);
        if !kept {
            assert_eq!(none.contact as i32, 3);
        }
        point.mu_factor = 1.0;
        let again = point.step([0.1], 1.0);
        let expected = if kept {
            Backbone::Power { chi: 2.5 }.traction(0.6)
        } else {
            // Born on the way: all elements have followed a part of the slip, u = R d / G.
            0.1
        };
        assert_abs_diff_eq!(again.traction[0], expected, epsilon = 1e-14);
    }
    // From next to nothing, and back: no bits go wild.
    let mut point = Point::<2>::new(&consistent(&unit(2.5)));
    for p in [
        1.0, 1e-300, 1.0, 1e-31, 1e-20, 1e-9, 1.0, 1e-200, 1e-100, 1.0, 1e-29, 3.0,
    ] {
        let response = point.step([0.2, -0.1], p);
        assert!(response.traction.norm() <= p * (1.0 + 1e-12));
        assert!(
            response.dissipated >= -1e-15,
            "{p}: {:e}",
            response.dissipated
        );
    }
}

/// p_old = 0 is a fresh start, with the critical slip of the new pressure first; a tiny pressure is no opening.
#[test]
fn a_fresh_start_and_a_tiny_pressure() {
    let chi = 2.5;
    let f = Backbone::Power { chi };
    let (p, d): (f64, f64) = (4.0, 0.3);
    let g = p.powf(1.0 / chi);
    let mut fresh = Point::<1>::new(&consistent(&unit(chi)));
    assert_abs_diff_eq!(
        fresh.step([d], p).traction[0],
        p * f.traction(d / g),
        epsilon = 1e-12
    );
    let mut tiny = Point::<1>::new(&consistent(&unit(chi)));
    tiny.step([0.0], 1e-9);
    // Straight in slip and in G from nearly nothing: u = R d / G.
    assert_abs_diff_eq!(tiny.step([d], p).traction[0], p * d / g, epsilon = 1e-3);
}

/// Consistent rule: the stiffness that a contact was born with stays until it opens. A host that changes mu acts through T,
/// one that changes gcr not before the next closing.
#[test]
fn properties_that_change_in_time() {
    let law = |props: &[f64]| Law::<1>::new(props, state_size(1, 16)).expect("good properties");
    let step = |law: &Law<1>, gcr: f64, d: f64, state: &mut Vec<f64>| {
        let start = state.clone();
        law.friction(gcr, &Vector::from([d]), 1.0, 1.0, &start, state)
            .expect("a valid increment")
    };
    let (one, other) = (
        law(&consistent(&unit(2.5))),
        law(&consistent(&[0.8, 3.0, 2.5])),
    );
    let mut state = vec![0.0; state_size(1, 16)];
    let before = step(&one, 1.0, 0.3, &mut state);
    // G goes with T: .8^(1/2.5), whatever gcr is now.
    let after = step(&other, 3.0, 0.0, &mut state);
    let knots = state[10] as usize;
    assert_relative_eq!(
        state[12 + 2 * (knots - 1)],
        0.8f64.powf(0.4),
        max_relative = 1e-14
    );
    assert!(after.dissipated >= -1e-15 && after.traction[0] < before.traction[0]);
}

/// Proportional rule: when gcr changes R and u scale with it, and the difference of energy is told.
#[test]
fn gcr_that_changes_at_rest() {
    let law = Law::<1>::new(&unit(2.5), 44).expect("good properties");
    let step = |gcr: f64, d: f64, state: &mut Vec<f64>| {
        let start = state.clone();
        law.friction(gcr, &Vector::from([d]), 1.0, 1.0, &start, state)
            .expect("a valid increment")
    };
    let mut state = vec![0.0; 44];
    let before = step(1.0, 0.3, &mut state);
    let after = step(2.0, 0.0, &mut state);
    assert_abs_diff_eq!(after.traction[0], before.traction[0], epsilon = 1e-14);
    assert_abs_diff_eq!(after.stored, 2.0 * before.stored, epsilon = 1e-14);
    assert_abs_diff_eq!(after.dissipated, -before.stored, epsilon = 1e-14);
}

/// Segalman's curve is not self-similar: no consistent rule; with method 1 there is none of it left.
#[test]
fn segalman_has_no_consistent_rule() {
    let props = consistent(&segalman(-0.5, 0.1));
    let error = Law::<1>::new(&props, 44).expect_err("not self-similar");
    assert_eq!(error.kind, Kind::BadProperty);
    let text = error.to_string();
    assert!(
        text.contains("reference_pressure") && text.contains("self-similar"),
        "{text}"
    );
    assert!(Law::<1>::new(&with(&props, 4, 1.0), 44).is_ok());
}

/// Under the consistent rule no increment creates energy, and work = change of stored + dissipated on straight paths.
#[test]
fn v10_energy_balance_under_changing_limits() {
    let seed = 217;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut worst = 0.0f64;
    for chi in [1.0, 1.5, 2.5, 4.0] {
        let mut point = Point::<1>::with_state_size(&consistent(&unit(chi)), state_size(1, 40));
        point.step([0.0], 1.0);
        let (mut g, mut stored) = (1.0f64, 0.0);
        for _ in 0..30 {
            let (d, to) = (1.2 * signed(&mut random), 0.5 + random.f64());
            // Work by quadrature of the traction along the path, each value from the start of the increment.
            let force = |part: f64| {
                point
                    .trial([part * d], (g + part * (to - g)).powf(chi))
                    .0
                    .traction[0]
                    * d
            };
            let work = support::integral(&force, 0.0, 1.0, 1e-12);
            let response = point.step([d], to.powf(chi));
            worst = worst.max((work - (response.stored - stored) - response.dissipated).abs());
            assert!(
                response.dissipated >= -1e-15 * g.max(to).powf(chi + 1.0),
                "{:e}",
                response.dissipated
            );
            (g, stored) = (to, response.stored);
        }
    }
    println!("work - change of stored - dissipated: {worst:.1e}");
    assert!(worst < 1e-9);
}
