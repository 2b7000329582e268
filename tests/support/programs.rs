//! Programs in C, C++ and Fortran: compiled against the header or the module and the built library, and run.

use super::native::library_path;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Flags under which the header must compile.
pub const STRICT_C: [&str; 5] = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
/// Flags under which the Fortran module must compile.
pub const STRICT_FORTRAN: [&str; 4] = ["-std=f2018", "-Wall", "-Wextra", "-Werror"];

/// A file of the repository.
pub fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A source in a directory of its own below build/ (tests run side by side).
pub fn source(directory: &str, file: &str, code: &str) -> PathBuf {
    let file = in_repository("build").join(directory).join(file);
    std::fs::create_dir_all(file.parent().expect("a directory"))
        .expect("a directory for the source");
    std::fs::write(&file, code).expect("the source");
    file
}

/// Compiles sources, modules first, to a program in an existing directory, which also takes what the compiler leaves.
pub fn compile(compiler: &str, flags: &[&str], sources: &[PathBuf], program: &Path) {
    let library = library_path();
    let place = library.parent().expect("a directory");
    let compiled = Command::new(compiler)
        .args(flags)
        .args(sources)
        .arg("-I")
        .arg(in_repository("include"))
        .arg("-L")
        .arg(place)
        .arg("-lmepc")
        .arg(format!("-Wl,-rpath,{}", place.display()))
        .arg("-o")
        .arg(program)
        .current_dir(program.parent().expect("a directory"))
        .output()
        .unwrap_or_else(|error| panic!("{compiler}: {error} (make setup installs it)"));
    let words = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{}: {words}", program.display());
}

/// Runs a program with this standard input.
pub fn run(program: &Path, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(program)
        .args(arguments)
        // Cargo's own library path would come before the program's.
        .env_remove("LD_LIBRARY_PATH")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stdin = child.stdin.take().expect("piped");
    let input = input.to_string();
    // A program that stops early closes its end: what it says then is what counts.
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().expect("the program ends");
    let _ = writer.join().expect("no panic");
    output
}

/// Compiles sources to a program beside the last of them, and gives what it prints.
pub fn compile_and_run(compiler: &str, flags: &[&str], sources: &[PathBuf]) -> String {
    let program = sources.last().expect("a source").with_extension("out");
    compile(compiler, flags, sources, &program);
    let output = run(&program, &[], "");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {words}", program.display());
    String::from_utf8(output.stdout).expect("text")
}
