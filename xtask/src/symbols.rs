//! `cargo xtask symbols`: the list of symbols that the shared library exports is frozen in a file.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::generated::settle;

pub fn run(root: &Path, library: &Path, check: bool) -> Result<()> {
    if !library.exists() {
        bail!(
            "{}: not there, run `cargo build --release` first",
            library.display()
        );
    }
    let nm = Command::new("nm")
        .args(["-D", "--defined-only"])
        .arg(library)
        .output()
        .context("nm (of binutils) does not start")?;
    if !nm.status.success() {
        bail!("nm: {}", String::from_utf8_lossy(&nm.stderr).trim());
    }
    let names = exported(&String::from_utf8(nm.stdout).context("nm's output is not text")?);
    let count = names.len();
    let text: String = names.iter().map(|name| format!("{name}\n")).collect();
    settle(
        &root.join("tests/symbols.txt"),
        &text,
        check,
        "cargo xtask symbols",
    )?;
    println!(
        "tests/symbols.txt: {count} symbols {}",
        if check { "as frozen" } else { "written" }
    );
    Ok(())
}

/// Sorted names from lines of `address type name`; a version suffix is not part of the name.
fn exported(listing: &str) -> Vec<String> {
    let mut names: Vec<String> = listing
        .lines()
        .filter_map(|line| line.split_whitespace().nth(2))
        .map(|name| name.split('@').next().unwrap_or(name).to_string())
        .collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::exported;

    #[test]
    fn names_are_sorted_and_bare() {
        let listing = "0000000000001000 T mepc_version\n0000000000002000 T fric_@@V1\n";
        assert_eq!(exported(listing), ["fric_", "mepc_version"]);
    }
}
