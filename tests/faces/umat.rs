//! The UMAT face as Kratos and CalculiX call it: from C, with null and stale pointers.

use crate::fortran::{caller, program, run};
use crate::support::flags;
use crate::support::native::{NativeLaw, library_path};
use libloading::Library;
use std::ffi::c_void;
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::OnceLock;

type Pointer = *mut c_void;
/// The 37 arguments and the hidden length of CMNAME.
type Umat = unsafe extern "C" fn(
    *mut f64,
    *mut f64,
    *mut f64,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const i32,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    Pointer,
    *const i32,
    *const i32,
    Pointer,
    Pointer,
    *const i32,
    *const i32,
    usize,
);

/// A material point of a host.
#[derive(Clone)]
pub struct Point {
    umat: Umat,
    row_major: bool,
    pub props: Vec<f64>,
    pub state: Vec<f64>,
    pub stran: Vec<f64>,
}

/// What a call gave.
pub struct Answer {
    pub stress: Vec<f64>,
    /// By rows, whatever the face's order.
    pub ddsdde: Vec<f64>,
    pub state: Vec<f64>,
}

fn library() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    // SAFETY: our own library; it runs no code when it is loaded.
    LIBRARY.get_or_init(|| unsafe { Library::new(library_path()).expect("the library") })
}

/// The 20 common properties and the first four of this face.
pub fn props(layout: f64, scale: f64, thickness: f64, tangent: f64) -> Vec<f64> {
    let mut props = vec![0.3, 0.002, 2.5, 0.0, 0.0, 0.0, 3e4, -0.001];
    props.resize(20, 0.0);
    props.extend([layout, scale, thickness, tangent]);
    props
}

impl Point {
    /// `symbol` is umat or umat_.
    pub fn new(symbol: &str, props: &[f64], ntens: usize, nstate: usize) -> Self {
        // SAFETY: the signature of the routine.
        let umat = unsafe { *library().get::<Umat>(symbol.as_bytes()).expect("umat") };
        Point {
            umat,
            row_major: symbol == "umat",
            props: props.to_vec(),
            state: vec![0.0; nstate],
            stran: vec![0.0; ntens],
        }
    }

    /// A trial from the state that is kept. Everything that a host does not vouch for is null or wild.
    pub fn trial(&self, dstran: &[f64]) -> Answer {
        let n = self.stran.len();
        let mut answer = Answer {
            stress: vec![f64::NAN; n],
            ddsdde: vec![f64::NAN; n * n],
            state: self.state.clone(),
        };
        let int = |number: usize| number as i32;
        let (wild, zero, one, nil): (Pointer, i32, f64, Pointer) =
            (without_provenance_mut(8), 0, 1.0, null_mut());
        let sizes = [
            3,
            int(n) - 3,
            int(n),
            int(self.state.len()),
            int(self.props.len()),
        ];
        let at = |index: usize| &raw const sizes[index];
        // SAFETY: arrays of the sizes that are passed; the rest is not touched.
        let call = || unsafe {
            (self.umat)(
                answer.stress.as_mut_ptr(),
                answer.state.as_mut_ptr(),
                answer.ddsdde.as_mut_ptr(),
                wild,
                wild,
                wild,
                nil,
                nil,
                nil,
                nil,
                self.stran.as_ptr(),
                dstran.as_ptr(),
                &raw const one,
                &raw const one,
                nil,
                nil,
                nil,
                nil,
                wild,
                at(0),
                at(1),
                at(2),
                at(3),
                self.props.as_ptr(),
                at(4),
                nil,
                nil,
                nil,
                nil,
                nil,
                nil,
                &raw const zero,
                &raw const zero,
                nil,
                nil,
                null(),
                null(),
                1,
            );
        };
        flags::watch(call);
        if !self.row_major {
            let columns = answer.ddsdde.clone();
            for i in 0..n {
                for j in 0..n {
                    answer.ddsdde[i * n + j] = columns[j * n + i];
                }
            }
        }
        answer
    }

    pub fn accept(&mut self, dstran: &[f64], answer: &Answer) {
        self.state.clone_from(&answer.state);
        for (total, increment) in self.stran.iter_mut().zip(dstran) {
            *total += increment;
        }
    }
}

/// Layout, NTENS, directions, slots of normal and shears, scale, thickness.
type Case = (f64, usize, usize, &'static [usize], f64, f64);

#[test]
fn layouts_and_scales() {
    let cases: [Case; 7] = [
        (0.0, 2, 1, &[0, 1], 1.0, 0.0),
        (0.0, 3, 2, &[0, 1, 2], 1.0, 0.0),
        (0.0, 3, 2, &[0, 1, 2], 3.0, 0.0),
        (1.0, 6, 2, &[2, 5, 4], 2.0, 0.0),
        (2.0, 6, 2, &[2, 4, 5], 1.0, 0.3),
        (2.0, 6, 2, &[2, 4, 5], 1.7, 0.3),
        (2.0, 4, 1, &[1, 3], 1.7, 0.3),
    ];
    for symbol in ["umat", "umat_"] {
        for (layout, ntens, directions, slots, scale, thickness) in cases {
            let props = props(layout, scale, thickness, 0.0);
            let law = NativeLaw::new(&props[..20], directions);
            let mut state = vec![0.0; law.nstate];
            let mut point = Point::new(symbol, &props, ntens, law.nstate);
            let length = scale * if layout == 2.0 { thickness } else { 1.0 };
            let mut opening = vec![0.0; 1 + directions];
            for step in 0..20 {
                let phase = f64::from(step) * 0.7;
                let now = [
                    -0.002 - 0.001 * phase.cos(),
                    0.003 * phase.sin(),
                    0.0011 * (1.3 * phase).cos(),
                ];
                let mut dstran = vec![0.25; ntens];
                for (k, slot) in slots.iter().enumerate() {
                    dstran[*slot] = (now[k] - opening[k]) / length;
                    opening[k] = now[k];
                }
                let out = law.interface(&opening, &mut state);
                let answer = point.trial(&dstran);
                let limit = 0.3 * 3e4 * 0.002;
                for (k, slot) in slots.iter().enumerate() {
                    let difference = answer.stress[*slot] - scale * out.traction[k];
                    assert!(
                        difference.abs() < 1e-11 * scale * limit,
                        "{symbol} layout {layout}: {difference:e}"
                    );
                    for (l, other) in slots.iter().enumerate() {
                        let (found, expected) = (
                            answer.ddsdde[slot * ntens + other],
                            scale * length * out.tangent[k * (1 + directions) + l],
                        );
                        // Sums of strains round differently: the tangent follows with f'' / f'.
                        let size = scale * length * limit / 0.002;
                        assert!(
                            (found - expected).abs() < 1e-8 * size,
                            "{symbol} layout {layout}: {found} {expected}"
                        );
                    }
                }
                let used = answer.stress.iter().filter(|x| **x != 0.0).count();
                assert!(
                    used <= 1 + directions,
                    "stress in slots that are not the interface's"
                );
                point.accept(&dstran, &answer);
            }
        }
    }
}

#[test]
fn sticking_tangent() {
    let props = props(2.0, 1.0, 0.3, 1.0);
    let mut point = Point::new("umat_", &props, 6, 84);
    // Gross slip, then micro-slip back.
    for slip in [0.02, -0.001] {
        let dstran = [
            0.0,
            0.0,
            if slip > 0.0 { -0.01 } else { 0.0 },
            0.0,
            slip / 0.3,
            0.0,
        ];
        let answer = point.trial(&dstran);
        let pressure = -answer.stress[2];
        assert!(pressure > 0.0);
        let shear = 0.3 * 0.3 * pressure / 0.002 * 2.5;
        for i in 0..6 {
            for j in 0..6 {
                let expected = match (i, j) {
                    (2, 2) => 0.3 * 3e4,
                    (4, 4) | (5, 5) => shear,
                    _ => 0.0,
                };
                assert!(
                    (answer.ddsdde[i * 6 + j] - expected).abs() <= 1e-12 * shear,
                    "{i} {j}"
                );
            }
        }
        point.accept(&dstran, &answer);
    }
    assert!(point.state[0] == 2.0, "micro-slip");
}

#[test]
fn a_rejected_trial_and_several_threads_change_nothing() {
    let run = |layout: f64| {
        let (ntens, scale) = if layout == 0.0 { (3, 1.0) } else { (6, 2.0) };
        let mut point = Point::new("umat", &props(layout, scale, 0.3, 0.0), ntens, 84);
        let mut all = Vec::new();
        for step in 0..200 {
            let phase = f64::from(step);
            let dstran: Vec<f64> = (0..ntens)
                .map(|k| {
                    if step == 0 {
                        -1e-3
                    } else {
                        4e-4 * (phase * (1.0 + k as f64)).sin()
                    }
                })
                .collect();
            let doubled: Vec<f64> = dstran.iter().map(|x| 2.0 * x).collect();
            point.trial(&doubled);
            let answer = point.trial(&dstran);
            point.accept(&dstran, &answer);
            all.extend(
                answer
                    .stress
                    .iter()
                    .chain(&answer.ddsdde)
                    .map(|x| x.to_bits()),
            );
        }
        all
    };
    let alone = [0.0, 1.0, 2.0].map(run);
    std::thread::scope(|scope| {
        for thread in 0..6 {
            let alone = &alone;
            scope.spawn(move || {
                assert!(
                    run(f64::from(thread % 3)) == alone[thread as usize % 3],
                    "thread {thread}"
                )
            });
        }
    });
}

/// A history of one step for a caller with these sizes and properties.
fn input(ndir: usize, nstate: usize, props: &str) -> String {
    let count = props.split_whitespace().count();
    format!(
        "{ndir} {nstate} {count} 1\n{props}\n{} 100\n",
        "0.001 ".repeat(ndir)
    )
}

/// Bad input that the caller passes on: layout, sizes and properties, and words of the message. The caller's arrays are those of
/// the layout, whatever PROPS(21) says.
const BAD: [(&str, usize, usize, &str, &str); 10] = [
    (
        "0",
        2,
        20,
        "0.3 0.002",
        "NSTATV = 20: must be from 24 (default 84)",
    ),
    ("2", 2, 23, "0.3 0.002", "NSTATV = 23"),
    ("0", 1, 44, "-0.3 0.002", "PROPS(1) mu = -0.3"),
    ("0", 2, 84, "0.3 0", "PROPS(2) gcr = 0"),
    ("7", 2, 84, "0.3 0.002", "PROPS(21) layout = 7"),
    (
        "0",
        2,
        84,
        "0.3 0.002 2.5 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 -1",
        "PROPS(22) scale = -1",
    ),
    (
        "2",
        2,
        84,
        "0.3 0.002 2.5 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 2 1 0",
        "PROPS(23) thickness = 0",
    ),
    (
        "0",
        2,
        84,
        "0.3 0.002 2.5 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1 0 2",
        "PROPS(24) tangent = 2",
    ),
    (
        "1",
        2,
        84,
        "0.3 0.002 2.5 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0",
        "NTENS = 6: must be in [2, 3] for layout 0 of PROPS(21)",
    ),
    (
        "1",
        2,
        84,
        "0.3 1e-110",
        "PROPS(2) gcr = 1e-110: must be 0, or from 1e-100 to 1e100",
    ),
];

#[test]
fn bad_input_ends_the_process_with_a_message() {
    for (layout, ndir, nstate, props, words) in BAD {
        let output = run(&caller("umat"), &[layout], &input(ndir, nstate, props));
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            message.contains(words) && message.contains("mepc UMAT: element 11"),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
        assert_eq!(output.status.code(), Some(1));
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn the_host_s_own_routines_are_used_where_there_are_any() {
    let host = program(
        "call_umat_hosted",
        &["history", "host_services", "call_umat"],
        &["-rdynamic"],
    );
    for (layout, ndir, nstate, props, words) in BAD {
        let output = run(&host, &[layout], &input(ndir, nstate, props));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(
            said.contains("HOST -2: mepc UMAT") && said.contains(words),
            "{said}"
        );
        assert_eq!(output.status.code(), Some(7), "ended by xit");
    }
}

/// PROPS(25): 0 by symbol, 1 row by row, 2 column by column, whatever the symbol.
#[test]
fn the_order_of_the_tangent_is_a_property() {
    let tangent = |symbol: &str, order: f64| {
        let mut all = props(0.0, 1.0, 0.0, 0.0);
        all.push(order);
        let mut point = Point::new(symbol, &all, 3, 84);
        let first = point.trial(&[-2e-3, 1e-3, 0.0]);
        point.accept(&[-2e-3, 1e-3, 0.0], &first);
        point.trial(&[-1e-4, 5e-4, 7e-4]).ddsdde
    };
    let [rows, columns] = [1.0, 2.0].map(|order| tangent("umat", order));
    assert!((0..3).any(|i| (0..3).any(|j| rows[3 * i + j] != rows[3 * j + i])));
    for i in 0..3 {
        for j in 0..3 {
            assert_eq!(rows[3 * i + j], columns[3 * j + i]);
        }
    }
    // The caller here turns what `umat_` gives, which is by columns, into rows.
    assert_eq!(tangent("umat", 0.0), rows);
    assert_eq!(tangent("umat_", 0.0), rows);
    assert_eq!(tangent("umat_", 1.0), columns);
    assert_eq!(tangent("umat_", 2.0), rows);
}

/// States that a host keeps in single precision.
#[test]
fn states_in_single_precision_are_taken() {
    for (layout, ntens) in [(0.0, 2), (0.0, 3), (2.0, 6)] {
        let nstate = if ntens == 2 { 44 } else { 84 };
        let mut point = Point::new("umat_", &props(layout, 1.0, 0.3, 0.0), ntens, nstate);
        for step in 0..100 {
            let phase = f64::from(step) * 0.7;
            let mut dstran = vec![2e-3 * phase.sin(); ntens];
            let normal = if layout == 2.0 { 2 } else { 0 };
            dstran[normal] = -0.01 - 0.001 * phase.cos() - point.stran[normal];
            let answer = point.trial(&dstran);
            assert!(answer.stress[normal] < 0.0);
            point.accept(&dstran, &answer);
            for x in &mut point.state {
                *x = f64::from(*x as f32);
            }
        }
    }
}
