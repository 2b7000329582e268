//! Independent references for the contact law, naive and not optimised.
//!
//! Nothing here shares code with the library. Views of one theory, each checked against the others in its tests:
//!
//! - [`masing`]: the exact one-dimensional law at a constant limit, from Masing's rules and a stack of reversals;
//! - [`twin`]: thousands of parallel slip elements with radial return, for curved paths and changing limits;
//! - [`jenkins`]: one element of constant stiffness with a changing limit;
//! - [`closed`]: formulas for single numbers (cycle dissipation, circle, Hertz-Mindlin sphere, elastic bar,
//!   Iwan loop);
//! - [`law`]: the whole law, memory curve and all, plain and slow: to be read, and to be compared with the library.
//!
//! [`limit`] is the limit traction; [`spring`] puts the exact law behind a spring, as the drivers' patches do. Unless a
//! name says otherwise, slip is in units of the critical slip `gcr`, traction in `mu p` and energy in `mu p gcr`.

mod backbone;
pub mod closed;
pub mod jenkins;
pub mod law;
pub mod limit;
pub mod masing;
mod quadrature;
pub mod spring;
pub mod twin;

pub use backbone::Backbone;

/// Contact status as the library numbers it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Status {
    /// No contact, or never closed.
    #[default]
    Open = 0,
    /// No element, or next to none, slides.
    Stick = 1,
    /// Some elements slide.
    MicroSlip = 2,
    /// All elements slide.
    GrossSlip = 3,
}
