//! Tables in JSON: an object with one array per column, at any depth.

use super::form::{Decimal, Field};
use super::{MOST_COLUMNS, MOST_NUMBERS};
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::io::{self, BufRead, Read};

/// A longer string is no name of a column.
const LONGEST_STRING: usize = 1 << 20;

/// A column: its name and its numbers, NaN where there is none.
pub type Column = (String, Vec<f64>);

/// Reads all arrays of numbers of an object.
///
/// # Errors
/// What is no JSON, or too large, in words that begin with line and column.
pub fn read(reader: impl BufRead) -> Result<Vec<Column>, String> {
    let mut columns = Columns::default();
    let mut input = serde_json::Deserializer::from_reader(Plain::new(reader));
    Object(&mut columns)
        .deserialize(&mut input)
        .and_then(|()| input.end())
        .map_err(|error| format!("is read as JSON: {error}"))?;
    Ok(columns.found)
}

#[derive(Default)]
struct Columns {
    found: Vec<Column>,
    numbers: usize,
}

/// An object: its arrays are columns, objects in it are looked through.
struct Object<'a>(&'a mut Columns);

impl<'de> DeserializeSeed<'de> for Object<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, input: D) -> Result<(), D::Error> {
        input.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Object<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(
            "an object with one array per column, {\"displacement\": [..], \"force\": [..]}",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(name) = map.next_key::<String>()? {
            map.next_value_seed(Member {
                columns: self.0,
                name,
            })?;
        }
        Ok(())
    }
}

/// What stands after a name.
struct Member<'a> {
    columns: &'a mut Columns,
    name: String,
}

impl<'de> DeserializeSeed<'de> for Member<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, input: D) -> Result<(), D::Error> {
        input.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Member<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an array of numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<(), A::Error> {
        Object(self.columns).visit_map(map)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        if self.columns.found.len() == MOST_COLUMNS {
            return Err(A::Error::custom(format!(
                "has more than {MOST_COLUMNS} arrays"
            )));
        }
        let mut values = Vec::new();
        while let Some(Sample(value)) = sequence.next_element()? {
            let Some(value) = value else {
                // No column: an array of texts, of arrays, of objects.
                while sequence.next_element::<IgnoredAny>()?.is_some() {}
                return Ok(());
            };
            values.push(value);
            self.columns.numbers += 1;
            if self.columns.numbers > MOST_NUMBERS {
                return Err(A::Error::custom(format!(
                    "has more than {MOST_NUMBERS} numbers"
                )));
            }
        }
        values.shrink_to_fit();
        self.columns.found.push((self.name, values));
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }
    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }
    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }
    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }
    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }
    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }
}

/// An element of an array: a number, NaN for what is missing, None for anything else.
struct Sample(Option<f64>);

impl<'de> serde::Deserialize<'de> for Sample {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Sample;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number")
            }
            fn visit_f64<E>(self, value: f64) -> Result<Sample, E> {
                Ok(Sample(Some(value)))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Sample, E> {
                Ok(Sample(Some(value as f64)))
            }
            fn visit_u64<E>(self, value: u64) -> Result<Sample, E> {
                Ok(Sample(Some(value as f64)))
            }
            fn visit_unit<E>(self) -> Result<Sample, E> {
                Ok(Sample(Some(f64::NAN)))
            }
            fn visit_str<E>(self, text: &str) -> Result<Sample, E> {
                Ok(Sample(
                    match Field::read(text.as_bytes(), &mut Decimal::Point) {
                        Field::Number(value) => Some(value),
                        Field::Missing => Some(f64::NAN),
                        Field::Text(_) => None,
                    },
                ))
            }
            fn visit_bool<E>(self, _: bool) -> Result<Sample, E> {
                Ok(Sample(None))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Sample, A::Error> {
                while sequence.next_element::<IgnoredAny>()?.is_some() {}
                Ok(Sample(None))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Sample, A::Error> {
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                Ok(Sample(None))
            }
        }
        input.deserialize_any(Any)
    }
}

/// Passes JSON on with `NaN`, which Python writes and JSON does not know, as an empty string; a string without end is an error.
struct Plain<R> {
    reader: R,
    in_string: bool,
    escaped: bool,
    length: usize,
    /// Letters of `NaN` that were passed.
    letters: usize,
}

impl<R> Plain<R> {
    fn new(reader: R) -> Self {
        Plain {
            reader,
            in_string: false,
            escaped: false,
            length: 0,
            letters: 0,
        }
    }

    fn pass(&mut self, byte: u8) -> io::Result<u8> {
        if self.in_string {
            self.length += 1;
            if self.length > LONGEST_STRING {
                return Err(io::Error::other("a string of more than 1 MB"));
            }
            if self.escaped {
                self.escaped = false;
            } else if byte == b'\\' {
                self.escaped = true;
            } else if byte == b'"' {
                self.in_string = false;
            }
            return Ok(byte);
        }
        self.letters = match (byte, self.letters) {
            (b'N', 0) => 1,
            (b'a', 1) => 2,
            (b'N', 2) => {
                self.letters = 0;
                return Ok(b' ');
            }
            _ => 0,
        };
        if byte == b'"' {
            self.in_string = true;
            self.length = 0;
        }
        Ok(if self.letters > 0 { b'"' } else { byte })
    }
}

impl<R: BufRead> Read for Plain<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = {
            let from = self.reader.fill_buf()?;
            let count = from.len().min(to.len());
            to[..count].copy_from_slice(&from[..count]);
            count
        };
        self.reader.consume(count);
        for byte in &mut to[..count] {
            *byte = self.pass(*byte)?;
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_columns() {
        let text = r#"{"rig": "A", "ok": true, "n": 3, "data": {"x (mm)": [1, 2.5, NaN], "F": ["1e3", null, -3]},
            "words": ["a", "b"], "pairs": [[1, 2], [3, 4]], "mixed": [1, "x", 3]}"#;
        let columns = read(text.as_bytes()).expect("columns");
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["x (mm)", "F"]);
        assert_eq!(columns[0].1[..2], [1.0, 2.5]);
        assert!(columns[0].1[2].is_nan() && columns[1].1[1].is_nan());
        assert_eq!((columns[1].1[0], columns[1].1[2]), (1000.0, -3.0));
        for (text, words) in [
            ("[1, 2]", "an object with one array per column"),
            ("{\"x\": [1, 2", "line 1"),
            ("{\"x\": [1]} 2", "trailing"),
        ] {
            let error = read(text.as_bytes()).expect_err(text);
            assert!(error.contains(words), "{error}");
        }
        let endless = io::Cursor::new(b"{\"x").chain(io::repeat(b'a'));
        let error = read(io::BufReader::new(endless)).expect_err("no end");
        assert!(error.contains("a string of more than 1 MB"), "{error}");
    }
}
