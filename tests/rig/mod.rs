//! Records as rigs write them, from loops of known parameters: thousands of slip elements instead of Masing's rule.
#![allow(dead_code, reason = "each test program uses a part")]

use std::f64::consts::{PI, TAU};

/// F_s (N), X_s (mm), k_alpha (N/mm), kappa: verification item 17; and its amplitude (mm).
pub const TRUTH: [f64; 4] = [266.78, 0.0041, 3280.7, -0.842];
pub const AMPLITUDE: f64 = 0.02;
/// Force at the amplitude.
pub const T_MAX: f64 = 332.394;
/// Samples of a turn, and slip elements.
pub const TURN: usize = 400;
const ELEMENTS: usize = 400;

/// Friction along a path that starts at rest: elements whose limits follow `slope`, the derivative of the curve of
/// first loading f(u / x_s), which ends at `reach` x_s.
pub fn friction(path: &[f64], x_s: f64, reach: f64, slope: impl Fn(f64) -> f64) -> Vec<f64> {
    let step = reach / ELEMENTS as f64;
    // An element of limit r has the stiffness by which the slope falls at r; the last ones have what is left.
    let stiffness: Vec<f64> = (0..ELEMENTS)
        .map(|k| {
            let after = if k + 1 < ELEMENTS {
                slope((k + 1) as f64 * step)
            } else {
                0.0
            };
            slope(k as f64 * step) - after
        })
        .collect();
    let mut deflection = vec![0.0f64; ELEMENTS];
    let mut last = path[0];
    path.iter()
        .map(|&x| {
            let slip = (x - last) / x_s;
            last = x;
            let mut force = 0.0;
            for (k, (own, stiffness)) in deflection.iter_mut().zip(&stiffness).enumerate() {
                let limit = (k as f64 + 0.5) * step;
                *own = (*own + slip).clamp(-limit, limit);
                force += stiffness * *own;
            }
            force
        })
        .collect()
}

/// The force of the joint with these parameters.
pub fn joint_of([force, x_s, residual, kappa]: [f64; 4], path: &[f64]) -> Vec<f64> {
    let chi = 2.5 + kappa;
    let slope = |r: f64| chi * (1.0 - r).max(0.0).powf(chi - 1.0);
    let friction = friction(path, x_s, 1.0, slope);
    let both = friction.iter().zip(path);
    both.map(|(t, x)| force * t + residual * (x - path[0]))
        .collect()
}

/// That of the known joint.
pub fn joint(path: &[f64]) -> Vec<f64> {
    joint_of(TRUTH, path)
}

/// A harmonic motion from the middle on.
pub fn sine(turns: usize) -> Vec<f64> {
    let at = |i: usize| AMPLITUDE * (TAU * i as f64 / TURN as f64).sin();
    (0..=turns * TURN).map(at).collect()
}

/// Its velocity over the greatest.
pub fn velocity(index: usize) -> f64 {
    (TAU * index as f64 / TURN as f64).cos()
}

/// Ramps from 0 to these amplitudes, each there and back, 100 samples to the amplitude.
pub fn ramps(amplitudes: &[f64]) -> Vec<f64> {
    let mut path = vec![0.0];
    for &a in amplitudes {
        let first = if path[path.len() - 1] <= 0.0 {
            Some(a)
        } else {
            None
        };
        for end in first.into_iter().chain([-a, a]) {
            let start = path[path.len() - 1];
            let count = ((100.0 * (end - start).abs() / a) as usize).max(8);
            path.extend((1..=count).map(|k| start + (end - start) * k as f64 / count as f64));
        }
    }
    path
}

/// Normal noise, a part of the largest force.
pub fn noisy(force: &[f64], part: f64, seed: u64) -> Vec<f64> {
    let largest = force.iter().fold(0.0f64, |m, f| m.max(f.abs()));
    let mut random = fastrand::Rng::with_seed(seed).fork();
    force
        .iter()
        .map(|f| {
            let (u, v) = (1.0 - random.f64(), random.f64());
            f + part * largest * (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
        })
        .collect()
}

/// The play operator: what follows a displacement that is free to move by `play`.
pub fn play(path: &[f64], play: f64) -> Vec<f64> {
    let mut at = path[0];
    path.iter()
        .map(|&x| {
            at = at.clamp(x - 0.5 * play, x + 0.5 * play);
            at
        })
        .collect()
}

/// The force of springs beyond clearances above and below.
pub fn stop(x: f64, [above, below]: [f64; 2], stiffness: f64) -> f64 {
    stiffness * ((x - above).max(0.0) + (x + below).min(0.0))
}
