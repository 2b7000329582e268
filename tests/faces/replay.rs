//! The vectors of tests/vectors through every face, beside the native interface.

use crate::fortran::{NORMAL_STIFFNESS, POINTS, caller, numbers};
use crate::mfront::{CONSISTENT, Hypothesis, Point};
use crate::support::native::NativeLaw;
use crate::support::with;
use std::fmt::Write;

/// Largest difference in the traction over mu p and in the energies over mu p gcr.
const SAME: f64 = 1e-12;

/// A history of the vector directory.
pub struct History {
    pub name: String,
    pub props: Vec<f64>,
    pub nstate: usize,
    pub ndir: usize,
    /// Total slip and pressure at the end of each step.
    pub steps: Vec<(Vec<f64>, f64)>,
}

impl History {
    fn read(text: &str) -> Self {
        let key = |name: &str| {
            let mark = format!("# {name}: ");
            let line = text.lines().find_map(|line| line.strip_prefix(&mark));
            line.unwrap_or_else(|| panic!("no {name}")).to_string()
        };
        let mut rows = text
            .lines()
            .filter(|line| !line.starts_with('#') && !line.is_empty());
        let columns: Vec<&str> = rows.next().expect("a header").split(',').collect();
        let column = |name: &str| columns.iter().position(|column| *column == name);
        let ndir = if column("slip_2").is_some() { 2 } else { 1 };
        let slips: Vec<usize> = (1..=ndir)
            .map(|i| column(&format!("slip_{i}")).expect("a slip"))
            .collect();
        let pressure = column("pressure").expect("a pressure");
        let steps = rows.map(|row| {
            let values: Vec<f64> = row.split(',').map(|x| x.parse().expect(row)).collect();
            (slips.iter().map(|&i| values[i]).collect(), values[pressure])
        });
        History {
            name: key("name"),
            props: key("props")
                .split(',')
                .map(|x| x.parse().expect("a number"))
                .collect(),
            nstate: key("nstate").parse().expect("a size"),
            ndir,
            steps: steps.collect(),
        }
    }

    pub fn all() -> Vec<Self> {
        let mut files: Vec<_> = std::fs::read_dir("tests/vectors")
            .expect("tests/vectors")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
            .collect();
        files.sort();
        let read = |path| Self::read(&std::fs::read_to_string(path).expect("a vector"));
        let all: Vec<Self> = files.iter().map(read).collect();
        assert!(all.len() >= 40, "{} vectors", all.len());
        all
    }

    /// What the Fortran callers read.
    pub fn input(&self) -> String {
        let mut text = format!(
            "{} {} {} {}\n",
            self.ndir,
            self.nstate,
            self.props.len(),
            self.steps.len()
        );
        for numbers in std::iter::once(self.props.clone()).chain(
            self.steps
                .iter()
                .map(|(slip, p)| [slip.as_slice(), &[*p]].concat()),
        ) {
            for number in numbers {
                write!(text, "{number:e} ").expect("text");
            }
            text.push('\n');
        }
        text
    }

    /// mu p, and mu p gcr; never zero.
    fn scales(&self) -> (f64, f64) {
        let pressure = self
            .steps
            .iter()
            .fold(f64::MIN_POSITIVE, |most, (_, p)| most.max(*p));
        let traction = self.props[0].max(f64::MIN_POSITIVE) * pressure;
        (traction, traction * self.props[1])
    }

    /// Slips of thousands of gcr cost digits of an increment that is a difference of totals, and gross slip
    /// dissipates in proportion.
    fn longest(&self) -> f64 {
        let slips = self.steps.iter().flat_map(|(slip, _)| slip);
        slips.fold(1.0, |most: f64, slip| most.max(slip.abs() / self.props[1]))
    }

    /// The native friction form: traction, stored, dissipated so far, d traction/d slip by rows, d traction/d pressure.
    fn friction(&self) -> Vec<Vec<f64>> {
        let law = NativeLaw::with_state_size(&self.props, self.ndir, self.nstate);
        let mut state = vec![0.0; self.nstate];
        let mut before = vec![0.0; self.ndir];
        let rows = self.steps.iter().map(|(slip, pressure)| {
            let increment: Vec<f64> = slip.iter().zip(&before).map(|(a, b)| a - b).collect();
            before.clone_from(slip);
            let out = law.friction(&increment, *pressure, &mut state);
            assert!(out.status >= 0, "{}", self.name);
            [
                &out.traction[..],
                &[out.energy[0], state[3]],
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
    fn interface(&self, total: impl Fn(f64, f64, f64) -> f64) -> Vec<Vec<f64>> {
        let props = with(&self.props, 7, NORMAL_STIFFNESS);
        let law = NativeLaw::with_state_size(&props, self.ndir, self.nstate);
        let mut state = vec![0.0; self.nstate];
        let (mut before, mut at) = (vec![0.0; self.ndir], vec![0.0; self.ndir]);
        let rows = self.steps.iter().map(|(slip, pressure)| {
            for i in 0..self.ndir {
                at[i] = total(at[i], before[i], slip[i]);
            }
            before.clone_from(slip);
            let opening = [&[-pressure / NORMAL_STIFFNESS], &at[..]].concat();
            let out = law.interface(&opening, &mut state);
            assert!(out.status >= 0, "{}", self.name);
            [
                &[-out.traction[0]],
                &out.traction[1..],
                &[out.energy[0], state[3]],
                &out.tangent,
            ]
            .concat()
        });
        rows.collect()
    }

    /// Compares `tractions` numbers, two energies and then stiffnesses (relative to the largest of the history).
    fn compare(&self, face: &str, tractions: usize, found: &[Vec<f64>], expected: &[Vec<f64>]) {
        assert_eq!(found.len(), expected.len(), "{}, {face}: rows", self.name);
        let (traction, energy) = self.scales();
        let stiff = expected
            .iter()
            .flat_map(|row| &row[tractions + 2..])
            .fold(1e-300, |m: f64, x| m.max(x.abs()));
        for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert_eq!(
                found.len(),
                expected.len(),
                "{}, {face}: columns",
                self.name
            );
            for (column, (a, b)) in found.iter().zip(expected).enumerate() {
                let scale = match column {
                    column if column < tractions => traction,
                    column if column < tractions + 2 => energy,
                    _ => stiff,
                };
                let error = (a - b).abs() / (scale * self.longest());
                assert!(
                    error <= SAME,
                    "{}, {face}, step {index}, column {column}: {a:e}, native {b:e}",
                    self.name
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
    for history in History::all() {
        let n = history.ndir;
        let input = history.input();
        let friction = history.friction();
        history.compare("fric", n, &numbers(&caller("fric"), &[], &input), &friction);

        let expected = history.interface(|_, before, now| before + (now - before));
        for layout in ["0", "1", "2"] {
            if n == 2 || layout == "0" {
                let rows = numbers(&caller("umat"), &[layout], &input);
                history.compare(&format!("umat, layout {layout}"), 1 + n, &rows, &expected);
            }
        }

        let expected = by_penetration(history.interface(|at, before, now| at + (now - before)), n);
        let rows = numbers(&caller("uinter"), &[], &input);
        history.compare("uinter", 1 + n, &rows, &expected);

        let expected = without_tangent(&friction, n);
        for face in ["vfric", "vfriction"] {
            let rows = numbers(&caller(face), &[], &input);
            for point in 0..POINTS {
                let rows: Vec<Vec<f64>> =
                    rows.iter().skip(point).step_by(POINTS).cloned().collect();
                history.compare(&format!("{face}, point {point}"), n, &rows, &expected);
            }
        }

        if !can(&history) {
            continue;
        }
        behaviours += 1;
        let expected = history.interface(|_, _, now| now);
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
fn can(history: &History) -> bool {
    let defaults = with(&[1.0, 1.0], 12, 0.0);
    let given = with(&history.props, 12, 0.0);
    given[8..] == defaults[8..] && history.nstate == Hypothesis::of(history.ndir).states()
}

/// Pressure, traction, energies and tangent of every step, as [`History::interface`].
fn through_behaviour(name: &str, history: &History) -> Vec<Vec<f64>> {
    let props = with(&history.props, 7, NORMAL_STIFFNESS);
    let mut point = Point::new(name, Hypothesis::of(history.ndir), &props, 0.25);
    let rows = history.steps.iter().map(|(slip, pressure)| {
        let opening = [&[-pressure / NORMAL_STIFFNESS], &slip[..]].concat();
        let mut row = point.step(&opening, CONSISTENT).expect("success");
        row[0] = -row[0];
        // Which shear is the first one matters for what the state variables are called.
        for (jump, slip) in point.states[0][5..].iter().zip(slip) {
            assert!((jump - slip).abs() <= 1e-14 * slip.abs(), "TangentialJump");
        }
        row
    });
    rows.collect()
}
