//! Files that are generated and committed: written, or compared with what is on disk.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// A generated file.
pub struct Generated {
    pub path: PathBuf,
    pub text: String,
}

/// Writes the files, or with `check` fails naming those that differ and the command that writes them.
/// Returns how many there are.
pub fn settle(files: &[Generated], check: bool, command: &str) -> Result<usize> {
    let mut drifted = Vec::new();
    for file in files {
        let on_disk = fs::read_to_string(&file.path).ok();
        if on_disk.as_deref() == Some(&file.text) {
            continue;
        }
        if !check {
            write(&file.path, &file.text)?;
        } else if !on_disk.is_some_and(|text| same_numbers(&text, &file.text)) {
            drifted.push(file.path.display().to_string());
        }
    }
    if !drifted.is_empty() {
        bail!("out of date, run `{command}`: {}", drifted.join(", "));
    }
    Ok(files.len())
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

/// Fails when `directory` holds files with this extension that no generator writes.
pub fn no_strays(directory: &Path, extension: &str, files: &[Generated]) -> Result<()> {
    for entry in fs::read_dir(directory).with_context(|| directory.display().to_string())? {
        let path = entry?.path();
        let ours = path.extension().is_some_and(|e| e == extension);
        if ours && !files.iter().any(|f| f.path == path) {
            bail!(
                "{}: no generator writes this file, remove it",
                path.display()
            );
        }
    }
    Ok(())
}

/// Writes a file and the directory it goes into.
pub fn write(path: &Path, text: &str) -> Result<()> {
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
    }
    fs::write(path, text).with_context(|| path.display().to_string())
}

/// Rounds to so many decimals, so that a file shows short numbers and a reader gets exactly those.
pub fn decimals(x: f64, places: usize) -> f64 {
    let rounded: f64 = format!("{x:.places$}")
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
        assert_eq!(decimals(0.1 + 0.2, 12).to_string(), "0.3");
        assert_eq!(decimals(-1e-15, 12).to_string(), "0");
    }
}
