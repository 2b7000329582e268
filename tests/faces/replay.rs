//! The vectors of tests/vectors through every face, beside the native interface.

use crate::fortran::{NORMAL_STIFFNESS, POINTS, caller, numbers};
use crate::mfront::{CONSISTENT, Hypothesis, Point};
use crate::support::native::NativeLaw;
use crate::support::vectors::{VectorFile, all};
use crate::support::with;
use std::fmt::Write;

/// Largest difference in the traction over the limit and in the energies over that times gcr.
const SAME: f64 = 1e-11;
/// The same for routines whose memory has directions of its own, on paths that turn: their slips are rounded otherwise, and
/// where the memory curve is halved, and what is forgotten, follows the last bits.
const TURNED: f64 = 1e-5;

impl VectorFile {
    /// What the Fortran callers read.
    pub fn input(&self) -> String {
        let mut text = format!(
            "{} {} {} {}\n",
            self.ndir,
            self.nstate,
            self.props.len(),
            self.rows.len()
        );
        let steps = self.rows.iter();
        let steps = steps.map(|row| [row.slip.as_slice(), &[row.pressure]].concat());
        for numbers in std::iter::once(self.props.clone()).chain(steps) {
            for number in numbers {
                write!(text, "{number:e} ").expect("text");
            }
            text.push('\n');
        }
        text
    }

    /// Slips of thousands of gcr cost digits of an increment that is a difference of totals, and gross slip
    /// dissipates in proportion.
    fn longest(&self) -> f64 {
        let slips = self.rows.iter().flat_map(|row| &row.slip);
        slips.fold(1.0, |most: f64, slip| most.max(slip.abs() / self.props[1]))
    }

    /// The native friction form: traction, stored, dissipated so far, d traction/d slip by rows, d traction/d pressure.
    fn friction(&self) -> Vec<Vec<f64>> {
        let law = NativeLaw::with_state_size(&self.props, self.ndir, self.nstate);
        let mut state = vec![0.0; self.nstate];
        let mut before = vec![0.0; self.ndir];
        let rows = self.rows.iter().map(|row| {
            let increment: Vec<f64> = row.slip.iter().zip(&before).map(|(a, b)| a - b).collect();
            before.clone_from(&row.slip);
            let out = law.friction(&increment, row.pressure, &mut state);
            assert!(out.status >= 0, "{}", self.name());
            [
                &out.traction[..],
                &[out.energy[0], state[4]],
                &out.tangent,
                &out.dtraction_dpressure,
            ]
            .concat()
        });
        rows.collect()
    }

    /// The native interface form: pressure, traction, stored, dissipated so far, d traction/d opening by rows.
    ///
    /// `total` makes the tangential jump of a step from that of the step before, and from the slip before and now. The
    /// faces add and subtract in different orders, and where a loop closes to the last bit the tangent jumps: so the
    /// reference does the same sums.
    /// The stored energy is that of friction, and of the normal spring where a face reports it (`spring`).
    fn interface(&self, spring: bool, total: impl Fn(f64, f64, f64) -> f64) -> Vec<Vec<f64>> {
        let props = with(&self.props, 7, NORMAL_STIFFNESS);
        let law = NativeLaw::with_state_size(&props, self.ndir, self.nstate);
        let mut state = vec![0.0; self.nstate];
        let (mut before, mut at) = (vec![0.0; self.ndir], vec![0.0; self.ndir]);
        let rows = self.rows.iter().map(|row| {
            for i in 0..self.ndir {
                at[i] = total(at[i], before[i], row.slip[i]);
            }
            before.clone_from(&row.slip);
            let opening = [&[-row.pressure / NORMAL_STIFFNESS], &at[..]].concat();
            let out = law.interface(&opening, &mut state);
            assert!(out.status >= 0, "{}", self.name());
            [
                &[-out.traction[0]],
                &out.traction[1..],
                &[if spring { out.energy[0] } else { state[3] }, state[4]],
                &out.tangent,
            ]
            .concat()
        });
        rows.collect()
    }

    /// Compares `tractions` numbers, two energies and then stiffnesses (relative to the largest of the history).
    fn compare(&self, face: &str, tractions: usize, found: &[Vec<f64>], expected: &[Vec<f64>]) {
        assert_eq!(found.len(), expected.len(), "{}, {face}: rows", self.name());
        // Without friction there is nothing to divide by.
        let [traction, energy] = [self.limit(), self.energy()].map(|x| x.max(f64::MIN_POSITIVE));
        let stiff = expected
            .iter()
            .flat_map(|row| &row[tractions + 2..])
            .fold(1e-300, |m: f64, x| m.max(x.abs()));
        for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert_eq!(
                found.len(),
                expected.len(),
                "{}, {face}: columns",
                self.name()
            );
            for (column, (a, b)) in found.iter().zip(expected).enumerate() {
                let scale = match column {
                    column if column < tractions => traction,
                    column if column < tractions + 2 => energy,
                    _ => stiff,
                };
                let error = (a - b).abs() / (scale * self.longest());
                let explicit = face.starts_with("vfric") && self.ndir == 2;
                assert!(
                    error <= if explicit { TURNED } else { SAME },
                    "{}, {face}, step {index}, column {column}: {a:e}, native {b:e}",
                    self.name()
                );
            }
        }
    }
}

/// Without the stiffnesses.
fn without_tangent(rows: &[Vec<f64>], tractions: usize) -> Vec<Vec<f64>> {
    rows.iter()
        .map(|row| row[..tractions + 2].to_vec())
        .collect()
}

/// The stiffnesses d traction/d penetration: opening reversed.
fn by_penetration(mut rows: Vec<Vec<f64>>, ndir: usize) -> Vec<Vec<f64>> {
    let n = 1 + ndir;
    for row in &mut rows {
        for i in 1..n {
            row[n + 2 + i * n] *= -1.0;
        }
    }
    rows
}

#[test]
fn every_face_gives_the_same_numbers() {
    let mut behaviours = 0;
    for history in all() {
        let n = history.ndir;
        let input = history.input();
        let friction = history.friction();
        history.compare("fric", n, &numbers(&caller("fric"), &[], &input), &friction);

        let expected = history.interface(false, |_, before, now| before + (now - before));
        for layout in ["0", "1", "2"] {
            if n == 2 || layout == "0" {
                let rows = numbers(&caller("umat"), &[layout], &input);
                history.compare(&format!("umat, layout {layout}"), 1 + n, &rows, &expected);
            }
        }

        let expected = history.interface(true, |at, before, now| at + (now - before));
        let expected = by_penetration(expected, n);
        let rows = numbers(&caller("uinter"), &[], &input);
        history.compare("uinter", 1 + n, &rows, &expected);

        let expected = without_tangent(&friction, n);
        for face in ["vfric", "vfriction"] {
            for directions in ["global", "contact"] {
                let rows = numbers(&caller(face), &[directions], &input);
                for point in 0..POINTS {
                    let rows: Vec<Vec<f64>> =
                        rows.iter().skip(point).step_by(POINTS).cloned().collect();
                    let face = format!("{face}, {directions} directions, point {point}");
                    history.compare(&face, n, &rows, &expected);
                }
            }
        }

        if !can(&history) {
            continue;
        }
        behaviours += 1;
        let expected = history.interface(true, |_, _, now| now);
        let rows = through_behaviour("MemoryPenaltyContact", &history);
        history.compare("MFront, contact", 1 + n, &rows, &expected);
        // The layer's square roots of two round, so its tangent is compared with differences instead (tangent.rs).
        let rows = without_tangent(&through_behaviour("MemoryPenaltyLayer", &history), 1 + n);
        history.compare(
            "MFront, layer",
            1 + n,
            &rows,
            &without_tangent(&expected, 1 + n),
        );
    }
    println!("{behaviours} vectors fit the behaviours");
    assert!(
        behaviours >= 25,
        "only {behaviours} vectors fit the behaviours"
    );
}

/// Whether the behaviours have the properties and the state size of a history.
fn can(history: &VectorFile) -> bool {
    // Of a point: coefficient, critical slip, exponent and reference pressure.
    let mut others = history
        .props
        .iter()
        .enumerate()
        .filter(|(index, _)| ![0, 1, 2, 4].contains(index));
    others.all(|(_, value)| *value == 0.0)
        && history.nstate == Hypothesis::of(history.ndir).states()
}

/// Pressure, traction, energies and tangent of every step, as [`VectorFile::interface`].
fn through_behaviour(name: &str, history: &VectorFile) -> Vec<Vec<f64>> {
    let props = with(&history.props, 7, NORMAL_STIFFNESS);
    let mut point = Point::new(name, Hypothesis::of(history.ndir), &props, 0.25);
    let rows = history.rows.iter().map(|row| {
        let opening = [&[-row.pressure / NORMAL_STIFFNESS], &row.slip[..]].concat();
        let mut numbers = point.step(&opening, CONSISTENT).expect("success");
        numbers[0] = -numbers[0];
        // Which shear is the first one matters for what the state variables are called.
        for (jump, slip) in point.states[0][7..].iter().zip(&row.slip) {
            assert!((jump - slip).abs() <= 1e-14 * slip.abs(), "TangentialJump");
        }
        numbers
    });
    rows.collect()
}
