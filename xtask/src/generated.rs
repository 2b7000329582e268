//! Files that are generated and committed: written, or compared with what is on disk.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Writes a generated file, or with `check` fails when the one on disk differs, naming the command that writes it.
pub fn settle(path: &Path, text: &str, check: bool, command: &str) -> Result<()> {
    if fs::read_to_string(path).is_ok_and(|on_disk| on_disk == text) {
        return Ok(());
    }
    if check {
        bail!("out of date, run `{command}`: {}", path.display());
    }
    write(path, text)
}

/// Writes a file and the directory it goes into.
pub fn write(path: &Path, text: &str) -> Result<()> {
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).with_context(|| directory.display().to_string())?;
    }
    fs::write(path, text).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_differs_is_told_or_written() {
        let path = std::env::temp_dir().join(format!("mepc_settle_{}.txt", std::process::id()));
        write(&path, "old").unwrap();
        assert!(settle(&path, "new", true, "cargo xtask header").is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        settle(&path, "new", false, "cargo xtask header").unwrap();
        settle(&path, "new", true, "cargo xtask header").unwrap();
        fs::remove_file(&path).unwrap();
    }
}
