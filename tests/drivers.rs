//! The C and the Fortran driver as programs: the vectors, patches, and files that are wrong.

mod support;

use mepc_oracle::Backbone;
use mepc_oracle::spring::SpringPatch;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::native::library_path;
use support::vectors::{DIRECTORY, all};
use support::{Point, power};

/// The two programs: through the C interface with dlopen, and through FRIC, linked.
const DRIVERS: [&str; 2] = ["mepc_replay", "fric_replay"];

/// Runs a driver with the library under test.
fn run(driver: &str, arguments: &[&str]) -> Output {
    let program = Path::new("build").join(driver);
    assert!(
        program.exists(),
        "{} is not there: run `make drivers` first",
        program.display()
    );
    let library = library_path();
    let directory = library.parent().expect("a directory");
    let mut command = Command::new(program);
    // The Fortran driver is linked: this path goes before the one that it was linked with.
    command
        .args(arguments)
        .env("MEPC_LIBRARY", &library)
        .env("LD_LIBRARY_PATH", directory);
    command.output().expect("the driver starts")
}

/// Runs a driver that must succeed; notes (a reversal was dropped, a column is not used) are all that it may say.
fn table(driver: &str, arguments: &[&str]) -> Table {
    let output = run(driver, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    let is_note = |line: &str| line.starts_with(&format!("{driver}: note: "));
    assert!(
        output.status.success() && said.lines().all(is_note),
        "{driver} {arguments:?}: {said}"
    );
    Table::parse(&String::from_utf8(output.stdout).expect("text"))
}

/// What a driver printed.
#[derive(Debug)]
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn parse(text: &str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let fields = |line: &str| {
            line.split(',')
                .map(|field| field.trim().to_string())
                .collect::<Vec<_>>()
        };
        let header = fields(lines.next().expect("a header"));
        let number = |word: String| word.parse().unwrap_or_else(|_| panic!("{word}"));
        let rows = lines
            .map(|line| fields(line).into_iter().map(number).collect())
            .collect();
        Table { header, rows }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let index = self.header.iter().position(|column| column == name);
        let index = index.unwrap_or_else(|| panic!("no column {name} in {:?}", self.header));
        self.rows.iter().map(|row| row[index]).collect()
    }

    /// Columns that come in one or two directions.
    fn vector(&self, stem: &str, ndir: usize) -> Vec<Vec<f64>> {
        let columns: Vec<_> = (1..=ndir)
            .map(|i| self.column(&format!("{stem}_{i}")))
            .collect();
        (0..self.rows.len())
            .map(|row| columns.iter().map(|column| column[row]).collect())
            .collect()
    }
}

/// A file of this test in the build directory.
fn file(name: &str, text: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a writable directory");
    path.display().to_string()
}

fn list(numbers: &[f64]) -> String {
    numbers
        .iter()
        .map(f64::to_string)
        .collect::<Vec<_>>()
        .join(",")
}

#[test]
fn vectors_through_both_drivers() {
    let mut worst = 0.0f64;
    for vector in all() {
        let path = format!("{DIRECTORY}/{}.csv", vector.name());
        let (props, nstate) = (list(&vector.props), vector.nstate.to_string());
        let arguments = ["point", &path, "--props", &props, "--nstate", &nstate];
        let tables = DRIVERS.map(|driver| table(driver, &arguments));
        for (driver, table) in DRIVERS.iter().zip(&tables) {
            assert_eq!(table.rows.len(), vector.rows.len(), "{driver} {path}");
            let tractions = table.vector("traction", vector.ndir);
            let [stored, dissipated, status] =
                ["stored_energy", "dissipated_energy", "status"].map(|c| table.column(c));
            for index in 0..table.rows.len() {
                vector.check(
                    index,
                    &tractions[index],
                    stored[index],
                    dissipated[index],
                    status[index] as i32,
                );
            }
        }
        let [c, fortran] = &tables;
        assert_eq!(c.header, fortran.header);
        // Inputs are echoed; tractions count in mu p, energies in mu p gcr.
        for name in &c.header {
            let scale = match name.as_str() {
                name if name.starts_with("traction") => vector.limit(),
                "stored_energy" | "dissipated_energy" => vector.energy(),
                _ => 0.0,
            };
            for (a, b) in c.column(name).into_iter().zip(fortran.column(name)) {
                // Accumulated energies grow with the path: count them relative to themselves there.
                let difference = (a - b).abs();
                let allowed = 1e-12 * scale.max(if scale > 0.0 { a.abs() } else { 0.0 });
                assert!(
                    difference <= allowed,
                    "{path}: {name}: C {a:e}, Fortran {b:e}"
                );
                worst = worst.max(if scale > 0.0 { difference / scale } else { 0.0 });
            }
        }
    }
    println!("largest difference between the drivers: {worst:.1e}");
}

const NESTED: [f64; 10] = [0.3, 0.9, 0.2, 0.6, -0.4, -2.0, 3.0, 2.6, 2.9, -3.0];

/// A patch of ten points of any area and pressure, its total area times pressure, and a history of displacements.
fn patch_files(name: &str, unit: f64) -> (String, String, f64) {
    let mut random = fastrand::Rng::with_seed(501);
    let (mut patch, mut total) = ("x,y,area,pressure\n".to_string(), 0.0);
    for k in 0..10 {
        let (area, pressure) = (1.0 + random.f64(), 50.0 * random.f64());
        writeln!(patch, "{k},{},{area:e},{pressure:e}", k % 3).expect("a string");
        total += area * pressure;
    }
    let mut history = "time,displacement_1\n".to_string();
    for (k, part) in NESTED.into_iter().enumerate() {
        writeln!(history, "{k},{:e}", part * unit).expect("a string");
    }
    let patch = file(&format!("{name}_patch.csv"), &patch);
    (patch, file(&format!("{name}_history.csv"), &history), total)
}

#[test]
fn patch_behind_a_series_spring() {
    let (mu, gcr, chi) = (0.37, 0.00268, 2.5);
    let (series, parallel) = (178e3, 3300.0);
    for springs in [
        (None, None),
        (Some(series), None),
        (Some(series), Some(parallel)),
    ] {
        let (patch, history, total) = patch_files("series", 2.0 * gcr);
        let limit = mu * total;
        let props = list(&power(mu, gcr, chi));
        let mut arguments = vec!["patch", &patch, &history, "--props", &props];
        let values = [springs.0, springs.1].map(|k: Option<f64>| k.map(|k| k.to_string()));
        for (option, value) in ["--series", "--parallel"].into_iter().zip(&values) {
            arguments.extend(value.iter().flat_map(|value| [option, value]));
        }
        let tables = DRIVERS.map(|driver| table(driver, &arguments));
        for (driver, table) in DRIVERS.iter().zip(&tables) {
            let mut exact = SpringPatch::new(Backbone::Power { chi }, limit, gcr, springs.0);
            let [slip, force, stored, dissipated, iterations] = [
                "slip_1",
                "force_1",
                "stored_energy",
                "dissipated_energy",
                "iterations",
            ]
            .map(|c| table.column(c));
            for (row, part) in NESTED.into_iter().enumerate() {
                let displacement = 2.0 * gcr * part;
                exact.move_to(displacement);
                let force = force[row] - springs.1.unwrap_or(0.0) * displacement;
                let near = |what: &str, value: f64, expected: f64, scale: f64| {
                    let error = (value - expected).abs() / scale;
                    assert!(
                        error < 1e-9,
                        "{driver} {springs:?} row {row}: {what} {value:e}, expected {expected:e}"
                    );
                };
                near("slip", slip[row], exact.slip(), gcr);
                near("force", force, exact.force(), limit);
                near("stored", stored[row], exact.stored(), limit * gcr);
                near(
                    "dissipated",
                    dissipated[row],
                    exact.dissipated(),
                    limit * gcr,
                );
                assert!(iterations[row] <= 20.0);
            }
        }
        same_numbers(
            &tables,
            &[
                ("slip_1", gcr),
                ("force_1", limit),
                ("dissipated_energy", limit * gcr),
            ],
        );
    }
}

fn same_numbers([c, fortran]: &[Table; 2], scales: &[(&str, f64)]) {
    for (name, scale) in scales {
        for (a, b) in c.column(name).into_iter().zip(fortran.column(name)) {
            assert!(
                (a - b).abs() <= 1e-12 * scale.max(a.abs()),
                "{name}: C {a:e}, Fortran {b:e}"
            );
        }
    }
}

/// Two directions, rotation and a pressure that opens: the sums over points, each stepped by the Rust law.
#[test]
fn patch_with_rotation_and_opening() {
    let props = power(0.4, 0.003, 2.5);
    let points = [
        (2.0, 0.5, 1.5, 20.0),
        (-1.0, 2.0, 0.7, 35.0),
        (0.3, -1.7, 1.1, 8.0),
    ];
    let steps = [
        (0.002, 0.001, 0.0, 1.0),
        (0.004, -0.001, 8e-4, 1.2),
        (0.004, -0.001, -5e-4, 0.9),
        (0.001, 0.0, 2e-3, 0.0),
        (0.002, 0.003, 1e-3, 0.8),
        (-0.006, 0.005, 0.0, 0.8),
    ];
    let mut patch = "x,y,area,pressure\n".to_string();
    for (x, y, area, pressure) in points {
        writeln!(patch, "{x},{y},{area},{pressure}").expect("a string");
    }
    let mut history =
        "# columns in any order\npressure_scale,rotation,time,displacement_2,displacement_1\n"
            .to_string();
    for (k, (u, v, rotation, scale)) in steps.into_iter().enumerate() {
        writeln!(history, "{scale},{rotation},{k},{v},{u}").expect("a string");
    }
    let (patch, history, text) = (
        file("rotation_patch.csv", &patch),
        file("rotation_history.csv", &history),
        list(&props),
    );
    let tables =
        DRIVERS.map(|driver| table(driver, &["patch", &patch, &history, "--props", &text]));
    let mut mine = points.map(|_| Point::<2>::new(&props));
    let mut dissipated = 0.0;
    for (row, (u, v, rotation, scale)) in steps.into_iter().enumerate() {
        let (mut force, mut moment, mut open) = ([0.0; 2], 0.0, 0);
        for (point, (x, y, area, pressure)) in mine.iter_mut().zip(points) {
            let response = point.move_to([u - rotation * y, v + rotation * x], scale * pressure);
            let t = response.traction;
            force = [force[0] + area * t[0], force[1] + area * t[1]];
            moment += area * (x * t[1] - y * t[0]);
            dissipated += area * response.dissipated;
            open += i32::from(point.state[0] == 0.0);
        }
        for (driver, table) in DRIVERS.iter().zip(&tables) {
            let expected = [
                ("force_1", force[0]),
                ("force_2", force[1]),
                ("moment", moment),
                ("dissipated_energy", dissipated),
                ("open", f64::from(open)),
                ("rotation", rotation),
            ];
            for (name, expected) in expected {
                let value = table.column(name)[row];
                assert!(
                    (value - expected).abs() < 1e-11,
                    "{driver} row {row}: {name} {value:e}, expected {expected:e}"
                );
            }
        }
    }
    same_numbers(
        &tables,
        &[("force_1", 10.0), ("moment", 10.0), ("stored_energy", 0.01)],
    );
}

/// Method 2: the Fortran driver plays the Lagrange host, the C driver has the penalty with gcr / 1000.
#[test]
fn lagrange_method_agrees_in_peak_and_area() {
    let (mu, gcr, p) = (0.3, 0.002, 25.0);
    let mut history = "time,slip_1,pressure\n".to_string();
    let (mut from, mut time) = (0.0, 0);
    for to in [3.0 * gcr, -3.0 * gcr, 3.0 * gcr] {
        for k in 1..=20 {
            writeln!(
                history,
                "{time},{},{p}",
                from + (to - from) * f64::from(k) / 20.0
            )
            .expect("a string");
            time += 1;
        }
        from = to;
    }
    let (history, props) = (file("lagrange.csv", &history), list(&[mu, gcr, 2.5, 2.0]));
    for driver in DRIVERS {
        let table = table(driver, &["point", &history, "--props", &props]);
        let peak = table.column("traction_1").into_iter().fold(0.0, f64::max);
        assert!(
            (peak / (mu * p) - 1.0).abs() < 2e-3,
            "{driver}: peak {peak}"
        );
        let dissipated = table.column("dissipated_energy");
        let area = dissipated[59] - dissipated[19];
        let exact = 4.0 * mu * p * 3.0 * gcr;
        assert!(
            (area / exact - 1.0).abs() < 2e-3,
            "{driver}: area {area}, expected {exact}"
        );
    }
}

#[test]
fn characteristic_length_in_the_fortran_driver() {
    let history = file(
        "length.csv",
        "time,slip_1,pressure\n0,0,10\n1,1e-3,10\n2,-2e-4,10\n",
    );
    let by_length = table(
        "fric_replay",
        &[
            "point",
            &history,
            "--props",
            "0.3,0,2.5,0,0,0.004",
            "--char-length",
            "0.67",
        ],
    );
    let by_slip = table(
        "fric_replay",
        &["point", &history, "--props", "0.3,0.00268,2.5"],
    );
    for (a, b) in by_length
        .column("traction_1")
        .into_iter()
        .zip(by_slip.column("traction_1"))
    {
        assert!((a - b).abs() < 1e-12 * 3.0);
    }
}

/// What a driver says to a wrong file or command line, without its own name: both say the same.
fn complaint(arguments: &[&str], code: i32) -> String {
    let said = DRIVERS.map(|driver| {
        let output = run(driver, arguments);
        let text = String::from_utf8(output.stderr).expect("text");
        assert_eq!(
            output.status.code(),
            Some(code),
            "{driver} {arguments:?}: {text}"
        );
        assert!(output.stdout.is_empty(), "{driver}: no half tables");
        assert!(text.starts_with(&format!("{driver}: ")), "{text}");
        let text = text.replace(&format!("{driver}: "), "");
        text.trim_end().to_string()
    });
    assert_eq!(said[0], said[1]);
    said[0].clone()
}

#[test]
fn wrong_point_histories_are_refused_with_file_line_and_column() {
    let header = "time,slip_1,pressure\n";
    let cases = [
        (
            "missing_column",
            "time,slip_1,\n0,0,1\n".to_string(),
            ":1: column pressure: missing in the header, which has time, slip_1, 3 (no name)",
        ),
        (
            "quoted",
            "\"time\",\"slip_1\",\"pressure\"\n0,0,10\n".to_string(),
            ":1: column time: missing in the header, which has \"time\", \"slip_1\", \"pressure\"",
        ),
        // The commas of the row are decimal ones.
        (
            "semicolons",
            "time;slip_1;pressure\n0;0,5;10\n".to_string(),
            ":1: the fields must be separated by commas, not by semicolons",
        ),
        (
            "tabs",
            "# a\ntime\tslip_1\tpressure\n0\t0\t10\n".to_string(),
            ":2: the fields must be separated by commas, not by tabs",
        ),
        (
            "text",
            format!("{header}0,0,10\n1,abc,10\n"),
            ":3: column slip_1: 'abc' is not a number",
        ),
        (
            "half_number",
            format!("{header}0,0,10\n1,1.0x,10\n"),
            ":3: column slip_1: '1.0x' is not a number",
        ),
        (
            "hexadecimal",
            format!("{header}0,0x10,10\n"),
            ":2: column slip_1: '0x10' is not a number",
        ),
        (
            "not_a_number",
            format!("# a\n{header}\n0,0,10\n1,nan,10\n"),
            ":5: column slip_1: 'nan' is not finite",
        ),
        (
            "infinite",
            format!("{header}0,0,10\n1,0,-Inf\n"),
            ":3: column pressure: '-Inf' is not finite",
        ),
        (
            "too_large",
            format!("{header}0,0,10\n1,1e999,10\n"),
            ":3: column slip_1: '1e999' is too large",
        ),
        (
            "empty_field",
            format!("{header}0,0,10\n1,,10\n"),
            ":3: column slip_1: '' is empty",
        ),
        (
            "few_fields",
            format!("{header}0,0,10\n1,0\n"),
            ":3: column pressure: missing",
        ),
        (
            "many_fields",
            format!("{header}0,0,10\n1,0,10,3\n"),
            ":3: column 4: has no name",
        ),
        (
            "control_characters",
            format!("{header}0,1\u{1b}[3m2,10\n"),
            ":2: column slip_1: '1\\x1B[3m2' is not a number",
        ),
        (
            "binary",
            format!("{header}0,1\02,10\n"),
            ": is not a text file",
        ),
        (
            "column_twice",
            "time,slip_1,pressure,pressure\n0,0,1,2\n".to_string(),
            ":1: column pressure: appears twice",
        ),
        (
            "backwards",
            format!("{header}1e3,0,10\n0.50,0,10\n"),
            ":3: column time: 0.50 comes after 1e3, time must not decrease",
        ),
        ("empty", String::new(), ":1: is empty"),
        ("comments_only", "# nothing\n\n".to_string(), ": is empty"),
        ("no_rows", header.to_string(), ":1: has a header but no row"),
    ];
    for (name, text, words) in cases {
        let path = file(&format!("wrong_{name}.csv"), &text);
        let said = complaint(&["point", &path, "--props", "0.3,0.002"], 1);
        assert!(
            said.starts_with(&path) && said.contains(words),
            "{name}: {said}"
        );
    }
    let absent = format!("{}/absent.csv", env!("CARGO_TARGET_TMPDIR"));
    assert!(complaint(&["point", &absent, "--props", "0.3,0.002"], 1).contains("absent.csv: "));
    let directory = complaint(&["point", "tests", "--props", "0.3,0.002"], 1);
    assert_eq!(directory, "tests: Is a directory");
}

#[test]
fn wrong_patches_are_refused_with_file_line_and_column() {
    let good_patch = file("good_patch.csv", "x,y,area,pressure\n0,0,1,10\n1,0,1,10\n");
    let good_history = file("good_history.csv", "time,displacement_1\n0,0\n1,0.001\n");
    for (name, text, words) in [
        (
            "no_area",
            "x,y,pressure\n0,0,10\n",
            ":1: column area: missing",
        ),
        (
            "text",
            "x,y,area,pressure\n0,0,1,10\n0,?,1,10\n",
            ":3: column y: '?' is not a number",
        ),
        (
            "negative_area",
            "x,y,area,pressure\n0,0,-1.50,10\n",
            ":2: column area: -1.50 is negative",
        ),
        (
            "no_points",
            "x,y,area,pressure\n",
            ":1: has a header but no row",
        ),
    ] {
        let path = file(&format!("wrong_patch_{name}.csv"), text);
        let said = complaint(&["patch", &path, &good_history, "--props", "0.3,0.002"], 1);
        assert!(
            said.starts_with(&path) && said.contains(words),
            "{name}: {said}"
        );
    }
    for (name, text, words) in [
        (
            "no_displacement",
            "time,slip_1\n0,0\n",
            ":1: column displacement_1: missing",
        ),
        (
            "infinite",
            "time,displacement_1\n0,0\n1,inf\n",
            ":3: column displacement_1: 'inf' is not finite",
        ),
        (
            "rotation",
            "time,displacement_1,rotation\n0,0,0\n",
            ":1: column ",
        ),
    ] {
        let path = file(&format!("wrong_patch_history_{name}.csv"), text);
        let said = complaint(&["patch", &good_patch, &path, "--props", "0.3,0.002"], 1);
        assert!(
            said.starts_with(&path) && said.contains(words),
            "{name}: {said}"
        );
    }
}

#[test]
fn wrong_command_lines_and_properties() {
    let history = file("good.csv", "time,slip_1,pressure\n0,0,10\n1,0.001,10\n");
    for arguments in [
        &[][..],
        &["point"],
        &["line", &history, "--props", "0.3,0.002"],
        &["point", &history],
        &["point", &history, "--props"],
        &["point", &history, "--props", "0.3,x"],
        &[
            "point",
            &history,
            "--props",
            "0.3,0.002",
            "--nstate",
            "many",
        ],
        &["point", &history, "--props", "0.3,0.002", "--series", "-1"],
        &["point", &history, "--props", "0.3,0.002", "--colour", "red"],
        &["point", &history, "--props", "0.3,0.002", "--nstate", "+25"],
        // The last one does not win in silence.
        &[
            "point",
            &history,
            "--props",
            "0.3,0.002",
            "--props",
            "0.3,0.002",
        ],
        &[
            "point",
            &history,
            "--props",
            "0.3,0.002",
            "--nstate",
            "25",
            "--nstate",
            "30",
        ],
    ] {
        for driver in DRIVERS {
            let output = run(driver, arguments);
            assert_eq!(output.status.code(), Some(2), "{driver} {arguments:?}");
            assert!(!output.stderr.is_empty() && output.stdout.is_empty());
        }
    }
    // What the law refuses is told in its words, and put down to the option, not to a line of the history.
    for (props, nstate, words) in [
        (
            "-0.3,0.002",
            "25",
            "--props: bad property: PROPS(1) mu = -0.3",
        ),
        (
            "0.3,0.002",
            "12",
            "--nstate: bad state: nstate = 12: 1 tangential direction",
        ),
        ("0.3,0", "25", "--props: "),
        ("0.3,0,2.5,2", "25", "--props: "),
    ] {
        for driver in DRIVERS {
            let output = run(
                driver,
                &["point", &history, "--props", props, "--nstate", nstate],
            );
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{driver}: {said}");
            assert!(
                said.starts_with(&format!("{driver}: {words}")),
                "{driver}: {said}"
            );
            assert!(!said.contains(&history), "{driver}: {said}");
        }
    }
    for driver in DRIVERS {
        let help = run(driver, &["--help"]);
        assert!(help.status.success() && help.stderr.is_empty());
        assert!(String::from_utf8_lossy(&help.stdout).contains("--props"));
    }
}

#[test]
fn wrong_options_are_told_in_the_same_words() {
    let history = file("options.csv", "time,slip_1,pressure\n0,0,10\n");
    let patch = file("options_patch.csv", "x,y,area,pressure\n0,0,1,10\n");
    let motion = file("options_motion.csv", "time,displacement_1\n0,0\n");
    let point = ["point", &history, "--props", "0.3,0.002"];
    // The next option is no value, and no name of a file.
    for (rest, words) in [
        (&["--output", "--nstate"][..], "--output"),
        (&["--nstate", "--output", "table.csv"], "--nstate"),
        (&["--output", "--help"], "--output"),
        (&["--output", ""], "--output"),
        (&["--output"], "--output"),
    ] {
        let said = complaint(&[&point[..], rest].concat(), 2);
        assert_eq!(said, format!("{words}: its value is missing\ntry --help"));
    }
    assert!(!Path::new("--nstate").exists());
    let said = complaint(&["point", &history, "--props", "0.3, x"], 2);
    assert!(
        said.starts_with("--props: entry 2: 'x' is not a number"),
        "{said}"
    );
    for option in ["--series", "--parallel"] {
        let arguments = [
            "patch",
            &patch,
            &motion,
            "--props",
            "0.3,0.002",
            option,
            "-1",
        ];
        let said = complaint(&arguments, 2);
        assert!(
            said.starts_with(&format!("{option}: must be positive, not -1")),
            "{said}"
        );
    }
    for driver in DRIVERS {
        let output = run(driver, &[&point[..], &["--output", "tests"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains("tests: cannot be written"), "{said}");
    }
}

/// Numbers that are finite, but not what follows from them: a message with the place, no table, and nobody dies of a trap.
#[test]
fn numbers_too_large_are_told_with_their_place() {
    // What a driver finds itself: its sums and products.
    let none = ":2: step 1: the result is not a finite number";
    let stuck = ":2: step 1: no equilibrium: Newton does not converge";
    for (name, patch, motion, options, words) in [
        ("area", "0,0,1e308,100", "1e-3,0,0,1", &[][..], none),
        // Infinite one way at one point, and the other way at the next.
        (
            "moment",
            "0,1e308,1e10,100\n0,-1e308,1e10,100",
            "1e-3,0,0,1",
            &[],
            none,
        ),
        (
            "parallel",
            "0,0,1,100",
            "1e10,0,0,1",
            &["--parallel", "1e308"],
            none,
        ),
        (
            "series",
            "0,0,1,100",
            "1e308,0,0,1",
            &["--series", "1e308"],
            stuck,
        ),
    ] {
        let patch = file(
            &format!("large_{name}_patch.csv"),
            &format!("x,y,area,pressure\n{patch}\n"),
        );
        let history = file(
            &format!("large_{name}.csv"),
            &format!("time,displacement_1,displacement_2,rotation,pressure_scale\n1,{motion}\n"),
        );
        for method in ["0", "1", "2"] {
            let props = format!("0.3,0.002,2.5,{method}");
            let arguments = [&["patch", &patch, &history, "--props", &props], options].concat();
            let said = complaint(&arguments, 1);
            assert!(
                said.starts_with(&format!("{history}{words}")),
                "{name} {method}: {said}"
            );
        }
    }
    // What the library refuses, in the words of its two faces.
    for (name, patch, history) in [
        ("point_pressure", "", "time,slip_1,pressure\n1,1e-3,1e308\n"),
        (
            "pressure",
            "0,0,1,100",
            "time,displacement_1,pressure_scale\n1,1e-3,1e308\n",
        ),
        (
            "turn",
            "0,0,1,100",
            "time,displacement_1,displacement_2,rotation\n0,0,0,-1e308\n1,0,0,1e308\n",
        ),
        (
            "way",
            "0,0,1,100",
            "time,displacement_1\n0,-1e308\n1,1e308\n",
        ),
    ] {
        let history = file(&format!("large_{name}.csv"), history);
        let patch = file(
            &format!("large_{name}_patch.csv"),
            &format!("x,y,area,pressure\n{patch}\n"),
        );
        let files = match name {
            "point_pressure" => vec!["point", &history],
            _ => vec!["patch", &patch, &history],
        };
        for (driver, method) in DRIVERS.iter().flat_map(|d| [(d, "0"), (d, "1")]) {
            let props = format!("0.3,0.002,2.5,{method}");
            let output = run(driver, &[&files[..], &["--props", &props]].concat());
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{driver} {name}: {said}");
            assert!(output.stdout.is_empty(), "{driver} {name}");
            assert!(
                said.contains(&format!("{driver}: {history}:")) && said.contains(": step "),
                "{driver} {name}: {said}"
            );
        }
    }
    // Large, but accepted.
    let history = file(
        "large_accepted.csv",
        "time,slip_1,slip_2,pressure\n1,-5e-3,-5e-3,30\n2,4e-3,0,1e140\n",
    );
    for driver in DRIVERS {
        let arguments = ["point", &history, "--props", "0.3,0.002,2.5,2,1"];
        assert_eq!(table(driver, &arguments).rows.len(), 2);
    }
}

/// The table goes to the file that is named, and nowhere else.
#[test]
fn output_to_a_file() {
    let history = file("output.csv", "time,slip_1,pressure\n0,0,10\n1,0.001,10\n");
    for driver in DRIVERS {
        let path = file(&format!("output_{driver}.csv"), "");
        let output = run(
            driver,
            &["point", &history, "--props", "0.3,0.002", "--output", &path],
        );
        assert!(output.status.success() && output.stdout.is_empty());
        let written = Table::parse(&std::fs::read_to_string(&path).expect("the table"));
        assert_eq!(
            written.rows,
            table(driver, &["point", &history, "--props", "0.3,0.002"]).rows
        );
        assert_eq!(written.rows.len(), 2);
    }
}

/// An optional column that is mistyped would otherwise be missing in silence.
#[test]
fn columns_that_are_not_used_are_noted() {
    let mistyped = file(
        "mistyped.csv",
        "# rig\ntime,slip_1,slip2,pressure,\n0,0,0,10,\n1,0.001,0.001,10,\n",
    );
    let patch = file("noted_patch.csv", "x,y,area,pressure,id\n0,0,1,10,a\n");
    let history = file(
        "noted_history.csv",
        "time,displacement_1,Rotation\n0,0,0\n1,0.001,0\n",
    );
    let exact = file("noted.csv", "time,slip_1,pressure\n0,0,10\n1,0.001,10\n");
    for driver in DRIVERS {
        let props = ["--props", "0.3,0.002"];
        let notes = |files: &[&str]| {
            let output = run(driver, &[files, &props].concat());
            assert!(output.status.success(), "{driver} {files:?}");
            String::from_utf8(output.stderr).expect("text")
        };
        let note = |file: &str, line: usize, columns: &str| {
            format!("{driver}: note: {file}:{line}: columns not used: {columns}\n")
        };
        assert_eq!(notes(&["point", &exact]), "");
        assert_eq!(
            notes(&["point", &mistyped]),
            note(&mistyped, 2, "slip2, 5 (no name)")
        );
        let both = notes(&["patch", &patch, &history]);
        assert!(both.contains(&note(&patch, 1, "id")), "{both}");
        assert!(both.contains(&note(&history, 1, "Rotation")), "{both}");
        // The output of one replay is a history for the next.
        let first = run(driver, &[&["point", &exact], &props[..]].concat()).stdout;
        let again = file(
            &format!("again_{driver}.csv"),
            &String::from_utf8(first).expect("text"),
        );
        assert_eq!(
            notes(&["point", &again]),
            note(
                &again,
                1,
                "traction_1, stored_energy, dissipated_energy, status"
            )
        );
    }
}

#[test]
fn the_output_is_no_input() {
    let text = "time,slip_1,pressure\n0,0,10\n1,0.001,10\n";
    let history = file("kept.csv", text);
    let patch = file("kept_patch.csv", "x,y,area,pressure\n0,0,1,10\n");
    let motion = file("kept_motion.csv", "time,displacement_1\n0,0\n");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let [soft, hard] = ["kept_soft.csv", "kept_hard.csv"].map(|name| directory.join(name));
    for link in [&soft, &hard] {
        let _ = std::fs::remove_file(link);
    }
    std::os::unix::fs::symlink(&history, &soft).expect("a link");
    std::fs::hard_link(&history, &hard).expect("a link");
    let dotted = directory.join("./kept.csv").display().to_string();
    let [soft, hard] = [soft, hard].map(|path| path.display().to_string());
    let point = ["point", &history, "--props", "0.3,0.002", "--output"];
    for name in [&history, &dotted, &soft, &hard] {
        let said = complaint(&[&point[..], &[name]].concat(), 1);
        let words =
            format!("--output: {name} is the input file {history}, which it would overwrite");
        assert_eq!(said, words);
    }
    let arguments = ["patch", &patch, &motion, "--props", "0.3,0.002", "--output"];
    for name in [&patch, &motion] {
        assert!(complaint(&[&arguments[..], &[name]].concat(), 1).contains("would overwrite"));
    }
    assert_eq!(std::fs::read_to_string(&history).expect("kept"), text);
    // Nor the library, which the C driver has open.
    let copy = directory.join("kept_library.so");
    std::fs::copy(library_path(), &copy).expect("a copy");
    let name = copy.display().to_string();
    let output = run(
        "mepc_replay",
        &[&point[..], &[&name, "--library", &name]].concat(),
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let words = format!("--output: {name} is the library {name}, which it would overwrite");
    assert!(said.contains(&words), "{said}");
}

/// A run that fails leaves nothing that looks like a result.
#[test]
fn a_failed_run_leaves_no_table() {
    let late = file(
        "late.csv",
        "time,slip_1,pressure\n0,0,10\n1,0.001,10\n2,1e300,10\n",
    );
    let patch = file("late_patch.csv", "x,y,area,pressure\n0,0,1,10\n");
    let motion = file(
        "late_motion.csv",
        "time,displacement_1\n0,0\n1,0.001\n2,1e300\n",
    );
    for driver in DRIVERS {
        for files in [&["point", &late][..], &["patch", &patch, &motion]] {
            let arguments = [files, &["--props", "0.3,0.002"]].concat();
            let output = run(driver, &arguments);
            assert_eq!(output.status.code(), Some(1), "{driver} {files:?}");
            assert!(output.stdout.is_empty(), "{driver} {files:?}");
            let table = file(&format!("late_{driver}.csv"), "");
            std::fs::remove_file(&table).expect("it was there");
            run(driver, &[&arguments[..], &["--output", &table]].concat());
            assert!(!Path::new(&table).exists(), "{driver} {files:?}");
        }
    }
}

/// A disk that fills up while the table is written: said, and the part that was written is taken back.
#[test]
fn a_full_disk_leaves_no_half_table() {
    let arguments = [
        "point",
        "cases/circle.csv",
        "--props",
        "0.3,0.002",
        "--output",
    ];
    for driver in DRIVERS {
        let output = run(driver, &[&arguments[..], &["/dev/full"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{driver}: {said}");
        assert!(said.contains("/dev/full: cannot be written"), "{said}");
    }
    // A limit on the size of files stands for the disk. Not for the Fortran driver: its runtime library ends the program at
    // the signal of the limit, whatever the parent process says.
    let table = file("full_disk.csv", "");
    let output = Command::new("bash")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 8; exec build/mepc_replay \"$@\"",
            "bash",
        ])
        .args(arguments)
        .arg(&table)
        .env("MEPC_LIBRARY", library_path())
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("full_disk.csv: cannot be written"), "{said}");
    assert_eq!(std::fs::read_to_string(&table).expect("a file"), "");
}
