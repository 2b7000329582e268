//! Time per update of the shared library beside Fortran rivals (rivals.f90), in one process.
//!
//! Every contender is called through a function pointer and keeps its states, as an FE code does. In each round
//! every contender runs the same batch of updates, the order rotates from round to round, and medians over the
//! rounds are printed: what disturbs the machine disturbs all alike, so trust the ratios more than the times.

use libloading::Library;
use mepc_oracle::Backbone;
use mepc_oracle::masing::Masing;
use mepc_oracle::twin::{PressureRule, Twin};
use std::f64::consts::TAU;
use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::time::Instant;

const ROUNDS: usize = 31;
/// Updates of one contender in one round, about.
const BATCH: usize = 16_000;
const ELEMENTS: usize = 4000;

const MU: f64 = 0.3;
const GCR: f64 = 0.002;
const CHI: f64 = 2.5;
const PRESSURE: f64 = 80.0;
const PROPS: [f64; 3] = [MU, GCR, CHI];
const BACKBONE: Backbone = Backbone::Power { chi: CHI };

/// One increment of a history: slip (length) and the pressure at its end.
#[derive(Clone, Copy)]
struct Step {
    slip: [f64; 2],
    pressure: f64,
}

/// A closed path of slip from the origin to the origin, driven over and over.
struct History {
    name: &'static str,
    ndir: usize,
    cycle: Vec<Step>,
    /// Along a line: the direction, for which the closed form holds.
    line: Option<[f64; 2]>,
}

impl History {
    /// `position` in critical slips and `pressure` relative to the mean, both of the part of the cycle.
    fn new(
        name: &'static str,
        ndir: usize,
        steps: usize,
        line: Option<[f64; 2]>,
        position: impl Fn(f64) -> [f64; 2],
        pressure: impl Fn(f64) -> f64,
    ) -> Self {
        let at = |k: usize| position(k as f64 / steps as f64);
        let cycle = (1..=steps)
            .map(|k| Step {
                slip: [0, 1].map(|i| GCR * (at(k)[i] - at(k - 1)[i])),
                pressure: PRESSURE * pressure(k as f64 / steps as f64),
            })
            .collect();
        History {
            name,
            ndir,
            cycle,
            line,
        }
    }

    fn straight(name: &'static str, amplitude: f64, direction: Option<[f64; 2]>) -> Self {
        let ndir = direction.map_or(1, |_| 2);
        let [x, y] = direction.unwrap_or([1.0, 0.0]);
        let position = |part: f64| {
            let s = amplitude * (TAU * part).sin();
            [s * x, s * y]
        };
        History::new(name, ndir, 64, Some([x, y]), position, |_| 1.0)
    }

    fn lissajous(name: &'static str, pressure: impl Fn(f64) -> f64) -> Self {
        let position = |part: f64| {
            [
                1.2 * (2.0 * TAU * part).sin(),
                0.9 * (3.0 * TAU * part).sin(),
            ]
        };
        History::new(name, 2, 240, None, position, pressure)
    }

    /// Tractions of the second cycle over mu and the mean pressure: closed form on a line, otherwise thousands of
    /// slip elements.
    fn reference(&self) -> Vec<[f64; 2]> {
        let mut line = Masing::new(BACKBONE);
        let mut twin = Twin::new(
            BACKBONE,
            MU,
            GCR,
            PressureRule::Dissipative,
            ELEMENTS as u32,
        );
        let limit = MU * PRESSURE;
        let mut step = |step: &Step| match self.line {
            Some([x, y]) => {
                let increment = (step.slip[0] * x + step.slip[1] * y) / GCR;
                line.move_to(line.slip() + increment);
                [x * line.traction(), y * line.traction()]
            }
            None => {
                twin.step(step.slip, step.pressure);
                twin.traction().map(|t| t / limit)
            }
        };
        let first = self.cycle.iter();
        first
            .chain(&self.cycle)
            .map(&mut step)
            .skip(self.cycle.len())
            .collect()
    }
}

/// Something that updates a contact point.
trait Contender {
    /// One update; gives the traction.
    fn update(&mut self, step: &Step) -> [f64; 2];

    fn run(&mut self, cycle: &[Step], cycles: usize) {
        for _ in 0..cycles {
            for step in cycle {
                self.update(step);
            }
        }
    }
}

type MepcFriction = unsafe extern "C" fn(
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

/// `mepc_friction`; the two states change places after each update.
struct Native {
    call: MepcFriction,
    law: *const c_void,
    states: [Vec<f64>; 2],
    traction: [f64; 2],
    tangent: [f64; 4],
    dpressure: [f64; 2],
    energy: [f64; 2],
    all: bool,
}

impl Contender for Native {
    #[inline]
    fn update(&mut self, step: &Step) -> [f64; 2] {
        let [start, end] = &mut self.states;
        let optional = |pointer: *mut f64| if self.all { pointer } else { null_mut() };
        // SAFETY: arrays of the documented sizes.
        let status = unsafe {
            (self.call)(
                self.law,
                step.slip.as_ptr(),
                step.pressure,
                start.as_ptr(),
                end.as_mut_ptr(),
                self.traction.as_mut_ptr(),
                self.tangent.as_mut_ptr(),
                optional(self.dpressure.as_mut_ptr()),
                optional(self.energy.as_mut_ptr()),
            )
        };
        assert!(status >= 0, "mepc_friction: {status}");
        self.states.swap(0, 1);
        self.traction
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
    fn update(&mut self, step: &Step) -> [f64; 2] {
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
                PROPS.as_ptr(),
                &(PROPS.len() as i32),
                80,
                80,
                80,
            );
        }
        assert!(pnewdt == 1.0 && lm == 0, "fric: PNEWDT {pnewdt}, LM {lm}");
        self.slip = [0, 1].map(|i| self.slip[i] + dslip[i]);
        self.time = self.time.map(|time| time + DTIME);
        self.tau
    }
}

type PaperRoutine =
    unsafe extern "C" fn(*const f64, f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64);

/// The paper's Eq. (13).
struct Paper {
    call: PaperRoutine,
    states: [[f64; 3]; 2],
}

impl Contender for Paper {
    #[inline]
    fn update(&mut self, step: &Step) -> [f64; 2] {
        let (mut traction, mut tangent) = (0.0, 0.0);
        let [start, end] = &mut self.states;
        // SAFETY: arrays of the sizes that the routine declares.
        unsafe {
            (self.call)(
                step.slip.as_ptr(),
                step.pressure,
                PROPS.as_ptr(),
                start.as_ptr(),
                end.as_mut_ptr(),
                &mut traction,
                &mut tangent,
            );
        }
        self.states.swap(0, 1);
        [traction, 0.0]
    }
}

type ElementsSetup = unsafe extern "C" fn(f64, f64, f64, *mut f64);
type ElementsRoutine = unsafe extern "C" fn(
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

/// 16 parallel slip elements.
struct Elements {
    call: ElementsRoutine,
    law: [f64; 2 + 5 * 16],
    states: [[f64; 3 + 2 * 16]; 2],
}

impl Contender for Elements {
    #[inline]
    fn update(&mut self, step: &Step) -> [f64; 2] {
        let (mut traction, mut tangent, mut dpressure, mut energy) =
            ([0.0; 2], [0.0; 4], [0.0; 2], [0.0; 2]);
        let [start, end] = &mut self.states;
        // SAFETY: arrays of the sizes that the routine declares.
        unsafe {
            (self.call)(
                self.law.as_ptr(),
                step.slip.as_ptr(),
                step.pressure,
                start.as_ptr(),
                end.as_mut_ptr(),
                traction.as_mut_ptr(),
                tangent.as_mut_ptr(),
                dpressure.as_mut_ptr(),
                energy.as_mut_ptr(),
            );
        }
        self.states.swap(0, 1);
        traction
    }
}

const NATIVE: &str = "mepc_friction";
const NATIVE_TANGENT: &str = "mepc_friction, tangent only";
const FRIC: &str = "fric_";
const PAPER: &str = "Eq. (13)";
const SLIP_ELEMENTS: &str = "16 slip elements";
const COULOMB: &str = "Coulomb FRIC";

/// The two libraries.
struct Libraries {
    mepc: Library,
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
    fn contenders(&self, ndir: usize) -> Vec<(&'static str, Box<dyn Contender>)> {
        let mut all: Vec<(&str, Box<dyn Contender>)> = Vec::new();
        // SAFETY: the types are those of include/mepc.h, of the host's page and of rivals.f90.
        unsafe {
            let state_size: unsafe extern "C" fn(*const f64, i32, i32) -> i32 =
                symbol(&self.mepc, "mepc_state_size");
            let new: unsafe extern "C" fn(*const f64, i32, i32, i32, *mut *const c_void) -> i32 =
                symbol(&self.mepc, "mepc_law_new");
            let call: MepcFriction = symbol(&self.mepc, "mepc_friction");
            let nprops = PROPS.len() as i32;
            let nstate = state_size(PROPS.as_ptr(), nprops, ndir as i32);
            let mut law = null();
            let status = new(PROPS.as_ptr(), nprops, ndir as i32, nstate, &mut law);
            assert_eq!(status, 0, "mepc_law_new");
            let state = vec![0.0; nstate as usize];
            for (name, every) in [(NATIVE, true), (NATIVE_TANGENT, false)] {
                let states = [state.clone(), state.clone()];
                all.push((
                    name,
                    Box::new(Native {
                        call,
                        law,
                        states,
                        traction: [0.0; 2],
                        tangent: [0.0; 4],
                        dpressure: [0.0; 2],
                        energy: [0.0; 2],
                        all: every,
                    }),
                ));
            }
            let fric = |call, nstatv| Fric {
                call,
                ndir: ndir as i32,
                statev: vec![0.0; nstatv],
                tau: [0.0; 2],
                slip: [0.0; 2],
                sed: 0.0,
                time: [0.0; 2],
            };
            all.push((
                FRIC,
                Box::new(fric(symbol(&self.mepc, "fric_"), state.len())),
            ));
            let Some(rivals) = &self.rivals else {
                return all;
            };
            if ndir == 1 {
                let call = symbol(rivals, "paper_eq13");
                all.push((
                    PAPER,
                    Box::new(Paper {
                        call,
                        states: [[0.0; 3]; 2],
                    }),
                ));
            }
            let setup: ElementsSetup = symbol(rivals, "elements_setup");
            let mut law = [0.0; 2 + 5 * 16];
            setup(MU, GCR, CHI, law.as_mut_ptr());
            let call = symbol(
                rivals,
                if ndir == 1 {
                    "elements_1"
                } else {
                    "elements_2"
                },
            );
            let states = [[0.0; 3 + 2 * 16]; 2];
            all.push((SLIP_ELEMENTS, Box::new(Elements { call, law, states })));
            all.push((COULOMB, Box::new(fric(symbol(rivals, "coulomb_fric_"), 2))));
        }
        all
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What was measured of one contender: nanoseconds per update of each round, largest error over mu p.
struct Measured {
    name: &'static str,
    rounds: Vec<f64>,
    error: f64,
}

fn measure(libraries: &Libraries, history: &History) -> Vec<Measured> {
    let reference = history.reference();
    let mut contenders = libraries.contenders(history.ndir);
    let mut measured: Vec<Measured> = contenders
        .iter_mut()
        .map(|(name, contender)| {
            // The first cycle starts from the virgin state, the second repeats for ever.
            contender.run(&history.cycle, 1);
            let error = history
                .cycle
                .iter()
                .zip(&reference)
                .map(|(step, reference)| {
                    let traction = contender.update(step);
                    let off = |i: usize| {
                        if i < history.ndir {
                            traction[i] / (MU * PRESSURE) - reference[i]
                        } else {
                            0.0
                        }
                    };
                    off(0).hypot(off(1))
                });
            Measured {
                name,
                rounds: Vec::new(),
                error: error.fold(0.0, f64::max),
            }
        })
        .collect();
    let cycles = BATCH.div_ceil(history.cycle.len());
    let updates = (cycles * history.cycle.len()) as f64;
    for round in 0..ROUNDS {
        for turn in 0..contenders.len() {
            let index = (round + turn) % contenders.len();
            let contender = &mut contenders[index].1;
            let start = Instant::now();
            contender.run(&history.cycle, cycles);
            measured[index]
                .rounds
                .push(start.elapsed().as_secs_f64() * 1e9 / updates);
        }
    }
    measured
}

/// Median over the rounds of the ratio of two contenders.
fn ratio(measured: &[Measured], of: &str, to: &str) -> Option<f64> {
    let rounds = |name: &str| {
        measured
            .iter()
            .find(|one| one.name == name)
            .map(|one| &one.rounds)
    };
    let (a, b) = (rounds(of)?, rounds(to)?);
    Some(median(a.iter().zip(b).map(|(a, b)| a / b).collect()))
}

/// A library, or an explanation how to get it.
fn load(path: &Path, make: &str) -> Result<Library, String> {
    // SAFETY: both libraries have no initialisation of their own.
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

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mepc = load(&library_path(), "cargo build --release makes it").unwrap_or_else(|message| {
        eprintln!("bench: {message}");
        std::process::exit(1)
    });
    let rivals = load(
        &root.join("build/librivals.so"),
        "make bench makes it, with gfortran",
    )
    .inspect_err(|message| println!("without rivals: {message}"))
    .ok();
    let libraries = Libraries { mepc, rivals };
    let oblique = Some([0.6, 0.8]);
    let histories = [
        History::straight("1-D cyclic, 1.5 gcr", 1.5, None),
        History::straight("1-D cyclic, 0.5 gcr", 0.5, None),
        History::straight("2-D oblique, 1.5 gcr", 1.5, oblique),
        History::straight("2-D oblique, 0.5 gcr", 0.5, oblique),
        History::lissajous("2-D Lissajous 2:3", |_| 1.0),
        History::lissajous("2-D Lissajous, p varies", |part| {
            1.0 + 0.3 * (TAU * part).sin()
        }),
    ];
    println!(
        "chi = {CHI}, default state sizes; medians of {ROUNDS} interleaved rounds of about {BATCH} updates."
    );
    println!(
        "Error: largest of a cycle against the closed form (curved: {ELEMENTS} slip elements), over mu p.\n"
    );
    println!(
        "{:<25}{:<30}{:>12}{:>13}",
        "history", "", "ns/update", "error"
    );
    // The first one to run finds the processor at rest.
    measure(&libraries, &histories[0]);
    let mut ratios = String::new();
    for history in &histories {
        let measured = measure(&libraries, history);
        for one in &measured {
            let time = median(one.rounds.clone());
            println!(
                "{:<25}{:<30}{time:>12.1}{:>13.1e}",
                history.name, one.name, one.error
            );
        }
        println!();
        let rival = if history.ndir == 1 {
            PAPER
        } else {
            SLIP_ELEMENTS
        };
        for of in [NATIVE, NATIVE_TANGENT, FRIC] {
            if let Some(ratio) = ratio(&measured, of, rival) {
                ratios += &format!(
                    "{:<25}{:<50}{ratio:>6.2}\n",
                    history.name,
                    format!("{of} / {rival}")
                );
            }
        }
    }
    println!("Ratios (median over the rounds):\n{ratios}");
}
