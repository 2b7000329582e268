//! One loop in every form that rigs and programs write: the same parameters come back, and what was told of the form is said.

mod tool;

use serde_json::Value;
use std::fmt::Write as _;
use tool::{Tool, csv};

const JOINT: &str = "266.78,0.0041,3280.7,-0.842";
const KEYS: [&str; 4] = ["F_s", "X_s", "k_alpha", "kappa"];
/// mm per inch, N per kip.
const INCH: f64 = 25.4;
const KIP: f64 = 4_448.221_615_260_5;

/// A noisy loop: displacement in mm, force in N.
fn rows(tool: &Tool) -> Vec<[f64; 2]> {
    let noise = ["--noise", "0.01", "--seed", "4", "--cycles", "2"];
    let loops = [
        "loop",
        "--iwan",
        JOINT,
        "--amplitude",
        "0.02",
        "--output",
        "plain.csv",
    ];
    tool.ok(&[&loops[..], &noise].concat());
    let table = csv(&tool.read("plain.csv"));
    table
        .iter()
        .map(|row| [row["displacement"], row["force"]])
        .collect()
}

/// A table of rows; time first where asked for.
fn table(rows: &[[f64; 2]], time: bool, separator: &str, end: &str) -> String {
    let mut text = String::new();
    for (k, [x, f]) in rows.iter().enumerate() {
        if time {
            let _ = write!(text, "{:.3}{separator}", 0.01 * k as f64);
        }
        let _ = write!(text, "{x:.12}{separator}{f:.9}{end}");
    }
    text
}

fn comma(text: &str) -> String {
    text.replace('.', ",")
}

/// The same parameters as those of the plain file.
fn assert_same(found: &Value, plain: &Value, what: &str) {
    for key in KEYS {
        let [a, b] = [found, plain].map(|json| json[key].as_f64().expect(key));
        assert!((a / b - 1.0).abs() < 1e-5, "{what}: {key} {a}, plain {b}");
    }
}

struct Form {
    name: &'static str,
    bytes: Vec<u8>,
    options: Vec<&'static str>,
    /// What the line on standard error says.
    said: &'static str,
}

fn form(name: &'static str, text: String, options: &[&'static str], said: &'static str) -> Form {
    Form {
        name,
        bytes: text.into_bytes(),
        options: options.to_vec(),
        said,
    }
}

fn forms(rows: &[[f64; 2]]) -> Vec<Form> {
    let plain = table(rows, false, ",", "\n");
    let timed = table(rows, true, "\t", "\n");
    let by_number = ["--displacement", "1", "--force", "2"];
    let imperial: Vec<[f64; 2]> = rows.iter().map(|[x, f]| [x / INCH, f / KIP]).collect();
    let metric: Vec<[f64; 2]> = rows.iter().map(|[x, f]| [x * 1e3, f * 1e-3]).collect();
    let mil: Vec<[f64; 2]> = rows
        .iter()
        .map(|[x, f]| [x / INCH * 1e3, f / KIP * 1e3])
        .collect();
    let array = |k: usize| {
        rows.iter()
            .map(|row| format!("{:e}", row[k]))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let utf_16 = |little: bool, mark: bool| -> Vec<u8> {
        let text = format!(
            "{}displacement,force\n{plain}",
            if mark { "\u{feff}" } else { "" }
        );
        let units = text.encode_utf16();
        units
            .flat_map(|unit| {
                if little {
                    unit.to_le_bytes()
                } else {
                    unit.to_be_bytes()
                }
            })
            .collect()
    };
    let names = "displacement,force\n";
    let mut all = vec![
        form(
            "blanks.txt",
            format!("  disp_mm   load_N\n{}", table(rows, false, "   ", "\n")),
            &[],
            "blanks, header line 1: 'disp_mm' (mm), 'load_N' (N)",
        ),
        form(
            "aligned.txt",
            format!(
                "  Displacement (mm)    Force (N)\n{}",
                table(rows, false, "\t  ", "  \n")
            ),
            &[],
            "tab, header line 1",
        ),
        form(
            "no_names.csv",
            plain.clone(),
            &by_number,
            "comma, no header: 'column 1' (mm), 'column 2' (N)",
        ),
        form(
            "no_names_timed.dat",
            timed.clone(),
            &["--displacement", "2", "--force", "3"],
            "tab, no header",
        ),
        form(
            "numbers_of_named.csv",
            format!("{names}{plain}"),
            &by_number,
            "comma, header line 1: 'displacement' (mm)",
        ),
        form(
            "comma_semicolon.csv",
            format!("Weg;Kraft\n{}", comma(&table(rows, false, ";", "\n"))),
            &[],
            "semicolon, decimal comma, header line 1: 'Weg' (mm), 'Kraft' (N)",
        ),
        form(
            "comma_tab.txt",
            format!("Weg\tKraft\n{}", comma(&table(rows, false, "\t", "\n"))),
            &[],
            "tab, decimal comma",
        ),
        form(
            "comma_blanks.txt",
            format!("Weg Kraft\n{}", comma(&table(rows, false, "  ", "\n"))),
            &[],
            "blanks, decimal comma",
        ),
        form(
            "comma_quoted.csv",
            format!(
                "\"Weg\",\"Kraft\"\n{}",
                rows.iter()
                    .map(|[x, f]| format!(
                        "\"{}\",\"{}\"\n",
                        comma(&format!("{x:.12}")),
                        comma(&format!("{f:.9}"))
                    ))
                    .collect::<String>()
            ),
            &[],
            "comma, decimal comma",
        ),
        form(
            "excel.csv",
            format!(
                "sep=;\r\nDisplacement (mm);Force (N)\r\n{}",
                table(rows, false, ";", "\r\n")
            ),
            &[],
            "semicolon (sep=), header line 2",
        ),
        form(
            "bar.csv",
            format!(
                "sep=|\nDisplacement [mm]|Force [N]\n{}",
                table(rows, false, "|", "\n")
            ),
            &[],
            "'|' (sep=), header line 2",
        ),
        form(
            "mark.csv",
            format!("\u{feff}{names}{plain}"),
            &[],
            "comma, header line 1",
        ),
        form(
            "cr.csv",
            format!("{names}{plain}").replace('\n', "\r"),
            &[],
            "comma, header line 1",
        ),
        form(
            "units_row.csv",
            format!(
                "Time,Displacement ,Force\ns,mm,N\n{}",
                table(rows, true, ",", "\n")
            ),
            &[],
            "comma, header line 1, units row",
        ),
        form(
            "units_row_um_kn.csv",
            format!(
                "Displacement;Force\n[\u{b5}m];[kN]\n{}",
                table(&metric, false, ";", "\n")
            ),
            &[],
            "units row: 'Displacement' (um), 'Force' (kN)",
        ),
        form(
            "machine.dat",
            format!(
                "Test: lap joint 7\nOperator: \nRate: 100 Hz\n\nTime\tAxial Displacement\tAxial Force\nsec\tmm\tN\n{timed}"
            ),
            &[],
            "tab, header line 5, units row",
        ),
        form(
            "key_and_value.csv",
            format!(
                "Rate;100\nSpecimen;7\n\nDisplacement;Force\n{}",
                table(rows, false, ";", "\n")
            ),
            &[],
            "semicolon, header line 4",
        ),
        form(
            "percent.txt",
            format!(
                "% lap joint\n% displacement (mm), force (N)\n{}",
                table(rows, false, " ", "\n")
            ),
            &[],
            "blanks, header in the comment of line 2",
        ),
        form(
            "hash.txt",
            format!(
                "# time disp force\n# s um kN\n{}",
                table(&metric, true, " ", "\n")
            ),
            &[],
            "header in the comment of line 1, units row: 'disp' (um), 'force' (kN)",
        ),
        form(
            "rule.txt",
            format!(
                "Disp (mm)  Load (N)\n---------  --------\n{}",
                table(rows, false, "  ", "\n")
            ),
            &[],
            "blanks, header line 1",
        ),
        form(
            "trailing.csv",
            format!("{names}{}", table(rows, false, ",", ",\n")),
            &[],
            "comma, header line 1",
        ),
        form(
            "trailing_named.csv",
            format!("displacement,force,\n{}", table(rows, false, ",", ",\n")),
            &[],
            "comma, header line 1",
        ),
        form(
            "empty_lines.csv",
            format!("\n\n{names}\n{}\n\n", plain.replace('\n', "\n\n")),
            &[],
            "comma, header line 3",
        ),
        form(
            "imperial.csv",
            format!("disp_in,load_kip\n{}", table(&imperial, false, ",", "\n")),
            &[],
            "'disp_in' (in), 'load_kip' (kip)",
        ),
        form(
            "imperial_options.csv",
            format!("u,F\n{}", table(&imperial, false, ",", "\n")),
            &[
                "--displacement",
                "U",
                "--force",
                "f",
                "--displacement-unit",
                "in",
                "--force-unit",
                "kip",
            ],
            "'u' (in), 'F' (kip)",
        ),
        form(
            "mil_lbf.csv",
            format!("Stroke [mil];Load [lbf]\n{}", table(&mil, false, ";", "\n")),
            &[],
            "'Stroke [mil]' (mil), 'Load [lbf]' (lbf)",
        ),
        form(
            "micro_sign.csv",
            format!("u (\u{3bc}m),F/kN\n{}", table(&metric, false, ",", "\n")),
            &["--displacement", "u", "--force", "f"],
            "(um), 'F/kN' (kN)",
        ),
        form(
            "micro_option.csv",
            format!("u,F\n{}", table(&metric, false, ",", "\n")),
            &[
                "--displacement",
                "u",
                "--force",
                "F",
                "--displacement-unit",
                "\u{b5}m",
                "--force-unit",
                "kN",
            ],
            "'u' (um), 'F' (kN)",
        ),
        form(
            "fortran.txt",
            format!(
                "disp load\n{}",
                rows.iter()
                    .map(|[x, f]| format!("{x:.12e} {f:.9e}\n").replace('e', "D"))
                    .collect::<String>()
            ),
            &[],
            "blanks, header line 1",
        ),
        form(
            "words.csv",
            format!(
                "Date,Displacement,Force,State\n{}",
                rows.iter()
                    .map(|[x, f]| format!("2024-05-01 12:00:01,{x:.12},{f:.9},ok\n"))
                    .collect::<String>()
            ),
            &[],
            "comma, header line 1",
        ),
        form(
            "columns.json",
            format!(
                "{{\"rig\": 7, \"Disp(mm)\": [{}], \"Load(N)\": [{}]}}\n",
                array(0),
                array(1)
            ),
            &[],
            "JSON, 2 arrays: 'Disp(mm)' (mm), 'Load(N)' (N)",
        ),
        form(
            "footer.csv",
            format!("{names}{plain}End of test,\nStopped by: operator\n"),
            &[],
            "comma, header line 1",
        ),
    ];
    let bytes = |name, bytes, said| Form {
        name,
        bytes,
        options: Vec::new(),
        said,
    };
    all.push(bytes(
        "utf_16_le.csv",
        utf_16(true, true),
        "UTF-16, comma, header line 1",
    ));
    all.push(bytes(
        "utf_16_be.csv",
        utf_16(false, true),
        "UTF-16, comma, header line 1",
    ));
    all.push(bytes(
        "utf_16_no_mark.csv",
        utf_16(true, false),
        "UTF-16, comma, header line 1",
    ));
    let mut latin = b"# 20 \xb0C\nDisplacement (\xb5m),Force (kN)\n".to_vec();
    latin.extend(table(&metric, false, ",", "\n").into_bytes());
    all.push(bytes(
        "latin_1.csv",
        latin,
        "Latin-1, comma, header line 2: 'Displacement (\u{b5}m)' (um)",
    ));
    all
}

#[test]
fn every_form_gives_the_same_parameters() {
    let tool = Tool::new();
    let rows = rows(&tool);
    let plain = tool.run(&["identify", "plain.csv", "--json"]);
    let plain: Value = serde_json::from_str(&plain.output).expect("JSON");
    for Form {
        name,
        bytes,
        options,
        said,
    } in forms(&rows)
    {
        std::fs::write(tool.path(name), bytes).expect(name);
        let run = tool.run(&[&["identify", name, "--json"], &options[..]].concat());
        assert!(
            run.errors.contains(&format!("{name}: reading: ")),
            "{name}: {}",
            run.errors
        );
        assert!(run.errors.contains(said), "{name}: {}", run.errors);
        assert!(!run.output.is_empty(), "{name}: {}", run.errors);
        let found = serde_json::from_str(&run.output).expect("JSON");
        assert_same(&found, &plain, name);
        assert_eq!(
            found["units"],
            serde_json::json!({ "length": "mm", "force": "N" }),
            "{name}"
        );
    }
}

/// Tables are in the units of the file, with the digits that the standard error leaves.
#[test]
fn tables_are_in_the_units_of_the_file() {
    let tool = Tool::new();
    let rows = rows(&tool);
    let kip: Vec<[f64; 2]> = rows.iter().map(|[x, f]| [x / INCH, f / KIP]).collect();
    tool.write(
        "kip.csv",
        &format!("disp_in,load_kip\n{}", table(&kip, false, ",", "\n")),
    );
    let run = tool.run(&["identify", "kip.csv"]);
    for (name, truth, digits) in [
        ("F_s (kip)", 266.78 / KIP, 5),
        ("X_s (in)", 0.0041 / INCH, 5),
    ] {
        let line = run
            .output
            .lines()
            .find(|line| line.starts_with(name))
            .expect(&run.output);
        let value = line[name.len()..]
            .split_whitespace()
            .next()
            .expect("a value");
        let number: f64 = value.parse().expect("a number");
        assert!((number / truth - 1.0).abs() < 0.02, "{line}");
        let shown = value
            .trim_start_matches(['0', '.'])
            .split('e')
            .next()
            .expect("digits");
        assert!(
            shown.chars().filter(char::is_ascii_digit).count() <= digits,
            "{line}"
        );
    }
    assert!(
        run.output.contains("(kip/in)") && run.output.contains("(kip.in)"),
        "{}",
        run.output
    );
    // What is rounding beside the amplitude is zero.
    tool.ok(&[
        "loop",
        "--iwan",
        JOINT,
        "--amplitude",
        "0.02",
        "--output",
        "clean.csv",
    ]);
    let output = tool.ok(&["identify", "clean.csv"]);
    assert!(output.contains("about 0 mm, mean force 0 N"), "{output}");
}

/// Samples that are not there are counted; lines that are no rows are told.
#[test]
fn gaps_are_said() {
    let tool = Tool::new();
    let rows = rows(&tool);
    let mut text = String::from("displacement,force\n");
    let mut gaps = 0;
    for (k, [x, f]) in rows.iter().enumerate() {
        let _ = match k % 97 {
            5 => writeln!(text, "{x},NaN"),
            6 => writeln!(text, "{x},"),
            7 => writeln!(text, "#N/A,{f}"),
            _ => writeln!(text, "{x},{f}"),
        };
        gaps += usize::from((5..8).contains(&(k % 97)));
    }
    tool.write("gaps.csv", &(text + "\n,\n"));
    let run = tool.run(&["identify", "gaps.csv"]);
    let words = format!(
        "{gaps} of {} rows have no number in the columns used (the first in line 7)",
        rows.len()
    );
    assert!(run.errors.contains(&words), "{}", run.errors);

    tool.write(
        "two.csv",
        &format!(
            "displacement,force\n0,0\n1,1\ndisplacement,force\n{}",
            table(&rows, false, ",", "\n")
        ),
    );
    let run = tool.run(&["identify", "two.csv"]);
    assert_eq!(run.code, 1);
    assert!(
        run.errors
            .contains("two.csv:4: 'displacement,force' holds no numbers, but line 5 below it does"),
        "{}",
        run.errors
    );
    // A replay takes no gaps: its history would be another.
    tool.write("history.csv", "time,slip_1,pressure\n0,0,10\n1,NaN,10\n");
    let run = tool.run(&["replay", "point", "history.csv", "--props", "0.3,0.002"]);
    assert_eq!(run.code, 1);
    assert!(
        run.errors
            .contains("history.csv:3: column slip_1: 'NaN' is no number"),
        "{}",
        run.errors
    );
    // A lone CR ends a line like any other end: no row is lost.
    tool.write(
        "cr.csv",
        "time,slip_1,pressure\n0,0,10\n1,0.001,10\r2,0.002,10\n3,0.003,10\n",
    );
    let output = tool.ok(&["replay", "point", "cr.csv", "--props", "0.3,0.002"]);
    assert_eq!(csv(&output).len(), 4);
}

/// What is not there is proposed.
#[test]
fn columns_are_proposed() {
    let tool = Tool::new();
    let rows = rows(&tool);
    let plain = table(&rows, false, ",", "\n");
    tool.write("no_names.csv", &plain);
    tool.write("timed.csv", &table(&rows, true, ",", "\n"));
    tool.write("odd.csv", &format!("Displacment,Fource\n{plain}"));
    tool.write("twice.csv", &format!("load A,load B\n{plain}"));
    tool.write(
        "wrong.csv",
        &format!("displacement (N),force (mm)\n{plain}"),
    );
    for (arguments, words) in [
        (
            vec!["no_names.csv"],
            "the table has no names (2 columns, line 1: ",
        ),
        (vec!["no_names.csv"], "--displacement 1 --force 2"),
        (vec!["timed.csv"], "--displacement 2 --force 3"),
        (vec!["odd.csv"], "did you mean 'Displacment'?"),
        (
            vec!["odd.csv", "--displacement", "1", "--force", "forse"],
            "did you mean 'Fource'?",
        ),
        (
            vec!["odd.csv", "--displacement", "3", "--force", "1"],
            "column 3: the table has 2 columns, counted from 1",
        ),
        (
            vec!["twice.csv", "--displacement", "1"],
            "may be one of load A, load B: choose with --force",
        ),
        (vec!["wrong.csv"], "column displacement (N): is in N"),
    ] {
        let run = tool.run(&[&["identify"], &arguments[..]].concat());
        assert_eq!(run.code, 1, "{arguments:?}: {}", run.errors);
        assert!(run.errors.contains(words), "{arguments:?}: {}", run.errors);
        assert!(run.output.is_empty(), "{arguments:?}");
    }
}

/// The largest memory of all runs so far, MB.
fn largest_run() -> f64 {
    // SAFETY: rusage is plain numbers, for which zeros are valid, and the call writes no more than one.
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        assert_eq!(libc::getrusage(libc::RUSAGE_CHILDREN, &mut usage), 0);
        usage
    };
    usage.ru_maxrss as f64 / 1024.0
}

/// Files that are no tables end with words and in little memory. Sparse files take no room.
#[test]
fn hostile_files_are_refused_in_little_memory() {
    let tool = Tool::new();
    let sized = |name: &str, start: &[u8], byte: u8, size: usize| {
        use std::io::Write;
        let mut file = std::io::BufWriter::new(std::fs::File::create(tool.path(name)).expect(name));
        file.write_all(start).expect(name);
        let block = vec![byte; 1 << 16];
        for _ in 0..size >> 16 {
            file.write_all(&block).expect(name);
        }
    };
    sized("line.csv", b"displacement,force\n", b'1', 100 << 20);
    sized("commas.csv", b"displacement,force\n", b',', 7 << 20);
    sized("string.json", b"{\"", b'x', 100 << 20);
    sized("nested.json", b"{\"x\":", b'[', 10 << 20);
    tool.write("zip.xlsx", "PK\u{3}\u{4} and so on");
    tool.write("words.csv", &"no numbers at all\n".repeat(100_000));
    let zeros = std::fs::File::create(tool.path("zeros.csv")).expect("a file");
    zeros.set_len(1 << 30).expect("a sparse file");
    for (name, words) in [
        (
            "line.csv",
            "line.csv:2: a line of more than 8 MB is no row of a table",
        ),
        ("commas.csv", "commas.csv:2: has more than 200000 columns"),
        ("string.json", "a string of more than 1 MB"),
        ("nested.json", "nested.json: is read as JSON"),
        ("zip.xlsx", "a ZIP archive (an .xlsx or .ods spreadsheet?)"),
        ("words.csv", "no row of numbers up to line 1000"),
        ("zeros.csv", "zeros.csv: is not a text file"),
        ("/dev/zero", "/dev/zero: is not a text file"),
        ("/dev/null", "/dev/null:1: is empty"),
        (".", "directory"),
    ] {
        let run = tool.run(&["identify", name]);
        assert_eq!(run.code, 1, "{name}: {}", run.errors);
        assert!(run.errors.contains(words), "{name}: {}", run.errors);
    }
    let largest = largest_run();
    println!("refused in at most {largest:.0} MB");
    assert!(largest < 64.0, "{largest} MB");

    // 10^5 columns are a table, and its rows are read.
    let names: Vec<String> = (0..100_000).map(|k| format!("c{k}")).collect();
    let mut wide = format!("{},displacement,force\n", names.join(","));
    let zeros = "0,".repeat(100_000);
    for [x, f] in rows(&tool).iter().step_by(10) {
        let _ = writeln!(wide, "{zeros}{x},{f}");
    }
    tool.write("wide.csv", &wide);
    let run = tool.run(&["identify", "wide.csv"]);
    assert!(run.output.contains("F_s"), "{}", run.errors);
    assert!(largest_run() < 100.0, "{} MB", largest_run());
}
