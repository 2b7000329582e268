//! Units of displacement and force: what they are called in files and on the command line, and their size in mm and N.

use clap::ValueEnum;

/// Pound-force in newtons (exact: .45359237 kg x 9.80665 m/s2).
const LBF: f64 = 4.448_221_615_260_5;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Length {
    /// Nanometre
    Nm,
    /// Micrometre
    #[value(alias = "µm", alias = "μm")]
    Um,
    /// Millimetre
    Mm,
    /// Centimetre
    Cm,
    /// Metre
    M,
    /// Inch
    In,
    /// Thousandth of an inch
    Mil,
}

/// A unit of force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Force {
    /// Newton
    #[value(name = "N")]
    N,
    /// Kilonewton
    #[value(name = "kN")]
    KiloN,
    /// Meganewton
    #[value(name = "MN")]
    MegaN,
    /// Pound-force
    #[value(name = "lbf")]
    Lbf,
    /// 1000 lbf
    #[value(name = "kip")]
    Kip,
}

impl Length {
    /// In mm.
    pub fn size(self) -> f64 {
        match self {
            Length::Nm => 1e-6,
            Length::Um => 1e-3,
            Length::Mm => 1.0,
            Length::Cm => 10.0,
            Length::M => 1e3,
            Length::In => 25.4,
            Length::Mil => 0.0254,
        }
    }

    /// As it is written after a number.
    pub fn name(self) -> &'static str {
        match self {
            Length::Nm => "nm",
            Length::Um => "um",
            Length::Mm => "mm",
            Length::Cm => "cm",
            Length::M => "m",
            Length::In => "in",
            Length::Mil => "mil",
        }
    }

    /// As files write it.
    pub fn read(text: &str) -> Option<Self> {
        // Case tells nm (length) from Nm (moment).
        if text == "nm" {
            return Some(Length::Nm);
        }
        Some(match text.trim_end_matches('.').to_lowercase().as_str() {
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometre" => Length::Um,
            "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" => Length::Mm,
            "cm" | "centimeter" | "centimetre" => Length::Cm,
            "m" | "meter" | "metre" | "meters" | "metres" => Length::M,
            "in" | "inch" | "inches" | "\"" => Length::In,
            "mil" | "mils" | "thou" => Length::Mil,
            _ => return None,
        })
    }
}

impl Force {
    /// In N.
    pub fn size(self) -> f64 {
        match self {
            Force::N => 1.0,
            Force::KiloN => 1e3,
            Force::MegaN => 1e6,
            Force::Lbf => LBF,
            Force::Kip => 1e3 * LBF,
        }
    }

    /// As it is written after a number.
    pub fn name(self) -> &'static str {
        match self {
            Force::N => "N",
            Force::KiloN => "kN",
            Force::MegaN => "MN",
            Force::Lbf => "lbf",
            Force::Kip => "kip",
        }
    }

    /// As files write it.
    pub fn read(text: &str) -> Option<Self> {
        // Case tells MN from mN.
        if text == "MN" {
            return Some(Force::MegaN);
        }
        Some(match text.trim_end_matches('.').to_lowercase().as_str() {
            "n" | "newton" | "newtons" => Force::N,
            "kn" | "kilonewton" | "kilonewtons" => Force::KiloN,
            "lb" | "lbs" | "lbf" | "pound" | "pounds" | "lb-f" => Force::Lbf,
            "kip" | "kips" | "klbf" | "klb" => Force::Kip,
            _ => return None,
        })
    }
}

/// What else may stand in a row of units, in lower case.
const OTHERS: [&str; 47] = [
    "s", "sec", "secs", "second", "seconds", "ms", "us", "min", "h", "hr", "hz", "khz", "°c",
    "degc", "deg c", "c", "°f", "degf", "k", "v", "mv", "volt", "volts", "a", "ma", "%", "-", "--",
    "1", "deg", "°", "rad", "n/mm", "n/m", "mm/s", "mm/min", "in/min", "mpa", "kpa", "gpa", "pa",
    "psi", "ksi", "nm", "n·m", "cycles", "segments",
];

/// Whether a field of a table is the name of a unit, in brackets or not.
pub fn is_unit(text: &str) -> bool {
    let text = bare(text);
    Length::read(text).is_some()
        || Force::read(text).is_some()
        || matches!(
            text,
            "mN" | "N.m" | "N-m" | "N*m" | "cycle" | "count" | "counts"
        )
        || OTHERS.contains(&text.to_lowercase().as_str())
}

/// Without the brackets about it.
pub fn bare(text: &str) -> &str {
    let text = text.trim();
    [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| text.strip_prefix(open)?.strip_suffix(close))
        .unwrap_or(text)
        .trim()
}

/// A column's name without its unit, and the unit: `Force (kN)`, `u [um]`, `load_lbf`, `u/mm`, `disp, in`.
pub fn split_name(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')] {
        if let Some(body) = name.strip_suffix(close)
            && let Some((before, unit)) = body.rsplit_once(open)
            && !before.trim().is_empty()
        {
            return (
                before.trim_end_matches([' ', '_', ',', '/', '\t']),
                Some(unit.trim()),
            );
        }
    }
    if let Some(at) = name.rfind(['_', '/', ',', ' ', '.', '-']) {
        let (before, unit) = (&name[..at], &name[at + 1..]);
        // A lower-case n is a number or a direction, not a newton.
        let known = unit != "n" && (Length::read(unit).is_some() || Force::read(unit).is_some());
        let before = before.trim_end_matches([' ', '_', ',', '/']);
        if known && !before.is_empty() {
            return (before, Some(unit));
        }
    }
    (name, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_names() {
        for (name, base, unit) in [
            ("Displacement (mm)", "Displacement", Some("mm")),
            ("Disp(mm)", "Disp", Some("mm")),
            ("u [\u{b5}m]", "u", Some("\u{b5}m")),
            ("load_kip", "load", Some("kip")),
            ("disp_in", "disp", Some("in")),
            ("F/kN", "F", Some("kN")),
            ("Force, lbf", "Force", Some("lbf")),
            ("Axial Force", "Axial Force", None),
            ("slip_1", "slip_1", None),
            ("force_n", "force_n", None),
            ("(mm)", "(mm)", None),
            ("mm", "mm", None),
        ] {
            assert_eq!(split_name(name), (base, unit), "{name}");
        }
    }

    #[test]
    fn sizes_and_names_go_together() {
        for length in Length::value_variants() {
            assert_eq!(Length::read(length.name()), Some(*length));
        }
        for force in Force::value_variants() {
            assert_eq!(Force::read(force.name()), Some(*force));
        }
        assert_eq!(Length::read("\u{3bc}m"), Some(Length::Um));
        assert_eq!(Length::read("Nm"), None);
        assert_eq!(Force::read("mN"), None);
        // A kip of 1000 lbf is 4448.2216 N, a mil 25.4 um.
        assert!((Force::Kip.size() - 4_448.221_615_260_5).abs() < 1e-9);
        assert!((Length::Mil.size() - 0.0254).abs() < 1e-15);
        for text in ["sec", "(mm)", "[kN]", "\u{b0}C", "N/mm", "-"] {
            assert!(is_unit(text), "{text}");
        }
        for text in ["Time", "Force", "lap joint", ""] {
            assert!(!is_unit(text), "{text}");
        }
    }
}
