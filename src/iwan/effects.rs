//! What the model leaves out: a time lag between the channels, backlash, a viscous part, and other forces of one more
//! unknown.
//!
//! Each is added to the four-parameter model; the one that lowers the sum of squares most is kept, then a further one
//! is tried. Lag and backlash change the displacement, so that reversals and branches are found anew for every value
//! that is tried.

use super::fit::{Estimate, Fit, Loop, ROUNDING, Solution, UNKNOWNS, fit_of, unknowns};
use super::least_squares::{Minimum, ROUGH, minimise};
use super::record::Record;
use super::residuals::Residuals;
use super::warning::Effect;
use crate::error::Error;

/// At most so many points of a cycle, and in all, tell what is left out.
const OF_A_CYCLE: usize = 800;
const POINTS: usize = 20_000;
/// An effect whose gain to first order is less than this is not looked at closer.
const PROMISING: f64 = 8.0;
/// Shape that effects leave, as a part of T_max, is no more than this.
const MOST_LEFT: f64 = 0.01;
/// At most so many effects together.
const MOST: usize = 2;
/// The sum of squares falls by so many variances: chance does it once in 10^5 times. For a lag, which is taken out,
/// more: a loop that is not quite of the model has a part of one by chance.
const SIGNIFICANT: f64 = 20.0;
const LAG_SIGNIFICANT: f64 = 30.0;
/// What an effect takes from the residuals, root mean square over T: less is of no matter. A lag of this size moves
/// kappa by less than .01.
const MATTERS: f64 = 1e-3;
const LAG_MATTERS: f64 = 3e-4;
/// Effects explain the residuals when no more than this part of the shape (of its square) is left.
const LEFT: f64 = 0.25;
/// An effect makes the parameters unfit when it takes this part of T_max from the residuals, root mean square, or moves
/// F_s, X_s, k_alpha (parts) or kappa by this much: half of what a loop with 1 % noise allows.
const TAKES: f64 = 5e-3;
const MOVES: [f64; 4] = [0.01, 0.025, 0.025, 0.025];
/// Greatest lag as a part of a cycle, greatest play as a part of the amplitude.
const MOST_LAG: f64 = 0.04;
const MOST_PLAY: f64 = 0.3;
/// Places that are looked at before the best is closed in, and how far.
const PLACES: i32 = 8;
const SECTIONS: usize = 18;
const GOLDEN: f64 = 0.618_033_988_75;
/// Half width of the slope that stands for the velocity, in samples.
const SLOPE: usize = 3;

const ALL: [Effect; 7] = [
    Effect::Lag,
    Effect::Backlash,
    Effect::Viscous,
    Effect::Hardening,
    Effect::Asymmetry,
    Effect::Drift,
    Effect::Change,
];

/// A model with effects.
#[derive(Clone, Debug, Default)]
struct Model {
    /// Late by so many samples.
    lag: f64,
    /// Play.
    play: f64,
    /// Forces, each a column.
    forces: Vec<Effect>,
    has: Vec<Effect>,
}

/// What was found.
pub(super) struct Found {
    /// The effects, with their size in samples, displacement or force.
    pub effects: Vec<(Effect, Estimate)>,
    /// The joint with them.
    pub fit: Fit,
    /// Whether they explain what noise does not.
    pub explain: bool,
    /// Mean square residual before and after.
    pub squares: [f64; 2],
}

impl Found {
    /// Whether parameters without the effects, `fit`, are unfit.
    pub fn spoil(&self, fit: &Fit) -> bool {
        let (before, after) = (fit.joint.parameters(), self.fit.joint.parameters());
        let stiffness = 0.1 * fit.peak / fit.joint.displacement;
        let moved = (0..4).any(|k| {
            let scale = match k {
                3 => 1.0,
                2 => after[k].abs().max(stiffness),
                _ => after[k].abs(),
            };
            (before[k] - after[k]).abs() > MOVES[k] * scale
        });
        let took = (self.squares[0] - self.squares[1]).max(0.0).sqrt();
        moved || took > TAKES * fit.peak.abs()
    }
}

impl Found {
    /// The size of one of them.
    pub fn size(&self, effect: Effect) -> Option<Estimate> {
        let found = self.effects.iter().find(|(e, _)| *e == effect);
        found.map(|(_, size)| *size)
    }
}

/// A model that was solved.
struct Solved {
    model: Model,
    record: Record,
    minimum: Minimum,
    square: f64,
}

/// Keeps the better one; its mean square, and whether it was better.
fn keep(best: &mut Option<Solved>, solved: Option<Solved>) -> (f64, bool) {
    let square = solved.as_ref().map_or(f64::INFINITY, |s| s.square);
    let better = square < best.as_ref().map_or(f64::INFINITY, |b| b.square);
    if better {
        *best = solved;
    }
    (square, better)
}

/// A record of no more points than are needed, with every so many-th row.
pub(super) fn thinned(record: &Record) -> Result<(Record, usize), Error> {
    let rows = record.displacement.len();
    let cycles = (record.half_cycles.len() / 2).max(1);
    let mut stride = (rows / cycles / OF_A_CYCLE).max(1);
    if record.origin.is_some() {
        stride = stride.max(rows.div_ceil(POINTS));
    }
    let end = rows.min(POINTS * stride);
    if stride == 1 && end == rows {
        return Ok((record.clone(), 1));
    }
    Ok((record.thinned(stride, end)?, stride))
}

/// The play operator: what follows a displacement with this play, from the middle of the record on.
fn with_play(record: &Record, play: f64) -> Result<Record, Error> {
    let half = 0.5 * play;
    let first = record.displacement[0];
    let mut at = record.centre.clamp(first - half, first + half);
    let follows = record.displacement.iter().map(|&x| {
        at = at.clamp(x - half, x + half);
        at
    });
    record.with_displacement(follows.collect())
}

/// The column of an effect that is a force, over its greatest value.
fn column(record: &Record, effect: Effect) -> Vec<f64> {
    let x = &record.displacement;
    let count = x.len();
    let place = |index: usize| (x[index] - record.centre) / record.amplitude;
    let mut column: Vec<f64> = match effect {
        Effect::Hardening => (0..count).map(|i| place(i).powi(3)).collect(),
        Effect::Asymmetry => (0..count).map(|i| place(i).powi(2)).collect(),
        Effect::Drift => (0..count).map(|i| i as f64 / count as f64).collect(),
        Effect::Change => {
            let unit = record.force_unit();
            let grown = |i: usize| (i as f64 / count as f64 - 0.5) * record.force[i] / unit;
            (0..count).map(grown).collect()
        }
        _ => (0..count)
            .map(|i| {
                let (low, high) = (i.saturating_sub(SLOPE), (i + SLOPE).min(count - 1));
                let middle = 0.5 * (low + high) as f64;
                let (mut xy, mut xx) = (0.0, 0.0);
                for k in low..=high {
                    let t = k as f64 - middle;
                    xy += t * place(k);
                    xx += t * t;
                }
                xy / xx
            })
            .collect(),
    };
    if effect == Effect::Viscous {
        let most = column.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        column
            .iter_mut()
            .for_each(|v| *v /= most.max(f64::MIN_POSITIVE));
    }
    column
}

/// The search on one record.
struct Search<'a> {
    record: &'a Record,
    start: &'a Fit,
    /// Greatest lag in samples.
    most_lag: f64,
}

impl Search<'_> {
    fn problem<'r>(&self, record: &'r Record, model: &Model) -> Loop<'r> {
        let mut problem = Loop::of(record);
        problem.stop = self.start.stop.is_some();
        problem.columns = model.forces.iter().map(|e| column(record, *e)).collect();
        problem
    }

    fn solve(&self, model: Model) -> Option<Solved> {
        let mut record = self.record.clone();
        if model.lag != 0.0 {
            record = record.without_lag(model.lag).ok()?;
        }
        if model.play != 0.0 {
            record = with_play(&record, model.play).ok()?;
        }
        let problem = self.problem(&record, &model);
        let minimum = minimise(&problem, unknowns(&problem, self.start), 1, ROUGH);
        let square = minimum.sum / minimum.count as f64 * problem.unit * problem.unit;
        Some(Solved {
            minimum,
            model,
            square,
            record,
        })
    }

    /// The best of models along one number: the least of some places, then golden sections beside it.
    fn along(&self, range: [f64; 2], model: impl Fn(f64) -> Model) -> Option<Solved> {
        let at = |value: f64| self.solve(model(value));
        let step = (range[1] - range[0]) / f64::from(PLACES);
        let place = |k: i32| range[0] + step * f64::from(k);
        let mut best: Option<Solved> = None;
        let mut centre = range[0];
        for k in 0..=PLACES {
            if keep(&mut best, at(place(k))).1 {
                centre = place(k);
            }
        }
        let (mut low, mut high) = ((centre - step).max(range[0]), (centre + step).min(range[1]));
        let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (mut at_a, mut at_b) = (keep(&mut best, at(a)).0, keep(&mut best, at(b)).0);
        for _ in 0..SECTIONS {
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = high - GOLDEN * (high - low);
                at_a = keep(&mut best, at(a)).0;
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + GOLDEN * (high - low);
                at_b = keep(&mut best, at(b)).0;
            }
        }
        best
    }

    /// What a small lag or play does to the force, as a column: the force at the parameters of `base` with the
    /// displacement moved.
    fn first_order(&self, base: &Solved, effect: Effect) -> Vec<f64> {
        const STEP: f64 = 1e-4;
        let record = &base.record;
        let mut moved = record.clone();
        let velocity = column(record, Effect::Viscous);
        for branch in &record.branches {
            for index in branch.points() {
                let way = match effect {
                    Effect::Lag => velocity[index],
                    _ => -branch.direction.sign(),
                };
                moved.displacement[index] += STEP * way * record.amplitude;
            }
        }
        let residuals = |record: &Record| {
            let mut residuals = Vec::new();
            let mut problem = self.problem(&base.record, &base.model);
            problem.record = record;
            problem.residuals(&base.minimum.parameters, &mut residuals);
            residuals
        };
        let (here, there) = (residuals(record), residuals(&moved));
        let mut column = vec![0.0; record.displacement.len()];
        let points = record.branches.iter().flat_map(|b| b.points());
        for (index, (a, b)) in points.zip(here.iter().zip(there)) {
            column[index] = (a - b) / (STEP * base.square.sqrt().max(f64::MIN_POSITIVE));
        }
        column
    }

    /// Whether a lag or play may lower the sum of squares, to first order.
    fn is_promising(&self, base: &Solved, effect: Effect) -> bool {
        let mut problem = self.problem(&base.record, &base.model);
        let mut start = base.minimum.parameters.as_slice().to_vec();
        start.insert(UNKNOWNS + problem.columns.len(), 0.0);
        problem.columns.push(self.first_order(base, effect));
        let minimum = minimise(&problem, start.into(), 1, ROUGH);
        let gain = (base.minimum.sum - minimum.sum) / minimum.sum * minimum.count as f64;
        gain > PROMISING
    }

    /// The model with one effect more.
    fn with(&self, base: &Solved, effect: Effect) -> Option<Solved> {
        let model = &base.model;
        if matches!(effect, Effect::Lag | Effect::Backlash) && !self.is_promising(base, effect) {
            return None;
        }
        let mut more = model.clone();
        more.has.push(effect);
        match effect {
            Effect::Lag => self.along([-self.most_lag, self.most_lag], |lag| Model {
                lag,
                ..more.clone()
            }),
            Effect::Backlash => {
                // A lag that was taken for it falls when it is there.
                let most = MOST_PLAY * self.record.amplitude;
                self.along([0.0, most], |play| Model {
                    play,
                    ..more.clone()
                })
            }
            _ => {
                more.forces.push(effect);
                self.solve(more)
            }
        }
    }

    /// By how many variances the sum of squares fell.
    fn gain(&self, before: f64, after: &Solved) -> f64 {
        let problem = self.problem(&after.record, &after.model);
        let Ok(solution) = Solution::new(&problem, after.minimum.clone()) else {
            return 0.0;
        };
        let unit = problem.unit * problem.unit;
        let variance = (solution.variance * unit).max(ROUNDING * ROUNDING * unit);
        (before - after.square) * problem.record.points() as f64 / variance
    }

    /// Value and standard error of a lag or play: where the sum of squares is one variance above the least.
    fn estimate(&self, solved: &Solved, effect: Effect) -> Estimate {
        let changed = |change: f64| {
            let mut model = solved.model.clone();
            match effect {
                Effect::Lag => model.lag += change,
                _ => model.play = (model.play + change).max(0.0),
            }
            self.solve(model)
        };
        let (value, step) = match effect {
            Effect::Lag => (solved.model.lag, 0.02 * self.most_lag),
            _ => (solved.model.play, 0.2 * solved.model.play),
        };
        // The sum of squares is a parabola there.
        let rise = [-step, step].map(|change| {
            changed(change).map_or(f64::NAN, |other| self.gain(other.square, solved).max(0.0))
        });
        let rise = 0.5 * (rise[0] + rise[1]);
        Estimate {
            value,
            error: step / rise.max(f64::MIN_POSITIVE).sqrt(),
        }
    }
}

/// The effects that the record shows beside the model of `fit`; None when there is none.
pub(super) fn found(whole: &Record, fit: &Fit, with_lag: bool) -> Result<Option<Found>, Error> {
    let (record, stride) = thinned(whole)?;
    let rows = record.half_cycles.iter().map(|half| {
        let rows = half.rows.iter();
        rows.map(ExactSizeIterator::len).sum::<usize>()
    });
    let of_a_cycle = 2.0 * rows.sum::<usize>() as f64 / record.half_cycles.len().max(1) as f64;
    let search = Search {
        record: &record,
        start: fit,
        most_lag: (MOST_LAG * of_a_cycle).max(2.0),
    };
    let Some(none) = search.solve(Model::default()) else {
        return Ok(None);
    };
    let shape = |solved: &Solved| -> Result<Residuals, Error> {
        let problem = search.problem(&solved.record, &solved.model);
        let solution = Solution::new(&problem, solved.minimum.clone())?;
        let rounding = ROUNDING * problem.unit;
        Ok(Residuals::new(
            &solved.record,
            &solution.residuals,
            rounding,
        ))
    };
    let before = shape(&none)?;
    let unit = record.force_unit();
    let (first, mut best) = (none.square, none);
    while best.model.has.len() < MOST {
        let open = ALL.into_iter().filter(|effect| {
            // In a single cycle a drift is a matter of shape.
            let shown = match effect {
                Effect::Lag => with_lag,
                Effect::Drift | Effect::Change => record.half_cycles.len() >= 4,
                _ => true,
            };
            shown && !best.model.has.contains(effect)
        });
        let next = open
            .filter_map(|effect| search.with(&best, effect))
            .min_by(|a, b| a.square.total_cmp(&b.square));
        let Some(next) = next else { break };
        let (matters, significant) = match next.model.has.last() {
            Some(Effect::Lag) => (LAG_MATTERS, LAG_SIGNIFICANT),
            _ => (MATTERS, SIGNIFICANT),
        };
        let fell = (best.square - next.square).max(0.0).sqrt();
        if search.gain(best.square, &next) < significant || fell < matters * unit {
            break;
        }
        best = next;
    }
    if best.model.has.is_empty() {
        return Ok(None);
    }
    let after = shape(&best)?;
    let problem = search.problem(&best.record, &best.model);
    let solution = Solution::new(&problem, best.minimum.clone())?;
    let mut effects = Vec::new();
    for &effect in &best.model.has {
        let size = match best.model.forces.iter().position(|e| *e == effect) {
            Some(k) => solution.estimate(UNKNOWNS + k, problem.unit),
            None => {
                let samples = if effect == Effect::Lag {
                    stride as f64
                } else {
                    1.0
                };
                let estimate = search.estimate(&best, effect);
                Estimate {
                    value: estimate.value * samples,
                    error: estimate.error * samples,
                }
            }
        };
        effects.push((effect, size));
    }
    let fit = fit_of(&problem, &solution)?;
    let left = after.shape.square.max(0.0).sqrt();
    let at_end = best.model.lag.abs() > 0.99 * search.most_lag;
    let explain = !at_end
        && (!after.shape.is_plain()
            || after.shape.square < LEFT * before.shape.square
                && left < MOST_LEFT * fit.peak.abs());
    Ok(Some(Found {
        effects,
        fit,
        explain,
        squares: [first, best.square],
    }))
}
