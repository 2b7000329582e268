//! Identification of the four-parameter Iwan model: verification item 17 and the paper's tables, against loops that the
//! closed form of the oracle gives.

mod support;

use mepc::iwan::{Fit, Iwan, NAMES, PAPER_TOLERANCE, Record, Warning};
use mepc_oracle::closed;
use std::f64::consts::PI;
use support::programs::{STRICT_C, STRICT_FORTRAN, compile_and_run, in_repository, source};

/// Item 17: F_s, X_s, k_alpha, kappa and the amplitude.
const TRUTH: [f64; 4] = [266.78, 0.0041, 3280.7, -0.842];
const AMPLITUDE: f64 = 0.02;

/// The paper's Table 2 (preloads 300 to 1100 N).
const TABLE_2: [[f64; 4]; 5] = [
    [89.70, 0.0032, 2996.4, -0.644],
    [149.02, 0.0036, 3058.9, -0.611],
    [208.09, 0.0039, 3158.3, -0.755],
    [266.78, 0.0041, 3280.7, -0.842],
    [325.38, 0.0044, 3351.4, -0.931],
];

/// The paper's Table 4: amplitude, then the parameters.
const TABLE_4: [(f64, [f64; 4]); 5] = [
    (0.025, [266.11, 0.0039, 3270.9, -0.930]),
    (0.020, [266.78, 0.0041, 3280.7, -0.842]),
    (0.015, [266.66, 0.0043, 3290.1, -0.828]),
    (0.010, [265.82, 0.0041, 3297.2, -0.864]),
    (0.005, [265.35, 0.0041, 3318.6, -0.909]),
];

fn oracle([force, displacement, residual, kappa]: [f64; 4]) -> closed::Iwan {
    closed::Iwan {
        force,
        displacement,
        residual,
        kappa,
    }
}

/// The force on a branch, written out independently of the library: Masing from the reversal.
fn masing(joint: &closed::Iwan, amplitude: f64, x: f64, sign: f64) -> f64 {
    let half = 0.5 * (amplitude + sign * x);
    sign * (2.0 * joint.peak_force(half) - joint.peak_force(amplitude))
}

/// How the displacement of a branch is sampled, from -1 to 1.
#[derive(Clone, Copy)]
enum Sampling {
    Uniform,
    Sinusoidal,
}

/// Loading and unloading branches of so many points each, `cycles` times.
fn loops(
    parameters: [f64; 4],
    amplitude: f64,
    points: usize,
    cycles: usize,
    sampling: Sampling,
) -> (Vec<f64>, Vec<f64>) {
    let joint = oracle(parameters);
    let mut data = (Vec::new(), Vec::new());
    for branch in 0..2 * cycles {
        let sign = if branch % 2 == 0 { 1.0 } else { -1.0 };
        for k in 0..points {
            let part = k as f64 / (points - 1) as f64;
            let x = match sampling {
                Sampling::Uniform => 2.0 * part - 1.0,
                Sampling::Sinusoidal => -(PI * part).cos(),
            };
            data.0.push(sign * amplitude * x);
            data.1
                .push(masing(&joint, amplitude, sign * amplitude * x, sign));
        }
    }
    data
}

/// Normal noise of this standard deviation.
fn noisy(force: &[f64], deviation: f64, seed: u64) -> Vec<f64> {
    // The generators of neighbouring seeds start alike, their forks do not.
    let mut random = fastrand::Rng::with_seed(seed).fork();
    force
        .iter()
        .map(|f| {
            let (u, v) = (1.0 - random.f64(), random.f64());
            f + deviation * (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
        })
        .collect()
}

fn least_squares(data: &(Vec<f64>, Vec<f64>)) -> Fit {
    Record::new(&data.0, &data.1)
        .and_then(|r| r.least_squares())
        .expect("a fit")
}

fn assert_recovered(fit: &Fit, truth: [f64; 4], part: f64) {
    for (k, (value, exact)) in fit.joint.parameters().into_iter().zip(truth).enumerate() {
        let error = (value / exact - 1.0).abs();
        assert!(error <= part, "{} {value}, not {exact}", NAMES[k]);
    }
}

#[test]
fn closed_forms_agree_with_the_oracle() {
    let ours = Iwan::new(TRUTH).expect("good parameters");
    let joint = oracle(TRUTH);
    for a in [0.001, 0.0041, 0.02] {
        let near = |x: f64, y: f64| assert!((x / y - 1.0).abs() < 1e-12, "{x} {y}");
        near(ours.peak_force(a), joint.peak_force(a));
        near(ours.dissipation(a), joint.cycle_dissipation(a));
        for k in 0..=20 {
            let x = a * (f64::from(k) / 10.0 - 1.0);
            for (direction, sign) in [
                (mepc::iwan::Direction::Loading, 1.0),
                (mepc::iwan::Direction::Unloading, -1.0),
            ] {
                let (f, exact) = (ours.steady(a, x, direction), masing(&joint, a, x, sign));
                assert!((f - exact).abs() < 1e-12 * joint.peak_force(a));
            }
        }
    }
    // The printed values of item 17.
    assert!((ours.peak_force(AMPLITUDE) - 332.394).abs() < 5e-4);
    assert!((ours.stick_stiffness() - 111_164.0).abs() < 0.5);
    assert!((ours.dissipation(AMPLITUDE) - 18.050).abs() < 5e-4);
}

/// Item 17: to 0.1 % from 200 clean points per branch.
#[test]
fn clean_loop_gives_its_parameters_back() {
    for sampling in [Sampling::Uniform, Sampling::Sinusoidal] {
        let data = loops(TRUTH, AMPLITUDE, 200, 1, sampling);
        let fit = least_squares(&data);
        assert_recovered(&fit, TRUTH, 1e-6);
        assert!(fit.warnings.is_empty(), "{:?}", fit.warnings);
    }
}

#[test]
fn tables_2_and_4_are_identified_back() {
    let table_2 = TABLE_2.map(|row| (AMPLITUDE, row));
    for (amplitude, row) in table_2.into_iter().chain(TABLE_4) {
        let data = loops(row, amplitude, 200, 1, Sampling::Uniform);
        let fit = least_squares(&data);
        assert_recovered(&fit, row, 1e-6);
        assert!(fit.is_reliable(), "{:?}", fit.warnings);
        let record = Record::new(&data.0, &data.1).expect("a loop");
        let area = oracle(row).cycle_dissipation(amplitude);
        assert!((record.loop_area() / area - 1.0).abs() < 1e-2);
    }
}

/// The paper's procedure on its own tables: rough in X_s and so in kappa, which is why it is not the default.
#[test]
fn paper_procedure_on_its_tables() {
    let table_2 = TABLE_2.map(|row| (AMPLITUDE, row));
    for (amplitude, row) in table_2.into_iter().chain(TABLE_4) {
        let data = loops(row, amplitude, 200, 1, Sampling::Uniform);
        let fit = Record::new(&data.0, &data.1)
            .and_then(|r| r.paper(PAPER_TOLERANCE))
            .expect("a fit");
        let found = fit.joint.parameters();
        let error = |k: usize| (found[k] / row[k] - 1.0).abs();
        println!("A {amplitude}: {row:?} -> {found:.5?}");
        assert!(error(0) < 0.005 && error(1) < 0.04 && error(2) < 0.05);
        assert!((found[3] - row[3]).abs() < 0.15);
    }
}

/// Noise must not lift the onset of gross slip far behind.
#[test]
fn paper_procedure_with_noise() {
    let clean = loops(TRUTH, AMPLITUDE, 200, 3, Sampling::Sinusoidal);
    let peak = oracle(TRUTH).peak_force(AMPLITUDE);
    for deviation in [0.001, 0.01] {
        for seed in 0..40 {
            let force = noisy(&clean.1, deviation * peak, seed);
            let fit = Record::new(&clean.0, &force).and_then(|r| r.paper(PAPER_TOLERANCE));
            let found = fit.expect("a fit").joint.parameters();
            assert!((found[1] / TRUTH[1] - 1.0).abs() < 0.1, "{seed}: {found:?}");
            assert!((found[3] - TRUTH[3]).abs() < 0.5, "{seed}: {found:?}");
        }
    }
}

/// 100 noisy loops: how many estimates are within `bounds`, and how many 95 % intervals hold the truth.
fn noise_statistics(
    cycles: usize,
    sampling: Sampling,
    bounds: [f64; 4],
) -> ([u32; 4], [u32; 4], [f64; 4]) {
    let clean = loops(TRUTH, AMPLITUDE, 200, cycles, sampling);
    let peak = oracle(TRUTH).peak_force(AMPLITUDE);
    let (mut within, mut covered, mut error) = ([0; 4], [0; 4], [0.0; 4]);
    for seed in 0..100 {
        let fit = least_squares(&(clean.0.clone(), noisy(&clean.1, 0.01 * peak, seed)));
        assert!(fit.is_reliable(), "{:?}", fit.warnings);
        for k in 0..4 {
            let value = fit.joint.parameters()[k];
            let scale = if k == 3 { 1.0 } else { TRUTH[k] };
            within[k] += u32::from((value - TRUTH[k]).abs() <= bounds[k] * scale);
            let [low, high] = fit.intervals[k];
            covered[k] += u32::from((low..=high).contains(&TRUTH[k]));
            error[k] += fit.standard_errors[k] / scale / 100.0;
        }
    }
    (within, covered, error)
}

/// Noise of 1 % of T_max, 200 points per branch, one cycle.
#[test]
fn noise_of_one_per_cent() {
    for (name, sampling) in [
        ("uniform", Sampling::Uniform),
        ("sinusoidal", Sampling::Sinusoidal),
    ] {
        let (within, covered, error) = noise_statistics(1, sampling, [0.02, 0.05, 0.05, 0.05]);
        println!("{name}: within bounds {within:?}, covered {covered:?}, mean error {error:.5?}");
        assert!(within.iter().all(|&n| n >= 95), "{within:?}");
        assert!(covered.iter().all(|n| (90..=99).contains(n)), "{covered:?}");
    }
}

#[test]
fn a_loop_without_gross_slip_is_flagged() {
    let peak = oracle(TRUTH).peak_force(AMPLITUDE);
    for part in [0.3, 0.6, 0.9, 0.97] {
        let clean = loops(TRUTH, part * TRUTH[1], 200, 1, Sampling::Uniform);
        for noise in [0.0, 0.01] {
            for seed in 0..10 {
                let fit = least_squares(&(clean.0.clone(), noisy(&clean.1, noise * peak, seed)));
                assert!(
                    fit.warnings
                        .iter()
                        .any(|w| matches!(w, Warning::NoGrossSlip { .. })),
                    "{part} {noise} {seed}: {:?} {:?}",
                    fit.joint,
                    fit.warnings
                );
            }
        }
    }
}

/// The same where the last branch ends one sample before its end.
#[test]
fn without_gross_slip_no_fit_is_reliable() {
    for part in [0.2, 0.5, 0.95] {
        for kappa in [-1.5, -0.6, 0.5, 2.0] {
            for residual in [0.0, 0.2] {
                let truth = [100.0, 0.01, residual * 1e4, kappa];
                let (mut x, mut force) = loops(truth, part * 0.01, 150, 2, Sampling::Uniform);
                x.pop();
                force.pop();
                let fit = Record::new(&x, &force).and_then(|r| r.least_squares());
                assert!(!fit.is_ok_and(|fit| fit.is_reliable()), "{part} {truth:?}");
            }
        }
    }
}

/// Wherever a record starts and ends: points beyond its first and its last reversal belong to other branches.
#[test]
fn a_record_may_start_and_end_anywhere() {
    let whole = loops(TRUTH, AMPLITUDE, 100, 4, Sampling::Sinusoidal);
    let cut = |from: usize, to: usize| {
        let part = (whole.0[from..to].to_vec(), whole.1[from..to].to_vec());
        let fit = least_squares(&part);
        assert_recovered(&fit, TRUTH, 1e-5);
        assert!(fit.is_reliable(), "{from} {to}: {:?}", fit.warnings);
    };
    for step in (0..200).step_by(3) {
        cut(0, 500 + step);
        cut(step, 700);
        cut(step, 300 + step);
    }
}

/// Noise of the displacement must not count as amplitude: .2 % of it shift no parameter by more than a standard error.
#[test]
fn noise_of_the_displacement() {
    let peak = oracle(TRUTH).peak_force(AMPLITUDE);
    for sampling in [Sampling::Uniform, Sampling::Sinusoidal] {
        let (mut x, mut force) = loops(TRUTH, AMPLITUDE, 200, 3, sampling);
        // Every reversal once: a corner has no plateau.
        for k in (1..6).rev() {
            x.remove(200 * k);
            force.remove(200 * k);
        }
        let clean = (x, force);
        let (mut bias, mut error) = ([0.0; 4], [0.0; 4]);
        for seed in 0..30 {
            let fit = least_squares(&(
                noisy(&clean.0, 0.002 * AMPLITUDE, seed),
                noisy(&clean.1, 0.01 * peak, 1000 + seed),
            ));
            assert!(fit.is_reliable(), "{:?}", fit.warnings);
            for k in 0..4 {
                bias[k] += (fit.joint.parameters()[k] - TRUTH[k]) / 30.0;
                error[k] += fit.standard_errors[k] / 30.0;
            }
        }
        println!("bias {bias:.3?} of standard error {error:.3?}");
        assert!(
            (0..4).all(|k| bias[k].abs() < error[k]),
            "{bias:?} {error:?}"
        );
        // More is told.
        let noisier = noisy(&clean.0, 0.006 * AMPLITUDE, 1);
        let warnings = least_squares(&(noisier, clean.1)).warnings;
        let told = |w: &Warning| matches!(w, Warning::NoisyDisplacement(part) if (0.004..0.008).contains(part));
        assert!(warnings.iter().any(told), "{warnings:?}");
    }
}

/// A drive that dwells at its ends, with hardly any noise of the displacement: two corners, which one curve cannot follow.
#[test]
fn noise_of_a_displacement_that_dwells() {
    let truth = [100.0, 0.3, 20.0, 0.0];
    let joint = oracle(truth);
    let ramp = |k: usize| {
        let phase = (k % 500) as f64 / 500.0;
        let triangle = if phase < 0.5 {
            4.0 * phase - 1.0
        } else {
            3.0 - 4.0 * phase
        };
        (
            (1.3 * triangle).clamp(-1.0, 1.0),
            if phase < 0.5 { 1.0 } else { -1.0 },
        )
    };
    let x: Vec<f64> = (0..1500).map(|k| ramp(k).0).collect();
    let force: Vec<f64> = (0..1500)
        .map(|k| masing(&joint, 1.0, ramp(k).0, ramp(k).1))
        .collect();
    for deviation in [1e-4, 1e-3] {
        for seed in 0..5 {
            let fit = least_squares(&(noisy(&x, deviation, seed), noisy(&force, 0.1, 100 + seed)));
            let found = fit.joint.parameters();
            assert!(
                (found[1] / truth[1] - 1.0).abs() < 0.01,
                "{deviation} {found:?}"
            );
            assert!((found[3] - truth[3]).abs() < 0.05, "{deviation} {found:?}");
            let noisy = |w: &Warning| matches!(w, Warning::NoisyDisplacement(_));
            assert!(!fit.warnings.iter().any(noisy), "{:?}", fit.warnings);
        }
    }
}

/// Numbers whose squares are none, and walks that no joint made: an error, or a fit that says what it is worth.
#[test]
fn odd_records_are_never_trusted() {
    let (x, force) = loops(TRUTH, AMPLITUDE, 50, 1, Sampling::Uniform);
    for factor in [1e-200, 1e200] {
        let huge: Vec<f64> = force.iter().map(|f| f * factor).collect();
        let message = Record::new(&x, &huge).unwrap_err().to_string();
        assert!(message.contains("force: the largest value"), "{message}");
        let far: Vec<f64> = x.iter().map(|x| x * factor).collect();
        assert!(Record::new(&far, &force).is_err());
    }
    let mut random = fastrand::Rng::with_seed(17).fork();
    for _ in 0..2000 {
        let length = random.usize(0..60);
        let mut walk = || {
            let steps = (0..length).map(|_| random.f64() - 0.5);
            let places = steps.scan(0.0, |at, step| {
                *at += step;
                Some(*at)
            });
            places.collect::<Vec<f64>>()
        };
        let (x, force) = (walk(), walk());
        let Ok(record) = Record::new(&x, &force) else {
            continue;
        };
        let _ = record.paper(PAPER_TOLERANCE);
        if let Ok(fit) = record.least_squares()
            && fit.is_reliable()
        {
            let found = fit.joint.parameters();
            let known = |k: usize| fit.standard_errors[k] <= found[k];
            assert!(known(0) && known(1), "{found:?} {:?}", fit.standard_errors);
        }
    }
}

/// A spring and a dashpot: an ellipse, which the model resembles with huge friction that a negative stiffness takes back.
#[test]
fn a_viscous_loop_is_no_joint() {
    for damping in [0.01, 0.1, 0.3, 1.0] {
        for stiffness in [0.0, 1.0] {
            let angle = |k: i32| f64::from(k) * PI / 100.0;
            let x: Vec<f64> = (0..=400).map(|k| angle(k).sin()).collect();
            let force = (0..=400).map(|k| stiffness * angle(k).sin() + damping * angle(k).cos());
            let fit = least_squares(&(x, force.collect()));
            assert!(!fit.is_reliable(), "{damping} {stiffness} {:?}", fit.joint);
        }
    }
}

#[test]
fn a_loop_that_turns_the_wrong_way_is_refused() {
    let (mut x, mut force) = loops(TRUTH, AMPLITUDE, 100, 2, Sampling::Uniform);
    x.reverse();
    force.reverse();
    let message = Record::new(&x, &force).unwrap_err().to_string();
    assert!(message.contains("turns the wrong way"), "{message}");
}

#[test]
fn the_end_of_the_search_is_told() {
    let truth = [266.78, 0.0041, 100.0, 0.0];
    let fit = least_squares(&loops(truth, 8.0, 2000, 1, Sampling::Sinusoidal));
    let at_bound = |w: &Warning| matches!(w, Warning::DisplacementAtBound(_));
    assert!(fit.warnings.iter().any(at_bound), "{:?}", fit.warnings);
}

/// What a real record has besides noise: first loading, a mean, a record that ends half way, a larger number of points here than
/// there.
#[test]
fn offsets_and_partial_branches() {
    let joint = oracle(TRUTH);
    let steady = loops(TRUTH, AMPLITUDE, 150, 2, Sampling::Sinusoidal);
    let first = (0..100).map(|k| AMPLITUDE * f64::from(k) / 100.0);
    let mut data: (Vec<f64>, Vec<f64>) = first.map(|x| (x, joint.peak_force(x))).unzip();
    // From the first peak on: the unloading branch of the first cycle, all of the second, a third of one more loading.
    data.0.extend(&steady.0[150..]);
    data.1.extend(&steady.1[150..]);
    data.0.extend(&steady.0[..50]);
    data.1.extend(&steady.1[..50]);
    let moved = (
        data.0.iter().map(|x| x - 3.0).collect(),
        data.1.iter().map(|f| f + 1000.0).collect(),
    );
    let fit = least_squares(&moved);
    assert_recovered(&fit, TRUTH, 1e-6);
    assert!((fit.offset - 1000.0).abs() < 1e-3, "{}", fit.offset);
    let record = Record::new(&moved.0, &moved.1).expect("a loop");
    assert_eq!(record.branches.len(), 4);
    assert!((record.centre + 3.0).abs() < 1e-12);
    let area = joint.cycle_dissipation(AMPLITUDE);
    assert!((record.loop_area() / area - 1.0).abs() < 1e-2);
}

/// chi from 1 (bilinear) to 5, X_s from a twentieth of the amplitude to nearly all of it, any units.
#[test]
fn every_corner_is_found() {
    for kappa in [-1.5, -1.2, 0.0, 2.5] {
        for displacement in [0.05, 0.3, 0.8] {
            for residual in [0.0, 0.5] {
                for unit in [1e-6, 1.0, 1e9] {
                    let truth = [2.0 * unit, displacement, residual * unit, kappa];
                    let data = loops(truth, 1.0, 200, 1, Sampling::Sinusoidal);
                    let fit = least_squares(&data);
                    for (k, (value, exact)) in
                        fit.joint.parameters().into_iter().zip(truth).enumerate()
                    {
                        let scale = [2.0 * unit, displacement, unit, 1.0][k];
                        assert!(
                            (value - exact).abs() < 1e-5 * scale,
                            "{truth:?} {:?}",
                            fit.joint
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_linear_spring_is_no_joint() {
    let x: Vec<f64> = (0..=400)
        .map(|k| -(f64::from(k) * PI / 100.0).cos())
        .collect();
    let spring: Vec<f64> = x.iter().map(|x| 5.0 * x).collect();
    // The work of each cycle is put in, not taken out.
    let backwards: Vec<f64> = (0..=400)
        .map(|k| -(f64::from(k) * PI / 100.0 - 0.3).cos())
        .collect();
    for force in [spring, backwards] {
        let outcome = Record::new(&x, &force).and_then(|r| r.least_squares());
        assert!(
            outcome.is_err() || outcome.as_ref().is_ok_and(|fit| !fit.is_reliable()),
            "{outcome:?}"
        );
    }
}

/// The C entries, called as C does.
mod c_interface {
    use super::*;
    use mepc::ffi::iwan::{mepc_iwan_force, mepc_iwan_identify};
    use std::ptr::{null, null_mut};

    /// Status, parameters, standard errors and misfit.
    fn identify(data: &(Vec<f64>, Vec<f64>), method: i32) -> (i32, [f64; 4], [f64; 4], f64) {
        let (mut parameters, mut errors, mut misfit) = ([-1.0; 4], [-1.0; 4], -1.0);
        // SAFETY: arrays of the documented sizes.
        let status = unsafe {
            mepc_iwan_identify(
                data.0.len() as i64,
                data.0.as_ptr(),
                data.1.as_ptr(),
                method,
                parameters.as_mut_ptr(),
                errors.as_mut_ptr(),
                &raw mut misfit,
            )
        };
        (status, parameters, errors, misfit)
    }

    #[test]
    fn force_then_identification() {
        let data = loops(TRUTH, AMPLITUDE, 200, 1, Sampling::Uniform);
        let branch: Vec<i8> = (0..400).map(|k| if k < 200 { 1 } else { -1 }).collect();
        let mut force = vec![0.0; 400];
        // SAFETY: 400 numbers each.
        let status = unsafe {
            mepc_iwan_force(
                TRUTH.as_ptr(),
                AMPLITUDE,
                400,
                data.0.as_ptr(),
                branch.as_ptr(),
                force.as_mut_ptr(),
            )
        };
        assert_eq!(status, 0);
        for (f, exact) in force.iter().zip(&data.1) {
            assert!((f - exact).abs() < 1e-10, "{f} {exact}");
        }
        for (method, part) in [(0, 1e-3), (1, 0.15)] {
            let (status, parameters, errors, misfit) = identify(&data, method);
            assert_eq!(status, 0);
            assert!((0.0..0.02).contains(&misfit), "{misfit}");
            for k in 0..4 {
                assert!(
                    (parameters[k] / TRUTH[k] - 1.0).abs() < part,
                    "{parameters:?}"
                );
                assert!(
                    errors[k] >= 0.0 && errors[k] < 0.1 * TRUTH[k].abs(),
                    "{errors:?}"
                );
            }
        }
        let size = data.0.len() as i64;
        let mut parameters = [0.0; 4];
        // SAFETY: as above; standard errors are optional.
        let status = unsafe {
            mepc_iwan_identify(
                size,
                data.0.as_ptr(),
                data.1.as_ptr(),
                0,
                parameters.as_mut_ptr(),
                null_mut(),
                null_mut(),
            )
        };
        assert_eq!(status, 0);
    }

    #[test]
    fn bad_calls_write_nothing() {
        let good = loops(TRUTH, AMPLITUDE, 50, 1, Sampling::Uniform);
        let mut broken = good.clone();
        broken.1[7] = f64::NAN;
        let small = loops(TRUTH, 0.5 * TRUTH[1], 200, 1, Sampling::Uniform);
        let few = (good.0[..9].to_vec(), good.1[..9].to_vec());
        for (data, method) in [
            (&broken, 0),
            (&small, 0),
            (&small, 1),
            (&few, 0),
            (&few, 1),
            (&good, 2),
            (&good, -1),
        ] {
            let (status, parameters, errors, misfit) = identify(data, method);
            assert_eq!(status, -4);
            assert_eq!((parameters, errors, misfit), ([-1.0; 4], [-1.0; 4], -1.0));
        }
        let n = good.0.len() as i64;
        let (x, f) = (good.0.as_ptr(), good.1.as_ptr());
        let mut out = [7.0; 100];
        let o = out.as_mut_ptr();
        // SAFETY: null pointers are what is tested; the others are as long as said.
        unsafe {
            assert_eq!(
                mepc_iwan_identify(n, null(), f, 0, o, null_mut(), null_mut()),
                -1
            );
            assert_eq!(
                mepc_iwan_identify(n, x, null(), 0, o, null_mut(), null_mut()),
                -1
            );
            assert_eq!(
                mepc_iwan_identify(n, x, f, 0, null_mut(), null_mut(), null_mut()),
                -1
            );
            assert_eq!(
                mepc_iwan_identify(-1, x, f, 0, o, null_mut(), null_mut()),
                -4
            );
            let up = [1i8; 100];
            let b = up.as_ptr();
            let p = TRUTH.as_ptr();
            assert_eq!(mepc_iwan_force(null(), 1.0, n, x, b, o), -1);
            assert_eq!(mepc_iwan_force(p, 1.0, n, null(), b, o), -1);
            assert_eq!(mepc_iwan_force(p, 1.0, n, x, null(), o), -1);
            assert_eq!(mepc_iwan_force(p, 1.0, n, x, b, null_mut()), -1);
            assert_eq!(mepc_iwan_force(p, -1.0, n, x, b, o), -4);
            assert_eq!(mepc_iwan_force(p, f64::NAN, n, x, b, o), -4);
            assert_eq!(mepc_iwan_force(p, 1.0, -1, x, b, o), -4);
            let mut wrong = up;
            wrong[3] = 0;
            assert_eq!(mepc_iwan_force(p, 1.0, n, x, wrong.as_ptr(), o), -4);
            for (k, bad) in [
                (0, 0.0),
                (1, -1.0),
                (2, f64::INFINITY),
                (3, -1.6),
                (3, f64::NAN),
            ] {
                let mut params = TRUTH;
                params[k] = bad;
                assert_eq!(mepc_iwan_force(params.as_ptr(), 1.0, n, x, b, o), -2);
            }
            assert_eq!(mepc_iwan_force(p, 1.0, 0, x, b, o), 0);
        }
        assert_eq!(out, [7.0; 100]);
    }
}

const C_PROGRAM: &str = r#"
#include <stdio.h>
#include "mepc.h"

int main(void)
{
    const double joint[4] = {266.78, 0.0041, 3280.7, -0.842};
    double x[400], force[400], found[4], errors[4], misfit;
    int8_t branch[400];
    for (int i = 0; i < 400; ++i) {
        branch[i] = i < 200 ? 1 : -1;
        x[i] = branch[i] * 0.02 * (2.0 * (i % 200) / 199.0 - 1.0);
    }
    if (mepc_iwan_force(joint, 0.02, 400, x, branch, force) != 0 ||
        mepc_iwan_identify(400, x, force, 0, found, errors, &misfit) != 0) {
        fprintf(stderr, "%s\n", mepc_last_error());
        return 1;
    }
    printf("%.15g %.15g %.15g %.15g\n", found[0], found[1], found[2], found[3]);
    return 0;
}
"#;

const FORTRAN_PROGRAM: &str = r#"
program joint
    use, intrinsic :: iso_c_binding, only: c_double, c_int8_t, c_int64_t
    use mepc
    implicit none
    real(c_double), parameter :: truth(4) = [266.78d0, 0.0041d0, 3280.7d0, -0.842d0]
    integer(c_int64_t), parameter :: n = 400
    real(c_double) :: x(n), force(n), found(4), errors(4), misfit
    integer(c_int8_t) :: branch(n)
    integer :: i

    branch(:200) = 1_c_int8_t
    branch(201:) = -1_c_int8_t
    do i = 0, 399
        x(i + 1) = branch(i + 1) * 0.02d0 * (2d0 * mod(i, 200) / 199d0 - 1d0)
    end do
    if (mepc_iwan_force(truth, 0.02d0, n, x, branch, force) /= 0) error stop mepc_last_error()
    if (mepc_iwan_identify(n, x, force, 0, found, errors, misfit) /= 0) error stop mepc_last_error()
    force(301:) = force(301:) + 50d0
    if (mepc_iwan_identify(n, x, force, 0, found, errors, misfit) /= mepc_not_described) error stop "not described"
    force(301:) = force(301:) - 50d0
    if (mepc_iwan_identify(n, x, force, 0, found) /= 0) error stop "errors are optional"
    print "(4es24.16)", found
end program
"#;

#[test]
fn from_c_and_fortran() {
    let c = source("iwan", "joint.c", C_PROGRAM);
    let fortran = source("iwan", "joint.f90", FORTRAN_PROGRAM);
    let module = in_repository("include/mepc.f90");
    let outputs = [
        compile_and_run("cc", &STRICT_C, &[c]),
        compile_and_run("gfortran", &STRICT_FORTRAN, &[module, fortran]),
    ];
    for output in outputs {
        let found: Vec<f64> = output
            .split_whitespace()
            .map(|f| f.parse().expect(f))
            .collect();
        assert_eq!(found.len(), 4);
        for (value, exact) in found.iter().zip(TRUTH) {
            assert!((value / exact - 1.0).abs() < 1e-3, "{value} {exact}");
        }
    }
}
