//! The Fortran programs that play the host.

use crate::support::native::library_path;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;

/// Normal stiffness of the callers, a power of two (tests/fortran/history.f90).
pub const NORMAL_STIFFNESS: f64 = 1_048_576.0;
/// Points of a block of the explicit routines.
pub const POINTS: usize = 3;

/// Compiles a program from its parts, the modules first, once per test run.
pub fn program(name: &str, parts: &[&str], flags: &[&str]) -> PathBuf {
    static DONE: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let mut done = DONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let directory = root.join("build/faces").join(name);
    let program = directory.join(name);
    if done.contains(name) {
        return program;
    }
    std::fs::create_dir_all(&directory).expect("a directory for the program");
    let library = library_path();
    let output = Command::new("gfortran")
        .args([
            "-std=f2018",
            "-O1",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-Wno-compare-reals",
            "-fimplicit-none",
        ])
        .args(["-fcheck=all", "-ffpe-trap=invalid,zero,overflow", "-J"])
        .arg(&directory)
        .args(flags)
        .args(
            parts
                .iter()
                .map(|part| root.join("tests/fortran").join(format!("{part}.f90"))),
        )
        .arg(&library)
        .arg(format!(
            "-Wl,-rpath,{}",
            library.parent().expect("a directory").display()
        ))
        .arg("-o")
        .arg(&program)
        .output()
        .expect("gfortran (make setup installs it)");
    assert!(
        output.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    done.insert(name.to_string());
    program
}

/// The program `call_NAME`.
pub fn caller(name: &str) -> PathBuf {
    let call = format!("call_{name}");
    program(&call, &["history", "explicit_contacts", &call], &[])
}

/// Runs a program with this standard input.
pub fn run(program: &Path, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    let mut stdin = child.stdin.take().expect("piped");
    let input = input.to_string();
    // A program that stops early closes its end: what it says then is what counts.
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().expect("the program ends");
    let _ = writer.join().expect("no panic");
    output
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
