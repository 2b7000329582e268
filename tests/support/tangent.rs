//! Tangents against central differences along random walks.

use super::{Point, decades, signed};
use mepc::Vector;

/// Which knots slipped in a step: all of the base grid at their limit, and the floating ones that are gone.
fn outside<const N: usize>(props: &[f64], start: &[f64], end: &[f64]) -> Vec<bool> {
    let base = if N == 1 {
        1
    } else {
        props.get(8).map_or(16, |b| *b as usize)
    };
    let limit = |k: usize| {
        let part = k as f64 / base as f64;
        if props.get(9) == Some(&1.0) {
            part.powf(2.0 / (props[2] + 2.0))
        } else {
            1.0 - (1.0 - part).powf(2.0 / props[2])
        }
    };
    let length = |e: &[f64]| e.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (knots, floats) = (8..8 + base * N, 8 + base * N);
    let floating = |state: &[f64]| -> Vec<u64> {
        let used = &state[floats..floats + state[7] as usize * (1 + N)];
        used.chunks(1 + N).map(|knot| knot[0].to_bits()).collect()
    };
    let stays = floating(end);
    let at_limit = end[knots]
        .chunks(N)
        .zip(1..)
        .map(|(e, k)| length(e) >= limit(k) * (1.0 - 1e-11));
    let gone = floating(start).into_iter().map(|r| !stays.contains(&r));
    at_limit.chain(gone).collect()
}

/// Worst relative differences between the tangents and central differences.
#[derive(Default)]
pub struct TangentCheck {
    pub samples: u32,
    pub skipped: u32,
    /// Steps that dropped a reversal.
    pub full: u32,
    pub slip: f64,
    pub pressure: f64,
}

impl TangentCheck {
    /// A random walk with both derivatives compared at every step, with a state of this size.
    pub fn walk<const N: usize>(
        &mut self,
        props: &[f64],
        nstate: usize,
        random: &mut fastrand::Rng,
        steps: u32,
    ) {
        let mut point = Point::<N>::with_state_size(props, nstate);
        let mut pressure = 1.0;
        for _ in 0..steps {
            let length = decades(random, -2.5, 0.3);
            let direction: [f64; N] = std::array::from_fn(|_| signed(random));
            let slip = (Vector::from(direction).normalize() * length).into();
            let next = if random.bool() {
                pressure
            } else {
                decades(random, -0.5, 0.5)
            };
            self.slip_tangent(props, &point, slip, next);
            self.pressure_tangent(props, &point, slip, pressure, next);
            self.full += u32::from(point.step(slip, next).memory_full);
            pressure = next;
        }
    }

    /// d traction / d slip, each column by itself.
    fn slip_tangent<const N: usize>(
        &mut self,
        props: &[f64],
        point: &Point<N>,
        slip: [f64; N],
        p: f64,
    ) {
        let tangent = point.trial(slip, p).0.dtraction_dslip;
        // Relative to the tangent, or to a tenth of mu p / gcr where it is small.
        let scale = tangent.norm().max(0.1 * p);
        for j in 0..N {
            let at = |shift: f64| {
                let mut moved = slip;
                moved[j] += shift;
                point.trial(moved, p)
            };
            // Rounding asks for long steps, a segment that nearly touches the yield boundary for short ones.
            let best = [1e-5, 1e-6, 1e-7].into_iter().filter_map(|part| {
                let h = part * Vector::from(slip).norm();
                let ((low, state_low), (high, state_high)) = (at(-h), at(h));
                let same = outside::<N>(props, &point.state, &state_low)
                    == outside::<N>(props, &point.state, &state_high);
                let difference = (high.traction - low.traction) / (2.0 * h);
                same.then(|| (tangent.column(j) - difference).norm() / scale)
            });
            self.samples += 1;
            match best.min_by(f64::total_cmp) {
                Some(error) => self.slip = self.slip.max(error),
                None => self.skipped += 1,
            }
        }
    }

    /// d traction / d pressure; at an unchanged pressure it is the falling side that is differentiated.
    fn pressure_tangent<const N: usize>(
        &mut self,
        props: &[f64],
        point: &Point<N>,
        slip: [f64; N],
        before: f64,
        p: f64,
    ) {
        let h = 2e-6 * p;
        let derivative = point.trial(slip, p).0.dtraction_dpressure;
        let steps = if p == before {
            [-2.0 * h, 0.0]
        } else {
            [-h, h]
        };
        let [(low, state_low), (high, state_high)] =
            steps.map(|shift| point.trial(slip, p + shift));
        self.samples += 1;
        if outside::<N>(props, &point.state, &state_low)
            != outside::<N>(props, &point.state, &state_high)
        {
            self.skipped += 1;
            return;
        }
        let difference = (high.traction - low.traction) / (2.0 * h);
        self.pressure = self.pressure.max((derivative - difference).norm());
    }
}
