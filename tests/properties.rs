//! Properties that hold on any history: random ones, seeds printed.

mod support;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use mepc::{Kind, Law, Matrix, Rigid, Vector, state};
use mepc_oracle::Backbone;
use mepc_oracle::masing::Masing;
use support::{Point, decades, least_state, power, segalman, signed, turned, unit, with};

/// Both backbones with both pressure rules.
fn laws() -> Vec<Vec<f64>> {
    let backbones = [
        unit(1.0),
        unit(1.7),
        unit(2.5),
        segalman(-0.6, 0.2),
        segalman(0.0, 0.0),
    ];
    let rules = |props: Vec<f64>| [with(&props, 5, 0.0), with(&props, 5, 1.0)];
    backbones.into_iter().flat_map(rules).collect()
}

/// A slip increment of random direction; its length is any of four decades.
fn slip<const N: usize>(random: &mut fastrand::Rng) -> [f64; N] {
    let length = decades(random, -3.0, 0.5);
    std::array::from_fn(|_| length * signed(random))
}

/// The pressure of the next step: mostly the same, else any of two decades, sometimes zero.
fn next_pressure(random: &mut fastrand::Rng, pressure: f64) -> f64 {
    match random.u32(0..12) {
        0 => 0.0,
        1..4 => decades(random, -1.0, 1.0),
        _ => pressure,
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

fn steps<const N: usize>(seed: u64, count: usize) -> Vec<([f64; N], f64)> {
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut pressure = 1.0;
    (0..count)
        .map(|_| {
            pressure = next_pressure(&mut random, pressure);
            (slip(&mut random), pressure)
        })
        .collect()
}

#[test]
fn rotated_paths_give_rotated_tractions() {
    for props in laws() {
        for angle in [0.4, 1.9, -2.6] {
            let mut plain = Point::<2>::new(&props);
            let mut rotated = Point::<2>::new(&props);
            let q = rotation(angle);
            for (slip, pressure) in steps::<2>(101, 300) {
                let a = plain.step(slip, pressure);
                let b = rotated.step(turned(slip, angle), pressure);
                let limit = pressure.max(1.0);
                assert_abs_diff_eq!(q * a.traction, b.traction, epsilon = 1e-10 * limit);
                assert_abs_diff_eq!(
                    q * a.dtraction_dpressure,
                    b.dtraction_dpressure,
                    epsilon = 1e-9
                );
                assert_abs_diff_eq!(a.stored, b.stored, epsilon = 1e-10 * limit);
                assert_abs_diff_eq!(a.dissipated, b.dissipated, epsilon = 1e-10 * limit);
            }
        }
    }
}

fn rotation(angle: f64) -> Matrix<2> {
    Matrix::from_columns(&[turned([1.0, 0.0], angle), turned([0.0, 1.0], angle)].map(Vector::from))
}

#[test]
fn a_rotated_memory_goes_on_as_if_everything_had_been_rotated() {
    let angle = 0.7;
    let (sin, cos) = f64::sin_cos(angle);
    for props in laws() {
        let mut plain = Point::<2>::new(&props);
        let mut turning = Point::<2>::new(&props);
        for (k, (slip, pressure)) in steps::<2>(102, 200).into_iter().enumerate() {
            let a = plain.step(slip, pressure);
            // From the middle on the tangential directions have turned: the same slip has other components.
            if k == 100 {
                state::rotate(
                    turning.law.layout(),
                    &[[cos, -sin], [sin, cos]],
                    &mut turning.state,
                );
            }
            let total = if k < 100 { 0.0 } else { angle };
            let b = turning.step(turned(slip, total), pressure);
            let expected = rotation(total) * a.traction;
            assert_abs_diff_eq!(expected, b.traction, epsilon = 1e-10 * pressure.max(1.0));
        }
    }
}

/// The remembered jump of the interface form is a vector, too; slip limits, counts and unused slots are none.
#[test]
fn rotation_turns_every_vector_of_a_state_and_nothing_else() {
    let mut point = used_state::<2>(&unit(2.5));
    point.state[5..7].copy_from_slice(&[0.3, -0.7]);
    let before = point.state.clone();
    let angle = 2.1;
    let (sin, cos) = f64::sin_cos(angle);
    let q = [[cos, -sin], [sin, cos]];
    state::rotate(point.law.layout(), &q, &mut point.state);
    let names: Vec<String> = (0..before.len())
        .map(|slot| point.law.layout().slot_name(slot).expect("a slot"))
        .collect();
    for (slot, name) in names.iter().enumerate() {
        let is_first = name == "TangentialJump1" || name.ends_with("_1") || name.ends_with("_e1");
        let is_second = name == "TangentialJump2" || name.ends_with("_2") || name.ends_with("_e2");
        if is_first {
            let expected = turned([before[slot], before[slot + 1]], angle);
            assert_abs_diff_eq!(point.state[slot], expected[0], epsilon = 1e-15);
            assert_abs_diff_eq!(point.state[slot + 1], expected[1], epsilon = 1e-15);
        } else if !is_second {
            assert_eq!(point.state[slot], before[slot], "{name}");
        }
    }
}

/// Branches are straight and at constant pressure; between them direction along the line and pressure change.
#[test]
fn one_step_or_many_on_straight_branches() {
    let seed = 103;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut worst = 0.0f64;
    for props in laws() {
        for roomy in [true, false] {
            let nstate = if roomy {
                8 + 32 + 3 * 40
            } else {
                least_state(2, 16)
            };
            let mut coarse = Point::<2>::with_state_size(&props, nstate);
            let mut fine = coarse.clone();
            let mut pressure = 1.0;
            for _ in 0..60 {
                let previous = pressure;
                pressure = next_pressure(&mut random, pressure);
                let length = 1.5 * signed(&mut random);
                let increment = [0.28 * length, -0.96 * length];
                let target = [coarse.slip[0] + increment[0], coarse.slip[1] + increment[1]];
                // The change of pressure is a step of its own: what it does depends on the slip before it.
                if pressure != previous {
                    coarse.step([0.0; 2], pressure);
                    fine.step([0.0; 2], pressure);
                }
                let one = coarse.move_to(target, pressure);
                let count = random.u32(2..60);
                let (many, dissipated) = fine.move_in_steps(target, pressure, count);
                let scale = pressure.max(1.0);
                worst = worst
                    .max((one.traction - many.traction).norm() / scale)
                    .max((one.dissipated - dissipated).abs() / scale)
                    .max((one.stored - many.stored).abs() / scale);
            }
        }
    }
    println!("worst difference {worst:.1e}");
    assert!(worst < 1e-9);
}

#[test]
fn a_zero_increment_changes_no_bit() {
    fn check<const N: usize>(props: &[f64], nstate: usize) {
        let mut point = Point::<N>::with_state_size(props, nstate);
        for (slip, pressure) in steps::<N>(104, 400) {
            let before = point.step(slip, pressure);
            let (response, end) = point.trial([0.0; N], pressure);
            assert_eq!(bits(&end), bits(&point.state));
            assert_eq!(response.dissipated, 0.0);
            assert_eq!(response.contact, before.contact);
            assert!(!response.memory_full);
            // The state is what counts; the traction is summed from it and may differ in its last bit.
            assert_abs_diff_eq!(
                response.traction,
                before.traction,
                epsilon = 1e-14 * pressure.max(1.0)
            );
        }
    }
    for props in laws() {
        for full in [false, true] {
            check::<1>(&props, if full { least_state(1, 1) } else { 25 });
            check::<2>(&props, if full { least_state(2, 16) } else { 64 });
        }
    }
}

/// What a host does: trials that are rejected, repeats, a restart from a text file.
#[test]
fn repeated_rejected_and_restored_steps_are_bit_identical() {
    fn check<const N: usize>(props: &[f64], nstate: usize) {
        let mut straight = Point::<N>::with_state_size(props, nstate);
        let mut tried = straight.clone();
        let mut random = fastrand::Rng::with_seed(205);
        for (slip_increment, pressure) in steps::<N>(105, 300) {
            let expected = straight.step(slip_increment, pressure);
            // Rejected trials with other increments and pressures, in between the same step twice.
            for _ in 0..3 {
                let rejected = next_pressure(&mut random, 2.0 * pressure);
                tried.trial(slip(&mut random), rejected);
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
        check::<1>(&props, 25);
        check::<2>(&props, 64);
        check::<2>(&props, least_state(2, 16));
    }
}

/// The state counts the slip path while the contact is closed; what is slipped while it is open does not count.
#[test]
fn the_slip_length_is_that_of_the_path_while_closed() {
    fn check<const N: usize>() {
        let mut point = Point::<N>::new(&unit(2.5));
        let mut length = 0.0;
        for (slip, pressure) in steps::<N>(114, 300) {
            point.step(slip, pressure);
            if pressure > 0.0 {
                length += Vector::from(slip).norm();
            }
            assert_relative_eq!(point.state[4], length, max_relative = 1e-12);
        }
        assert!(length > 0.0);
    }
    check::<1>();
    check::<2>();
}

/// Rigid stick by multipliers that takes over a state of the memory law: the energy held there is lost, and told.
#[test]
fn rigid_stick_loses_the_energy_that_a_memory_held() {
    let mut point = Point::<2>::new(&unit(2.5));
    let held = point.step([0.5, 0.0], 1.0).stored;
    assert!(held > 0.1);
    let law = Law::<2>::new(&with(&unit(2.5), 4, 2.0), point.state.len()).expect("a law");
    let take_over = |sticks: bool, multiplier: [f64; 2], slip: [f64; 2]| {
        let mut end = vec![0.0; point.state.len()];
        let (multiplier, slip) = (Vector::from(multiplier), Vector::from(slip));
        let outcome = law.lagrange(sticks, &multiplier, &slip, 1.0, &point.state, &mut end);
        (outcome.expect("valid input"), end)
    };
    let (outcome, end) = take_over(true, [0.5, 0.0], [0.0; 2]);
    assert_eq!(outcome, Rigid::Stick { dissipated: held });
    assert_eq!((end[2], end[3]), (0.0, point.state[3] + held));
    let (outcome, end) = take_over(false, [0.0; 2], [0.25, 0.0]);
    let Rigid::Slip(response) = outcome else {
        panic!("{outcome:?}")
    };
    assert_eq!(response.dissipated, 0.25 + held);
    assert_eq!((end[2], end[4]), (0.0, point.state[4] + 0.25));
    // Numbers that no result follows from are refused, and huge ones keep their direction.
    let mut end = vec![0.0; point.state.len()];
    let mut refused = |slip: [f64; 2], pressure: f64| {
        let outcome = law.lagrange(
            false,
            &Vector::zeros(),
            &slip.into(),
            pressure,
            &point.state,
            &mut end,
        );
        outcome.is_err() && end.iter().all(|x| *x == 0.0)
    };
    assert!(refused([1e-3, 0.0], f64::MAX));
    assert!(refused([1e-150, 0.0], 1e200));
    assert!(refused([1e300, 0.0], 1.0));
    // Open: what slips there does not count; held: an increment is noise.
    let mut end = vec![0.0; point.state.len()];
    let slip = Vector::from([0.25, 0.0]);
    let open = law.lagrange(false, &Vector::zeros(), &slip, 0.0, &point.state, &mut end);
    assert!(matches!(open, Ok(Rigid::Slip(_))));
    assert_eq!((end[0], end[4]), (0.0, point.state[4]));
    let (outcome, end) = take_over(true, [2.0, 0.0], [-0.25, 0.0]);
    let Rigid::Slip(response) = outcome else {
        panic!("{outcome:?}")
    };
    assert_eq!((response.dissipated, end[4]), (held, point.state[4]));
    let short = law.lagrange(
        false,
        &Vector::zeros(),
        &slip,
        1.0,
        &point.state,
        &mut [0.0; 10],
    );
    assert_eq!(short.map_err(|error| error.kind), Err(Kind::BadState));
    let (outcome, _) = take_over(true, [3e300, 4e300], [0.0; 2]);
    let Rigid::Slip(response) = outcome else {
        panic!("{outcome:?}")
    };
    assert_abs_diff_eq!(response.traction, Vector::from([0.6, 0.8]), epsilon = 1e-15);
}

/// A slip element that just touches its limit, with sticking ones on both sides, is not forgotten: undoing a step
/// exactly gives what undoing it almost exactly gives.
#[test]
fn an_element_that_touches_its_limit_stays() {
    let paths = [
        (2.5, 3.0, [[0.125, -0.375], [-0.25, 0.0], [0.25, 0.0]]),
        (2.5, 16.0, [[-0.25, -0.125], [0.375, -0.125], [-0.25, 0.0]]),
        // It is one of the base grid, which is k / 8.
        (2.0, 8.0, [[1.0, 0.75], [-0.5, -1.0], [0.5, 0.25]]),
    ];
    for (chi, base_knots, path) in paths {
        let last = |shift: [f64; 2]| {
            let mut point = Point::<2>::new(&with(&unit(chi), 9, base_knots));
            let mut response = None;
            for (k, slip) in path.into_iter().enumerate() {
                let slip = if k == 2 {
                    [0, 1].map(|i| slip[i] + shift[i])
                } else {
                    slip
                };
                response = Some(point.step(slip, 1.0));
            }
            response.expect("three steps")
        };
        let exact = last([0.0; 2]);
        for shift in [[1e-10, 0.0], [-1e-10, 0.0], [0.0, 1e-10], [0.0, -1e-10]] {
            let near = last(shift);
            assert_abs_diff_eq!(exact.traction, near.traction, epsilon = 1e-9);
            assert_abs_diff_eq!(exact.stored, near.stored, epsilon = 1e-9);
            assert_abs_diff_eq!(exact.dtraction_dslip, near.dtraction_dslip, epsilon = 1e-6);
        }
    }
}

/// Gross slip, then a step across it: all slip elements move along their limits, outwards or inwards by no more than rounding. They
/// turn as a whole: what sticks by rounding must not make a front, whose place would be noise and whose speed anything.
#[test]
fn elements_that_move_along_their_limits_turn_together() {
    let seed = 117;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for (chi, base) in [(2.0, 3), (2.5, 16), (1.5, 16), (2.5, 64)] {
        let props = with(&unit(chi), 9, f64::from(base));
        // The weights of the base knots add up to the secant of f over the first segment.
        let first = 1.0 - (1.0 - 1.0 / f64::from(base)).powf(2.0 / chi);
        let stiffness = (1.0 - (1.0 - first).powf(chi)) / first;
        for _ in 0..2000 {
            let mut point = Point::<2>::new(&props);
            let n = turned([1.0, 0.0], 7.0 * random.f64());
            point.step(n.map(|x| 2.0 * x), 1.0);
            // On the circle of the last element, or straight on, which is outwards.
            let across = decades(&mut random, -16.0, -6.0);
            let back = [0.0, 0.5 * across * across][random.usize(0..2)];
            let step = [-across * n[1] - back * n[0], across * n[0] - back * n[1]];
            let tangent = point.step(step, 1.0).dtraction_dslip;
            let n = Vector::from(n);
            let expected = (Matrix::identity() - n * n.transpose()) * stiffness;
            assert_abs_diff_eq!(tangent, expected, epsilon = 1e-4 * chi);
        }
    }
}

/// What would make the state infinite, or turn the traction round, is refused.
#[test]
fn energies_beyond_numbers_and_critical_slips_that_are_none_are_refused() {
    let mut point = Point::<1>::new(&unit(2.5));
    point.step([0.5], 1.0);
    let mut huge = point.state.clone();
    (huge[2], huge[3]) = (1.7e308, 1.7e308);
    let mut end = vec![0.0; huge.len()];
    let opened = point
        .law
        .friction(1.0, &Vector::zeros(), 0.0, &huge, &mut end);
    assert_eq!(opened.map_err(|error| error.kind), Err(Kind::BadInput));
    for gcr in [0.0, -0.002, f64::NAN, f64::INFINITY, 1e-320] {
        let mut call = |state: &[f64]| {
            point
                .law
                .friction(gcr, &Vector::zeros(), 1.0, state, &mut end)
        };
        let error = call(&point.state).expect_err("no length");
        assert!(error.message.starts_with("gcr = "), "{error}");
    }
    assert!(end.iter().all(|x| *x == 0.0));
}

#[test]
fn interface_form_is_penalty_and_friction_form() {
    fn check<const N: usize>(props: &[f64]) {
        let (kn, gap0) = (200.0, 0.01);
        let props = with(&with(props, 7, kn), 8, gap0);
        let mut interface = Point::<N>::new(&props);
        let mut friction = interface.clone();
        let mut random = fastrand::Rng::with_seed(106);
        let mut jump = [0.0; N];
        let mut closed = 0;
        for _ in 0..500 {
            let normal = -gap0 + 0.03 * (signed(&mut random) - 0.5);
            let increment: [f64; N] = slip(&mut random);
            for (jump, d) in jump.iter_mut().zip(increment) {
                *jump += d;
            }
            // The jump in the state makes the increment: the same rounding here.
            let at: Vec<f64> = interface.state[5..5 + N].to_vec();
            let exact = std::array::from_fn(|i| jump[i] - at[i]);
            let mut end = vec![0.0; interface.state.len()];
            let response = interface
                .law
                .interface(
                    interface.gcr,
                    normal,
                    &Vector::from(jump),
                    &interface.state,
                    &mut end,
                )
                .expect("a valid opening");
            interface.state = end;
            let pressure = (-kn * (normal + gap0)).max(0.0);
            let expected = friction.step(exact, pressure);
            closed += usize::from(pressure > 0.0);
            assert_eq!(response.friction, expected);
            assert_eq!(response.normal_traction, -pressure);
            assert_eq!(
                response.normal_stiffness,
                if pressure > 0.0 { kn } else { 0.0 }
            );
            // The states differ in the remembered jump alone.
            assert_eq!(interface.state[5..5 + N], jump[..]);
            assert_eq!(bits(&interface.state[..5]), bits(&friction.state[..5]));
            assert_eq!(bits(&interface.state[7..]), bits(&friction.state[7..]));
        }
        assert!((100..400).contains(&closed));
    }
    for props in laws() {
        check::<1>(&props);
        check::<2>(&props);
    }
}

/// The jump goes on while the contact is open; on closing the whole increment of that step counts.
#[test]
fn slip_while_open_is_not_remembered() {
    let props = with(&power(0.3, 1e-3, 2.5), 7, 1e4);
    let law = Law::<1>::new(&props, 25).expect("good properties");
    let run = |path: &[(f64, f64)]| {
        let mut state = [0.0; 25];
        let mut last = 0.0;
        for (normal, jump) in path {
            let start = state;
            let response = law.interface(1e-3, *normal, &Vector::from([*jump]), &start, &mut state);
            last = response.expect("a valid opening").friction.traction[0];
        }
        last
    };
    let closing = run(&[(0.1, 0.5), (0.1, 0.7), (-1e-3, 0.7004)]);
    let virgin = run(&[(-1e-3, 0.0004)]);
    assert_abs_diff_eq!(closing, virgin, epsilon = 1e-11);
    assert!(closing > 1.0);
    let reopened = run(&[(-1e-3, 0.01), (0.0, 0.02), (-1e-3, 0.0204)]);
    assert_abs_diff_eq!(reopened, virgin, epsilon = 1e-11);
}

/// A host's first iteration starts from touching: no pressure yet, but the stiffness that closes the gap.
#[test]
fn a_point_that_just_touches_is_stiff() {
    let (kn, gap0) = (1e4, 0.125);
    let props = with(&with(&unit(2.5), 7, kn), 8, gap0);
    let law = Law::<2>::new(&props, 64).expect("good properties");
    let mut end = [0.0; 64];
    let mut at = |normal: f64| {
        let jump = Vector::from([0.2, -0.1]);
        let response = law.interface(1.0, normal, &jump, &[0.0; 64], &mut end);
        response.expect("a valid opening")
    };
    for (normal, stiffness) in [(-gap0, kn), (-gap0 + 1e-9, 0.0), (-gap0 - 1e-9, kn)] {
        let response = at(normal);
        assert_eq!(response.normal_stiffness, stiffness);
        assert_eq!(response.normal_traction, (kn * (normal + gap0)).min(0.0));
        let open = normal >= -gap0;
        assert_eq!(response.friction.traction.norm() == 0.0, open);
        assert_eq!(response.dtraction_dopening.norm() == 0.0, open);
    }
    let open = at(1.0).normal_traction;
    assert!(open.is_sign_positive(), "no negative zero in an open point");
}

/// The whole unsymmetric tangent of the interface form, against central differences.
#[test]
fn interface_tangent_against_differences() {
    fn check<const N: usize>(props: &[f64], worst: &mut f64) {
        let kn = 50.0;
        let props = with(&with(props, 7, kn), 8, -0.02);
        let mut point = Point::<N>::new(&props);
        let mut random = fastrand::Rng::with_seed(107);
        let mut jump = Vector::<N>::zeros();
        for _ in 0..300 {
            let direction = Vector::<N>::from_fn(|_, _| signed(&mut random)).normalize();
            jump += direction * decades(&mut random, -2.0, 0.3);
            let normal = -0.02 * random.f64();
            let at = |normal: f64, jump: Vector<N>| {
                let mut end = vec![0.0; point.state.len()];
                let response = point
                    .law
                    .interface(1.0, normal, &jump, &point.state, &mut end);
                (response.expect("a valid opening"), end)
            };
            let (response, end) = at(normal, jump);
            let scale = -response.normal_traction;
            // Rounding asks for long steps, kinks nearby for short ones.
            let best = |error: &dyn Fn(f64) -> f64| {
                [1e-6, 1e-7, 1e-8]
                    .map(error)
                    .into_iter()
                    .fold(f64::INFINITY, f64::min)
            };
            *worst = worst.max(best(&|h| {
                let (high, low) = (at(normal + h, jump).0, at(normal - h, jump).0);
                let normal_part = (high.normal_traction - low.normal_traction) / (2.0 * h)
                    - response.normal_stiffness;
                let part = (high.friction.traction - low.friction.traction) / (2.0 * h)
                    - response.dtraction_dopening;
                (part.norm() + normal_part.abs()) / kn
            }));
            for j in 0..N {
                *worst = worst.max(best(&|h| {
                    let mut shift = Vector::<N>::zeros();
                    shift[j] = h;
                    let (high, low) = (at(normal, jump + shift).0, at(normal, jump - shift).0);
                    // The pressure does not depend on the tangential jump.
                    assert_eq!(high.normal_traction, low.normal_traction);
                    let part = (high.friction.traction - low.friction.traction) / (2.0 * h);
                    (part - response.friction.dtraction_dslip.column(j)).norm() / scale
                }));
            }
            point.state = end;
        }
    }
    let mut worst = 0.0;
    for props in laws() {
        check::<1>(&props, &mut worst);
        check::<2>(&props, &mut worst);
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-6);
}

#[test]
fn opening_and_closing() {
    fn check<const N: usize>(props: &[f64]) {
        let mut point = Point::<N>::new(props);
        let mut random = fastrand::Rng::with_seed(108);
        for _ in 0..200 {
            for _ in 0..random.u32(1..6) {
                point.step(slip(&mut random), decades(&mut random, -1.0, 1.0));
            }
            let stored = point.state[2];
            let dissipated = point.state[3];
            let length = point.state[4];
            // Open, slide while open, close again: a virgin point with its counters going on.
            let opened = point.step(slip(&mut random), -random.f64());
            assert_eq!(opened.traction.norm(), 0.0);
            assert_eq!(opened.dtraction_dslip.norm(), 0.0);
            assert_eq!((opened.stored, opened.dissipated), (0.0, stored));
            point.step(slip(&mut random), 0.0);
            assert_eq!(point.state[..3], [0.0; 3]);
            assert_eq!(point.state[3], dissipated + stored);
            assert_eq!(point.state[4], length);
            assert!(point.state[7..].iter().all(|x| *x == 0.0));
            let (increment, pressure) = (slip(&mut random), decades(&mut random, -1.0, 1.0));
            let closed = point.step(increment, pressure);
            let virgin = Point::<N>::new(props).step(increment, pressure);
            assert_eq!(closed, virgin);
        }
    }
    for props in laws() {
        check::<1>(&props);
        check::<2>(&props);
    }
}

/// A state with remembered reversals, for damaging.
fn used_state<const N: usize>(props: &[f64]) -> Point<N> {
    let mut point = Point::<N>::new(props);
    for s in [0.8, -0.5, 0.3, -0.1] {
        let mut target = [0.4 * s; N];
        target[0] = s;
        point.move_to(target, 1.0);
    }
    assert!(point.state[7] >= 3.0, "a history with floating knots");
    point
}

#[test]
fn corrupt_states_are_refused_and_nothing_is_written() {
    fn check<const N: usize>(props: &[f64], base: usize) {
        let point = used_state::<N>(props);
        let floats = 8 + base * N;
        let knot = 1 + N;
        let count = point.state[7];
        let room = ((point.state.len() - floats) / knot) as f64;
        let refused = |what: &str, slot: usize, value: f64| {
            let mut state = point.state.clone();
            state[slot] = value;
            let mut end = vec![-77.0; state.len()];
            let increment = Vector::from([0.1; N]);
            let error = point
                .law
                .friction(point.gcr, &increment, 1.0, &state, &mut end)
                .expect_err(what);
            assert_eq!(error.kind, Kind::BadState, "{what}: {error}");
            let name = point.law.layout().slot_name(slot).expect("a slot");
            assert!(
                error.message.contains(&format!("state[{slot}] {name} = ")),
                "{what}: {error}"
            );
            assert!(
                end.iter().all(|x| *x == -77.0),
                "{what}: state1 was written"
            );
        };
        for slot in 0..point.state.len() {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                refused("not finite", slot, value);
            }
        }
        for status in [-1.0, 4.0, 0.5] {
            refused("unknown contact status", 0, status);
        }
        refused("negative pressure", 1, -1e-3);
        for value in [-1.0, 0.5, count + 1e-9, room + 1.0, 1e300] {
            refused("knot count", 7, value);
        }
        let first = point.state[floats];
        let second = point.state[floats + knot];
        refused("knot at zero", floats, 0.0);
        refused("negative knot", floats, -first);
        refused("knot beyond one", floats + (count as usize - 1) * knot, 1.0);
        refused("unordered knots", floats + knot, 0.5 * first);
        refused("equal knots", floats + knot, first);
        refused("knots of rounding apart", floats + knot, first.next_up());
        assert!(second > first);
        for (what, slot) in [
            ("base deflection", floats - N),
            ("knot deflection", floats + 1),
        ] {
            refused(what, slot, 1.5);
            refused(what, slot, -1.5);
        }
    }
    for props in [unit(2.5), segalman(-0.5, 0.1)] {
        check::<1>(&props, 1);
        check::<2>(&props, 16);
    }
}

/// A floating knot in the place of a base knot would make a segment of no length.
#[test]
fn a_floating_knot_on_the_base_grid_is_refused() {
    let mut point = used_state::<2>(&with(&unit(2.0), 9, 4.0));
    let floats = 8 + 4 * 2;
    // chi = 2: the base grid is k / B, to the last bit.
    for (k, r) in [0.25, 0.5, 0.75].into_iter().enumerate() {
        point.state[7] = 1.0;
        point.state[floats..].fill(0.0);
        point.state[floats] = r;
        let mut end = point.state.clone();
        let result =
            point
                .law
                .friction(1.0, &Vector::from([0.1, 0.0]), 1.0, &point.state, &mut end);
        let error = result.expect_err("a knot on the base grid");
        assert_eq!(error.kind, Kind::BadState, "knot {k}: {error}");
    }
}

/// Rotation and restart files with few digits leave deflections a little too long: these are projected.
#[test]
fn deflections_a_little_too_long_are_projected() {
    for (stretch, ok) in [
        (1.0 + 5e-10, true),
        (1.0 + 0.9e-9, true),
        (1.0 + 3e-9, false),
    ] {
        // In gross slip every base knot is at its limit.
        let mut point = Point::<2>::new(&unit(2.5));
        point.move_to([3.0, 4.0], 1.0);
        for e in &mut point.state[8..40] {
            *e *= stretch;
        }
        let mut end = vec![0.0; 64];
        let result = point
            .law
            .friction(1.0, &Vector::zeros(), 1.0, &point.state, &mut end);
        assert_eq!(result.is_ok(), ok, "stretched by {stretch}");
        if let Ok(response) = result {
            assert!(response.traction.norm() <= 1.0 + 1e-14);
            let longest = end[38].hypot(end[39]);
            assert!(longest <= 1.0 + 1e-14, "{longest:e}");
        }
    }
}

#[test]
fn memory_full_is_reported_when_a_reversal_is_dropped() {
    fn spiral<const N: usize>(nstate: usize, turns: i32) -> Vec<bool> {
        let mut point = Point::<N>::with_state_size(&unit(2.5), nstate);
        (0..turns)
            .map(|k| {
                point
                    .move_to([0.95 * (-0.8f64).powi(k); N], 1.0)
                    .memory_full
            })
            .collect()
    }
    // Ever smaller reversals: F knots hold F - 1 of them and the present front.
    for (two, one, slots) in [(least_state(2, 16), least_state(1, 1), 2), (64, 25, 8)] {
        for full in [spiral::<1>(one, 12), spiral::<2>(two, 12)] {
            let first = full.iter().position(|full| *full);
            println!("{slots} slots: first dropped at branch {first:?}");
            assert!(first.is_some_and(|first| first >= slots));
        }
    }
    // Large cycles need no memory of each other.
    assert!(!spiral::<1>(25, 4).contains(&true));
}

/// A state with room for everything is followed as long as nothing is said: who reads the advice knows what a result is worth.
#[test]
fn a_short_state_goes_its_own_way_only_after_it_has_reported_full() {
    fn check<const N: usize>(props: &[f64], random: &mut fastrand::Rng) -> u32 {
        let base = if N == 1 { 1 } else { 16 };
        let size = |floating: usize| 8 + base * N + floating * (1 + N);
        let mut differ = 0;
        for _ in 0..400 {
            let mut short = Point::<N>::with_state_size(props, size(2));
            let mut roomy = Point::<N>::with_state_size(props, size(64));
            for _ in 0..8 {
                let slip = slip(random);
                let (a, b) = (short.step(slip, 1.0), roomy.step(slip, 1.0));
                assert!(!b.memory_full);
                let difference = (a.traction - b.traction).norm();
                if a.memory_full {
                    differ += u32::from(difference > 1e-9);
                    break;
                }
                assert!(difference < 1e-9, "{difference:e} {:?}", short.slip);
            }
        }
        differ
    }
    let seed = 115;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut differ = 0;
    for props in laws() {
        differ += check::<1>(&props, &mut random) + check::<2>(&props, &mut random);
    }
    println!("{differ} differ with the step that reports it");
    assert!(differ > 100);
}

/// What is dropped from a full memory is the smallest loop: the large ones keep their place.
#[test]
fn the_least_important_reversal_is_dropped() {
    // Loops of half the size each: many more than there are slots.
    let reversals: Vec<f64> = (0..20).map(|k| 0.95 * (-0.5f64).powi(k)).collect();
    for (slots, nstate, tolerance) in [(4, 17, 0.05), (8, 25, 1e-3)] {
        let mut point = Point::<1>::with_state_size(&unit(2.5), nstate);
        let mut exact = Masing::new(Backbone::Power { chi: 2.5 });
        let mut worst = 0.0f64;
        let mut full = 0;
        // In, and out again along the large loops.
        for s in reversals.iter().chain(&[-0.3, 0.6, 0.94]) {
            let response = point.move_to([*s], 1.0);
            exact.move_to(*s);
            full += i32::from(response.memory_full);
            worst = worst.max((response.traction[0] - exact.traction()).abs());
        }
        println!("{slots} slots: {full} dropped, traction off by {worst:.1e}");
        assert!(full > 5);
        assert!(worst < tolerance);
    }
}

/// Masing's rules: besides the front a branch remembers the reversals of the loops that are open. With chi = 1 there is one slip
/// element, and a reversal tells nothing that the traction does not.
#[test]
fn closed_loops_are_forgotten() {
    fn check<const N: usize>(direction: [f64; N]) {
        let mut point = Point::<N>::new(&unit(2.5));
        for (s, floating_knots) in [
            (0.8, 1.0),
            (-0.2, 2.0),
            (0.3, 3.0),
            (-0.2, 2.0),
            (0.1, 3.0),
            (-0.8, 1.0),
            (0.8, 1.0),
            (-0.3, 2.0),
            (-3.0, 0.0),
        ] {
            point.move_to(direction.map(|x| s * x), 1.0);
            assert_eq!(point.state[7], floating_knots, "at {s}");
        }
        let mut line = Point::<N>::new(&with(&unit(1.0), 9, 1.0));
        let mut random = fastrand::Rng::with_seed(116);
        for _ in 0..300 {
            let s = signed(&mut random);
            line.move_to(direction.map(|x| s * x), 1.0);
            assert!(line.state[7] <= 1.0, "{} at {s}", line.state[7]);
        }
    }
    check([1.0]);
    check([0.6, -0.8]);
}

/// Numbers at the edges of the format and random bits: an error or finite values, never a panic.
#[test]
fn odd_numbers_give_errors_or_finite_values() {
    let seed = 109;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let odd = |usual: f64, random: &mut fastrand::Rng| match random.u32(0..6) {
        0 => f64::from_bits(random.u64(..)),
        1 => [
            0.0,
            -0.0,
            f64::MIN_POSITIVE,
            5e-324,
            f64::MAX,
            f64::NAN,
            f64::INFINITY,
            1e-300,
            1e99,
            1e160,
        ][random.usize(0..10)],
        2 => signed(random) * decades(random, -300.0, 300.0),
        _ => usual,
    };
    let (mut good, mut refused) = (0, 0);
    for props in laws() {
        for _ in 0..20_000 {
            let mut point = Point::<2>::with_state_size(&props, least_state(2, 16));
            for _ in 0..random.u32(0..5) {
                point.step(slip(&mut random), decades(&mut random, -1.0, 1.0));
            }
            let increment: [f64; 2] = slip::<2>(&mut random).map(|x| odd(x, &mut random));
            let pressure = odd(1.0, &mut random);
            let damaged = random.u32(0..3) == 0;
            if damaged {
                let slot = random.usize(0..point.state.len());
                point.state[slot] = odd(point.state[slot], &mut random);
            }
            let mut end = vec![f64::NAN; point.state.len()];
            match point.law.friction(
                1.0,
                &Vector::from(increment),
                pressure,
                &point.state,
                &mut end,
            ) {
                Ok(response) => {
                    good += 1;
                    let numbers = response.traction.iter().chain(&response.dtraction_dslip);
                    let numbers = numbers.chain(&response.dtraction_dpressure).chain(&end);
                    assert!(
                        numbers.copied().all(f64::is_finite),
                        "{increment:?} {pressure}"
                    );
                    assert!(response.stored.is_finite() && response.dissipated.is_finite());
                    // A damaged curve may be steeper than any that slip can make; rounding is larger there.
                    let rounding = if damaged { 1e-7 } else { 1e-12 };
                    if pressure >= 1e-290 {
                        // Below that traction itself loses digits.
                        let excess = (response.traction / pressure).norm() - 1.0;
                        assert!(excess <= rounding, "{excess:e}");
                    }
                }
                Err(error) => {
                    refused += 1;
                    assert!(
                        matches!(error.kind, Kind::BadState | Kind::BadInput),
                        "{error}"
                    );
                    assert!(end.iter().all(|x| x.is_nan()), "state1 was written");
                }
            }
        }
    }
    println!("{good} updates, {refused} refused");
    assert!(good > 20_000 && refused > 20_000);
}

/// Worst values of many updates; tractions over mu p, energies over mu p gcr.
#[derive(Debug)]
struct Worst {
    updates: u64,
    excess: f64,
    dissipated: f64,
    not_finite: u64,
    full: u64,
}

impl Worst {
    /// One history of a point with a state as short as can be.
    fn history<const N: usize>(&mut self, props: &[f64], random: &mut fastrand::Rng, count: u64) {
        let base = if N == 1 { 1 } else { props[8] as usize };
        let (mu, gcr, rule) = (props[0], props[1], props[4]);
        let mut point = Point::<N>::with_state_size(props, least_state(N, base));
        let mut end = point.state.clone();
        let typical = decades(random, -3.0, 4.0);
        let mut pressure = typical;
        for _ in 0..count {
            let length = gcr * decades(random, -12.0, 3.0);
            let slip = Vector::from(std::array::from_fn(|_| length * signed(random)));
            let before = pressure;
            pressure = match random.u32(0..16) {
                0 => 0.0,
                1 | 2 => typical * decades(random, -2.0, 2.0),
                3 => pressure * (1.0 + 0.1 * signed(random)),
                _ if pressure == 0.0 => typical,
                _ => pressure,
            };
            let response = point
                .law
                .friction(gcr, &slip, pressure, &point.state, &mut end);
            let response = response.expect("a valid increment from the library's own state");
            std::mem::swap(&mut point.state, &mut end);
            let finite = response
                .traction
                .iter()
                .chain(&response.dtraction_dslip)
                .chain(&response.dtraction_dpressure);
            let finite = finite.copied().all(f64::is_finite)
                && (response.stored + response.dissipated).is_finite();
            self.updates += 1;
            self.not_finite += u64::from(!finite);
            self.full += u64::from(response.memory_full);
            if pressure > 0.0 {
                self.excess = self
                    .excess
                    .max(response.traction.norm() / (mu * pressure) - 1.0);
            }
            if rule == 0.0 {
                let energy = mu * pressure.max(before) * gcr;
                self.dissipated = self
                    .dissipated
                    .min(response.dissipated / energy.max(f64::MIN_POSITIVE));
            }
        }
    }
}

#[test]
fn ten_million_random_updates() {
    const HISTORIES: u64 = 50;
    const PER_HISTORY: u64 = 25_000;
    let seed = 20_260_110;
    let started = std::time::Instant::now();
    let mut random = fastrand::Rng::with_seed(seed);
    let mut worst = Worst {
        updates: 0,
        excess: f64::NEG_INFINITY,
        dissipated: f64::INFINITY,
        not_finite: 0,
        full: 0,
    };
    for rule in [0.0, 1.0] {
        for is_segalman in [false, true] {
            for _ in 0..HISTORIES {
                // Usual exponents, and all that is allowed.
                let curve = match (is_segalman, random.usize(0..6)) {
                    (false, usual @ 0..4) => unit([1.0, 1.5, 2.5, 4.0][usual]),
                    (false, _) => unit(1.0 + decades(&mut random, -4.0, 5.99)),
                    (true, usual @ 0..4) => {
                        segalman([-0.9, -0.6, -0.3, 0.0][usual], 0.3 * random.f64())
                    }
                    (true, _) => segalman(
                        -1.0 + decades(&mut random, -6.0, 0.0),
                        decades(&mut random, -6.0, 6.0),
                    ),
                };
                let mut props = with(&curve, 5, rule);
                props[0] = 0.1 + random.f64();
                props[1] = decades(&mut random, -6.0, 0.0);
                props[8] = f64::from(random.u32(1..=24));
                worst.history::<1>(&props, &mut random, PER_HISTORY);
                worst.history::<2>(&props, &mut random, PER_HISTORY);
            }
        }
    }
    println!(
        "seed {seed}: {} updates in {:.1} s, {} with full memory; max |tau|/(mu p) - 1 = {:.2e}, least dissipation / \
         (mu p gcr) under rule 0 = {:.2e}, not finite: {}",
        worst.updates,
        started.elapsed().as_secs_f64(),
        worst.full,
        worst.excess,
        worst.dissipated,
        worst.not_finite
    );
    assert_eq!(worst.updates, 10_000_000);
    assert!(worst.full > 100_000, "the histories fill the memory");
    assert_eq!(worst.not_finite, 0);
    assert!(worst.excess <= 1e-12);
    // Rounding of a sum that cancels; a step of 1000 gcr has energies of 1000 mu p gcr.
    assert!(worst.dissipated >= -1e-14);
}
