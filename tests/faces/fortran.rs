//! The Fortran programs that play the host.

pub use crate::support::programs::run;
use crate::support::programs::{STRICT_FORTRAN, compile, in_repository};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Normal stiffness of the callers, a power of two (tests/fortran/history.f90).
pub const NORMAL_STIFFNESS: f64 = 1_048_576.0;
/// Points of a block of the explicit routines.
pub const POINTS: usize = 3;

/// Compiles a program from its parts, the modules first, once per test run.
pub fn program(name: &str, parts: &[&str], flags: &[&str]) -> PathBuf {
    static DONE: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let mut done = DONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let directory = in_repository("build/faces").join(name);
    let program = directory.join(name);
    if done.contains(name) {
        return program;
    }
    std::fs::create_dir_all(&directory).expect("a directory for the program");
    let strict = [
        &STRICT_FORTRAN[..],
        &[
            "-O1",
            "-Wno-compare-reals",
            "-fimplicit-none",
            "-fcheck=all",
        ],
        &["-ffpe-trap=invalid,zero,overflow"],
        flags,
    ];
    let source = |part: &&str| in_repository(&format!("tests/fortran/{part}.f90"));
    let sources: Vec<PathBuf> = parts.iter().map(source).collect();
    compile("gfortran", &strict.concat(), &sources, &program);
    done.insert(name.to_string());
    program
}

/// The program `call_NAME`.
pub fn caller(name: &str) -> PathBuf {
    let call = format!("call_{name}");
    program(&call, &["history", "explicit_contacts", &call], &[])
}

/// The numbers that a caller prints, line by line.
pub fn numbers(program: &Path, arguments: &[&str], input: &str) -> Vec<Vec<f64>> {
    let output = run(program, arguments, input);
    let text = String::from_utf8_lossy(&output.stdout);
    let words = String::from_utf8_lossy(&output.stderr);
    let last = text.lines().last().unwrap_or_default();
    assert!(
        output.status.success(),
        "{}: {last}\n{words}",
        program.display()
    );
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word}"));
    text.lines()
        .map(|line| line.split_whitespace().map(number).collect())
        .collect()
}
