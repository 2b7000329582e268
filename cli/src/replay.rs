//! `mepc replay`: the histories of the C driver, same files, same outputs, without a compiler.

mod patch;
mod point;

use crate::numbers;
use crate::pictures::Replayed;
use crate::props::Props;
use crate::{Outcome, check_outputs, say, write};
use anyhow::{Result, anyhow, bail};
use clap::Subcommand;
use mepc::{Kind, Law, default_state_size};
use std::path::{Path, PathBuf};

/// Replay a load history through the contact law.
///
/// Each row holds the values at the end of a step; the first row is a step too, from zero slip and zero pressure. Pressure is
/// positive in compression; zero or less is an open contact. Columns are found by name, those that are not used are noted; lines
/// starting with # are skipped.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc replay point cases/nested_reversals.csv --props mu=.3,gcr=.002,reference_pressure=100 --picture point.svg
  mepc replay patch cases/lap_patch_902.csv cases/lap_history.csv --props mu=.42,gcr=.00268,reference_pressure=2.5 \\
      --series 178e3 --parallel 3.3e3 --output lap.csv

status: 0 open, 1 stick, 2 micro-slip, 3 gross slip. dissipated_energy counts from the start.")]
pub struct Arguments {
    #[command(subcommand)]
    mode: Mode,
}

#[derive(Subcommand)]
enum Mode {
    /// One contact point under prescribed slip and pressure.
    Point {
        /// time,slip_1[,slip_2],pressure
        #[arg(value_name = "HISTORY.csv")]
        history: PathBuf,
        #[command(flatten)]
        common: Common,
    },
    /// Contact points that share one rigid tangential motion, with springs in series and in parallel.
    Patch {
        /// x,y,area,pressure
        #[arg(value_name = "PATCH.csv")]
        patch: PathBuf,
        /// time,displacement_1[,displacement_2][,rotation][,pressure_scale]
        #[arg(value_name = "HISTORY.csv")]
        history: PathBuf,
        #[command(flatten)]
        common: Common,
        /// Spring in series, K (u - g) = contact force (default: rigid).
        #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = numbers::positive)]
        series: Option<f64>,
        /// Spring in parallel, adds K u to the force (default: none).
        #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = numbers::positive)]
        parallel: Option<f64>,
    },
}

#[derive(clap::Args)]
struct Common {
    #[arg(long, required = true, value_name = "mu,gcr,..", allow_hyphen_values = true,
        value_parser = crate::props::read, help = crate::props::HELP)]
    props: Props,
    /// Length of the state array (default: what the library recommends).
    #[arg(long, value_name = "N", value_parser = |text: &str| numbers::whole::<u32>(text, 1..=1_000_000))]
    nstate: Option<u32>,
    /// Write the table there (default: standard output).
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw forces over displacements, and energies over time, into this SVG file.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

/// What a replay leaves.
struct Replay {
    /// The output table.
    text: String,
    /// Updates that had to forget a reversal.
    forgotten: usize,
    drawn: Replayed,
}

/// Refuses pressures that are negative or zero throughout: the contact would be open and every force zero.
///
/// # Errors
/// Names the column.
fn check_sign(pressures: impl Iterator<Item = f64> + Clone, place: &str) -> Result<()> {
    let [low, high] = pressures.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
        [low.min(p), high.max(p)]
    });
    if low < 0.0 && high <= 0.0 {
        bail!(
            "{place}: {low} to {high}: the contact is never closed, for compression is positive; turn the sign if the file \
             counts tension as positive"
        );
    }
    Ok(())
}

impl Common {
    fn law<const N: usize>(&self) -> Result<Law<N>> {
        let named = |error: mepc::Error| {
            let option = if error.kind == Kind::BadState {
                "--nstate"
            } else {
                "--props"
            };
            anyhow!("{option}: {error}")
        };
        let nstate = match self.nstate {
            Some(n) => n as usize,
            None => default_state_size(&self.props.0, N).map_err(named)?,
        };
        Law::new(&self.props.0, nstate).map_err(named)
    }

    fn check_output(&self, inputs: &[&Path]) -> Result<()> {
        let outputs = [
            ("--output", self.output.as_deref()),
            ("--picture", self.picture.as_deref()),
        ];
        check_outputs(&outputs, inputs)
    }
}

/// Runs the command.
///
/// # Errors
/// Bad input, or an output that cannot be written.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let (replay, title, common) = match &arguments.mode {
        Mode::Point { history, common } => {
            common.check_output(&[history])?;
            let title = history.display().to_string();
            (point::run(history, common)?, title, common)
        }
        Mode::Patch {
            patch,
            history,
            common,
            series,
            parallel,
        } => {
            common.check_output(&[patch, history])?;
            let springs = Springs {
                series: *series,
                parallel: parallel.unwrap_or(0.0),
            };
            let title = format!("{}, {}", patch.display(), history.display());
            (patch::run(patch, history, common, springs)?, title, common)
        }
    };
    let Replay {
        text,
        forgotten,
        drawn,
    } = replay;
    if let Some(file) = &common.picture {
        write(Some(file), &drawn.svg(&title)?)?;
    }
    write(common.output.as_deref(), &text)?;
    if forgotten > 0 {
        say(&format!(
            "note: the memory was full in {forgotten} updates and the least important reversal was dropped, a longer state \
             array (--nstate) keeps it"
        ));
    }
    Ok(Outcome::Done)
}

/// The springs of a patch.
#[derive(Clone, Copy)]
pub struct Springs {
    /// Between the prescribed displacement and the contact; None is rigid.
    pub series: Option<f64>,
    /// Beside the contact.
    pub parallel: f64,
}

pub use patch::{Motion, Patch, Points};
