//! The language-neutral vectors of tests/vectors (their README describes the format).

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Where the vectors are, seen from the package.
pub const DIRECTORY: &str = "tests/vectors";

/// A point history with the values that the law must give.
pub struct VectorFile {
    pub path: PathBuf,
    pub props: Vec<f64>,
    pub nstate: usize,
    pub ndir: usize,
    /// Largest errors, as multiples of the largest limit traction (traction), and of that times gcr (energies).
    pub tolerances: Tolerances,
    pub rows: Vec<Row>,
}

pub struct Tolerances {
    pub traction: f64,
    pub dissipated: f64,
    pub stored: f64,
}

/// The end of a step and what is expected there.
pub struct Row {
    pub slip: Vec<f64>,
    pub pressure: f64,
    /// The caller's factor on mu; 1 where the file has none.
    pub mu_factor: f64,
    pub traction: Vec<f64>,
    pub dissipated: Option<f64>,
    pub stored: Option<f64>,
    pub status: Option<i32>,
}

/// All vectors without a factor on mu, by name: those that every face can replay.
pub fn all() -> Vec<VectorFile> {
    let mut files = every();
    files.retain(|file| file.rows.iter().all(|row| row.mu_factor == 1.0));
    files
}

/// All vectors, by name.
pub fn every() -> Vec<VectorFile> {
    let entries = std::fs::read_dir(DIRECTORY).expect(DIRECTORY);
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    paths.sort();
    assert!(paths.len() > 40, "{DIRECTORY} holds the vectors");
    paths.iter().map(|path| VectorFile::read(path)).collect()
}

impl VectorFile {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a readable vector file");
        let name = path.display();
        let mut keys = HashMap::new();
        let mut table = Vec::new();
        for line in text.lines() {
            if let Some(comment) = line.strip_prefix('#') {
                let (key, value) = comment
                    .split_once(':')
                    .unwrap_or_else(|| panic!("{name}: {line}"));
                keys.insert(key.trim(), value.trim());
            } else if !line.trim().is_empty() {
                table.push(line.split(',').map(str::trim).collect::<Vec<_>>());
            }
        }
        let key = |key: &str| *keys.get(key).unwrap_or_else(|| panic!("{name}: no {key}"));
        let number =
            |word: &str| -> f64 { word.parse().unwrap_or_else(|_| panic!("{name}: {word}")) };
        assert_eq!(key("name"), path.file_stem().expect("a name"), "{name}");
        assert!(!key("source").is_empty() && !key("about").is_empty());
        let (header, lines) = table
            .split_first()
            .unwrap_or_else(|| panic!("{name}: no header"));
        let column = |wanted: &str| header.iter().position(|column| *column == wanted);
        let ndir = if column("slip_2").is_some() { 2 } else { 1 };
        let needed =
            |wanted: &str| column(wanted).unwrap_or_else(|| panic!("{name}: no column {wanted}"));
        let vector = |stem: &str| -> Vec<usize> {
            (1..=ndir).map(|i| needed(&format!("{stem}_{i}"))).collect()
        };
        let (slip, traction, pressure) = (
            vector("slip"),
            vector("expected_traction"),
            needed("pressure"),
        );
        let energies = ["expected_dissipated_energy", "expected_stored_energy"].map(column);
        let tolerance = |key_: &str, used: bool| if used { number(key(key_)) } else { f64::NAN };
        let (status, factor) = (column("expected_status"), column("mu_factor"));
        let mut props = Vec::new();
        for word in key("properties").split_whitespace() {
            let (property, value) = word
                .split_once('=')
                .unwrap_or_else(|| panic!("{name}: {word}"));
            let index = mepc::NAMES.iter().position(|known| *known == property);
            let index = index.unwrap_or_else(|| panic!("{name}: no property {property}"));
            props.resize(props.len().max(index + 1), 0.0);
            props[index] = number(value);
        }
        VectorFile {
            path: path.to_path_buf(),
            props,
            nstate: key("nstate").parse().expect("a size"),
            ndir,
            tolerances: Tolerances {
                traction: tolerance("tolerance_traction", true),
                dissipated: tolerance("tolerance_dissipated_energy", energies[0].is_some()),
                stored: tolerance("tolerance_stored_energy", energies[1].is_some()),
            },
            rows: lines
                .iter()
                .map(|line| {
                    assert_eq!(line.len(), header.len(), "{name}: {line:?}");
                    let at = |index: usize| number(line[index]);
                    Row {
                        slip: slip.iter().map(|index| at(*index)).collect(),
                        pressure: at(pressure),
                        mu_factor: factor.map_or(1.0, at),
                        traction: traction.iter().map(|index| at(*index)).collect(),
                        dissipated: energies[0].map(at),
                        stored: energies[1].map(at),
                        status: status
                            .map(|index| at(index) as i32)
                            .filter(|status| *status >= 0),
                    }
                })
                .collect(),
        }
    }

    pub fn name(&self) -> String {
        self.path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned()
    }

    /// The largest limit traction of the file: the scale of tractions. The run-in only lowers it.
    pub fn limit(&self) -> f64 {
        let property = |number: usize| self.props.get(number - 1).copied().unwrap_or(0.0);
        let cap = if property(13) > 0.0 {
            property(13)
        } else {
            f64::INFINITY
        };
        let limit =
            |row: &Row| (property(12) + row.mu_factor * self.props[0] * row.pressure).min(cap);
        self.rows.iter().map(limit).fold(0.0, f64::max)
    }

    /// That times gcr: the scale of energies.
    pub fn energy(&self) -> f64 {
        self.limit() * self.props[1]
    }

    /// Compares one row's values with what is expected there: `dissipated` since the start.
    pub fn check(&self, index: usize, traction: &[f64], stored: f64, dissipated: f64, status: i32) {
        let row = &self.rows[index];
        let place = || format!("{}, row {index}", self.path.display());
        // Without friction there is no scale: then everything is exactly zero.
        let near = |what: &str, value: f64, expected: f64, allowed: f64| {
            let error = (value - expected).abs();
            assert!(
                error <= allowed,
                "{}: {what} {value:e}, expected {expected:e}, off by {error:e}",
                place()
            );
        };
        assert_eq!(traction.len(), self.ndir);
        for (value, expected) in traction.iter().zip(&row.traction) {
            near(
                "traction",
                *value,
                *expected,
                self.tolerances.traction * self.limit(),
            );
        }
        if let Some(expected) = row.dissipated {
            near(
                "dissipated",
                dissipated,
                expected,
                self.tolerances.dissipated * self.energy(),
            );
        }
        if let Some(expected) = row.stored {
            near(
                "stored",
                stored,
                expected,
                self.tolerances.stored * self.energy(),
            );
        }
        if let Some(expected) = row.status {
            assert_eq!(status, expected, "{}: contact status", place());
        }
    }
}
