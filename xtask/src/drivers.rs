//! Runs the replay drivers and reads the tables they write.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow, bail};

use crate::manifest::Case;

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
        self.names
            .iter()
            .map(String::as_str)
            .zip(self.columns.iter().map(Vec::as_slice))
    }
}

/// One of the two replay programs.
pub struct Driver {
    program: PathBuf,
    /// The shared library, for the driver that loads it itself.
    library: Option<PathBuf>,
}

impl Driver {
    /// The C driver, which opens the shared library at run time.
    pub fn c(root: &Path) -> Result<Driver> {
        let program = root.join("build/mepc_replay");
        let library = root.join("target/release/libmepc.so");
        for path in [&program, &library] {
            if !path.exists() {
                bail!("{}: not there, run `make` first", path.display());
            }
        }
        Ok(Driver {
            program,
            library: Some(library),
        })
    }

    /// The Fortran driver, which is linked with the library.
    pub fn fortran(root: &Path) -> Result<Driver> {
        let program = root.join("build/fric_replay");
        if !program.exists() {
            bail!("{}: not there, run `make` first", program.display());
        }
        Ok(Driver {
            program,
            library: None,
        })
    }

    /// Replays a case and leaves the driver's table in `output`. Returns it and the number of updates in which the memory was
    /// full, as far as the driver knows: FRIC has no place for the library's advisory status.
    pub fn replay(&self, case: &Case, method: u8, output: &Path) -> Result<(Table, u64)> {
        let mut command = Command::new(&self.program);
        match &case.patch {
            None => command.arg("point"),
            Some(patch) => command.arg("patch").arg(patch),
        };
        command.arg(&case.history);
        let props: Vec<String> = case.props(method).iter().map(f64::to_string).collect();
        command.arg("--props").arg(props.join(","));
        command.arg("--output").arg(output);
        if let Some(nstate) = case.nstate {
            command.arg("--nstate").arg(nstate.to_string());
        }
        for (option, stiffness) in [("--series", case.series), ("--parallel", case.parallel)] {
            if let Some(stiffness) = stiffness {
                command.arg(option).arg(stiffness.to_string());
            }
        }
        if let Some(library) = &self.library {
            command.arg("--library").arg(library);
        }
        let run = command
            .output()
            .with_context(|| format!("{} does not start", self.program.display()))?;
        let said = String::from_utf8_lossy(&run.stderr);
        if !run.status.success() {
            bail!(
                "{} on case {}, method {method}: {}: {}",
                self.program.display(),
                case.name,
                run.status,
                said.trim()
            );
        }
        let memory_full = memory_full(&said).with_context(|| said.trim().to_string())?;
        Ok((Table::read(output)?, memory_full))
    }
}

/// The number in the driver's note on a full memory, zero without a note.
fn memory_full(said: &str) -> Result<u64> {
    match said.split_once("note: the memory was full in ") {
        None => Ok(0),
        Some((_, rest)) => Ok(rest.split(' ').next().unwrap_or_default().parse()?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_on_a_full_memory_is_read() {
        let said = "mepc_replay: note: the memory was full in 5 updates and the least important";
        assert_eq!(memory_full(said).unwrap(), 5);
        assert_eq!(memory_full("").unwrap(), 0);
        assert!(memory_full("note: the memory was full in some updates").is_err());
    }
}
