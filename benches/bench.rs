//! Time per update of the shared library beside rivals, and their errors, in one process.
//!
//! Every contender is called through a function pointer and keeps its states, as an FE code does. In each round every
//! contender runs the same batch of updates, the order rotates from round to round, and medians over the rounds are printed:
//! what disturbs the machine disturbs all alike, so trust the ratios more than the times. Time is the thread's processor time.
//!
//! Rivals: the library before its kernel was written anew (build/old, `make bench` builds it from the repository's history),
//! and in rivals.f90 the paper's Eq. (13), plain Coulomb and parallel slip elements.

use libloading::Library;
use mepc_oracle::Backbone;
use mepc_oracle::twin::Twin;
use mepc_plot::{BLUE, Curve, Figure, GREY, ORANGE, Stroke};
use std::f64::consts::TAU;
use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::null;

const ROUNDS: usize = 15;
/// Updates of one contender in one round, about.
const BATCH: usize = 4_000;
/// Steps of a cycle.
const STEPS: usize = 100;
/// Elements of the reference, and sub-steps of it in a step: one radial return a step is exact on lines only.
const ELEMENTS: u32 = 4000;
const PARTS: u32 = 200;

const MU: f64 = 0.3;
const GCR: f64 = 0.002;
const CHI: f64 = 2.5;
const PRESSURE: f64 = 80.0;
const AMPLITUDES: [f64; 3] = [0.03, 0.3, 1.5];

/// One increment of a history: slip (length) and the pressure at its end.
#[derive(Clone, Copy)]
struct Step {
    slip: [f64; 2],
    pressure: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// One direction.
    Line,
    /// Two directions, along a line across the axes.
    Oblique,
    Circle,
}

/// A cycle of slip, driven over and over, of an amplitude in critical slips; the limit varies by 30 % or not.
struct History {
    shape: Shape,
    amplitude: f64,
    varies: bool,
    cycle: Vec<Step>,
}

/// What a contender gives in one increment.
#[derive(Clone, Copy, Default)]
struct Given {
    traction: [f64; 2],
    dissipated: f64,
}

impl History {
    fn new(shape: Shape, amplitude: f64, varies: bool) -> Self {
        let position = |k: usize| {
            let angle = TAU * k as f64 / STEPS as f64;
            let [x, y] = match shape {
                Shape::Line => [angle.sin(), 0.0],
                Shape::Oblique => [0.6 * angle.sin(), 0.8 * angle.sin()],
                Shape::Circle => [angle.sin(), 1.0 - angle.cos()],
            };
            [amplitude * GCR * x, amplitude * GCR * y]
        };
        let cycle = (1..=STEPS)
            .map(|k| {
                let (a, b) = (position(k - 1), position(k));
                let swing = if varies {
                    0.3 * (TAU * (k as f64 / STEPS as f64 + 0.1)).sin()
                } else {
                    0.0
                };
                Step {
                    slip: [b[0] - a[0], b[1] - a[1]],
                    pressure: PRESSURE * (1.0 + swing),
                }
            })
            .collect();
        History {
            shape,
            amplitude,
            varies,
            cycle,
        }
    }

    fn directions(&self) -> usize {
        if self.shape == Shape::Line { 1 } else { 2 }
    }

    fn name(&self) -> String {
        let shape = match self.shape {
            Shape::Line => "1-D",
            Shape::Oblique => "2-D line",
            Shape::Circle => "2-D circle",
        };
        format!(
            "{shape} {}{}",
            self.amplitude,
            if self.varies { ", T varies" } else { "" }
        )
    }

    /// What the second cycle gives, by thousands of slip elements in sub-steps; consistent rule or proportional rule.
    fn reference(&self, consistent: bool) -> Vec<Given> {
        let mut twin = if consistent {
            Twin::fixed_depths(CHI, GCR, MU * PRESSURE, 1.3 * MU * PRESSURE, ELEMENTS)
        } else {
            Twin::fixed_limits(Backbone::Power { chi: CHI }, GCR, ELEMENTS)
        };
        let parts = if self.shape == Shape::Circle {
            PARTS
        } else {
            10
        };
        let mut all = Vec::new();
        for step in self.cycle.iter().chain(&self.cycle) {
            let before = twin.dissipated();
            twin.step(step.slip, MU * step.pressure, parts);
            all.push(Given {
                traction: twin.traction(),
                dissipated: twin.dissipated() - before,
            });
        }
        all.split_off(STEPS)
    }
}

/// Something that updates a contact point.
trait Contender {
    fn update(&mut self, step: &Step) -> Given;

    fn run(&mut self, cycle: &[Step], cycles: usize) {
        for _ in 0..cycles {
            for step in cycle {
                self.update(step);
            }
        }
    }
}

type Friction = unsafe extern "C" fn(
    *const c_void,
    *const f64,
    f64,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
) -> i32;
/// That of ABI version 1.
type OldFriction = unsafe extern "C" fn(
    *const c_void,
    *const f64,
    f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
) -> i32;

#[derive(Clone, Copy)]
enum Call {
    Now(Friction),
    Old(OldFriction),
}

/// `mepc_friction` with all its outputs; the two states change places after each update.
struct Native {
    call: Call,
    law: *const c_void,
    states: [Vec<f64>; 2],
}

impl Native {
    /// # Safety
    /// `library` is the library that `call` is of. `nstate`: not the default.
    unsafe fn new(
        library: &Library,
        call: Call,
        props: &[f64],
        ndir: usize,
        nstate: Option<i32>,
    ) -> Self {
        // SAFETY: the types are those of include/mepc.h, arrays have the documented sizes.
        unsafe {
            let state_size: unsafe extern "C" fn(*const f64, i32, i32) -> i32 =
                symbol(library, "mepc_state_size");
            let new: unsafe extern "C" fn(*const f64, i32, i32, i32, *mut *const c_void) -> i32 =
                symbol(library, "mepc_law_new");
            let (nprops, ndir) = (props.len() as i32, ndir as i32);
            let nstate = nstate.unwrap_or_else(|| state_size(props.as_ptr(), nprops, ndir));
            let mut law = null();
            assert_eq!(
                new(props.as_ptr(), nprops, ndir, nstate, &mut law),
                0,
                "mepc_law_new"
            );
            let state = vec![0.0; nstate as usize];
            Native {
                call,
                law,
                states: [state.clone(), state],
            }
        }
    }
}

impl Contender for Native {
    #[inline]
    fn update(&mut self, step: &Step) -> Given {
        let [start, end] = &mut self.states;
        let (mut traction, mut tangent, mut by_pressure, mut energy) =
            ([0.0; 2], [0.0; 4], [0.0; 2], [0.0; 2]);
        let (slip, state0, state1) = (step.slip.as_ptr(), start.as_ptr(), end.as_mut_ptr());
        let (t, k, kp, e) = (
            traction.as_mut_ptr(),
            tangent.as_mut_ptr(),
            by_pressure.as_mut_ptr(),
            energy.as_mut_ptr(),
        );
        // SAFETY: arrays of the documented sizes.
        let status = unsafe {
            match self.call {
                Call::Now(call) => call(
                    self.law,
                    slip,
                    step.pressure,
                    null(),
                    state0,
                    state1,
                    t,
                    k,
                    kp,
                    e,
                ),
                Call::Old(call) => call(self.law, slip, step.pressure, state0, state1, t, k, kp, e),
            }
        };
        assert!(status >= 0, "mepc_friction: {status}");
        self.states.swap(0, 1);
        Given {
            traction,
            dissipated: energy[1],
        }
    }
}

type FricRoutine = unsafe extern "C" fn(
    *mut i32,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const i32,
    *const c_char,
    *const c_char,
    *const c_char,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const i32,
    usize,
    usize,
    usize,
);

/// A host's friction routine with all its arguments.
struct Fric {
    call: FricRoutine,
    ndir: i32,
    statev: Vec<f64>,
    tau: [f64; 2],
    slip: [f64; 2],
    sed: f64,
    time: [f64; 2],
}

impl Contender for Fric {
    #[inline]
    fn update(&mut self, step: &Step) -> Given {
        const NAME: [u8; 80] =
            *b"BENCH                                                                           ";
        const DTIME: f64 = 1e-3;
        let name = NAME.as_ptr().cast();
        let (mut lm, mut sfd, mut pnewdt) = (0, 0.0, 1.0);
        let (mut ddtddg, mut ddtddp, mut dslip, mut ddtddt) =
            ([0.0; 4], [0.0; 2], [0.0; 2], [0.0; 4]);
        let nstatv = self.statev.len() as i32;
        // SAFETY: arrays of the sizes that the host passes.
        unsafe {
            (self.call)(
                &mut lm,
                self.tau.as_mut_ptr(),
                ddtddg.as_mut_ptr(),
                ddtddp.as_mut_ptr(),
                dslip.as_mut_ptr(),
                &mut self.sed,
                &mut sfd,
                ddtddt.as_mut_ptr(),
                &mut pnewdt,
                self.statev.as_mut_ptr(),
                step.slip.as_ptr(),
                [0.0; 2].as_ptr(),
                &step.pressure,
                &0.0,
                &1e5,
                self.slip.as_ptr(),
                &1,
                &1,
                self.time.as_ptr(),
                &DTIME,
                &0,
                name,
                name,
                name,
                &1,
                &1,
                &1,
                [0.0; 3].as_ptr(),
                [0.0; 3].as_ptr(),
                [1.0, 0.0, 0.0, 1.0].as_ptr(),
                [0.0; 2].as_ptr(),
                [0.0; 2].as_ptr(),
                &self.ndir,
                &3,
                &1,
                &nstatv,
                &1.0,
                [MU, GCR, CHI].as_ptr(),
                &3,
                80,
                80,
                80,
            );
        }
        assert!(pnewdt == 1.0 && lm == 0, "fric: PNEWDT {pnewdt}, LM {lm}");
        self.slip = [0, 1].map(|i| self.slip[i] + dslip[i]);
        self.time = self.time.map(|time| time + DTIME);
        Given {
            traction: self.tau,
            dissipated: sfd,
        }
    }
}

type PaperRoutine =
    unsafe extern "C" fn(*const f64, f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64);

/// The paper's Eq. (13); it has no energies.
struct Paper {
    call: PaperRoutine,
    states: [[f64; 3]; 2],
}

impl Contender for Paper {
    #[inline]
    fn update(&mut self, step: &Step) -> Given {
        let (mut traction, mut tangent) = (0.0, 0.0);
        let [start, end] = &mut self.states;
        let props = [MU, GCR, CHI];
        // SAFETY: arrays of the sizes that the routine declares.
        unsafe {
            (self.call)(
                step.slip.as_ptr(),
                step.pressure,
                props.as_ptr(),
                start.as_ptr(),
                end.as_mut_ptr(),
                &mut traction,
                &mut tangent,
            );
        }
        self.states.swap(0, 1);
        Given {
            traction: [traction, 0.0],
            dissipated: f64::NAN,
        }
    }
}

type ElementsSetup = unsafe extern "C" fn(i32, i32, f64, *mut f64, *mut f64);
type ElementsRoutine = unsafe extern "C" fn(
    i32,
    f64,
    f64,
    *const f64,
    *const f64,
    *const f64,
    f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
);

/// Parallel slip elements.
struct Elements {
    call: ElementsRoutine,
    limit: Vec<f64>,
    stiffness: Vec<f64>,
    states: [Vec<f64>; 2],
}

impl Contender for Elements {
    #[inline]
    fn update(&mut self, step: &Step) -> Given {
        let (mut traction, mut tangent, mut by_pressure, mut energy) =
            ([0.0; 2], [0.0; 4], [0.0; 2], [0.0; 2]);
        let [start, end] = &mut self.states;
        // SAFETY: arrays of the sizes that the routine declares.
        unsafe {
            (self.call)(
                self.limit.len() as i32,
                MU,
                GCR,
                self.limit.as_ptr(),
                self.stiffness.as_ptr(),
                step.slip.as_ptr(),
                step.pressure,
                start.as_ptr(),
                end.as_mut_ptr(),
                traction.as_mut_ptr(),
                tangent.as_mut_ptr(),
                by_pressure.as_mut_ptr(),
                energy.as_mut_ptr(),
            );
        }
        self.states.swap(0, 1);
        Given {
            traction,
            dissipated: energy[1],
        }
    }
}

const NATIVE: &str = "mepc_friction";
const CONSISTENT: &str = "mepc_friction, consistent rule";
const COARSE: &str = "mepc_friction, resolution 1e-2";
const FINE: &str = "mepc_friction, 64 knots, 1e-4";
const FRIC: &str = "fric_";
const OLD: &str = "kernel before";
const PAPER: &str = "Eq. (13)";
const COULOMB: &str = "Coulomb FRIC";
const SIZES: [usize; 3] = [16, 32, 64];
const GRIDS: [&str; 2] = ["equal", "geometric"];

fn elements_name(n: usize, grid: usize) -> String {
    format!("{n} elements, {}", GRIDS[grid])
}

/// The libraries; rivals may be missing.
struct Libraries {
    mepc: Library,
    old: Option<Library>,
    rivals: Option<Library>,
}

/// A function of a library.
///
/// # Safety
/// `T` is its type.
unsafe fn symbol<T: Copy>(library: &Library, name: &str) -> T {
    // SAFETY: by the caller's word; the libraries outlive all uses.
    *unsafe { library.get::<T>(name) }.unwrap_or_else(|error| panic!("{error}"))
}

impl Libraries {
    /// The contenders for one history, by name.
    fn contenders(&self, history: &History) -> Vec<(String, Box<dyn Contender>)> {
        let ndir = history.directions();
        let mut all: Vec<(String, Box<dyn Contender>)> = Vec::new();
        let mut add =
            |name: &str, contender: Box<dyn Contender>| all.push((name.into(), contender));
        let fric = |call, nstatv| Fric {
            call,
            ndir: ndir as i32,
            statev: vec![0.0; nstatv],
            tau: [0.0; 2],
            slip: [0.0; 2],
            sed: 0.0,
            time: [0.0; 2],
        };
        // SAFETY: the types are those of include/mepc.h, of the host's page and of rivals.f90.
        unsafe {
            let call = Call::Now(symbol(&self.mepc, "mepc_friction"));
            let native = |props: &[f64]| Native::new(&self.mepc, call, props, ndir, None);
            let plain = native(&[MU, GCR, CHI]);
            let nstate = plain.states[0].len();
            add(NATIVE, Box::new(plain));
            if history.varies {
                add(CONSISTENT, Box::new(native(&[MU, GCR, CHI, 0.0, PRESSURE])));
            }
            if history.shape == Shape::Circle {
                for (name, resolution, nstate) in
                    [(COARSE, 1e-2, None), (FINE, 1e-4, Some(12 + 3 * 64))]
                {
                    let mut props = [0.0; 16];
                    props[..3].copy_from_slice(&[MU, GCR, CHI]);
                    props[15] = resolution;
                    add(
                        name,
                        Box::new(Native::new(&self.mepc, call, &props, ndir, nstate)),
                    );
                }
            }
            add(FRIC, Box::new(fric(symbol(&self.mepc, "fric_"), nstate)));
            if let Some(old) = &self.old {
                let call = Call::Old(symbol(old, "mepc_friction"));
                add(
                    OLD,
                    Box::new(Native::new(old, call, &[MU, GCR, CHI], ndir, None)),
                );
            }
            if let Some(rivals) = &self.rivals {
                if ndir == 1 {
                    let call = symbol(rivals, "paper_eq13");
                    add(
                        PAPER,
                        Box::new(Paper {
                            call,
                            states: [[0.0; 3]; 2],
                        }),
                    );
                }
                add(COULOMB, Box::new(fric(symbol(rivals, "coulomb_fric_"), 2)));
                let setup: ElementsSetup = symbol(rivals, "elements_setup");
                let call: ElementsRoutine = symbol(rivals, &format!("elements_{ndir}"));
                for grid in 0..GRIDS.len() {
                    for n in SIZES {
                        let (mut limit, mut stiffness) = (vec![0.0; n], vec![0.0; n]);
                        setup(
                            n as i32,
                            grid as i32,
                            CHI,
                            limit.as_mut_ptr(),
                            stiffness.as_mut_ptr(),
                        );
                        let states = [vec![0.0; 3 + ndir * n], vec![0.0; 3 + ndir * n]];
                        add(
                            &elements_name(n, grid),
                            Box::new(Elements {
                                call,
                                limit,
                                stiffness,
                                states,
                            }),
                        );
                    }
                }
            }
        }
        all
    }

    /// Time of 10^5 points in one batch call on one thread over that of single calls.
    fn batch_ratio(&self) -> f64 {
        const POINTS: usize = 100_000;
        type Batch = unsafe extern "C" fn(
            *const c_void,
            i64,
            *const f64,
            *const f64,
            *const f64,
            *const f64,
            *mut f64,
            *mut f64,
            *mut f64,
            *mut f64,
            *mut f64,
            *mut i32,
            i32,
        ) -> i32;
        // SAFETY: the types are those of include/mepc.h, arrays have the documented sizes.
        unsafe {
            let single: Friction = symbol(&self.mepc, "mepc_friction");
            let batch: Batch = symbol(&self.mepc, "mepc_friction_batch");
            let Native {
                law,
                states: [state, _],
                ..
            } = Native::new(&self.mepc, Call::Now(single), &[MU, GCR, CHI], 1, None);
            let nstate = state.len();
            let (mut state0, mut state1) = (vec![0.0; POINTS * nstate], vec![0.0; POINTS * nstate]);
            let pressure = vec![PRESSURE; POINTS];
            let (mut t, mut k, mut kp, mut e) = (
                vec![0.0; POINTS],
                vec![0.0; POINTS],
                vec![0.0; POINTS],
                vec![0.0; 2 * POINTS],
            );
            let mut statuses = vec![0; POINTS];
            let mut ratios = Vec::new();
            for round in 0..ROUNDS {
                let slip: Vec<f64> = (0..POINTS)
                    .map(|p| GCR * ((p % 97) as f64 / 97.0 - 0.3 * (round % 4) as f64))
                    .collect();
                let mut times = [0.0; 2];
                for way in 0..2 {
                    let start = now();
                    if (way + round) % 2 == 0 {
                        let status = batch(
                            law,
                            POINTS as i64,
                            slip.as_ptr(),
                            pressure.as_ptr(),
                            null(),
                            state0.as_ptr(),
                            state1.as_mut_ptr(),
                            t.as_mut_ptr(),
                            k.as_mut_ptr(),
                            kp.as_mut_ptr(),
                            e.as_mut_ptr(),
                            statuses.as_mut_ptr(),
                            1,
                        );
                        assert!(status >= 0, "mepc_friction_batch: {status}");
                    } else {
                        for p in 0..POINTS {
                            let status = single(
                                law,
                                &slip[p],
                                PRESSURE,
                                null(),
                                state0[p * nstate..].as_ptr(),
                                state1[p * nstate..].as_mut_ptr(),
                                &mut t[p],
                                &mut k[p],
                                &mut kp[p],
                                e[2 * p..].as_mut_ptr(),
                            );
                            assert!(status >= 0, "mepc_friction: {status}");
                        }
                    }
                    times[(way + round) % 2] = now() - start;
                }
                ratios.push(times[0] / times[1]);
                std::mem::swap(&mut state0, &mut state1);
            }
            median(ratios)
        }
    }
}

/// Processor time of this thread, s: on a machine with other work, wall time would count against the slow, which are
/// interrupted more often.
fn now() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    assert_eq!(
        // SAFETY: the pointer is to a timespec.
        unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) },
        0
    );
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What was measured of one contender: nanoseconds per update of each round; largest error of the traction over T, and error of
/// the dissipation of a cycle over itself.
struct Measured {
    name: String,
    rounds: Vec<f64>,
    traction: f64,
    dissipated: f64,
}

impl Measured {
    fn time(&self) -> f64 {
        median(self.rounds.clone())
    }
}

fn measure(libraries: &Libraries, history: &History) -> Vec<Measured> {
    let references = [history.reference(false), history.reference(true)];
    let ndir = history.directions();
    let mut contenders = libraries.contenders(history);
    let mut measured = Vec::new();
    for (name, contender) in &mut contenders {
        // The first cycle starts from the virgin state, the second repeats for ever.
        contender.run(&history.cycle, 1);
        let reference = &references[usize::from(name == CONSISTENT)];
        let (mut traction, mut dissipated, mut expected): (f64, _, _) = (0.0, 0.0, 0.0);
        for (step, reference) in history.cycle.iter().zip(reference) {
            let given = contender.update(step);
            let off = |i: usize| {
                if i < ndir {
                    given.traction[i] - reference.traction[i]
                } else {
                    0.0
                }
            };
            traction = traction.max(off(0).hypot(off(1)) / (MU * PRESSURE));
            dissipated += given.dissipated;
            expected += reference.dissipated;
        }
        if name == OLD && history.varies {
            // It had another rule.
            (traction, dissipated) = (f64::NAN, f64::NAN);
        }
        let dissipated = (dissipated / expected - 1.0).abs();
        measured.push(Measured {
            name: name.clone(),
            rounds: Vec::new(),
            traction,
            dissipated,
        });
    }
    let cycles = BATCH / STEPS;
    for round in 0..ROUNDS {
        for turn in 0..contenders.len() {
            let index = (round + turn) % contenders.len();
            let start = now();
            contenders[index].1.run(&history.cycle, cycles);
            let time = (now() - start) * 1e9 / (cycles * STEPS) as f64;
            measured[index].rounds.push(time);
        }
    }
    measured
}

/// Median over the rounds of the ratio of two contenders; `difference`: of their difference, ns.
fn compare(measured: &[Measured], of: &str, to: &str, difference: bool) -> Option<f64> {
    let rounds = |name: &str| {
        measured
            .iter()
            .find(|one| one.name == name)
            .map(|one| &one.rounds)
    };
    let (a, b) = (rounds(of)?, rounds(to)?);
    Some(median(
        a.iter()
            .zip(b)
            .map(|(a, b)| if difference { a - b } else { a / b })
            .collect(),
    ))
}

/// A library, or an explanation how to get it.
fn load(path: &Path, make: &str) -> Result<Library, String> {
    // SAFETY: the libraries have no initialisation of their own.
    unsafe { Library::new(path) }.map_err(|error| format!("{error}\n  ({make})"))
}

/// The library to measure: MEPC_LIBRARY, otherwise the one that was built with this program.
fn library_path() -> PathBuf {
    let built = || {
        let program = std::env::current_exe().expect("this program has a path");
        let release = program
            .ancestors()
            .nth(2)
            .expect("target/release/deps/bench");
        release.join("libmepc.so")
    };
    std::env::var_os("MEPC_LIBRARY").map_or_else(built, PathBuf::from)
}

/// Error against time of the circles under constant limit: elements by their number, ours by its resolution.
fn picture(circles: &[(f64, Vec<Measured>)]) -> String {
    let families: [(&str, Vec<String>, _); 3] = [
        (
            "elements, equal",
            SIZES.map(|n| elements_name(n, 0)).into(),
            GREY,
        ),
        (
            "elements, geometric",
            SIZES.map(|n| elements_name(n, 1)).into(),
            ORANGE,
        ),
        (
            "mepc",
            [COARSE, NATIVE, FINE].map(String::from).into(),
            BLUE,
        ),
    ];
    let figure = |title: &str, error: fn(&Measured) -> f64| {
        let mut curves = Vec::new();
        for (amplitude, measured) in circles {
            let stroke = match *amplitude {
                a if a < 0.1 => Stroke::Solid,
                a if a < 1.0 => Stroke::Dashed,
                _ => Stroke::Marks,
            };
            for (label, names, colour) in &families {
                let found = names
                    .iter()
                    .filter_map(|name| measured.iter().find(|one| one.name == *name));
                let points = found
                    .map(|one| [one.time().log10(), error(one).log10()])
                    .collect();
                curves.push(Curve {
                    label: format!("{label}, {amplitude} gcr"),
                    points,
                    stroke,
                    colour: *colour,
                });
            }
        }
        Figure {
            title: title.into(),
            x_label: "log10 of the time per update, ns".into(),
            y_label: "log10 of the error".into(),
            curves,
            equal_axes: false,
        }
    };
    mepc_plot::stacked(&[
        figure("Circles: largest error of the traction, over T", |one| {
            one.traction
        }),
        figure("Circles: error of the dissipation of a cycle", |one| {
            one.dissipated
        }),
    ])
    .expect("a picture")
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mepc = load(&library_path(), "cargo build --release makes it").unwrap_or_else(|message| {
        eprintln!("bench: {message}");
        std::process::exit(1)
    });
    let rival = |path: &str, make: &str| {
        load(&root.join(path), make)
            .inspect_err(|message| println!("without: {message}"))
            .ok()
    };
    let libraries = Libraries {
        mepc,
        old: rival(
            "build/old/libmepc.so",
            "make bench builds it from the repository's history, where that is there",
        ),
        rivals: rival("build/librivals.so", "make bench makes it, with gfortran"),
    };
    println!(
        "chi = {CHI}, default state sizes, {STEPS} steps a cycle, T constant or varying by 30 % (proportional rule unless it is"
    );
    println!(
        "said); medians of {ROUNDS} interleaved rounds of {BATCH} updates. Errors of a cycle against {ELEMENTS} slip elements"
    );
    println!(
        "in {PARTS} sub-steps a step: largest of the traction over T, and of the dissipation.\n"
    );
    println!(
        "{:<26}{:<32}{:>10}{:>12}{:>12}",
        "history", "", "ns/update", "traction", "dissipation"
    );
    // The first one to run finds the processor at rest.
    measure(&libraries, &History::new(Shape::Line, 1.5, false));
    let (mut ratios, mut circles) = (String::new(), Vec::new());
    for varies in [false, true] {
        for shape in [Shape::Line, Shape::Oblique, Shape::Circle] {
            for amplitude in AMPLITUDES {
                let history = History::new(shape, amplitude, varies);
                let measured = measure(&libraries, &history);
                let name = history.name();
                for one in &measured {
                    println!(
                        "{name:<26}{:<32}{:>10.1}{:>12.1e}{:>12.1e}",
                        one.name,
                        one.time(),
                        one.traction,
                        one.dissipated
                    );
                }
                println!();
                let elements = elements_name(32, 1);
                for to in [OLD, PAPER, elements.as_str()] {
                    if let Some(ratio) = compare(&measured, NATIVE, to, false) {
                        ratios +=
                            &format!("{name:<26}{:<50}{ratio:>8.2}\n", format!("{NATIVE} / {to}"));
                    }
                }
                if let Some(ns) = compare(&measured, FRIC, NATIVE, true) {
                    ratios += &format!("{name:<26}{:<50}{ns:>8.1}\n", "fric_ - mepc_friction, ns");
                }
                if shape == Shape::Circle && !varies {
                    circles.push((amplitude, measured));
                }
            }
        }
    }
    println!("Ratios (median over the rounds):\n{ratios}");
    println!(
        "batch of 10^5 points / single calls: {:.2}",
        libraries.batch_ratio()
    );
    let path = root.join("build/speed.svg");
    std::fs::write(&path, picture(&circles)).expect("build/ is there");
    println!("picture: {}", path.display());
}
