//! `mepc`: from a measured hysteresis loop of a joint to a contact law and an FE deck.

mod calibrate;
mod channels;
mod deck;
mod identify;
mod loops;
mod numbers;
mod pictures;
mod props;
mod replay;
mod table;
mod units;

use clap::{CommandFactory, Parser, Subcommand};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// From a measured hysteresis loop of a joint to a contact law and an FE deck.
///
/// Any consistent set of units; what a table calls mm and N may be m and kN throughout.
#[derive(Parser)]
#[command(name = "mepc", version, max_term_width = 100, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples, each going on from the one before:
  mepc loop --iwan 266.78,0.0041,3280.7,-0.842 --amplitude 0.02 --noise 0.01 --output loop.csv
                                  a loop to try things on: 1 % noise
  mepc identify loop.csv --picture loop.svg
                                  F_s, X_s, k_alpha, kappa with 95 % intervals
  mepc calibrate loop.csv --preload 900 --area 361.52
                                  mu, gcr, chi of the contact law, and the series stiffness
  mepc deck abaqus --props mu=.3,gcr=.0027,reference_pressure=2.5
                                  what to paste into the deck; 2.5 MPa = 900 N / 361.52 mm2

Files may be as the rig wrote them; how one was read is said on standard error.

Exit codes: 0 done; 1 bad input; 2 wrong command line; 3 done, but the data do not determine the
parameters (no gross slip): read the warnings.";

#[derive(Subcommand)]
enum Command {
    Identify(identify::Arguments),
    Calibrate(calibrate::Arguments),
    Loop(loops::Arguments),
    Deck(deck::Arguments),
    Replay(replay::Arguments),
    /// Print a completion script for a shell.
    ///
    /// mepc completions bash > ~/.local/share/bash-completion/completions/mepc
    /// mepc completions zsh > ~/.zfunc/_mepc
    /// mepc completions fish > ~/.config/fish/completions/mepc.fish
    #[command(verbatim_doc_comment)]
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages (section 1) into a directory, for example ~/.local/share/man/man1.
    Man {
        /// Where to; it must exist.
        directory: PathBuf,
    },
}

/// How a command ended, if not with an error.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Done,
    /// There is a result, and a warning that it must not be used as it is.
    Flagged,
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Loop(arguments) => loops::run(&arguments),
        Command::Deck(arguments) => deck::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "mepc", &mut text);
            print(&String::from_utf8_lossy(&text))
        }
        Command::Man { directory } => clap_mangen::generate_to(Arguments::command(), &directory)
            .map_err(|error| anyhow::anyhow!("{}: {error}", directory.display()))
            .map(|()| Outcome::Done),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Flagged) => ExitCode::from(3),
        Err(error) => {
            if let Some(error) = error.downcast_ref::<clap::Error>() {
                error.exit();
            }
            say(&format!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// A message on standard error. What a file holds may be part of it: control characters must not reach the terminal.
fn say(text: &str) {
    let mut clean = String::new();
    for character in text.chars() {
        if character.is_control() {
            clean += &format!("\\x{:02X}", u32::from(character));
        } else {
            clean.push(character);
        }
    }
    eprintln!("mepc: {clean}");
}

/// What an error of the library says, without its kind.
fn sentence(error: &mepc::Error) -> String {
    let words = error.to_string();
    let kind = format!("{}: ", error.kind);
    words.strip_prefix(&kind).unwrap_or(&words).to_string()
}

/// Writes to standard output. A reader who has seen enough (`| head`) is no error.
fn print(text: &str) -> anyhow::Result<Outcome> {
    let mut output = io::stdout().lock();
    match output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::anyhow!("standard output: {error}"))
        }
        _ => Ok(Outcome::Done),
    }
}

/// Writes a file, or standard output without a name.
fn write(file: Option<&Path>, text: &str) -> anyhow::Result<()> {
    let Some(file) = file else {
        return print(text).map(drop);
    };
    std::fs::write(file, text).map_err(|error| {
        // Emptied, so that nobody takes the part for the whole; it may be a device, so not removed.
        if file.exists() {
            let _ = std::fs::File::create(file);
        }
        anyhow::anyhow!("{}: {error}", file.display())
    })
}

/// What two names of one file have in common: device and number on the device.
#[cfg(unix)]
fn identity(file: &Path) -> io::Result<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    std::fs::metadata(file).map(|data| (data.dev(), data.ino()))
}

/// What two names of one file have in common: the full path (hard links stay unknown).
#[cfg(not(unix))]
fn identity(file: &Path) -> io::Result<PathBuf> {
    file.canonicalize()
}

/// Refuses an output file that is one of the input files, or another output, by whatever name or link; and a picture with
/// the ending of another format.
fn check_outputs(outputs: &[(&str, Option<&Path>)], inputs: &[&Path]) -> anyhow::Result<()> {
    // A file that is still to be made is known by its directory.
    let place = |file: &Path| {
        let directory = file.parent().map(|parent| Path::new(".").join(parent));
        Some(directory?.canonicalize().ok()?.join(file.file_name()?))
    };
    let same = |a: &Path, b: &Path| match (identity(a), identity(b)) {
        (Ok(a), Ok(b)) => a == b,
        (Err(_), Err(_)) => place(a).is_some_and(|a| Some(a) == place(b)),
        _ => false,
    };
    let given = outputs
        .iter()
        .filter_map(|(option, output)| Some((option, (*output)?)));
    let given: Vec<(&&str, &Path)> = given.collect();
    for (k, (option, output)) in given.iter().enumerate() {
        if let Some(input) = inputs.iter().find(|input| same(output, input)) {
            anyhow::bail!(
                "{option}: {} is the input file {}, which it would overwrite",
                output.display(),
                input.display()
            );
        }
        // A device (/dev/null) takes all.
        let device = output.exists() && !output.is_file();
        if let Some((other, _)) = given[..k].iter().find(|(_, other)| same(output, other))
            && !device
        {
            anyhow::bail!(
                "{option}: {} is the file of {other}, which it would overwrite",
                output.display()
            );
        }
        if option.ends_with("picture") {
            pictures::check(option, output)?;
        }
    }
    Ok(())
}

/// What clap cannot see by itself to be a wrong command line.
fn wrong_use(words: impl std::fmt::Display) -> anyhow::Error {
    Arguments::command()
        .error(clap::error::ErrorKind::ValueValidation, words)
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
