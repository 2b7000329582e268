//! Numbers of any size: finite results or a clear error, and no flag that hosts trap.

mod support;

use mepc::Vector;
use support::flags::raised;
use support::{Point, consistent, decades, segalman, signed, unit, with};

/// Critical slips from 1e-100 to 1e100, slips from 1e-30 to 1e60 of them, pressures up to 1e300; limits that rise, fall, are zero.
fn any_size<const N: usize>(random: &mut fastrand::Rng, props: &[f64]) -> (u32, u32) {
    let gcr = decades(random, -100.0, 100.0);
    let scale = match random.u32(0..3) {
        0 => 1.0,
        1 => decades(random, -300.0, 290.0),
        _ => decades(random, -10.0, 10.0),
    };
    let mut props = with(props, 2, gcr);
    if props.get(4).is_some_and(|p0| *p0 > 0.0) {
        props[4] = scale;
    }
    let mut point = Point::<N>::new(&props);
    let (mut taken, mut refused) = (0, 0);
    let mut pressure = scale;
    for _ in 0..40 {
        let length = match random.u32(0..8) {
            0 => 0.0,
            1 => gcr * decades(random, -30.0, 60.0),
            2 => gcr * decades(random, -200.0, 2.0),
            _ => gcr * decades(random, -3.0, 0.5),
        };
        let slip = Vector::<N>::from_fn(|_, _| length * signed(random));
        pressure = match random.u32(0..16) {
            0 => 0.0,
            1 => scale * decades(random, -40.0, 10.0),
            2..=5 => pressure * (1.0 + 0.3 * signed(random)),
            _ if pressure == 0.0 => scale,
            _ => pressure,
        };
        let factor = if random.u32(0..20) == 0 { 0.0 } else { 1.0 };
        let mut end = vec![f64::NAN; point.state.len()];
        let (result, flags) = raised(|| {
            point
                .law
                .friction(point.gcr, &slip, pressure, factor, &point.state, &mut end)
        });
        let case = format!(
            "{props:?} slip {slip:?} pressure {pressure:e} from {:?}",
            point.state
        );
        assert!(flags == 0 || result.is_err(), "flags {flags:#b}: {case}");
        match result {
            Ok(response) => {
                taken += 1;
                let mut numbers: Vec<f64> = end.clone();
                numbers.extend(response.traction.iter());
                numbers.extend(response.dtraction_dslip.iter());
                numbers.extend(response.dtraction_dpressure.iter());
                numbers.extend(response.elastic_slip.iter());
                numbers.extend([response.stored, response.dissipated]);
                assert!(numbers.iter().all(|number| number.is_finite()), "{case}");
                let limit = end[2];
                let over = if limit > 0.0 {
                    (response.traction / limit).norm()
                } else {
                    0.0
                };
                // Of the smallest numbers few digits are left.
                assert!(over < 1.0 + 1e-10 || limit < 1e-290, "{case}: {over}");
                // What it writes it reads, where the sticking stiffness is still a number.
                if limit > 1e290 * end[12].min(1.0) {
                    point.state = end;
                    continue;
                }
                let mut next = end.clone();
                let zero = Vector::<N>::zeros();
                let (again, flags) = raised(|| {
                    point
                        .law
                        .friction(point.gcr, &zero, pressure, factor, &end, &mut next)
                });
                assert!(
                    again.is_ok() && flags == 0,
                    "{case} and no slip: {again:?} {flags:#b}"
                );
                point.state = end;
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
                assert!(
                    end.iter().all(|number| number.is_nan()),
                    "written although refused: {case}"
                );
                pressure = scale;
            }
        }
    }
    (taken, refused)
}

#[test]
fn numbers_of_any_size_give_finite_results_or_an_error() {
    let seed = 301;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut laws = vec![segalman(-0.6, 0.2)];
    for chi in [1.0, 1.5, 2.5, 3.7] {
        laws.extend([unit(chi), consistent(&unit(chi))]);
    }
    let (mut taken, mut refused) = (0, 0);
    for round in 0..3000 {
        let props = &laws[round % laws.len()];
        for (a, b) in [
            any_size::<1>(&mut random, props),
            any_size::<2>(&mut random, props),
        ] {
            (taken, refused) = (taken + a, refused + b);
        }
    }
    println!("{taken} taken, {refused} refused");
    assert!(taken > 20 * refused, "{taken} taken, {refused} refused");
}
