//! Slip paths in the tangential plane, in units of the critical slip, all from the origin.

use std::f64::consts::TAU;

/// Radial start, then turns about the origin.
pub fn circle(radius: f64, turns: u32, steps: u32) -> Vec<[f64; 2]> {
    let radial = (1..=20).map(|k| [radius * f64::from(k) / 20.0, 0.0]);
    let round = (1..=turns * steps).map(|k| {
        let phase = TAU * f64::from(k) / f64::from(steps);
        [radius * phase.cos(), radius * phase.sin()]
    });
    radial.chain(round).collect()
}

/// Turns about a square with the given half side.
pub fn square(half_side: f64, turns: u32, side_steps: u32) -> Vec<[f64; 2]> {
    let a = half_side;
    let corners = [[a, a], [-a, a], [-a, -a], [a, -a]];
    let mut points = Vec::new();
    let mut from = [0.0; 2];
    for corner in (0..=4 * turns as usize).map(|k| corners[k % 4]) {
        for k in 1..=side_steps {
            let part = f64::from(k) / f64::from(side_steps);
            points.push([0, 1].map(|i: usize| from[i] + (corner[i] - from[i]) * part));
        }
        from = corner;
    }
    points
}

/// a (sin(m t), sin(n t)) for whole numbers m, n.
pub fn lissajous(a: f64, [m, n]: [u32; 2], turns: u32, steps: u32) -> Vec<[f64; 2]> {
    (1..=turns * steps)
        .map(|k| {
            let phase = TAU * f64::from(k) / f64::from(steps);
            [
                a * (f64::from(m) * phase).sin(),
                a * (f64::from(n) * phase).sin(),
            ]
        })
        .collect()
}

/// Steps of uniform direction and of length up to `step`.
pub fn random_walk(random: &mut fastrand::Rng, count: u32, step: f64) -> Vec<[f64; 2]> {
    let mut at = [0.0; 2];
    (0..count)
        .map(|_| {
            let (angle, length) = (TAU * random.f64(), step * random.f64());
            at = [at[0] + length * angle.cos(), at[1] + length * angle.sin()];
            at
        })
        .collect()
}
