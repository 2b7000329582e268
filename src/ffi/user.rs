//! What the user routines of FE hosts share: their arguments, and the law that their properties ask for.

use crate::error::{Error, Kind, numbers};
use crate::law::{Law, SQUARED, within};
use crate::memory::{Curve, Matrix, Vector};
use crate::state::{Header, Layout, MAX_USED, rotate};
use arrayvec::ArrayVec;
use libc::{c_char, c_double};
use std::cell::RefCell;
use std::slice;
use std::thread::LocalKey;

/// What a refused increment is cut to.
pub(super) const CUTBACK: f64 = 0.5;
/// How far a rotation increment may be from orthogonal.
const ORTHOGONALITY: f64 = 1e-6;
/// Length of the contact and surface names.
const NAME_LENGTH: usize = 80;
/// What a contact without a name is called.
const UNNAMED: &str = "(unnamed)";
/// Laws kept per thread.
const MOST_LAWS: usize = 256;

/// The laws that a thread has used. A law never changes, so keeping it cannot change a result.
#[expect(clippy::vec_box, reason = "they change places")]
pub(super) struct Laws<const N: usize>(Vec<Box<Kept<N>>>);

struct Kept<const N: usize> {
    props: Vec<f64>,
    law: Law<N>,
}

/// Where a thread keeps its laws.
pub(super) type ThreadLaws<const N: usize> = LocalKey<RefCell<Laws<N>>>;

thread_local! {
    pub(super) static ONE: RefCell<Laws<1>> = const { RefCell::new(Laws(Vec::new())) };
    pub(super) static TWO: RefCell<Laws<2>> = const { RefCell::new(Laws(Vec::new())) };
}

impl<const N: usize> Laws<N> {
    /// The law for these properties; bits are compared, so that nothing can be taken for something else.
    #[inline(always)]
    fn get(&mut self, props: &[f64], nstate: usize) -> Result<&Law<N>, Error> {
        let same = |kept: &Kept<N>| {
            kept.law.layout().nstate == nstate
                && kept.props.len() == props.len()
                && (kept.props.iter().zip(props)).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        match self.0.iter().position(|kept| same(kept)) {
            // Points of one pair come one after the other: the law used last is looked at first.
            Some(index) => self.0.swap(0, index),
            None => {
                let law = Law::new(props, nstate)?;
                self.0.truncate(MOST_LAWS - 1);
                let props = props.to_vec();
                self.0.insert(0, Box::new(Kept { props, law }));
            }
        }
        Ok(&self.0[0].law)
    }
}

/// Runs `body` with this thread's law for these properties.
#[inline(always)]
pub(super) fn with_law<const N: usize>(
    laws: &'static ThreadLaws<N>,
    props: &[f64],
    nstate: usize,
    body: impl FnOnce(&Law<N>) -> Result<(), Error>,
) -> Result<(), Error> {
    let outcome = laws.try_with(|laws| body(laws.borrow_mut().get(props, nstate)?));
    // A host's own destructor may call while the thread ends.
    outcome.unwrap_or_else(|_| {
        let message = "the thread is ending, and what it kept is gone";
        Err(Error::new(Kind::BadInput, message))
    })
}

/// An error of the library in the words of a host: `name` takes the library's name of the argument, and the index
/// (from 0) of the number in it, and gives the host's, or None where the name is the host's already.
#[cold]
pub(super) fn in_host_words(
    mut error: Error,
    name: impl FnOnce(&str, usize) -> Option<String>,
) -> Error {
    let end = error.message.find([' ', '[']);
    let (ours, rest) = error.message.split_at(end.unwrap_or(0));
    let (index, rest) = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((index, rest)) => (index.parse().unwrap_or(0), rest),
        None => (0, rest),
    };
    if let Some(theirs) = name(ours, index) {
        error.message = format!("{theirs}{rest}");
    }
    error
}

/// What FRIC, UINTER and UMAT call the state and the sizes.
pub(super) fn common_name(ours: &str, index: usize) -> Option<String> {
    match ours {
        "state" => Some(format!("STATEV({})", index + 1)),
        "nstate" => Some("NSTATV".to_string()),
        "nprops" => Some("NPROPS".to_string()),
        _ => None,
    }
}

/// The refusal of a null pointer.
pub(super) fn null(name: &str) -> Error {
    Error::new(Kind::NullPointer, format!("{name} = NULL"))
}

/// Refuses outputs that are not there; the names stand in the same order.
#[inline(always)]
pub(super) fn required<const K: usize>(
    names: [&str; K],
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
pub(super) unsafe fn read<T: Copy>(name: &str, pointer: *const T) -> Result<T, Error> {
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
pub(super) unsafe fn count(name: &str, pointer: *const i32) -> Result<usize, Error> {
    // SAFETY: as the caller says.
    size(name, unsafe { read(name, pointer)? })
}

/// A size, which must not be negative.
#[inline(always)]
pub(super) fn size(name: &str, value: i32) -> Result<usize, Error> {
    usize::try_from(value)
        .map_err(|_| Error::new(Kind::BadInput, format!("{name} = {value}: must be >= 0")))
}

/// An array of the host.
///
/// # Safety
/// `pointer` is null or points to `len` numbers that nobody writes as long as the slice lives.
#[inline(always)]
pub(super) unsafe fn array<'a>(
    name: &str,
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
    name: &str,
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

/// Room for a copy of a state.
pub(super) type StateCopy = ArrayVec<f64, MAX_USED>;

/// A copy of the used part of a state, so that the end may be written over the start.
///
/// The room is the caller's: thousands of bytes that travel by value cost more than the update.
///
/// # Safety
/// `pointer` is null or points to a state of this layout.
pub(super) unsafe fn state<'a>(
    name: &str,
    layout: &Layout,
    pointer: *const c_double,
    copy: &'a mut StateCopy,
) -> Result<&'a mut [f64], Error> {
    // SAFETY: the used part is no longer than the state.
    let state = unsafe { array(name, pointer, layout.used())? };
    copy.clear();
    copy.try_extend_from_slice(state)
        .map_err(|_| Error::new(Kind::Internal, "a state longer than any layout"))?;
    Ok(copy)
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

/// Asks for a smaller increment.
///
/// # Safety
/// `pnewdt` is null or readable and writable.
pub(super) unsafe fn cut_back(pnewdt: *mut c_double) {
    // SAFETY: as the caller says.
    if let Some(pnewdt) = unsafe { pnewdt.as_mut() } {
        *pnewdt = pnewdt.min(CUTBACK);
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
/// `pointer` is null or points to a state of this law; `drot` as in [`turn`].
#[inline(always)]
pub(super) unsafe fn read_turned<const N: usize>(
    name: &str,
    law: &Law<N>,
    pointer: *const c_double,
    drot: *const c_double,
    memory: &mut Curve<N>,
) -> Result<Header, Error> {
    // SAFETY: as the caller says.
    unsafe {
        if N == 1 || stays(drot) {
            return law.read(array(name, pointer, law.layout().used())?, memory);
        }
        let mut copy = StateCopy::new();
        let state = state(name, law.layout(), pointer, &mut copy)?;
        turn(drot, law.layout(), state)?;
        law.read(state, memory)
    }
}

/// Whether the slip directions stay what they were.
///
/// # Safety
/// As in [`turn`].
unsafe fn stays(drot: *const c_double) -> bool {
    // SAFETY: four numbers by the caller's word.
    drot.is_null() || unsafe { slice::from_raw_parts(drot, 4) } == [1.0, 0.0, 0.0, 1.0]
}

/// Turns the remembered vectors with the slip directions.
///
/// # Safety
/// `drot` is null (nothing turns) or points to DROT(2,2), column-major.
unsafe fn turn(drot: *const c_double, layout: &Layout, state: &mut [f64]) -> Result<(), Error> {
    // SAFETY: as the caller says.
    if unsafe { stays(drot) } {
        return Ok(());
    }
    // SAFETY: four numbers by the caller's word.
    let entries = unsafe { slice::from_raw_parts(drot, 4) };
    let drot = Matrix::<2>::from_column_slice(entries);
    let off = || (drot.transpose() * drot - Matrix::<2>::identity()).norm();
    let proper = entries.iter().all(|x| within(*x, 1.0 + ORTHOGONALITY))
        && off() < ORTHOGONALITY
        && drot.determinant() > 0.0;
    if !proper {
        return Err(Error::new(
            Kind::BadInput,
            format!("DROT = {:?}: must be a rotation", numbers(entries)),
        ));
    }
    // The rotation next to it: the memory must not grow or shrink by what the host rounds.
    let (cosine, sine) = (drot[(0, 0)] + drot[(1, 1)], drot[(1, 0)] - drot[(0, 1)]);
    let length = cosine.hypot(sine);
    let (cosine, sine) = (cosine / length, sine / length);
    rotate(layout, &[[cosine, -sine], [sine, cosine]], state);
    Ok(())
}
