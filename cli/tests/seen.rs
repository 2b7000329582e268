//! What people see: pictures of every command, examples of the help, words where there is nothing to show.

mod tool;

use std::fmt::Write as _;
use tool::{Tool, root};

const JOINT: &str = "266.78,0.0041,3280.7,-0.842";

fn write_loop(tool: &Tool, file: &str, more: &[&str]) {
    let loops = [
        "loop",
        "--iwan",
        JOINT,
        "--amplitude",
        "0.02",
        "--output",
        file,
    ];
    tool.ok(&[&loops[..], more].concat());
}

/// Texts of a picture that can be parsed.
fn texts(tool: &Tool, file: &str) -> Vec<String> {
    let text = tool.read(file);
    let picture = roxmltree::Document::parse(&text).expect("XML");
    let nodes = picture
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    nodes
        .filter_map(|node| node.text())
        .map(|text| text.trim().to_string())
        .collect()
}

/// Every axis of every picture has its unit.
#[test]
fn every_command_draws_with_units() {
    let tool = Tool::new();
    write_loop(
        &tool,
        "l.csv",
        &[
            "--noise",
            "0.01",
            "--picture",
            "loop.svg",
            "--energy-picture",
            "energy.svg",
        ],
    );
    tool.run(&["identify", "l.csv", "--picture", "identify.svg"]);
    tool.run(&[
        "calibrate",
        "l.csv",
        "--preload",
        "900",
        "--area",
        "361.52",
        "--picture",
        "calibrate.svg",
    ]);
    let case = |name: &str| root().join("cases").join(name).display().to_string();
    let props = [
        "--props",
        "mu=.3,gcr=.002,reference_pressure=100",
        "--output",
        "out.csv",
    ];
    let point = [
        "replay",
        "point",
        &case("circle.csv"),
        "--picture",
        "point.svg",
    ];
    tool.ok(&[&point[..], &props].concat());
    let patch = [
        "replay",
        "patch",
        &case("lap_patch_902.csv"),
        &case("lap_history.csv"),
    ];
    tool.ok(&[
        &patch[..],
        &["--series", "178e3", "--picture", "patch.svg"],
        &props,
    ]
    .concat());
    for (file, labels) in [
        ("loop.svg", &["displacement (mm)", "force (N)"][..]),
        (
            "energy.svg",
            &["amplitude (mm)", "energy (N.mm)", "D / (2 pi A T_max)  (-)"],
        ),
        ("identify.svg", &["displacement (mm)", "force (N)"]),
        (
            "calibrate.svg",
            &[
                "displacement (mm)",
                "force (N)",
                "F_s (N)",
                "X_s (mm)",
                "gcr + F_s / K_e",
            ],
        ),
        (
            "point.svg",
            &[
                "slip (mm)",
                "traction (MPa)",
                "energy (N/mm)",
                "direction 2",
            ],
        ),
        (
            "patch.svg",
            &["displacement (mm)", "force (N)", "energy (N.mm)"],
        ),
    ] {
        let texts = texts(&tool, file);
        for label in labels {
            assert!(
                texts.iter().any(|text| text.starts_with(label)),
                "{file}: {label} in {texts:?}"
            );
        }
    }
}

/// Pictures stay small, and show all the data: the columns of the area reach as far as the noise does.
#[test]
fn pictures_of_many_points_are_small() {
    let tool = Tool::new();
    write_loop(
        &tool,
        "many.csv",
        &["--noise", "0.01", "--cycles", "200", "--points", "250"],
    );
    let run = tool.run(&["identify", "many.csv", "--picture", "many.svg"]);
    assert!(run.output.contains("F_s"), "{}", run.errors);
    let text = tool.read("many.svg");
    assert!(text.len() < 1_000_000, "{}", text.len());
    let bars = text.matches("stroke-width=\"20\"").count();
    assert!(bars > 500, "{bars}");
    // A smooth curve of many points stays a line.
    write_loop(
        &tool,
        "smooth.csv",
        &["--points", "100000", "--picture", "smooth.svg"],
    );
    let size = tool.read("smooth.svg").len();
    assert!(size < 30_000, "{size}");
}

#[test]
fn other_formats_and_numbers_out_of_range() {
    let tool = Tool::new();
    write_loop(&tool, "l.csv", &[]);
    for (arguments, file) in [
        (vec!["identify", "l.csv", "--picture", "l.png"], "l.png"),
        (
            vec![
                "loop",
                "--iwan",
                JOINT,
                "--amplitude",
                "1",
                "--energy-picture",
                "e.pdf",
            ],
            "e.pdf",
        ),
        (
            vec![
                "calibrate",
                "l.csv",
                "--preload",
                "1",
                "--area",
                "1",
                "--picture",
                "c.PNG",
            ],
            "c.PNG",
        ),
    ] {
        let run = tool.run(&arguments);
        assert_eq!(run.code, 1, "{arguments:?}");
        assert!(
            run.errors
                .contains(&format!("{file}: pictures are written as SVG only")),
            "{}",
            run.errors
        );
        assert!(!tool.path(file).exists() && run.output.is_empty());
    }
    // The smallest number and a large one: a picture or words, no panic.
    for (amplitude, code) in [("5e-324", 0), ("1e-300", 0), ("1e100", 0), ("1e299", 1)] {
        let loops = [
            "loop",
            "--iwan",
            JOINT,
            "--amplitude",
            amplitude,
            "--output",
            "x.csv",
        ];
        let run = tool.run(
            &[
                &loops[..],
                &["--picture", "x.svg", "--energy-picture", "y.svg"],
            ]
            .concat(),
        );
        assert_eq!(run.code, code, "{amplitude}: {}", run.errors);
        assert!(!run.errors.contains("panicked"), "{}", run.errors);
    }
}

/// Pressures of the other sign are no contact at all: words, no zeros.
#[test]
fn pressures_of_the_other_sign_are_told() {
    let tool = Tool::new();
    let mut history = String::from("time,slip_1,pressure\n");
    for k in 0..5 {
        let _ = writeln!(history, "{k},{},-10", f64::from(k) * 1e-3);
    }
    tool.write("h.csv", &history);
    let props = ["--props", "mu=.3,gcr=.002"];
    let run = tool.run(&[&["replay", "point", "h.csv"], &props[..]].concat());
    assert_eq!((run.code, run.output.as_str()), (1, ""));
    let words = "h.csv: column pressure: -10 to -10: the contact is never closed, for compression is positive";
    assert!(run.errors.contains(words), "{}", run.errors);
    tool.write("p.csv", "x,y,area,pressure\n0,0,1,-5\n1,0,1,0\n");
    tool.write("m.csv", "time,displacement_1\n0,0.001\n");
    let run = tool.run(&[&["replay", "patch", "p.csv", "m.csv"], &props[..]].concat());
    assert!(
        run.errors.contains("p.csv: column pressure: -5 to 0"),
        "{}",
        run.errors
    );
    // An opening is something else.
    tool.write("o.csv", "time,slip_1,pressure\n0,0,10\n1,0.001,-1\n");
    tool.ok(&[&["replay", "point", "o.csv"], &props[..]].concat());
}

/// The examples of `mepc --help` run one after the other as they stand.
#[test]
fn the_examples_of_the_help_work() {
    let tool = Tool::new();
    let help = tool.ok(&["--help"]);
    let examples: Vec<&str> = help
        .lines()
        .filter_map(|line| line.strip_prefix("  mepc "))
        .collect();
    assert_eq!(examples.len(), 4, "{help}");
    for example in examples {
        let arguments: Vec<&str> = example.split_whitespace().collect();
        let output = tool.ok(&arguments);
        assert!(!output.is_empty(), "{example}");
    }
    assert!(
        texts(&tool, "loop.svg")
            .iter()
            .any(|text| text == "least squares")
    );
}

/// The keys of the JSON are those that docs/files.md lists, all of them and no others.
#[test]
fn json_keys_are_those_of_the_docs() {
    let tool = Tool::new();
    write_loop(&tool, "l.csv", &["--noise", "0.01"]);
    let docs = std::fs::read_to_string(root().join("docs/files.md")).expect("docs/files.md");
    for (command, more) in [
        ("identify", &[][..]),
        ("calibrate", &["--preload", "900", "--area", "361.52"]),
    ] {
        let (_, section) = docs
            .split_once(&format!("\n`{command}`:\n"))
            .expect(command);
        // The first column of the table, up to the empty line below it.
        let (table, _) = section
            .trim_start()
            .split_once("\n\n")
            .expect("the end of the table");
        let rows = table
            .lines()
            .skip(2)
            .filter_map(|row| row.split('|').nth(1));
        let mut listed: Vec<&str> = rows
            .flat_map(|cell| cell.split('`').skip(1).step_by(2))
            .collect();
        let run = tool.run(&[&[command, "l.csv", "--json"], more].concat());
        let json: serde_json::Value = serde_json::from_str(&run.output).expect("JSON");
        let mut found: Vec<&str> = json
            .as_object()
            .expect("an object")
            .keys()
            .map(String::as_str)
            .collect();
        listed.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, listed, "{command}");
        assert_eq!(
            json["units"],
            serde_json::json!({ "length": "mm", "force": "N" })
        );
    }
}
