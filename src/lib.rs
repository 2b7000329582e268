//! Friction with memory for finite-element contact.
//!
//! The friction traction of a contact point follows mu p f(g / gcr) at first loading and remembers every
//! reversal after that: nested loops close, a larger loop wipes out the smaller ones, and the traction never
//! exceeds mu p. See `docs/theory.md` for the law and its derivation.
//!
//! FE codes load this crate as a shared library (`include/mepc.h`, `include/mepc.f90`, and the user-subroutine
//! symbols); Rust programs use [`Law`].
//!
//! ```
//! use mepc::{Law, Vector};
//!
//! let props = [0.3, 0.002, 2.5]; // mu, gcr (mm), chi
//! let law = Law::<1>::new(&props, 44)?;
//! let gcr = law.critical_slip(0.0)?;
//! let (start, mut end) = ([0.0; 44], [0.0; 44]); // zeros: virgin
//! let (pressure, mu_factor) = (100.0, 1.0);
//! let response = law.friction(gcr, &Vector::<1>::new(0.001), pressure, mu_factor, &start, &mut end)?;
//! assert!((response.traction[0] - 30.0 * 0.823223).abs() < 1e-4);
//! # Ok::<(), mepc::Error>(())
//! ```
#![deny(unsafe_code)]

pub mod backbone;
mod error;
#[allow(unsafe_code)]
pub mod ffi;
pub mod iwan;
// FRIC alone takes what is not public here.
#[cfg_attr(not(feature = "abaqus"), allow(dead_code))]
mod lagrange;
mod law;
mod limit;
mod memory;
mod number;
mod properties;
pub mod state;

pub use error::{Error, Fault, Kind, Value};
pub use lagrange::{Host, Rigid};
pub use law::{InterfaceResponse, Law, RIGID, Response, UNKNOWN_OPENING, default_state_size};
pub use memory::{Matrix, Vector};
pub use number::Number;
pub use properties::{COMMON, Method, NAMES, Properties, RunIn};
