//! The faces: every host's calling convention leads to the same kernel and the same numbers.
//!
//! Everything runs against the built shared library. The Fortran hosts are programs under tests/fortran with the full
//! argument lists; the UMAT of C hosts and the MFront behaviours are loaded and called as those hosts do.

#[path = "../support/mod.rs"]
mod support;

mod abaqus;
mod fortran;
mod mfront;
mod replay;
mod tangent;
mod umat;
