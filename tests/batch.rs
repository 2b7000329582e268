//! Batches of the built shared library: the same as point by point, for any number of threads.

mod support;

use std::ptr::{null, null_mut};
use support::least_state;
use support::native::*;

/// Arrays of a batch of points in the middle of their histories.
struct Batch {
    law: NativeLaw,
    n: usize,
    slip: Vec<f64>,
    opening: Vec<f64>,
    pressure: Vec<f64>,
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
        let law = NativeLaw::with_state_size(&props(), ndir, least_state(ndir, [1, 16][ndir - 1]));
        let mut random = fastrand::Rng::with_seed(302);
        let mut batch = Batch {
            law,
            n,
            slip: Vec::new(),
            opening: Vec::new(),
            pressure: Vec::new(),
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
                (call.call(), call.values())
            } else {
                let slip = &self.slip[k * ndir..][..ndir];
                let mut call = FrictionCall::new(&self.law, slip, self.pressure[k], state0);
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
        batch.state0[300 * nstate + 7] = 0.5; // -3
        batch.state0[600 * nstate + 7] = 0.5; // in another thread's share
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
            last_error().contains("point 300") && last_error().contains("FloatingKnots"),
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
    // Without the optional outputs the required ones are the same.
    let [state1, traction, ..] = outputs.each_mut().map(Watched::pointer);
    assert_eq!(
        friction(law, 5, slip, pressure, state0, state1, traction, 1),
        batch.one_by_one(false).0
    );
    let (_, expected, _) = batch.one_by_one(false);
    assert_eq!(outputs[0].values(), expected[0]);
    assert_eq!(outputs[1].values()[..10], expected[1][..]);
}
