//! Least squares over all branches at once, and what the data can tell about each parameter.
//!
//! The unknowns are F_s / T, ln(X_s / A), chi, k_alpha A / T and the mean force over T, which a real record has and
//! nobody wants to know (T and A: [`super::masing`]). Given X_s and chi the others are linear. X_s and kappa lie in a
//! long and narrow valley: its bottom, the best chi for each of many X_s with the linear unknowns eliminated, tells
//! where to start.

use super::least_squares::{
    EXACT, Minimum, Problem, correlation, inflation, minimise, rough_search, search, search_stride,
    sum_of_squares,
};
use super::masing::{Curve, Masing};
use super::record::{Record, room};
use super::warning::Warning;
use super::{CHI_OFFSET, Iwan};
use crate::error::{Error, Kind};
use nalgebra::{DMatrix, DVector};

/// chi is looked for in this range.
pub(super) const CHI_RANGE: [f64; 2] = [1.0, 100.0];
/// X_s over the amplitude, likewise.
pub(super) const X_RANGE: [f64; 2] = [1e-3, 20.0];
/// Steps of X_s along the valley, from the least to the amplitude and from there to the greatest.
const X_STEPS: [i32; 2] = [34, 15];
/// Where the search for the best chi at an X_s starts, and how many golden sections it ends with.
const CHI_GRID: [f64; 12] = [
    1.0, 1.15, 1.4, 1.7, 2.0, 2.5, 3.2, 4.5, 7.0, 12.0, 30.0, 100.0,
];
const CHI_SECTIONS: usize = 10;
const GOLDEN: f64 = 0.618_033_988_75;
/// Minima along the valley that are followed.
const STARTS: usize = 5;
/// At most so many points are used to draw it.
const VALLEY_POINTS: usize = 500;
/// Fewer points per direction than this, or in gross slip, leave the fit to chance.
pub(super) const FEW_POINTS: usize = 25;
const FEW_GROSS: usize = 5;
/// A standard error beyond this part of the parameter (of 1 for kappa) is no determination.
pub const ILL: f64 = 0.1;
/// Neighbouring residuals with a larger correlation are not noise alone.
pub const CORRELATED: f64 = 0.3;
/// A friction force beyond so many times the half range of the force is none.
const CANCELLING: f64 = 2.0;
/// Scatter of the displacement, as a part of the amplitude, that shifts X_s and kappa by more than a standard error.
const NOISY: f64 = 0.003;
/// A sum of squares at the 95 % point of chi^2 with one degree of freedom above the least is still likely.
const LIKELY: f64 = 3.841_459;
/// A plateau is plain where at this part of the branch no more than that part of F_s is missing.
const PLAIN: [f64; 2] = [0.8, 0.001];
/// A side is reached where the clearance ends so many standard errors before the amplitude.
const PLAINLY: f64 = 4.0;
/// Residuals below this part of the force range are rounding.
pub(super) const ROUNDING: f64 = 1e-7;
/// Unknowns of the curve, and of a fit without more.
const OF_CURVE: usize = 3;
pub(super) const UNKNOWNS: usize = OF_CURVE + 2;

/// A joint identified from a record.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The parameters.
    pub joint: Iwan,
    /// Mean force, about which the loop lies.
    pub offset: f64,
    /// Standard errors of F_s, X_s, k_alpha, kappa.
    pub standard_errors: [f64; 4],
    /// 95 % intervals of the same.
    pub intervals: [[f64; 2]; 4],
    /// Springs beyond a clearance, where they were asked for.
    pub stop: Option<Stop>,
    /// Force at the end of the loop.
    pub peak: f64,
    /// Measured minus fitted force, for the points of the branches, branch after branch.
    pub residuals: Vec<f64>,
    /// Their root mean square.
    pub rms: f64,
    /// What has to be known before the parameters are used.
    pub warnings: Vec<Warning>,
}

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// Springs that bear beyond a clearance on either side, counted from the middle of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Displacements above and below the middle at which they begin to bear; None where that side was not reached.
    pub clearances: [Option<Estimate>; 2],
    /// Their stiffness.
    pub stiffness: Estimate,
}

impl Stop {
    /// Force at a displacement from the middle.
    pub fn force(&self, x: f64) -> f64 {
        let [above, below] = self
            .clearances
            .map(|side| side.map_or(f64::INFINITY, |clearance| clearance.value));
        self.stiffness.value * ((x - above).max(0.0) + (x + below).min(0.0))
    }
}

impl Fit {
    /// False when the parameters must not be used as they are.
    pub fn is_reliable(&self) -> bool {
        !self.warnings.iter().any(|w| w.reason().is_some())
    }

    /// Why not, in single words, each once.
    pub fn reasons(&self) -> Vec<&'static str> {
        let mut reasons: Vec<&str> = Vec::new();
        for reason in self.warnings.iter().filter_map(Warning::reason) {
            if !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
        reasons
    }

    /// Root mean square residual over the force at the end of the loop.
    pub fn misfit(&self) -> f64 {
        self.rms / self.peak.abs()
    }
}

/// The curve F_s f(u / X_s), of F_s / T, ln(X_s / A) and chi.
#[derive(Clone, Copy)]
pub(super) struct Friction {
    /// Of X_s / A.
    pub x_range: [f64; 2],
}

impl Curve<OF_CURVE> for Friction {
    fn at(&self, u: f64, &[force, log_x, chi]: &[f64; OF_CURVE]) -> (f64, [f64; OF_CURVE]) {
        let s = u * (-log_x).exp();
        let [f, by_s, by_chi] = shape(s, chi);
        (force * f, [f, -force * by_s * s, force * by_chi])
    }

    fn bounds(&self) -> [[f64; 2]; OF_CURVE] {
        [[0.0, f64::INFINITY], self.x_range.map(f64::ln), CHI_RANGE]
    }
}

/// f(s) = 1 - (1 - s)^chi with its derivatives by s and chi.
fn shape(s: f64, chi: f64) -> [f64; 3] {
    if s >= 1.0 {
        return [1.0, 0.0, 0.0];
    }
    if s < 0.0 {
        return [chi * s, chi, s];
    }
    let log = (-s).ln_1p();
    let rest = (chi * log).exp();
    [-(chi * log).exp_m1(), chi * rest / (1.0 - s), -rest * log]
}

/// The least-squares problem of a record.
pub(super) type Loop<'a> = Masing<'a, Friction, OF_CURVE>;

impl<'a> Loop<'a> {
    pub(super) fn of(record: &'a Record) -> Self {
        Masing::new(record, Friction { x_range: X_RANGE })
    }
}

/// A minimum with what follows from it.
pub(super) struct Solution {
    pub minimum: Minimum,
    /// Root of the diagonal of the covariance.
    pub errors: Vec<f64>,
    pub residuals: Vec<f64>,
    /// Of the residuals, in the unit of the problem, enlarged where they go together.
    pub variance: f64,
}

impl Solution {
    pub fn new(problem: &Loop, minimum: Minimum) -> Result<Self, Error> {
        let mut residuals = room(problem.count())?;
        problem.residuals(&minimum.parameters, &mut residuals);
        let count = residuals.len();
        let correlation = correlation(&residuals, problem.lengths(), ROUNDING * problem.unit);
        let free = count.saturating_sub(problem.unknowns()).max(1);
        let variance = minimum.sum / free as f64 * inflation(correlation, count);
        let errors = covariance_errors(problem, &minimum, variance);
        Ok(Solution {
            errors,
            minimum,
            residuals,
            variance,
        })
    }

    /// Value and standard error of an unknown, both times a factor.
    pub fn estimate(&self, index: usize, factor: f64) -> Estimate {
        Estimate {
            value: self.minimum.parameters[index] * factor,
            error: self.errors[index] * factor.abs(),
        }
    }
}

/// Standard errors of the unknowns. One that stands at a bound, as a clearance that is never reached does, has no
/// influence and stays out.
fn covariance_errors(problem: &Loop, minimum: &Minimum, variance: f64) -> Vec<f64> {
    let all = minimum.parameters.len();
    let inside: Vec<usize> = (0..all)
        .filter(|&k| k < UNKNOWNS || minimum.normal[(k, k)] > 0.0)
        .collect();
    let part = DMatrix::from_fn(inside.len(), inside.len(), |i, k| {
        minimum.normal[(inside[i], inside[k])]
    });
    debug_assert_eq!(problem.unknowns(), all);
    let mut errors = vec![f64::INFINITY; all];
    if let Some(inverse) = part.try_inverse() {
        for (at, &k) in inside.iter().enumerate() {
            let square = inverse[(at, at)];
            // Not positive: lost in rounding.
            if square > 0.0 {
                errors[k] = (square * variance).sqrt();
            }
        }
    }
    errors
}

impl Record {
    /// The four parameters by least squares over all branches at once, without the judgement of [`super::identify`] on
    /// whether the model describes the loop.
    ///
    /// The standard errors take the residuals for noise in the force; when neighbouring residuals are alike they are
    /// enlarged for the smaller number of independent ones.
    ///
    /// # Errors
    /// [`Kind::BadInput`] when no curve of the model resembles the data.
    pub fn least_squares(&self) -> Result<Fit, Error> {
        let problem = Loop::of(self);
        let valley = valley(&problem, 1);
        let best = lowest(&problem, &valley).ok_or_else(|| bad("no start for the search"))?;
        let solution = Solution::new(&problem, best)?;
        let mut fit = fit_of(&problem, &solution)?;
        fit.warnings = warnings(&fit, &problem, &solution, &valley);
        fit.residuals = solution.residuals;
        Ok(fit)
    }

    /// Least squares from known parameters, for data that differ little from those that gave them (resampling): nothing
    /// is searched, and no warnings are looked for.
    ///
    /// # Errors
    /// As [`Record::least_squares`].
    pub fn least_squares_from(&self, start: &Fit) -> Result<Fit, Error> {
        let mut problem = Loop::of(self);
        problem.stop = start.stop.is_some();
        let minimum = minimise(&problem, unknowns(&problem, start), 1, EXACT);
        let solution = Solution::new(&problem, minimum)?;
        let mut fit = fit_of(&problem, &solution)?;
        fit.residuals = solution.residuals;
        Ok(fit)
    }

    /// Measured minus modelled force for the points of the branches.
    ///
    /// # Errors
    /// [`Kind::BadInput`] when there is no memory for them.
    pub fn residuals(&self, joint: &Iwan, offset: f64) -> Result<Vec<f64>, Error> {
        let problem = Loop::of(self);
        let mut residuals = room(problem.count())?;
        problem.residuals(&of_joint(&problem, joint, offset).into(), &mut residuals);
        Ok(residuals)
    }
}

/// The fit that a solution stands for, without its residuals and warnings.
pub(super) fn fit_of(problem: &Loop, solution: &Solution) -> Result<Fit, Error> {
    let amplitude = problem.record.amplitude;
    let unknowns = &solution.minimum.parameters;
    let joint = Iwan::new([
        unknowns[0] * problem.unit,
        unknowns[1].exp() * amplitude,
        unknowns[3] * problem.unit / amplitude,
        unknowns[2] - CHI_OFFSET,
    ]);
    let joint = joint.map_err(|_| {
        bad("the loop dissipates nothing, or turns the wrong way: no joint resembles it")
    })?;
    let count = solution.residuals.len();
    let log_error = solution.errors[1];
    let stiffness = problem.unit / amplitude;
    let standard_errors = [
        solution.errors[0] * problem.unit,
        log_error * joint.displacement,
        solution.errors[3] * stiffness,
        solution.errors[2],
    ];
    let t = student(count.saturating_sub(problem.unknowns()).max(1) as f64);
    let parameters = joint.parameters();
    let intervals = std::array::from_fn(|index| {
        let (value, half) = (parameters[index], t * standard_errors[index]);
        match index {
            // X_s is estimated by its logarithm.
            1 => [
                value * (-t * log_error).exp(),
                value * (t * log_error).exp(),
            ],
            _ => [value - half, value + half],
        }
    });
    let stop = problem.stop.then(|| {
        let first = UNKNOWNS + problem.columns.len();
        let clearance = |k: usize| {
            let place = solution.estimate(first + k, amplitude);
            // Noise alone leaves a clearance just below the amplitude.
            let reached = solution.minimum.normal[(first + k, first + k)] > 0.0
                && place.value + PLAINLY * place.error < amplitude;
            reached.then_some(place)
        };
        Stop {
            clearances: [clearance(0), clearance(1)],
            stiffness: solution.estimate(first + 2, stiffness),
        }
    });
    let at_stop = stop.map_or(0.0, |stop| stop.force(amplitude));
    Ok(Fit {
        joint,
        offset: unknowns[4] * problem.unit,
        standard_errors,
        intervals,
        stop,
        peak: joint.peak_force(amplitude) + at_stop,
        residuals: Vec::new(),
        rms: (solution.minimum.sum / count as f64).sqrt() * problem.unit,
        warnings: Vec::new(),
    })
}

fn of_joint(problem: &Loop, joint: &Iwan, offset: f64) -> Vec<f64> {
    let amplitude = problem.record.amplitude;
    vec![
        joint.force / problem.unit,
        (joint.displacement / amplitude).ln(),
        joint.chi(),
        joint.residual * amplitude / problem.unit,
        offset / problem.unit,
    ]
}

/// The unknowns of a fit in the units of a problem; those of further columns are 0.
pub(super) fn unknowns(problem: &Loop, fit: &Fit) -> DVector<f64> {
    let amplitude = problem.record.amplitude;
    let mut all = of_joint(problem, &fit.joint, fit.offset);
    all.resize(UNKNOWNS + problem.columns.len(), 0.0);
    if problem.stop {
        let (clearances, stiffness) = match &fit.stop {
            Some(stop) => (stop.clearances, stop.stiffness.value),
            None => ([None; 2], 0.0),
        };
        all.extend(clearances.map(|side| side.map_or(1.0, |c| c.value / amplitude)));
        all.push(stiffness * amplitude / problem.unit);
    }
    all.into()
}

/// What the fit alone tells that has to be known before the parameters are used.
pub(super) fn warnings(
    fit: &Fit,
    problem: &Loop,
    solution: &Solution,
    valley: &[Bottom],
) -> Vec<Warning> {
    let record = problem.record;
    let mut warnings = Vec::new();
    let reach = fit.joint.displacement / record.amplitude;
    let gross: usize = record
        .branches
        .iter()
        .map(|branch| {
            let factor = branch.masing().1 * branch.direction.sign();
            let slips = |i: &usize| {
                factor * (record.displacement[*i] - branch.start) >= fit.joint.displacement
            };
            branch.points().filter(slips).count()
        })
        .sum();
    let plain = |log_x: f64, chi: f64| 1.0 - shape(PLAIN[0] * (-log_x).exp(), chi)[0] <= PLAIN[1];
    // Gross slip is shown when every curve without it, X_s from the amplitude on, fits worse than chance allows, or has
    // a plain plateau as well.
    let rounding = problem.count() as f64 * ROUNDING * ROUNDING;
    let chance = LIKELY * solution.variance.max(rounding);
    let as_good_without = || {
        let without = Loop {
            curve: Friction {
                x_range: [1.0, X_RANGE[1]],
            },
            ..problem.clone()
        };
        let stride = search_stride(problem);
        let least = sum_of_squares(problem, &solution.minimum.parameters, stride);
        let starts = starts(&valley[X_STEPS[0] as usize..]);
        rough_search(&without, starts).is_some_and(|minimum| {
            (minimum.sum - least) * stride as f64 <= chance
                && !plain(minimum.parameters[1], minimum.parameters[2])
        })
    };
    let plateau = plain(reach.ln(), fit.joint.chi());
    if (reach >= 1.0 || gross == 0) && !plateau || as_good_without() {
        warnings.push(Warning::NoGrossSlip { reach });
    } else if fit.joint.force > CANCELLING * problem.unit {
        warnings.push(Warning::NoJoint(fit.joint.force / problem.unit));
    } else if gross < 2 * FEW_GROSS && !plateau {
        warnings.push(Warning::FewGrossSlipPoints(gross));
    }
    let scatter = record.scatter / record.amplitude;
    if scatter > NOISY {
        warnings.push(Warning::NoisyDisplacement(scatter));
    }
    if reach <= X_RANGE[0] * (1.0 + 1e-9) || reach >= X_RANGE[1] * (1.0 - 1e-9) {
        warnings.push(Warning::DisplacementAtBound(reach));
    }
    let up: usize = record
        .branches
        .iter()
        .filter(|b| b.direction.sign() > 0.0)
        .map(|b| b.count())
        .sum();
    let fewest = up.min(record.points() - up);
    if fewest < FEW_POINTS {
        warnings.push(Warning::FewPoints(fewest));
    }
    for (index, value) in fit.joint.parameters().into_iter().enumerate() {
        let scale = match index {
            3 => 1.0,
            // A residual stiffness may well be zero: measured by the secant of the loop.
            2 => value.abs().max(0.1 * problem.unit / record.amplitude),
            _ => value.abs(),
        };
        let error = fit.standard_errors[index] / scale;
        if error > ILL {
            warnings.push(Warning::IllDetermined { index, error });
        }
    }
    let chi = fit.joint.chi();
    if chi <= CHI_RANGE[0] + 1e-9 || chi >= CHI_RANGE[1] - 1e-9 {
        warnings.push(Warning::ChiAtBound(chi));
    }
    let correlation = correlation(
        &solution.residuals,
        problem.lengths(),
        ROUNDING * problem.unit,
    );
    if correlation > CORRELATED {
        warnings.push(Warning::Correlated(correlation));
    }
    warnings
}

/// The refusal of forces.
pub(super) fn bad(words: &str) -> Error {
    Error::new(Kind::BadInput, format!("force: {words}"))
}

/// The 97.5 % point of Student's distribution, by its expansion about the normal one.
pub(super) fn student(degrees: f64) -> f64 {
    let z: f64 = 1.959_963_985;
    let z2 = z * z;
    let first = (z2 + 1.0) / 4.0;
    let second = ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let third = (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    z * (1.0 + (first + (second + third / degrees) / degrees) / degrees)
}

/// A place on the bottom of the valley.
#[derive(Clone, Debug)]
pub(super) struct Bottom {
    /// The sum of squares there.
    pub sum: f64,
    pub unknowns: DVector<f64>,
}

/// The least sum of squares near the lowest places of the valley.
pub(super) fn lowest(problem: &Loop, valley: &[Bottom]) -> Option<Minimum> {
    search(problem, starts(valley))
}

/// The lowest places of a valley.
fn starts(valley: &[Bottom]) -> Vec<DVector<f64>> {
    let sum = |k: usize| valley.get(k).map_or(f64::INFINITY, |bottom| bottom.sum);
    let mut places: Vec<usize> = (0..valley.len())
        .filter(|&k| sum(k) <= sum(k.wrapping_sub(1)) && sum(k) <= sum(k + 1))
        .collect();
    places.sort_by(|a, b| sum(*a).total_cmp(&sum(*b)));
    places.truncate(STARTS);
    // The bottom is a little rough where a loop is not quite of the model: the places beside the lowest may lead lower.
    if let Some(&first) = places.first() {
        places.extend(first.checked_sub(1));
        places.extend((first + 1 < valley.len()).then_some(first + 1));
    }
    let starts = places.into_iter().map(|k| valley[k].unknowns.clone());
    starts.collect()
}

/// The bottom of the valley, from the least X_s to the greatest, at every so many-th place.
pub(super) fn valley(problem: &Loop, every: usize) -> Vec<Bottom> {
    let [low, high] = X_RANGE.map(f64::ln);
    let part = |k: i32, steps: i32| f64::from(k) / f64::from(steps);
    let to_amplitude = (0..X_STEPS[0]).map(|k| low * (1.0 - part(k, X_STEPS[0])));
    let beyond = (0..=X_STEPS[1]).map(|k| high * part(k, X_STEPS[1]));
    let all = to_amplitude.chain(beyond);
    all.step_by(every)
        .map(|log_x| bottom(problem, log_x))
        .collect()
}

/// The best of the other unknowns for this X_s.
fn bottom(problem: &Loop, log_x: f64) -> Bottom {
    let stride = problem.count().div_ceil(VALLEY_POINTS);
    let at = |chi: f64| linear(problem, log_x, chi, stride);
    let better = |a: Bottom, b: Bottom| if b.sum < a.sum { b } else { a };
    let cells = CHI_GRID.map(at);
    let sum = |k: &usize| cells[*k].sum;
    let best = (0..CHI_GRID.len())
        .min_by(|a, b| sum(a).total_cmp(&sum(b)))
        .unwrap_or(0);
    let mut low = CHI_GRID[best.saturating_sub(1)];
    let mut high = CHI_GRID[(best + 1).min(CHI_GRID.len() - 1)];
    let inner = |low: f64, high: f64| GOLDEN * (high - low);
    let mut below = at(high - inner(low, high));
    let mut above = at(low + inner(low, high));
    for _ in 0..CHI_SECTIONS {
        if below.sum < above.sum {
            high = above.unknowns[2];
            above = below;
            below = at(high - inner(low, high));
        } else {
            low = below.unknowns[2];
            below = above;
            above = at(low + inner(low, high));
        }
    }
    // At an end of the range it is the end itself.
    better(cells[best].clone(), better(below, above))
}

/// Best F_s, k_alpha, mean force and factors of columns for given X_s and chi.
fn linear(problem: &Loop, log_x: f64, chi: f64, stride: usize) -> Bottom {
    let count = problem.unknowns();
    let mut unknowns = DVector::zeros(count);
    (unknowns[0], unknowns[1], unknowns[2]) = (1.0, log_x, chi);
    // Of the unknowns, the linear ones: F_s, then all behind the curve's.
    let place = |k: usize| if k == 0 { 0 } else { k + OF_CURVE - 1 };
    let size = count - OF_CURVE + 1;
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    let mut square = 0.0;
    problem.visit(&unknowns, stride, &mut |residual, row| {
        // At F_s = 1 and nothing else, the model's force is the first derivative.
        let force = row[0] - residual;
        square += force * force;
        for i in 0..size {
            right[i] += row[place(i)] * force;
            for k in 0..=i {
                matrix[(i, k)] += row[place(i)] * row[place(k)];
            }
        }
    });
    matrix.fill_upper_triangle_with_lower_triangle();
    let solution = matrix
        .cholesky()
        .map_or_else(|| DVector::zeros(size), |c| c.solve(&right));
    // A friction force must be positive.
    let sum = if solution[0] > 0.0 {
        square - solution.dot(&right)
    } else {
        square
    };
    for k in 0..size {
        unknowns[place(k)] = solution[k];
    }
    unknowns[0] = unknowns[0].max(1e-6);
    Bottom { sum, unknowns }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cycles, the second one larger, so that every kind of branch is there.
    fn record() -> Record {
        let x: Vec<f64> = (0..=800)
            .map(|k| {
                let turn = f64::from(k) / 400.0;
                (if turn < 1.0 { 0.6 } else { 1.0 }) * (std::f64::consts::TAU * turn).sin()
            })
            .collect();
        let force = x.iter().enumerate();
        let force: Vec<f64> = force
            .map(|(k, x)| x + 0.3 * (std::f64::consts::TAU * k as f64 / 400.0).cos())
            .collect();
        Record::new(&x, &force).expect("a loop")
    }

    #[test]
    fn derivatives_are_those_of_the_residual() {
        let record = record();
        let mut problem = Loop::of(&record);
        problem.columns = vec![record.displacement.iter().map(|x| x * x).collect()];
        problem.stop = true;
        for log_x in [-0.8f64, 0.3] {
            let at = DVector::from_column_slice(&[0.8, log_x, 1.7, 0.2, 0.01, 0.1, 0.5, 0.6, 0.4]);
            let collect = |at: &DVector<f64>| {
                let mut all: Vec<(f64, Vec<f64>)> = Vec::new();
                problem.visit(at, 7, &mut |residual, row| {
                    all.push((residual, row.to_vec()))
                });
                all
            };
            let here = collect(&at);
            for k in 0..problem.unknowns() {
                let h = 1e-6;
                let (mut above, mut below) = (at.clone(), at.clone());
                above[k] += h;
                below[k] -= h;
                for ((a, b), here) in collect(&above).iter().zip(collect(&below)).zip(&here) {
                    let slope = (a.0 - b.0) / (2.0 * h);
                    assert!(
                        (slope - here.1[k]).abs() < 1e-7,
                        "{k} {slope} {}",
                        here.1[k]
                    );
                }
            }
        }
    }

    #[test]
    fn every_stride_visits_each_branch() {
        let record = record();
        let problem = Loop::of(&record);
        let at = DVector::from_column_slice(&[0.8, -0.8, 1.7, 0.2, 0.01]);
        for stride in [1, 2, 7, 100, 10_000] {
            let mut count = 0;
            problem.visit(&at, stride, &mut |_, _| count += 1);
            assert_eq!(count, problem.count().div_ceil(stride));
        }
    }

    #[test]
    fn student_of_the_tables() {
        for (degrees, table) in [(10.0, 2.228), (30.0, 2.042), (100.0, 1.984)] {
            assert!((student(degrees) - table).abs() < 2e-3);
        }
    }
}
