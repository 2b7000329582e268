//! The rim: what C and Fortran callers see. Faces convert arguments and hold no physics.
//!
//! Every exported function runs inside `guard`, so that no panic leaves the library.

// What the faces share is all there in every build; a build without some of them does not use all of it.
#![cfg_attr(
    not(all(feature = "abaqus", feature = "umat", feature = "mfront")),
    allow(dead_code, unused_imports, unused_macros)
)]

mod arguments;
mod components;
#[cfg(feature = "abaqus")]
pub mod fric;
pub mod iwan;
mod laws;
mod messages;
#[cfg(feature = "mfront")]
pub mod mfront;
pub mod native;
mod refusal;
#[cfg(feature = "abaqus")]
pub mod uinter;
#[cfg(feature = "umat")]
pub mod umat;
#[cfg(feature = "abaqus")]
pub mod vfric;

use crate::error::{Error, Kind};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs the body of an exported function; a panic becomes [`Kind::Internal`].
pub(crate) fn guard<T>(body: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|payload| Err(caught(&*payload)))
}

#[cold]
fn caught(payload: &(dyn Any + Send)) -> Error {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_string());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "panic without a message".to_string());
    Error::new(Kind::Internal, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_internal_error_with_its_words() {
        let words = |outcome: Result<(), Error>| {
            let error = outcome.expect_err("a panic");
            assert_eq!(error.kind, Kind::Internal);
            error.expected.to_string()
        };
        assert_eq!(words(guard(|| panic!("a str"))), "a str");
        assert_eq!(words(guard(|| panic!("a {}", "String"))), "a String");
        let other = guard(|| std::panic::panic_any(1));
        assert_eq!(words(other), "panic without a message");
    }
}
