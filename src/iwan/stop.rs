//! Slip, then bearing: the four-parameter model with a spring beyond a clearance on either side.

use super::fit::{
    Friction, Loop, Solution, UNKNOWNS, X_RANGE, bad, fit_of, lowest, valley, warnings,
};
use super::least_squares::search;
use super::masing::{CLEARANCES, Masing};
use super::record::Record;
use super::{Fit, fit::Bottom};
use crate::error::Error;
use nalgebra::DVector;

/// Clearances over the amplitude where the search starts; the last one is not reached.
const STARTS: [f64; 7] = [0.2, 0.4, 0.55, 0.7, 0.82, 0.92, CLEARANCES[1]];
/// Of the places along the valley, every so many-th tells which start is good.
const COARSE: usize = 3;
/// So many of the best are followed.
const FOLLOWED: usize = 4;

/// The problem with stops.
pub(super) fn with_stop(record: &Record) -> Loop<'_> {
    Loop {
        stop: true,
        ..Masing::new(record, Friction { x_range: X_RANGE })
    }
}

/// The least squares of the model with stops, and the valley of its best start.
pub(super) fn solve(record: &Record) -> Result<(Solution, Vec<Bottom>), Error> {
    let problem = with_stop(record);
    // For given clearances the stiffness is linear: the bottom of the valley with one more column.
    let bottoms = |[above, below]: [f64; 2], every: usize| -> Vec<Bottom> {
        let column = record.displacement.iter().map(|x| {
            let place = (x - record.centre) / record.amplitude;
            (place - above).max(0.0) + (place + below).min(0.0)
        });
        let mut one = Loop::of(record);
        one.columns = vec![column.collect()];
        let mut bottoms = valley(&one, every);
        for bottom in &mut bottoms {
            let stiffness = bottom.unknowns[UNKNOWNS].max(0.0);
            let mut all = bottom.unknowns.as_slice()[..UNKNOWNS].to_vec();
            all.extend([above, below, stiffness]);
            bottom.unknowns = all.into();
        }
        bottoms
    };
    let mut tried: Vec<(f64, [f64; 2], DVector<f64>)> = Vec::new();
    // One side after the other: both alike, then each for the best of the other; the last one is that it is not
    // reached.
    let alike = STARTS.map(|clearance| [clearance; 2]);
    let mut places: Vec<[f64; 2]> = alike[..STARTS.len() - 1].to_vec();
    for side in [1, 0, 1] {
        for pair in places.drain(..) {
            if tried.iter().any(|(_, other, _)| *other == pair) {
                continue;
            }
            let bottoms = bottoms(pair, COARSE);
            let best = bottoms.into_iter().min_by(|a, b| a.sum.total_cmp(&b.sum));
            tried.extend(best.map(|bottom| (bottom.sum, pair, bottom.unknowns)));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, best, _)) = tried.first() {
            places = STARTS
                .map(|clearance| {
                    let mut pair = *best;
                    pair[side] = clearance;
                    pair
                })
                .to_vec();
        }
    }
    tried.truncate(FOLLOWED);
    let best = search(
        &problem,
        tried.iter().map(|(.., unknowns)| unknowns.clone()),
    );
    let mut best = best.ok_or_else(|| bad("no start for the search"))?;
    // Once more along the whole valley, with the clearances that were found.
    let found = [0, 1].map(|k| best.parameters[UNKNOWNS + k]);
    let bottoms = bottoms(found, 1);
    if let Some(other) = lowest(&problem, &bottoms)
        && other.sum < best.sum
    {
        best = other;
    }
    Ok((Solution::new(&problem, best)?, bottoms))
}

/// The fit with stops.
pub(super) fn fit(record: &Record) -> Result<Fit, Error> {
    let problem = with_stop(record);
    let (solution, valley) = solve(record)?;
    let mut fit = fit_of(&problem, &solution)?;
    fit.warnings = warnings(&fit, &problem, &solution, &valley);
    fit.residuals = solution.residuals;
    Ok(fit)
}
