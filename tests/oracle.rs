//! The kernel against the plain law of `mepc-oracle`, on random histories.

mod support;

use mepc::Vector;
use mepc_oracle::law::{self, Knot};
use mepc_oracle::limit::Limit;
use mepc_oracle::{Backbone, Status};
use support::{Point, decades, segalman, signed, unit, with};

/// The oracle's law for the properties of a point with mu = gcr = 1.
fn plain(props: &[f64], room: usize) -> law::Law {
    let entry = |number: usize| props.get(number - 1).copied().unwrap_or(0.0);
    let backbone = if entry(4) > 0.0 {
        Backbone::PENALTY
    } else if entry(10) == 1.0 {
        Backbone::Segalman { c: entry(3) - 2.0, beta: entry(11) }
    } else {
        Backbone::Power { chi: entry(3) }
    };
    law::Law {
        backbone,
        limit: Limit {
            mu: entry(1),
            cohesion: entry(12),
            cap: if entry(13) > 0.0 { entry(13) } else { f64::INFINITY },
            run_in: (entry(14) > 0.0).then_some((entry(14), entry(15))),
        },
        gcr: entry(2),
        reference_pressure: entry(5),
        room,
        resolution: if entry(16) > 0.0 { entry(16) } else { 1e-3 },
    }
}

/// What the state holds, for the oracle.
fn remembered<const N: usize>(state: &[f64]) -> law::Point {
    law::Point {
        pressure: state[1],
        limit: state[2],
        stored: state[3],
        slip_length: state[5],
        forgotten: state[9],
        status: [Status::Open, Status::Stick, Status::MicroSlip, Status::GrossSlip][state[0] as usize],
        knots: state[12..]
            .chunks_exact(1 + N)
            .take(state[10] as usize)
            .map(|knot| Knot { r: knot[0], u: [knot[1], if N == 2 { knot[2] } else { 0.0 }] })
            .collect(),
    }
}

#[derive(Debug, Default)]
struct Worst {
    updates: u32,
    traction: f64,
    stored: f64,
    dissipated: f64,
    by_slip: f64,
    by_pressure: f64,
    knots: f64,
    /// Another choice at a threshold: another number of knots.
    other: u32,
}

impl Worst {
    fn history<const N: usize>(&mut self, props: &[f64], nstate: usize, random: &mut fastrand::Rng, steps: u32) {
        let mut point = Point::<N>::with_state_size(props, nstate);
        let law = plain(props, (nstate - 12) / (1 + N));
        let mut pressure = 1.0f64;
        for _ in 0..steps {
            let length = decades(random, -3.0, 0.5);
            let d: [f64; N] = std::array::from_fn(|_| length * signed(random));
            pressure = match random.u32(0..20) {
                0 => 0.0,
                1..=4 => decades(random, -0.7, 0.7),
                5..=8 => pressure * (1.0 + 0.2 * signed(random)),
                _ if pressure == 0.0 => 1.0,
                _ => pressure,
            };
            let d = if random.u32(0..10) == 0 { [0.0; N] } else { d };
            let factor = if random.u32(0..10) == 0 { random.f64() } else { 1.0 };
            let mut mirror = remembered::<N>(&point.state);
            let before = mirror.clone();
            let mut end = point.state.clone();
            let response = point
                .law
                .friction(1.0, &Vector::from(d), pressure, factor, &point.state, &mut end)
                .expect("a valid increment");
            let expected = law.step(&mut mirror, [d[0], if N == 2 { d[1] } else { 0.0 }], pressure, factor);
            let t = mirror.limit.max(before.limit).max(1e-30);
            let g = mirror.knots.last().map_or(1.0, |k| k.r).max(before.knots.last().map_or(0.0, |k| k.r));
            let k = t / g * law.backbone.tangent(0.0) * (g / mirror.knots.last().map_or(g, |k| k.r));
            let mut off = |name: &str, worst: fn(&mut Worst) -> &mut f64, error: f64, limit: f64| {
                let worst = worst(self);
                if error > limit && !(name == "by slip" && d == [0.0; N]) && name != "knots" || error.is_nan() { println!("BAD {name} {error:e}"); }
                if error > *worst || error.is_nan() {
                    *worst = error;
                    if error > limit && !(name == "by slip" && d == [0.0; N]) || error.is_nan() {
                        println!("{name} {error:e}: {props:?} d {d:?} p {} -> {pressure} x{factor} T {} -> {}\n {response:?}\n {expected:?}\n start {:?}\n kernel {:?}\n oracle {:?}", before.pressure, before.limit, mirror.limit, before.knots, remembered::<N>(&end).knots, mirror.knots);
                    }
                }
            };
            let size = Vector::from(d).norm().max(g) * t;
            for i in 0..N {
                off("traction", |w| &mut w.traction, (response.traction[i] - expected.traction[i]).abs() / t, 1e-12);
                off("by pressure", |w| &mut w.by_pressure, (response.dtraction_dpressure[i] - expected.by_pressure[i]).abs(), 1e-9);
                for j in 0..N {
                    off("by slip", |w| &mut w.by_slip, (response.dtraction_dslip[(i, j)] - expected.by_slip[i][j]).abs() / k, 1e-9);
                }
            }
            off("stored", |w| &mut w.stored, (response.stored - mirror.stored).abs() / (t * g), 1e-12);
            off("dissipated", |w| &mut w.dissipated, (response.dissipated - expected.dissipated).abs() / size, 1e-12);
            if expected.status as i32 != response.contact as i32 {
                println!("status {:?} {:?} {d:?} {before:?}", expected.status, response.contact);
            }
            let kernel = remembered::<N>(&end).knots;
            if law.backbone.exponent() == 1.0 {
            } else if kernel.len() == mirror.knots.len() {
                for (a, b) in kernel.iter().zip(&mirror.knots) {
                    let error = (a.r - b.r).abs().max((a.u[0] - b.u[0]).abs()).max((a.u[1] - b.u[1]).abs());
                    off("knots", |w| &mut w.knots, error / g, 1e-11);
                }
            } else {
                if self.other < 3 { println!("other {props:?} d {d:?} p {} -> {pressure} T {} -> {}\n start {:?}\n kernel {:?}\n oracle {:?}", before.pressure, before.limit, mirror.limit, before.knots, kernel, mirror.knots); }
                self.other += 1;
            }
            self.updates += 1;
            let _ = Status::Open;
            point.state = end;
        }
    }
}

#[test]
fn the_kernel_is_the_law() {
    for direction in [1, 2] {
        for (name, props) in [
            ("1", unit(1.0)),
            ("1.5", unit(1.5)),
            ("2", unit(2.0)),
            ("2.5", unit(2.5)),
            ("3.7", unit(3.7)),
            ("Segalman", segalman(-0.6, 0.2)),
        ] {
            for rule in [0.0, 1.0] {
                if name == "Segalman" && rule > 0.0 {
                    continue;
                }
                let props = with(&props, 5, rule);
                let mut worst = Worst::default();
                let mut random = fastrand::Rng::with_seed(1);
                if direction == 1 {
                    worst.history::<1>(&props, 44, &mut random, 3000);
                    worst.history::<1>(&props, 20, &mut random, 3000);
                } else {
                    worst.history::<2>(&props, 84, &mut random, 2000);
                    worst.history::<2>(&props, 24, &mut random, 1000);
                }
                println!("{direction} {name} rule {rule}: {worst:?}");
            }
        }
    }
}
