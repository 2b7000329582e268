//! The README's examples, compiled and run as a reader would.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What both examples print: mu p = 30 MPa, f(.5); then from .5 down by .75 (Masing: 2 f(.375)); then up by .25.
fn expected() -> [f64; 3] {
    let f = |s: f64| 1.0 - (1.0 - s).powf(2.5);
    let first = f(0.5);
    let second = first - 2.0 * f(0.375);
    [first, second, second + 2.0 * f(0.125)].map(|t| 30.0 * t)
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The first fenced block of a language.
fn block(language: &str) -> String {
    let readme = std::fs::read_to_string(root().join("README.md")).expect("README.md");
    let fence = format!("```{language}\n");
    let (_, rest) = readme.split_once(&fence).expect("an example in the README");
    let (code, _) = rest.split_once("```").expect("a closed example");
    code.to_owned()
}

/// The source in a directory of its own (tests run side by side).
fn source(directory: &str, file: &str, code: &str) -> PathBuf {
    let directory = root().join("build/readme").join(directory);
    std::fs::create_dir_all(&directory).expect("a directory for the example");
    let file = directory.join(file);
    std::fs::write(&file, code).expect("the example's source");
    file
}

/// Compiles the sources beside the last of them and compares what the program prints.
fn compile_and_run(compiler: &str, flags: &[&str], sources: &[&Path]) {
    let directory = sources
        .last()
        .and_then(|source| source.parent())
        .expect("a source in a directory");
    let library = root().join("target/release");
    let program = directory.join("example");
    let compiled = Command::new(compiler)
        .args(flags)
        .args(sources)
        .arg("-I")
        .arg(root().join("include"))
        .arg("-L")
        .arg(&library)
        .arg("-lmepc")
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .arg("-o")
        .arg(&program)
        .current_dir(directory)
        .output()
        .unwrap_or_else(|error| panic!("{compiler}: {error} (make setup installs it)"));
    let words = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{compiler}: {words}");
    // cargo points it at its own builds; the reader's program finds the library by its rpath.
    let run = Command::new(&program)
        .env_remove("LD_LIBRARY_PATH")
        .output()
        .expect("the example runs");
    let text = String::from_utf8(run.stdout).expect("text");
    assert!(run.status.success(), "{text}");
    let tractions: Vec<f64> = text
        .lines()
        .map(|line| {
            line.split_whitespace()
                .nth(1)
                .and_then(|word| word.parse().ok())
                .expect(line)
        })
        .collect();
    assert_eq!(tractions.len(), 3, "{text}");
    for (printed, exact) in tractions.iter().zip(expected()) {
        assert!(
            (printed - exact).abs() < 1e-5,
            "{printed} printed, {exact} expected"
        );
    }
}

#[test]
fn c_example() {
    let source = source("c", "example.c", &block("c"));
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
    compile_and_run("cc", &flags, &[&source]);
}

#[test]
fn c_example_as_cpp() {
    // The header in a C++ program; calloc without a cast is C only.
    let code = block("c").replace("= calloc(", "= (double *)calloc(");
    let source = source("cpp", "example.cpp", &code);
    compile_and_run("c++", &["-Wall", "-Wextra", "-Werror"], &[&source]);
}

#[test]
fn fortran_example() {
    let module = root().join("include/mepc.f90");
    let source = source("fortran", "example.f90", &block("fortran"));
    compile_and_run("gfortran", &["-Wall"], &[&module, &source]);
}
