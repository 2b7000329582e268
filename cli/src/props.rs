//! PROPS from the command line, by place or by name.

use crate::numbers;
use anyhow::{Result, anyhow};
use mepc::{COMMON, NAMES, Properties};

/// Help for --props, everywhere the same.
pub const HELP: &str = "Properties of the contact law, by place (mu,gcr,exponent,..) or by name: mu=.3,gcr=.0027,reference_pressure=10. \
What is left out or 0 has its default. The names: mu, gcr, exponent, method (memory, penalty, lagrange), reference_pressure, fraction, kn, \
gap0, normal_exponent, backbone (power_law, segalman), beta, cohesion, tau_max, mu_late, slip_late, resolution";

/// Symbols of the theory for some of the names.
const SYMBOLS: [(&str, &str); 6] = [
    ("chi", "exponent"),
    ("q", "exponent"),
    ("p0", "reference_pressure"),
    ("m", "normal_exponent"),
    ("c", "cohesion"),
    ("eta", "resolution"),
];
/// Words for numbers.
const WORDS: [(&str, &str, f64); 5] = [
    ("method", "memory", 0.0),
    ("method", "penalty", 1.0),
    ("method", "lagrange", 2.0),
    ("backbone", "power_law", 0.0),
    ("backbone", "segalman", 1.0),
];
/// Names this alike (Jaro and Winkler's measure) are proposed.
const ALIKE: f64 = 0.75;

/// The entries of PROPS, no longer than needed.
#[derive(Clone, Debug, PartialEq)]
pub struct Props(pub Vec<f64>);

/// For a command line: numbers by place, then numbers by name.
///
/// # Errors
/// What is no number, a name that is unknown or comes twice, a place after a name.
pub fn read(text: &str) -> Result<Props, String> {
    let mut props: Vec<f64> = Vec::new();
    let mut named: Vec<usize> = Vec::new();
    for (place, part) in text.split(',').enumerate() {
        let Some((name, value)) = part.split_once('=') else {
            if !named.is_empty() {
                return Err(format!(
                    "'{part}' after a name: places come first, then names"
                ));
            }
            props.push(numbers::argument(part)?);
            continue;
        };
        let name = name.trim().to_lowercase();
        let symbol = SYMBOLS.iter().find(|(symbol, _)| *symbol == name);
        let name = symbol.map_or(name.as_str(), |(_, name)| name);
        let known = NAMES
            .iter()
            .position(|known| *known == name && !known.starts_with("reserved"));
        let Some(index) = known else {
            return Err(unknown(name));
        };
        if named.contains(&index) || index < place - named.len() {
            return Err(format!("{name} is given twice"));
        }
        named.push(index);
        let word = value.trim().to_lowercase();
        let word = WORDS
            .iter()
            .find(|(of, word_of, _)| *of == name && *word_of == word);
        let number = match word {
            Some((_, _, number)) => *number,
            None => numbers::argument(value).map_err(|words| format!("{name}: {words}"))?,
        };
        if props.len() <= index {
            props.resize(index + 1, 0.0);
        }
        props[index] = number;
    }
    Ok(Props(props))
}

fn unknown(name: &str) -> String {
    let known = NAMES.iter().filter(|known| !known.starts_with("reserved"));
    let near = known
        .clone()
        .map(|known| (strsim::jaro_winkler(known, name), *known))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let proposal = match near {
        Some((alike, known)) if alike >= ALIKE => format!(", did you mean {known}?"),
        _ => String::new(),
    };
    let known: Vec<&str> = known.copied().collect();
    format!(
        "{name}: is no property{proposal} There are {}",
        known.join(", ")
    )
}

/// The entries, checked.
///
/// # Errors
/// Names the entry.
pub fn check(props: &[f64]) -> Result<Properties> {
    Properties::new(props).map_err(|error| anyhow!("--props: {error}"))
}

/// The whole common list, zeros where nothing is given.
pub fn complete(props: &[f64]) -> Vec<f64> {
    let mut all = props.to_vec();
    all.resize(COMMON, 0.0);
    all
}

/// Numbers for a deck: short where that is exact.
pub fn list(props: &[f64]) -> Vec<String> {
    props.iter().map(|&value| numbers::exact(value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_place_and_by_name() {
        for (text, props) in [
            ("0.3,0.002,2.5", &[0.3, 0.002, 2.5][..]),
            (
                "mu=.3,gcr=.0027,reference_pressure=10",
                &[0.3, 0.0027, 0.0, 0.0, 10.0],
            ),
            (" .3 , .002 , p0 = 10", &[0.3, 0.002, 0.0, 0.0, 10.0]),
            ("chi=2,MU=.3", &[0.3, 0.0, 2.0]),
            ("0.3,0.002,method=penalty", &[0.3, 0.002, 0.0, 1.0]),
            (
                "mu=.3,gcr=1,q=1.5,backbone=Segalman,beta=0.3",
                &[0.3, 1.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.3],
            ),
        ] {
            assert_eq!(read(text), Ok(Props(props.to_vec())), "{text}");
        }
        for (text, words) in [
            ("0.3,abc", "'abc' is not a number"),
            ("mu=.3,0.002", "'0.002' after a name"),
            ("mu=.3,mu=.4", "mu is given twice"),
            ("0.3,0.002,gcr=1", "gcr is given twice"),
            ("0.3,refrence_presure=3", "did you mean reference_pressure?"),
            ("reserved17=1", "reserved17: is no property"),
            ("mu=x", "mu: 'x' is not a number"),
            ("mu=memory", "mu: 'memory' is not a number"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    /// The help has every name of the library.
    #[test]
    fn the_help_is_complete() {
        for name in NAMES.iter().filter(|name| !name.starts_with("reserved")) {
            assert!(HELP.contains(name), "{name}");
        }
    }
}
