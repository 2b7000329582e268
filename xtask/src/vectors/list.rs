//! What the vectors are.

use super::closed_forms::{
    gross_slip_under_falling_pressure, loading_after_pressure_rise, opening, proportional_rule,
};
use super::paths::{PLACES, branches, circle, figure_eight, plane, random_walk, square};
use super::vector::{Energies, Law, Step, Vector};
use crate::generated::decimals;

pub fn all() -> Vec<Vector> {
    let mut vectors = first_loading_and_cycles();
    vectors.extend(memory());
    vectors.extend(boundaries());
    vectors.extend(changing_pressure());
    vectors.extend(two_directions());
    vectors.extend(other_methods());
    vectors
}

fn first_loading_and_cycles() -> Vec<Vector> {
    let path = [0.0, 0.5, -0.5, 1.5, -1.5, 0.25];
    let mut vectors = Vec::new();
    for chi in [1.0, 1.5, 2.0, 2.5, 3.0, 3.7, 6.0] {
        let gcr = 0.00268;
        vectors.push(Vector::straight(
            format!("cycle_chi_{chi}"),
            "first loading, a partial and a full cycle, power law",
            Law::power(0.3, gcr, chi),
            12.5,
            &branches(gcr, &path, 5),
        ));
    }
    for (c, beta) in [(-0.842, 0.5), (-0.5, 0.0), (-0.2, 1.0), (0.0, 0.0)] {
        let gcr = 0.0041;
        vectors.push(Vector::straight(
            format!("cycle_segalman_{c}_{beta}"),
            "first loading, a partial and a full cycle, Segalman's backbone",
            Law::segalman(0.42, gcr, c, beta),
            2.5,
            &branches(gcr, &path, 5),
        ));
    }
    vectors
}

fn memory() -> Vec<Vector> {
    let (mu, gcr, chi) = (0.3, 0.002, 2.5);
    let law = || Law::power(mu, gcr, chi);
    vec![
        Vector::straight(
            "nested_path",
            "verification item 2: a nested loop closes, the outer one goes on, gross slip",
            law(),
            10.0,
            &branches(gcr, &[0.0, 0.8, -0.2, 0.3, -0.2, -0.8, -1.0], 1),
        ),
        Vector::straight(
            "nested_path_small_steps",
            "the same turning points in 20 steps a branch",
            law(),
            10.0,
            &branches(gcr, &[0.0, 0.8, -0.2, 0.3, -0.2, -0.8, -1.0], 20),
        ),
        Vector::straight(
            "slide_and_back",
            "verification item 3: gross slip moves the origin",
            law(),
            10.0,
            &branches(gcr, &[0.0, 5.0, 3.0, 2.0, 3.2, 2.5], 4),
        ),
        Vector::straight(
            "memory_full_two_slots",
            "exactly as many reversals as the smallest state array holds, and zero increments there",
            law().nstate(13),
            10.0,
            &branches(
                gcr,
                &[0.0, 2.0, 1.0, 1.6, 1.6, 2.0, 3.0, 1.4, 2.6, 2.6, 3.0, 3.5],
                3,
            ),
        ),
        Vector::straight(
            "memory_full_default",
            "exactly as many reversals as the default state array holds, a pause, and all loops closed again",
            law(),
            10.0,
            &branches(
                gcr,
                &[
                    0.0, 2.0, 0.2, 1.8, 0.4, 1.6, 0.6, 1.4, 0.8, 1.2, 1.2, 1.4, 1.6, 1.8, 2.0, 3.0,
                ],
                2,
            ),
        ),
    ]
}

fn boundaries() -> Vec<Vector> {
    let (mu, gcr) = (0.2, 0.002);
    let law = || Law::power(mu, gcr, 2.5);
    let mut to_gcr_in_tenths = branches(gcr, &[0.0, 1.0, 1.0, -1.0], 10);
    to_gcr_in_tenths.extend(branches(gcr, &[1.0, 0.0, 1.0], 1));
    vec![
        Vector::straight(
            "slip_exactly_gcr",
            "slip of exactly gcr at once, and of exactly 2 gcr back",
            law(),
            25.0,
            &branches(gcr, &[0.0, 1.0, -1.0, 1.0, 0.0, 1.0], 1),
        ),
        Vector::straight(
            "slip_exactly_gcr_in_steps",
            "the same in ten steps",
            law(),
            25.0,
            &to_gcr_in_tenths,
        ),
        Vector::straight(
            "zero_increments",
            "nothing moves: at the start, on first loading, after a reversal, in gross slip",
            law(),
            25.0,
            &branches(
                gcr,
                &[0.0, 0.0, 0.4, 0.4, -0.1, -0.1, 0.2, 0.2, 1.4, 1.4, 1.1, 1.1],
                2,
            ),
        ),
        Vector::straight(
            "reversal_at_origin",
            "reversals exactly at zero slip",
            law(),
            25.0,
            &branches(
                gcr,
                &[0.0, 0.5, 0.0, 0.5, 0.0, -0.5, 0.0, -0.5, 0.0, 0.75, 0.0],
                2,
            ),
        ),
        Vector::straight(
            "tiny_slips",
            "slips of 1e-9 gcr",
            law(),
            25.0,
            &[0.0, 2e-12, -2e-12, 1e-12, -1e-12, 2e-12, 3e-12],
        )
        .tolerance(1e-14, 0.0)
        .energies(Energies::None),
        // 2.5 a^3 = 2.5e-18 a cycle, asked for to six digits: wrong by orders when integrals of f are subtracted
        // carelessly.
        Vector::straight(
            "small_cycles",
            "cycles of 1e-6 gcr: the dissipation keeps its leading digits",
            law(),
            25.0,
            &branches(gcr, &[0.0, 1e-6, -1e-6, 1e-6, -1e-6, 1e-6], 1),
        )
        .tolerance(1e-14, 2.5e-24)
        .energies(Energies::Dissipated),
        // One unit in the last place of a slip of 2 mm is 2e-13 gcr.
        Vector::straight(
            "huge_slip",
            "1000 gcr in one step, a small reversal there, and back",
            law(),
            25.0,
            &branches(
                gcr,
                &[0.0, 1000.0, 999.5, 1000.0, -1000.0, -999.0, -1000.5],
                1,
            ),
        )
        .tolerance(2e-12, 1e-9),
        opening(law()),
    ]
}

fn changing_pressure() -> Vec<Vector> {
    let (mu, gcr) = (0.3, 0.002);
    let steps = |rows: &[(f64, f64)]| -> Vec<Step> {
        rows.iter()
            .map(|&(s, pressure)| Step {
                slip: [decimals(s * gcr, PLACES), 0.0],
                pressure,
            })
            .collect()
    };
    let penalty = || Law::power(mu, gcr, 1.0);
    vec![
        Vector::twin(
            "pressure_rise_penalty",
            "verification item 11: the pressure doubles at fixed slip, slip returns, the pressure halves",
            penalty(),
            1,
            steps(&[(0.0, 1.0), (0.5, 1.0), (0.5, 2.0), (0.0, 2.0), (0.0, 1.0)]),
        ),
        Vector::twin(
            "pressure_fall_penalty",
            "verification item 11: the pressure halves at fixed slip, slip returns",
            penalty(),
            1,
            steps(&[(0.0, 2.0), (0.5, 2.0), (0.5, 1.0), (0.0, 1.0)]),
        ),
        gross_slip_under_falling_pressure(Law::power(mu, gcr, 2.5)),
        loading_after_pressure_rise(Law::power(mu, gcr, 2.5)),
        proportional_rule(Law {
            rule: 1,
            ..Law::power(mu, gcr, 2.5)
        }),
        Vector::twin(
            "pressure_proportional_energy",
            "the proportional rule books energy it creates as negative dissipation",
            Law {
                rule: 1,
                ..Law::power(mu, gcr, 2.5)
            },
            1,
            steps(&[
                (0.0, 5.0),
                (0.6, 5.0),
                (0.6, 12.0),
                (-0.1, 12.0),
                (-0.1, 4.0),
                (0.3, 4.0),
                (0.3, 9.0),
                (2.0, 9.0),
                (2.0, 3.0),
                (1.1, 3.0),
            ]),
        ),
        Vector::twin(
            "pressure_steps",
            "the pressure rises and falls between and during straight slips, dissipative rule",
            Law::power(mu, gcr, 2.5).nstate(137),
            1,
            steps(&[
                (0.0, 5.0),
                (0.6, 5.0),
                (0.6, 12.0),
                (0.7, 12.0),
                (-0.1, 12.0),
                (-0.1, 4.0),
                (0.3, 4.0),
                (0.35, 9.0),
                (0.35, 11.0),
                (0.2, 15.0),
                (2.0, 9.0),
                (2.0, 13.0),
                (1.1, 3.0),
                (1.4, 20.0),
            ]),
        ),
    ]
}

fn two_directions() -> Vec<Vector> {
    let (mu, gcr, p) = (0.37, 0.00268, 1.64);
    let law = |chi: f64| Law::power(mu, gcr, chi);
    let nested = branches(
        gcr,
        &[0.0, 0.8, -0.2, 0.3, -0.2, -0.8, -1.7, 0.1, -0.5, 0.4],
        4,
    );
    let diagonal = std::f64::consts::FRAC_1_SQRT_2;
    let mut vectors: Vec<Vector> = [
        ("oblique_axis", [0.0, 1.0]),
        ("oblique_45", [diagonal, diagonal]),
        ("oblique_3_4_5", [0.6, -0.8]),
        ("oblique_7_24_25", [-0.28, -0.96]),
    ]
    .into_iter()
    .map(|(name, direction)| {
        Vector::oblique(
            name,
            "verification item 8: a straight history across the axes",
            law(2.5),
            p,
            &nested,
            Some(direction),
        )
    })
    .collect();

    let curves = [
        (
            "circle_small",
            "radial start and three turns of radius gcr/2",
            law(2.5),
            circle(0.5, 3, 90),
        ),
        (
            "circle_large",
            "radial start and two turns of radius 2 gcr",
            law(2.5),
            circle(2.0, 2, 120),
        ),
        (
            "circle_chi_1.5",
            "radial start and two turns of radius 0.7 gcr, Mindlin's exponent",
            law(1.5),
            circle(0.7, 2, 90),
        ),
        (
            "circle_chi_4",
            "radial start and two turns of radius 0.7 gcr, chi = 4",
            law(4.0),
            circle(0.7, 2, 90),
        ),
        (
            "circle_segalman",
            "radial start and two turns of radius 1.2 gcr, Segalman's backbone",
            Law::segalman(mu, gcr, -0.5, 0.3),
            circle(1.2, 2, 90),
        ),
        (
            "figure_eight",
            "two turns of a figure of eight",
            law(2.5),
            figure_eight(1.1, 2, 120),
        ),
        (
            "square",
            "two turns about a square of half side 0.6 gcr",
            law(2.5),
            square(0.6, 2, 15),
        ),
        (
            "random_walk",
            "300 random steps of up to 0.25 gcr in each direction",
            law(2.5),
            random_walk(300, 0.25),
        ),
    ];
    for (name, about, law, points) in curves {
        vectors.push(Vector::twin(name, about, law, 2, plane(gcr, p, points)));
    }

    let fine = Law {
        base_knots: 64,
        ..law(2.5).nstate(160)
    };
    let mut fine = Vector::twin(
        "circle_64_base_knots",
        "radial start and three turns of radius gcr/2 with the finest base grid",
        fine,
        2,
        plane(gcr, p, circle(0.5, 3, 90)),
    );
    fine.tolerance.traction = 1e-3;
    fine.tolerance.stored = 1e-3;
    vectors.push(fine);

    let pressure = |k: usize| decimals(p * (1.0 + 0.5 * (k as f64 / 25.0).sin()), 6);
    let points = figure_eight(0.9, 2, 120);
    let mut steps = plane(gcr, p, points);
    for (k, step) in steps.iter_mut().enumerate() {
        step.pressure = pressure(k);
    }
    vectors.push(Vector::twin(
        "figure_eight_pressure",
        "two turns of a figure of eight while the pressure rises and falls",
        law(2.5),
        2,
        steps,
    ));
    vectors
}

fn other_methods() -> Vec<Vector> {
    let (mu, gcr, p) = (0.42, 0.00268, 2.5);
    let penalty = || Law {
        method: 1,
        ..Law::power(mu, gcr, 2.5)
    };
    vec![
        Vector::straight(
            "method_penalty",
            "method 1 is the straight line to gcr whatever chi says",
            penalty(),
            p,
            &branches(gcr, &[0.0, 0.5, -0.5, 1.5, -1.5, 0.25], 5),
        ),
        Vector::twin(
            "method_penalty_circle",
            "method 1 around a circle",
            penalty(),
            2,
            plane(gcr, p, circle(1.5, 2, 60)),
        ),
        Vector::straight(
            "frictionless",
            "mu = 0: no traction, no energy",
            Law::power(0.0, gcr, 2.5),
            p,
            &branches(gcr, &[0.0, 0.5, -0.5, 1.5, -1.5, 0.25], 5),
        ),
    ]
}
