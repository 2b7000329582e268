//! The MFront face: two behaviours of the "generic" interface, for MGIS, MTest and OpenGeoSys.
//!
//! `MemoryPenaltyContact` is a cohesive zone (opening to traction), `MemoryPenaltyLayer` the same contact as a thin
//! layer of small strain. The names of symbols, properties and state variables are contracts.
#![allow(non_upper_case_globals)]

use super::arguments::{array, null, positive, read, write};
use super::components::{Components, Operator, Order, consistent, sticking, uncoupled};
use super::guard;
use super::laws::{ONE, TWO, ThreadLaws, with_law};
use super::messages::note;
use super::refusal::cut_back;
use crate::error::{Error, Kind};
use crate::law::{InterfaceResponse, Law, Start};
use crate::memory::Vector;
use crate::number::finite;
use crate::state::{End, HEADER};
use libc::{c_char, c_double, c_int, c_ushort};
use std::f64::consts::SQRT_2;
use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::{ptr, slice};

/// State variables: the default sizes for two directions and for one.
const STATE_TWO: usize = HEADER + 24 * 3;
const STATE_ONE: usize = HEADER + 16 * 2;
/// Room for a message and its end.
const MESSAGE: usize = 512;

/// The material properties of a point in their order (the last one only for the layer), and the entry of PROPS, from 0,
/// that each one is; the thickness is none.
const PROPERTIES: [(&CStr, usize); 7] = [
    (c"FrictionCoefficient", 0),
    (c"CriticalSlip", 1),
    (c"Exponent", 2),
    (c"NormalStiffness", 6),
    (c"InitialGap", 7),
    (c"ReferencePressure", 4),
    (c"Thickness", usize::MAX),
];
const COHESIVE_PROPERTIES: usize = PROPERTIES.len() - 1;

/// The parameters of a behaviour, the same for all points, and the entries of PROPS that they are. Their default is 0,
/// which is PROPS' own.
const PARAMETERS: [(&CStr, usize); 9] = [
    (c"Method", 3),
    (c"NormalExponent", 8),
    (c"Backbone", 9),
    (c"Beta", 10),
    (c"Cohesion", 11),
    (c"MaximalTraction", 12),
    (c"LateFrictionCoefficient", 13),
    (c"LateSlipLength", 14),
    (c"Resolution", 15),
];
/// The entries of PROPS that are set.
const PROPS: usize = 16;

/// The values of a behaviour's parameters, by their bits.
struct Parameters([AtomicU64; PARAMETERS.len()]);

impl Parameters {
    const fn new() -> Self {
        Parameters([const { AtomicU64::new(0) }; PARAMETERS.len()])
    }

    /// Sets one; false when there is none of that name.
    fn set(&self, name: &CStr, value: f64) -> bool {
        let found = PARAMETERS.iter().position(|(known, _)| *known == name);
        found
            .inspect(|index| self.0[*index].store(value.to_bits(), Ordering::Relaxed))
            .is_some()
    }

    fn get(&self, index: usize) -> f64 {
        f64::from_bits(self.0[index].load(Ordering::Relaxed))
    }
}

/// What a behaviour holds at one end of the time step.
#[repr(C)]
pub struct State {
    gradients: *const c_double,
    thermodynamic_forces: *mut c_double,
    _mass_density: *const c_double,
    material_properties: *const c_double,
    internal_state_variables: *mut c_double,
    stored_energy: *mut c_double,
    dissipated_energy: *mut c_double,
    _external_state_variables: *const c_double,
}

/// The argument of a behaviour: layout of version 1 of the interface. Only `s1` and the first part are written.
#[repr(C)]
pub struct BehaviourData {
    error_message: *mut c_char,
    _dt: c_double,
    k: *mut c_double,
    rdt: *mut c_double,
    _speed_of_sound: *mut c_double,
    s0: State,
    s1: State,
}

// Other compilers made the other side of this.
const _: () = assert!(size_of::<State>() == 64 && size_of::<BehaviourData>() == 168);

/// The two behaviours.
#[derive(Clone, Copy, PartialEq)]
enum Behaviour {
    Contact,
    Layer,
}

/// A stiffness that a caller may ask for in K[0].
#[derive(Clone, Copy, PartialEq)]
enum Stiffness {
    Elastic,
    Secant,
    Tangent,
}

/// What K[0] asks for.
#[derive(Clone, Copy, PartialEq)]
enum Request {
    /// The stiffness at the start of the step; nothing is integrated.
    Predict(Stiffness),
    /// Integration, and a stiffness at its end if any.
    Integrate(Option<Stiffness>),
}

impl Request {
    fn new(k0: f64) -> Result<Self, Error> {
        if !finite(k0) {
            let expected = "must be a finite number that asks for an operator";
            return Err(Error::about(Kind::BadInput, "K", expected)
                .index(0)
                .number(k0));
        }
        // Not before: a compiler may compare first, and comparing a NaN raises a flag that hosts trap.
        let k0 = std::hint::black_box(k0);
        // The speed of sound is asked for by 100 more; a contact has none.
        let k0 = if k0 > 50.0 { k0 - 100.0 } else { k0 };
        let stiffness = |size: f64| match size {
            size if size < 1.5 => Stiffness::Elastic,
            size if size < 2.5 => Stiffness::Secant,
            _ => Stiffness::Tangent,
        };
        Ok(if k0 < -0.25 {
            Request::Predict(stiffness(-k0))
        } else if k0 < 0.5 {
            Request::Integrate(None)
        } else {
            Request::Integrate(Some(stiffness(k0)))
        })
    }
}

impl Behaviour {
    /// How many material properties there are.
    const fn properties(self) -> usize {
        match self {
            Behaviour::Contact => COHESIVE_PROPERTIES,
            Behaviour::Layer => PROPERTIES.len(),
        }
    }

    /// Where the components of the interface are.
    fn components<const N: usize>(self, thickness: f64) -> Components {
        let (size, slots, weights) = match (self, N) {
            (Behaviour::Contact, 1) => (2, [0, 1, 1], [1.0; 3]),
            (Behaviour::Contact, _) => (3, [0, 1, 2], [1.0; 3]),
            (Behaviour::Layer, 1) => (4, [1, 3, 3], [1.0, SQRT_2, SQRT_2]),
            (Behaviour::Layer, _) => (6, [2, 4, 5], [1.0, SQRT_2, SQRT_2]),
        };
        Components {
            size,
            slots,
            weights,
            length: thickness,
        }
    }

    /// The values of its parameters.
    fn parameters(self) -> &'static Parameters {
        static CONTACT: Parameters = Parameters::new();
        static LAYER: Parameters = Parameters::new();
        match self {
            Behaviour::Contact => &CONTACT,
            Behaviour::Layer => &LAYER,
        }
    }

    /// Sets a parameter: 1 is success, 0 failure.
    ///
    /// # Safety
    /// `name` is null or a C string.
    unsafe fn set_parameter(self, name: *const c_char, value: c_double) -> c_int {
        if name.is_null() {
            return 0;
        }
        // SAFETY: a C string by the caller's word.
        c_int::from(
            self.parameters()
                .set(unsafe { CStr::from_ptr(name) }, value),
        )
    }

    /// The body of the exported functions: 1 is success, -1 failure.
    ///
    /// # Safety
    /// `data` is null or what the interface says.
    unsafe fn call<const N: usize>(
        self,
        data: *mut BehaviourData,
        laws: &'static ThreadLaws<N>,
    ) -> c_int {
        // SAFETY: null or readable by the caller's word.
        let Some(data) = (unsafe { data.as_ref() }) else {
            return -1;
        };
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe { self.update(data, laws) });
        let Err(mut error) = outcome else {
            return 1;
        };
        if error.argument == "PROPS" {
            // The host has names for them, and its user knows no others.
            error.name = "".into();
        }
        let host_name = |ours: &str, index| self.host_name::<N>(ours, index);
        // SAFETY: null or as the interface says.
        unsafe {
            complain(data.error_message, &error.words(host_name));
            cut_back(data.rdt);
        }
        // Not every host prints it.
        note("MFront behaviour", &error, &host_name);
        -1
    }

    /// # Safety
    /// Pointers of `data` are null or what the interface says for N directions.
    unsafe fn update<const N: usize>(
        self,
        data: &BehaviourData,
        laws: &'static ThreadLaws<N>,
    ) -> Result<(), Error> {
        // SAFETY: sizes by the caller's word; K[0] is read before K is written.
        unsafe {
            let request = Request::new(read("K", data.k)?)?;
            let given = array(
                "material_properties",
                data.s1.material_properties,
                self.properties(),
            )?;
            let thickness = given.get(COHESIVE_PROPERTIES).copied().unwrap_or(1.0);
            let thickness = positive(Kind::BadProperty, "Thickness", thickness)?;
            let nstate = if N == 1 { STATE_ONE } else { STATE_TWO };
            with_law(laws, &self.props(given), nstate, |law| {
                self.answer(data, law, request, thickness)
            })
        }
    }

    /// # Safety
    /// As [`Behaviour::update`].
    unsafe fn answer<const N: usize>(
        self,
        data: &BehaviourData,
        law: &Law<N>,
        request: Request,
        thickness: f64,
    ) -> Result<(), Error> {
        let (s0, s1) = (&data.s0, &data.s1);
        let components = self.components::<N>(thickness);
        let nstate = law.layout().nstate;
        let (mut start, mut end) = (Start::new(), End::new());
        // SAFETY: sizes by the caller's word; everything is read before anything is written, for a caller may use one
        // array for both ends.
        unsafe {
            let gcr = law.critical_slip(0.0)?;
            let state0 = array(
                "s0.internal_state_variables",
                s0.internal_state_variables,
                nstate,
            )?;
            law.read(state0, &mut start)?;
            let before = array("s0.gradients", s0.gradients, components.size)?;
            let (normal_before, jump_before) = components.opening::<N>(before);
            let stiffness = match request {
                Request::Predict(stiffness) => {
                    let response = law.interface_from(
                        &mut start,
                        gcr,
                        normal_before,
                        &jump_before,
                        1.0,
                        &mut end,
                    )?;
                    Some(match stiffness {
                        Stiffness::Tangent => consistent(&response),
                        // Without an increment the secant is the stiffness of what sticks.
                        Stiffness::Elastic | Stiffness::Secant => sticking(law, gcr, &response),
                    })
                }
                Request::Integrate(stiffness) => {
                    let after = array("s1.gradients", s1.gradients, components.size)?;
                    let forces = array(
                        "s0.thermodynamic_forces",
                        s0.thermodynamic_forces,
                        components.size,
                    )?;
                    if s1.thermodynamic_forces.is_null() {
                        return Err(null("s1.thermodynamic_forces"));
                    }
                    if s1.internal_state_variables.is_null() {
                        return Err(null("s1.internal_state_variables"));
                    }
                    let (normal, jump) = components.opening::<N>(after);
                    let response =
                        law.interface_from(&mut start, gcr, normal, &jump, 1.0, &mut end)?;
                    let operator = stiffness.map(|stiffness| match stiffness {
                        Stiffness::Elastic => sticking(law, gcr, &response),
                        Stiffness::Tangent => consistent(&response),
                        Stiffness::Secant => {
                            let (_, traction) = components.traction::<N>(forces);
                            let slip = jump - jump_before;
                            let rise = response.friction.traction - traction;
                            secant(law, gcr, &response, &slip, &rise)
                        }
                    });
                    let state1 = slice::from_raw_parts_mut(s1.internal_state_variables, nstate);
                    law.layout().write(&end, state1);
                    components.write_forces(&response, s1.thermodynamic_forces);
                    // Energies of the contact are per area, of a layer per volume; its thickness is 1 otherwise.
                    let stored = response.friction.stored + response.normal_energy;
                    write(s1.stored_energy, &[stored / thickness]);
                    write(s1.dissipated_energy, &[end.header.dissipated / thickness]);
                    operator
                }
            };
            if let Some(operator) = stiffness {
                components.write_operator::<N>(&operator, Order::RowMajor, data.k);
            }
        }
        Ok(())
    }

    /// What the host's user calls an argument of the library.
    fn host_name<const N: usize>(self, ours: &str, index: Option<usize>) -> Option<String> {
        let index = index?;
        match (ours, self) {
            ("opening", Behaviour::Contact) => Some(format!("OpeningDisplacement[{index}]")),
            ("opening", Behaviour::Layer) => {
                let slot = *self.components::<N>(1.0).slots.get(index)?;
                Some(format!("jump of Strain[{slot}]"))
            }
            ("state", _) => Some(format!("s0.internal_state_variables[{index}]")),
            ("PROPS", _) => {
                let mut names = PROPERTIES.iter().chain(&PARAMETERS);
                let (name, _) = names.find(|(_, entry)| *entry == index)?;
                Some(name.to_string_lossy().into_owned())
            }
            _ => None,
        }
    }

    /// PROPS in the library's order.
    fn props(self, given: &[f64]) -> [f64; PROPS] {
        let mut props = [0.0; PROPS];
        for ((_, entry), value) in PROPERTIES[..COHESIVE_PROPERTIES].iter().zip(given) {
            props[*entry] = *value;
        }
        for (index, (_, entry)) in PARAMETERS.iter().enumerate() {
            props[*entry] = self.parameters().get(index);
        }
        props
    }
}

/// The secant over the increment: the tangential stiffness that takes the slip to the rise of the traction along it,
/// never more than that of sticking nor less than zero; that of sticking when nothing slips.
fn secant<const N: usize>(
    law: &Law<N>,
    gcr: f64,
    response: &InterfaceResponse<N>,
    slip: &Vector<N>,
    rise: &Vector<N>,
) -> Operator {
    let elastic = law.sticking_stiffness(gcr, -response.normal_traction);
    let length2 = slip.norm_squared();
    // Not by zero: compilers divide first, and some hosts trap that. Without slip by 1.
    let slope = rise.dot(slip) / (length2 + f64::from(u8::from(length2 == 0.0)));
    let slips = length2 > 0.0 && slope.is_finite();
    uncoupled(
        response.normal_stiffness,
        if slips {
            slope.clamp(0.0, elastic)
        } else {
            elastic
        },
    )
}

/// Writes a failure as a C string.
///
/// # Safety
/// `message` is null or has room for 512 characters.
#[cold]
unsafe fn complain(message: *mut c_char, words: &str) {
    if message.is_null() {
        return;
    }
    let text = format!("mepc: {words}");
    let ascii = text.bytes().map(|byte| {
        if byte.is_ascii() && byte != 0 {
            byte
        } else {
            b'?'
        }
    });
    let text: Vec<u8> = ascii.take(MESSAGE - 1).chain([0]).collect();
    // SAFETY: no more than 512 characters, which there is room for by the caller's word.
    unsafe { message.copy_from_nonoverlapping(text.as_ptr().cast(), text.len()) }
}

/// A table of constants with addresses in it, for the host to read.
#[repr(transparent)]
pub struct Table<T>(T);

// SAFETY: the addresses are those of constants, and nothing is ever written.
unsafe impl<T> Sync for Table<T> {}

type Name = *const c_char;
type Names<const L: usize> = Table<[Name; L]>;

/// The first names of a list of properties or parameters.
const fn first_names<const L: usize>(list: &[(&'static CStr, usize)]) -> Names<L> {
    let mut names = [ptr::null(); L];
    let mut index = 0;
    while index < L {
        names[index] = list[index].0.as_ptr();
        index += 1;
    }
    Table(names)
}

/// A C string of pieces.
macro_rules! text {
    ($($piece:expr),*) => {
        concat!($($piece,)* "\0").as_ptr().cast::<c_char>()
    };
}

/// Names of the state variables, as mepc_state_name gives them (a test compares).
macro_rules! state_names {
    ($($knot:literal)*, directions $directions:tt) => {
        Table(state_names!(@flatten
            [text!("ContactStatus"), text!("Pressure"), text!("ShearLimit"), text!("StoredEnergy"),
             text!("DissipatedEnergy"), text!("SlipLength"), text!("NormalOpening"), text!("TangentialJump1"),
             text!("TangentialJump2"), text!("Forgotten"), text!("Knots"), text!("Layout"),]
            [$($knot)*] $directions))
    };
    (@flatten [$($header:tt)*] [$($knot:literal)*] 1) => {
        [$($header)* $(text!("Knot", $knot, "_R"), text!("Knot", $knot, "_u1"),)*]
    };
    (@flatten [$($header:tt)*] [$($knot:literal)*] 2) => {
        [$($header)* $(text!("Knot", $knot, "_R"), text!("Knot", $knot, "_u1"), text!("Knot", $knot, "_u2"),)*]
    };
}

/// A constant that the host looks up by name.
macro_rules! symbol {
    ($behaviour:literal, $name:literal, $rust:ident: $type:ty = $value:expr) => {
        #[doc = concat!("`", $behaviour, $name, "` of the generic interface.")]
        #[unsafe(export_name = concat!($behaviour, $name))]
        pub static $rust: $type = $value;
    };
}

/// The defaults of the parameters.
macro_rules! parameter_defaults {
    ($behaviour:literal, $($rust:ident $name:literal),*) => {
        $(
            #[doc = concat!("The default of the parameter `", $name, "`: the library's own.")]
            #[unsafe(export_name = concat!($behaviour, "_", $name, "_ParameterDefaultValue"))]
            pub static $rust: c_double = 0.0;
        )*
    };
}

/// Everything that describes one behaviour: the union of what the known hosts look up.
macro_rules! behaviour {
    (
        $module:ident, $behaviour:literal, $kind:expr, type $type:literal, kinematic $kinematic:literal,
        gradient $gradient:literal, force $force:literal, of type $tensor:literal
    ) => {
        #[doc = concat!("The symbols of `", $behaviour, "`.")]
        pub mod $module {
            use super::*;

            const COUNT: usize = $kind.properties();

            symbol!($behaviour, "_mfront_mkt", mkt: c_ushort = 1);
            symbol!($behaviour, "_mfront_interface", interface: Table<Name> = Table(text!("Generic")));
            symbol!($behaviour, "_api_version", api_version: c_ushort = 1);
            symbol!($behaviour, "_BehaviourType", behaviour_type: c_ushort = $type);
            symbol!($behaviour, "_BehaviourKinematic", kinematic: c_ushort = $kinematic);
            symbol!($behaviour, "_SymmetryType", symmetry: c_ushort = 0);
            symbol!($behaviour, "_ElasticSymmetryType", elastic_symmetry: c_ushort = 0);
            symbol!($behaviour, "_requiresStiffnessTensor", stiffness_tensor: c_ushort = 0);
            symbol!($behaviour, "_requiresThermalExpansionCoefficientTensor", expansion_tensor: c_ushort = 0);
            symbol!($behaviour, "_ComputesInternalEnergy", internal_energy: c_ushort = 1);
            symbol!($behaviour, "_ComputesDissipatedEnergy", dissipated_energy: c_ushort = 1);
            symbol!($behaviour, "_UsableInPurelyImplicitResolution", purely_implicit: c_ushort = 0);
            symbol!($behaviour, "_TemperatureRemovedFromExternalStateVariables", no_temperature: c_ushort = 0);

            symbol!($behaviour, "_nGradients", gradient_count: c_ushort = 1);
            symbol!($behaviour, "_Gradients", gradients: Names<1> = Table([text!($gradient)]));
            symbol!($behaviour, "_GradientsTypes", gradient_types: [c_int; 1] = [$tensor]);
            symbol!($behaviour, "_nThermodynamicForces", force_count: c_ushort = 1);
            symbol!($behaviour, "_ThermodynamicForces", forces: Names<1> = Table([text!($force)]));
            symbol!($behaviour, "_ThermodynamicForcesTypes", force_types: [c_int; 1] = [$tensor]);
            // One block, d force / d gradient; counted in strings.
            symbol!($behaviour, "_nTangentOperatorBlocks", block_count: c_ushort = 2);
            symbol!($behaviour, "_TangentOperatorBlocks", blocks: Names<2> = Table([text!($force), text!($gradient)]));

            symbol!($behaviour, "_nMaterialProperties", property_count: c_ushort = COUNT as c_ushort);
            symbol!($behaviour, "_MaterialProperties", properties: Names<COUNT> = first_names(&super::PROPERTIES));

            symbol!($behaviour, "_nExternalStateVariables", external_count: c_ushort = 0);
            symbol!($behaviour, "_ExternalStateVariables", external: Table<*const Name> = Table(ptr::null()));
            symbol!($behaviour, "_ExternalStateVariablesTypes", external_types: Table<*const c_int> = Table(ptr::null()));
            symbol!($behaviour, "_nParameters", parameter_count: c_ushort = PARAMETERS.len() as c_ushort);
            symbol!($behaviour, "_Parameters", parameters: Names<{ PARAMETERS.len() }> = first_names(&PARAMETERS));
            symbol!($behaviour, "_ParametersTypes", parameter_types: [c_int; PARAMETERS.len()] = [0; PARAMETERS.len()]);
            parameter_defaults!($behaviour, method "Method", normal_exponent "NormalExponent", backbone "Backbone",
                beta "Beta", cohesion "Cohesion", cap "MaximalTraction", late_friction "LateFrictionCoefficient",
                late_slip "LateSlipLength", resolution "Resolution");
            symbol!($behaviour, "_nInitializeFunctions", initialize_count: c_ushort = 0);
            symbol!($behaviour, "_InitializeFunctions", initialize: Table<*const Name> = Table(ptr::null()));
            symbol!($behaviour, "_nPostProcessings", post_count: c_ushort = 0);
            symbol!($behaviour, "_PostProcessings", post: Table<*const Name> = Table(ptr::null()));

            symbol!($behaviour, "_nModellingHypotheses", hypothesis_count: c_ushort = 2);
            symbol!($behaviour, "_ModellingHypotheses", hypotheses: Names<2> =
                Table([text!("PlaneStrain"), text!("Tridimensional")]));

            // The state depends on the hypothesis. A host looks up the name with the hypothesis first.
            symbol!($behaviour, "_nInternalStateVariables", state_count: c_ushort = STATE_TWO as c_ushort);
            symbol!($behaviour, "_InternalStateVariables", state: Names<STATE_TWO> = TWO_NAMES);
            symbol!($behaviour, "_InternalStateVariablesTypes", state_types: [c_int; STATE_TWO] = [0; STATE_TWO]);
            symbol!($behaviour, "_Tridimensional_nInternalStateVariables", state_count_3: c_ushort = STATE_TWO as c_ushort);
            symbol!($behaviour, "_Tridimensional_InternalStateVariables", state_3: Names<STATE_TWO> = TWO_NAMES);
            symbol!($behaviour, "_Tridimensional_InternalStateVariablesTypes", state_types_3: [c_int; STATE_TWO] =
                [0; STATE_TWO]);
            symbol!($behaviour, "_PlaneStrain_nInternalStateVariables", state_count_2: c_ushort = STATE_ONE as c_ushort);
            symbol!($behaviour, "_PlaneStrain_InternalStateVariables", state_2: Names<STATE_ONE> = ONE_NAMES);
            symbol!($behaviour, "_PlaneStrain_InternalStateVariablesTypes", state_types_2: [c_int; STATE_ONE] =
                [0; STATE_ONE]);

            /// Sets a parameter of all points: 1 is success, 0 failure. Its value is checked when it is used.
            ///
            /// # Safety
            /// `name` is null or a C string.
            #[unsafe(export_name = concat!($behaviour, "_setParameter"))]
            pub unsafe extern "C" fn set_parameter(name: *const c_char, value: c_double) -> c_int {
                // SAFETY: the host's arguments.
                unsafe { $kind.set_parameter(name, value) }
            }

            /// Integration in three dimensions: two tangential directions.
            ///
            /// # Safety
            /// `data` is null or what the generic interface says.
            #[unsafe(export_name = concat!($behaviour, "_Tridimensional"))]
            pub unsafe extern "C" fn tridimensional(data: *mut BehaviourData) -> c_int {
                // SAFETY: the host's argument.
                unsafe { $kind.call(data, &TWO) }
            }

            /// Integration in plane strain: one tangential direction.
            ///
            /// # Safety
            /// `data` is null or what the generic interface says.
            #[unsafe(export_name = concat!($behaviour, "_PlaneStrain"))]
            pub unsafe extern "C" fn plane_strain(data: *mut BehaviourData) -> c_int {
                // SAFETY: the host's argument.
                unsafe { $kind.call(data, &ONE) }
            }
        }
    };
}

const TWO_NAMES: Names<STATE_TWO> =
    state_names!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24, directions 2);
const ONE_NAMES: Names<STATE_ONE> =
    state_names!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16, directions 1);

behaviour!(
    contact, "MemoryPenaltyContact", Behaviour::Contact, type 3, kinematic 2,
    gradient "OpeningDisplacement", force "CohesiveForce", of type 2
);
behaviour!(
    layer, "MemoryPenaltyLayer", Behaviour::Layer, type 1, kinematic 1,
    gradient "Strain", force "Stress", of type 1
);
