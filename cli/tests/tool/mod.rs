//! Runs the tool in a directory of its own.
#![allow(dead_code, reason = "each test program uses a part")]

use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("cli is a directory of the repository")
        .to_path_buf()
}

/// What a run left.
pub struct Run {
    pub code: i32,
    pub output: String,
    pub errors: String,
}

/// A directory to run in.
pub struct Tool {
    pub directory: tempfile::TempDir,
}

impl Tool {
    pub fn new() -> Self {
        Tool {
            directory: tempfile::tempdir().expect("a directory"),
        }
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        let done = Command::new(env!("CARGO_BIN_EXE_mepc"))
            .args(arguments)
            .current_dir(self.directory.path())
            .output()
            .expect("the tool starts");
        Run {
            code: done.status.code().expect("no signal"),
            output: String::from_utf8(done.stdout).expect("text"),
            errors: String::from_utf8(done.stderr).expect("text"),
        }
    }

    /// Standard output of a run that must succeed.
    pub fn ok(&self, arguments: &[&str]) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.errors);
        run.output
    }

    /// The same as one JSON value.
    pub fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.ok(arguments)).expect("JSON")
    }

    pub fn path(&self, file: &str) -> PathBuf {
        self.directory.path().join(file)
    }

    pub fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.path(file)).expect(file)
    }

    pub fn write(&self, file: &str, text: &str) {
        std::fs::write(self.path(file), text).expect(file);
    }
}

/// The rows of a plain CSV text by column name.
pub fn csv(text: &str) -> Vec<HashMap<String, f64>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|line| {
            let values = line.split(',').map(|field| field.parse().expect(field));
            names.iter().map(ToString::to_string).zip(values).collect()
        })
        .collect()
}
