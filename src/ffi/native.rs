//! The native C interface, `mepc_*` (include/mepc.h is generated from this file).

// The comments are those of the C header, where [n] is an array of n numbers.
#![allow(rustdoc::broken_intra_doc_links)]

use super::arguments::{array, null, size, write};
use super::guard;
use crate::error::{Error, Kind};
use crate::law::{Law, Start, check_directions, default_state_size};
use crate::memory::Vector;
use crate::state::{Contact, End, Layout};
use arrayvec::ArrayVec;
use libc::{c_char, c_double};
use std::cell::RefCell;
use std::ffi::CString;
use std::num::NonZero;
use std::slice;

/// Points that one thread of a batch is worth starting for, when the library chooses their number.
const POINTS_PER_THREAD: usize = 256;

/// Version of this interface. A program compares it with what mepc_abi_version returns.
pub const MEPC_ABI_VERSION: i32 = 2;
/// Advisory status: the state array is full and a remembered knot that mattered was dropped.
pub const MEPC_MEMORY_FULL: i32 = 1;
/// Advisory status of mepc_iwan_identify: the model does not describe the loop. What was found is written all the same.
pub const MEPC_NOT_DESCRIBED: i32 = 2;
/// Status: a required pointer is null.
pub const MEPC_NULL_POINTER: i32 = -1;
/// Status: a property is missing or out of range.
pub const MEPC_BAD_PROPERTY: i32 = -2;
/// Status: the state array is too short or corrupt.
pub const MEPC_BAD_STATE: i32 = -3;
/// Status: an input is not finite, or a size is out of range.
pub const MEPC_BAD_INPUT: i32 = -4;
/// Status: a defect of the library (a caught panic).
pub const MEPC_INTERNAL: i32 = -5;

/// Contact status, the first number of a state: open, or never closed.
pub const MEPC_CONTACT_OPEN: i32 = 0;
/// Contact status: no more than a hundredth of the stiffness has slipped.
pub const MEPC_CONTACT_STICK: i32 = 1;
/// Contact status: part of the contact slips.
pub const MEPC_CONTACT_MICRO_SLIP: i32 = 2;
/// Contact status: all of it slips.
pub const MEPC_CONTACT_GROSS_SLIP: i32 = 3;

// The header needs plain numbers; they are the discriminants of `Kind` and `Contact`.
const _: () = assert!(
    MEPC_NULL_POINTER == Kind::NullPointer as i32
        && MEPC_BAD_PROPERTY == Kind::BadProperty as i32
        && MEPC_BAD_STATE == Kind::BadState as i32
        && MEPC_BAD_INPUT == Kind::BadInput as i32
        && MEPC_INTERNAL == Kind::Internal as i32
        && MEPC_CONTACT_OPEN == Contact::Open as i32
        && MEPC_CONTACT_STICK == Contact::Stick as i32
        && MEPC_CONTACT_MICRO_SLIP == Contact::MicroSlip as i32
        && MEPC_CONTACT_GROSS_SLIP == Contact::GrossSlip as i32
);

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::new(CString::default());
}

/// Keeps the words of an error for [`mepc_last_error`]; gives its status number.
#[cold]
pub(super) fn remember(error: &Error) -> i32 {
    let text: Vec<u8> = error
        .to_string()
        .bytes()
        .filter(|&byte| byte != 0)
        .collect();
    // While a thread ends its last error is gone; there is nobody left to read it.
    let _ = LAST_ERROR.try_with(|last| {
        *last.borrow_mut() = CString::new(text).unwrap_or_default();
    });
    error.kind as i32
}

pub(super) fn status(result: Result<i32, Error>) -> i32 {
    result.unwrap_or_else(|error| remember(&error))
}

/// A contact law: properties checked once, and everything that follows from them.
///
/// Made by mepc_law_new, released by mepc_law_free. Immutable: any number of threads may use one law at once.
#[allow(non_camel_case_types)]
pub struct mepc_law {
    law: AnyLaw,
    gcr: f64,
    names: Vec<Name>,
}

/// The name of a state variable as C reads it.
type Name = [u8; 24];

enum AnyLaw {
    One(Law<1>),
    Two(Law<2>),
}

impl mepc_law {
    fn new(props: &[f64], ndir: i32, nstate: i32) -> Result<Self, Error> {
        let nstate = usize::try_from(nstate).map_err(|_| {
            Error::about(Kind::BadState, "nstate", "must be positive").count(nstate)
        })?;
        let law = match directions(ndir)? {
            1 => AnyLaw::One(Law::new(props, nstate)?),
            _ => AnyLaw::Two(Law::new(props, nstate)?),
        };
        let (gcr, layout) = match &law {
            AnyLaw::One(law) => (law.critical_slip(0.0)?, *law.layout()),
            AnyLaw::Two(law) => (law.critical_slip(0.0)?, *law.layout()),
        };
        let mut names = Vec::new();
        names.try_reserve_exact(nstate).map_err(|_| {
            let expected = "must be such that the names of the state variables fit into memory";
            Error::about(Kind::BadState, "nstate", expected).count(nstate)
        })?;
        for name in (0..).map_while(|index| layout.slot_name(index)) {
            let mut letters = Name::default();
            letters[..name.len()].copy_from_slice(name.as_bytes());
            names.push(letters);
        }
        Ok(mepc_law { law, gcr, names })
    }

    fn layout(&self) -> &Layout {
        match &self.law {
            AnyLaw::One(law) => law.layout(),
            AnyLaw::Two(law) => law.layout(),
        }
    }
}

/// The number of tangential directions, 1 or 2.
fn directions(ndir: i32) -> Result<usize, Error> {
    let expected = "must be 1 or 2 tangential directions";
    let number = usize::try_from(ndir)
        .map_err(|_| Error::about(Kind::BadInput, "ndir", expected).count(ndir))?;
    check_directions(number)?;
    Ok(number)
}

/// One of the two forms of the law: the addresses of a point, or of the first point of a batch.
trait Form: Copy {
    /// What every point needs, and what it is called.
    fn required(&self) -> [(&'static str, *const c_double); 5];

    /// The addresses of the point `points` further on.
    ///
    /// # Safety
    /// Every array that is not null holds more than that many points.
    unsafe fn skip(&self, points: usize, ndir: usize, nstate: usize) -> Self;

    /// Updates the point; gives the status. Everything is read before anything is written, so that arrays may overlap.
    ///
    /// # Safety
    /// Pointers are null or point to arrays of the documented sizes.
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error>;
}

/// The friction form.
#[derive(Clone, Copy)]
struct Friction {
    slip_increment: *const c_double,
    pressure: *const c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
}

/// The interface form.
#[derive(Clone, Copy)]
struct Interface {
    opening: *const c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    tangent: *mut c_double,
    energy: *mut c_double,
}

/// An array's address `points` points of `size` numbers further on; NULL stays NULL.
///
/// # Safety
/// The array reaches that far.
#[inline(always)]
unsafe fn on<T>(pointer: *const T, points: usize, size: usize) -> *mut T {
    if pointer.is_null() {
        return pointer.cast_mut();
    }
    // SAFETY: inside the caller's array.
    unsafe { pointer.add(points * size).cast_mut() }
}

/// The factor on mu: 1 where there is none.
///
/// # Safety
/// `pointer` is null or readable.
#[inline(always)]
unsafe fn factor(pointer: *const c_double) -> f64 {
    if pointer.is_null() {
        return 1.0;
    }
    // SAFETY: not null, readable by the caller's word.
    unsafe { *pointer }
}

impl Form for Friction {
    fn required(&self) -> [(&'static str, *const c_double); 5] {
        [
            ("slip_increment", self.slip_increment),
            ("pressure", self.pressure),
            ("state0", self.state0),
            ("state1", self.state1),
            ("traction", self.traction),
        ]
    }

    #[inline(always)]
    unsafe fn skip(&self, points: usize, ndir: usize, nstate: usize) -> Self {
        // SAFETY: inside the arrays, by the caller's word.
        unsafe {
            Friction {
                slip_increment: on(self.slip_increment, points, ndir),
                pressure: on(self.pressure, points, 1),
                mu_factor: on(self.mu_factor, points, 1),
                state0: on(self.state0, points, nstate),
                state1: on(self.state1, points, nstate),
                traction: on(self.traction, points, ndir),
                dtraction_dslip: on(self.dtraction_dslip, points, ndir * ndir),
                dtraction_dpressure: on(self.dtraction_dpressure, points, ndir),
                energy: on(self.energy, points, 2),
            }
        }
    }

    #[inline(always)]
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error> {
        let (mut start, mut end) = (Start::new(), End::new());
        check_required(self)?;
        // SAFETY: sizes by the caller's word.
        unsafe {
            let slip =
                Vector::<N>::from_column_slice(array("slip_increment", self.slip_increment, N)?);
            law.read(
                array("state0", self.state0, law.layout().used())?,
                &mut start,
            )?;
            let factor = factor(self.mu_factor);
            let response =
                law.friction_from(&mut start, gcr, &slip, *self.pressure, factor, &mut end)?;
            write_state(law, &end, self.state1);
            write(self.traction, response.traction.as_slice());
            // Row by row: nalgebra's order is by columns.
            write(
                self.dtraction_dslip,
                response.dtraction_dslip.transpose().as_slice(),
            );
            write(
                self.dtraction_dpressure,
                response.dtraction_dpressure.as_slice(),
            );
            write(self.energy, &[response.stored, response.dissipated]);
            Ok(success(response.memory_full))
        }
    }
}

impl Form for Interface {
    fn required(&self) -> [(&'static str, *const c_double); 5] {
        [
            ("opening", self.opening),
            ("state0", self.state0),
            ("state1", self.state1),
            ("traction", self.traction),
            ("traction", self.traction),
        ]
    }

    #[inline(always)]
    unsafe fn skip(&self, points: usize, ndir: usize, nstate: usize) -> Self {
        // SAFETY: inside the arrays, by the caller's word.
        unsafe {
            Interface {
                opening: on(self.opening, points, 1 + ndir),
                mu_factor: on(self.mu_factor, points, 1),
                state0: on(self.state0, points, nstate),
                state1: on(self.state1, points, nstate),
                traction: on(self.traction, points, 1 + ndir),
                tangent: on(self.tangent, points, (1 + ndir) * (1 + ndir)),
                energy: on(self.energy, points, 2),
            }
        }
    }

    #[inline(always)]
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error> {
        let (mut start, mut end) = (Start::new(), End::new());
        check_required(self)?;
        // SAFETY: sizes by the caller's word.
        unsafe {
            let opening = array("opening", self.opening, 1 + N)?;
            let (normal, tangential) = (opening[0], Vector::<N>::from_column_slice(&opening[1..]));
            law.read(
                array("state0", self.state0, law.layout().used())?,
                &mut start,
            )?;
            let factor = factor(self.mu_factor);
            let response =
                law.interface_from(&mut start, gcr, normal, &tangential, factor, &mut end)?;
            let friction = &response.friction;
            let mut traction = ArrayVec::<f64, 3>::new();
            traction.push(response.normal_traction);
            traction.extend(friction.traction.iter().copied());
            let mut tangent = ArrayVec::<f64, 9>::new();
            tangent.push(response.normal_stiffness);
            tangent.extend([0.0; N]);
            for i in 0..N {
                tangent.push(response.dtraction_dopening[i]);
                tangent.extend(friction.dtraction_dslip.row(i).iter().copied());
            }
            let stored = friction.stored + response.normal_energy;
            write_state(law, &end, self.state1);
            write(self.traction, &traction);
            write(self.tangent, &tangent);
            write(self.energy, &[stored, friction.dissipated]);
            Ok(success(friction.memory_full))
        }
    }
}

/// The status of a point that was updated.
#[inline(always)]
fn success(memory_full: bool) -> i32 {
    if memory_full { MEPC_MEMORY_FULL } else { 0 }
}

/// # Safety
/// `state` has room for the law's states, and there is no other reference to it.
#[inline(always)]
unsafe fn write_state<const N: usize>(law: &Law<N>, end: &End<N>, state: *mut c_double) {
    // SAFETY: as the caller says.
    law.layout().write(end, unsafe {
        slice::from_raw_parts_mut(state, law.layout().nstate)
    });
}

/// Refuses arrays that are not there.
#[inline(always)]
fn check_required(form: &impl Form) -> Result<(), Error> {
    match form
        .required()
        .into_iter()
        .find(|(_, pointer)| pointer.is_null())
    {
        Some((name, _)) => Err(null(name)),
        None => Ok(()),
    }
}

/// Runs a point.
///
/// # Safety
/// `law` is null or came from mepc_law_new; arrays are as long as described.
#[inline(always)]
unsafe fn run_point(law: *const mepc_law, point: impl Form) -> i32 {
    // SAFETY: by the caller's word.
    status(guard(|| unsafe {
        let law = law_of(law)?;
        match &law.law {
            AnyLaw::One(one) => point.run(one, law.gcr),
            AnyLaw::Two(two) => point.run(two, law.gcr),
        }
    }))
}

/// Runs many points, of which the first is given.
///
/// # Safety
/// As [`run_point`]; `statuses` is null or has room for all points.
unsafe fn run_points(
    law: *const mepc_law,
    n: i64,
    first: impl Form,
    statuses: *mut i32,
    threads: i32,
) -> i32 {
    status(guard(|| {
        // SAFETY: by the caller's word.
        let law = unsafe { law_of(law)? };
        let points = points("n", n, law.layout().nstate)?;
        if points > 0 {
            check_required(&first)?;
        }
        let (gcr, nstate) = (law.gcr, law.layout().nstate);
        let first = Shared(first);
        // SAFETY: inside the arrays, by the caller's word.
        unsafe {
            match &law.law {
                AnyLaw::One(law) => run_batch(points, statuses, threads, |index| {
                    first.get().skip(index, 1, nstate).run(law, gcr)
                }),
                AnyLaw::Two(law) => run_batch(points, statuses, threads, |index| {
                    first.get().skip(index, 2, nstate).run(law, gcr)
                }),
            }
        }
    }))
}

/// A history has one array for the state at both ends.
fn one_state(mut error: Error) -> Error {
    if let "state0" | "state1" = error.argument {
        error.argument = "state";
    }
    error
}

impl Friction {
    /// Runs the history of point `index`, whose state is at both ends of each increment; gives the largest status. It
    /// stops where an increment is refused: the state is then the one before.
    ///
    /// # Safety
    /// As [`Form::run`]; arrays other than the state hold `increments` rows of every point up to this one.
    #[inline(always)]
    unsafe fn history<const N: usize>(
        &self,
        index: usize,
        increments: usize,
        law: &Law<N>,
        gcr: f64,
    ) -> Result<i32, Error> {
        let nstate = law.layout().nstate;
        // SAFETY: inside the arrays, here and below.
        let state = unsafe { on(self.state1, index, nstate) };
        let mut worst = 0;
        for increment in 0..increments {
            // SAFETY: row `increment` of history `index`, inside the arrays.
            let row = unsafe { self.skip(index * increments + increment, N, 0) };
            let row = Friction {
                state0: state,
                state1: state,
                ..row
            };
            // SAFETY: as above; the state is this history's own.
            let status = unsafe { row.run(law, gcr) };
            let status = status.map_err(|error| one_state(error).at("increment", increment))?;
            worst = worst.max(status);
        }
        Ok(worst)
    }
}

/// # Safety
/// `law` is null or came from mepc_law_new and lives on.
unsafe fn law_of<'a>(law: *const mepc_law) -> Result<&'a mepc_law, Error> {
    // SAFETY: by the caller's word.
    unsafe { law.as_ref() }.ok_or_else(|| null("law"))
}

/// Version of the interface that the library offers; a program built against another MEPC_ABI_VERSION must not call it.
#[unsafe(no_mangle)]
pub extern "C" fn mepc_abi_version() -> i32 {
    MEPC_ABI_VERSION
}

/// Version of the library, "major.minor.patch".
#[unsafe(no_mangle)]
pub extern "C" fn mepc_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// What a status number means, in words; never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mepc_status_message(status: i32) -> *const c_char {
    match status {
        0 => c"success",
        MEPC_MEMORY_FULL => c"memory full: a remembered knot that mattered was dropped",
        MEPC_NOT_DESCRIBED => c"the model does not describe the loop",
        MEPC_NULL_POINTER => c"null pointer",
        MEPC_BAD_PROPERTY => c"bad property",
        MEPC_BAD_STATE => c"bad state: too short or corrupt",
        MEPC_BAD_INPUT => c"bad input: not finite, or a size out of range",
        MEPC_INTERNAL => c"internal error (please report it)",
        _ => c"unknown status",
    }
    .as_ptr()
}

/// This thread's last error in words: which argument, its value, what was expected. Never NULL, empty before the
/// first error. The text is valid until this thread's next failing call.
#[unsafe(no_mangle)]
pub extern "C" fn mepc_last_error() -> *const c_char {
    LAST_ERROR
        .try_with(|last| last.borrow().as_ptr())
        .unwrap_or(c"".as_ptr())
}

/// Makes a law.
///
/// props: nprops properties in the order of the property table (see the README); zero and missing trailing entries take
/// their defaults. gcr must be positive here: there is no characteristic length.
/// ndir: tangential directions, 1 or 2. nstate: numbers in a state array, see mepc_state_size.
/// law: receives the new law, to be released with mepc_law_free; written only on success.
///
/// Returns 0, or MEPC_NULL_POINTER, MEPC_BAD_PROPERTY, MEPC_BAD_STATE (nstate too small or above 1000000), MEPC_BAD_INPUT (ndir, nprops).
///
/// # Safety
/// props points to nprops numbers, law to a writable pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_law_new(
    props: *const c_double,
    nprops: i32,
    ndir: i32,
    nstate: i32,
    law: *mut *mut mepc_law,
) -> i32 {
    status(guard(|| {
        if law.is_null() {
            return Err(null("law"));
        }
        // SAFETY: nprops numbers by the caller's word.
        let props = unsafe { array("props", props, size("nprops", nprops)?)? };
        let made = Box::new(mepc_law::new(props, ndir, nstate)?);
        // SAFETY: not null, writable by the caller's word.
        unsafe { law.write(Box::into_raw(made)) };
        Ok(0)
    }))
}

/// Releases a law; NULL is allowed and does nothing.
///
/// # Safety
/// law came from mepc_law_new and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_law_free(law: *mut mepc_law) {
    if !law.is_null() {
        // SAFETY: made by Box::into_raw in mepc_law_new, released once by the caller's word.
        drop(unsafe { Box::from_raw(law) });
    }
}

/// The default number of state variables: 44 for one direction (16 knots), 84 for two (24 knots), or a negative status.
///
/// A state may be longer (up to 64 knots of 1 + ndir numbers are used) or shorter (12 numbers and 4 knots at least).
///
/// # Safety
/// props points to nprops numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_state_size(props: *const c_double, nprops: i32, ndir: i32) -> i32 {
    status(guard(|| {
        // SAFETY: nprops numbers by the caller's word.
        let props = unsafe { array("props", props, size("nprops", nprops)?)? };
        // 44 or 84.
        Ok(default_state_size(props, directions(ndir)?)? as i32)
    }))
}

/// The name of state variable index (0-based); NULL past the end. Valid as long as the law.
///
/// # Safety
/// law is NULL or came from mepc_law_new.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_state_name(law: *const mepc_law, index: i32) -> *const c_char {
    // SAFETY: by the caller's word.
    let name = unsafe { law.as_ref() }.and_then(|law| law.names.get(usize::try_from(index).ok()?));
    name.map_or(std::ptr::null(), |name| name.as_ptr().cast())
}

/// Friction form: one contact point, one increment.
///
/// slip_increment: [ndir] tangential slip of the increment, length. pressure: at the end of the increment, positive in
/// compression; zero or less is an open contact: no traction, and the memory is cleared.
/// mu_factor: one number >= 0 by which the friction coefficient is multiplied in this increment, or NULL (1).
/// state0: [nstate] at the start of the increment; all zeros is the virgin state. state1: [nstate] at its end; may be
/// the same array as state0, but must not overlap it otherwise.
/// traction: [ndir] friction traction (force per area) with the sign of the slip.
/// dtraction_dslip: [ndir*ndir] row-major consistent tangent, or NULL. dtraction_dpressure: [ndir], or NULL.
/// energy: [2] per area: stored at the end, dissipated in the increment; or NULL.
///
/// Returns 0, MEPC_MEMORY_FULL (a valid result), or a negative status; outputs are written only when it is not negative.
/// A pure function of law, state0, slip_increment, pressure and mu_factor: repeat, reject and restart at will.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_friction(
    law: *const mepc_law,
    slip_increment: *const c_double,
    pressure: c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
) -> i32 {
    let point = Friction {
        slip_increment,
        pressure: &raw const pressure,
        mu_factor,
        state0,
        state1,
        traction,
        dtraction_dslip,
        dtraction_dpressure,
        energy,
    };
    // SAFETY: by the caller's word.
    unsafe { run_point(law, point) }
}

/// Interface form: one contact point, one increment, with the normal penalty (PROPS 7, kn > 0 required).
///
/// opening: [1+ndir] total opening at the end of the increment, lengths: normal first (positive when open), then
/// tangential. mu_factor, state0, state1: as in mepc_friction.
/// traction: [1+ndir]: normal (negative in compression), then friction with the sign of the tangential jump.
/// tangent: [(1+ndir)*(1+ndir)] row-major d traction_i / d opening_j, not symmetric; or NULL.
/// energy: [2] per area: stored at the end by friction and by the normal penalty, dissipated in the increment; or NULL.
///
/// Returns and guarantees as mepc_friction.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_interface(
    law: *const mepc_law,
    opening: *const c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    tangent: *mut c_double,
    energy: *mut c_double,
) -> i32 {
    let point = Interface {
        opening,
        mu_factor,
        state0,
        state1,
        traction,
        tangent,
        energy,
    };
    // SAFETY: by the caller's word.
    unsafe { run_point(law, point) }
}

/// Friction form for n points.
///
/// Arrays hold point after point: slip_increment [n*ndir], pressure [n], mu_factor [n] or NULL, state0 and state1 [n*nstate], traction [n*ndir],
/// dtraction_dslip [n*ndir*ndir] or NULL, dtraction_dpressure [n*ndir] or NULL, energy [n*2] or NULL.
/// statuses: [n] or NULL. threads: 1 = this thread, 0 = as many as there are cores, otherwise that many.
///
/// Returns the most negative status, else the largest; points that fail leave their outputs untouched, and
/// mepc_last_error tells of the first point with the returned status. The result does not depend on threads.
/// Where the call itself is refused (a null array, n < 0), statuses stay untouched, too.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_friction_batch(
    law: *const mepc_law,
    n: i64,
    slip_increment: *const c_double,
    pressure: *const c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
    statuses: *mut i32,
    threads: i32,
) -> i32 {
    let first = Friction {
        slip_increment,
        pressure,
        mu_factor,
        state0,
        state1,
        traction,
        dtraction_dslip,
        dtraction_dpressure,
        energy,
    };
    // SAFETY: by the caller's word.
    unsafe { run_points(law, n, first, statuses, threads) }
}

/// Interface form for n points.
///
/// Arrays hold point after point: opening [n*(1+ndir)], mu_factor [n] or NULL, state0 and state1 [n*nstate], traction [n*(1+ndir)],
/// tangent [n*(1+ndir)*(1+ndir)] or NULL, energy [n*2] or NULL. statuses, threads and the result as in
/// mepc_friction_batch.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_interface_batch(
    law: *const mepc_law,
    n: i64,
    opening: *const c_double,
    mu_factor: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    tangent: *mut c_double,
    energy: *mut c_double,
    statuses: *mut i32,
    threads: i32,
) -> i32 {
    let first = Interface {
        opening,
        mu_factor,
        state0,
        state1,
        traction,
        tangent,
        energy,
    };
    // SAFETY: by the caller's word.
    unsafe { run_points(law, n, first, statuses, threads) }
}

/// Friction form: one contact point, n increments one after the other.
///
/// Arrays hold increment after increment: slip_increment [n*ndir], pressure [n], mu_factor [n] or NULL, traction [n*ndir],
/// dtraction_dslip [n*ndir*ndir] or NULL, dtraction_dpressure [n*ndir] or NULL, energy [n*2] or NULL; each means what it
/// means in mepc_friction. state: [nstate], at the start of the history on entry, at its end on return.
///
/// Stops at the first increment that is refused: state is then the one before it, what was written for the increments
/// before it stays, later rows are untouched, and mepc_last_error names the increment (from 0).
/// Returns 0, MEPC_MEMORY_FULL (in some increment), or the negative status of the refused one.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_friction_history(
    law: *const mepc_law,
    n: i64,
    slip_increment: *const c_double,
    pressure: *const c_double,
    mu_factor: *const c_double,
    state: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
) -> i32 {
    let first = Friction {
        slip_increment,
        pressure,
        mu_factor,
        state0: state,
        state1: state,
        traction,
        dtraction_dslip,
        dtraction_dpressure,
        energy,
    };
    status(guard(|| {
        // SAFETY: by the caller's word.
        let law = unsafe { law_of(law)? };
        let increments = points("n", n, 1)?;
        // SAFETY: by the caller's word.
        unsafe {
            match &law.law {
                AnyLaw::One(one) => first.history(0, increments, one, law.gcr),
                AnyLaw::Two(two) => first.history(0, increments, two, law.gcr),
            }
        }
    }))
}

/// Friction form: whole histories of npoints contact points, n increments each.
///
/// Arrays hold the history of one point after that of another: slip_increment [npoints*n*ndir], pressure [npoints*n],
/// mu_factor [npoints*n] or NULL, state [npoints*nstate], traction [npoints*n*ndir], dtraction_dslip
/// [npoints*n*ndir*ndir] or NULL, dtraction_dpressure [npoints*n*ndir] or NULL, energy [npoints*n*2] or NULL; for each
/// point as in mepc_friction_history. statuses: [npoints] or NULL. threads as in mepc_friction_batch.
///
/// A point whose increment is refused stops there; the others go on. Returns the most negative status, else the largest,
/// and mepc_last_error names the first point with it, and its increment. The result does not depend on threads.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_friction_history_batch(
    law: *const mepc_law,
    npoints: i64,
    n: i64,
    slip_increment: *const c_double,
    pressure: *const c_double,
    mu_factor: *const c_double,
    state: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
    statuses: *mut i32,
    threads: i32,
) -> i32 {
    let first = Friction {
        slip_increment,
        pressure,
        mu_factor,
        state0: state,
        state1: state,
        traction,
        dtraction_dslip,
        dtraction_dpressure,
        energy,
    };
    status(guard(|| {
        // SAFETY: by the caller's word.
        let law = unsafe { law_of(law)? };
        let increments = points("n", n, 1)?;
        let points = points("npoints", npoints, increments.max(law.layout().nstate))?;
        if points > 0 && increments > 0 {
            check_required(&first).map_err(one_state)?;
        }
        let first = Shared(first);
        // SAFETY: by the caller's word.
        unsafe {
            match &law.law {
                AnyLaw::One(one) => run_batch(points, statuses, threads, |index| {
                    first.get().history(index, increments, one, law.gcr)
                }),
                AnyLaw::Two(two) => run_batch(points, statuses, threads, |index| {
                    first.get().history(index, increments, two, law.gcr)
                }),
            }
        }
    }))
}

/// A number of points, or of increments, whose arrays fit into memory where the longest row has `row` numbers.
fn points(name: &'static str, n: i64, row: usize) -> Result<usize, Error> {
    let fits = |points: &usize| {
        let numbers = points
            .checked_mul(row.max(9))
            .and_then(|numbers| numbers.checked_mul(4));
        numbers.is_some_and(|numbers| numbers <= isize::MAX as usize / size_of::<f64>())
    };
    let expected = "must be >= 0 and fit into memory";
    usize::try_from(n)
        .ok()
        .filter(fits)
        .ok_or_else(|| Error::about(Kind::BadInput, name, expected).count(n))
}

/// Addresses that several threads use at once, each for its own points.
struct Shared<T>(T);

// SAFETY: the threads of a batch work on disjoint points and only read what they share.
unsafe impl<T> Sync for Shared<T> {}

impl<T> Shared<T> {
    fn get(&self) -> &T {
        &self.0
    }
}

/// The worst point of a batch so far: the most negative status, else the largest, the first of its kind.
#[derive(Default)]
struct Worst {
    status: i32,
    error: Option<(usize, Error)>,
}

impl Worst {
    fn take(&mut self, index: usize, result: Result<i32, Error>) -> i32 {
        match result {
            Ok(status) => {
                if self.status >= 0 {
                    self.status = self.status.max(status);
                }
                status
            }
            Err(error) => {
                let status = error.kind as i32;
                if status < self.status.min(0) {
                    self.status = status;
                    self.error = Some((index, error));
                }
                status
            }
        }
    }

    /// Adds the outcome of points that come after these.
    fn merge(&mut self, later: Worst) {
        if later.status < self.status.min(0) || (self.status >= 0 && later.status > self.status) {
            *self = later;
        }
    }

    fn finish(self) -> Result<i32, Error> {
        match self.error {
            Some((index, error)) => Err(error.at("point", index)),
            None => Ok(self.status),
        }
    }
}

/// Runs `point` for all points, in one thread or several.
///
/// # Safety
/// `statuses` is null or has room for all points.
unsafe fn run_batch(
    points: usize,
    statuses: *mut i32,
    threads: i32,
    point: impl Fn(usize) -> Result<i32, Error> + Sync,
) -> Result<i32, Error> {
    let threads = match size("threads", threads)? {
        0 => std::thread::available_parallelism()
            .map_or(1, NonZero::get)
            .min(points.div_ceil(POINTS_PER_THREAD)),
        chosen => chosen.min(points),
    };
    let statuses = Shared(statuses);
    let run = |range: std::ops::Range<usize>| {
        let mut worst = Worst::default();
        for index in range {
            let status = worst.take(index, guard(|| point(index)));
            let statuses = *statuses.get();
            if !statuses.is_null() {
                // SAFETY: room for all points by the caller's word; each index is written once.
                unsafe { statuses.add(index).write(status) };
            }
        }
        worst
    };
    if threads <= 1 {
        return run(0..points).finish();
    }
    let share = points.div_ceil(threads);
    let ranges = (0..threads).map(|k| (k * share).min(points)..((k + 1) * share).min(points));
    let mut worst = Worst::default();
    std::thread::scope(|scope| {
        let workers: Vec<_> = ranges
            .map(|range| {
                let run = &run;
                let own = range.clone();
                // Where the system gives no more threads, this one does the work.
                match std::thread::Builder::new().spawn_scoped(scope, move || run(own)) {
                    Ok(worker) => Ok(worker),
                    Err(_) => Err(run(range)),
                }
            })
            .collect();
        for worker in workers {
            worst.merge(match worker {
                Ok(worker) => worker.join().unwrap_or_else(|payload| Worst {
                    status: MEPC_INTERNAL,
                    error: Some((0, super::caught(&*payload))),
                }),
                Err(done) => done,
            });
        }
    });
    worst.finish()
}
