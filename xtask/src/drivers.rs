//! Runs the two replay programs and reads tables.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow, bail};

use crate::generated;
use crate::manifest::{Case, Method};

/// A CSV file of numbers with named columns.
#[derive(Debug, Clone)]
pub struct Table {
    path: PathBuf,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    pub fn read(path: &Path) -> Result<Table> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_path(path)
            .with_context(|| path.display().to_string())?;
        let names: Vec<String> = reader.headers()?.iter().map(str::to_string).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record.with_context(|| path.display().to_string())?;
            let line = record.position().map_or(0, |p| p.line());
            for (field, (name, column)) in record.iter().zip(names.iter().zip(&mut columns)) {
                match field.parse::<f64>() {
                    Ok(number) if number.is_finite() => column.push(number),
                    _ => bail!(
                        "{}:{line}: column {name}: `{field}` is not a finite number",
                        path.display()
                    ),
                }
            }
        }
        if columns.first().is_none_or(Vec::is_empty) {
            bail!("{}: no rows", path.display());
        }
        Ok(Table {
            path: path.to_path_buf(),
            names,
            columns,
        })
    }

    pub fn rows(&self) -> usize {
        self.columns[0].len()
    }

    pub fn find(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|n| n == name)?;
        Some(&self.columns[index])
    }

    pub fn column(&self, name: &str) -> Result<&[f64]> {
        self.find(name)
            .ok_or_else(|| anyhow!("{}: no column {name}", self.path.display()))
    }

    pub fn columns(&self) -> impl Iterator<Item = (&str, &[f64])> {
        let columns = self.columns.iter().map(Vec::as_slice);
        self.names.iter().map(String::as_str).zip(columns)
    }
}

/// A case with what goes in and what came out of both programs, method after method.
pub struct Replayed {
    pub case: Case,
    pub history: Table,
    pub patch: Option<Table>,
    pub c: Vec<Table>,
    pub fortran: Vec<Table>,
    /// Updates of the C driver in which the memory was full; FRIC has no place for this status.
    pub memory_full: Vec<u64>,
}

/// The two programs; the C driver opens the shared library, the Fortran driver is linked with it.
pub struct Drivers {
    c: PathBuf,
    fortran: PathBuf,
    library: PathBuf,
}

impl Drivers {
    pub fn find(root: &Path) -> Result<Drivers> {
        let drivers = Drivers {
            c: root.join("build/mepc_replay"),
            fortran: root.join("build/fric_replay"),
            library: root.join("target/release/libmepc.so"),
        };
        for path in [&drivers.c, &drivers.fortran, &drivers.library] {
            if !path.exists() {
                bail!("{}: not there, run `make build` first", path.display());
            }
        }
        Ok(drivers)
    }

    /// Replays a case with all methods; the programs' tables stay in `output`.
    pub fn replay(&self, case: Case, output: &Path) -> Result<Replayed> {
        let mut replayed = Replayed {
            history: Table::read(&case.history)?,
            patch: case.patch.as_deref().map(Table::read).transpose()?,
            case,
            c: Vec::new(),
            fortran: Vec::new(),
            memory_full: Vec::new(),
        };
        for &method in replayed.case.methods() {
            let case = &replayed.case;
            let file = |language: &str| {
                output.join(format!("{}_{}_{language}.csv", case.name, method.name()))
            };
            let (table, said) = run(&self.c, Some(&self.library), case, method, &file("c"))?;
            replayed
                .memory_full
                .push(memory_full(&said).with_context(|| said.clone())?);
            replayed.c.push(table);
            let (table, _) = run(&self.fortran, None, case, method, &file("fortran"))?;
            replayed.fortran.push(table);
        }
        Ok(replayed)
    }
}

/// Runs a program; its table, which is written to a file, and what it said on standard error.
fn run(
    program: &Path,
    library: Option<&Path>,
    case: &Case,
    method: Method,
    output: &Path,
) -> Result<(Table, String)> {
    let mut command = Command::new(program);
    command.arg(if case.patch.is_some() {
        "patch"
    } else {
        "point"
    });
    command.args(library);
    let props: Vec<String> = case.props(method).iter().map(f64::to_string).collect();
    command
        .arg(props.join(","))
        .args(&case.patch)
        .arg(&case.history);
    let options = [
        ("--nstate", case.nstate.map(f64::from)),
        ("--series", case.series),
        ("--parallel", case.parallel),
    ];
    for (option, value) in options {
        command.args(
            value
                .into_iter()
                .flat_map(|value| [option.to_string(), value.to_string()]),
        );
    }
    let run = command
        .output()
        .with_context(|| format!("{} does not start", program.display()))?;
    let said = String::from_utf8_lossy(&run.stderr).trim().to_string();
    if !run.status.success() {
        let program = program.display();
        bail!(
            "{program} on case {}, method {}: {said}",
            case.name,
            method.name()
        );
    }
    generated::write(output, &String::from_utf8_lossy(&run.stdout))?;
    Ok((Table::read(output)?, said))
}

/// The number in the driver's note on a full memory, zero without a note.
fn memory_full(said: &str) -> Result<u64> {
    match said.split_once("a knot that mattered was dropped in ") {
        None => Ok(0),
        Some((_, rest)) => Ok(rest.split(' ').next().unwrap_or_default().parse()?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_on_a_full_memory_is_read() {
        let said = "mepc_replay: note: a knot that mattered was dropped in 5 updates, a longer state keeps it";
        assert_eq!(memory_full(said).unwrap(), 5);
        assert_eq!(memory_full("").unwrap(), 0);
        assert!(memory_full("a knot that mattered was dropped in some updates").is_err());
    }
}
