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

/// Six significant digits, zeros at the end left out.
pub fn short(value: f64) -> String {
    significant(value, 6, false)
}

/// As many digits as the standard error leaves: two of those that it has itself, but six at most.
pub fn with_error(value: f64, error: f64) -> String {
    let power = |number: f64| number.abs().log10().floor();
    let digits = power(value) - power(error) + 2.0;
    if value == 0.0 || !digits.is_finite() {
        return short(value);
    }
    // As is 0.1 with an error of 1: one digit shows that.
    significant(value, digits.clamp(1.0, 6.0) as usize, digits < 6.0)
}

/// Beside numbers of this size; what is rounding of them is zero.
pub fn beside(value: f64, size: f64) -> String {
    const ROUNDING: f64 = 1e-9;
    if value.abs() < ROUNDING * size.abs() {
        return "0".to_string();
    }
    short(value)
}

/// So many significant digits, with an exponent where the number has more zeros than that.
fn significant(value: f64, digits: usize, zeros: bool) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 && value.is_sign_negative() {
            "-0".to_string()
        } else {
            value.to_string()
        };
    }
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |text: &str| {
        if text.contains('.') && !zeros {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text.to_string()
        }
    };
    if (-4..6).contains(&exponent) {
        let places = (digits as i32 - 1 - exponent).max(0) as usize;
        // Rounded to the digits first: 123456 with three is 123000.
        let rounded = scientific.parse().unwrap_or(value);
        trim(&format!("{rounded:.places$}"))
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
        assert_eq!(short(123_456.7), "123457");
    }

    #[test]
    fn digits_that_are_deserved() {
        for (value, error, text) in [
            (266.799, 0.118, "266.80"),
            (0.004_087_72, 1.54e-5, "0.004088"),
            (3280.7, 12.0, "3281"),
            (178_234.0, 5600.0, "178200"),
            (-0.842, 0.016, "-0.842"),
            (266.78, 1e-15, "266.78"),
            (0.3, 0.0, "0.3"),
            (0.3, f64::INFINITY, "0.3"),
            (0.1, 3.0, "0.1"),
        ] {
            assert_eq!(with_error(value, error), text);
        }
        assert_eq!(beside(7.49e-18, 266.0), "0");
        assert_eq!(beside(-0.011_28, 266.0), "-0.01128");
    }
}
