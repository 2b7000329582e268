//! The MFront behaviours, loaded and called as MGIS, MTest and OpenGeoSys do.

use crate::support::native::{NativeLaw, library_path, native, text};
use crate::support::{flags, with};
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::null_mut;
use std::sync::OnceLock;

pub const NO_OPERATOR: f64 = 0.0;
pub const ELASTIC: f64 = 1.0;
pub const SECANT: f64 = 2.0;
pub const TANGENT: f64 = 3.0;
pub const CONSISTENT: f64 = 4.0;
/// Characters of a message with its end.
const MESSAGE: usize = 512;

/// One end of the step, as the C header of the interface declares it.
#[repr(C)]
struct State {
    gradients: *mut f64,
    thermodynamic_forces: *mut f64,
    mass_density: *mut f64,
    material_properties: *mut f64,
    internal_state_variables: *mut f64,
    stored_energy: *mut f64,
    dissipated_energy: *mut f64,
    external_state_variables: *mut f64,
}

#[repr(C)]
struct Data {
    error_message: *mut c_char,
    dt: f64,
    k: *mut f64,
    rdt: *mut f64,
    speed_of_sound: *mut f64,
    s0: State,
    s1: State,
}

type Function = unsafe extern "C" fn(*mut Data) -> c_int;

#[derive(Clone, Copy, PartialEq)]
pub enum Hypothesis {
    PlaneStrain,
    Tridimensional,
}

impl Hypothesis {
    pub fn of(ndir: usize) -> Self {
        if ndir == 1 {
            Hypothesis::PlaneStrain
        } else {
            Hypothesis::Tridimensional
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Hypothesis::PlaneStrain => "PlaneStrain",
            Hypothesis::Tridimensional => "Tridimensional",
        }
    }

    pub fn directions(self) -> usize {
        match self {
            Hypothesis::PlaneStrain => 1,
            Hypothesis::Tridimensional => 2,
        }
    }

    pub fn states(self) -> usize {
        match self {
            Hypothesis::PlaneStrain => 44,
            Hypothesis::Tridimensional => 84,
        }
    }
}

fn library() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    // SAFETY: our own library; it runs no code when it is loaded.
    LIBRARY.get_or_init(|| unsafe { Library::new(library_path()).expect("the library") })
}

/// The address of a symbol.
fn address<T>(name: &str) -> Option<*const T> {
    // SAFETY: only the address is taken.
    unsafe {
        library().get::<*const T>(name).ok().map(|symbol| {
            symbol
                .try_as_raw_ptr()
                .expect("an address")
                .cast_const()
                .cast()
        })
    }
}

/// A constant, looked up with the hypothesis first, as the hosts do.
fn constant<T: Copy>(behaviour: &str, hypothesis: Hypothesis, name: &str) -> T {
    let first = address(&format!("{behaviour}_{}_{name}", hypothesis.name()));
    let found = first.or_else(|| address(&format!("{behaviour}_{name}")));
    // SAFETY: the constants have the types of the interface.
    unsafe { *found.unwrap_or_else(|| panic!("{behaviour}_{name}")) }
}

/// An array of names with its count.
fn names(behaviour: &str, hypothesis: Hypothesis, name: &str) -> Vec<String> {
    let count: u16 = constant(behaviour, hypothesis, &format!("n{name}"));
    let first = address::<*const c_char>(&format!("{behaviour}_{}_{name}", hypothesis.name()));
    let array = first
        .or_else(|| address(&format!("{behaviour}_{name}")))
        .expect(name);
    let string = |index| {
        // SAFETY: as many C strings as the count says.
        unsafe { CStr::from_ptr(*array.add(index)) }
            .to_str()
            .expect("text")
            .to_string()
    };
    (0..usize::from(count)).map(string).collect()
}

/// An array of type numbers.
fn types(behaviour: &str, hypothesis: Hypothesis, name: &str) -> Vec<c_int> {
    let count: u16 = constant(behaviour, hypothesis, &format!("n{name}"));
    let types = format!("{name}Types");
    let first = address::<c_int>(&format!("{behaviour}_{}_{types}", hypothesis.name()));
    let array = first
        .or_else(|| address(&format!("{behaviour}_{types}")))
        .expect("types");
    // SAFETY: as many numbers as the count says.
    (0..usize::from(count))
        .map(|index| unsafe { *array.add(index) })
        .collect()
}

/// A point of a host: what it keeps between steps, and the call.
pub struct Point {
    function: Function,
    directions: usize,
    layer: bool,
    thickness: f64,
    pub properties: Vec<f64>,
    pub gradients: [Vec<f64>; 2],
    pub forces: [Vec<f64>; 2],
    pub states: [Vec<f64>; 2],
    pub energies: [[f64; 2]; 2],
    pub k: Vec<f64>,
    pub rdt: f64,
    pub message: Vec<u8>,
    /// Whether energies and a message are asked for.
    pub extras: bool,
}

impl Point {
    /// `props` in the library's order.
    pub fn new(behaviour: &str, hypothesis: Hypothesis, props: &[f64], thickness: f64) -> Self {
        let symbol = format!("{behaviour}_{}", hypothesis.name());
        // SAFETY: the signature of the interface.
        let function = unsafe {
            *library()
                .get::<Function>(symbol.as_bytes())
                .expect("the behaviour")
        };
        let layer = behaviour == "MemoryPenaltyLayer";
        let directions = hypothesis.directions();
        let size = match (layer, directions) {
            (false, n) => 1 + n,
            (true, 1) => 4,
            (true, _) => 6,
        };
        let props = with(props, 12, 0.0);
        let mut properties = vec![props[0], props[1], props[2], props[6], props[7], props[4]];
        if layer {
            properties.push(thickness);
        }
        let pair = |len: usize| [vec![0.0; len], vec![0.0; len]];
        Point {
            function,
            directions,
            layer,
            thickness: if layer { thickness } else { 1.0 },
            properties,
            gradients: pair(size),
            forces: pair(size),
            states: pair(hypothesis.states()),
            energies: [[0.0; 2]; 2],
            k: vec![0.0; size * size],
            rdt: 1.0,
            message: vec![b'#'; MESSAGE + 1],
            extras: true,
        }
    }

    /// Slots of the interface, and their weights.
    fn slots(&self) -> Vec<(usize, f64)> {
        let root = std::f64::consts::SQRT_2;
        match (self.layer, self.directions) {
            (false, n) => (0..=n).map(|slot| (slot, 1.0)).collect(),
            (true, 1) => vec![(1, 1.0), (3, root)],
            (true, _) => vec![(2, 1.0), (4, root), (5, root)],
        }
    }

    /// Sets the opening at the end of the step.
    pub fn open(&mut self, opening: &[f64]) {
        for ((slot, weight), opening) in self.slots().into_iter().zip(opening) {
            self.gradients[1][slot] = opening / (self.thickness * weight);
        }
    }

    /// Calls the behaviour as the arrays stand; `k0` is the request.
    pub fn call(&mut self, k0: f64) -> c_int {
        self.k.fill(0.0);
        self.k[0] = k0;
        // Neither of these may be touched.
        let wild = std::ptr::without_provenance_mut::<f64>(8);
        let optional = |pointer: *mut f64| if self.extras { pointer } else { null_mut() };
        let [g0, g1] = &mut self.gradients;
        let [f0, f1] = &mut self.forces;
        let [i0, i1] = &mut self.states;
        let [e0, e1] = &mut self.energies;
        let properties = self.properties.as_mut_ptr();
        let state =
            |g: &mut Vec<f64>, f: &mut Vec<f64>, i: &mut Vec<f64>, e: &mut [f64; 2]| State {
                gradients: g.as_mut_ptr(),
                thermodynamic_forces: f.as_mut_ptr(),
                mass_density: wild,
                material_properties: properties,
                internal_state_variables: i.as_mut_ptr(),
                stored_energy: optional(&raw mut e[0]),
                dissipated_energy: optional(&raw mut e[1]),
                external_state_variables: wild,
            };
        let mut data = Data {
            error_message: if self.extras {
                self.message.as_mut_ptr().cast()
            } else {
                null_mut()
            },
            dt: 1.0,
            k: self.k.as_mut_ptr(),
            rdt: &raw mut self.rdt,
            speed_of_sound: wild,
            s0: state(g0, f0, i0, e0),
            s1: state(g1, f1, i1, e1),
        };
        // SAFETY: arrays of the sizes of the interface.
        let call = || unsafe { (self.function)(&raw mut data) };
        flags::watch(call)
    }

    /// Accepts the step.
    pub fn accept(&mut self) {
        for pair in [&mut self.gradients, &mut self.forces, &mut self.states] {
            let [start, end] = pair;
            start.clone_from(end);
        }
        self.energies[0] = self.energies[1];
    }

    /// d traction / d opening by rows, from K.
    pub fn stiffness(&self) -> Vec<f64> {
        let (slots, size) = (self.slots(), self.gradients[0].len());
        let mut rows = Vec::new();
        for (i, a) in &slots {
            rows.extend(
                slots
                    .iter()
                    .map(|(j, b)| self.k[i * size + j] / (a * b * self.thickness)),
            );
        }
        let others = self.k.iter().filter(|x| **x != 0.0).count();
        assert!(
            others <= slots.len() * slots.len(),
            "K outside the interface"
        );
        rows
    }

    /// Traction from the forces at the start (0) or the end (1).
    pub fn traction(&self, end: usize) -> Vec<f64> {
        self.slots()
            .iter()
            .map(|(slot, weight)| self.forces[end][*slot] / weight)
            .collect()
    }

    /// One accepted step: traction, stored, dissipated so far, d traction/d opening by rows; the message on failure.
    pub fn step(&mut self, opening: &[f64], k0: f64) -> Result<Vec<f64>, String> {
        self.open(opening);
        if self.call(k0) != 1 {
            return Err(self.words());
        }
        let energies = self.energies[1].map(|energy| energy * self.thickness);
        let row = [&self.traction(1)[..], &energies, &self.stiffness()].concat();
        self.accept();
        Ok(row)
    }

    fn words(&self) -> String {
        assert_eq!(self.message[MESSAGE], b'#', "written past the end");
        let message = CStr::from_bytes_until_nul(&self.message).expect("an end");
        message.to_str().expect("text").to_string()
    }
}

const BEHAVIOURS: [&str; 2] = ["MemoryPenaltyContact", "MemoryPenaltyLayer"];
/// The parameters of a behaviour, in their order.
const PARAMETERS: [&str; 9] = [
    "Method",
    "NormalExponent",
    "Backbone",
    "Beta",
    "Cohesion",
    "MaximalTraction",
    "LateFrictionCoefficient",
    "LateSlipLength",
    "Resolution",
];
const HYPOTHESES: [Hypothesis; 2] = [Hypothesis::PlaneStrain, Hypothesis::Tridimensional];

/// Laws that need every property: with clearance and both rules.
fn props() -> Vec<f64> {
    vec![0.3, 0.002, 2.5, 0.0, 0.0, 0.0, 3e4, -0.001]
}

#[test]
fn sizes_of_the_struct() {
    assert_eq!((size_of::<State>(), size_of::<Data>()), (64, 168));
}

#[test]
fn symbols_describe_the_behaviours() {
    for behaviour in BEHAVIOURS {
        let layer = behaviour == "MemoryPenaltyLayer";
        for hypothesis in HYPOTHESES {
            let number = |name: &str| -> u16 { constant(behaviour, hypothesis, name) };
            for (name, value) in [
                ("mfront_mkt", 1),
                ("api_version", 1),
                ("BehaviourType", if layer { 1 } else { 3 }),
                ("BehaviourKinematic", if layer { 1 } else { 2 }),
                ("SymmetryType", 0),
                ("ElasticSymmetryType", 0),
                ("requiresStiffnessTensor", 0),
                ("requiresThermalExpansionCoefficientTensor", 0),
                ("ComputesInternalEnergy", 1),
                ("ComputesDissipatedEnergy", 1),
                ("TemperatureRemovedFromExternalStateVariables", 0),
                ("nGradients", 1),
                ("nThermodynamicForces", 1),
                ("nTangentOperatorBlocks", 2),
                ("nExternalStateVariables", 0),
                ("nParameters", 9),
                ("nInitializeFunctions", 0),
                ("nPostProcessings", 0),
                ("nModellingHypotheses", 2),
            ] {
                assert_eq!(number(name), value, "{behaviour}_{name}");
            }
            let interface: *const c_char = constant(behaviour, hypothesis, "mfront_interface");
            assert_eq!(text(interface).as_deref(), Some("Generic"));
            let (gradient, force, tensor) = if layer {
                ("Strain", "Stress", 1)
            } else {
                ("OpeningDisplacement", "CohesiveForce", 2)
            };
            assert_eq!(names(behaviour, hypothesis, "Gradients"), [gradient]);
            assert_eq!(types(behaviour, hypothesis, "Gradients"), [tensor]);
            assert_eq!(names(behaviour, hypothesis, "ThermodynamicForces"), [force]);
            assert_eq!(
                types(behaviour, hypothesis, "ThermodynamicForces"),
                [tensor]
            );
            assert_eq!(
                names(behaviour, hypothesis, "TangentOperatorBlocks"),
                [force, gradient]
            );
            let mut hypotheses = names(behaviour, hypothesis, "ModellingHypotheses");
            hypotheses.sort();
            assert_eq!(hypotheses, ["PlaneStrain", "Tridimensional"]);
            let mut properties = vec![
                "FrictionCoefficient",
                "CriticalSlip",
                "Exponent",
                "NormalStiffness",
                "InitialGap",
                "ReferencePressure",
            ];
            if layer {
                properties.push("Thickness");
            }
            assert_eq!(
                names(behaviour, hypothesis, "MaterialProperties"),
                properties
            );
            for name in [
                "ExternalStateVariables",
                "ExternalStateVariablesTypes",
                "InitializeFunctions",
                "PostProcessings",
            ] {
                let pointer: *const c_void = constant(behaviour, hypothesis, name);
                assert!(pointer.is_null(), "{name}");
            }
            assert_eq!(names(behaviour, hypothesis, "Parameters"), PARAMETERS);
            assert_eq!(types(behaviour, hypothesis, "Parameters"), [0; 9]);
            for name in PARAMETERS {
                let default: f64 = constant(
                    behaviour,
                    hypothesis,
                    &format!("{name}_ParameterDefaultValue"),
                );
                assert_eq!(default, 0.0, "the library's own");
            }
            let law = NativeLaw::new(&props(), hypothesis.directions());
            // SAFETY: a law that lives, any index.
            let name = |index| text(unsafe { (native().mepc_state_name)(law.pointer, index) });
            let expected: Vec<String> = (0..).map_while(name).collect();
            assert_eq!(expected.len(), hypothesis.states());
            assert_eq!(
                names(behaviour, hypothesis, "InternalStateVariables"),
                expected
            );
            assert!(
                types(behaviour, hypothesis, "InternalStateVariables")
                    .iter()
                    .all(|scalar| *scalar == 0)
            );
        }
        // Without a hypothesis: three dimensions.
        let count: *const u16 =
            address(&format!("{behaviour}_nInternalStateVariables")).expect("a count");
        // SAFETY: our constant.
        assert_eq!(unsafe { *count }, 84);
        type SetParameter = unsafe extern "C" fn(*const c_char, f64) -> c_int;
        let symbol = format!("{behaviour}_setParameter");
        // SAFETY: the signature of the interface.
        let answer = unsafe {
            let set = library()
                .get::<SetParameter>(symbol.as_bytes())
                .expect("setParameter");
            set(c"Exponent".as_ptr(), 2.0)
        };
        assert_eq!(answer, 0, "the exponent is a property of each point");
    }
}

/// Everything that a call may write, to see that it did not.
fn written(point: &Point) -> Vec<f64> {
    [&point.forces[1][..], &point.states[1], &point.energies[1]].concat()
}

/// An opening with n components, its slip across the axes where there are two directions.
fn oblique(n: usize, normal: f64, slip: f64) -> Vec<f64> {
    [normal, slip, -0.4 * slip][..n].to_vec()
}

#[test]
fn every_operator_request() {
    let props = props();
    let (kn, gap0, mu, gcr, chi) = (props[6], props[7], props[0], props[1], props[2]);
    for behaviour in BEHAVIOURS {
        for hypothesis in HYPOTHESES {
            let n = 1 + hypothesis.directions();
            let mut point = Point::new(behaviour, hypothesis, &props, 0.4);
            let opening = |normal: f64, slip: f64| oblique(n, normal, slip);
            let first = opening(-0.002, 0.0009);
            point.step(&first, NO_OPERATOR).expect("a first step");
            let pressure = |normal: f64| -kn * (normal + gap0);
            let diagonal = |normal: f64| {
                let mut rows = vec![0.0; n * n];
                for i in 0..n {
                    rows[i * n + i] = if i == 0 {
                        kn
                    } else {
                        chi * mu * pressure(normal) / gcr
                    };
                }
                rows
            };
            let close = |found: &[f64], expected: &[f64], what: &str| {
                for (a, b) in found.iter().zip(expected) {
                    assert!(
                        (a - b).abs() <= 1e-10 * expected[n + 1],
                        "{behaviour} {what}: {a} {b}"
                    );
                }
            };

            // Prediction: the stiffness at the start, and nothing is written but K.
            point.open(&opening(-0.0023, -0.0005));
            for (request, what) in [
                (-1.0, "elastic"),
                (-2.0, "secant"),
                (-3.0, "tangent"),
                (99.0, "elastic"),
            ] {
                let before = written(&point);
                assert_eq!(point.call(request), 1);
                assert_eq!(written(&point), before, "{behaviour} {what}");
                let k = point.stiffness();
                if what == "tangent" {
                    // Only the traction's share of the pressure, tau / p, is added to what sticks.
                    let tau = point.traction(0);
                    let mut expected = diagonal(-0.002);
                    for i in 1..n {
                        assert!(tau[i] != 0.0);
                        expected[i * n] = -kn * tau[i] / pressure(-0.002);
                    }
                    close(&k, &expected, what);
                } else {
                    close(&k, &diagonal(-0.002), what);
                }
            }

            // No operator: K stays, the step is integrated.
            assert_eq!(point.call(NO_OPERATOR), 1);
            assert!(point.k.iter().all(|x| *x == 0.0));
            let integrated = written(&point);
            for request in [ELASTIC, SECANT, TANGENT, CONSISTENT, 100.0 + CONSISTENT] {
                point.forces[1].fill(0.0);
                assert_eq!(point.call(request), 1);
                assert_eq!(
                    written(&point),
                    integrated,
                    "the operator changes nothing else"
                );
                let k = point.stiffness();
                match request {
                    ELASTIC => close(&k, &diagonal(-0.0023), "elastic"),
                    SECANT => {
                        // It takes the slip to the rise of the traction along it.
                        let before = point.traction(0);
                        let after = point.traction(1);
                        let slip: Vec<f64> = (1..n).map(|i| opening(0.0, -0.0014)[i]).collect();
                        let rise: f64 = (1..n).map(|i| (after[i] - before[i]) * slip[i - 1]).sum();
                        let length: f64 = slip.iter().map(|s| s * s).sum();
                        let mut expected = diagonal(-0.0023);
                        for i in 1..n {
                            expected[i * n + i] = rise / length;
                        }
                        close(&k, &expected, "secant");
                        assert!(rise > 0.0 && expected[n + 1] < diagonal(-0.0023)[n + 1]);
                    }
                    _ => assert!(k[n] != 0.0 && k[1] == 0.0, "not symmetric"),
                }
            }

            // Nothing slips: the secant is the stiffness of what sticks.
            point.accept();
            assert_eq!(point.call(SECANT), 1);
            close(
                &point.stiffness(),
                &diagonal(-0.0023),
                "secant without slip",
            );

            // The speed of sound changes nothing, and a number of no meaning is refused.
            for odd in [
                f64::NAN,
                f64::from_bits(0x7ff4_0000_0000_0000),
                f64::INFINITY,
            ] {
                assert_eq!(point.call(odd), -1);
            }

            // Without energies and message.
            point.extras = false;
            assert_eq!(point.call(CONSISTENT), 1);
            point.properties[0] = -1.0;
            assert_eq!(point.call(CONSISTENT), -1);
        }
    }
}

/// Falling pressure takes traction away: along a slip that goes on the secant would be negative, along one that turns
/// steeper than what sticks.
#[test]
fn the_secant_is_not_negative_nor_steeper_than_what_sticks() {
    let props = props();
    let (kn, gap0, mu, gcr, chi) = (props[6], props[7], props[0], props[1], props[2]);
    for behaviour in BEHAVIOURS {
        for hypothesis in HYPOTHESES {
            let n = 1 + hypothesis.directions();
            let mut point = Point::new(behaviour, hypothesis, &props, 0.4);
            let opening = |normal: f64, slip: f64| oblique(n, normal, slip);
            let slip = 0.0009;
            point
                .step(&opening(-0.002, slip), NO_OPERATOR)
                .expect("a first step");
            let normal = -0.0015;
            let sticking = -chi * mu * kn * (normal + gap0) / gcr;
            for (further, expected) in [(1e-5, 0.0), (-1e-5, sticking)] {
                point.open(&opening(normal, slip + further));
                assert_eq!(point.call(SECANT), 1);
                let rise = (point.traction(1)[1] - point.traction(0)[1]) / further;
                assert!(!(0.0..=sticking).contains(&rise), "nothing to clamp");
                let k = point.stiffness();
                for (i, j) in (1..n).flat_map(|i| (1..n).map(move |j| (i, j))) {
                    let expected = if i == j { expected } else { 0.0 };
                    assert!(
                        (k[i * n + j] - expected).abs() <= 1e-10 * sticking,
                        "{behaviour}: {} {expected}",
                        k[i * n + j]
                    );
                }
            }
        }
    }
}

#[test]
fn a_failure_says_why_and_asks_for_a_smaller_step() {
    for behaviour in BEHAVIOURS {
        let bad = [
            (0, -0.3, "FrictionCoefficient = -0.3"),
            (1, 0.0, "CriticalSlip = 0"),
            (2, 0.5, "Exponent = 0.5"),
            (3, 0.0, "NormalStiffness = 0"),
            (4, f64::NAN, "InitialGap = NaN"),
            (5, -2.0, "ReferencePressure = -2"),
            (6, 0.0, "Thickness = 0"),
        ];
        for (index, value, words) in bad {
            let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
            if index >= point.properties.len() {
                continue;
            }
            point.properties[index] = value;
            let before = written(&point);
            let message = point
                .step(&[-0.001, 1e-4, 0.0], CONSISTENT)
                .expect_err("refused");
            assert!(message.contains(words), "{message}");
            assert!(point.rdt < 1.0, "{}", point.rdt);
            assert_eq!(written(&point), before);
        }
        let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
        let message = point
            .step(&[-0.001, f64::NAN, 0.0], CONSISTENT)
            .expect_err("refused");
        let gradient = match behaviour {
            "MemoryPenaltyContact" => "OpeningDisplacement[1] = NaN",
            _ => "jump of Strain[4] = NaN",
        };
        assert!(message.contains(gradient), "{message}");
        let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
        point.states[0][9] = f64::NAN;
        let message = point
            .step(&[-0.001, 1e-4, 0.0], CONSISTENT)
            .expect_err("refused");
        assert!(
            message.contains("s0.internal_state_variables[9] Forgotten = NaN"),
            "{message}"
        );
        let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
        point.states[0][10] = 99.0;
        point.states[0][11] = 2.0;
        let message = point
            .step(&[-0.001, 1e-4, 0.0], CONSISTENT)
            .expect_err("refused");
        assert!(message.contains("Knots = 99"), "{message}");
    }
}

#[test]
fn a_repeated_step_gives_the_same_bits() {
    for behaviour in BEHAVIOURS {
        let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
        point
            .step(&[-0.002, 0.001, 0.0005], CONSISTENT)
            .expect("a step");
        point.open(&[-0.0025, -0.001, 0.0]);
        assert_eq!(point.call(CONSISTENT), 1);
        let once = (written(&point), point.k.clone());
        // A rejected attempt in between.
        point.open(&[-0.01, 0.5, 0.0]);
        assert_eq!(point.call(CONSISTENT), 1);
        point.open(&[-0.0025, -0.001, 0.0]);
        assert_eq!(point.call(CONSISTENT), 1);
        assert_eq!(once, (written(&point), point.k.clone()));
    }
}

/// States that a host keeps in single precision.
#[test]
fn states_in_single_precision_are_taken() {
    for behaviour in BEHAVIOURS {
        for hypothesis in HYPOTHESES {
            let n = 1 + hypothesis.directions();
            let mut point = Point::new(behaviour, hypothesis, &props(), 0.4);
            for step in 0..100 {
                let phase = f64::from(step) * 0.7;
                let opening = oblique(n, -0.003 - 0.0015 * phase.cos(), 0.003 * phase.sin());
                point
                    .step(&opening, CONSISTENT)
                    .expect("a state in single precision");
                for x in &mut point.states[0] {
                    *x = f64::from(*x as f32);
                }
            }
        }
    }
}

/// The stored energy holds the normal spring: pressed without friction, all the work comes back.
#[test]
fn the_stored_energy_holds_the_normal_spring() {
    let mut props = props();
    props[0] = 0.0;
    for behaviour in BEHAVIOURS {
        for hypothesis in HYPOTHESES {
            let n = 1 + hypothesis.directions();
            let mut point = Point::new(behaviour, hypothesis, &props, 0.4);
            for normal in [-0.003, -0.0005, 0.002, -0.004] {
                let row = point
                    .step(&oblique(n, normal, 0.0), CONSISTENT)
                    .expect("a step");
                let deep = f64::max(0.0, -(normal + props[7]));
                let expected = 0.5 * props[6] * deep * deep;
                assert!((row[n] - expected).abs() <= 1e-12 * 0.5 * props[6] * 1e-5);
                assert_eq!(row[n + 1], 0.0);
            }
        }
    }
}

/// Parameters: a cap of the limit traction, set for all points of a behaviour, in a process of its own.
#[test]
fn parameters_are_set_for_all_points() {
    let program = std::env::current_exe().expect("this program");
    let arguments = ["--exact", "mfront::parameters", "--ignored", "--nocapture"];
    let output = std::process::Command::new(program).args(arguments).output();
    let output = output.expect("this program runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
#[ignore = "run by parameters_are_set_for_all_points"]
fn parameters() {
    type SetParameter = unsafe extern "C" fn(*const c_char, f64) -> c_int;
    let set = |behaviour: &str, name: &CStr, value: f64| {
        let symbol = format!("{behaviour}_setParameter");
        // SAFETY: the signature of the interface.
        unsafe {
            library()
                .get::<SetParameter>(symbol.as_bytes())
                .expect("it")(name.as_ptr(), value)
        }
    };
    for behaviour in BEHAVIOURS {
        assert_eq!(set(behaviour, c"MaximalTraction", 4.0), 1);
        let mut point = Point::new(behaviour, Hypothesis::Tridimensional, &props(), 0.4);
        let row = point.step(&[-0.003, 0.1, 0.0], CONSISTENT).expect("a step");
        assert!((row[1] - 4.0).abs() < 1e-12, "{}", row[1]);
        assert_eq!(set(behaviour, c"Method", 7.0), 1);
        let words = point
            .step(&[-0.003, 0.1, 0.0], CONSISTENT)
            .expect_err("refused");
        assert!(words.contains("Method = 7"), "{words}");
        assert_eq!(set(behaviour, c"Method", 0.0), 1);
        assert_eq!(set(behaviour, c"MaximalTraction", 0.0), 1);
    }
}
