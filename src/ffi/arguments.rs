//! The arguments of exported functions: scalars, arrays and names of the host, and what it calls them.

use crate::error::{Error, Kind};
use crate::law::{Law, SQUARED, Start};
use crate::memory::{Matrix, Vector};
use crate::number::within;
use crate::state::{Layout, MAX_USED, rotate};
use arrayvec::ArrayVec;
use libc::{c_char, c_double};
use std::slice;

/// The types of a host's arguments, all by reference: numbers that are read, numbers that are written, and names.
pub(super) type Real = *const c_double;
pub(super) type RealOut = *mut c_double;
pub(super) type Integer = *const i32;
pub(super) type IntegerOut = *mut i32;
pub(super) type Text = *const c_char;

/// How far a rotation increment may be from orthogonal: hosts hand over linearised rotations.
const ORTHOGONALITY: f64 = 1e-3;
/// Length of the contact and surface names.
const NAME_LENGTH: usize = 80;
/// What a contact without a name is called.
const UNNAMED: &str = "(unnamed)";

/// What FRIC, UINTER and UMAT, written in Fortran, call an argument of the library; arrays count from 1.
pub(super) fn fortran_name(ours: &str, index: Option<usize>) -> Option<String> {
    let theirs = match ours {
        "state" | "state0" => "STATEV",
        "nstate" => "NSTATV",
        "nprops" => "NPROPS",
        "mu_factor" => "PREDEF value that multiplies mu",
        _ => ours,
    };
    Some(match index {
        Some(index) => format!("{theirs}({})", index + 1),
        None => theirs.to_string(),
    })
}

/// The refusal of a null pointer.
pub(super) fn null(name: &'static str) -> Error {
    Error::about(Kind::NullPointer, name, "").text("NULL")
}

/// Refuses outputs that are not there; the names stand in the same order.
#[inline(always)]
pub(super) fn required<const K: usize>(
    names: [&'static str; K],
    outputs: [*mut c_double; K],
) -> Result<(), Error> {
    match outputs.iter().position(|pointer| pointer.is_null()) {
        Some(missing) => Err(null(names[missing])),
        None => Ok(()),
    }
}

/// A scalar of the host, or a message with the argument's name.
///
/// # Safety
/// `pointer` is null or readable.
#[inline(always)]
pub(super) unsafe fn read<T: Copy>(name: &'static str, pointer: *const T) -> Result<T, Error> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: not null, readable by the caller's word.
    Ok(unsafe { *pointer })
}

/// A size of the host.
///
/// # Safety
/// `pointer` is null or readable.
#[inline(always)]
pub(super) unsafe fn count(name: &'static str, pointer: *const i32) -> Result<usize, Error> {
    // SAFETY: as the caller says.
    size(name, unsafe { read(name, pointer)? })
}

/// A size, which must not be negative.
#[inline(always)]
pub(super) fn size(name: &'static str, value: i32) -> Result<usize, Error> {
    usize::try_from(value)
        .map_err(|_| Error::about(Kind::BadInput, name, "must be >= 0").count(value))
}

/// An array of the host.
///
/// # Safety
/// `pointer` is null or points to `len` numbers that nobody writes as long as the slice lives.
#[inline(always)]
pub(super) unsafe fn array<'a>(
    name: &'static str,
    pointer: *const c_double,
    len: usize,
) -> Result<&'a [f64], Error> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: not null, `len` numbers by the caller's word.
    Ok(unsafe { slice::from_raw_parts(pointer, len) })
}

/// PROPS, NPROPS long.
///
/// # Safety
/// The pointers are null or what their names say, and PROPS is not written during the call.
#[inline(always)]
pub(super) unsafe fn properties<'a>(
    props: *const c_double,
    nprops: *const i32,
) -> Result<&'a [f64], Error> {
    // SAFETY: as the caller says.
    unsafe { array("PROPS", props, count("NPROPS", nprops)?) }
}

/// N numbers of an array of the host, from number `first` (from 1) on.
///
/// # Safety
/// `pointer` is null or points to an array that reaches that far.
#[inline(always)]
pub(super) unsafe fn vector<const N: usize>(
    name: &'static str,
    pointer: *const c_double,
    first: usize,
) -> Result<Vector<N>, Error> {
    // SAFETY: as the caller says; copied at once.
    let numbers = unsafe { array(name, pointer, first - 1 + N)? };
    Ok(Vector::from_column_slice(&numbers[first - 1..]))
}

/// A vector that hosts may leave unset: zeros where it is not there, or cannot be meant.
///
/// # Safety
/// `pointer` is null or points to N readable numbers.
pub(super) unsafe fn hint<const N: usize>(pointer: *const c_double) -> Vector<N> {
    // SAFETY: as the caller says; copied at once.
    match unsafe { array("", pointer, N) } {
        Ok(numbers) if numbers.iter().all(|x| within(*x, SQUARED)) => {
            Vector::from_column_slice(numbers)
        }
        _ => Vector::zeros(),
    }
}

/// Writes numbers where the host wants them.
///
/// # Safety
/// `pointer` is null or has room.
#[inline(always)]
pub(super) unsafe fn write(pointer: *mut c_double, values: &[f64]) {
    if !pointer.is_null() {
        // SAFETY: not null, room by the caller's word; `values` is ours.
        unsafe { pointer.copy_from_nonoverlapping(values.as_ptr(), values.len()) }
    }
}

/// A blank-padded name of the host.
///
/// # Safety
/// `pointer` is null or points to 80 characters.
pub(super) unsafe fn name(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return UNNAMED.to_string();
    }
    // SAFETY: 80 characters by the caller's word.
    let bytes = unsafe { slice::from_raw_parts(pointer.cast::<u8>(), NAME_LENGTH) };
    match String::from_utf8_lossy(bytes).trim_end() {
        "" => UNNAMED.to_string(),
        name => name.to_string(),
    }
}

/// Reads a state whose remembered vectors turn with the slip directions.
///
/// # Safety
/// `pointer` is null or points to a state of this law; `drot` is null (nothing turns) or points to DROT(2,2),
/// column-major.
#[inline(always)]
pub(super) unsafe fn read_turned<const N: usize>(
    name: &'static str,
    law: &Law<N>,
    pointer: *const c_double,
    drot: *const c_double,
    start: &mut Start<N>,
) -> Result<(), Error> {
    // SAFETY: as the caller says; the used part is no longer than the state.
    unsafe {
        let state = array(name, pointer, law.layout().used())?;
        if N == 1 || drot.is_null() {
            return law.read(state, start);
        }
        let drot = slice::from_raw_parts(drot, 4);
        if stays(drot) {
            return law.read(state, start);
        }
        let mut turned = ArrayVec::<f64, MAX_USED>::new();
        turned.extend(state.iter().copied());
        turn(drot, law.layout(), &mut turned)?;
        law.read(&turned, start)
    }
}

/// Whether the slip directions stay what they were; the bits tell, for DROT may hold anything.
fn stays(drot: &[f64]) -> bool {
    let identity = [1.0f64, 0.0, 0.0, 1.0];
    drot.iter()
        .zip(identity)
        .all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Turns the remembered vectors with the slip directions.
#[cold]
fn turn(drot: &[f64], layout: &Layout, state: &mut [f64]) -> Result<(), Error> {
    let rotation = Matrix::<2>::from_column_slice(drot);
    let off = || (rotation.transpose() * rotation - Matrix::<2>::identity()).norm();
    let proper = drot.iter().all(|x| within(*x, 2.0))
        && off() < 3.0 * ORTHOGONALITY
        && rotation.determinant() > 0.0;
    if !proper {
        let expected = "must be a rotation, orthogonal to 1e-3";
        return Err(Error::about(Kind::BadInput, "DROT", expected).numbers(drot));
    }
    // What a rotation would do to a number that is none is no use: the check of the state will name it.
    if !state.iter().all(|x| within(*x, SQUARED)) {
        return Ok(());
    }
    // The rotation next to it: the memory must not grow or shrink by what the host rounds or leaves out.
    let (cosine, sine) = (drot[0] + drot[3], drot[1] - drot[2]);
    let length = cosine.hypot(sine);
    let (cosine, sine) = (cosine / length, sine / length);
    rotate(layout, &[[cosine, -sine], [sine, cosine]], state);
    Ok(())
}

/// Refuses a number that is infinite or none.
#[inline(always)]
pub(super) fn finite(name: &'static str, value: f64) -> Result<f64, Error> {
    if crate::number::finite(value) {
        return Ok(value);
    }
    Err(Error::about(Kind::BadInput, name, "must be finite").number(value))
}

/// Refuses a number that is not above zero, or that is so large or small that what follows from it is none.
#[inline(always)]
pub(super) fn positive(kind: Kind, name: &'static str, value: f64) -> Result<f64, Error> {
    // By bits, as numbers above zero are in the order of theirs: a NaN must not be compared.
    if ((1.0 / LARGEST).to_bits()..=LARGEST.to_bits()).contains(&value.to_bits()) {
        return Ok(value);
    }
    Err(Error::about(kind, name, "must be > 0, from 1e-100 to 1e100").number(value))
}

/// Areas, thicknesses and scales up to here, and down to its reciprocal, have products that are numbers.
const LARGEST: f64 = 1e100;

/// A host's routine: one list of its arguments in the host's order makes the struct of those that are used and the
/// exported symbols, with the underscore that Fortran compilers on Linux append and without, both of which fill the
/// struct and run it.
///
/// The hidden string lengths that follow the arguments are not declared: they are not needed, and on every calling
/// convention in use the caller removes them.
macro_rules! routine {
    (
        $(#[$doc:meta])*
        struct $name:ident of $with:ident($($with_extra:expr)?), $without:ident($($without_extra:expr)?);
        $($kind:ident $argument:ident: $type:ty,)*
    ) => {
        $crate::ffi::arguments::routine!(@fields [$(#[$doc])*] $name {} $($kind $argument: $type,)*);
        $crate::ffi::arguments::routine!(@export [$(#[$doc])*] $name $with($($with_extra)?) $($kind $argument: $type,)*);
        $crate::ffi::arguments::routine!(@export [$(#[$doc])*] $name $without($($without_extra)?) $($kind $argument: $type,)*);
    };
    (@fields [$($doc:tt)*] $name:ident {$($fields:tt)*}) => {
        /// The arguments that are used, as the host passes them.
        #[derive(Clone, Copy)]
        struct $name { $($fields)* }
    };
    (@fields $doc:tt $name:ident {$($fields:tt)*} take $argument:ident: $type:ty, $($rest:tt)*) => {
        $crate::ffi::arguments::routine!(@fields $doc $name {$($fields)* $argument: $type,} $($rest)*);
    };
    (@fields $doc:tt $name:ident $fields:tt skip $argument:ident: $type:ty, $($rest:tt)*) => {
        $crate::ffi::arguments::routine!(@fields $doc $name $fields $($rest)*);
    };
    (@export [$($doc:tt)*] $name:ident $symbol:ident($($extra:expr)?) $($kind:ident $argument:ident: $type:ty,)*) => {
        $($doc)*
        ///
        /// # Safety
        /// The arguments that are used (see docs/hosts.md) are as the host's manual describes them.
        #[unsafe(no_mangle)]
        #[allow(unused_variables)]
        pub unsafe extern "C" fn $symbol($($argument: $type,)*) {
            let arguments = $crate::ffi::arguments::routine!(@fill $name {} $($kind $argument,)*);
            // SAFETY: the host's arguments.
            unsafe { arguments.run($($extra)?) }
        }
    };
    (@fill $name:ident {$($fields:tt)*}) => { $name { $($fields)* } };
    (@fill $name:ident {$($fields:tt)*} take $argument:ident, $($rest:tt)*) => {
        $crate::ffi::arguments::routine!(@fill $name {$($fields)* $argument,} $($rest)*)
    };
    (@fill $name:ident $fields:tt skip $argument:ident, $($rest:tt)*) => {
        $crate::ffi::arguments::routine!(@fill $name $fields $($rest)*)
    };
}
pub(super) use routine;
