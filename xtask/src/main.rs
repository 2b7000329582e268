//! Chores of the repository: generated files and their drift checks, the demo's table and pictures.

mod comparison;
mod demo;
mod drivers;
mod expected;
mod generated;
mod header;
mod manifest;
mod pictures;
mod symbols;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Chores of the mepc repository.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Write include/mepc.h from the source.
    Header {
        /// Write nothing; fail when the file on disk differs.
        #[arg(long)]
        check: bool,
    },
    /// Write tests/symbols.txt, the list of symbols that the shared library exports.
    Symbols {
        /// Write nothing; fail when the file on disk differs.
        #[arg(long)]
        check: bool,
        /// The shared library.
        #[arg(long, default_value = "target/release/libmepc.so")]
        library: PathBuf,
    },
    /// Replay every case with both drivers: table on the screen, CSV files and pictures in build/demo.
    Demo {
        /// Also copy the picture of the three methods to docs/loops.svg.
        #[arg(long)]
        docs: bool,
    },
}

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask is a directory of the repository");
    let result = match Arguments::parse().chore {
        Chore::Header { check } => header::run(root, check),
        Chore::Symbols { check, library } => symbols::run(root, &root.join(library), check),
        Chore::Demo { docs } => demo::run(root, docs),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}
