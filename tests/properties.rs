//! Properties that hold on any history: random ones, seeds printed. And what fuzzing and the prototypes found.

mod support;

use approx::assert_abs_diff_eq;
use mepc::{Kind, Matrix, Vector};
use support::{
    Point, consistent, decades, integral, segalman, signed, state_size, turned, unit, with,
};

/// Both backbones, both rules.
fn laws() -> Vec<Vec<f64>> {
    let mut laws = vec![segalman(-0.6, 0.2), segalman(0.0, 0.0)];
    for chi in [1.0, 1.7, 2.5] {
        laws.extend([unit(chi), consistent(&unit(chi))]);
    }
    laws
}

fn slip<const N: usize>(random: &mut fastrand::Rng) -> [f64; N] {
    let length = decades(random, -3.0, 0.5);
    std::array::from_fn(|_| length * signed(random))
}

/// Item 8: a rotated path gives rotated tractions. Halving is decided at thresholds: seldom rounding decides otherwise.
#[test]
fn v08_rotated_paths_give_rotated_tractions() {
    let mut worst = Vec::new();
    for props in laws() {
        for angle in [0.4, 1.9, -2.6] {
            let q = Matrix::from_columns(
                &[turned([1.0, 0.0], angle), turned([0.0, 1.0], angle)].map(Vector::from),
            );
            let (mut plain, mut rotated) = (Point::<2>::new(&props), Point::<2>::new(&props));
            let mut random = fastrand::Rng::with_seed(101);
            let mut pressure = 1.0;
            for _ in 0..100 {
                if random.u32(0..4) == 0 {
                    pressure = decades(&mut random, -1.0, 1.0);
                }
                let d = slip(&mut random);
                let (a, b) = (
                    plain.step(d, pressure),
                    rotated.step(turned(d, angle), pressure),
                );
                worst.push((q * a.traction - b.traction).norm() / pressure);
                worst.push((a.stored - b.stored).abs() / pressure);
            }
        }
    }
    let count = worst.iter().filter(|x| **x > 1e-9).count();
    println!(
        "{} of {} differ by more than 1e-9, at most {:.1e}",
        count,
        worst.len(),
        worst.iter().fold(0.0f64, |m, x| m.max(*x))
    );
    assert!(worst.iter().all(|x| *x < 2e-3));
    assert!(count * 50 < worst.len());
}

/// Item 10: work = change of stored + dissipated along straight histories at a constant limit.
#[test]
fn v10_energy_balance_on_straight_histories() {
    let seed = 11;
    let mut random = fastrand::Rng::with_seed(seed);
    let mut worst = 0.0f64;
    for props in [unit(1.0), unit(1.5), unit(2.5), segalman(-0.6, 0.3)] {
        for direction in [[1.0, 0.0], [0.6, -0.8]] {
            let mut point = Point::<2>::with_state_size(&props, state_size(2, 40));
            let (mut before, mut at) = (0.0, 0.0);
            for _ in 0..10 {
                let s = signed(&mut random) * [0.1, 0.5, 1.0, 3.0][random.usize(0..4)];
                // Work by quadrature of the traction along the branch, each value from the start of the branch.
                let n = Vector::from(direction);
                let force = |d: f64| {
                    point
                        .trial(direction.map(|x| x * d), 1.0)
                        .0
                        .traction
                        .dot(&n)
                };
                let work = integral(&force, 0.0, s - at, 1e-12);
                let response = point.step(direction.map(|x| x * (s - at)), 1.0);
                at = s;
                worst = worst.max((work - (response.stored - before) - response.dissipated).abs());
                before = response.stored;
            }
        }
    }
    println!("seed {seed}: work - change of stored - dissipated = {worst:.1e}");
    assert!(worst < 1e-9);
}

/// Found by fuzzing: with chi = 1 a return from gross slip by b <= 1e-7 gcr, and forward again, stays on the straight line.
#[test]
fn a_tiny_return_from_gross_slip_stays_on_the_line_of_the_penalty() {
    for props in [unit(1.0), consistent(&unit(1.0)), with(&unit(2.5), 4, 1.0)] {
        for b in [1e-5, 1e-7, 1e-9, 1e-12] {
            for direction in [[1.0, 0.0], [0.6, -0.8]] {
                let n = Vector::from(direction);
                let mut point = Point::<2>::new(&props);
                let mut line = Point::<1>::new(&props);
                line.step([3.0], 1.0);
                point.step(direction.map(|x| 3.0 * x), 1.0);
                line.step([-b], 1.0);
                point.step(direction.map(|x| -b * x), 1.0);
                let mut slip = 1.0 - b;
                // In two and more steps forward; half the way still sticks.
                for _ in 0..4 {
                    slip += b / 8.0;
                    let (a, c) = (
                        line.step([b / 8.0], 1.0),
                        point.step(direction.map(|x| x * b / 8.0), 1.0),
                    );
                    for (t, k) in [
                        (a.traction[0], a.dtraction_dslip[(0, 0)]),
                        (c.traction.dot(&n), n.dot(&(c.dtraction_dslip * n))),
                    ] {
                        assert_abs_diff_eq!(t, slip, epsilon = 2e-15 + 1e-6 * b);
                        assert_abs_diff_eq!(k, 1.0, epsilon = 1e-9);
                    }
                    assert!(a.contact as i32 == 1 && c.contact as i32 == 1);
                }
            }
        }
    }
}

/// Found by fuzzing: the stored energy is never negative, not by rounding either.
#[test]
fn stored_energy_is_never_negative() {
    let mut random = fastrand::Rng::with_seed(319);
    for props in laws() {
        let (mut line, mut plane) = (Point::<1>::new(&props), Point::<2>::new(&props));
        for _ in 0..20_000 {
            let p = if random.bool() {
                1.0
            } else {
                decades(&mut random, -0.3, 0.3)
            };
            let d = 1e-3 * signed(&mut random) * decades(&mut random, -9.0, 3.5);
            assert!(line.step([d], p).stored >= 0.0);
            assert!(plane.step([0.28 * d, -0.96 * d], p).stored >= 0.0);
            assert!(line.state[3] >= 0.0 && plane.state[3] >= 0.0);
        }
    }
}

/// A trap: an exact reversal of what was just done, or almost, gives the same but for what the reversal is short of.
#[test]
fn undoing_a_step_exactly_or_almost() {
    let mut worst = 0.0f64;
    for path in [
        [[0.125, -0.375], [-0.25, 0.0], [0.25, 0.0]],
        [[-0.25, -0.125], [0.375, -0.125], [-0.25, 0.0]],
        [[1.0, 0.75], [-0.5, -1.0], [0.5, 0.25]],
    ] {
        for props in laws() {
            let last = |shift: [f64; 2]| {
                let mut point = Point::<2>::new(&props);
                point.step(path[0], 1.0);
                point.step(path[1], 1.0);
                point.step([0, 1].map(|i| path[2][i] + shift[i]), 1.0)
            };
            let exact = last([0.0; 2]);
            for shift in [[1e-10, 0.0], [-1e-10, 0.0], [0.0, 1e-10], [0.0, -1e-10]] {
                let near = last(shift);
                worst = worst
                    .max((exact.traction - near.traction).norm())
                    .max((exact.stored - near.stored).abs());
            }
        }
    }
    // Lifted middles come or go.
    println!("worst {worst:.1e}");
    assert!(worst < 6e-4);
}

/// What would make the state infinite, or turn the traction round, is refused.
#[test]
fn energies_beyond_numbers_and_critical_slips_that_are_none_are_refused() {
    let mut point = Point::<1>::new(&unit(2.5));
    point.step([0.5], 1.0);
    let mut huge = point.state.clone();
    (huge[3], huge[4]) = (1.7e308, 1.7e308);
    let mut end = vec![0.0; huge.len()];
    let opened = point
        .law
        .friction(1.0, &Vector::zeros(), 0.0, 1.0, &huge, &mut end);
    assert_eq!(opened.map_err(|error| error.kind), Err(Kind::BadInput));
    for gcr in [0.0, -0.002, f64::NAN, f64::INFINITY, 1e-320] {
        let error = point
            .law
            .friction(gcr, &Vector::zeros(), 1.0, 1.0, &point.state, &mut end)
            .expect_err("no length");
        assert!(error.to_string().contains("gcr = "), "{error}");
    }
    for factor in [-0.1, f64::NAN, f64::INFINITY] {
        let error = point
            .law
            .friction(1.0, &Vector::zeros(), 1.0, factor, &point.state, &mut end)
            .expect_err("no factor");
        assert!(error.to_string().contains("mu_factor = "), "{error}");
    }
    assert!(end.iter().all(|x| *x == 0.0));
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
        for _ in 0..10_000 {
            let mut point = Point::<2>::with_state_size(&props, state_size(2, 4));
            for _ in 0..random.u32(0..5) {
                point.step(slip(&mut random), decades(&mut random, -1.0, 1.0));
            }
            let increment: [f64; 2] = slip::<2>(&mut random).map(|x| odd(x, &mut random));
            let (pressure, factor) = (odd(1.0, &mut random), odd(1.0, &mut random));
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
                factor,
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
                    let limit = pressure * factor;
                    // A damaged curve may be steeper than any that slip can make; outside of these limits the traction itself
                    // loses digits.
                    if !damaged && (1e-290..1e290).contains(&limit) {
                        let excess = (response.traction / limit).norm() - 1.0;
                        assert!(
                            excess <= 1e-12,
                            "{excess:e} {props:?} {increment:?} {pressure} {factor} {:?}",
                            point.state
                        );
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

/// Worst values of many updates; tractions over T, energies over T and the longer of slip and G.
#[derive(Debug)]
struct Worst {
    updates: u64,
    excess: f64,
    /// Least dissipation in one direction, in two at a constant limit, and in two under a changing one.
    line: f64,
    plane: f64,
    turning: f64,
    negative: u64,
    not_finite: u64,
    full: u64,
}

impl Worst {
    /// One history of a point with a state of four knots or of the default length. Limits rise, fall, vanish (pressure and factor).
    fn history<const N: usize>(&mut self, props: &[f64], random: &mut fastrand::Rng, count: u64) {
        let (mu, gcr, p0) = (props[0], props[1], props[4]);
        let knots = if random.bool() { 4 } else { 16 };
        let mut point = Point::<N>::with_state_size(props, state_size(N, knots));
        let mut end = point.state.clone();
        let typical = decades(random, -3.0, 4.0);
        let mut pressure = typical;
        for _ in 0..count {
            let length = gcr * decades(random, -12.0, 3.0);
            let slip = Vector::from(std::array::from_fn(|_| length * signed(random)));
            pressure = match random.u32(0..16) {
                0 => 0.0,
                1 | 2 => typical * decades(random, -2.0, 2.0),
                3..=6 => pressure * (1.0 + 0.1 * signed(random)),
                _ if pressure == 0.0 => typical,
                _ => pressure,
            };
            let factor = match random.u32(0..32) {
                0 => 0.0,
                1 => random.f64(),
                _ => 1.0,
            };
            let before = (
                point.state[2],
                point.state[HEADER..]
                    .chunks_exact(1 + N)
                    .map(|knot| knot[0])
                    .fold(0.0, f64::max),
            );
            let response = point
                .law
                .friction(gcr, &slip, pressure, factor, &point.state, &mut end);
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
            self.negative += u64::from(response.stored < 0.0);
            self.full += u64::from(response.memory_full);
            let limit = mu * factor * pressure;
            if limit > 0.0 {
                self.excess = self.excess.max(response.traction.norm() / limit - 1.0);
            } else {
                assert_eq!(response.traction.norm(), 0.0);
            }
            // Under the proportional rule a changing limit creates energy.
            if p0 > 0.0 || limit == before.0 {
                let critical = point.state[HEADER..]
                    .chunks_exact(1 + N)
                    .map(|knot| knot[0])
                    .fold(before.1, f64::max);
                let energy = limit.max(before.0) * critical.max(slip.norm());
                let least = response.dissipated / energy.max(f64::MIN_POSITIVE);
                let least_of = match (N, limit == before.0) {
                    (1, _) => &mut self.line,
                    (_, true) => &mut self.plane,
                    _ => &mut self.turning,
                };
                *least_of = least_of.min(least);
            }
        }
    }
}

const HEADER: usize = support::HEADER;

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
        line: f64::INFINITY,
        plane: f64::INFINITY,
        turning: f64::INFINITY,
        negative: 0,
        not_finite: 0,
        full: 0,
    };
    for (is_segalman, is_consistent) in
        [(false, false), (false, true), (true, false), (false, true)]
    {
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
            let p0 = if is_consistent {
                decades(&mut random, -1.0, 1.0)
            } else {
                0.0
            };
            let mut props = with(&curve, 5, p0);
            props[0] = 0.1 + random.f64();
            props[1] = decades(&mut random, -6.0, 0.0);
            worst.history::<1>(&props, &mut random, PER_HISTORY);
            worst.history::<2>(&props, &mut random, PER_HISTORY);
        }
    }
    println!(
        "seed {seed}: {} updates in {:.1} s, {} with full memory; max |tau|/T - 1 = {:.2e}, least dissipation / (T max(G, slip)) \
         but for changing limits under the proportional rule = {:.2e} in one direction, {:.2e} in two, {:.2e} there under changing limits; negative stored energies: {}, not finite: {}",
        worst.updates,
        started.elapsed().as_secs_f64(),
        worst.full,
        worst.excess,
        worst.line,
        worst.plane,
        worst.turning,
        worst.negative,
        worst.not_finite
    );
    assert_eq!(worst.updates, 10_000_000);
    assert!(worst.full > 100_000, "the histories fill the memory");
    assert_eq!((worst.not_finite, worst.negative), (0, 0));
    assert!(worst.excess <= 1e-12);
    // Rounding of sums that cancel.
    assert!(worst.line.min(worst.plane).min(worst.turning) >= -1e-12);
}

/// Consistent rule: no increment dissipates less than rounding. The old apex of a contact whose limit rises by much leaves two
/// places next to each other that have slipped differently.
#[test]
fn no_increment_creates_energy() {
    let props = [
        0.9544155901726464,
        2.163424791782604e-6,
        1.0,
        0.0,
        4.718719718122761,
    ];
    let mut point = Point::<2>::with_state_size(&props, state_size(2, 4));
    let start = [
        1.0,
        806.7083391400995,
        769.9350155975935,
        0.0038587182658724782,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        2.0,
        2.0,
        5.5402205984585026e-17,
        5.060234770306605e-17,
        -2.2556746992782335e-17,
        0.0003698572758900313,
        -3.312716137046155e-5,
        5.108671231497755e-5,
    ];
    point.state[..start.len()].copy_from_slice(&start);
    let response = point.step(
        [-0.0006853674725864118, -0.0013779566565478212],
        3536.016448178056,
    );
    // chi = 1: the only element sticks.
    let scale = point.state[2] * 0.0016;
    assert_abs_diff_eq!(response.dissipated / scale, 0.0, epsilon = 1e-14);
}
