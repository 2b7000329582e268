//! What can go wrong, as the numbers of the C interface and a sentence that names the argument.

use std::fmt;

/// The kinds of failure; the discriminants are the status numbers of the C interface and are frozen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Kind {
    /// A required pointer is null.
    NullPointer = -1,
    /// A property is missing, out of range, or not meaningful for this call.
    BadProperty = -2,
    /// The state array is too short, or what it holds is not a state.
    BadState = -3,
    /// An input is not finite, or a size is out of range.
    BadInput = -4,
    /// A defect of this library (a caught panic).
    Internal = -5,
}

impl fmt::Display for Kind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Kind::NullPointer => "null pointer",
            Kind::BadProperty => "bad property",
            Kind::BadState => "bad state",
            Kind::BadInput => "bad input",
            Kind::Internal => "internal error (please report it)",
        })
    }
}

/// A number in a message. The formatting of a NaN compares it, which raises a flag that hosts trap.
pub(crate) struct Number(pub f64);

/// Several of them.
pub(crate) fn numbers(values: &[f64]) -> Vec<Number> {
    values.iter().copied().map(Number).collect()
}

impl fmt::Debug for Number {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_nan() {
            return out.write_str("NaN");
        }
        write!(out, "{:?}", self.0)
    }
}

/// A failed call: what kind, and a sentence that names the argument and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The kind, whose number a C caller sees.
    pub kind: Kind,
    /// Names the argument, its value and what was expected.
    pub message: String,
}

impl Error {
    pub(crate) fn new(kind: Kind, message: impl Into<String>) -> Self {
        Error {
            kind,
            message: message.into(),
        }
    }

    /// The part of the message that names the argument, without its value.
    pub fn cause(&self) -> &str {
        self.message.split(" = ").next().unwrap_or_default()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.kind, self.message)
    }
}

impl std::error::Error for Error {}
