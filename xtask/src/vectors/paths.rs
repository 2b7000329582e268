//! Slip histories: zigzags along a line, curves in the plane.

use super::vector::Step;
use crate::generated::decimals;

/// Decimals of a slip in mm: 1e-12 mm, far below any critical slip here.
pub const PLACES: usize = 12;

/// From one turning point to the next in equal steps; the first point is the first row.
pub fn branches(gcr: f64, turning_points: &[f64], steps: usize) -> Vec<f64> {
    let mut slips = vec![decimals(turning_points[0] * gcr, PLACES)];
    for pair in turning_points.windows(2) {
        for k in 1..=steps {
            let s = pair[0] + (pair[1] - pair[0]) * k as f64 / steps as f64;
            slips.push(decimals(s * gcr, PLACES));
        }
    }
    slips
}

/// A path in the plane at constant pressure, from points in units of gcr.
pub fn plane(gcr: f64, pressure: f64, points: impl IntoIterator<Item = [f64; 2]>) -> Vec<Step> {
    points
        .into_iter()
        .map(|[x, y]| Step {
            slip: [decimals(x * gcr, PLACES), decimals(y * gcr, PLACES)],
            pressure,
        })
        .collect()
}

/// Radial start, then turns about the origin.
pub fn circle(radius: f64, turns: usize, steps: usize) -> Vec<[f64; 2]> {
    let radial = (0..=10).map(|k| [radius * f64::from(k) / 10.0, 0.0]);
    let round = (1..=turns * steps).map(|k| {
        let phase = std::f64::consts::TAU * k as f64 / steps as f64;
        [radius * phase.cos(), radius * phase.sin()]
    });
    radial.chain(round).collect()
}

pub fn figure_eight(a: f64, turns: usize, steps: usize) -> Vec<[f64; 2]> {
    (0..=turns * steps)
        .map(|k| {
            let phase = std::f64::consts::TAU * k as f64 / steps as f64;
            [a * phase.sin(), a * (2.0 * phase).sin() / 2.0]
        })
        .collect()
}

pub fn square(a: f64, turns: usize, side_steps: usize) -> Vec<[f64; 2]> {
    let corners = [[a, a], [-a, a], [-a, -a], [a, -a]];
    let mut points = vec![[0.0, 0.0]];
    let mut from = [0.0, 0.0];
    for corner in (0..4 * turns + 1).map(|k| corners[k % 4]) {
        for k in 1..=side_steps {
            let part = k as f64 / side_steps as f64;
            points.push([0, 1].map(|i: usize| from[i] + (corner[i] - from[i]) * part));
        }
        from = corner;
    }
    points
}

/// Steps of up to `reach` in either direction, from a fixed seed.
pub fn random_walk(count: usize, reach: f64) -> Vec<[f64; 2]> {
    // Knuth's 64-bit linear congruential generator, upper bits.
    let mut seed: u64 = 20_240_229;
    let mut uniform = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut at = [0.0, 0.0];
    let mut points = vec![at];
    for _ in 0..count {
        at = at.map(|x| x + reach * (2.0 * uniform() - 1.0));
        points.push(at);
    }
    points
}
