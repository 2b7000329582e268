//! Slip paths of the vectors, in critical slips: zigzags along a line, curves in the plane.

use serde::Deserialize;
use std::f64::consts::TAU;

/// A path, as vectors.toml says it.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Path {
    /// From one turning point to the next in equal steps.
    Branches { points: Vec<f64>, steps: usize },
    /// Slip and pressure of each step, and the factor on mu.
    Rows { rows: Vec<Vec<f64>> },
    /// Ten radial steps, then turns about the origin.
    Circle {
        radius: f64,
        turns: usize,
        steps: usize,
    },
    /// sin, and half of the double sin across it.
    FigureEight {
        radius: f64,
        turns: usize,
        steps: usize,
    },
    /// Turns about a square from its centre; `steps` a side.
    Square {
        half_side: f64,
        turns: usize,
        steps: usize,
    },
    /// Steps of up to `reach` in either direction, from a fixed seed.
    RandomWalk { steps: usize, reach: f64 },
}

impl Path {
    /// Directions of the path.
    pub fn directions(&self) -> usize {
        if matches!(self, Path::Branches { .. } | Path::Rows { .. }) {
            1
        } else {
            2
        }
    }

    pub fn points(&self) -> Vec<[f64; 2]> {
        match self {
            Path::Branches { points, steps } => {
                let first = [points[0], 0.0];
                let branch = |pair: &[f64]| {
                    let (from, to, steps) = (pair[0], pair[1], *steps);
                    (1..=steps).map(move |k| [from + (to - from) * k as f64 / steps as f64, 0.0])
                };
                std::iter::once(first)
                    .chain(points.windows(2).flat_map(branch))
                    .collect()
            }
            Path::Rows { rows } => rows.iter().map(|row| [row[0], 0.0]).collect(),
            Path::Circle {
                radius,
                turns,
                steps,
            } => {
                let radial = (0..=10).map(|k| [radius * f64::from(k) / 10.0, 0.0]);
                let round = (1..=turns * steps).map(|k| {
                    let phase = TAU * k as f64 / *steps as f64;
                    [radius * phase.cos(), radius * phase.sin()]
                });
                radial.chain(round).collect()
            }
            Path::FigureEight {
                radius,
                turns,
                steps,
            } => (0..=turns * steps)
                .map(|k| {
                    let phase = TAU * k as f64 / *steps as f64;
                    [radius * phase.sin(), radius * (2.0 * phase).sin() / 2.0]
                })
                .collect(),
            Path::Square {
                half_side: a,
                turns,
                steps,
            } => {
                let corners = [[*a, *a], [-a, *a], [-a, -a], [*a, -a]];
                let mut points = vec![[0.0, 0.0]];
                let mut from = [0.0, 0.0];
                for corner in (0..4 * turns + 1).map(|k| corners[k % 4]) {
                    for k in 1..=*steps {
                        let part = k as f64 / *steps as f64;
                        points.push([0, 1].map(|i: usize| from[i] + (corner[i] - from[i]) * part));
                    }
                    from = corner;
                }
                points
            }
            Path::RandomWalk { steps, reach } => {
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
                for _ in 0..*steps {
                    at = at.map(|x| x + reach * (2.0 * uniform() - 1.0));
                    points.push(at);
                }
                points
            }
        }
    }
}
