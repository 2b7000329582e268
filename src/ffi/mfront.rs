//! The MFront face: two behaviours of the "generic" interface, for MGIS, MTest and OpenGeoSys.
//!
//! `MemoryPenaltyContact` is a cohesive zone (opening to traction), `MemoryPenaltyLayer` the same contact as a thin
//! layer of small strain. The names of symbols, properties and state variables are contracts.
#![allow(non_upper_case_globals)]

use super::components::{Components, Operator, Order, consistent, sticking, uncoupled};
use super::guard;
use super::user::{self, CUTBACK, ThreadLaws, array, null, read, with_law, write};
use crate::error::{Error, Kind};
use crate::law::{InterfaceResponse, Law};
use crate::memory::Vector;
use libc::{c_char, c_double, c_int, c_ushort};
use std::f64::consts::SQRT_2;
use std::ffi::CStr;
use std::ptr;

/// State variables: the default sizes for two directions and for one.
const STATE_TWO: usize = 64;
const STATE_ONE: usize = 25;
/// Room for a message and its end.
const MESSAGE: usize = 512;

/// The material properties in their order (the last one only for the layer), and what the library calls them.
const PROPERTIES: [(&CStr, &str); 8] = [
    (c"FrictionCoefficient", "PROPS(1) mu"),
    (c"CriticalSlip", "PROPS(2) gcr"),
    (c"Exponent", "PROPS(3) chi"),
    (c"NormalStiffness", "PROPS(7) kn"),
    (c"InitialGap", "PROPS(8) gap0"),
    (c"Method", "PROPS(4) method"),
    (c"PressureRule", "PROPS(5) pressure_rule"),
    (c"Thickness", ""),
];
/// Place of the accumulated dissipation in a state.
const DISSIPATED: usize = 3;
const COHESIVE_PROPERTIES: usize = PROPERTIES.len() - 1;

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
        if !k0.is_finite() {
            let message = format!("K[0] = {k0}: must be a finite number that asks for an operator");
            return Err(Error::new(Kind::BadInput, message));
        }
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
        let Err(error) = outcome.map_err(|error| self.in_host_words::<N>(error)) else {
            return 1;
        };
        // SAFETY: null or as the interface says.
        unsafe {
            complain(data.error_message, &error);
            // Not every host prints it.
            super::host::note("MFront behaviour", &error);
            if let Some(rdt) = data.rdt.as_mut() {
                *rdt = rdt.min(CUTBACK);
            }
        }
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
            let (props, thickness) = self.convert(given)?;
            let nstate = if N == 1 { STATE_ONE } else { STATE_TWO };
            with_law(laws, &props, nstate, |law| {
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
        // SAFETY: sizes by the caller's word.
        unsafe {
            let gcr = law.critical_slip(0.0)?;
            let state0 = array(
                "s0.internal_state_variables",
                s0.internal_state_variables,
                nstate,
            )?;
            let start = array("s0.gradients", s0.gradients, components.size)?;
            let stiffness = match request {
                Request::Predict(stiffness) => {
                    let (normal, tangential) = components.opening::<N>(start);
                    let mut unused = [0.0; STATE_TWO];
                    let unused = &mut unused[..nstate];
                    let response = law.interface(gcr, normal, &tangential, state0, unused)?;
                    Some(match stiffness {
                        Stiffness::Tangent => consistent(&response),
                        // Without an increment the secant is the stiffness of what sticks.
                        Stiffness::Elastic | Stiffness::Secant => sticking(law, gcr, &response),
                    })
                }
                Request::Integrate(stiffness) => {
                    let end = array("s1.gradients", s1.gradients, components.size)?;
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
                    // A caller may use one array for both ends: the start is copied before the end is written.
                    let (mut start_state, mut end_state) = ([0.0; STATE_TWO], [0.0; STATE_TWO]);
                    start_state[..nstate].copy_from_slice(state0);
                    let (normal, tangential) = components.opening::<N>(end);
                    let response = law.interface(
                        gcr,
                        normal,
                        &tangential,
                        &start_state[..nstate],
                        &mut end_state[..nstate],
                    )?;
                    let operator = stiffness.map(|stiffness| match stiffness {
                        Stiffness::Elastic => sticking(law, gcr, &response),
                        Stiffness::Tangent => consistent(&response),
                        Stiffness::Secant => {
                            let (_, before) = components.opening::<N>(start);
                            let (_, traction) = components.traction::<N>(forces);
                            let slip = tangential - before;
                            let rise = response.friction.traction - traction;
                            secant(law, gcr, &response, &slip, &rise)
                        }
                    });
                    write(s1.internal_state_variables, &end_state[..nstate]);
                    components.write_forces(&response, s1.thermodynamic_forces);
                    // Energies of the contact are per area, of a layer per volume.
                    let dissipated = end_state[DISSIPATED];
                    let volume = if self == Behaviour::Layer {
                        thickness
                    } else {
                        1.0
                    };
                    write(s1.stored_energy, &[response.friction.stored / volume]);
                    write(s1.dissipated_energy, &[dissipated / volume]);
                    operator
                }
            };
            if let Some(operator) = stiffness {
                components.write_operator::<N>(&operator, Order::RowMajor, data.k);
            }
        }
        Ok(())
    }

    /// A failure under the names that the host's user knows.
    #[cold]
    fn in_host_words<const N: usize>(self, error: Error) -> Error {
        let slots = self.components::<N>(1.0).slots;
        let mut error = user::in_host_words(error, |ours, index| match (ours, self) {
            ("opening", Behaviour::Contact) => Some(format!("OpeningDisplacement[{index}]")),
            ("opening", Behaviour::Layer) => Some(format!("jump of Strain[{}]", slots.get(index)?)),
            ("state", _) => Some(format!("s0.internal_state_variables[{index}]")),
            _ => None,
        });
        for (theirs, ours) in &PROPERTIES[..COHESIVE_PROPERTIES] {
            error.message = error.message.replace(ours, &theirs.to_string_lossy());
        }
        error
    }

    /// PROPS in the library's order, and the thickness of the layer (1 for the cohesive zone).
    fn convert(self, given: &[f64]) -> Result<([f64; 8], f64), Error> {
        let thickness = given.get(COHESIVE_PROPERTIES).copied().unwrap_or(1.0);
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(Error::new(
                Kind::BadProperty,
                format!("Thickness = {thickness}: must be finite and > 0"),
            ));
        }
        // There is no characteristic length, so the fraction of it (PROPS 6) has no effect.
        const FRACTION: f64 = 1.0;
        let [mu, gcr, chi, kn, gap0, method, rule] = std::array::from_fn(|index| given[index]);
        Ok(([mu, gcr, chi, method, rule, FRACTION, kn, gap0], thickness))
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
unsafe fn complain(message: *mut c_char, error: &Error) {
    if message.is_null() {
        return;
    }
    let text = format!("mepc: {error}");
    let text: Vec<u8> = text
        .bytes()
        .map(|byte| {
            if byte.is_ascii() && byte != 0 {
                byte
            } else {
                b'?'
            }
        })
        .take(MESSAGE - 1)
        .chain([0])
        .collect();
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

/// The first names of the material properties.
const fn property_names<const L: usize>() -> Names<L> {
    let mut names = [ptr::null(); L];
    let mut index = 0;
    while index < L {
        names[index] = PROPERTIES[index].0.as_ptr();
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
    (base $($base:literal)*, knots $($knot:literal)*, directions $directions:tt) => {
        Table(state_names!(@flatten
            [text!("ContactStatus"), text!("Pressure"), text!("StoredEnergy"), text!("DissipatedEnergy"),
             text!("SlipLength"), text!("TangentialJump1"), text!("TangentialJump2"), text!("FloatingKnots"),]
            [$($base)*] [$($knot)*] $directions))
    };
    (@flatten [$($header:tt)*] [$($base:literal)*] [$($knot:literal)*] 1) => {
        [$($header)* $(text!("Base", $base, "_1"),)* $(text!("Knot", $knot, "_r"), text!("Knot", $knot, "_e1"),)*]
    };
    (@flatten [$($header:tt)*] [$($base:literal)*] [$($knot:literal)*] 2) => {
        [$($header)* $(text!("Base", $base, "_1"), text!("Base", $base, "_2"),)*
         $(text!("Knot", $knot, "_r"), text!("Knot", $knot, "_e1"), text!("Knot", $knot, "_e2"),)*]
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

/// Everything that describes one behaviour: the union of what the known hosts look up.
macro_rules! behaviour {
    (
        $module:ident, $behaviour:literal, $kind:expr, type $type:literal, kinematic $kinematic:literal,
        gradient $gradient:literal, force $force:literal, of type $tensor:literal
    ) => {
        #[doc = concat!("The symbols of `", $behaviour, "`.")]
        pub mod $module {
            use super::*;

            const PROPERTIES: usize = $kind.properties();

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

            symbol!($behaviour, "_nMaterialProperties", property_count: c_ushort = PROPERTIES as c_ushort);
            symbol!($behaviour, "_MaterialProperties", properties: Names<PROPERTIES> = property_names());

            symbol!($behaviour, "_nExternalStateVariables", external_count: c_ushort = 0);
            symbol!($behaviour, "_ExternalStateVariables", external: Table<*const Name> = Table(ptr::null()));
            symbol!($behaviour, "_ExternalStateVariablesTypes", external_types: Table<*const c_int> = Table(ptr::null()));
            symbol!($behaviour, "_nParameters", parameter_count: c_ushort = 0);
            symbol!($behaviour, "_Parameters", parameters: Table<*const Name> = Table(ptr::null()));
            symbol!($behaviour, "_ParametersTypes", parameter_types: Table<*const c_int> = Table(ptr::null()));
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

            /// There are no parameters: always 0, a failure.
            #[unsafe(export_name = concat!($behaviour, "_setParameter"))]
            pub extern "C" fn set_parameter(_name: *const c_char, _value: c_double) -> c_int {
                0
            }

            /// Integration in three dimensions: two tangential directions.
            ///
            /// # Safety
            /// `data` is null or what the generic interface says.
            #[unsafe(export_name = concat!($behaviour, "_Tridimensional"))]
            pub unsafe extern "C" fn tridimensional(data: *mut BehaviourData) -> c_int {
                // SAFETY: the host's argument.
                unsafe { $kind.call(data, &user::TWO) }
            }

            /// Integration in plane strain: one tangential direction.
            ///
            /// # Safety
            /// `data` is null or what the generic interface says.
            #[unsafe(export_name = concat!($behaviour, "_PlaneStrain"))]
            pub unsafe extern "C" fn plane_strain(data: *mut BehaviourData) -> c_int {
                // SAFETY: the host's argument.
                unsafe { $kind.call(data, &user::ONE) }
            }
        }
    };
}

const TWO_NAMES: Names<STATE_TWO> =
    state_names!(base 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16, knots 1 2 3 4 5 6 7 8, directions 2);
const ONE_NAMES: Names<STATE_ONE> = state_names!(base 1, knots 1 2 3 4 5 6 7 8, directions 1);

behaviour!(
    contact, "MemoryPenaltyContact", Behaviour::Contact, type 3, kinematic 2,
    gradient "OpeningDisplacement", force "CohesiveForce", of type 2
);
behaviour!(
    layer, "MemoryPenaltyLayer", Behaviour::Layer, type 1, kinematic 1,
    gradient "Strain", force "Stress", of type 1
);
