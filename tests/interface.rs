//! The interface form: opening and jump in, normal and friction traction out.

mod support;

use approx::assert_abs_diff_eq;
use mepc::{InterfaceResponse, Kind, Law, UNKNOWN_OPENING, Vector};
use support::{Point, consistent, decades, power, segalman, signed, state_size, unit, with};

/// A point of the interface form, as a host keeps it.
#[derive(Clone)]
struct Contact<const N: usize> {
    law: Law<N>,
    state: Vec<f64>,
    mu_factor: f64,
}

impl<const N: usize> Contact<N> {
    fn new(props: &[f64]) -> Self {
        let nstate = state_size(N, 24);
        Contact {
            law: Law::new(props, nstate).expect("good properties"),
            state: vec![0.0; nstate],
            mu_factor: 1.0,
        }
    }

    fn trial(&self, normal: f64, jump: [f64; N]) -> (InterfaceResponse<N>, Vec<f64>) {
        let mut end = vec![f64::NAN; self.state.len()];
        let gcr = self.law.critical_slip(0.0).expect("gcr > 0");
        let response = self.law.interface(
            gcr,
            normal,
            &Vector::from(jump),
            self.mu_factor,
            &self.state,
            &mut end,
        );
        (response.expect("a valid opening"), end)
    }

    fn to(&mut self, normal: f64, jump: [f64; N]) -> InterfaceResponse<N> {
        let (response, end) = self.trial(normal, jump);
        self.state = end;
        response
    }
}

/// kn, gap0 and normal exponent.
fn with_normal(props: &[f64], kn: f64, gap0: f64, m: f64) -> Vec<f64> {
    with(&with(&with(props, 7, kn), 8, gap0), 9, m)
}

fn laws() -> Vec<Vec<f64>> {
    vec![
        unit(1.0),
        unit(2.5),
        segalman(-0.6, 0.2),
        consistent(&unit(1.0)),
        consistent(&unit(1.5)),
        consistent(&unit(2.5)),
    ]
}

/// While it stays closed it is p = kn (-gap)^m and the friction form.
#[test]
fn closed_it_is_the_penalty_and_the_friction_form() {
    fn check<const N: usize>(props: &[f64], m: f64) {
        let (kn, gap0) = (20.0, -0.02);
        let props = with_normal(props, kn, gap0, m);
        let mut contact = Contact::<N>::new(&props);
        let mut friction = Point::<N>::with_state_size(&props, state_size(N, 24));
        let mut random = fastrand::Rng::with_seed(301);
        // The first increment of an interference: the critical slip of its pressure is there before.
        friction.step([0.0; N], kn * (-gap0).powf(m));
        for step in 0..300 {
            let normal = 0.018 * random.f64() - 0.1 * random.f64();
            let length = decades(&mut random, -2.0, 0.0);
            let jump: [f64; N] =
                std::array::from_fn(|i| contact.state[7 + i] + length * signed(&mut random));
            let exact = std::array::from_fn(|i| jump[i] - contact.state[7 + i]);
            contact.mu_factor = if step == 0 || random.bool() {
                1.0
            } else {
                random.f64()
            };
            friction.mu_factor = contact.mu_factor;
            let response = contact.to(normal, jump);
            let gap = -(normal + gap0);
            let pressure = kn * gap.powf(m);
            assert_abs_diff_eq!(
                response.normal_traction,
                -pressure,
                epsilon = 1e-13 * pressure
            );
            assert_abs_diff_eq!(
                response.normal_stiffness,
                m * pressure / gap,
                epsilon = 1e-12 * pressure / gap
            );
            assert_abs_diff_eq!(
                response.normal_energy,
                kn * gap.powf(m + 1.0) / (m + 1.0),
                epsilon = 1e-13
            );
            let expected = friction.step(exact, -response.normal_traction);
            assert_eq!(response.friction, expected);
            assert_eq!(contact.state[..6], friction.state[..6]);
            assert_eq!(contact.state[6], normal);
            assert_eq!(contact.state[7..7 + N], jump);
            assert_eq!(contact.state[9..], friction.state[9..]);
        }
    }
    for props in laws() {
        for m in [1.0, 1.5, 2.0] {
            check::<1>(&props, m);
            check::<2>(&props, m);
        }
    }
}

/// Closing within the step: only the part after closing counts, and it is a growth of the limit from that at no pressure.
/// So a step from the moment of closing on is the same, and the share of the jump before it does not matter.
#[test]
fn closing_within_the_step() {
    for cohesion in [0.0, 0.4] {
        for (chi, rule) in [(1.0, 1.0), (1.5, 1.0), (2.5, 1.0), (2.5, 0.0)] {
            let mut props = with_normal(&with(&unit(chi), 5, rule), 50.0, 0.1, 1.0);
            props = with(&props, 12, cohesion);
            let mut contact = Contact::<2>::new(&props);
            contact.to(0.1, [0.3, 0.1]);
            assert_eq!(contact.state[10], 0.0);
            // g0 = .2, g1 = -.05: the part phi = .2.
            let end = [0.3 + 1.5, 0.1 - 0.5];
            let response = contact.to(-0.15, end);
            let (pressure, d) = (50.0 * 0.05, [0.2 * 1.5, 0.2 * -0.5]);
            assert_abs_diff_eq!(response.normal_traction, -pressure, epsilon = 1e-12);
            // By hand: from a point that is closed at next to no pressure.
            let friction_props = with(&with(&unit(chi), 5, rule), 12, cohesion);
            let mut point = Point::<2>::with_state_size(&friction_props, contact.state.len());
            if rule == 1.0 {
                point.step([0.0; 2], 1e-250);
            }
            let expected = point.step(d, pressure);
            assert_abs_diff_eq!(
                response.friction.traction,
                expected.traction,
                epsilon = 1e-12
            );
            assert_abs_diff_eq!(
                response.friction.dissipated,
                expected.dissipated,
                epsilon = 1e-12
            );
            // Straight loading: T u(R) is a straight line as long as nothing slips.
            if rule == 1.0 && cohesion == 0.0 {
                let g = pressure.powf(1.0 / chi);
                let length = d[0].hypot(d[1]);
                assert!(length < g);
                let t = Vector::from(d) * (pressure / g);
                assert_abs_diff_eq!(response.friction.traction, t, epsilon = 1e-12);
                assert_abs_diff_eq!(response.friction.dissipated, 0.0, epsilon = 1e-15);
            }
        }
    }
}

/// Closing in one step, or opened and closed exactly at the gap: how the host cuts the step does not matter (consistent rule).
#[test]
fn the_moment_of_closing_may_be_a_step_of_its_own() {
    let props = with_normal(&consistent(&unit(2.5)), 50.0, 0.1, 1.0);
    let mut whole = Contact::<1>::new(&props);
    whole.to(0.1, [0.3]);
    let mut cut = whole.clone();
    let a = whole.to(-0.15, [1.3]);
    cut.to(-0.1, [0.3 + 0.8]);
    assert_eq!(cut.state[1], 0.0);
    let b = cut.to(-0.15, [1.3]);
    assert_abs_diff_eq!(a.friction.traction, b.friction.traction, epsilon = 1e-13);
    assert_abs_diff_eq!(
        a.friction.dissipated,
        b.friction.dissipated,
        epsilon = 1e-14
    );
    assert_abs_diff_eq!(a.friction.stored, b.friction.stored, epsilon = 1e-14);
}

/// An interference is closed from the first; an opening that the host does not know is a fresh start with the whole jump.
#[test]
fn interference_and_an_unknown_opening() {
    let props = with_normal(&consistent(&unit(2.5)), 50.0, -0.02, 1.0);
    let mut contact = Contact::<1>::new(&props);
    let first = contact.to(0.0, [0.2]);
    let mut point = Point::<1>::new(&consistent(&unit(2.5)));
    assert_abs_diff_eq!(
        first.friction.traction,
        point.step([0.2], 1.0).traction,
        epsilon = 1e-12
    );

    let mut known = Contact::<1>::new(&props);
    known.to(0.5, [0.0]);
    known.state[6] = UNKNOWN_OPENING;
    let response = known.to(-0.03, [0.2]);
    let mut point = Point::<1>::new(&consistent(&unit(2.5)));
    assert_abs_diff_eq!(
        response.friction.traction,
        point.step([0.2], 2.5).traction,
        epsilon = 1e-12
    );
}

/// Open: nothing is remembered but the counters, the openings and the jumps; what was stored is dissipated.
#[test]
fn open_nothing_is_remembered() {
    for props in laws() {
        let mut contact = Contact::<2>::new(&with_normal(&props, 50.0, 0.0, 1.0));
        contact.to(-0.02, [0.1, 0.0]);
        let held = contact.to(-0.02, [0.6, 0.2]).friction.stored;
        let before = contact.state.clone();
        let open = contact.to(0.01, [3.0, -1.0]);
        assert_eq!(
            (open.friction.stored, open.friction.dissipated),
            (0.0, held)
        );
        assert_eq!(
            open.friction.traction.norm() + open.friction.dtraction_dslip.norm(),
            0.0
        );
        assert!(open.normal_traction == 0.0 && open.normal_traction.is_sign_positive());
        let after = &contact.state;
        assert_eq!(after[..4], [0.0; 4]);
        assert_eq!(after[4], before[4] + held);
        assert_eq!(after[5..9], [before[5], 0.01, 3.0, -1.0]);
        assert_eq!(after[11], 2.0);
        assert!(after[9..11].iter().chain(&after[12..]).all(|x| *x == 0.0));
    }
}

/// A host's first iteration starts from touching: no pressure yet, but the stiffness that closes the gap.
#[test]
fn a_point_that_just_touches_is_stiff() {
    let (kn, gap0) = (1e4, 0.125);
    let contact = Contact::<2>::new(&with_normal(&unit(2.5), kn, gap0, 1.0));
    for (normal, stiffness) in [(-gap0, kn), (-gap0 + 1e-9, 0.0), (-gap0 - 1e-9, kn)] {
        let response = contact.trial(normal, [0.2, -0.1]).0;
        assert_eq!(response.normal_stiffness, stiffness);
        assert_eq!(response.normal_traction, (kn * (normal + gap0)).min(0.0));
    }
}

#[test]
fn a_normal_stiffness_is_required() {
    let law = Law::<1>::new(&power(0.3, 1e-3, 2.5), 44).expect("good properties");
    let error = law.interface(
        1e-3,
        -0.1,
        &Vector::from([0.0]),
        1.0,
        &[0.0; 44],
        &mut [0.0; 44],
    );
    let error = error.expect_err("no kn");
    assert_eq!(error.kind, Kind::BadProperty);
    assert!(error.to_string().contains("kn"), "{error}");
}

/// The whole unsymmetric tangent, closing steps included, against central differences.
#[test]
fn tangent_against_differences() {
    fn check<const N: usize>(props: &[f64], m: f64, count: &mut [u32; 2], worst: &mut f64) {
        let props = with_normal(props, 50.0, 0.02, m);
        let mut contact = Contact::<N>::new(&props);
        let mut random = fastrand::Rng::with_seed(302);
        for _ in 0..300 {
            let direction = Vector::<N>::from_fn(|_, _| signed(&mut random)).normalize();
            let length = decades(&mut random, -2.0, 0.3);
            let jump: [f64; N] =
                std::array::from_fn(|i| contact.state[7 + i] + direction[i] * length);
            let normal = -0.02 + 0.06 * (random.f64() - 0.7);
            let (response, end) = contact.trial(normal, jump);
            if response.normal_traction == 0.0 {
                contact.state = end;
                continue;
            }
            let scale = response
                .friction
                .dtraction_dslip
                .norm()
                .max(-response.normal_traction);
            // Rounding asks for long steps, fronts that come and go for short ones.
            let best = |error: &dyn Fn(f64) -> f64| {
                [1e-5, 1e-6, 1e-7]
                    .map(|h| error(h * length))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min)
            };
            let by_opening = best(&|h| {
                let h = h.min(0.01 * (-normal - 0.02));
                let (high, low) = (
                    contact.trial(normal + h, jump).0,
                    contact.trial(normal - h, jump).0,
                );
                let normal_part = (high.normal_traction - low.normal_traction) / (2.0 * h)
                    - response.normal_stiffness;
                let part = (high.friction.traction - low.friction.traction) / (2.0 * h)
                    - response.dtraction_dopening;
                (part.norm() + normal_part.abs())
                    / (response.dtraction_dopening.norm() + response.normal_stiffness)
            });
            let mut errors = vec![by_opening];
            for j in 0..N {
                errors.push(best(&|h| {
                    let at = |h: f64| {
                        let mut moved = jump;
                        moved[j] += h;
                        contact.trial(normal, moved).0
                    };
                    let (high, low) = (at(h), at(-h));
                    // The pressure does not depend on the jump.
                    assert_eq!(high.normal_traction, low.normal_traction);
                    let part = (high.friction.traction - low.friction.traction) / (2.0 * h);
                    (part - response.friction.dtraction_dslip.column(j)).norm() / scale
                }));
            }
            for error in errors {
                count[0] += 1;
                // Fronts or middles that come and go between + and -.
                if error > 1e-5 {
                    count[1] += 1;
                } else {
                    *worst = worst.max(error);
                }
            }
            contact.state = end;
        }
    }
    let (mut line, mut plane, mut worst) = ([0; 2], [0; 2], 0.0);
    for props in laws() {
        for m in [1.0, 1.5] {
            check::<1>(&props, m, &mut line, &mut worst);
            check::<2>(&props, m, &mut plane, &mut worst);
        }
    }
    println!("samples and left out: one direction {line:?}, two {plane:?}; worst {worst:.1e}");
    assert!(100 * line[1] <= line[0] && 100 * plane[1] <= plane[0]);
}
