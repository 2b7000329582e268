//! Writes the tables that the repository keeps: test vectors (tests/vectors, from vectors.toml) and the histories and
//! patches of the demo (cases, from cases.toml). Nothing here comes from the library.
//!
//! `mepc-oracle vectors|cases [--check]`; with `--check` nothing is written and a file that differs is an error.

mod cases;
mod files;
mod paths;
mod vectors;

use anyhow::{Result, bail};
use std::path::Path;
use std::process::ExitCode;

fn run() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (what, check) = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [what] => (what, false),
        [what, "--check"] => (what, true),
        _ => ("", false),
    };
    let oracle = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (directory, files) = match what {
        "vectors" => (
            "tests/vectors",
            vectors::files(&oracle.join("vectors.toml"))?,
        ),
        "cases" => ("cases", cases::files(&oracle.join("cases.toml"))?),
        _ => bail!("usage: mepc-oracle vectors|cases [--check]"),
    };
    let root = oracle
        .parent()
        .expect("oracle is a directory of the repository");
    files::settle(&root.join(directory), &files, check, what)?;
    println!(
        "{directory}: {} files {}",
        files.len(),
        if check { "up to date" } else { "written" }
    );
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("mepc-oracle: {error:#}");
            ExitCode::FAILURE
        }
    }
}
