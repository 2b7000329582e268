//! The state array: what it holds, what is taken from it, what is refused, what a host may do with it.

mod support;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use mepc::{Kind, Law, Matrix, Vector, default_state_size, state};
use mepc_oracle::Backbone;
use mepc_oracle::masing::Masing;
use support::{
    HEADER, Point, consistent, decades, segalman, signed, state_size, turned, unit, with,
};

/// Both backbones, both rules.
fn laws() -> Vec<Vec<f64>> {
    vec![
        unit(1.0),
        unit(2.5),
        segalman(-0.6, 0.2),
        consistent(&unit(1.0)),
        consistent(&unit(1.5)),
        consistent(&unit(2.5)),
        with(&consistent(&unit(2.5)), 12, 0.2),
    ]
}

fn slip<const N: usize>(random: &mut fastrand::Rng) -> [f64; N] {
    let length = decades(random, -3.0, 0.5);
    std::array::from_fn(|_| length * signed(random))
}

fn steps<const N: usize>(seed: u64, count: usize) -> Vec<([f64; N], f64)> {
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut pressure = 1.0;
    (0..count)
        .map(|_| {
            pressure = match random.u32(0..12) {
                0 => 0.0,
                1..4 => decades(&mut random, -1.0, 1.0),
                _ => pressure,
            };
            (slip(&mut random), pressure)
        })
        .collect()
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

/// Header and knots of the layout; the defaults and the limits of its length.
#[test]
fn layout() {
    let names = |ndir: usize, nstate: usize| -> Vec<String> {
        let layout = state::Layout::new(ndir, nstate).expect("a layout");
        (0..nstate)
            .map(|slot| layout.slot_name(slot).expect("a name"))
            .collect()
    };
    let header = [
        "ContactStatus",
        "Pressure",
        "ShearLimit",
        "StoredEnergy",
        "DissipatedEnergy",
        "SlipLength",
        "NormalOpening",
        "TangentialJump1",
        "TangentialJump2",
        "Forgotten",
        "Knots",
        "Layout",
    ];
    assert_eq!(names(1, 21)[..12], header);
    assert_eq!(
        names(1, 21)[12..],
        [
            "Knot1_R", "Knot1_u1", "Knot2_R", "Knot2_u1", "Knot3_R", "Knot3_u1", "Knot4_R",
            "Knot4_u1", "Unused1"
        ]
    );
    assert_eq!(
        names(2, 24)[12..18],
        [
            "Knot1_R", "Knot1_u1", "Knot1_u2", "Knot2_R", "Knot2_u1", "Knot2_u2"
        ]
    );
    assert_eq!(default_state_size(&unit(2.5), 1).expect("a size"), 44);
    assert_eq!(default_state_size(&unit(2.5), 2).expect("a size"), 84);
    assert!(Law::<1>::new(&unit(2.5), 20).is_ok() && Law::<2>::new(&unit(2.5), 24).is_ok());
    for error in [
        Law::<1>::new(&unit(2.5), 19).err(),
        Law::<2>::new(&unit(2.5), 23).err(),
    ] {
        assert_eq!(error.expect("too short").kind, Kind::BadState);
    }
    // Beyond 64 knots nothing is used.
    let mut point = Point::<1>::with_state_size(&unit(2.5), 12 + 2 * 200);
    for k in 0..100 {
        point.move_to([(-0.98f64).powi(k)], 1.0);
    }
    assert_eq!(point.state[10], 64.0);
    assert!(point.state[12 + 2 * 64..].iter().all(|x| *x == 0.0));
}

/// What the slots hold along a history.
#[test]
fn what_a_state_holds() {
    fn check<const N: usize>(props: &[f64]) {
        let mut point = Point::<N>::new(props);
        let (mut dissipated, mut length) = (0.0, 0.0);
        for (slip, pressure) in steps::<N>(401, 300) {
            let response = point.step(slip, pressure);
            dissipated += response.dissipated;
            let s = &point.state;
            let cohesion = props.get(11).copied().unwrap_or(0.0);
            let limit = if pressure > 0.0 {
                cohesion + pressure
            } else {
                0.0
            };
            assert_eq!(
                s[..4],
                [
                    f64::from(response.contact as u8),
                    pressure,
                    limit,
                    response.stored
                ]
            );
            assert_relative_eq!(s[4], dissipated, max_relative = 1e-12);
            if pressure > 0.0 {
                length += Vector::from(slip).norm();
            }
            assert_relative_eq!(s[5], length, max_relative = 1e-12);
            assert_eq!((s[11], s[6..9].to_vec()), (2.0, vec![0.0; 3]));
            assert!(N == 2 || s[9] == 0.0);
            // Knots ascend, end at G, stay inside the cone; unused slots are zero.
            let count = s[10] as usize;
            assert_eq!(count > 0, pressure > 0.0);
            let knots: Vec<&[f64]> = s[HEADER..].chunks_exact(1 + N).take(count).collect();
            assert!(knots.windows(2).all(|pair| pair[0][0] < pair[1][0]));
            assert!(
                knots
                    .iter()
                    .all(|knot| knot[1..].iter().map(|u| u * u).sum::<f64>().sqrt()
                        <= knot[0] * (1.0 + 1e-12))
            );
            assert!(s[HEADER + count * (1 + N)..].iter().all(|x| *x == 0.0));
            if let Some(last) = knots.last() {
                let chi = if props.get(4) == Some(&1.0) {
                    props[2]
                } else {
                    f64::INFINITY
                };
                let critical = (limit / (1.0 + cohesion)).powf(1.0 / chi);
                assert_relative_eq!(last[0], critical, max_relative = 1e-12);
            }
        }
    }
    for props in laws() {
        check::<1>(&props);
        check::<2>(&props);
    }
}

/// A zero increment copies the state bit for bit, also a full one.
#[test]
fn a_zero_increment_changes_no_bit() {
    fn check<const N: usize>(props: &[f64], nstate: usize) {
        let mut point = Point::<N>::with_state_size(props, nstate);
        let mut full = 0;
        for (slip, pressure) in steps::<N>(104, 300) {
            let before = point.step(slip, pressure);
            full += u32::from(point.state[10] as usize == (nstate - HEADER) / (1 + N));
            let (response, end) = point.trial([0.0; N], pressure);
            assert_eq!(bits(&end), bits(&point.state));
            assert_eq!(response.dissipated, 0.0);
            assert_eq!(
                (response.contact, response.stored),
                (before.contact, before.stored)
            );
            assert!(!response.memory_full);
            // The state is what counts; the traction is summed from it anew. What a full memory gave up is in it.
            let allowed = if N == 2 || point.state[10] as usize == (nstate - HEADER) / (1 + N) {
                0.5
            } else {
                1e-14
            };
            assert!((response.traction - before.traction).norm() <= allowed * pressure.max(1.0));
        }
        assert!(full > 0 || nstate > state_size(N, 4) || props[2] == 1.0);
    }
    for props in laws() {
        for knots in [4, 24] {
            check::<1>(&props, state_size(1, knots));
            check::<2>(&props, state_size(2, knots));
        }
    }
}

/// What a host does: trials that are rejected, repeats, a restart from a text file; state0 that is state1.
#[test]
fn repeated_rejected_and_restored_steps_are_bit_identical() {
    fn check<const N: usize>(props: &[f64], nstate: usize) {
        let mut straight = Point::<N>::with_state_size(props, nstate);
        let mut tried = straight.clone();
        let mut random = fastrand::Rng::with_seed(205);
        for (slip_increment, pressure) in steps::<N>(105, 150) {
            let expected = straight.step(slip_increment, pressure);
            for _ in 0..3 {
                tried.trial(slip(&mut random), decades(&mut random, -1.0, 1.0));
                let (repeated, end) = tried.trial(slip_increment, pressure);
                assert_eq!(repeated, expected);
                assert_eq!(bits(&end), bits(&straight.state));
            }
            // Stop and restart from text with 17 digits, with a law made anew.
            let text: Vec<String> = tried.state.iter().map(|x| format!("{x:.16e}")).collect();
            tried.state = text
                .iter()
                .map(|word| word.parse().expect("a number"))
                .collect();
            tried.law = Law::new(props, nstate).expect("good properties");
            assert_eq!(tried.step(slip_increment, pressure), expected);
            assert_eq!(bits(&tried.state), bits(&straight.state));
        }
    }
    for props in laws() {
        check::<1>(&props, 44);
        check::<2>(&props, 84);
        check::<2>(&props, state_size(2, 4));
    }
}

/// States stored in single precision, or with seven digits, are taken at every step and lead to nearly the same.
#[test]
fn few_digits_are_taken() {
    fn check<const N: usize>(props: &[f64], few: impl Fn(f64) -> f64, worst: &mut f64) {
        let (mut exact, mut stored) = (Point::<N>::new(props), Point::<N>::new(props));
        let mut random = fastrand::Rng::with_seed(402);
        let mut pressure: f64 = 1.0;
        for k in 0..400 {
            let d: [f64; N] = if k % 3 == 0 {
                [0.0; N]
            } else {
                std::array::from_fn(|_| 0.4 * signed(&mut random))
            };
            pressure = (pressure * (1.0 + 0.1 * signed(&mut random))).clamp(0.5, 2.0);
            let (a, b) = (exact.step(d, pressure), stored.step(d, pressure));
            stored.state.iter_mut().for_each(|x| *x = few(*x));
            *worst = worst.max((a.traction - b.traction).norm());
        }
    }
    let mut worst = [0.0f64; 2];
    let seven = |x: f64| -> f64 { format!("{x:.6e}").parse().expect("a number") };
    for props in laws() {
        for (worst, few) in worst.iter_mut().zip([
            &(|x: f64| f64::from(x as f32)) as &dyn Fn(f64) -> f64,
            &seven,
        ]) {
            check::<1>(&props, few, worst);
            check::<2>(&props, few, worst);
        }
    }
    println!(
        "single precision {:.1e}, seven digits {:.1e}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 3e-3 && worst[1] < 3e-3);
}

/// A state with remembered reversals, for damaging.
fn used_state<const N: usize>(props: &[f64]) -> Point<N> {
    let mut point = Point::<N>::new(props);
    for s in [0.8, -0.5, 0.3, -0.1] {
        let mut target = [0.4 * s; N];
        target[0] = s;
        point.move_to(target, 1.0);
    }
    assert!(point.state[10] >= 4.0, "a history with knots");
    point
}

/// The refusal of a state: kind, the slot with its name and value, and nothing written.
fn refusal<const N: usize>(point: &Point<N>, state: &[f64], what: &str) -> String {
    let mut end = vec![-77.0; state.len()];
    let error = point
        .law
        .friction(
            point.gcr,
            &Vector::from([0.1; N]),
            1.0,
            1.0,
            state,
            &mut end,
        )
        .expect_err(what);
    assert_eq!(error.kind, Kind::BadState, "{what}: {error}");
    assert!(
        end.iter().all(|x| *x == -77.0),
        "{what}: state1 was written"
    );
    error.to_string()
}

#[test]
fn corrupt_states_are_refused_and_nothing_is_written() {
    fn check<const N: usize>(props: &[f64]) {
        let point = used_state::<N>(props);
        let knot = 1 + N;
        let refused = |what: &str, slot: usize, value: f64| {
            let mut state = point.state.clone();
            state[slot] = value;
            let text = refusal(&point, &state, what);
            let name = point.law.layout().slot_name(slot).expect("a slot");
            assert!(text.contains(&name), "{what}: {text}");
        };
        let used = HEADER + point.state[10] as usize * knot;
        for slot in 0..used {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                refused("not finite", slot, value);
            }
        }
        for status in [-1.0, 4.0, 0.5] {
            refused("unknown contact status", 0, status);
        }
        for (slot, what) in [
            (1, "pressure"),
            (2, "limit"),
            (3, "stored energy"),
            (5, "slip length"),
            (9, "forgotten"),
        ] {
            refused(what, slot, -1e-3);
        }
        // Found by fuzzing.
        refused("stored energy", 3, -100.0);
        for value in [-1.0, 0.5, 25.0, 1e300] {
            refused("knot count", 10, value);
        }
        let (first, second) = (point.state[HEADER], point.state[HEADER + knot]);
        refused("knot at zero", HEADER, 0.0);
        refused("negative knot", HEADER, -first);
        refused("unordered knots", HEADER + knot, 0.5 * first);
        assert!(second > first);
        refused("outside the cone", HEADER + 1, 1.1 * first);
        refused("outside the cone", HEADER + 1, -1.1 * first);
    }
    for props in [unit(2.5), segalman(-0.5, 0.1), consistent(&unit(1.5))] {
        check::<1>(&props);
        check::<2>(&props);
    }
    // One direction: the curve rises no faster than the cone.
    let mut point = used_state::<1>(&unit(2.5));
    point.state[HEADER + 3] =
        point.state[HEADER + 1] + 1.01 * (point.state[HEADER + 2] - point.state[HEADER]);
    assert!(point.state[HEADER + 3].abs() < point.state[HEADER + 2]);
    assert!(refusal(&point, &point.state, "too steep").contains("Knot2_u1"));
}

/// A host that averages states, or brings another program's, is told so; the Layout number is what gives it away.
#[test]
fn averaged_and_foreign_states_are_refused_with_words() {
    let point = used_state::<2>(&unit(2.5));
    let mut averaged: Vec<f64> = point.state.iter().map(|x| 0.5 * x).collect();
    let text = refusal(&point, &averaged, "half a virgin state");
    assert!(
        text.contains("Layout") && text.contains("averaged"),
        "{text}"
    );
    // Two used states with other numbers of knots.
    let mut other = Point::<2>::new(&unit(2.5));
    other.move_to([0.3, 0.0], 1.0);
    for (mean, other) in averaged.iter_mut().zip(&other.state) {
        *mean += 0.5 * other;
    }
    refusal(&point, &averaged, "a mean of two");
    for layout in [1.0, 3.0, 2.5] {
        let mut state = point.state.clone();
        state[11] = layout;
        assert!(refusal(&point, &state, "another layout").contains("Layout"));
    }
    // A state of the first edition, or of anything else, has no such number.
    let mut foreign = vec![0.0; 84];
    foreign[0] = 1.0;
    refusal(&point, &foreign, "foreign");
    // All zeros is the virgin state.
    let mut end = vec![0.0; 84];
    assert!(
        point
            .law
            .friction(
                1.0,
                &Vector::from([0.1, 0.0]),
                1.0,
                1.0,
                &[0.0; 84],
                &mut end
            )
            .is_ok()
    );
    assert_eq!(end[11], 2.0);
}

/// Vectors turn with the axes; slip limits, counts and unused slots are none.
#[test]
fn rotation_turns_every_vector_of_a_state_and_nothing_else() {
    let mut point = used_state::<2>(&unit(2.5));
    point.state[7..9].copy_from_slice(&[0.3, -0.7]);
    let before = point.state.clone();
    let angle = 2.1;
    let (sin, cos) = f64::sin_cos(angle);
    state::rotate(
        point.law.layout(),
        &[[cos, -sin], [sin, cos]],
        &mut point.state,
    );
    for slot in 0..before.len() {
        let name = point.law.layout().slot_name(slot).expect("a slot");
        if name == "TangentialJump1" || name.ends_with("_u1") {
            let expected = turned([before[slot], before[slot + 1]], angle);
            assert_abs_diff_eq!(point.state[slot], expected[0], epsilon = 1e-15);
            assert_abs_diff_eq!(point.state[slot + 1], expected[1], epsilon = 1e-15);
        } else if name != "TangentialJump2" && !name.ends_with("_u2") {
            assert_eq!(point.state[slot], before[slot], "{name}");
        }
    }
}

#[test]
fn a_rotated_memory_goes_on_as_if_everything_had_been_rotated() {
    let angle = 0.7;
    let (sin, cos) = f64::sin_cos(angle);
    let q = Matrix::from_columns(
        &[turned([1.0, 0.0], angle), turned([0.0, 1.0], angle)].map(Vector::from),
    );
    for props in laws() {
        let mut plain = Point::<2>::new(&props);
        let mut turning = Point::<2>::new(&props);
        for (k, (slip, pressure)) in steps::<2>(102, 60).into_iter().enumerate() {
            let a = plain.step(slip, pressure);
            if k == 30 {
                state::rotate(
                    turning.law.layout(),
                    &[[cos, -sin], [sin, cos]],
                    &mut turning.state,
                );
            }
            let b = turning.step(if k < 30 { slip } else { turned(slip, angle) }, pressure);
            let expected = if k < 30 { a.traction } else { q * a.traction };
            // Halving is decided at thresholds: seldom rounding decides otherwise.
            assert_abs_diff_eq!(expected, b.traction, epsilon = 1e-3 * pressure.max(1.0));
        }
    }
}

/// Opening forgets all but the counters; the next closing is that of a virgin point.
#[test]
fn opening_and_closing() {
    fn check<const N: usize>(props: &[f64]) {
        let mut point = Point::<N>::new(props);
        let mut random = fastrand::Rng::with_seed(108);
        for _ in 0..100 {
            for _ in 0..random.u32(1..6) {
                point.step(slip(&mut random), decades(&mut random, -1.0, 1.0));
            }
            let (stored, dissipated, length) = (point.state[3], point.state[4], point.state[5]);
            let opened = point.step(slip(&mut random), -random.f64());
            assert_eq!(opened.traction.norm() + opened.dtraction_dslip.norm(), 0.0);
            assert_eq!((opened.stored, opened.dissipated), (0.0, stored));
            point.step(slip(&mut random), 0.0);
            assert_eq!(point.state[..4], [0.0; 4]);
            assert_eq!(point.state[4..6], [dissipated + stored, length]);
            assert!(
                point.state[9..11]
                    .iter()
                    .chain(&point.state[12..])
                    .all(|x| *x == 0.0)
            );
            let (increment, pressure) = (slip(&mut random), decades(&mut random, -1.0, 1.0));
            let closed = point.step(increment, pressure);
            assert_eq!(closed, Point::<N>::new(props).step(increment, pressure));
        }
    }
    for props in laws() {
        check::<1>(&props);
        check::<2>(&props);
    }
}

#[test]
fn memory_full_is_reported_when_a_reversal_is_dropped() {
    let spiral = |knots: usize, turns: i32| -> Vec<bool> {
        let mut point = Point::<1>::with_state_size(&unit(2.5), state_size(1, knots));
        (0..turns)
            .map(|k| point.move_to([0.95 * (-0.8f64).powi(k)], 1.0).memory_full)
            .collect()
    };
    // Ever smaller reversals: one knot each, and the end of the curve.
    for knots in [4, 9] {
        let first = spiral(knots, 14).iter().position(|full| *full);
        assert_eq!(first, Some(knots - 1));
    }
    assert!(!spiral(9, 4).contains(&true));
}

/// What is dropped from a full memory is the smallest loop: the large ones keep their place.
#[test]
fn the_least_important_reversal_is_dropped() {
    // Loops of half the size each: many more than there are slots.
    let reversals: Vec<f64> = (0..20).map(|k| 0.95 * (-0.5f64).powi(k)).collect();
    for (knots, tolerance) in [(5, 0.05), (9, 1e-3)] {
        let mut point = Point::<1>::with_state_size(&unit(2.5), state_size(1, knots));
        let mut exact = Masing::new(Backbone::Power { chi: 2.5 });
        let (mut worst, mut full) = (0.0f64, 0);
        // In, and out again along the large loops.
        for s in reversals.iter().chain(&[-0.3, 0.6, 0.94]) {
            let response = point.move_to([*s], 1.0);
            exact.move_to(*s);
            full += i32::from(response.memory_full);
            worst = worst.max((response.traction[0] - exact.traction()).abs());
        }
        println!("{knots} knots: {full} dropped, traction off by {worst:.1e}");
        assert!(full > 5);
        assert!(worst < tolerance);
    }
}

/// Masing's rules: besides the end of the curve and the front a branch remembers the reversals of the loops that are open. With
/// chi = 1 there is one slip element, and a reversal tells nothing that the traction does not.
#[test]
fn closed_loops_are_forgotten() {
    fn check<const N: usize>(direction: [f64; N]) {
        let mut point = Point::<N>::new(&unit(2.5));
        for (s, knots) in [
            (0.8, 2.0),
            (-0.2, 3.0),
            (0.3, 4.0),
            (-0.2, 3.0),
            (0.1, 4.0),
            (-0.8, 2.0),
            (0.8, 2.0),
            (-0.3, 3.0),
            (-3.0, 1.0),
        ] {
            point.move_to(direction.map(|x| s * x), 1.0);
            assert_eq!(point.state[10], knots, "at {s}");
        }
        let mut line = Point::<N>::new(&unit(1.0));
        let mut random = fastrand::Rng::with_seed(116);
        for _ in 0..300 {
            let s = signed(&mut random);
            assert!(!line.move_to(direction.map(|x| s * x), 1.0).memory_full);
        }
    }
    check([1.0]);
    check([0.6, -0.8]);
}

/// Zero means default, everywhere; missing trailing entries, too.
#[test]
fn zero_means_default() {
    let spelled = {
        let mut all = vec![0.3, 0.002, 2.5, 0.0, 0.0, 0.005];
        all.resize(20, 0.0);
        all[8] = 1.0;
        all[15] = 1e-3;
        all
    };
    let mut zeros = vec![0.0; 20];
    zeros[..2].copy_from_slice(&[0.3, 0.002]);
    for props in [&[0.3, 0.002][..], &[0.3, 0.002, 0.0], &zeros] {
        let (mut a, mut b) = (Point::<2>::new(&spelled), Point::<2>::new(props));
        for (slip, pressure) in steps::<2>(403, 50) {
            let d = slip.map(|x| 0.002 * x);
            assert_eq!(a.step(d, pressure), b.step(d, pressure));
        }
    }
    // gcr = 0: fraction of the characteristic length, .005 where none is given.
    for (props, gcr) in [
        (vec![0.3], 0.005),
        (vec![0.3, 0.0, 0.0, 0.0, 0.0, 0.004], 0.004),
    ] {
        let law = Law::<1>::new(&props, 44).expect("good properties");
        assert_relative_eq!(law.critical_slip(1.0).expect("a length"), gcr);
        assert_eq!(
            law.critical_slip(0.0).expect_err("no length").kind,
            Kind::BadProperty
        );
    }
    // mu = 0 is frictionless, but for cohesion.
    assert_eq!(
        Point::<1>::new(&[0.0, 1.0]).step([3.0], 5.0).traction[0],
        0.0
    );
    let mut sticky = vec![0.0; 12];
    (sticky[1], sticky[11]) = (1.0, 0.7);
    assert_abs_diff_eq!(
        Point::<1>::new(&sticky).step([3.0], 5.0).traction[0],
        0.7,
        epsilon = 1e-15
    );
}

/// Refused properties name entry, value and range.
#[test]
fn bad_properties_are_refused_with_words() {
    let base = {
        let mut props = unit(2.5);
        props.resize(20, 0.0);
        props
    };
    let refused = |changes: &[(usize, f64)], named: &str| {
        let mut props = base.clone();
        changes
            .iter()
            .for_each(|&(number, value)| props[number - 1] = value);
        let error = Law::<2>::new(&props, 84).expect_err(named);
        assert_eq!(error.kind, Kind::BadProperty, "{changes:?}");
        assert!(error.to_string().contains(named), "{changes:?}: {error}");
    };
    for (number, name) in [
        (1, "mu"),
        (2, "gcr"),
        (5, "reference_pressure"),
        (6, "fraction"),
        (7, "kn"),
        (12, "cohesion"),
        (13, "tau_max"),
    ] {
        refused(&[(number, -1.0)], name);
        refused(&[(number, f64::NAN)], name);
        refused(&[(number, f64::INFINITY)], name);
    }
    refused(&[(3, 0.9)], "exponent");
    refused(&[(4, 3.0)], "method");
    refused(&[(4, 0.5)], "method");
    refused(&[(9, 0.5)], "normal_exponent");
    refused(&[(10, 2.0)], "backbone");
    refused(&[(10, 1.0), (3, 1.0)], "exponent");
    refused(&[(10, 1.0), (3, 2.1)], "exponent");
    refused(&[(10, 1.0), (3, 0.0)], "exponent");
    refused(&[(11, 0.5)], "beta");
    refused(&[(14, 0.3)], "slip_late");
    refused(&[(15, 0.3)], "mu_late");
    refused(&[(16, 0.2)], "resolution");
    refused(&[(16, 1e-7)], "resolution");
    for number in 17..=20 {
        refused(&[(number, 1.0)], &format!("reserved{number}"));
    }
    // T0 = 0 under the consistent rule with a mu that comes later.
    refused(&[(1, 0.0), (5, 1.0), (14, 0.3), (15, 1.0)], "mu_late");
}
