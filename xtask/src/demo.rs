//! `cargo xtask demo`: every case of cases/cases.toml through both drivers, against each other and a reference.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::comparison::{self, Row};
use crate::drivers::{Drivers, Replayed};
use crate::{expected, manifest, pictures};

pub fn run(root: &Path, docs: bool) -> Result<()> {
    let drivers = Drivers::find(root)?;
    let output = root.join("build/demo");
    // Nothing of an earlier run stays among the results.
    if output.exists() {
        std::fs::remove_dir_all(&output).with_context(|| output.display().to_string())?;
    }
    let (mut rows, mut broken) = (Vec::new(), Vec::new());
    let mut replayed: Vec<Replayed> = Vec::new();
    for case in manifest::read(&root.join("cases/cases.toml"))? {
        let r = drivers.replay(case, &output)?;
        for (index, &method) in r.case.methods().iter().enumerate() {
            let row = expected::of(&r, method).and_then(|expected| Row::new(&r, index, &expected));
            let row = row.with_context(|| format!("case {}, {}", r.case.name, method.name()))?;
            broken.extend(row.broken());
            rows.push(row);
        }
        broken.extend(comparison::same_loop(&r, &replayed)?);
        replayed.push(r);
    }
    comparison::print_table(&rows);
    let pictures = pictures::write(&replayed, &output, docs.then_some(root))?;
    println!(
        "\nCSV files and {pictures} pictures in {}",
        output.strip_prefix(root)?.display()
    );
    if !broken.is_empty() {
        bail!("bounds broken:\n  {}", broken.join("\n  "));
    }
    Ok(())
}
