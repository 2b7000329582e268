//! The C and the Fortran driver as programs: the vectors, patches, and input that is wrong.

mod support;

use mepc_oracle::Backbone;
use mepc_oracle::spring::SpringPatch;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::native::library_path;
use support::vectors::{VectorFile, all};
use support::{Point, power, with};

/// The two programs: through the C interface with dlopen, and through FRIC, linked.
const DRIVERS: [&str; 2] = ["mepc_replay", "fric_replay"];

/// A driver with the library under test and these properties: kind of replay, properties, files and options.
fn command(driver: &str, kind: &str, props: &str, rest: &[&str]) -> Command {
    let program = Path::new("build").join(driver);
    assert!(
        program.exists(),
        "{} is not there: run `make drivers` first",
        program.display()
    );
    let library = library_path();
    let mut command = Command::new(program);
    command.arg(kind);
    if driver == "mepc_replay" {
        command.arg(&library);
    }
    // The Fortran driver is linked: this path goes before the one that it was linked with.
    command
        .env("LD_LIBRARY_PATH", library.parent().expect("a directory"))
        .arg(props)
        .args(rest);
    command
}

fn run(driver: &str, kind: &str, props: &str, rest: &[&str]) -> Output {
    command(driver, kind, props, rest)
        .output()
        .expect("the driver starts")
}

/// Runs a driver that must succeed; a note (a knot that mattered was dropped) is all that it may say.
fn table(driver: &str, kind: &str, props: &str, rest: &[&str]) -> Table {
    let output = run(driver, kind, props, rest);
    let said = String::from_utf8_lossy(&output.stderr);
    let is_note = |line: &str| line.starts_with(&format!("{driver}: note: "));
    assert!(
        output.status.success() && said.lines().all(is_note),
        "{driver} {kind} {props} {rest:?}: {said}"
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

/// The steps of a vector as a history.
fn history(vector: &VectorFile) -> String {
    let numbered = |stem: &str| {
        (1..=vector.ndir)
            .map(|i| format!(",{stem}_{i}"))
            .collect::<String>()
    };
    let mut text = format!("# {}\ntime{},pressure\n", vector.name(), numbered("slip"));
    for (time, row) in vector.rows.iter().enumerate() {
        writeln!(text, "{time},{},{:e}", list(&row.slip), row.pressure).expect("a string");
    }
    file(&format!("{}.csv", vector.name()), &text)
}

#[test]
fn vectors_through_both_drivers() {
    let mut worst = 0.0f64;
    for vector in all() {
        let (path, props, nstate) = (
            history(&vector),
            list(&vector.props),
            vector.nstate.to_string(),
        );
        let rest = [path.as_str(), "--nstate", &nstate];
        let tables = DRIVERS.map(|driver| table(driver, "point", &props, &rest));
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
        // All steps in one call: the same numbers to the last bit, without the status.
        let at_once = table("mepc_replay", "history", &props, &rest);
        assert_eq!(c.header[..c.header.len() - 1], at_once.header);
        for (row, row_at_once) in c.rows.iter().zip(&at_once.rows) {
            assert_eq!(row[..row.len() - 1], row_at_once[..], "{path}");
        }
    }
    println!("largest difference between the drivers: {worst:.1e}");
}

/// Interface form: an interference, closed from the first, is a constant pressure, and jumps are slips.
#[test]
fn interface_form_of_the_c_driver() {
    let (kn, gap) = (1024.0, -0.03125);
    let mut point = "time,slip_1,slip_2,pressure\n".to_string();
    let mut opening = "time,opening,jump_1,jump_2\n".to_string();
    for (time, [u, v]) in [[1e-3, 0.0], [5e-4, 1e-3], [-2e-3, 3e-3], [0.0, 0.0]]
        .into_iter()
        .enumerate()
    {
        writeln!(point, "{time},{u},{v},{}", -kn * gap).expect("a string");
        writeln!(opening, "{time},0,{u},{v}").expect("a string");
    }
    writeln!(point, "4,0,0,0").expect("a string");
    writeln!(opening, "4,1,0,0").expect("a string");
    let props = with(&with(&power(0.3, 0.002, 2.5), 7, kn), 8, gap);
    let props = list(&with(&props, 5, 30.0));
    let expected = table(
        "mepc_replay",
        "point",
        &props,
        &[&file("slips.csv", &point)],
    );
    let found = table(
        "mepc_replay",
        "interface",
        &props,
        &[&file("openings.csv", &opening)],
    );
    assert_eq!(
        found.column("normal_traction"),
        [kn * gap, kn * gap, kn * gap, kn * gap, 0.0]
    );
    for name in ["traction_1", "traction_2", "dissipated_energy", "status"] {
        for (a, b) in found.column(name).into_iter().zip(expected.column(name)) {
            assert!((a - b).abs() < 1e-13, "{name}: {a:e}, friction form {b:e}");
        }
    }
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
        let mut arguments = vec![patch.as_str(), &history];
        let values = [springs.0, springs.1].map(|k: Option<f64>| k.map(|k| k.to_string()));
        for (option, value) in ["--series", "--parallel"].into_iter().zip(&values) {
            arguments.extend(value.iter().flat_map(|value| [option, value]));
        }
        let tables = DRIVERS.map(|driver| table(driver, "patch", &props, &arguments));
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
    let mut history = "time,displacement_1,displacement_2,rotation,pressure_scale\n".to_string();
    for (k, (u, v, rotation, scale)) in steps.into_iter().enumerate() {
        writeln!(history, "{k},{u},{v},{rotation},{scale}").expect("a string");
    }
    let (patch, history, text) = (
        file("rotation_patch.csv", &patch),
        file("rotation_history.csv", &history),
        list(&props),
    );
    let tables = DRIVERS.map(|driver| table(driver, "patch", &text, &[&patch, &history]));
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
        let table = table(driver, "point", &props, &[&history]);
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
    for method in ["0", "2"] {
        let by_length = table(
            "fric_replay",
            "point",
            &format!("0.3,0,2.5,{method},10,0.004"),
            &[&history, "--length", "0.67"],
        );
        let by_slip = table(
            "fric_replay",
            "point",
            &format!("0.3,0.00268,2.5,{method},10"),
            &[&history],
        );
        let pairs = by_length
            .column("traction_1")
            .into_iter()
            .zip(by_slip.column("traction_1"));
        for (a, b) in pairs {
            assert!((a - b).abs() < 1e-12 * 3.0);
        }
    }
}

/// What a driver says to wrong input, without its own name: both say the same.
fn complaint(kind: &str, props: &str, rest: &[&str], code: i32) -> String {
    let said = DRIVERS.map(|driver| {
        let output = run(driver, kind, props, rest);
        let text = String::from_utf8(output.stderr).expect("text");
        assert_eq!(
            output.status.code(),
            Some(code),
            "{driver} {kind} {rest:?}: {text}"
        );
        assert!(output.stdout.is_empty(), "{driver}: no half tables");
        let (name, text) = text.split_once(": ").expect("a name");
        assert_eq!(name, driver);
        text.trim_end().to_string()
    });
    assert_eq!(said[0], said[1]);
    said[0].clone()
}

#[test]
fn wrong_tables_are_refused_with_file_line_and_column() {
    let header = "time,slip_1,pressure\n";
    let must = "must be time,slip_1,pressure or time,slip_1,slip_2,pressure";
    let row = |row: &str| format!("# a\n{header}\n0,0,10\n{row}\n");
    let cases = [
        (
            "missing_column",
            "time,slip_1,\n0,0,1\n".to_string(),
            ":1: the header is 'time,slip_1,', must be",
        ),
        (
            "mistyped",
            "time,slip_1,slip2,pressure\n0,0,0,1\n".to_string(),
            must,
        ),
        (
            "semicolons",
            "time;slip_1;pressure\n0;0,5;10\n".to_string(),
            must,
        ),
        (
            "text",
            row("1,abc,10"),
            ":5: column slip_1: 'abc' is not a finite number",
        ),
        (
            "half_number",
            row("1,1.0x,10"),
            ":5: column slip_1: '1.0x' is not a finite number",
        ),
        (
            "hexadecimal",
            row("1,0x10,10"),
            ":5: column slip_1: '0x10' is not a finite number",
        ),
        (
            "two_numbers",
            row("1,1 2,10"),
            ":5: column slip_1: '1 2' is not a finite number",
        ),
        (
            "no_letter",
            row("1,1-5,10"),
            ":5: column slip_1: '1-5' is not a finite number",
        ),
        (
            "two_exponents",
            row("1,1e5e3,10"),
            ":5: column slip_1: '1e5e3' is not a finite number",
        ),
        (
            "no_exponent",
            row("1,1e,10"),
            ":5: column slip_1: '1e' is not a finite number",
        ),
        (
            "repeated",
            row("1,2*3,10"),
            ":5: column slip_1: '2*3' is not a finite number",
        ),
        (
            "slash",
            row("1,1/,10"),
            ":5: column slip_1: '1/' is not a finite number",
        ),
        (
            "point_only",
            row("1,.,10"),
            ":5: column slip_1: '.' is not a finite number",
        ),
        (
            "not_a_number",
            row("1,nan,10"),
            ":5: column slip_1: 'nan' is not a finite number",
        ),
        (
            "infinite",
            row("1,0,-Inf"),
            ":5: column pressure: '-Inf' is not a finite number",
        ),
        (
            "too_large",
            row("1,1e999,10"),
            ":5: column slip_1: '1e999' is not a finite number",
        ),
        (
            "empty_field",
            row("1,,10"),
            ":5: column slip_1: '' is not a finite number",
        ),
        (
            "few_fields",
            row("1,0"),
            ":5: column slip_1: too few fields",
        ),
        (
            "many_fields",
            row("1,0,10,3"),
            ":5: column pressure: too many fields",
        ),
        (
            "empty",
            String::new(),
            ":0: the file ends without a row of numbers",
        ),
        (
            "comments_only",
            "# nothing\n\n".to_string(),
            ":2: the file ends without a row of numbers",
        ),
        (
            "no_rows",
            header.to_string(),
            ":1: the file ends without a row of numbers",
        ),
    ];
    for (name, text, words) in cases {
        let path = file(&format!("wrong_{name}.csv"), &text);
        let said = complaint("point", "0.3,0.002", &[&path], 1);
        assert!(
            said.starts_with(&path) && said.contains(words),
            "{name}: {said}"
        );
    }
    assert_eq!(
        complaint("point", "0.3,0.002", &["tests"], 1),
        "tests: Is a directory"
    );
    let absent = format!("{}/absent.csv", env!("CARGO_TARGET_TMPDIR"));
    for driver in DRIVERS {
        let output = run(driver, "point", "0.3,0.002", &[&absent]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains("absent.csv: ") && said.contains("No such file"),
            "{said}"
        );
    }
    // Line ends of another system, and none after the last line.
    let text = format!("# a\r\n\r\n{}0,1e-3,10", header.replace('\n', "\r\n"));
    for driver in DRIVERS {
        let found = table(
            driver,
            "point",
            "0.3,0.002",
            &[&file("line_ends.csv", &text)],
        );
        assert_eq!(found.column("slip_1"), [1e-3]);
    }
    let patch = file("good_patch.csv", "x,y,area,pressure\n0,0,1,10\n1,0,1,10\n");
    let motion = file("good_motion.csv", "time,displacement_1\n0,0\n1,0.001\n");
    for (motion, patch, words) in [
        (
            &motion,
            &file("no_area.csv", "x,y,pressure\n0,0,10\n"),
            ":1: the header is 'x,y,pressure', must be x,y,area,pressure",
        ),
        (
            &motion,
            &file("no_y.csv", "x,y,area,pressure\n0,?,1,10\n"),
            ":2: column y: '?' is not a finite number",
        ),
        (
            &file("turn.csv", "time,displacement_1,rotation\n0,0,0\n"),
            &patch,
            ":1: the header is 'time,displacement_1,rotation'",
        ),
        (
            &file("inf.csv", "time,displacement_1\n0,inf\n"),
            &patch,
            ":2: column displacement_1: 'inf' is not a finite number",
        ),
    ] {
        assert!(
            complaint("patch", "0.3,0.002", &[patch, motion], 1).contains(words),
            "{words}"
        );
    }
}

#[test]
fn wrong_command_lines_and_properties() {
    let history = file("good.csv", "time,slip_1,pressure\n0,0,10\n1,0.001,10\n");
    for (kind, props, rest) in [
        ("line", "0.3,0.002", &[history.as_str()][..]),
        ("point", "0.3,0.002", &[]),
        ("patch", "0.3,0.002", &[&history]),
        ("point", "0.3,x", &[&history]),
        ("point", "0.3,,2.5", &[&history]),
        ("point", "", &[&history]),
        ("point", "0.3,0.002", &[&history, "--nstate"]),
        ("point", "0.3,0.002", &[&history, "--nstate", "many"]),
        ("point", "0.3,0.002", &[&history, "--nstate", "1e99"]),
        ("point", "0.3,0.002", &[&history, "--colour", "1"]),
        (
            "patch",
            "0.3,0.002",
            &[&history, &history, "--series", "-1"],
        ),
    ] {
        let said = complaint_start(kind, props, rest);
        assert!(said.starts_with("wrong command line"), "{said}");
    }
    // What the law refuses is told in its words.
    let said = complaint_start_with("point", "-0.3,0.002", &[&history], 1);
    assert!(
        said.iter()
            .all(|said| said.starts_with("PROPS") && said.contains("mu = -0.3")),
        "{said:?}"
    );
    let said = complaint_start_with("point", "0.3,0.002", &[&history, "--nstate", "12"], 1);
    assert!(said.iter().all(|said| said.contains("12")), "{said:?}");
    let said = run("mepc_replay", "point", "0.3,0", &[&history]);
    assert_eq!(said.status.code(), Some(1));
    let said = run("fric_replay", "point", "0.3,0", &[&history]);
    assert_eq!(said.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&said.stderr).contains("characteristic length"));
}

/// The first lines that the drivers say, without their names.
fn complaint_start_with(kind: &str, props: &str, rest: &[&str], code: i32) -> [String; 2] {
    DRIVERS.map(|driver| {
        let output = run(driver, kind, props, rest);
        let text = String::from_utf8(output.stderr).expect("text");
        assert_eq!(
            output.status.code(),
            Some(code),
            "{driver} {kind} {rest:?}: {text}"
        );
        assert!(output.stdout.is_empty(), "{driver}: no half tables");
        text.replace(&format!("{driver}: "), "")
    })
}

fn complaint_start(kind: &str, props: &str, rest: &[&str]) -> String {
    let [c, fortran] = complaint_start_with(kind, props, rest, 2);
    assert!(
        fortran.starts_with("wrong command line") && fortran.contains("usage:"),
        "{fortran}"
    );
    c
}

/// Numbers that are finite, but not what follows from them: a message with the place and no table.
#[test]
fn numbers_too_large_are_told_with_their_place() {
    let none = ":2: the result is not a finite number";
    let stuck = ":2: no equilibrium: Newton's method does not converge";
    for (name, points, motion, options, words) in [
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
            &format!("x,y,area,pressure\n{points}\n"),
        );
        let header = "time,displacement_1,displacement_2,rotation,pressure_scale";
        let motion = file(
            &format!("large_{name}.csv"),
            &format!("{header}\n1,{motion}\n"),
        );
        for method in ["0", "1", "2"] {
            let props = format!("0.3,0.002,2.5,{method},100");
            let said = complaint(
                "patch",
                &props,
                &[&[patch.as_str(), &motion], options].concat(),
                1,
            );
            assert!(
                said.starts_with(&format!("{motion}{words}")),
                "{name} {method}: {said}"
            );
        }
    }
    // What the library refuses, in the words of its two faces, with the line of the history.
    let patch = file("large_patch.csv", "x,y,area,pressure\n0,0,1,100\n");
    for (name, kind, history) in [
        (
            "pressure",
            "point",
            "time,slip_1,pressure\n0,0,1\n1,1e-3,1e308\n",
        ),
        (
            "scale",
            "patch",
            "time,displacement_1,pressure_scale\n0,0,1\n1,1e-3,1e308\n",
        ),
        (
            "turn",
            "patch",
            "time,displacement_1,displacement_2,rotation\n0,0,0,-1e308\n1,0,0,1e308\n",
        ),
        ("way", "patch", "time,displacement_1\n0,-1e308\n1,1e308\n"),
    ] {
        let history = file(&format!("large_{name}.csv"), history);
        let files = if kind == "patch" {
            vec![patch.as_str(), &history]
        } else {
            vec![history.as_str()]
        };
        for driver in DRIVERS {
            let output = run(driver, kind, "0.3,0.002,2.5,0,100", &files);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{driver} {name}: {said}");
            assert!(
                output.stdout.is_empty() && said.contains(&format!("{driver}: {history}:")),
                "{driver} {name}: {said}"
            );
        }
    }
}

/// A run that fails late leaves nothing that looks like a result, and says where it failed.
#[test]
fn a_failed_run_leaves_no_table() {
    let late = file(
        "late.csv",
        "time,slip_1,pressure\n0,0,10\n1,0.001,10\n2,1e300,10\n",
    );
    for (driver, kind) in [
        ("mepc_replay", "point"),
        ("mepc_replay", "history"),
        ("fric_replay", "point"),
    ] {
        let output = run(driver, kind, "0.3,0.002", &[&late]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{driver} {kind}");
        assert!(
            output.stdout.is_empty() && said.contains("late.csv:4: "),
            "{driver} {kind}: {said}"
        );
    }
    // A disk that is full.
    for driver in DRIVERS {
        let full = std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .expect("a device");
        let output = command(driver, "point", "0.3,0.002", &["cases/circle.csv"])
            .stdout(full)
            .output();
        let output = output.expect("the driver starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.code() == Some(1) && said.contains("standard output: "),
            "{driver}: {said}"
        );
    }
}

/// The C driver looks at what it loads.
#[test]
fn another_library_is_refused() {
    let history = file("any.csv", "time,slip_1,pressure\n0,0,10\n");
    for (library, words) in [
        ("/nowhere/libmepc.so", "cannot load the library"),
        ("libm.so.6", "libm.so.6: has no function mepc_abi_version"),
    ] {
        let output = Command::new("build/mepc_replay")
            .args(["point", library, "0.3,0.002", &history])
            .output();
        let output = output.expect("the driver starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.code() == Some(1) && said.contains(words),
            "{said}"
        );
    }
}

/// The Fortran module: its program prints the tractions of first loading, f(.5) and f(1), and of a cycle.
#[test]
fn module_demo() {
    let directory = library_path();
    let output = Command::new("build/module_demo")
        .env("LD_LIBRARY_PATH", directory.parent().expect("a directory"))
        .output()
        .expect("build/module_demo: run `make drivers` first");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{text}");
    let tractions: Vec<f64> = text
        .lines()
        .filter_map(|line| line.split_whitespace().next()?.parse().ok())
        .collect();
    let limit = 0.3 * 50.0;
    assert_eq!(tractions.len(), 6, "{text}");
    assert!(
        (tractions[0] - limit * (1.0 - 0.5f64.powf(2.5))).abs() < 1e-7,
        "{text}"
    );
    assert!((tractions[1] - limit).abs() < 1e-7, "{text}");
    // After a slip of -4/2 gcr the whole of the contact slips back.
    assert!((tractions[3] + limit).abs() < 1e-7, "{text}");
    assert!(
        text.contains("difference of the last traction: 0.00E+00"),
        "{text}"
    );
}
