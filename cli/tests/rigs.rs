//! `mepc identify` and `mepc calibrate` on records as rigs write them: exit code, reasons, and what is said.

#[path = "../../tests/rig/mod.rs"]
mod rig;
mod tool;

use rig::{
    AMPLITUDE, T_MAX, TRUTH, TURN, joint, joint_of, noisy, play, ramps, sine, stop, velocity,
};
use serde_json::Value;
use std::fmt::Write as _;
use tool::{Run, Tool};

fn put(tool: &Tool, file: &str, x: &[f64], force: &[f64]) {
    let mut text = String::from("displacement,force\n");
    for (x, force) in x.iter().zip(force) {
        let _ = writeln!(text, "{x:e},{force:e}");
    }
    tool.write(file, &text);
}

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.output).unwrap_or_else(|_| panic!("{}", run.errors))
}

fn number(json: &Value, key: &str) -> f64 {
    json[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {json}"))
}

/// Reasons of a run that is flagged; the lag, if any, is no reason.
fn reasons(run: &Run) -> Vec<String> {
    let json = json(run);
    let reasons = json["reasons"].as_array().expect("a list");
    assert_eq!(run.code, if reasons.is_empty() { 0 } else { 3 });
    assert_eq!(json["reliable"], reasons.is_empty());
    let words = reasons
        .iter()
        .map(|r| r.as_str().expect("a word").to_string());
    words.collect()
}

#[test]
fn growing_amplitude_needs_no_option() {
    let tool = Tool::new();
    let x = ramps(&[0.004, 0.008, 0.012, 0.016, 0.02, 0.02]);
    put(&tool, "ramp.csv", &x, &noisy(&joint(&x), 0.01, 1));
    let run = tool.run(&["identify", "ramp.csv", "--json"]);
    assert!(reasons(&run).is_empty());
    assert!(
        run.errors.contains("the amplitude grows: 6 cycles"),
        "{}",
        run.errors
    );
    let all = json(&run);
    assert_eq!(all["points"], x.len());
    assert_eq!(
        (&all["cycles"], &all["amplitude_changes"]),
        (&6.into(), &true.into())
    );
    assert!((number(&all, "kappa") - TRUTH[3]).abs() < 0.05);
    for options in [&["--cycle", "5"][..], &["--rows", "1600:2372"]] {
        let run = tool.run(&[&["identify", "ramp.csv", "--json"], options].concat());
        let some = json(&run);
        assert!((number(&some, "kappa") - TRUTH[3]).abs() < 0.1, "{some}");
        assert!(number(&some, "points") < 0.5 * x.len() as f64);
    }
    for (options, words) in [
        (["--cycle", "7"], "--cycle 7: 6 whole cycles were found"),
        (["--rows", "1:99999"], "--rows 1:99999: there are 2372 rows"),
        (["--rows", "10:40"], "no loop: 0 whole half cycles"),
    ] {
        let run = tool.run(&[&["identify", "ramp.csv"][..], &options].concat());
        assert_eq!(run.code, 1);
        assert!(run.errors.contains(words), "{}", run.errors);
    }
    for rows in ["0:5", "5:2", "5", "a:b"] {
        assert_eq!(tool.run(&["identify", "ramp.csv", "--rows", rows]).code, 2);
    }
}

#[test]
fn a_lag_is_taken_out_and_said() {
    let tool = Tool::new();
    let x = sine(5);
    let force = noisy(&joint(&x), 0.01, 2);
    put(&tool, "lag.csv", &x[TURN - 4..x.len() - 4], &force[TURN..]);
    let run = tool.run(&["identify", "lag.csv", "--json"]);
    assert!(reasons(&run).is_empty());
    assert!(
        run.errors.contains("taken out (--lag 0 leaves it)"),
        "{}",
        run.errors
    );
    let found = json(&run);
    assert!((number(&found["lag"], "value") - 4.0).abs() < 0.3);
    assert!((number(&found, "kappa") - TRUTH[3]).abs() < 0.05);
    let run = tool.run(&["identify", "lag.csv", "--json", "--lag", "0"]);
    assert!(reasons(&run).contains(&"lag".to_string()));
    assert!((number(&json(&run)["extended"]["effects"]["lag"], "value") - 4.0).abs() < 0.3);
    // Given, it is neither looked for nor said.
    let run = tool.run(&["identify", "lag.csv", "--json", "--lag", "4"]);
    assert!(reasons(&run).is_empty() && !run.errors.contains("late"));
}

#[test]
fn bearing_is_flagged_and_the_stop_model_proposed() {
    let tool = Tool::new();
    let x = sine(5);
    let clean = joint(&x);
    let pairs = clean.iter().zip(&x);
    let force: Vec<f64> = pairs.map(|(t, &x)| t + stop(x, [0.015; 2], 2e4)).collect();
    put(
        &tool,
        "lap.csv",
        &x[TURN..],
        &noisy(&force, 0.005, 1)[TURN..],
    );
    let run = tool.run(&["identify", "lap.csv", "--json"]);
    assert!(reasons(&run).contains(&"bearing".to_string()));
    assert!(run.errors.contains("use --model stop"), "{}", run.errors);
    let extended = json(&run);
    let clearance = number(&extended["extended"]["stop"]["clearance_above"], "value");
    assert!((clearance - 0.015).abs() < 1e-4);
    let run = tool.run(&[
        "identify",
        "lap.csv",
        "--json",
        "--model",
        "stop",
        "--picture",
        "l.svg",
    ]);
    assert!(reasons(&run).is_empty());
    let found = json(&run);
    assert_eq!(found["model"], "stop");
    assert!((number(&found["stop"]["stiffness"], "value") / 2e4 - 1.0).abs() < 0.02);
    assert!((number(&found, "T_max") / (T_MAX + 100.0) - 1.0).abs() < 0.01);
    assert!((number(&found, "kappa") - TRUTH[3]).abs() < 0.05);
    let table = tool.ok(&["identify", "lap.csv", "--model", "stop"]);
    assert!(table.contains("clearance above the middle"), "{table}");
    let run = tool.run(&[
        "identify", "lap.csv", "--model", "stop", "--method", "paper",
    ]);
    assert_eq!(run.code, 2);
}

#[test]
fn other_loops_are_flagged_with_their_reason() {
    let tool = Tool::new();
    let x = sine(5);
    let clean = joint(&x);
    let viscous = clean.iter().enumerate();
    let pinched = clean.iter().zip(&x);
    let cases = [
        ("backlash", joint(&play(&x, 0.005 * AMPLITUDE))),
        (
            "viscous",
            viscous
                .map(|(i, t)| t + 0.1 * T_MAX * velocity(i))
                .collect(),
        ),
        (
            "shape",
            pinched
                .map(|(t, x)| t * (0.15 + (x / AMPLITUDE).powi(2)).min(1.0))
                .collect(),
        ),
    ];
    for (reason, force) in cases {
        put(
            &tool,
            "loop.csv",
            &x[TURN..],
            &noisy(&force, 0.01, 1)[TURN..],
        );
        for method in ["least-squares", "paper"] {
            let run = tool.run(&["identify", "loop.csv", "--json", "--method", method]);
            // The paper's procedure finds no line in a pinched loop.
            if run.code != 1 {
                assert!(
                    reasons(&run).contains(&reason.to_string()),
                    "{reason} {}",
                    run.errors
                );
            }
        }
        let run = tool.run(&["identify", "loop.csv", "--json"]);
        let found = json(&run);
        if reason != "shape" {
            assert!(number(&found["extended"]["effects"][reason], "value") > 0.0);
            assert!((number(&found["extended"], "kappa") - TRUTH[3]).abs() < 0.06);
        }
        let table = tool.run(&["identify", "loop.csv"]).output;
        assert!(table.contains("not reliable: "), "{table}");
    }
}

/// Loops at three preloads, mu .3, gcr 2.68 um, K_e 178 kN/mm, in the shape of a joint of chi 1.658.
fn preloads(tool: &Tool, seed: u64) -> Vec<String> {
    let x = ramps(&[AMPLITUDE; 3]);
    let files = [300.0, 700.0, 1100.0].map(|p| {
        let file = format!("p{p}.csv");
        let friction = 0.3 * p;
        let loops = joint_of(
            [friction, 0.00268 + friction / 178e3, TRUTH[2], TRUTH[3]],
            &x,
        );
        put(tool, &file, &x, &noisy(&loops, 0.01, seed));
        file
    });
    files.to_vec()
}

fn calibrate<'a>(files: &'a [String], options: &[&'a str]) -> Vec<&'a str> {
    let files = files.iter().map(String::as_str);
    ["calibrate", "--json"]
        .into_iter()
        .chain(files)
        .chain(options.iter().copied())
        .collect()
}

#[test]
fn preloads_give_the_law() {
    let tool = Tool::new();
    let right = [
        "--preload",
        "300",
        "--preload",
        "700",
        "--preload",
        "1100",
        "--area",
        "361.52",
    ];
    for seed in 1..=5 {
        let files = preloads(&tool, seed);
        let run = tool.run(&calibrate(&files, &right));
        assert!(reasons(&run).is_empty(), "{}", run.errors);
        let found = json(&run);
        assert!((number(&found, "mu") / 0.3 - 1.0).abs() < 0.01);
        assert!(
            (number(&found, "gcr") / 0.00268 - 1.0).abs() < 0.05,
            "{found}"
        );
        assert!((number(&found, "K_e") / 178e3 - 1.0).abs() < 0.1, "{found}");
        // The reference pressure is that of the mean preload; it is property 5.
        let pressure = 700.0 / 361.52;
        assert!((number(&found, "reference_pressure") / pressure - 1.0).abs() < 1e-12);
        assert_eq!(found["props"][4], found["reference_pressure"]);
        assert_eq!(found["props"][3], 0.0);
        // gcr does not move with the pressure here.
        let power = &found["gcr_over_pressure"];
        assert!(number(power, "power").abs() < 0.15, "{power}");
        assert_eq!(power["constant_gcr_fits"], true);
        assert_eq!(power["consistent_rule_fits"], false);
    }
    let files = preloads(&tool, 1);
    for order in [
        ["700", "300", "1100"],
        ["1100", "700", "300"],
        ["300", "1100", "700"],
    ] {
        let mut options = vec!["--area", "361.52"];
        options.extend(order.iter().flat_map(|p| ["--preload", p]));
        let run = tool.run(&calibrate(&files, &options));
        assert!(reasons(&run).contains(&"preloads".to_string()), "{order:?}");
    }
    // An exponent that the loops do not have.
    let run = tool.run(&calibrate(&files, &[&right[..], &["--chi", "4"]].concat()));
    assert_eq!(reasons(&run), ["chi"]);
    assert!((number(&json(&run), "chi_identified") - 1.658).abs() < 0.2);
}

#[test]
fn preload_and_area_have_units() {
    let tool = Tool::new();
    let files = preloads(&tool, 1)[1..2].to_vec();
    let plain = tool.run(&calibrate(
        &files,
        &["--preload", "700", "--area", "361.52"],
    ));
    let plain = json(&plain);
    let kip = (700.0 / 4_448.221_615_260_5).to_string();
    let inches = (361.52 / 645.16).to_string();
    for options in [
        [
            "--preload",
            ".7",
            "--preload-unit",
            "kN",
            "--area",
            "3.6152",
            "--area-unit",
            "cm2",
        ],
        [
            "--preload",
            &kip,
            "--preload-unit",
            "kip",
            "--area",
            &inches,
            "--area-unit",
            "in2",
        ],
    ] {
        let found = json(&tool.run(&calibrate(&files, &options)));
        for key in ["mu", "reference_pressure"] {
            assert!(
                (number(&found, key) / number(&plain, key) - 1.0).abs() < 1e-9,
                "{key}"
            );
        }
    }
    // The units of the loop hold for both.
    let text = tool.read(&files[0]);
    let mut other = String::from("displacement,force\n");
    for line in text.lines().skip(1) {
        let (x, force) = line.split_once(',').expect("two columns");
        let [x, force]: [f64; 2] = [x, force].map(|field| field.parse().expect(field));
        let _ = writeln!(other, "{:e},{:e}", x / 25.4, force / 4_448.221_615_260_5);
    }
    tool.write("inches.csv", &other);
    let inch_files = vec!["inches.csv".to_string()];
    let units = ["--displacement-unit", "in", "--force-unit", "kip"];
    let loads = ["--preload", &kip, "--area", &inches];
    let found = json(&tool.run(&calibrate(&inch_files, &[&units[..], &loads].concat())));
    for key in ["mu", "reference_pressure", "gcr"] {
        assert!(
            (number(&found, key) / number(&plain, key) - 1.0).abs() < 1e-6,
            "{key}"
        );
    }
    // A preload in the wrong unit gives a friction coefficient that none has.
    let run = tool.run(&calibrate(&files, &["--preload", ".7", "--area", "361.52"]));
    assert!(reasons(&run).contains(&"mu".to_string()));
}
