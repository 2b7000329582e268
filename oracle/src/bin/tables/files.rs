//! CSV files that are generated and committed: written, or compared with what is on disk.

use anyhow::{Context, Result, bail};
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// A generated file: base name and text.
pub struct File {
    pub name: String,
    pub text: String,
}

/// Reads a TOML file.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    toml::from_str(&text).with_context(|| path.display().to_string())
}

/// Writes the files, or with `check` fails naming those that differ. Fails when the directory holds CSV files that are
/// none of these.
pub fn settle(directory: &Path, files: &[File], check: bool, what: &str) -> Result<()> {
    let mut drifted = Vec::new();
    for file in files {
        let path = directory.join(format!("{}.csv", file.name));
        let on_disk = fs::read_to_string(&path).ok();
        if on_disk.as_deref() == Some(&file.text) {
            continue;
        }
        if !check {
            fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
            fs::write(&path, &file.text).with_context(|| path.display().to_string())?;
        } else if !on_disk.is_some_and(|text| same_numbers(&text, &file.text)) {
            drifted.push(path.display().to_string());
        }
    }
    if !drifted.is_empty() {
        bail!(
            "out of date, run `mepc-oracle {what}`: {}",
            drifted.join(", ")
        );
    }
    for entry in fs::read_dir(directory).with_context(|| directory.display().to_string())? {
        let path = entry?.path();
        let csv = path.extension().is_some_and(|extension| extension == "csv");
        if csv
            && !files.iter().any(|file| {
                path.file_stem()
                    .is_some_and(|stem| stem == file.name.as_str())
            })
        {
            bail!("{}: nothing writes this file, remove it", path.display());
        }
    }
    Ok(())
}

/// Whether two CSV files differ only in what another mathematical library makes of the last digits: the same comments
/// and header, and each number the same to 1e-8 of the largest in its column.
fn same_numbers(a: &str, b: &str) -> bool {
    let words = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|line| numbers(line).is_none())
            .map(str::to_string)
            .collect()
    };
    let table = |text: &str| -> Vec<Vec<f64>> { text.lines().filter_map(numbers).collect() };
    let (rows_a, rows_b) = (table(a), table(b));
    let shape = |rows: &[Vec<f64>]| rows.iter().map(Vec::len).collect::<Vec<_>>();
    if words(a) != words(b) || shape(&rows_a) != shape(&rows_b) {
        return false;
    }
    let largest = |column: usize| {
        let values = rows_a.iter().filter_map(|row| row.get(column));
        values.fold(0.0, |most: f64, x| most.max(x.abs()))
    };
    let width = rows_a.first().map_or(0, Vec::len);
    let allowed: Vec<f64> = (0..width).map(|column| 1e-8 * largest(column)).collect();
    rows_a.iter().zip(&rows_b).all(|(row_a, row_b)| {
        let pairs = row_a.iter().zip(row_b).zip(&allowed);
        pairs
            .into_iter()
            .all(|((x, y), allowed)| (x - y).abs() <= *allowed)
    })
}

/// The numbers of a line, if it holds nothing else.
fn numbers(line: &str) -> Option<Vec<f64>> {
    line.split(',').map(|field| field.parse().ok()).collect()
}

/// Rounds to twelve decimals, so that a file shows short numbers and a reader gets exactly those.
pub fn decimals(x: f64) -> f64 {
    let rounded: f64 = format!("{x:.12}")
        .parse()
        .expect("a printed number is a number");
    // No negative zero in a file.
    rounded + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_last_digits_may_differ() {
        let file = "# source: f = 1\na,b\n1,1e-20\n2.5,-3e-20\n";
        assert!(same_numbers(
            file,
            &file.replace("2.5", "2.500000000000001")
        ));
        assert!(!same_numbers(file, &file.replace("2.5", "2.5000001")));
        assert!(!same_numbers(file, &file.replace("1e-20", "1.1e-20")));
        assert!(!same_numbers(file, &file.replace("f = 1", "f = 2")));
        assert!(!same_numbers(file, &file.replace("a,b", "b,a")));
        assert!(!same_numbers(file, &file.replace("2.5,-3e-20\n", "")));
        assert!(!same_numbers(file, &file.replace("2.5,", "2.5,0,")));
    }

    #[test]
    fn decimals_are_short_and_without_negative_zero() {
        assert_eq!(decimals(0.1 + 0.2).to_string(), "0.3");
        assert_eq!(decimals(-1e-15).to_string(), "0");
    }
}
