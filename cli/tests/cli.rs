//! The tool as a user runs it: files in, tables and pictures out.

mod tool;

use mepc_oracle::closed;
use serde_json::Value;
use std::fmt::Write as _;
use tool::{Tool, csv, root};

/// Verification item 17.
const JOINT: &str = "266.78,0.0041,3280.7,-0.842";
const TRUTH: [(&str, f64); 4] = [
    ("F_s", 266.78),
    ("X_s", 0.0041),
    ("k_alpha", 3280.7),
    ("kappa", -0.842),
];

fn number(json: &Value, key: &str) -> f64 {
    json[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {json}"))
}

fn assert_truth(json: &Value, part: f64) {
    for (key, truth) in TRUTH {
        let value = number(json, key);
        assert!((value / truth - 1.0).abs() <= part, "{key} {value}");
    }
}

/// Leaves the loop of a joint in a file.
fn write_loop(tool: &Tool, joint: &str, file: &str) {
    write_loop_with(tool, joint, "0.02", file, &[]);
}

/// The same with another amplitude, and with options.
fn write_loop_with(tool: &Tool, joint: &str, amplitude: &str, file: &str, options: &[&str]) {
    let loops = ["loop", "--iwan", joint, "--amplitude", amplitude];
    tool.ok(&[&loops[..], options, &["--output", file]].concat());
}

#[test]
fn loop_to_parameters() {
    let tool = Tool::new();
    write_loop(&tool, JOINT, "clean.csv");
    let json = tool.json(&["identify", "clean.csv", "--json", "--picture", "clean.svg"]);
    assert_truth(&json, 1e-3);
    assert_eq!(json["warnings"].as_array().map(Vec::len), Some(0));
    let joint = closed::Iwan {
        force: 266.78,
        displacement: 0.0041,
        residual: 3280.7,
        kappa: -0.842,
    };
    for (key, exact, part) in [
        ("T_max", joint.peak_force(0.02), 1e-6),
        ("stick_stiffness", joint.stick_stiffness(), 1e-6),
        ("loop_area_fitted", joint.cycle_dissipation(0.02), 1e-6),
        // Trapezoids of 200 points.
        ("loop_area_measured", joint.cycle_dissipation(0.02), 1e-3),
    ] {
        let value = number(&json, key);
        assert!((value / exact - 1.0).abs() < part, "{key} {value} {exact}");
    }
    let picture = tool.read("clean.svg");
    for word in ["data", "least squares", "Residual", "displacement (mm)"] {
        assert!(picture.contains(word), "{word}");
    }
    roxmltree::Document::parse(&picture).expect("the picture is XML");

    // The table says the same.
    let table = tool.ok(&["identify", "clean.csv"]);
    assert!(
        table.contains("266.78") && table.contains("0.0041") && table.contains("-0.842"),
        "{table}"
    );
}

#[test]
fn noisy_cycles_other_names_and_units() {
    let tool = Tool::new();
    write_loop_with(
        &tool,
        JOINT,
        "0.02",
        "noisy.csv",
        &["--cycles", "3", "--noise", "0.01", "--seed", "2"],
    );
    // The same data in um and kN, shifted, with other names and separators.
    let mut text = String::from("# test 12\nt; u (um) ; F (kN)\n");
    for (k, row) in csv(&tool.read("noisy.csv")).iter().enumerate() {
        let _ = writeln!(
            text,
            "{k};{};{}",
            row["displacement"] * 1e3 + 50.0,
            row["force"] * 1e-3 + 1.5
        );
    }
    tool.write("other.csv", &text);
    let plain = tool.json(&["identify", "noisy.csv", "--json"]);
    let other = tool.json(&[
        "identify",
        "other.csv",
        "--json",
        "--displacement",
        "u (um)",
        "--displacement-unit",
        "um",
        "--force",
        "F (kN)",
        "--force-unit",
        "kN",
    ]);
    assert_truth(&plain, 0.05);
    for (key, _) in TRUTH {
        let (a, b) = (number(&plain, key), number(&other, key));
        assert!((a / b - 1.0).abs() < 1e-6, "{key} {a} {b}");
    }
    assert!((number(&other, "centre") - 0.05).abs() < 1e-9);
    assert!((number(&other, "mean_force") - 1500.0).abs() < 2.0);
    // Bootstrap and linearised errors are of one size, and repeat.
    let args = [
        "identify",
        "noisy.csv",
        "--json",
        "--bootstrap",
        "200",
        "--seed",
        "3",
    ];
    let boot = tool.json(&args);
    assert_eq!(boot, tool.json(&args));
    for (key, truth) in TRUTH {
        let ratio = number(&boot["standard_errors"], key) / number(&plain["standard_errors"], key);
        assert!((0.6..1.6).contains(&ratio), "{key} {ratio}");
        let interval = boot["interval_95"][key].as_array().expect("two numbers");
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().expect("a number"));
        // Five standard errors: the seed is fixed, this is no matter of luck.
        let width = high - low;
        assert!(
            low - width < truth && truth < high + width,
            "{key} {low} {high}"
        );
    }
    // The paper's procedure works on the same data, less well.
    let paper = tool.json(&["identify", "noisy.csv", "--json", "--method", "paper"]);
    for ((key, truth), part) in TRUTH.into_iter().zip([0.01, 0.15, 0.05, 0.3]) {
        let value = number(&paper, key);
        assert!((value / truth - 1.0).abs() < part, "{key} {value}");
    }
    for (key, _) in TRUTH {
        assert_eq!(plain["paper"][key], paper[key]);
    }
}

/// The paper's procedure has no intervals; where it misses, that is said.
#[test]
fn the_papers_procedure_is_no_better_than_it_is() {
    let tool = Tool::new();
    write_loop(&tool, JOINT, "clean.csv");
    let paper = ["identify", "clean.csv", "--method", "paper"];
    let json = tool.json(&[&paper[..], &["--json"]].concat());
    assert!(json["standard_errors"].is_null() && json["interval_95"].is_null());
    assert!(number(&json["scatter_of_the_lines"], "F_s") > 0.0);
    // On clean data anything is more than twice what least squares leaves.
    const MISSES: &str = "the paper's procedure misses this loop: rms ";
    assert!(
        json["warnings"][0]
            .as_str()
            .expect("words")
            .contains(MISSES)
    );
    let table = tool.ok(&paper);
    assert!(
        table.contains(MISSES) && !table.contains("interval"),
        "{table}"
    );
    let run = tool.run(&["identify", "clean.csv"]);
    assert!(run.output.contains(MISSES) && run.errors.lines().count() == 1);
    // It does well enough where noise is all that is left.
    write_loop_with(
        &tool,
        JOINT,
        "0.02",
        "noisy.csv",
        &["--noise", "0.02", "--seed", "2"],
    );
    assert!(!tool.ok(&["identify", "noisy.csv"]).contains(MISSES));
    let run = tool.run(&[&paper[..], &["--bootstrap", "200"]].concat());
    assert_eq!(run.code, 2);
    assert!(
        run.errors
            .contains("--bootstrap does not go with --method paper")
    );
}

/// However many loops there are, every one has a colour of its own.
#[test]
fn twelve_loops_can_be_told_apart() {
    let tool = Tool::new();
    let amplitudes: Vec<String> = (1..=12)
        .map(|k| format!("{}", 0.002 * f64::from(k)))
        .collect();
    let amplitudes = amplitudes.join(",");
    let loops = ["loop", "--iwan", JOINT, "--amplitude", &amplitudes];
    tool.ok(&[&loops[..], &["--output", "l.csv", "--picture", "l.svg"]].concat());
    let text = tool.read("l.svg");
    let picture = roxmltree::Document::parse(&text).expect("the picture is XML");
    // The wide lines are the curves.
    let colours: std::collections::HashSet<&str> = picture
        .descendants()
        .filter(|node| node.attribute("stroke-width") == Some("20"))
        .filter_map(|node| node.attribute("stroke"))
        .collect();
    assert_eq!(colours.len(), 12, "{colours:?}");
}

/// The residuals of a branch are a curve of their own: it never runs back.
#[test]
fn residuals_are_drawn_branch_by_branch() {
    let tool = Tool::new();
    write_loop_with(
        &tool,
        JOINT,
        "0.02",
        "l.csv",
        &["--noise", "0.01", "--cycles", "3"],
    );
    tool.ok(&["identify", "l.csv", "--picture", "l.svg"]);
    let text = tool.read("l.svg");
    let picture = roxmltree::Document::parse(&text).expect("the picture is XML");
    let panel = picture
        .root_element()
        .children()
        .nth(3)
        .expect("two panels");
    let branches = panel
        .descendants()
        .filter_map(|node| node.attribute("points"))
        .map(|points| -> Vec<i32> {
            let sides = points.split_whitespace();
            sides
                .map(|p| p.split(',').next().expect("x").parse().expect("a number"))
                .collect()
        })
        .filter(|x| x.len() > 100);
    let mut count = 0;
    for x in branches {
        let steps: Vec<i32> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|s| *s >= 0) || steps.iter().all(|s| *s <= 0));
        count += 1;
    }
    assert_eq!(count, 6);
}

/// Test rigs write a micro sign as one byte.
#[test]
fn latin_1_is_read() {
    let tool = Tool::new();
    write_loop(&tool, JOINT, "clean.csv");
    let clean = tool.read("clean.csv");
    let mut latin = b"# 20 \xB0C\namplitude,u (\xB5m),force\n".to_vec();
    latin.extend(
        clean
            .lines()
            .skip(1)
            .flat_map(|line| format!("{line}\n").into_bytes()),
    );
    std::fs::write(tool.path("latin.csv"), latin).expect("written");
    // The numbers are in mm, whatever the name says.
    let names = [
        "--displacement",
        "u (µm)",
        "--displacement-unit",
        "mm",
        "--json",
    ];
    let json = tool.json(&[&["identify", "latin.csv"], &names[..]].concat());
    assert_eq!(json, tool.json(&["identify", "clean.csv", "--json"]));
    // What is no number is still refused, with its line.
    std::fs::write(tool.path("word.csv"), b"displacement,force\n1,2\xB5\n").expect("written");
    let run = tool.run(&["identify", "word.csv"]);
    assert!(
        run.errors
            .contains("word.csv:2: column force: '2µ' is not a number")
    );
}

/// Sums of squares of huge or tiny numbers would be lost.
#[test]
fn huge_and_tiny_numbers_are_refused() {
    let tool = Tool::new();
    write_loop(&tool, JOINT, "clean.csv");
    for (factor, words) in [(1e300, "e302, is not from"), (1e-200, "e-198, is not from")] {
        let mut text = String::from("displacement,force\n");
        for row in csv(&tool.read("clean.csv")) {
            let _ = writeln!(
                text,
                "{:e},{:e}",
                row["displacement"],
                row["force"] * factor
            );
        }
        tool.write("scaled.csv", &text);
        for command in [
            &["identify", "scaled.csv"][..],
            &["calibrate", "scaled.csv", "--preload", "1", "--area", "1"],
        ] {
            let run = tool.run(command);
            assert_eq!(run.code, 1);
            assert!(run.errors.contains(words), "{}", run.errors);
        }
    }
}

#[test]
fn no_gross_slip_is_flagged() {
    let tool = Tool::new();
    write_loop_with(&tool, JOINT, "0.003", "small.csv", &["--noise", "0.005"]);
    let run = tool.run(&["identify", "small.csv", "--json", "--picture", "small.svg"]);
    assert_eq!(run.code, 3, "{}", run.errors);
    assert!(tool.read("small.svg").contains("(not reliable)"));
    assert!(run.errors.contains("gross slip"), "{}", run.errors);
    let json: Value = serde_json::from_str(&run.output).expect("JSON");
    assert_eq!(json["reliable"], false);
    assert!(
        json["warnings"][0]
            .as_str()
            .expect("words")
            .contains("gross slip")
    );
    let run = tool.run(&[
        "calibrate",
        "small.csv",
        "--preload",
        "900",
        "--area",
        "361.52",
    ]);
    assert_eq!(run.code, 3);
}

#[test]
fn bad_input_is_named() {
    let tool = Tool::new();
    tool.write("word.csv", "displacement,force\n0,0\n# note\n1,abc\n");
    tool.write("line.csv", "displacement,force\n0,0\n1,1\n2,2\n");
    tool.write("other.csv", "x,force\n0,0\n1,1\n");
    for (arguments, words) in [
        (
            vec!["identify", "word.csv"],
            "word.csv:4: column force: 'abc' is not a number",
        ),
        (
            vec!["identify", "other.csv"],
            "other.csv:1: column displacement: missing in the header, which has x, force",
        ),
        (
            vec!["identify", "line.csv"],
            "line.csv:1: columns displacement, force, 3 rows:",
        ),
        (vec!["identify", "none.csv"], "none.csv: "),
        (
            vec!["deck", "abaqus", "--props", "0.3,-1"],
            "PROPS(2) gcr = -1",
        ),
        (
            vec!["deck", "kratos", "--props", "0.3,1"],
            "PROPS(7) kn = 0",
        ),
        (
            vec!["deck", "calculix", "--props", "0.3,1,2.5,0,0,0.005,9"],
            "--thickness",
        ),
    ] {
        let run = tool.run(&arguments);
        assert_eq!(run.code, 1, "{arguments:?}");
        assert!(run.errors.contains(words), "{arguments:?}: {}", run.errors);
        assert!(run.output.is_empty());
    }
    for arguments in [
        vec!["identify"],
        vec!["loop", "--amplitude", "1"],
        vec!["loop", "--iwan", "1,2,3,x", "--amplitude", "1"],
        vec!["loop", "--iwan", "1,2,3,4", "--amplitude", "-1"],
        vec!["deck", "ansys", "--props", "1,1"],
    ] {
        assert_eq!(tool.run(&arguments).code, 2, "{arguments:?}");
    }
    const TWICE: &str = "multiple times";
    let iwan = ["--iwan", "1,1,1,0"];
    // In our words, not in those of the parser.
    for (arguments, words) in [
        (
            vec!["replay", "point", "a", "--props", "1,1", "--nstate", "abc"],
            "'abc' is not a whole number from 1 to 1000000",
        ),
        (
            [&["loop"], &iwan[..], &["--amplitude", "1", "--points", "2"]].concat(),
            "'2' is not a whole number from 3 to 1000000",
        ),
        (
            vec!["identify", "a", "--bootstrap", "1e3"],
            "'1e3' is not a whole number from 20 to 100000",
        ),
        (
            vec!["identify", "a", "--tolerance", "x"],
            "'x' is not a number",
        ),
        (
            vec!["identify", "a", "--tolerance", "0"],
            "0 is not above 0 and below 1",
        ),
        (
            vec!["identify", "a", "--tolerance", "2"],
            "2 is not above 0 and below 1",
        ),
        (
            [&["loop"], &iwan[..], &["--amplitude", "1", "--noise", "11"]].concat(),
            "11 is not from 0 to 10",
        ),
        (
            vec!["loop", "--iwan", "1,2,3", "--amplitude", "1"],
            "3 numbers, F_s,X_s,k_alpha,kappa are four",
        ),
        (
            vec!["loop", "--iwan", "1,0,3,0", "--amplitude", "1"],
            "X_s = 0",
        ),
        (
            vec!["calibrate", "a", "b", "--preload", "1", "--area", "1"],
            "--preload: 2 loops and 1 preloads",
        ),
        // A list that is given twice is not joined.
        (
            vec!["replay", "point", "a", "--props", "1,1", "--props", "2.5"],
            TWICE,
        ),
        (
            vec!["deck", "abaqus", "--props", "1,1", "--props", "2.5"],
            TWICE,
        ),
        (
            [&["loop"], &iwan[..], &iwan[..], &["--amplitude", "1"]].concat(),
            TWICE,
        ),
        (
            [
                &["loop"],
                &iwan[..],
                &["--amplitude", "1", "--amplitude", "2"],
            ]
            .concat(),
            TWICE,
        ),
    ] {
        let run = tool.run(&arguments);
        assert_eq!(run.code, 2, "{arguments:?}");
        assert!(run.errors.contains(words), "{arguments:?}: {}", run.errors);
    }
}

/// What `mepc replay` says about wrong or doubtful input.
#[test]
fn replay_says_what_is_wrong() {
    let tool = Tool::new();
    let header = "time,slip_1,pressure\n";
    tool.write("good.csv", &format!("{header}0,0,10\n1,0.001,10\n"));
    tool.write(
        "mistyped.csv",
        "# rig\ntime,slip_1,slip2,pressure,\n0,0,0,10,\n1,0.001,0.001,10,\n",
    );
    tool.write("escape.csv", &format!("{header}0,1\u{1b}[3m2,10\n"));
    tool.write("binary.csv", &format!("{header}0,1\02,10\n"));
    tool.write("patch.csv", "x,y,area,pressure,id\n0,0,1,10,a\n");
    tool.write(
        "motion.csv",
        "time,displacement_1,rotated\n0,0,0\n1,0.001,0\n",
    );
    std::os::unix::fs::symlink("good.csv", tool.path("soft.csv")).expect("a link");
    std::fs::hard_link(tool.path("good.csv"), tool.path("hard.csv")).expect("a link");
    tool.write("huge.csv", "x,y,area,pressure\n0,0,1e308,1000\n");
    tool.write("moved.csv", "time,displacement_1\n0,0.001\n");
    let props = ["--props", "0.3,0.002"];
    let overwrite = |output: &str, input: &str| {
        format!("--output: {output} is the input file {input}, which it would overwrite\n")
    };
    let cases: [(&[&str], &[&str], i32, String); 13] = [
        (&["point", "good.csv"], &props, 0, String::new()),
        (
            &["point", "mistyped.csv"],
            &props,
            0,
            "note: mistyped.csv:2: columns not used: slip2, 5 (no name)\n".to_string(),
        ),
        (
            &["patch", "patch.csv", "motion.csv"],
            &props,
            0,
            "note: motion.csv:1: columns not used: rotated\n\
             note: patch.csv:1: columns not used: id\n"
                .to_string(),
        ),
        (
            &["patch", "huge.csv", "moved.csv"],
            &props,
            1,
            "moved.csv:2: step 1: the result is not a finite number\n".to_string(),
        ),
        (
            &["point", "escape.csv"],
            &props,
            1,
            "escape.csv:2: column slip_1: '1\\x1B[3m2' is not a number\n".to_string(),
        ),
        (
            &["point", "binary.csv"],
            &props,
            1,
            "binary.csv: is not a text file\n".to_string(),
        ),
        (
            &["point", "good.csv", "--output", "./good.csv"],
            &props,
            1,
            overwrite("./good.csv", "good.csv"),
        ),
        (
            &["point", "good.csv", "--output", "soft.csv"],
            &props,
            1,
            overwrite("soft.csv", "good.csv"),
        ),
        (
            &["point", "good.csv", "--output", "hard.csv"],
            &props,
            1,
            overwrite("hard.csv", "good.csv"),
        ),
        (
            &["patch", "patch.csv", "motion.csv", "--output", "patch.csv"],
            &props,
            1,
            overwrite("patch.csv", "patch.csv"),
        ),
        (
            &["point", "good.csv", "--nstate", "12"],
            &props,
            1,
            "--nstate: bad state: nstate = 12: must be from 20 (default 44) to 1000000 state variables for 1 tangential \
             direction(s)\n"
                .to_string(),
        ),
        (
            &["point", "good.csv", "--props", "0.3,0"],
            &[],
            1,
            "--props: bad property: PROPS(2) gcr = 0.0 with a characteristic length of 0.0: a host without a \
             characteristic length needs gcr > 0 (otherwise gcr is fraction x characteristic length)\n"
                .to_string(),
        ),
        (
            &["point", "good.csv", "--props", "-1,1"],
            &[],
            1,
            "--props: bad property: PROPS(1) mu = -1.0: must be from 0 to 1e100\n".to_string(),
        ),
    ];
    for (arguments, more, code, words) in cases {
        let arguments = [arguments, more].concat();
        let run = tool.run(&[&["replay"], &arguments[..]].concat());
        assert_eq!(run.code, code, "{arguments:?}: {}", run.errors);
        assert_eq!(run.errors.replace("mepc: ", ""), words, "{arguments:?}");
    }
    assert!(tool.read("good.csv").starts_with(header));
}

/// A file that cannot be written to its end is emptied; a picture does not overwrite the loop that it shows.
#[test]
fn outputs_are_whole_and_no_inputs() {
    let tool = Tool::new();
    let done = std::process::Command::new("bash")
        .args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$@\"", "bash"])
        .arg(env!("CARGO_BIN_EXE_mepc"))
        .args([
            "loop",
            "--iwan",
            JOINT,
            "--amplitude",
            "0.02",
            "--points",
            "2000",
        ])
        .args(["--output", "loop.csv"])
        .current_dir(tool.directory.path())
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("mepc: loop.csv: "), "{said}");
    assert_eq!(tool.read("loop.csv"), "");

    write_loop(&tool, JOINT, "loop.csv");
    let before = tool.read("loop.csv");
    let run = tool.run(&["identify", "loop.csv", "--picture", "./loop.csv"]);
    assert_eq!(run.code, 1);
    assert!(
        run.errors
            .contains("--picture: ./loop.csv is the input file loop.csv")
    );
    assert_eq!(tool.read("loop.csv"), before);
    // Two outputs are two files, made already or not; a device takes both.
    std::os::unix::fs::symlink("loop.csv", tool.path("soft.csv")).expect("a link");
    let loops = ["loop", "--iwan", JOINT, "--amplitude", "0.02"];
    for (outputs, words) in [
        (
            ["--output", "new", "--picture", "./new"],
            "--picture: ./new is the file of --output",
        ),
        (
            ["--picture", "new", "--energy-picture", "new"],
            "--energy-picture: new is the file of --picture",
        ),
        (
            ["--output", "loop.csv", "--energy-picture", "soft.csv"],
            "--energy-picture: soft.csv is the file of --output",
        ),
    ] {
        let run = tool.run(&[&loops[..], &outputs].concat());
        assert_eq!(run.code, 1, "{outputs:?}");
        assert!(run.errors.contains(words), "{outputs:?}: {}", run.errors);
        assert!(!tool.path("new").exists());
    }
    assert_eq!(tool.read("loop.csv"), before);
    let null = ["--output", "/dev/null", "--picture", "/dev/null"];
    tool.ok(&[&loops[..], &null].concat());
    // The shortest numbers that are read back as they were.
    for field in before.lines().skip(1).flat_map(|line| line.split(',')) {
        let value: f64 = field.parse().expect("a number");
        let shortest = [value.to_string(), format!("{value:e}")];
        assert!(shortest.iter().any(|text| text == field), "{field}");
    }
    assert!(
        before
            .lines()
            .nth(1)
            .expect("a row")
            .starts_with("0.02,-0.02,")
    );
}

/// Loops of the contact law behind a spring: the law's own numbers come back.
#[test]
fn calibration_gives_the_law_back() {
    let tool = Tool::new();
    let law = [
        "--props",
        "0.3,0.00268,2.5",
        "--series",
        "178e3",
        "--parallel",
        "3.3e3",
        "--amplitude",
        "0.02",
    ];
    for preload in ["300", "700", "1100"] {
        let file = format!("p{preload}.csv");
        let mut arguments = vec!["loop", "--preload", preload, "--output", &file];
        arguments.extend(law);
        tool.ok(&arguments);
    }
    let one = tool.json(&[
        "calibrate",
        "p700.csv",
        "--preload",
        "700",
        "--area",
        "361.52",
        "--json",
    ]);
    let three = [
        "calibrate",
        "p300.csv",
        "p700.csv",
        "p1100.csv",
        "--preload",
        "300",
        "--preload",
        "700",
        "--preload",
        "1100",
        "--area",
        "361.52",
        "--json",
    ];
    let three = tool.json(&three);
    for json in [&one, &three] {
        for (key, truth) in [
            ("mu", 0.3),
            ("gcr", 0.00268),
            ("K_e", 178e3),
            ("k_alpha", 3.3e3),
        ] {
            let value = number(json, key);
            assert!((value / truth - 1.0).abs() < 1e-5, "{key} {value}");
        }
    }
    // Another exponent is seen to fit worse on clean data, and the tool says so.
    let run = tool.run(&[
        "calibrate",
        "p700.csv",
        "--preload",
        "700",
        "--area",
        "361.52",
        "--chi",
        "1.5",
    ]);
    assert!(
        run.errors.contains("chi = 1.5 of the contact fits worse"),
        "{}",
        run.errors
    );
    assert!(run.output.contains("fits as well as any"));
}

/// A noisy loop of a contact of 0.3, 2.68 um, 2.5 behind 178 kN/mm, in a file named after its preload.
fn write_sprung(tool: &Tool, preload: &str, seed: u64) -> String {
    let file = format!("p{preload}.csv");
    tool.ok(&[
        "loop",
        "--props",
        "0.3,0.00268,2.5",
        "--series",
        "178e3",
        "--parallel",
        "3.3e3",
        "--amplitude",
        "0.02",
        "--noise",
        "0.01",
        "--preload",
        preload,
        "--seed",
        &seed.to_string(),
        "--output",
        &file,
    ]);
    file
}

/// The command line that calibrates such loops.
fn calibrate<'a>(files: &'a [String], preloads: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["calibrate", "--area", "361.52"];
    arguments.extend(files.iter().map(String::as_str));
    arguments.extend(preloads.iter().flat_map(|p| ["--preload", p]));
    arguments
}

/// The standard errors are the scatter over many loops, and the intervals hold the truth as often as they say.
#[test]
fn calibration_knows_its_errors() {
    const RUNS: u64 = 40;
    for preloads in [&["900"][..], &["900", "1100"], &["300", "700", "1100"]] {
        let mut found: [Vec<[f64; 2]>; 3] = Default::default();
        for run in 0..RUNS {
            let tool = Tool::new();
            let files: Vec<String> = (0..)
                .zip(preloads)
                .map(|(k, preload)| write_sprung(&tool, preload, 10 * run + k))
                .collect();
            let json = tool.json(&[&calibrate(&files, preloads)[..], &["--json"]].concat());
            let errors = &json["standard_errors"];
            // 1/K_e is what is estimated.
            let series = number(&json, "K_e");
            for (all, one) in found.iter_mut().zip([
                [number(&json, "mu"), number(errors, "mu")],
                [number(&json, "gcr"), number(errors, "gcr")],
                [1.0 / series, number(errors, "K_e") / series.powi(2)],
            ]) {
                all.push(one);
            }
        }
        let runs = RUNS as f64;
        for (name, truth, values) in [
            ("mu", 0.3, &found[0]),
            ("gcr", 0.00268, &found[1]),
            ("1/K_e", 1.0 / 178e3, &found[2]),
        ] {
            let mean = |of: &dyn Fn(&[f64; 2]) -> f64| values.iter().map(of).sum::<f64>() / runs;
            let scatter = mean(&|v| (v[0] - truth).powi(2)).sqrt();
            let error = mean(&|v| v[1]);
            let held = mean(&|v| f64::from(u8::from((v[0] - truth).abs() < 1.96 * v[1])));
            println!("{preloads:?} {name}: scatter {scatter:.3e}, error {error:.3e}, {held:.2}");
            // Three standard deviations of the scatter of 40, and of a share of 95 %.
            assert!((0.67..1.5).contains(&(error / scatter)), "{name}");
            assert!(held > 0.85, "{name} {held}");
        }
    }
}

/// Loops that do not separate gcr and K_e are refused; what is ill-determined, or of another exponent, is said.
#[test]
fn calibration_refuses_and_warns() {
    let tool = Tool::new();
    let same = [write_sprung(&tool, "900", 1), "same.csv".to_string()];
    tool.write("same.csv", &tool.read(&same[0]));
    let other = ["p900.csv".to_string(), "other.csv".to_string()];
    write_sprung(&tool, "900", 2);
    std::fs::rename(tool.path("p900.csv"), tool.path("other.csv")).expect("renamed");
    write_sprung(&tool, "900", 1);
    for files in [&same, &other] {
        for json in [&[][..], &["--json"]] {
            let run = tool.run(&[&calibrate(files, &["900", "1100"])[..], json].concat());
            assert_eq!(run.code, 1);
            for words in ["do not separate", "900, 1100 N", "F_s = 2"] {
                assert!(run.errors.contains(words), "{words}: {}", run.errors);
            }
            assert!(!run.errors.contains("NaN"), "{}", run.errors);
            assert!(run.output.is_empty(), "{}", run.output);
        }
    }

    let preloads = ["300", "700", "1100"];
    let files = preloads.map(|preload| write_sprung(&tool, preload, 5));
    let run = tool.run(&calibrate(&files, &preloads));
    // How each of the three files was read, and no warning.
    assert_eq!((run.code, run.errors.lines().count()), (0, 3));
    assert!(run.errors.lines().all(|line| line.contains(": reading: ")));
    assert!(run.output.contains("Next: mepc deck"));
    let run = tool.run(&[&calibrate(&files, &preloads)[..], &["--chi", "4"]].concat());
    assert_eq!(run.code, 3);
    assert!(
        run.errors.contains("chi = 4 of the contact fits worse"),
        "{}",
        run.errors
    );

    // Two preloads leave K_e to within 11 % or so.
    let run = tool.run(&calibrate(&files[1..], &preloads[1..]));
    assert!(run.errors.lines().all(|line| line.contains(": reading: ")));
    let near = [write_sprung(&tool, "900", 3), files[2].clone()];
    let run = tool.run(&calibrate(&near, &["900", "1100"]));
    assert!(
        run.errors.contains("K_e is ill-determined"),
        "{}",
        run.errors
    );

    // Without gross slip there is a table to look at, but no next step.
    write_loop_with(&tool, JOINT, "0.003", "small.csv", &[]);
    let small = ["small.csv".to_string()];
    let run = tool.run(&calibrate(&small, &["900"]));
    assert_eq!(run.code, 3);
    assert!(!run.output.contains("Next:"), "{}", run.output);
}

/// Neighbouring seeds give noise that has nothing in common.
#[test]
fn noise_of_neighbouring_seeds_is_independent() {
    let tool = Tool::new();
    let noise = |seed: &str| -> Vec<f64> {
        let force = |noise: &str| -> Vec<f64> {
            write_loop_with(
                &tool,
                JOINT,
                "0.02",
                "n.csv",
                &["--points", "2000", "--noise", noise, "--seed", seed],
            );
            csv(&tool.read("n.csv"))
                .iter()
                .map(|row| row["force"])
                .collect()
        };
        let pairs = force("0.01").into_iter().zip(force("0"));
        pairs.map(|(noisy, clean)| noisy - clean).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let all = ["1", "2", "3", "4"].map(noise);
    for (k, a) in all.iter().enumerate() {
        for b in &all[..k] {
            let correlation = product(a, b) / (product(a, a) * product(b, b)).sqrt();
            assert!(correlation.abs() < 0.08, "{correlation}");
        }
    }
}

/// The paper's Tables 2 and 3 together read as gcr = 2.68 um behind 178 kN/mm: its X_s over its F_s. The law has another shape
/// than the four-parameter model, so that its own X_s is a little larger.
#[test]
fn calibration_of_table_2() {
    let tool = Tool::new();
    let rows = [
        ("300", "89.70,0.0032,2996.4,-0.644"),
        ("500", "149.02,0.0036,3058.9,-0.611"),
        ("700", "208.09,0.0039,3158.3,-0.755"),
        ("900", "266.78,0.0041,3280.7,-0.842"),
        ("1100", "325.38,0.0044,3351.4,-0.931"),
    ];
    let mut arguments = vec!["calibrate", "--area", "361.52", "--json"];
    let files = rows.map(|(preload, joint)| {
        let file = format!("p{preload}.csv");
        write_loop(&tool, joint, &file);
        file
    });
    for ((preload, _), file) in rows.iter().zip(&files) {
        arguments.extend(["--preload", preload, file]);
    }
    let json = tool.json(&arguments);
    for (key, paper, part) in [
        ("mu", 0.3, 0.02),
        ("gcr", 0.00268, 0.15),
        ("K_e", 178e3, 0.1),
    ] {
        let value = number(&json, key);
        println!("{key} {value}, the tables {paper}");
        assert!((value / paper - 1.0).abs() < part, "{key} {value}");
    }
}

#[test]
fn energies_agree_with_the_closed_form() {
    let tool = Tool::new();
    for model in [
        vec!["--iwan", JOINT],
        vec!["--props", "0.3,0.002,2.5", "--preload", "900"],
        vec![
            "--props",
            "0.3,0.002,1.5",
            "--preload",
            "900",
            "--series",
            "1e5",
            "--parallel",
            "2e3",
        ],
        vec![
            "--props",
            "mu=.3,gcr=.002,q=1.5,backbone=segalman,beta=.3",
            "--preload",
            "900",
        ],
    ] {
        let mut arguments = vec![
            "loop",
            "--amplitude",
            "0.0005,0.002,0.01",
            "--points",
            "400",
            "--output",
            "l.csv",
        ];
        arguments.extend(model);
        for row in csv(&tool.ok(&arguments)) {
            let (energy, exact) = (row["energy"], row["energy_closed_form"]);
            assert!(
                (energy / exact - 1.0).abs() < 1e-3,
                "{arguments:?}: {row:?}"
            );
            let damping = exact / (std::f64::consts::TAU * row["amplitude"] * row["peak_force"]);
            assert!((damping - row["damping"]).abs() < 1e-5);
        }
    }
    // Without friction there is nothing to damp, and nothing amiss.
    let text = tool.ok(&[
        "loop",
        "--props",
        "0,0.002,2.5",
        "--preload",
        "900",
        "--amplitude",
        "0.01",
        "--output",
        "l.csv",
    ]);
    let row = &csv(&text)[0];
    assert_eq!((row["peak_force"], row["damping"]), (0.0, 0.0));
    // Verification item 5: D/(mu p gcr) at a = .5 and chi = 2.5.
    let text = tool.ok(&[
        "loop",
        "--props",
        "1,1,2.5",
        "--preload",
        "1",
        "--amplitude",
        "0.5",
        "--output",
        "l.csv",
        "--picture",
        "l.svg",
        "--energy-picture",
        "e.svg",
    ]);
    assert!((csv(&text)[0]["energy"] - 0.269870).abs() < 1e-6, "{text}");
    roxmltree::Document::parse(&tool.read("l.svg")).expect("the picture is XML");
    // One amplitude is enough for curves: energy and damping of the closed form, from near zero to the amplitude.
    let text = tool.read("e.svg");
    let picture = roxmltree::Document::parse(&text).expect("the picture is XML");
    let curves: Vec<Vec<f64>> = picture
        .descendants()
        .filter_map(|node| node.attribute("points"))
        .map(|points| {
            let heights = points
                .split_whitespace()
                .filter_map(|p| p.split(',').nth(1));
            heights.map(|y| y.parse().expect("a number")).collect()
        })
        .filter(|curve: &Vec<f64>| curve.len() >= 100)
        .collect();
    assert_eq!(curves.len(), 2);
    for heights in curves {
        // Upwards, over most of the panel: some 4000 of the drawing's units.
        assert!(heights.windows(2).all(|pair| pair[1] <= pair[0]));
        assert!(heights[0] - heights[heights.len() - 1] > 3000.0);
    }
}

#[test]
fn completions_and_manual() {
    let tool = Tool::new();
    for shell in ["bash", "zsh", "fish"] {
        assert!(tool.ok(&["completions", shell]).contains("identify"));
    }
    tool.ok(&["man", "."]);
    for page in ["mepc.1", "mepc-identify.1", "mepc-replay-patch.1"] {
        assert!(tool.read(page).contains(".TH"), "{page}");
    }
    // Every example of the help is a command line that parses; those with files are run elsewhere.
    for command in ["identify", "calibrate", "loop", "deck", "replay"] {
        assert!(tool.ok(&[command, "--help"]).contains("Examples:"));
    }
}

/// The C driver with the shared library, kind of replay and properties; None if they are not built.
fn c_driver(kind: &str, props: &str) -> Option<std::process::Command> {
    let driver = root().join("build/mepc_replay");
    let library = std::env::var_os("MEPC_LIBRARY").map_or_else(
        || root().join("target/release/libmepc.so"),
        std::path::PathBuf::from,
    );
    let mut command = std::process::Command::new(&driver);
    command.arg(kind).arg(&library).arg(props);
    (driver.exists() && library.exists()).then_some(command)
}

/// The shipped cases: the same numbers as the C driver's, which goes through the shared library.
#[test]
fn replay_is_the_c_drivers() {
    let cases = root().join("cases");
    let tool = Tool::new();
    let mut compared = 0;
    let runs: [(&[&str], &[&str]); 8] = [
        (
            &["point", "nested_reversals.csv"],
            &["--props", "0.3,0.002,2.5"],
        ),
        (
            &["point", "circle_gross.csv"],
            &["--props", "0.3,0.002,1.5"],
        ),
        (
            &["point", "figure_eight.csv"],
            &["--props", "0.3,0.002,2.5,1"],
        ),
        (&["point", "opening.csv"], &["--props", "0.3,0.002,2.5,2"]),
        (
            &["point", "rising_pressure.csv"],
            &["--props", "0.3,0.002", "--nstate", "20"],
        ),
        (
            &["patch", "sphere_patch.csv", "sphere_history.csv"],
            &["--props", "0.2,0.002408451,1.5"],
        ),
        (
            &["patch", "lap_patch_902.csv", "lap_history.csv"],
            &[
                "--props",
                "0.42,0.00268,2.5",
                "--series",
                "178e3",
                "--parallel",
                "3.3e3",
            ],
        ),
        (
            &["patch", "disc_patch.csv", "torsion_history.csv"],
            &["--props", "0.3,0.002,2.5", "--series", "5e4"],
        ),
    ];
    for (files, options) in runs {
        let mut arguments = vec!["replay".to_string(), files[0].to_string()];
        arguments.extend(
            files[1..]
                .iter()
                .map(|file| cases.join(file).display().to_string()),
        );
        arguments.extend(options.iter().map(ToString::to_string));
        let ours = tool.ok(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let header = ours.lines().next().expect("a header");
        assert!(header.starts_with("time,"));
        let Some(mut driver) = c_driver(files[0], options[1]) else {
            continue;
        };
        // The C driver takes the properties before the files.
        let rest = [
            &arguments[2..1 + files.len()],
            &arguments[3 + files.len()..],
        ]
        .concat();
        let theirs = driver.args(rest).output();
        let theirs = theirs.expect("the C driver starts");
        assert!(
            theirs.status.success(),
            "{}",
            String::from_utf8_lossy(&theirs.stderr)
        );
        let theirs = String::from_utf8(theirs.stdout).expect("text");
        assert_eq!(header, theirs.lines().next().expect("a header"));
        let (ours, theirs) = (csv(&ours), csv(&theirs));
        assert_eq!(ours.len(), theirs.len());
        for name in header.split(',') {
            let largest = theirs.iter().map(|row| row[name].abs()).fold(0.0, f64::max);
            for (a, b) in ours.iter().zip(&theirs) {
                let (a, b) = (a[name], b[name]);
                // The number of Newton corrections hangs on the last bit of a residual.
                let allowed = if name == "iterations" {
                    1.0
                } else {
                    1e-12 * largest
                };
                assert!((a - b).abs() <= allowed, "{arguments:?} {name}: {a} {b}");
            }
        }
        compared += 1;
    }
    if compared == 0 {
        eprintln!("the C driver is not built (make drivers): nothing compared");
    }
}
