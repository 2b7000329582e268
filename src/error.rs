//! What can go wrong, as a value: the kind, the argument, the number in it, and what was expected.
//!
//! Words are made at the edge, by [`Error::words`], with the names that the caller's program uses.

use crate::number::Number;
use std::borrow::Cow;
use std::fmt;
use std::ops::{Deref, DerefMut};

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

/// What an argument was.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Value {
    /// Nothing to show.
    #[default]
    None,
    /// A number.
    Number(Number),
    /// A count or a size.
    Count(i64),
    /// Several numbers.
    Numbers(Vec<Number>),
    /// Words, such as NULL.
    Text(Cow<'static, str>),
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::None => Ok(()),
            Value::Number(number) => write!(out, "{number}"),
            Value::Count(count) => write!(out, "{count}"),
            Value::Numbers(numbers) => {
                let words: Vec<_> = numbers.iter().map(Number::to_string).collect();
                write!(out, "[{}]", words.join(", "))
            }
            Value::Text(text) => out.write_str(text),
        }
    }
}

/// What a failed call tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The kind, whose number a C caller sees.
    pub kind: Kind,
    /// The argument, as the library calls it.
    pub argument: &'static str,
    /// Which number of the argument, from 0.
    pub index: Option<usize>,
    /// What that number is called: a property, a state variable. Empty where it has no name.
    pub name: Cow<'static, str>,
    /// What it was.
    pub value: Value,
    /// What was expected, as the end of a sentence that starts with the value ("must be finite").
    pub expected: Cow<'static, str>,
    /// Which point of a batch, and increment of a history, from 0; the outer one first.
    pub at: Vec<(&'static str, usize)>,
}

/// A failed call.
#[derive(Clone, Debug, PartialEq)]
pub struct Error(Box<Fault>);

impl Deref for Error {
    type Target = Fault;

    fn deref(&self) -> &Fault {
        &self.0
    }
}

impl DerefMut for Error {
    fn deref_mut(&mut self) -> &mut Fault {
        &mut self.0
    }
}

impl Error {
    /// An error that no argument is to blame for, in a sentence.
    #[cold]
    pub(crate) fn new(kind: Kind, message: impl Into<Cow<'static, str>>) -> Self {
        Error::about(kind, "", message)
    }

    /// An error about `argument`; `expected` ends a sentence that starts with the value.
    #[cold]
    pub(crate) fn about(
        kind: Kind,
        argument: &'static str,
        expected: impl Into<Cow<'static, str>>,
    ) -> Self {
        Error(Box::new(Fault {
            kind,
            argument,
            index: None,
            name: Cow::Borrowed(""),
            value: Value::None,
            expected: expected.into(),
            at: Vec::new(),
        }))
    }

    /// Names number `index` of the argument (from 0).
    pub(crate) fn index(mut self, index: usize) -> Self {
        self.index = Some(index);
        self
    }

    /// Says what that number is called.
    pub(crate) fn name(mut self, name: impl Into<Cow<'static, str>>) -> Self {
        self.name = name.into();
        self
    }

    /// Shows a number.
    pub(crate) fn number(mut self, value: f64) -> Self {
        self.value = Value::Number(Number(value));
        self
    }

    /// Shows a count or a size.
    pub(crate) fn count(mut self, value: impl TryInto<i64>) -> Self {
        self.value = Value::Count(value.try_into().unwrap_or(i64::MAX));
        self
    }

    /// Shows several numbers.
    pub(crate) fn numbers(mut self, values: &[f64]) -> Self {
        self.value = Value::Numbers(values.iter().copied().map(Number).collect());
        self
    }

    /// Shows words.
    pub(crate) fn text(mut self, text: impl Into<Cow<'static, str>>) -> Self {
        self.value = Value::Text(text.into());
        self
    }

    /// Names the increment of a history, then the point of a batch: what is outside comes later.
    pub(crate) fn at(mut self, what: &'static str, index: usize) -> Self {
        self.at.insert(0, (what, index));
        self
    }

    /// The message. `host_name` gives the host's name of an argument of the library and of the number in it that is
    /// meant (its index, from 0), or None where there is no other.
    pub fn words(&self, host_name: impl Fn(&str, Option<usize>) -> Option<String>) -> String {
        let mut words = format!("{}: ", self.kind);
        for (what, index) in &self.at {
            words += &format!("{what} {index}: ");
        }
        words += &match (host_name(self.argument, self.index), self.index) {
            (Some(theirs), _) => theirs,
            // Properties count from 1 in every host.
            (None, Some(index)) if self.argument == "PROPS" => format!("PROPS({})", index + 1),
            (None, Some(index)) => format!("{}[{index}]", self.argument),
            (None, None) => self.argument.to_string(),
        };
        if !self.name.is_empty() {
            words += &format!(" {}", self.name);
        }
        if self.value != Value::None {
            words += &format!(" = {}", self.value);
        }
        if self.argument.is_empty() {
            words += &self.expected;
        } else if !self.expected.is_empty() {
            words += &format!(": {}", self.expected);
        }
        words
    }
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.words(|_, _| None))
    }
}

impl std::error::Error for Error {}
