//! Numbers as text, read and written.

use std::ops::RangeInclusive;

/// A number in C or Fortran notation (`1.5e-3`, `1.5D-3`), finite.
///
/// # Errors
/// What is wrong, to be put after the text.
pub fn read(text: &str) -> Result<f64, &'static str> {
    if text.is_empty() {
        return Err("is empty");
    }
    let bare = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
    if ["nan", "inf", "infinity"].contains(&bare.as_str()) {
        return Err("is not finite");
    }
    if !text.bytes().all(|b| b"0123456789+-.eEdD".contains(&b)) {
        return Err("is not a number");
    }
    let value: f64 = text
        .replace(['d', 'D'], "e")
        .parse()
        .map_err(|_| "is not a number")?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err("is too large")
    }
}

/// For a command line: a number, or words that name it.
///
/// # Errors
/// As [`read`].
pub fn argument(text: &str) -> Result<f64, String> {
    read(text.trim()).map_err(|words| format!("'{text}' {words}"))
}

/// For a command line: a number > 0.
///
/// # Errors
/// As [`read`], and zero or less.
pub fn positive(text: &str) -> Result<f64, String> {
    let value = argument(text)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err(format!("{text} is not positive"))
    }
}

/// For a command line: a whole number in a range.
///
/// # Errors
/// Anything else.
pub fn whole<T: TryFrom<u64>>(text: &str, range: RangeInclusive<u64>) -> Result<T, String> {
    let digits = text.bytes().all(|b| b.is_ascii_digit());
    let value = text
        .parse()
        .ok()
        .filter(|value| digits && range.contains(value));
    value
        .and_then(|value| T::try_from(value).ok())
        .ok_or_else(|| {
            format!(
                "'{text}' is not a whole number from {} to {}",
                range.start(),
                range.end()
            )
        })
}

/// The shortest text that gives the number back; with an exponent where zeros would hide it.
pub fn exact(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Six significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 && value.is_sign_negative() {
            "-0".to_string()
        } else {
            value.to_string()
        };
    }
    let scientific = format!("{value:.5e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text.to_string()
        }
    };
    if (-4..6).contains(&exponent) {
        trim(&format!("{value:.*}", (5 - exponent) as usize))
    } else {
        let sign = if exponent < 0 { '-' } else { '+' };
        format!("{}e{sign}{:02}", trim(mantissa), exponent.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_c_and_fortran() {
        for (text, value) in [
            ("1.5e-3", 1.5e-3),
            ("-2D2", -200.0),
            (".5", 0.5),
            ("+1.", 1.0),
        ] {
            assert_eq!(read(text), Ok(value));
        }
        for text in [
            "", "nan", "-Inf", "0x10", "1e", "--1", "1 2", "1e999", ".", "1,5",
        ] {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn whole_numbers() {
        assert_eq!(whole::<u8>("2", 1..=2), Ok(2));
        for text in [
            "",
            "abc",
            "+1",
            "-1",
            "1.0",
            "0",
            "3",
            "99999999999999999999",
        ] {
            let words = format!("'{text}' is not a whole number from 1 to 2");
            assert_eq!(whole::<u8>(text, 1..=2), Err(words));
        }
    }

    #[test]
    fn writes_what_is_read_back() {
        for (value, text) in [
            (0.1, "0.1"),
            (-0.5, "-0.5"),
            (1e-5, "1e-5"),
            (1e20, "1e20"),
            (123456.0, "123456"),
            (1.0 / 3.0, "0.3333333333333333"),
            (0.0, "0"),
        ] {
            assert_eq!(exact(value), text);
            assert_eq!(read(text), Ok(value));
        }
        assert_eq!(short(0.004_100_000_1), "0.0041");
        assert_eq!(short(1e6), "1e+06");
    }
}
