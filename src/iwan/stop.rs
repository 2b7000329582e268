//! Slip, then bearing: the four-parameter model with a spring beyond a clearance on either side.

use super::fit::{Friction, Loop, Solution, UNKNOWNS, X_RANGE, bad, fit_of, lowest, valley, warnings};
use super::least_squares::search;
use super::masing::{CLEARANCES, Masing};
use super::record::Record;
use super::{Fit, fit::Bottom};
use crate::error::Error;

/// Clearances over the amplitude where the search starts.
const STARTS: [f64; 6] = [0.2, 0.4, 0.55, 0.7, 0.82, 0.92];
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
    // For given clearances the stiffness is linear: the bottom of the valley with one more column, with a stop on both sides, only
    // above, or only below.
    let reached = CLEARANCES[1];
    let sides = [[true, true], [true, false], [false, true]];
    let mut starts: Vec<(f64, Vec<Bottom>)> = Vec::new();
    for clearance in STARTS {
        for side in sides {
            let [above, below] = side.map(|there| if there { clearance } else { reached });
            let column = record.displacement.iter().map(|x| {
                let place = (x - record.centre) / record.amplitude;
                (place - above).max(0.0) + (place + below).min(0.0)
            });
            let mut one = Loop::of(record);
            one.columns = vec![column.collect()];
            let mut bottoms = valley(&one);
            for bottom in &mut bottoms {
                let stiffness = bottom.unknowns[UNKNOWNS].max(0.0);
                let mut all = bottom.unknowns.as_slice()[..UNKNOWNS].to_vec();
                all.extend([above, below, stiffness]);
                bottom.unknowns = all.into();
            }
            let least = bottoms.iter().map(|b| b.sum).fold(f64::INFINITY, f64::min);
            starts.push((least, bottoms));
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(FOLLOWED);
    let lowest_of = |bottoms: &[Bottom]| {
        let best = bottoms.iter().min_by(|a, b| a.sum.total_cmp(&b.sum));
        best.map(|bottom| bottom.unknowns.clone())
    };
    let best = search(&problem, starts.iter().filter_map(|(_, b)| lowest_of(b)));
    let mut best = best.ok_or_else(|| bad("no start for the search"))?;
    let bottoms = starts.swap_remove(0).1;
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
