//! The laws that a thread has used: hosts pass PROPS in every call, which are checked once.

use super::arguments::null;
use crate::error::{Error, Kind};
use crate::law::Law;
use crate::properties::COMMON;
use arrayvec::ArrayVec;
use libc::c_double;
use std::cell::RefCell;
use std::thread::LocalKey;

/// Laws kept per thread.
const MOST_LAWS: usize = 256;

/// The laws that a thread has used. A law never changes, so keeping it cannot change a result.
#[expect(clippy::vec_box, reason = "they change places")]
pub(super) struct Laws<const N: usize>(Vec<Box<Kept<N>>>);

struct Kept<const N: usize> {
    /// The common properties as the host gave them; its own ones are no part of the law.
    props: ArrayVec<f64, COMMON>,
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
        let props = &props[..props.len().min(COMMON)];
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
                let props = props.iter().copied().collect();
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

/// Which predefined field multiplies mu, from 0: the host's own property 21, in which 0 is none.
#[inline(always)]
pub(super) fn field(
    props: &[f64],
    fields: impl Fn() -> Result<usize, Error>,
) -> Result<Option<usize>, Error> {
    match props.get(COMMON) {
        // The compiler would make a comparison of numbers of that, which raises a flag for a NaN.
        Some(number) if std::hint::black_box(number.to_bits()) << 1 != 0 => {
            some_field(*number, fields()?).map(Some)
        }
        _ => Ok(None),
    }
}

#[cold]
fn some_field(number: f64, fields: usize) -> Result<usize, Error> {
    if let Some(index) =
        (0..fields).find(|index| number.to_bits() == (1.0 + *index as f64).to_bits())
    {
        return Ok(index);
    }
    let expected = format!(
        "must be 0 (none) or the number of a predefined field that multiplies mu, here at most {fields}"
    );
    Err(Error::about(Kind::BadProperty, "PROPS", expected)
        .index(COMMON)
        .name("field")
        .number(number))
}

/// The factor on mu: 1, or a value of the field that PROPS(21) names: number `place(index)` of the array.
///
/// # Safety
/// The array is null or reaches that far.
#[inline(always)]
pub(super) unsafe fn mu_factor(
    props: &[f64],
    fields: impl Fn() -> Result<usize, Error>,
    name: &'static str,
    array: *const c_double,
    place: impl FnOnce(usize) -> usize,
) -> Result<f64, Error> {
    let Some(index) = field(props, fields)? else {
        return Ok(1.0);
    };
    if array.is_null() {
        return Err(null(name));
    }
    // SAFETY: not null, and it reaches that far by the caller's word.
    Ok(unsafe { *array.add(place(index)) })
}
