//! The native C interface, `mepc_*` (include/mepc.h is generated from this file).

// The comments are those of the C header, where [n] is an array of n numbers.
#![allow(rustdoc::broken_intra_doc_links)]

use super::guard;
use super::user::{array, null, size, write};
use crate::error::{Error, Kind};
use crate::law::{Law, Response, default_state_size};
use crate::memory::{Curve, Vector};
use crate::state::{Contact, Layout};
use arrayvec::ArrayVec;
use libc::{c_char, c_double};
use std::cell::RefCell;
use std::ffi::CString;
use std::num::NonZero;
use std::slice;

/// Points that one thread of a batch is worth starting for, when the library chooses their number.
const POINTS_PER_THREAD: usize = 256;

/// Version of this interface. A program compares it with what mepc_abi_version returns.
pub const MEPC_ABI_VERSION: i32 = 1;
/// Advisory status: the state array is full and the least important reversal was dropped.
pub const MEPC_MEMORY_FULL: i32 = 1;
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
    names: Vec<CString>,
}

enum AnyLaw {
    One(Law<1>),
    Two(Law<2>),
}

impl mepc_law {
    fn new(props: &[f64], ndir: i32, nstate: i32) -> Result<Self, Error> {
        let nstate = usize::try_from(nstate).map_err(|_| {
            Error::new(
                Kind::BadState,
                format!("nstate = {nstate}: must be positive"),
            )
        })?;
        let law = match ndir {
            1 => AnyLaw::One(Law::new(props, nstate)?),
            2 => AnyLaw::Two(Law::new(props, nstate)?),
            _ => return Err(bad_directions(ndir)),
        };
        let (gcr, layout) = match &law {
            AnyLaw::One(law) => (law.critical_slip(0.0)?, *law.layout()),
            AnyLaw::Two(law) => (law.critical_slip(0.0)?, *law.layout()),
        };
        let names = (0..)
            .map_while(|index| layout.slot_name(index))
            .map(|name| CString::new(name).unwrap_or_default())
            .collect();
        Ok(mepc_law { law, gcr, names })
    }

    fn layout(&self) -> &Layout {
        match &self.law {
            AnyLaw::One(law) => law.layout(),
            AnyLaw::Two(law) => law.layout(),
        }
    }
}

fn bad_directions(ndir: i32) -> Error {
    Error::new(
        Kind::BadInput,
        format!("ndir = {ndir}: must be 1 or 2 tangential directions"),
    )
}

/// One of the two forms of the law: the addresses of a point, or of the first point of a batch.
trait Form {
    /// The addresses of point `index`.
    ///
    /// # Safety
    /// Every array that is not null holds more than `index` points.
    unsafe fn point(&self, index: usize, ndir: usize, nstate: usize) -> Self;

    /// Updates the point; gives the status.
    ///
    /// # Safety
    /// Pointers are null or point to arrays of the documented sizes; state0 may equal state1.
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error>;
}

/// The friction form.
struct Friction {
    slip_increment: *const c_double,
    pressure: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    dtraction_dslip: *mut c_double,
    dtraction_dpressure: *mut c_double,
    energy: *mut c_double,
}

/// The interface form.
struct Interface {
    opening: *const c_double,
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
unsafe fn skip<T>(pointer: *mut T, points: usize, size: usize) -> *mut T {
    if pointer.is_null() {
        return pointer;
    }
    // SAFETY: inside the caller's array.
    unsafe { pointer.add(points * size) }
}

impl Form for Friction {
    unsafe fn point(&self, index: usize, ndir: usize, nstate: usize) -> Self {
        // SAFETY: inside the arrays, by the caller's word.
        unsafe {
            Friction {
                slip_increment: skip(self.slip_increment.cast_mut(), index, ndir),
                pressure: skip(self.pressure.cast_mut(), index, 1),
                state0: skip(self.state0.cast_mut(), index, nstate),
                state1: skip(self.state1, index, nstate),
                traction: skip(self.traction, index, ndir),
                dtraction_dslip: skip(self.dtraction_dslip, index, ndir * ndir),
                dtraction_dpressure: skip(self.dtraction_dpressure, index, ndir),
                energy: skip(self.energy, index, 2),
            }
        }
    }

    #[inline]
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error> {
        let mut memory = Curve::new();
        // SAFETY: sizes by the caller's word; the inputs are read before anything is written.
        let (slip, pressure, header) = unsafe {
            (
                Vector::<N>::from_column_slice(array("slip_increment", self.slip_increment, N)?),
                array("pressure", self.pressure, 1)?[0],
                law.read(
                    array("state0", self.state0, law.layout().used())?,
                    &mut memory,
                )?,
            )
        };
        // SAFETY: as above; state0 has been read, so this is the only reference to the array.
        let state1 = unsafe { output_state(law.layout(), self.state1, self.traction)? };
        let response = law.friction_from(header, &mut memory, gcr, &slip, pressure, state1)?;
        // SAFETY: optional arrays are null or of the documented sizes.
        unsafe {
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
        }
        Ok(success(&response))
    }
}

impl Form for Interface {
    unsafe fn point(&self, index: usize, ndir: usize, nstate: usize) -> Self {
        // SAFETY: inside the arrays, by the caller's word.
        unsafe {
            Interface {
                opening: skip(self.opening.cast_mut(), index, 1 + ndir),
                state0: skip(self.state0.cast_mut(), index, nstate),
                state1: skip(self.state1, index, nstate),
                traction: skip(self.traction, index, 1 + ndir),
                tangent: skip(self.tangent, index, (1 + ndir) * (1 + ndir)),
                energy: skip(self.energy, index, 2),
            }
        }
    }

    #[inline]
    unsafe fn run<const N: usize>(&self, law: &Law<N>, gcr: f64) -> Result<i32, Error> {
        let mut memory = Curve::new();
        // SAFETY: sizes by the caller's word; the inputs are read before anything is written.
        let (normal, tangential, header) = unsafe {
            let opening = array("opening", self.opening, 1 + N)?;
            (
                opening[0],
                Vector::<N>::from_column_slice(&opening[1..]),
                law.read(
                    array("state0", self.state0, law.layout().used())?,
                    &mut memory,
                )?,
            )
        };
        // SAFETY: as above; state0 has been read, so this is the only reference to the array.
        let state1 = unsafe { output_state(law.layout(), self.state1, self.traction)? };
        let response = law.interface_from(header, &mut memory, gcr, normal, &tangential, state1)?;
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
        // SAFETY: optional arrays are null or of the documented sizes.
        unsafe {
            write(self.traction, &traction);
            write(self.tangent, &tangent);
            write(self.energy, &[friction.stored, friction.dissipated]);
        }
        Ok(success(friction))
    }
}

/// The status of a point that was updated.
#[inline]
fn success<const N: usize>(response: &Response<N>) -> i32 {
    if response.memory_full {
        MEPC_MEMORY_FULL
    } else {
        0
    }
}

/// One point.
///
/// # Safety
/// `law` as in [`law_of`], `point` as in [`Form::run`].
#[inline(always)]
unsafe fn run_point(law: *const mepc_law, point: impl Form) -> i32 {
    status(guard(|| {
        // SAFETY: by the caller's word.
        unsafe {
            let law = law_of(law)?;
            match &law.law {
                AnyLaw::One(one) => point.run(one, law.gcr),
                AnyLaw::Two(two) => point.run(two, law.gcr),
            }
        }
    }))
}

/// `n` points from the first one on; `arrays` are those that must not be NULL where there are points.
///
/// # Safety
/// As [`run_point`], for all points; `statuses` is null or has room for them.
unsafe fn run_points(
    law: *const mepc_law,
    n: i64,
    first: impl Form,
    arrays: &[(&str, *const c_double)],
    statuses: *mut i32,
    threads: i32,
) -> i32 {
    let first = Shared(first);
    status(guard(|| {
        // SAFETY: by the caller's word.
        let law = unsafe { law_of(law)? };
        let nstate = law.layout().nstate;
        let points = points(n, nstate)?;
        check_required(points, arrays)?;
        // SAFETY: points are disjoint, arrays of the documented sizes by the caller's word.
        unsafe {
            match &law.law {
                AnyLaw::One(one) => run_batch(points, statuses, threads, |index| {
                    first.get().point(index, 1, nstate).run(one, law.gcr)
                }),
                AnyLaw::Two(two) => run_batch(points, statuses, threads, |index| {
                    first.get().point(index, 2, nstate).run(two, law.gcr)
                }),
            }
        }
    }))
}

/// The state array to write, once all required outputs are known to be there.
///
/// # Safety
/// `state1` is null or points to a writable state of this layout to which there is no other reference.
#[inline]
unsafe fn output_state<'a>(
    layout: &Layout,
    state1: *mut c_double,
    traction: *const c_double,
) -> Result<&'a mut [f64], Error> {
    if state1.is_null() {
        return Err(null("state1"));
    }
    if traction.is_null() {
        return Err(null("traction"));
    }
    // SAFETY: not null, and the caller vouches for the rest.
    Ok(unsafe { slice::from_raw_parts_mut(state1, layout.nstate) })
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
        MEPC_MEMORY_FULL => c"memory full: the least important reversal was dropped",
        super::iwan::MEPC_NOT_DESCRIBED => c"the model does not describe the loop",
        MEPC_NULL_POINTER => c"null pointer",
        MEPC_BAD_PROPERTY => c"bad property",
        MEPC_BAD_STATE => c"bad state: too short or corrupt",
        MEPC_BAD_INPUT => c"bad input: not finite, or a size out of range",
        MEPC_INTERNAL => c"internal error (please report it)",
        _ => c"unknown status",
    }
    .as_ptr()
}

/// This thread's last error in words: which argument, its value, what was expected; after MEPC_NOT_DESCRIBED why. Never NULL,
/// empty before the first error. The text is valid until this thread's next failing call.
#[unsafe(no_mangle)]
pub extern "C" fn mepc_last_error() -> *const c_char {
    LAST_ERROR
        .try_with(|last| last.borrow().as_ptr())
        .unwrap_or(c"".as_ptr())
}

/// Makes a law.
///
/// props: nprops properties in the order of the property table (see the README); missing trailing entries take their
/// defaults. gcr must be positive here: there is no characteristic length.
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

/// The default number of state variables (room for 8 remembered reversals besides the base grid), or a negative status.
///
/// A state may be longer (up to 64 reversals are used) or shorter (2 at least).
///
/// # Safety
/// props points to nprops numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_state_size(props: *const c_double, nprops: i32, ndir: i32) -> i32 {
    status(guard(|| {
        // SAFETY: nprops numbers by the caller's word.
        let props = unsafe { array("props", props, size("nprops", nprops)?)? };
        let ndir = usize::try_from(ndir).map_err(|_| bad_directions(ndir))?;
        // At most 8 + 128 + 24.
        Ok(default_state_size(props, ndir)? as i32)
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
    name.map_or(std::ptr::null(), |name| name.as_ptr())
}

/// Friction form: one contact point, one increment.
///
/// slip_increment: [ndir] tangential slip of the increment, length. pressure: at the end of the increment, positive in
/// compression; zero or less is an open contact: no traction, and the memory is cleared.
/// state0: [nstate] at the start of the increment; all zeros is the virgin state. state1: [nstate] at its end; may be
/// the same array as state0, but must not overlap it otherwise.
/// traction: [ndir] friction traction (force per area) with the sign of the slip.
/// dtraction_dslip: [ndir*ndir] row-major consistent tangent, or NULL. dtraction_dpressure: [ndir], or NULL.
/// energy: [2] per area: stored at the end, dissipated in the increment; or NULL.
///
/// Returns 0, MEPC_MEMORY_FULL (a valid result), or a negative status; outputs are written only when it is not negative.
/// A pure function of law, state0, slip_increment and pressure: repeat, reject and restart at will.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_friction(
    law: *const mepc_law,
    slip_increment: *const c_double,
    pressure: c_double,
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
/// tangential. state0, state1: as in mepc_friction.
/// traction: [1+ndir]: normal (negative in compression), then friction with the sign of the tangential jump.
/// tangent: [(1+ndir)*(1+ndir)] row-major d traction_i / d opening_j, not symmetric; or NULL.
/// energy: [2] per area: stored by friction at the end, dissipated in the increment; or NULL.
///
/// Returns and guarantees as mepc_friction.
///
/// # Safety
/// law came from mepc_law_new, and arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_interface(
    law: *const mepc_law,
    opening: *const c_double,
    state0: *const c_double,
    state1: *mut c_double,
    traction: *mut c_double,
    tangent: *mut c_double,
    energy: *mut c_double,
) -> i32 {
    let point = Interface {
        opening,
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
/// Arrays hold point after point: slip_increment [n*ndir], pressure [n], state0 and state1 [n*nstate], traction [n*ndir],
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
        state0,
        state1,
        traction,
        dtraction_dslip,
        dtraction_dpressure,
        energy,
    };
    let required = [
        ("slip_increment", slip_increment),
        ("pressure", pressure),
        ("state0", state0),
        ("state1", state1.cast_const()),
        ("traction", traction.cast_const()),
    ];
    // SAFETY: by the caller's word.
    unsafe { run_points(law, n, first, &required, statuses, threads) }
}

/// Interface form for n points.
///
/// Arrays hold point after point: opening [n*(1+ndir)], state0 and state1 [n*nstate], traction [n*(1+ndir)],
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
        state0,
        state1,
        traction,
        tangent,
        energy,
    };
    let required = [
        ("opening", opening),
        ("state0", state0),
        ("state1", state1.cast_const()),
        ("traction", traction.cast_const()),
    ];
    // SAFETY: by the caller's word.
    unsafe { run_points(law, n, first, &required, statuses, threads) }
}

/// The number of points of a batch whose arrays fit into memory.
fn points(n: i64, nstate: usize) -> Result<usize, Error> {
    usize::try_from(n)
        .ok()
        .filter(|points| {
            let bytes = points.checked_mul(nstate.max(9) * size_of::<f64>());
            bytes.is_some_and(|bytes| bytes <= isize::MAX as usize)
        })
        .ok_or_else(|| {
            Error::new(
                Kind::BadInput,
                format!("n = {n}: must be >= 0 and fit into memory"),
            )
        })
}

fn check_required(points: usize, arrays: &[(&str, *const c_double)]) -> Result<(), Error> {
    match arrays.iter().find(|(_, pointer)| pointer.is_null()) {
        Some((name, _)) if points > 0 => Err(null(name)),
        _ => Ok(()),
    }
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
            Some((index, error)) => Err(Error::new(
                error.kind,
                format!("point {index} of the batch: {}", error.message),
            )),
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
