//! The README's examples, compiled and run as a reader would.

mod support;

use support::programs::{STRICT_C, compile_and_run, in_repository, source};

/// What both examples print: mu p = 30 MPa, f(.5); then from .5 down by .75 (Masing: 2 f(.375)); then up by .25.
fn expected() -> [f64; 3] {
    let f = |s: f64| 1.0 - (1.0 - s).powf(2.5);
    let first = f(0.5);
    let second = first - 2.0 * f(0.375);
    [first, second, second + 2.0 * f(0.125)].map(|t| 30.0 * t)
}

/// The first fenced block of a language.
fn block(language: &str) -> String {
    let readme = std::fs::read_to_string(in_repository("README.md")).expect("README.md");
    let fence = format!("```{language}\n");
    let (_, rest) = readme.split_once(&fence).expect("an example in the README");
    let (code, _) = rest.split_once("```").expect("a closed example");
    code.to_owned()
}

/// Compares what an example prints.
fn check(text: &str) {
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
    let source = source("readme/c", "example.c", &block("c"));
    check(&compile_and_run("cc", &STRICT_C, &[source]));
}

#[test]
fn c_example_as_cpp() {
    // The header in a C++ program; calloc without a cast is C only.
    let code = block("c").replace("= calloc(", "= (double *)calloc(");
    let source = source("readme/cpp", "example.cpp", &code);
    check(&compile_and_run("c++", &["-Wall", "-Wextra", "-Werror"], &[source]));
}

#[test]
fn fortran_example() {
    let module = in_repository("include/mepc.f90");
    let source = source("readme/fortran", "example.f90", &block("fortran"));
    check(&compile_and_run("gfortran", &["-Wall"], &[module, source]));
}
