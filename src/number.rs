//! Numbers that may be anything: looked at by their bits.
//!
//! Hosts trap floating-point flags, and comparing a signalling NaN, or several numbers at once as compilers do, raises
//! one. A look at the bits raises none.

use std::fmt;

/// Whether a number is neither infinite nor a NaN.
#[inline(always)]
pub(crate) fn finite(value: f64) -> bool {
    within(value, f64::MAX)
}

/// Whether |value| <= limit; false for a NaN.
#[inline(always)]
pub(crate) fn within(value: f64, limit: f64) -> bool {
    value.to_bits() & !SIGN <= limit.to_bits()
}

/// The bit of the sign.
const SIGN: u64 = 1 << 63;

/// A number in a message. Formatting a NaN compares it, which raises a flag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.to_bits() & !SIGN > f64::INFINITY.to_bits() {
            return out.write_str("NaN");
        }
        write!(out, "{:?}", self.0)
    }
}
