//! What `mepc deck` prints, fed to a parser or a compiler; where there is none, its form.

mod tool;

use mepc::{Law, Vector};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;
use tool::{Tool, root};

const PROPS: &str = "mu=.3,gcr=.002,exponent=2.5,reference_pressure=10,kn=1e5";

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
                0.3, 0.002, 2.5, 0.0, 10.0, 0.0, 1e5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0
            ]
        );
        assert_eq!(numbers("STATE_VARIABLES"), [0.0; 84]);
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
            "ReferencePressure",
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
    assert_eq!(values, [0.3, 0.002, 2.5, 1e5, 0.0, 10.0, 0.1]);
    assert!(
        text.contains("<variables/>") && text.contains("5 DissipatedEnergy"),
        "{text}"
    );
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
        ("0.3,0.002,2.5", "2", 84, 3),
        ("0.3,0", "1", 44, 2),
        ("0.3,0.002,2.5,0,10,0.005,0,0,0,0,0,2,40", "2", 84, 13),
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
        for words in [
            "CSTATUS",
            "SDV1 ContactStatus (0 open",
            "SDV5 DissipatedEnergy",
            "SDV6 SlipLength",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert_eq!(text.contains("SDV9 TangentialJump2"), directions == "2");
    }
    let text = tool.ok(&["deck", "calculix", "--props", PROPS, "--thickness", "0.1"]);
    let deck = keywords(&text);
    assert_eq!(deck[0].0, "*MATERIAL, NAME=@ABAQUS_MEPC");
    assert_eq!(deck[1].0, "*USER MATERIAL, CONSTANTS=25");
    // And the temperature for which the constants hold.
    assert_eq!(deck[1].1[..7], [0.3, 0.002, 2.5, 0.0, 10.0, 0.0, 1e5]);
    assert_eq!(deck[1].1[20..], [2.0, 1.0, 0.1, 1.0, 0.0, 0.0]);
    assert_eq!(deck[2], ("*DEPVAR".to_string(), vec![84.0]));
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
    assert!(text.contains("1 ContactStatus (0 open"), "{text}");
    // A parameter of the behaviour, not of the point; the same backbone as asked for.
    let segalman = "mu=.3,gcr=.002,q=1.5,backbone=segalman,beta=.2,kn=1e5";
    let text = tool.ok(&["deck", "mtest", "--props", segalman]);
    for line in [
        "@Parameter 'Backbone' 1;",
        "@Parameter 'Beta' 0.2;",
        "@MaterialProperty<constant> 'Exponent' 1.5;",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let refused = tool.run(&[
        "deck",
        "opengeosys",
        "--props",
        segalman,
        "--thickness",
        "0.1",
    ]);
    assert_eq!(refused.code, 1);
    let words = "PROPS(10) backbone = 1: is the parameter Backbone of the behaviour, which a project of OpenGeoSys cannot set";
    assert!(refused.errors.contains(words), "{}", refused.errors);
}

/// What a deck has no place for is refused, and why there is a reference pressure is said.
#[test]
fn options_without_effect_are_refused() {
    let tool = Tool::new();
    for (host, option, value) in [
        ("calculix", "--name", "Bolt"),
        ("calculix", "--directions", "1"),
        ("calculix", "--library", "a.so"),
        ("abaqus", "--thickness", "1"),
        ("abaqus", "--material", "2"),
        ("kratos", "--thickness", "1"),
        ("mtest", "--name", "Bolt"),
        ("c", "--library", "a.so"),
        ("fortran", "--material", "3"),
    ] {
        let run = tool.run(&["deck", host, "--props", PROPS, option, value]);
        assert_eq!(run.code, 2, "{host} {option}");
        let words = format!("{option}: the deck for {host} has no place for it");
        assert!(
            run.errors.contains(&words),
            "{host} {option}: {}",
            run.errors
        );
        assert!(run.output.is_empty());
    }
    let run = tool.run(&[
        "deck",
        "calculix",
        "--props",
        &format!("0.3,0.002{},2", ",0".repeat(18)),
        "--thickness",
        "1",
    ]);
    assert!(
        run.errors
            .contains("--props: 21 entries: those from 21 on belong to the host"),
        "{}",
        run.errors
    );
    // A field that multiplies mu is for FRIC.
    assert!(
        tool.ok(&[
            "deck",
            "abaqus",
            "--props",
            &format!("0.3,0.002{},2", ",0".repeat(18))
        ])
        .contains("PROPERTIES=21")
    );
    for (props, has) in [
        ("mu=.3,gcr=.002", false),
        ("mu=.3,gcr=.002,reference_pressure=10", true),
    ] {
        let run = tool.run(&["deck", "c", "--props", props]);
        assert_eq!(
            run.errors
                .contains("warning: --props: no reference_pressure"),
            !has,
            "{}",
            run.errors
        );
        assert_eq!(
            run.output
                .contains("gcr holds at the reference pressure 10"),
            has,
            "{}",
            run.output
        );
    }
}

/// The programs print a cycle; the crate gives the same numbers.
fn assert_cycle<const N: usize>(output: &str, props: &[f64]) {
    let nstate = mepc::default_state_size(props, N).expect("good properties");
    let law = Law::<N>::new(props, nstate).expect("good properties");
    let gcr = law.critical_slip(0.0).expect("a critical slip");
    let pressure = if props.len() > 4 && props[4] > 0.0 {
        props[4]
    } else {
        100.0
    };
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
            .friction(gcr, &increment, pressure, 1.0, &state, &mut next)
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
        let rest = [state[0], state[4], state[5]];
        assert!(
            printed[2..]
                .iter()
                .zip(rest)
                .all(|(a, b)| (a - b).abs() < 1e-9 * b.max(1.0)),
            "{i}: {line}"
        );
        assert_eq!(printed.len(), 5);
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
        ("0.42,2.68e-3,1.5,0,20,0.004,0,0,0,0,0,1.5", "2"),
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
