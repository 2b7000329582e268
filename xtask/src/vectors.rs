//! `cargo xtask vectors`: point histories with the values a correct implementation returns.
//!
//! Every expected value comes from `mepc-oracle`; the library is not linked here.

mod closed_forms;
mod list;
mod paths;
mod vector;

use std::path::Path;

use anyhow::Result;

use crate::generated::{Generated, no_strays, settle};

pub fn run(root: &Path, check: bool) -> Result<()> {
    let directory = root.join("tests/vectors");
    let files: Vec<Generated> = list::all()
        .iter()
        .map(|v| Generated {
            path: directory.join(format!("{}.csv", v.name)),
            text: v.text(),
        })
        .collect();
    let count = settle(&files, check, "cargo xtask vectors")?;
    no_strays(&directory, "csv", &files)?;
    println!(
        "tests/vectors: {count} files {}",
        if check { "up to date" } else { "written" }
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::list::all;

    /// A reader of the files gets exactly the numbers that the expected values belong to.
    #[test]
    fn names_are_unique_and_rows_complete() {
        let vectors = all();
        for (i, v) in vectors.iter().enumerate() {
            assert!(vectors[..i].iter().all(|w| w.name != v.name), "{}", v.name);
            assert_eq!(v.steps.len(), v.expected.len(), "{}", v.name);
            let text = v.text();
            let mut rows = text.lines().filter(|l| !l.starts_with('#'));
            let columns = rows.next().unwrap().split(',').count();
            for row in rows {
                let numbers = row.split(',').map(|field| field.parse::<f64>().unwrap());
                assert_eq!(
                    numbers.filter(|x| x.is_finite()).count(),
                    columns,
                    "{}: {row}",
                    v.name
                );
            }
        }
    }

    #[test]
    fn item_2_in_physical_units() {
        let vectors = all();
        let nested = vectors.iter().find(|v| v.name == "nested_path").unwrap();
        assert_eq!(nested.law.props(), "0.3,0.002,2.5");
        assert!((nested.expected[3].traction[0] - 3.0 * 0.361386).abs() < 2e-6);
    }
}
