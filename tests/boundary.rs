//! The real boundary: the built shared library, loaded at run time and called by its C signatures.

mod support;

use mepc::{Law, Vector};
use std::collections::{BTreeMap, BTreeSet};
use std::ptr::{null, null_mut};
use support::native::*;
use support::{HEADER, decades, flags, segalman, signed, state_size, unit, with};

/// The whole numbers that header and module name, by their names in the header: MEPC_x in C, mepc_x in Fortran.
fn constants() -> [BTreeMap<String, i32>; 2] {
    let read = |path| std::fs::read_to_string(path).expect(path);
    let number = |(name, value): (&str, &str)| {
        let value = value.trim().parse().ok()?;
        Some((name.trim().to_uppercase(), value))
    };
    let header = read("include/mepc.h");
    let defined = header.lines().filter_map(|line| {
        let define = line.strip_prefix("#define MEPC_")?;
        number(define.split_once(' ')?)
    });
    let module = read("include/mepc.f90");
    let parameters = module.lines().filter_map(|line| {
        let (_, parameter) = line.split_once("parameter, public :: mepc_")?;
        number(parameter.split("!<").next()?.split_once('=')?)
    });
    let mut constants = [defined.collect(), parameters.collect::<BTreeMap<_, _>>()];
    // What has another name there: no constant is called as a function.
    let abi = constants[1].remove("ABI").expect("mepc_abi");
    constants[1].insert("ABI_VERSION".to_string(), abi);
    // A status that C programs write as 0.
    assert_eq!(constants[1].remove("OK"), Some(0));
    constants
}

#[test]
fn constants_of_header_and_module_are_those_of_the_library() {
    let [header, module] = constants();
    assert_eq!(header, module);
    // SAFETY: no arguments.
    let mut expected = vec![("ABI_VERSION", unsafe { (native().mepc_abi_version)() })];
    expected.extend([
        ("MEMORY_FULL", MEMORY_FULL),
        ("NOT_DESCRIBED", NOT_DESCRIBED),
        ("NULL_POINTER", NULL_POINTER),
        ("BAD_PROPERTY", BAD_PROPERTY),
        ("BAD_STATE", BAD_STATE),
        ("BAD_INPUT", BAD_INPUT),
        ("INTERNAL", INTERNAL),
    ]);
    // The contact status of a point on its way from closing to gross slip, and of the point that opens after that.
    let law = NativeLaw::new(&props(), 1);
    let mut state = vec![0.0; law.nstate];
    for (name, slip, pressure) in [
        ("CONTACT_STICK", 0.0, 50.0),
        ("CONTACT_MICRO_SLIP", 1e-3, 50.0),
        ("CONTACT_GROSS_SLIP", 3e-3, 50.0),
        ("CONTACT_OPEN", 0.0, 0.0),
    ] {
        assert_eq!(law.friction(&[slip], pressure, &mut state).status, 0);
        expected.push((name, state[0] as i32));
    }
    let expected = expected.into_iter().map(|(name, n)| (name.to_string(), n));
    assert_eq!(header, expected.collect());
}

/// Its comments are those of the Rust source: no headings and paths of rustdoc may come along.
#[test]
fn the_header_speaks_c() {
    let header = std::fs::read_to_string("include/mepc.h").expect("the header");
    for rust in ["# Safety", "::", "[`"] {
        assert!(!header.contains(rust), "{rust}");
    }
}

#[test]
fn versions_and_messages() {
    // SAFETY: no arguments, or a number.
    let (abi, version, message) = unsafe {
        let native = native();
        let message = |status| text((native.mepc_status_message)(status)).expect("never NULL");
        let messages: Vec<String> = [
            0,
            MEMORY_FULL,
            NOT_DESCRIBED,
            NULL_POINTER,
            BAD_PROPERTY,
            BAD_STATE,
            BAD_INPUT,
            INTERNAL,
            99,
        ]
        .map(message)
        .to_vec();
        (
            (native.mepc_abi_version)(),
            text((native.mepc_version)()),
            messages,
        )
    };
    assert_eq!(abi, 2);
    assert_eq!(version.as_deref(), Some(env!("CARGO_PKG_VERSION")));
    assert!(message.iter().all(|words| !words.is_empty()));
    assert_eq!(message.iter().collect::<BTreeSet<_>>().len(), message.len());
}

#[test]
fn last_error_is_empty_at_first_and_belongs_to_its_thread() {
    let mine = || new_law(&[0.3], 1, 44).0;
    let thread = std::thread::spawn(move || {
        assert_eq!(last_error(), "");
        assert_eq!(mine(), BAD_PROPERTY);
        let text = last_error();
        // A success does not touch it.
        NativeLaw::new(&props(), 1);
        assert_eq!(last_error(), text);
        text
    });
    let there = thread.join().expect("no panic");
    assert_eq!(new_law(&[0.3, 0.002], 7, 44).0, BAD_INPUT);
    assert_ne!(last_error(), there);
}

/// Calls mepc_law_new; the law, if any, is released by the caller's NativeLaw.
fn new_law(props: &[f64], ndir: i32, nstate: i32) -> (i32, LawPointer) {
    let marker = 0x55 as LawPointer;
    let mut law = marker;
    // SAFETY: as many properties as said, and a place for the law.
    let status = unsafe {
        (native().mepc_law_new)(
            props.as_ptr(),
            props.len() as i32,
            ndir,
            nstate,
            &raw mut law,
        )
    };
    assert_eq!(
        law == marker,
        status != 0,
        "the law is written on success only"
    );
    (status, law)
}

/// A NaN that raises a flag as soon as anybody computes with it or compares it.
fn signalling() -> f64 {
    f64::from_bits(0x7ff4_0000_0000_0000)
}

#[test]
fn bad_properties_are_named_with_their_values() {
    let good = props();
    let refused = |good: &[f64], number: usize, value: f64, name: &str| {
        let bad = with(good, number, value);
        let status = flags::watch(|| new_law(&bad, 2, 84).0);
        assert_eq!(status, BAD_PROPERTY, "{name} = {value}");
        let value = if value.is_nan() {
            "NaN".to_string()
        } else {
            format!("{value:?}")
        };
        let words = format!("PROPS({number}) {name} = {value}");
        assert!(last_error().contains(&words), "{words}: {}", last_error());
    };
    let odd = [f64::NAN, signalling(), f64::INFINITY, f64::NEG_INFINITY];
    for (index, name) in mepc::NAMES.iter().enumerate() {
        for value in odd {
            refused(&good, index + 1, value, name);
        }
    }
    // What must not be negative, and what would overflow.
    for (number, name, largest) in [
        (1, "mu", 1e100),
        (2, "gcr", 1e100),
        (5, "reference_pressure", 1e300),
        (6, "fraction", 1e100),
        (7, "kn", 1e300),
        (12, "cohesion", 1e300),
        (13, "tau_max", 1e300),
        (14, "mu_late", 1e100),
        (15, "slip_late", 1e100),
    ] {
        for value in [-1e-3, -1e300, 1.001 * largest] {
            refused(&good, number, value, name);
        }
    }
    for value in [0.99, -0.5, 2e6] {
        refused(&good, 3, value, "exponent");
    }
    for (number, name) in [(4, "method"), (10, "backbone")] {
        for value in [-1.0, 0.5, 3.0] {
            refused(&good, number, value, name);
        }
    }
    for value in [0.5, -1.0, 101.0] {
        refused(&good, 9, value, "normal_exponent");
    }
    for value in [-1.0, 1e-7, 0.2] {
        refused(&good, 16, value, "resolution");
    }
    for (number, name) in [(17, "reserved17"), (20, "reserved20")] {
        refused(&good, number, 1.0, name);
    }
    refused(&good, 8, 1e101, "gap0");
    refused(&good, 11, 0.5, "beta"); // the power law has none
    // A late friction coefficient and its slip length belong together.
    refused(&with(&good, 14, 0.2), 15, 0.0, "slip_late");
    refused(&with(&good, 15, 0.2), 14, 0.0, "mu_late");
    // Nor does a change of mu mean anything where the critical slip belongs to a limit that is 0.
    let smooth = with(&with(&with(&good, 1, 0.0), 5, 100.0), 15, 1.0);
    refused(&smooth, 14, 0.2, "mu_late");
    // Segalman's backbone: the exponent has no default and another range, beta >= 0, only the proportional rule.
    let segalman = with(&with(&good, 10, 1.0), 3, 1.5);
    assert!(matches!(new_law(&segalman, 1, 44), (0, law) if { free(law); true }));
    for (number, value, name) in [
        (3, 2.5, "exponent"),
        (3, 1.0, "exponent"),
        (3, 0.0, "exponent"),
        (3, -0.5, "exponent"),
        (5, 100.0, "reference_pressure"),
        (11, -0.1, "beta"),
        (11, 2e100, "beta"),
    ] {
        refused(&segalman, number, value, name);
    }
    assert!(!last_error().contains("self-similar"));
    refused(&segalman, 5, 100.0, "reference_pressure");
    assert!(last_error().contains("self-similar"), "{}", last_error());
    // No characteristic length here, so the critical slip must be given; missing entries are 0.
    for short in [&good[..0], &good[..1]] {
        assert_eq!(new_law(short, 1, 44).0, BAD_PROPERTY);
        assert!(
            last_error().contains("PROPS(2) gcr = 0"),
            "{}",
            last_error()
        );
    }
}

/// Zero and a missing entry are the default.
#[test]
fn zero_is_the_default() {
    let given = with(
        &with(&with(&with(&props(), 3, 2.5), 6, 0.005), 9, 1.0),
        16,
        1e-3,
    );
    let zeros = with(&with(&props(), 3, 0.0), 20, 0.0);
    let run = |props: &[f64]| {
        let law = NativeLaw::new(props, 2);
        let mut state = vec![0.0; law.nstate];
        let mut random = fastrand::Rng::with_seed(305);
        let steps = random_inputs(&mut random, 2, 50).into_iter();
        let steps: Vec<Outcome> = steps
            .map(|(slip, pressure)| law.friction(&slip, pressure, &mut state))
            .collect();
        (
            steps,
            law.interface(&[-5e-3, 1e-3, 0.0], &mut vec![0.0; law.nstate]),
        )
    };
    assert!(run(&given) == run(&zeros));
}

fn free(law: LawPointer) {
    // SAFETY: from mepc_law_new, used no more.
    unsafe { (native().mepc_law_free)(law) }
}

#[test]
fn limits_of_nprops_ndir_and_nstate() {
    let good = props();
    for ndir in [0, 3, -1, i32::MAX, i32::MIN] {
        assert_eq!(new_law(&good, ndir, 84).0, BAD_INPUT);
        assert!(
            last_error().contains(&format!("ndir = {ndir}")),
            "{}",
            last_error()
        );
        assert_eq!(default_size(&good, ndir), BAD_INPUT);
    }
    for (ndir, least) in [(1, 20), (2, 24)] {
        for nstate in [-1, i32::MIN, 1_000_001, i32::MAX, 0, 1, least - 1] {
            assert_eq!(new_law(&good, ndir, nstate).0, BAD_STATE);
            let words = format!("nstate = {nstate}:");
            assert!(last_error().contains(&words), "{}", last_error());
        }
        assert!(
            last_error().contains(&least.to_string()),
            "{}",
            last_error()
        );
        for nstate in [least, least + 1, 1000, 1_000_000] {
            let (status, law) = new_law(&good, ndir, nstate);
            assert_eq!(status, 0);
            free(law);
        }
    }
    // A host's own entries follow the common ones.
    let mut long = with(&good, 20, 0.0);
    long.extend([9.0, f64::NAN, signalling(), -3.0]);
    let (status, law) = flags::watch(|| new_law(&long, 2, 84));
    assert_eq!(status, 0, "{}", last_error());
    free(law);
    // SAFETY: negative and null are refused before anything is read; NULL is released without effect.
    unsafe {
        let mut law = null_mut();
        assert_eq!(
            (native().mepc_law_new)(good.as_ptr(), -1, 1, 44, &raw mut law),
            BAD_INPUT
        );
        assert!(last_error().contains("nprops = -1"), "{}", last_error());
        assert_eq!(
            (native().mepc_law_new)(null(), 3, 1, 44, &raw mut law),
            NULL_POINTER
        );
        assert!(last_error().contains("props"), "{}", last_error());
        assert_eq!(
            (native().mepc_law_new)(good.as_ptr(), 3, 1, 25, null_mut()),
            NULL_POINTER
        );
        assert!(last_error().contains("law"), "{}", last_error());
        assert!(law.is_null());
        assert_eq!((native().mepc_state_size)(null(), 3, 1), NULL_POINTER);
        assert_eq!((native().mepc_state_size)(good.as_ptr(), -1, 1), BAD_INPUT);
        (native().mepc_law_free)(null_mut());
    }
}

fn default_size(props: &[f64], ndir: i32) -> i32 {
    // SAFETY: as many properties as said.
    unsafe { (native().mepc_state_size)(props.as_ptr(), props.len() as i32, ndir) }
}

#[test]
fn state_size_is_the_default_of_the_table() {
    for props in [unit(2.5), segalman(-0.5, 0.0), with(&unit(2.5), 5, 1.0)] {
        assert_eq!(default_size(&props, 1), 44);
        assert_eq!(default_size(&props, 2), 84);
    }
    // A host with a characteristic length asks before it knows the length.
    assert_eq!(default_size(&[0.3, 0.0], 2), 84);
    assert_eq!(default_size(&[0.3], 1), 44);
    assert_eq!(default_size(&[-0.3, 0.002], 1), BAD_PROPERTY);
}

#[test]
fn state_names_are_the_table() {
    let header = [
        "ContactStatus",
        "Pressure",
        "ShearLimit",
        "StoredEnergy",
        "DissipatedEnergy",
        "SlipLength",
        "NormalOpening",
        "TangentialJump1",
        "TangentialJump2",
        "Forgotten",
        "Knots",
        "Layout",
    ];
    for (ndir, nstate) in [
        (1, 44),
        (2, 84),
        (1, 20),
        (2, 25),
        (1, 300),
        (2, 300),
        (2, 1_000_000),
    ] {
        let law = NativeLaw::with_state_size(&unit(2.5), ndir, nstate);
        let mut expected: Vec<String> = header.map(String::from).to_vec();
        for knot in 1..=((nstate - 12) / (1 + ndir)).min(64) {
            expected.push(format!("Knot{knot}_R"));
            expected.extend((1..=ndir).map(|direction| format!("Knot{knot}_u{direction}")));
        }
        // SAFETY: a law.
        let name = |index: i32| text(unsafe { (native().mepc_state_name)(law.pointer, index) });
        let names: Vec<String> = (0..).map_while(name).collect();
        assert_eq!(names.len(), nstate);
        assert_eq!(names[..expected.len()], expected[..]);
        assert_eq!(
            names.iter().collect::<BTreeSet<_>>().len(),
            nstate,
            "names are unique"
        );
        for past in [nstate as i32, -1, i32::MAX, i32::MIN] {
            assert_eq!(name(past), None);
        }
    }
    // SAFETY: NULL is allowed.
    let name = unsafe { (native().mepc_state_name)(null_mut(), 0) };
    assert_eq!(text(name), None);
}

/// A state in the middle of a history.
fn used_state(law: &NativeLaw) -> Vec<f64> {
    let mut state = vec![0.0; law.nstate];
    for slip in [1.6e-3, -2.0e-3, 1.1e-3, -0.6e-3] {
        let out = law.friction(&vec![slip; law.ndir], 40.0, &mut state);
        assert_eq!(out.status, 0);
    }
    assert!(state[10] >= 3.0);
    state
}

/// How a call is spoiled, under the name of the argument.
type Spoiled<'a, C> = (&'a str, &'a dyn Fn(&mut C));

/// What a call may be given NULL for, all after state1 and traction, changes nothing else; for what it may not: -1, the
/// argument's name, and nothing written.
fn check_null_rules<C: WatchedCall>(good: impl Fn() -> C, inputs: &[Spoiled<C>]) {
    let mut all = good();
    assert_eq!(all.call(), 0);
    let expected = all.values();
    assert!(all.outputs().iter().flatten().all(|o| !o.untouched()));
    assert!(
        (expected.iter().flatten()).all(|x| x.is_finite() && x.abs() < 1e9),
        "all of it was written"
    );
    for left_out in 0..1 << (expected.len() - 2) {
        let mut some = good();
        for (bit, output) in some.outputs()[2..].iter_mut().enumerate() {
            if left_out & (1 << bit) != 0 {
                *output = None;
            }
        }
        assert_eq!(some.call(), 0);
        for (output, expected) in some.outputs().iter().zip(&expected) {
            assert!(output.as_ref().is_none_or(|o| o.values() == expected));
        }
    }
    let refused = |name: &str, change: &dyn Fn(&mut C)| {
        let mut bad = good();
        change(&mut bad);
        assert_eq!(bad.call(), NULL_POINTER, "{name}");
        let words = format!("{name} = NULL");
        assert!(last_error().contains(&words), "{}", last_error());
        assert!(bad.untouched(), "{name}");
    };
    for (name, change) in inputs {
        refused(name, change);
    }
    refused("state1", &|bad| bad.outputs()[0] = None);
    refused("traction", &|bad| bad.outputs()[1] = None);
}

#[test]
fn friction_null_rules_and_canaries() {
    for ndir in [1, 2] {
        let law = NativeLaw::new(&props(), ndir);
        let (slip, state0) = (vec![4e-4; ndir], used_state(&law));
        check_null_rules(
            || FrictionCall::new(&law, &slip, 50.0, &state0),
            &[
                ("law", &|bad: &mut FrictionCall| bad.law = null_mut()),
                ("slip_increment", &|bad: &mut FrictionCall| bad.slip = None),
                ("state0", &|bad: &mut FrictionCall| bad.state0 = None),
            ],
        );
    }
}

#[test]
fn interface_null_rules_and_canaries() {
    for ndir in [1, 2] {
        let law = NativeLaw::new(&props(), ndir);
        let (opening, state0) = ([-5e-3, 4e-4, -3e-4], used_state(&law));
        check_null_rules(
            || InterfaceCall::new(&law, &opening[..=ndir], &state0),
            &[
                ("law", &|bad: &mut InterfaceCall| bad.law = null_mut()),
                ("opening", &|bad: &mut InterfaceCall| bad.opening = None),
                ("state0", &|bad: &mut InterfaceCall| bad.state0 = None),
            ],
        );
    }
}

#[test]
fn bad_inputs_and_states_leave_the_outputs_alone() {
    for ndir in [1, 2] {
        let law = NativeLaw::new(&props(), ndir);
        let (slip, state0) = (vec![4e-4; ndir], used_state(&law));
        let refused = |status: i32, words: &str, call: &mut FrictionCall| {
            assert_eq!(call.call(), status, "{words}");
            assert!(last_error().contains(words), "{words}: {}", last_error());
            assert!(call.untouched(), "{words}");
        };
        for value in [f64::NAN, signalling(), f64::INFINITY, f64::NEG_INFINITY] {
            refused(
                BAD_INPUT,
                &format!("pressure = {value}"),
                &mut FrictionCall::new(&law, &slip, value, &state0),
            );
            let mut call = FrictionCall::new(&law, &slip, 50.0, &state0);
            call.mu_factor = Some(value);
            refused(BAD_INPUT, &format!("mu_factor = {value}"), &mut call);
            for index in 0..ndir {
                let mut bad = slip.clone();
                bad[index] = value;
                let words = format!("slip_increment[{index}] = {value}");
                refused(
                    BAD_INPUT,
                    &words,
                    &mut FrictionCall::new(&law, &bad, 50.0, &state0),
                );
            }
            // Slots past the last knot are not looked at.
            for slot in 0..HEADER + state0[10] as usize * (1 + ndir) {
                let mut bad = state0.clone();
                bad[slot] = value;
                let words = format!("state[{slot}] ");
                refused(
                    BAD_STATE,
                    &words,
                    &mut FrictionCall::new(&law, &slip, 50.0, &bad),
                );
            }
            for index in 0..=ndir {
                let mut bad = vec![-5e-3; 1 + ndir];
                bad[index] = value;
                let mut call = InterfaceCall::new(&law, &bad, &state0);
                assert_eq!(call.call(), BAD_INPUT);
                assert!(
                    last_error().contains(&format!("{value}")),
                    "{}",
                    last_error()
                );
                assert!(call.untouched());
            }
        }
        // Finite numbers whose results are not.
        let mut call = FrictionCall::new(&law, &slip, 50.0, &state0);
        call.mu_factor = Some(-1e-3);
        refused(BAD_INPUT, "mu_factor = -0.001", &mut call);
        for (slip, pressure) in [(1e200, 50.0), (-1e300, 50.0), (4e-4, f64::MAX)] {
            let slip = vec![slip; ndir];
            let mut call = FrictionCall::new(&law, &slip, pressure, &state0);
            assert_eq!(call.call(), BAD_INPUT);
            assert!(call.untouched());
        }
        // The interface form names its own argument, and the value that was passed.
        let good = vec![-5e-3; 1 + ndir];
        for index in 0..=ndir {
            for value in [f64::NAN, f64::NEG_INFINITY, -1e308] {
                let mut opening = good.clone();
                opening[index] = value;
                let mut call = InterfaceCall::new(&law, &opening, &state0);
                assert_eq!(call.call(), BAD_INPUT);
                let words = format!("opening[{index}] = {value:?}");
                assert!(last_error().contains(&words), "{words}: {}", last_error());
                assert!(call.untouched());
            }
        }
        // The interface form needs a normal stiffness, and one that its tangent can hold.
        let opening = vec![-5e-3; 1 + ndir];
        let law_without = NativeLaw::new(&with(&props(), 7, 0.0), ndir);
        let mut call = InterfaceCall::new(&law_without, &opening, &state0);
        assert_eq!(call.call(), BAD_PROPERTY);
        assert!(last_error().contains("kn = 0"), "{}", last_error());
        assert!(call.untouched());
        // The law and the state are as good as before.
        let mut good = FrictionCall::new(&law, &slip, 50.0, &state0);
        assert_eq!(good.call(), 0);
    }
}

#[test]
fn memory_full_is_an_advice_and_the_outputs_are_written() {
    let law = NativeLaw::with_state_size(&props(), 1, state_size(1, 4));
    let mut state = vec![0.0; law.nstate];
    let mut statuses = Vec::new();
    let mut at = 0.0;
    for k in 0..8 {
        let target = 0.0018 * (-0.8f64).powi(k);
        let before = state.clone();
        let slip = [target - at];
        let mut call = FrictionCall::new(&law, &slip, 50.0, &before);
        statuses.push(call.call());
        assert!(
            call.outputs
                .iter()
                .flatten()
                .all(|output| !output.untouched())
        );
        state.copy_from_slice(call.outputs[0].as_ref().expect("state1").values());
        at = target;
    }
    assert_eq!(statuses[..2], [0, 0]);
    assert!(statuses[2..].contains(&MEMORY_FULL), "{statuses:?}");
    assert!(
        statuses
            .iter()
            .all(|status| [0, MEMORY_FULL].contains(status))
    );
}

/// The C interface is the Rust one: same numbers, matrices row by row; state0 may be state1.
#[test]
fn the_library_is_the_crate() {
    fn check<const N: usize>(props: &[f64], random: &mut fastrand::Rng) {
        let native = NativeLaw::new(props, N);
        let law = Law::<N>::new(props, native.nstate).expect("good properties");
        let gcr = law.critical_slip(0.0).expect("gcr > 0");
        let (mut mine, mut theirs) = (vec![0.0; native.nstate], vec![0.0; native.nstate]);
        for (slip, pressure) in random_inputs(random, N, 300) {
            let mut end = vec![0.0; native.nstate];
            let slip_vector = Vector::<N>::from_column_slice(&slip);
            let response = law
                .friction(gcr, &slip_vector, pressure, 1.0, &mine, &mut end)
                .expect("valid");
            mine = end;
            // Aliased: the state is its own successor. Separate: as the watched outputs say.
            let start = theirs.clone();
            let mut separate = FrictionCall::new(&native, &slip, pressure, &start);
            assert!(separate.call() >= 0);
            let out = native.friction(&slip, pressure, &mut theirs);
            assert_eq!(
                separate.outputs[0].as_ref().expect("state1").values(),
                theirs
            );
            assert_eq!(
                separate.outputs[1].as_ref().expect("traction").values(),
                out.traction
            );

            close(&theirs, &mine, 1e-9);
            close(&out.traction, response.traction.as_slice(), 1e-9);
            close(
                &out.tangent,
                response.dtraction_dslip.transpose().as_slice(),
                1e-6,
            );
            close(
                &out.dtraction_dpressure,
                response.dtraction_dpressure.as_slice(),
                1e-9,
            );
            close(&out.energy, &[response.stored, response.dissipated], 1e-9);
            assert_eq!(out.status, i32::from(response.memory_full));

            let normal = -0.011 * random.f64();
            let mut opening = vec![normal];
            opening.extend(&slip);
            let (mut start, mut end) = (theirs.clone(), mine.clone());
            let response = law
                .interface(gcr, normal, &slip_vector, 1.0, &mine, &mut end)
                .expect("valid");
            let out = native.interface(&opening, &mut start);
            close(&start, &end, 1e-9);
            let mut tangent = vec![response.normal_stiffness];
            tangent.extend([0.0; N]);
            for i in 0..N {
                tangent.push(response.dtraction_dopening[i]);
                tangent.extend(response.friction.dtraction_dslip.row(i).iter());
            }
            close(&out.tangent, &tangent, 1e-6);
            assert_eq!(out.traction[0], response.normal_traction);
            close(
                &out.traction[1..],
                response.friction.traction.as_slice(),
                1e-9,
            );
            // The penalty's spring holds energy, too.
            let stored = response.friction.stored + response.normal_energy;
            close(&out.energy, &[stored, response.friction.dissipated], 1e-9);
        }
    }
    // Two builds of one source may differ in the last bits.
    fn close(a: &[f64], b: &[f64], part: f64) {
        let scale = b.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
        assert_eq!(a.len(), b.len());
        assert!(
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= part * scale),
            "{a:?} {b:?}"
        );
    }
    let seed = 301;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for props in [
        props(),
        with(&props(), 5, 20.0),
        with(&with(&props(), 10, 1.0), 3, 1.6),
    ] {
        check::<1>(&props, &mut random);
        check::<2>(&props, &mut random);
    }
}

#[test]
fn several_threads_share_a_law() {
    let law = NativeLaw::new(&props(), 2);
    let history = random_inputs(&mut fastrand::Rng::with_seed(303), 2, 2000);
    let run = || -> Vec<Outcome> {
        let mut state = vec![0.0; law.nstate];
        history
            .iter()
            .map(|(slip, pressure)| law.friction(slip, *pressure, &mut state))
            .collect()
    };
    let expected = run();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        for worker in workers {
            assert!(worker.join().expect("no panic") == expected);
        }
    });
}

/// However long the array: 64 knots are used, the rest is zero and not looked at.
#[test]
fn long_states_use_sixty_four_knots() {
    for (ndir, used) in [(1, 12 + 64 * 2), (2, 12 + 64 * 3)] {
        let law = NativeLaw::with_state_size(&props(), ndir, used + 50);
        let mut state = vec![0.0; law.nstate];
        let mut at = 0.0;
        let mut full = 0;
        for k in 0..90 {
            let target = 0.0019 * (-0.97f64).powi(k);
            let slip = vec![(target - at) / (ndir as f64).sqrt(); ndir];
            let status = law.friction(&slip, 50.0, &mut state).status;
            full += i32::from(status == MEMORY_FULL);
            at = target;
            // What is not used may hold anything.
            assert!(state[used..].iter().all(|x| *x == 0.0));
            state[used..].fill(f64::NAN);
        }
        assert_eq!(state[10], 64.0);
        assert!(ndir == 2 || full > 10, "{full}");
    }
}

/// Hosts that are built to stop at a division by zero, an invalid operation or an overflow must not stop here. In the
/// built library: compilers compute both sides of a choice. (Every accepted call of these tests is watched, see `flags`;
/// here are the histories that look for trouble.)
#[test]
fn no_update_raises_a_flag_that_hosts_trap() {
    let seed = 20_261_127;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let curves = [
        unit(1.0),
        unit(1.5),
        unit(2.5),
        unit(3.3),
        unit(1e6),
        segalman(-0.6, 0.2),
        segalman(0.0, 0.0),
        segalman(-0.9999, 1e6),
        with(&with(&unit(2.5), 12, 0.3), 13, 1.2),
        with(&with(&unit(1.5), 14, 0.4), 15, 3.0),
    ];
    let cases = curves.iter().flat_map(|curve| {
        let methods = [0.0, 1.0, 2.0].map(|method| with(curve, 4, method));
        // Segalman's backbone has the proportional rule only.
        let pressures = if curve.get(9) == Some(&1.0) {
            [0.0; 2]
        } else {
            [0.0, 1.0]
        };
        let rules = methods.map(|props| pressures.map(|p0| with(&props, 5, p0)));
        rules
            .into_iter()
            .flatten()
            .map(|props| with(&props, 7, 10.0))
    });
    for (props, ndir) in cases.flat_map(|props| [(props.clone(), 1), (props, 2)]) {
        let nstate = state_size(ndir, 6) + 1;
        let make = || NativeLaw::with_state_size(&props, ndir, nstate);
        let law = flags::watch(make);
        let (mut state, mut closed) = (vec![0.0; law.nstate], vec![0.0; law.nstate]);
        let mut opening = vec![0.0; 1 + ndir];
        for _ in 0..4000 {
            // Steps on a lattice fall exactly on limits, on fronts and on each other; the others on nothing.
            let mut slip: Vec<f64> = (0..ndir)
                .map(|_| match random.u32(0..8) {
                    0 => 0.0,
                    1 => decades(&mut random, -12.0, 3.0) * signed(&mut random),
                    _ => 0.125 * f64::from(random.i32(-6..=6)),
                })
                .collect();
            if ndir == 2 && random.u32(0..4) == 0 {
                // Next to nothing, across the last element's deflection: the curve then lies along its limits.
                let across = decades(&mut random, -20.0, -8.0) * signed(&mut random);
                let last = (state[10] as usize).max(1) - 1;
                let top = &state[HEADER + 3 * last + 1..][..2];
                slip = vec![-across * top[1], across * top[0]];
            }
            let pressure = [0.0, 0.5, 1.0, 1.0, 1.0, 2.0][random.usize(0..6)];
            assert!(
                law.friction(&slip, pressure, &mut state).status >= 0,
                "{}",
                last_error()
            );
            opening[0] = match random.u32(0..20) {
                0 => 1e150,
                _ => 0.1 * (0.5 - random.f64()),
            };
            for (total, slip) in opening[1..].iter_mut().zip(&slip) {
                *total += slip;
            }
            assert!(
                law.interface(&opening, &mut closed).status >= 0,
                "{}",
                last_error()
            );
        }
    }
}
