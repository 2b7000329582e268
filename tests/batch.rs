//! Batches of the built shared library: the same as point by point, for any number of threads.

mod support;

use std::ptr::{null, null_mut};
use support::native::*;
use support::state_size;

/// Arrays of a batch of points in the middle of their histories.
struct Batch {
    law: NativeLaw,
    n: usize,
    slip: Vec<f64>,
    opening: Vec<f64>,
    pressure: Vec<f64>,
    mu_factor: Vec<f64>,
    state0: Vec<f64>,
}

/// What a batch gives: all outputs in one row, and the statuses.
type BatchOutputs = (i32, Vec<Vec<f64>>, Vec<i32>);

fn all(outputs: &[Watched]) -> Vec<Vec<f64>> {
    let values = outputs.iter().map(|output| output.values().to_vec());
    values.collect()
}

impl Batch {
    fn new(ndir: usize, n: usize) -> Self {
        let law = NativeLaw::with_state_size(&props(), ndir, state_size(ndir, 4));
        let mut random = fastrand::Rng::with_seed(302);
        let mut batch = Batch {
            law,
            n,
            slip: Vec::new(),
            opening: Vec::new(),
            pressure: Vec::new(),
            mu_factor: (0..n).map(|k| 1.0 + 0.25 * (k % 3) as f64).collect(),
            state0: Vec::new(),
        };
        for k in 0..n {
            let mut history = if k % 2 == 0 {
                random_inputs(&mut random, ndir, 7)
            } else {
                // Ever smaller reversals, more than the state can hold.
                let spiral = |k| (vec![0.003 * (-0.7f64).powi(k); ndir], 40.0);
                (0..7).map(spiral).collect()
            };
            let (slip, pressure) = history.pop().expect("seven steps");
            let mut state = vec![0.0; batch.law.nstate];
            for (slip, pressure) in history {
                assert!(batch.law.friction(&slip, pressure, &mut state).status >= 0);
            }
            batch.opening.push(-0.01 * random.f64());
            batch.opening.extend(&slip);
            batch.slip.extend(slip);
            batch.pressure.push(pressure);
            batch.state0.extend(state);
        }
        batch
    }

    fn friction(&self, threads: i32) -> BatchOutputs {
        let n = self.law.ndir;
        let mut outputs = [self.law.nstate, n, n * n, n, 2].map(|len| Watched::new(len * self.n));
        let mut statuses = vec![99; self.n];
        let [state1, traction, dslip, dpressure, energy] = outputs.each_mut().map(Watched::pointer);
        // SAFETY: arrays for n points, of the documented sizes.
        let worst = unsafe {
            (native().mepc_friction_batch)(
                self.law.pointer,
                self.n as i64,
                self.slip.as_ptr(),
                self.pressure.as_ptr(),
                self.mu_factor.as_ptr(),
                self.state0.as_ptr(),
                state1,
                traction,
                dslip,
                dpressure,
                energy,
                statuses.as_mut_ptr(),
                threads,
            )
        };
        (worst, all(&outputs), statuses)
    }

    fn interface(&self, threads: i32) -> BatchOutputs {
        let n = 1 + self.law.ndir;
        let mut outputs = [self.law.nstate, n, n * n, 2].map(|len| Watched::new(len * self.n));
        let mut statuses = vec![99; self.n];
        let [state1, traction, tangent, energy] = outputs.each_mut().map(Watched::pointer);
        // SAFETY: arrays for n points, of the documented sizes.
        let worst = unsafe {
            (native().mepc_interface_batch)(
                self.law.pointer,
                self.n as i64,
                self.opening.as_ptr(),
                self.mu_factor.as_ptr(),
                self.state0.as_ptr(),
                state1,
                traction,
                tangent,
                energy,
                statuses.as_mut_ptr(),
                threads,
            )
        };
        (worst, all(&outputs), statuses)
    }

    /// The same, point by point.
    fn one_by_one(&self, interface: bool) -> BatchOutputs {
        let count = if interface { 4 } else { 5 };
        let (mut worst, mut outputs, mut statuses) = (0, vec![Vec::new(); count], Vec::new());
        for k in 0..self.n {
            let (nstate, ndir) = (self.law.nstate, self.law.ndir);
            let state0 = &self.state0[k * nstate..][..nstate];
            let (status, values) = if interface {
                let mut call = InterfaceCall::new(
                    &self.law,
                    &self.opening[k * (1 + ndir)..][..1 + ndir],
                    state0,
                );
                call.mu_factor = Some(self.mu_factor[k]);
                (call.call(), call.values())
            } else {
                let slip = &self.slip[k * ndir..][..ndir];
                let mut call = FrictionCall::new(&self.law, slip, self.pressure[k], state0);
                call.mu_factor = Some(self.mu_factor[k]);
                (call.call(), call.values())
            };
            for (all, values) in outputs.iter_mut().zip(values) {
                all.extend(values);
            }
            statuses.push(status);
            // The most negative, else the largest.
            worst = if status < 0 || worst < 0 {
                worst.min(status)
            } else {
                worst.max(status)
            };
        }
        (worst, outputs, statuses)
    }

    /// Both forms with several numbers of threads against point by point.
    fn compare(&self) -> [BatchOutputs; 2] {
        let expected = [self.one_by_one(false), self.one_by_one(true)];
        for threads in [1, 2, 0, 3, 64] {
            assert!(
                self.friction(threads) == expected[0],
                "friction form, {threads} threads"
            );
            assert!(
                self.interface(threads) == expected[1],
                "interface form, {threads} threads"
            );
        }
        expected
    }
}

#[test]
fn a_batch_is_its_points_whatever_the_number_of_threads() {
    for ndir in [1, 2] {
        // Enough points for several threads when the library chooses, and fewer points than threads.
        for n in [1500, 3, 1] {
            let [(worst, _, statuses), _] = Batch::new(ndir, n).compare();
            assert!(worst >= 0);
            if n == 1500 {
                assert!(statuses.contains(&0) && statuses.contains(&MEMORY_FULL));
                assert_eq!(worst, MEMORY_FULL);
            }
        }
    }
}

#[test]
fn a_batch_returns_the_worst_status_and_leaves_failed_points_alone() {
    for ndir in [1, 2] {
        let mut batch = Batch::new(ndir, 700);
        let nstate = batch.law.nstate;
        batch.state0[300 * nstate + 10] = 0.5; // -3
        batch.state0[600 * nstate + 10] = 0.5; // in another thread's share
        let [(worst, _, statuses), (interface_worst, ..)] = batch.compare();
        assert_eq!((worst, interface_worst), (BAD_STATE, BAD_STATE));
        assert_eq!(
            statuses
                .iter()
                .filter(|status| **status == BAD_STATE)
                .count(),
            2
        );
        batch.friction(2);
        assert!(
            last_error().contains("point 300") && last_error().contains("Knots"),
            "{}",
            last_error()
        );

        batch.slip[650 * ndir] = f64::NAN; // -4
        batch.opening[650 * (1 + ndir)] = f64::NAN;
        let [(worst, ..), (interface_worst, ..)] = batch.compare();
        assert_eq!((worst, interface_worst), (BAD_INPUT, BAD_INPUT));
        batch.friction(0);
        assert!(last_error().contains("point 650"), "{}", last_error());
        batch.interface(3);
        assert!(last_error().contains("point 650"), "{}", last_error());
    }
}

#[test]
fn batch_sizes_and_null_rules() {
    let batch = Batch::new(2, 5);
    let (law, nstate) = (batch.law.pointer, batch.law.nstate);
    let mut outputs = [5 * nstate, 15, 10, 45, 10].map(Watched::new);
    let [state1, traction, ..] = outputs.each_mut().map(Watched::pointer);
    let friction = |law, n, slip, pressure, state0, state1, traction, threads| {
        // SAFETY: arrays of the documented sizes, or NULL.
        unsafe {
            (native().mepc_friction_batch)(
                law,
                n,
                slip,
                pressure,
                null(),
                state0,
                state1,
                traction,
                null_mut(),
                null_mut(),
                null_mut(),
                null_mut(),
                threads,
            )
        }
    };
    let interface = |law, n, opening, state0, state1, traction, threads| {
        // SAFETY: arrays of the documented sizes, or NULL.
        unsafe {
            (native().mepc_interface_batch)(
                law,
                n,
                opening,
                null(),
                state0,
                state1,
                traction,
                null_mut(),
                null_mut(),
                null_mut(),
                threads,
            )
        }
    };
    let (slip, pressure, opening) = (
        batch.slip.as_ptr(),
        batch.pressure.as_ptr(),
        batch.opening.as_ptr(),
    );
    let state0 = batch.state0.as_ptr();
    let refused = |status: i32, expected: i32, words: &str| {
        assert_eq!(status, expected, "{words}");
        assert!(last_error().contains(words), "{words}: {}", last_error());
    };
    refused(
        friction(null_mut(), 5, slip, pressure, state0, state1, traction, 1),
        NULL_POINTER,
        "law",
    );
    refused(
        friction(law, 5, null(), pressure, state0, state1, traction, 1),
        NULL_POINTER,
        "slip_increment",
    );
    refused(
        friction(law, 5, slip, null(), state0, state1, traction, 1),
        NULL_POINTER,
        "pressure",
    );
    refused(
        friction(law, 5, slip, pressure, null(), state1, traction, 1),
        NULL_POINTER,
        "state0",
    );
    refused(
        friction(law, 5, slip, pressure, state0, null_mut(), traction, 1),
        NULL_POINTER,
        "state1",
    );
    refused(
        friction(law, 5, slip, pressure, state0, state1, null_mut(), 1),
        NULL_POINTER,
        "traction",
    );
    refused(
        friction(law, -1, slip, pressure, state0, state1, traction, 1),
        BAD_INPUT,
        "n = -1",
    );
    refused(
        friction(law, i64::MAX, slip, pressure, state0, state1, traction, 1),
        BAD_INPUT,
        "n = ",
    );
    refused(
        friction(law, 5, slip, pressure, state0, state1, traction, -1),
        BAD_INPUT,
        "threads = -1",
    );
    refused(
        interface(null_mut(), 5, opening, state0, state1, traction, 1),
        NULL_POINTER,
        "law",
    );
    refused(
        interface(law, 5, null(), state0, state1, traction, 1),
        NULL_POINTER,
        "opening",
    );
    refused(
        interface(law, 5, opening, null(), state1, traction, 1),
        NULL_POINTER,
        "state0",
    );
    refused(
        interface(law, 5, opening, state0, null_mut(), traction, 1),
        NULL_POINTER,
        "state1",
    );
    refused(
        interface(law, 5, opening, state0, state1, null_mut(), 1),
        NULL_POINTER,
        "traction",
    );
    refused(
        interface(law, -7, opening, state0, state1, traction, 1),
        BAD_INPUT,
        "n = -7",
    );
    refused(
        interface(law, 5, opening, state0, state1, traction, -2),
        BAD_INPUT,
        "threads = -2",
    );
    // No points: nothing to do, and nothing needed.
    assert_eq!(
        friction(law, 0, null(), null(), null(), null_mut(), null_mut(), 0),
        0
    );
    assert_eq!(
        interface(law, 0, null(), null(), null_mut(), null_mut(), 0),
        0
    );
    assert!(outputs.iter().all(Watched::untouched));
    // Without factors and the optional outputs the required ones are the same.
    let mut batch = batch;
    batch.mu_factor.fill(1.0);
    let [state1, traction, ..] = outputs.each_mut().map(Watched::pointer);
    assert_eq!(
        friction(law, 5, slip, pressure, state0, state1, traction, 1),
        batch.one_by_one(false).0
    );
    let (_, expected, _) = batch.one_by_one(false);
    assert_eq!(outputs[0].values(), expected[0]);
    assert_eq!(outputs[1].values()[..10], expected[1][..]);
}

/// Histories of several points, increment after increment.
struct Histories {
    law: NativeLaw,
    points: usize,
    n: usize,
    slip: Vec<f64>,
    pressure: Vec<f64>,
    mu_factor: Vec<f64>,
}

/// State, traction, tangents, energies of histories, and the statuses of their points.
type HistoryOutputs = (i32, Vec<Vec<f64>>, Vec<i32>);

impl Histories {
    fn new(ndir: usize, points: usize, n: usize) -> Self {
        let law = NativeLaw::new(&props(), ndir);
        let mut random = fastrand::Rng::with_seed(304);
        let inputs = random_inputs(&mut random, ndir, points * n);
        let (slip, pressure): (Vec<_>, Vec<_>) = inputs.into_iter().unzip();
        Histories {
            law,
            points,
            n,
            slip: slip.concat(),
            pressure,
            mu_factor: (0..points * n).map(|_| 0.5 + random.f64()).collect(),
        }
    }

    /// State, then traction, dtraction_dslip, dtraction_dpressure, energy, for virgin points.
    fn outputs(&self) -> [Watched; 5] {
        let (d, rows) = (self.law.ndir, self.points * self.n);
        let mut outputs = [
            self.points * self.law.nstate,
            d * rows,
            d * d * rows,
            d * rows,
            2 * rows,
        ]
        .map(Watched::new);
        outputs[0].fill(0.0);
        outputs
    }

    fn batch(&self, threads: i32) -> HistoryOutputs {
        let mut outputs = self.outputs();
        let mut statuses = vec![99; self.points];
        let [state, traction, dslip, dpressure, energy] = outputs.each_mut().map(Watched::pointer);
        // SAFETY: arrays of the documented sizes.
        let worst = unsafe {
            (native().mepc_friction_history_batch)(
                self.law.pointer,
                self.points as i64,
                self.n as i64,
                self.slip.as_ptr(),
                self.pressure.as_ptr(),
                self.mu_factor.as_ptr(),
                state,
                traction,
                dslip,
                dpressure,
                energy,
                statuses.as_mut_ptr(),
                threads,
            )
        };
        (worst, all(&outputs), statuses)
    }

    /// The history of point `k`.
    fn history(&self, k: usize) -> HistoryOutputs {
        let (d, n) = (self.law.ndir, self.n);
        let one = Histories {
            law: NativeLaw::new(&props(), d),
            points: 1,
            n,
            slip: self.slip[k * n * d..][..n * d].to_vec(),
            pressure: self.pressure[k * n..][..n].to_vec(),
            mu_factor: self.mu_factor[k * n..][..n].to_vec(),
        };
        let mut outputs = one.outputs();
        let [state, traction, dslip, dpressure, energy] = outputs.each_mut().map(Watched::pointer);
        // SAFETY: arrays of the documented sizes.
        let status = unsafe {
            (native().mepc_friction_history)(
                one.law.pointer,
                n as i64,
                one.slip.as_ptr(),
                one.pressure.as_ptr(),
                one.mu_factor.as_ptr(),
                state,
                traction,
                dslip,
                dpressure,
                energy,
            )
        };
        (status, all(&outputs), vec![status])
    }

    /// The same, one call an increment.
    fn one_by_one(&self) -> HistoryOutputs {
        let (d, nstate) = (self.law.ndir, self.law.nstate);
        let mut outputs = all(&self.outputs());
        let mut statuses = Vec::new();
        for k in 0..self.points {
            let mut state = vec![0.0; nstate];
            let mut status = 0;
            for row in k * self.n..(k + 1) * self.n {
                let slip = &self.slip[row * d..][..d];
                let mut call = FrictionCall::new(&self.law, slip, self.pressure[row], &state);
                call.mu_factor = Some(self.mu_factor[row]);
                let now = call.call();
                if now < 0 {
                    status = now;
                    break;
                }
                status = status.max(now);
                let values = call.values();
                for (all, values) in outputs.iter_mut().zip(&values).skip(1) {
                    all[row * values.len()..][..values.len()].copy_from_slice(values);
                }
                state = values[0].clone();
            }
            outputs[0][k * nstate..][..nstate].copy_from_slice(&state);
            statuses.push(status);
        }
        let worst = statuses.iter().copied().reduce(|worst, status| {
            if status < 0 || worst < 0 {
                worst.min(status)
            } else {
                worst.max(status)
            }
        });
        (worst.unwrap_or(0), outputs, statuses)
    }
}

#[test]
fn a_history_is_its_increments_whatever_the_number_of_threads() {
    for ndir in [1, 2] {
        let mut histories = Histories::new(ndir, 400, 12);
        // A point whose history stops in the middle, and one whose history stops at once.
        histories.pressure[7 * 12 + 5] = f64::NAN;
        histories.mu_factor[300 * 12] = -1.0;
        let expected = histories.one_by_one();
        assert_eq!(expected.0, BAD_INPUT);
        let stopped: Vec<usize> = (0..400).filter(|k| expected.2[*k] < 0).collect();
        assert_eq!(stopped, [7, 300]);
        for threads in [1, 0, 2, 64] {
            assert!(histories.batch(threads) == expected, "{threads} threads");
            assert!(
                last_error().contains("point 7: increment 5: pressure = NaN"),
                "{}",
                last_error()
            );
        }
        for k in [0, 7, 300] {
            let (status, outputs, _) = histories.history(k);
            assert_eq!(status, expected.2[k]);
            for (one, all) in outputs.iter().zip(&expected.1) {
                assert!(one[..] == all[k * one.len()..][..one.len()]);
            }
        }
        assert!(
            last_error().contains("increment 0: mu_factor = -1"),
            "{}",
            last_error()
        );
    }
}

#[test]
fn history_sizes_and_null_rules() {
    let histories = Histories::new(2, 3, 4);
    let (law, n) = (histories.law.pointer, histories.n as i64);
    let (slip, pressure) = (histories.slip.as_ptr(), histories.pressure.as_ptr());
    let mut outputs = histories.outputs();
    let [state, traction, ..] = outputs.each_mut().map(Watched::pointer);
    let history = |law, n, slip, pressure, state, traction| {
        let none = null_mut;
        // SAFETY: arrays of the documented sizes, or NULL.
        unsafe {
            (native().mepc_friction_history)(
                law,
                n,
                slip,
                pressure,
                null(),
                state,
                traction,
                none(),
                none(),
                none(),
            )
        }
    };
    let batch = |law, points, n, slip, pressure, state, traction, threads| {
        let none = null_mut;
        // SAFETY: arrays of the documented sizes, or NULL.
        unsafe {
            (native().mepc_friction_history_batch)(
                law,
                points,
                n,
                slip,
                pressure,
                null(),
                state,
                traction,
                none(),
                none(),
                none(),
                null_mut(),
                threads,
            )
        }
    };
    let refused = |status: i32, expected: i32, words: &str| {
        assert_eq!(status, expected, "{words}");
        assert!(last_error().contains(words), "{words}: {}", last_error());
    };
    for (arguments, words) in [
        ((null_mut(), slip, pressure, state, traction), "law"),
        ((law, null(), pressure, state, traction), "slip_increment"),
        ((law, slip, null(), state, traction), "pressure"),
        ((law, slip, pressure, null_mut(), traction), "state"),
        ((law, slip, pressure, state, null_mut()), "traction"),
    ] {
        let (law, slip, pressure, state, traction) = arguments;
        refused(
            history(law, n, slip, pressure, state, traction),
            NULL_POINTER,
            words,
        );
        refused(
            batch(law, 3, n, slip, pressure, state, traction, 1),
            NULL_POINTER,
            words,
        );
    }
    refused(
        history(law, -1, slip, pressure, state, traction),
        BAD_INPUT,
        "n = -1",
    );
    refused(
        history(law, i64::MAX, slip, pressure, state, traction),
        BAD_INPUT,
        "n = ",
    );
    refused(
        batch(law, -2, n, slip, pressure, state, traction, 1),
        BAD_INPUT,
        "npoints = -2",
    );
    refused(
        batch(law, 3, -2, slip, pressure, state, traction, 1),
        BAD_INPUT,
        "n = -2",
    );
    refused(
        batch(law, 3, i64::MAX, slip, pressure, state, traction, 1),
        BAD_INPUT,
        "n = ",
    );
    refused(
        batch(law, 1 << 40, 1 << 30, slip, pressure, state, traction, 1),
        BAD_INPUT,
        "npoints",
    );
    refused(
        batch(law, 3, n, slip, pressure, state, traction, -1),
        BAD_INPUT,
        "threads = -1",
    );
    assert!(outputs[1..].iter().all(Watched::untouched));
    // No increments, or no points: nothing to do, and nothing needed.
    assert_eq!(history(law, 0, null(), null(), null_mut(), null_mut()), 0);
    assert_eq!(
        batch(law, 0, n, null(), null(), null_mut(), null_mut(), 0),
        0
    );
    // Without the optional outputs the required ones are the same.
    let mut plain = Histories::new(2, 3, 4);
    plain.mu_factor.fill(1.0);
    let (worst, expected, _) = plain.one_by_one();
    assert_eq!(batch(law, 3, n, slip, pressure, state, traction, 2), worst);
    assert_eq!(outputs[0].values(), expected[0]);
    assert_eq!(outputs[1].values(), expected[1]);
}
