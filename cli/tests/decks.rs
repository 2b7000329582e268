//! What `mepc deck` prints, fed to a parser or a compiler; where there is none, its form.

mod tool;

use mepc::{Law, Vector};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;
use tool::{Tool, root};

const PROPS: &str = "0.3,0.002,2.5,0,0,0.005,1e5";

fn library() -> PathBuf {
    std::env::var_os("MEPC_LIBRARY")
        .map_or_else(|| root().join("target/release/libmepc.so"), PathBuf::from)
}

#[test]
fn kratos_is_json() {
    let tool = Tool::new();
    tool.write("libmepc.so", "");
    for (directions, law) in [
        ("1", "SmallStrainUMAT2DInterfaceLaw"),
        ("2", "SmallStrainUMAT3DInterfaceLaw"),
    ] {
        let text = tool.ok(&[
            "deck",
            "kratos",
            "--props",
            PROPS,
            "--directions",
            directions,
            "--name",
            "Structure.Contact",
        ]);
        let json: Value = serde_json::from_str(&text).expect("JSON");
        let entry = &json["properties"][0];
        assert_eq!(entry["model_part_name"], "Structure.Contact");
        assert_eq!(entry["Material"]["constitutive_law"]["name"], law);
        let variables = &entry["Material"]["Variables"];
        let numbers = |key: &str| -> Vec<f64> {
            let list = variables[key].as_array().expect(key);
            list.iter().map(|v| v.as_f64().expect("a number")).collect()
        };
        assert_eq!(
            numbers("UMAT_PARAMETERS"),
            [
                0.3, 0.002, 2.5, 0.0, 0.0, 0.005, 1e5, 0.0, 16.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0
            ]
        );
        assert_eq!(numbers("STATE_VARIABLES"), [0.0; 64]);
        let path = variables["UDSM_NAME"].as_str().expect("a path");
        assert!(std::path::Path::new(path).is_absolute(), "{path}");
    }
}

#[test]
fn opengeosys_is_xml() {
    let tool = Tool::new();
    let text = tool.ok(&[
        "deck",
        "opengeosys",
        "--props",
        PROPS,
        "--thickness",
        "0.1",
        "--material",
        "3",
    ]);
    let document = roxmltree::Document::parse(&text).expect("XML");
    assert_eq!(
        document.root_element().tag_name().name(),
        "OpenGeoSysProjectDiff"
    );
    let all = |tag: &str| {
        document
            .descendants()
            .filter(|n| n.has_tag_name(tag))
            .collect::<Vec<_>>()
    };
    let relation = all("constitutive_relation")[0];
    assert_eq!(relation.attribute("id"), Some("3"));
    let child = |tag: &str| {
        relation
            .children()
            .find(|n| n.has_tag_name(tag))
            .and_then(|n| n.text())
    };
    assert_eq!(child("type"), Some("MFront"));
    assert_eq!(child("behaviour"), Some("MemoryPenaltyLayer"));
    // Every material property in its order, and each of its parameters with its value.
    let names: Vec<_> = all("material_property")
        .iter()
        .map(|n| n.attribute("name").expect("name"))
        .collect();
    assert_eq!(
        names,
        [
            "FrictionCoefficient",
            "CriticalSlip",
            "Exponent",
            "NormalStiffness",
            "InitialGap",
            "Method",
            "PressureRule",
            "Thickness"
        ]
    );
    let values: Vec<f64> = all("material_property")
        .iter()
        .map(|property| {
            let parameter = all("parameter")
                .into_iter()
                .find(|p| {
                    p.children().any(|n| {
                        n.has_tag_name("name") && n.text() == property.attribute("parameter")
                    })
                })
                .expect("its parameter");
            let value = parameter
                .children()
                .find(|n| n.has_tag_name("value"))
                .and_then(|n| n.text());
            value.expect("a value").parse().expect("a number")
        })
        .collect();
    assert_eq!(values, [0.3, 0.002, 2.5, 1e5, 0.0, 0.0, 0.0, 0.1]);
}

/// Keyword lines and the numbers of data lines.
fn keywords(text: &str) -> Vec<(String, Vec<f64>)> {
    let mut found: Vec<(String, Vec<f64>)> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with("**")) {
        assert!(line.len() <= 132, "{line}");
        if line.starts_with('*') {
            found.push((line.to_string(), Vec::new()));
        } else {
            let fields: Vec<&str> = line.trim().trim_end_matches(',').split(',').collect();
            assert!(fields.len() <= 8, "{line}");
            let data = &mut found.last_mut().expect("a keyword").1;
            data.extend(fields.iter().map(|f| f.trim().parse::<f64>().expect(f)));
        }
    }
    found
}

#[test]
fn abaqus_and_calculix_by_form() {
    let tool = Tool::new();
    for (props, directions, depvar, count) in [
        ("0.3,0.002,2.5", "2", 64, 3),
        ("0.3,0", "1", 25, 2),
        ("0.3,0.002,2.5,0,0,0.005,0,0,32,0,0,0", "2", 96, 12),
    ] {
        let text = tool.ok(&[
            "deck",
            "abaqus",
            "--props",
            props,
            "--directions",
            directions,
        ]);
        let deck = keywords(&text);
        let (friction, numbers) = &deck[1];
        assert_eq!(
            friction,
            &format!("*FRICTION, USER=FRIC, DEPVAR={depvar}, PROPERTIES={count}")
        );
        let given: Vec<f64> = props.split(',').map(|p| p.parse().expect(p)).collect();
        assert_eq!(numbers, &given);
        assert!(text.contains("checked for form only"));
    }
    let text = tool.ok(&["deck", "calculix", "--props", PROPS, "--thickness", "0.1"]);
    let deck = keywords(&text);
    assert_eq!(deck[0].0, "*MATERIAL, NAME=@ABAQUS_MEPC");
    assert_eq!(deck[1].0, "*USER MATERIAL, CONSTANTS=16");
    // And the temperature for which the constants hold.
    assert_eq!(deck[1].1[12..], [2.0, 1.0, 0.1, 1.0, 0.0]);
    assert_eq!(deck[2], ("*DEPVAR".to_string(), vec![64.0]));
    assert!(text.contains("checked for form only"));
}

#[test]
fn mtest_by_form() {
    let tool = Tool::new();
    let text = tool.ok(&["deck", "mtest", "--props", PROPS, "--directions", "1"]);
    assert!(text.contains("checked for form only"));
    for line in text.lines().filter(|line| !line.starts_with("//")) {
        assert!(line.starts_with('@') && line.ends_with(';'), "{line}");
        assert_eq!(
            line.matches('{').count(),
            line.matches('}').count(),
            "{line}"
        );
        assert_eq!(line.matches('\'').count() % 2, 0, "{line}");
    }
    assert!(text.contains("@Behaviour<generic> 'libmepc.so' 'MemoryPenaltyContact';"));
    assert!(text.contains("@MaterialProperty<constant> 'CriticalSlip' 0.002;"));
    let refused = tool.run(&[
        "deck",
        "mtest",
        "--props",
        "0.3,0.002,-0.5,0,0,0.005,1e5,0,16,1,0",
    ]);
    assert_eq!(refused.code, 1);
}

/// The programs print a cycle; the crate gives the same numbers.
fn assert_cycle<const N: usize>(output: &str, props: &[f64]) {
    let nstate = mepc::default_state_size(props, N).expect("good properties");
    let law = Law::<N>::new(props, nstate).expect("good properties");
    let gcr = law.critical_slip(0.0).expect("a critical slip");
    let (mut state, mut next) = (vec![0.0; nstate], vec![0.0; nstate]);
    let mut slip = 0.0;
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(lines.len(), 100);
    for (i, line) in lines.into_iter().enumerate() {
        let step = if (20..60).contains(&i) {
            -0.1 * gcr
        } else {
            0.1 * gcr
        };
        let mut increment = Vector::<N>::zeros();
        increment[0] = step;
        slip += step;
        let response = law
            .friction(gcr, &increment, 100.0, &state, &mut next)
            .expect("an update");
        std::mem::swap(&mut state, &mut next);
        let printed: Vec<f64> = line
            .split(',')
            .map(|f| f.trim().parse().expect(f))
            .collect();
        assert!(
            (printed[0] - slip).abs() < 1e-12 && (printed[1] - response.traction[0]).abs() < 1e-9,
            "{i}: {line}"
        );
    }
}

fn compile_and_run(tool: &Tool, compiler: &str, flags: &[&str], sources: &[PathBuf]) -> String {
    let library = library();
    assert!(
        library.exists(),
        "{} is not there: run `cargo build --release` first, or set MEPC_LIBRARY",
        library.display()
    );
    let place = library.parent().expect("a directory");
    let program = tool.path("friction");
    let done = Command::new(compiler)
        .args(flags)
        .args(sources)
        .arg("-I")
        .arg(root().join("include"))
        .arg("-L")
        .arg(place)
        .arg("-lmepc")
        .arg(format!("-Wl,-rpath,{}", place.display()))
        .arg("-o")
        .arg(&program)
        .current_dir(tool.directory.path())
        .output()
        .unwrap_or_else(|error| panic!("{compiler}: {error} (make setup installs it)"));
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let run = Command::new(&program)
        // Cargo's own library path would come before the program's.
        .env_remove("LD_LIBRARY_PATH")
        .output()
        .expect("the program starts");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    String::from_utf8(run.stdout).expect("text")
}

#[test]
fn c_and_fortran_run() {
    let tool = Tool::new();
    for (props, directions) in [
        ("0.3,0.002,2.5", "1"),
        ("0.42,2.68e-3,1.5,0,0,0.004,0,0,8,0,0,0", "2"),
    ] {
        let numbers: Vec<f64> = props.split(',').map(|p| p.parse().expect(p)).collect();
        let check = |output: &str| match directions {
            "1" => assert_cycle::<1>(output, &numbers),
            _ => assert_cycle::<2>(output, &numbers),
        };
        let deck =
            |host: &str| tool.ok(&["deck", host, "--props", props, "--directions", directions]);
        tool.write("friction.c", &deck("c"));
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
        check(&compile_and_run(
            &tool,
            "cc",
            &flags,
            &[tool.path("friction.c")],
        ));
        tool.write("friction.f90", &deck("fortran"));
        let sources = [root().join("include/mepc.f90"), tool.path("friction.f90")];
        let flags = [
            "-std=f2018",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fimplicit-none",
        ];
        check(&compile_and_run(&tool, "gfortran", &flags, &sources));
    }
}
