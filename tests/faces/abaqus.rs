//! The routines of Abaqus on bad input, and the objects that are deployed with it.

use crate::fortran::{program, run};

/// Words of the messages, in the order of tests/fortran/refusals.f90, and the level that the host hears.
const MESSAGES: [(&str, &str, &str); 15] = [
    (
        "-2",
        "mepc UINTER: contact FEW, node 7, step 2, increment 5:",
        "NSTATV = 20: must be from 24 (default 84)",
    ),
    (
        "-2",
        "mepc UINTER: contact NO-KN, node 7, step 2, increment 5:",
        "PROPS(7) kn = 0",
    ),
    (
        "-2",
        "mepc UINTER: contact NO-LAW, node 7, step 2, increment 5:",
        "PROPS(1) mu = -1",
    ),
    (
        "-2",
        "mepc UINTER: contact MIRROR, node 7, step 2, increment 5:",
        "DROT = [1.0, 0.0, 0.0, -1.0]",
    ),
    (
        "-2",
        "mepc UINTER: contact NOT-A-NUMBER, node 7, step 2, increment 5:",
        "DRDISP(2) = NaN",
    ),
    (
        "-2",
        "mepc UINTER: contact TOO-LONG, node 7, step 2, increment 5:",
        "DRDISP(3) = 1e200",
    ),
    (
        "-2",
        "mepc UINTER: contact TOO-DEEP, node 7, step 2, increment 5:",
        "-RDISP(1) = -1e308",
    ),
    (
        "-3",
        "mepc VFRIC: contact NODE, node 0, step 1, increment 9:",
        "jConSlvid(2) = 3: must be a slave node, 1 to 2",
    ),
    (
        "-3",
        "mepc VFRIC: contact SHORT, node 0, step 1, increment 9:",
        "nStateVar = 23",
    ),
    (
        "-3",
        "mepc VFRIC: contact NOWHERE, node 11, step 1, increment 9:",
        "dircosSl = [0.0, 0.0, 0.0]",
    ),
    (
        "-3",
        "mepc VFRIC: contact NOT-A-NUMBER, node 11, step 1, increment 9:",
        "dSlipFric(3) = NaN",
    ),
    (
        "-3",
        "mepc VFRIC: contact STATE, node 12, step 1, increment 9:",
        "statev(10) Forgotten = NaN",
    ),
    (
        "-3",
        "mepc VFRIC: contact SINGLE, node 0, step 1, increment 9:",
        "must be in double precision, these are in single: run with double=both",
    ),
    (
        "-3",
        "mepc VFRICTION: contact BOLT, node 21, step 3, increment 4:",
        "area of the contact point = 0.0: must be > 0",
    ),
    (
        "-3",
        "mepc VFRICTION: contact LLLL",
        "area of the contact point = -2.2250738585072014e-308",
    ),
];

/// The longest text that the host's routine takes.
const LONGEST: usize = 500;

#[test]
fn refusals_of_the_routines() {
    let alone = program("refusals", &["history", "refusals"], &[]);
    let output = run(&alone, &[], "");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && said.ends_with("done\n"),
        "{said}"
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    let lines: Vec<&str> = errors.lines().collect();
    assert_eq!(lines.len(), MESSAGES.len(), "{errors}");
    for (line, (_, place, cause)) in lines.iter().zip(MESSAGES) {
        assert!(line.starts_with(place) && line.contains(cause), "{line}");
    }
}

#[test]
fn refusals_go_through_the_host_s_routine() {
    let hosted = program(
        "refusals_hosted",
        &["history", "host_services", "refusals"],
        &["-rdynamic"],
    );
    let output = run(&hosted, &[], "");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    let lines: Vec<&str> = said
        .lines()
        .filter(|line| line.starts_with("HOST"))
        .collect();
    assert_eq!(lines.len(), MESSAGES.len(), "{said}");
    for (line, (level, place, cause)) in lines.iter().zip(MESSAGES) {
        assert!(
            line.starts_with(&format!("HOST {level}: {place}")) && line.contains(cause),
            "{line}"
        );
    }
    let longest = lines.iter().map(|line| line.len()).max();
    assert!(longest <= Some("HOST -3: ".len() + LONGEST), "{said}");
}
