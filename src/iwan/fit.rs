//! Joint least squares over all branches of the loop, and what the data can tell about each parameter.
//!
//! Everything is scaled: displacement by the amplitude A, force by the half range T. The unknowns are F_s / T, ln(X_s / A),
//! k_alpha A / T, chi, and the mean force over T, which a real record has and nobody wants to know. Given X_s and chi the
//! others are linear. X_s and kappa lie in a long and narrow valley: its bottom, the best chi for each of many X_s with the linear
//! unknowns eliminated, tells where to start.

use super::least_squares::{Minimum, Problem, correlation, inflation, minimise, search};
use super::record::{Point, Record};
use super::{CHI_OFFSET, Iwan, NAMES};
use crate::error::{Error, Kind};
use nalgebra::{DVector, Matrix3, SMatrix, Vector3};
use std::fmt;

/// chi is looked for in this range.
const CHI_RANGE: [f64; 2] = [1.0, 12.0];
/// X_s over the amplitude, likewise.
const X_RANGE: [f64; 2] = [1e-3, 20.0];
/// Steps of X_s along the valley, from the least to the amplitude and from there to the greatest.
const X_STEPS: [i32; 2] = [34, 15];
/// Where the search for the best chi at an X_s starts, and how many golden sections it ends with.
const CHI_GRID: [f64; 10] = [1.0, 1.15, 1.4, 1.7, 2.0, 2.5, 3.2, 4.5, 7.0, 12.0];
const CHI_SECTIONS: usize = 15;
const GOLDEN: f64 = 0.618_033_988_75;
/// Minima along the valley that are followed.
const STARTS: usize = 5;
/// At most so many points are used to draw it.
const VALLEY_POINTS: usize = 1000;
/// Fewer points per direction than this, or in gross slip, leave the fit to chance.
const FEW_POINTS: usize = 25;
const FEW_GROSS: usize = 5;
/// A standard error beyond this part of the parameter (of 1 for kappa) is no determination.
pub const ILL: f64 = 0.1;
/// A standard error of F_s or X_s beyond this part says nothing of it.
const NOTHING: f64 = 1.0;
/// Neighbouring residuals with a larger correlation are not noise alone.
pub const CORRELATED: f64 = 0.3;
/// A friction force beyond so many times the half range of the force is none.
const CANCELLING: f64 = 2.0;
/// Scatter of the displacement, as a part of the amplitude, that shifts X_s and kappa by more than a standard error.
const NOISY: f64 = 0.003;
/// A sum of squares at the 95 % point of chi^2 with one degree of freedom above the least is still likely.
const LIKELY: f64 = 3.841_459;
/// Residuals below this part of the force range are rounding.
const ROUNDING: f64 = 1e-7;
/// Number of unknowns.
const UNKNOWNS: usize = 5;

/// Something that the user of the parameters has to know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// The data do not show that gross slip was reached: the parameters are an extrapolation.
    NoGrossSlip {
        /// X_s over the amplitude, as fitted.
        reach: f64,
    },
    /// So few points in one direction.
    FewPoints(usize),
    /// So few points in gross slip.
    FewGrossSlipPoints(usize),
    /// Parameter `index` has this standard error, relative (kappa: absolute).
    IllDetermined {
        /// Index into [`NAMES`].
        index: usize,
        /// The standard error.
        error: f64,
    },
    /// chi stands at an end of its range.
    ChiAtBound(f64),
    /// The displacement scatters by this part of the amplitude.
    NoisyDisplacement(f64),
    /// Friction and residual stiffness cancel: F_s is so many times the half range of the force.
    NoJoint(f64),
    /// X_s, over the amplitude, stands at the lower end of its range.
    DisplacementAtBound(f64),
    /// Neighbouring residuals are alike, with this correlation: the loop is not quite one of the model.
    Misfit(f64),
}

impl Warning {
    /// True when the parameters must not be used as they are.
    pub fn is_severe(&self) -> bool {
        match self {
            Warning::NoGrossSlip { .. } | Warning::NoJoint(_) => true,
            Warning::IllDetermined { index, error } => *index < 2 && *error > NOTHING,
            _ => false,
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NoGrossSlip { reach } if *reach >= 1.0 => write!(
                out,
                "no gross slip in the data (X_s would be {reach:.2} amplitudes): F_s, X_s, k_alpha and kappa are an extrapolation; \
                 measure with a larger amplitude"
            ),
            Warning::NoGrossSlip { reach } => write!(
                out,
                "the data do not show gross slip: X_s is {reach:.2} amplitudes, but a curve with X_s beyond the amplitude fits no \
                 worse than their scatter and misfit allow; F_s, X_s, k_alpha and kappa are an extrapolation"
            ),
            Warning::NoJoint(ratio) => write!(
                out,
                "F_s is {ratio:.1} times the half range of the force, and k_alpha takes it back: the loop is not one of this model"
            ),
            Warning::DisplacementAtBound(x) => write!(
                out,
                "X_s = {x} amplitudes is the end of the range that was searched: nothing can be said of X_s and kappa"
            ),
            Warning::NoisyDisplacement(part) => write!(
                out,
                "the displacement scatters by {:.1} % of the amplitude: X_s and kappa come out too small, by more than the \
                 standard errors tell",
                100.0 * part
            ),
            Warning::FewPoints(count) => {
                write!(
                    out,
                    "only {count} points in one direction, {FEW_POINTS} are few"
                )
            }
            Warning::FewGrossSlipPoints(count) => write!(
                out,
                "only {count} points in gross slip: k_alpha and F_s rest on them"
            ),
            Warning::IllDetermined { index: 3, error } => {
                write!(out, "kappa is ill-determined: standard error {error:.2}")
            }
            Warning::IllDetermined { index, error } => write!(
                out,
                "{} is ill-determined: standard error {:.0} %",
                NAMES[*index],
                100.0 * error
            ),
            Warning::ChiAtBound(chi) => write!(
                out,
                "chi = {chi} is the end of the range that was searched: the loop has another shape"
            ),
            Warning::Misfit(correlation) => write!(
                out,
                "neighbouring residuals are alike (correlation {correlation:.2}): the loop is not quite of this model; \
                 the standard errors are enlarged as for noise of that kind, a bias is not in them"
            ),
        }
    }
}

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
    /// Measured minus fitted force, for the points of the loop, branch after branch.
    pub residuals: Vec<f64>,
    /// Their root mean square.
    pub rms: f64,
    /// What has to be known before the parameters are used.
    pub warnings: Vec<Warning>,
}

impl Fit {
    /// False when the parameters are an extrapolation.
    pub fn is_reliable(&self) -> bool {
        !self.warnings.iter().any(Warning::is_severe)
    }
}

impl Record {
    /// The four parameters by least squares over all branches at once.
    ///
    /// The standard errors take the residuals for noise in the force; when neighbouring residuals are alike they are
    /// enlarged for the smaller number of independent ones.
    ///
    /// # Errors
    /// [`Kind::BadInput`] when no curve of the model resembles the data.
    pub fn least_squares(&self) -> Result<Fit, Error> {
        let scaled = Scaled::new(self, X_RANGE);
        let valley = scaled.valley();
        let best = lowest(&scaled, &valley).ok_or_else(|| bad("no start for the search"))?;
        let mut fit = self.fit_at(&scaled, &best)?;
        fit.warnings = self.warnings(&fit, &scaled, &best, &valley);
        Ok(fit)
    }

    /// Least squares from known parameters, for data that differ little from those that gave them (resampling): nothing is
    /// searched, and no warnings are looked for.
    ///
    /// # Errors
    /// As [`Record::least_squares`].
    pub fn least_squares_from(&self, start: &Fit) -> Result<Fit, Error> {
        let scaled = Scaled::new(self, X_RANGE);
        let start = scaled.unknowns(&start.joint, start.offset);
        self.fit_at(&scaled, &minimise(&scaled, start))
    }

    /// Measured minus modelled force for the points of the loop, branch after branch.
    pub fn residuals(&self, joint: &Iwan, offset: f64) -> Vec<f64> {
        let scaled = Scaled::new(self, X_RANGE);
        let unknowns = scaled.unknowns(joint, offset);
        let mut gradient = [0.0; UNKNOWNS];
        (0..scaled.count())
            .map(|index| -scaled.residual(&unknowns, index, &mut gradient) * scaled.unit)
            .collect()
    }

    /// The fit that a minimum stands for.
    fn fit_at(&self, scaled: &Scaled, best: &Minimum) -> Result<Fit, Error> {
        let (joint, offset) = scaled.joint(&best.parameters)?;
        let residuals = self.residuals(&joint, offset);
        let count = residuals.len();
        let degrees = (count - UNKNOWNS) as f64;
        let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / count as f64).sqrt();
        let variance = self.variance(scaled, best, &residuals);
        let inverse = (best.normal.clone().try_inverse())
            .ok_or_else(|| bad("the data do not determine the parameters at all"))?;
        let error = |index: usize| match inverse[(index, index)] {
            square if square > 0.0 => (square * variance).sqrt(),
            // Lost in rounding.
            _ => f64::INFINITY,
        };
        let log_error = error(1);
        let stiffness = scaled.unit / self.amplitude;
        let standard_errors = [
            error(0) * scaled.unit,
            log_error * joint.displacement,
            error(2) * stiffness,
            error(3),
        ];
        let t = student(degrees);
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
        Ok(Fit {
            joint,
            offset,
            standard_errors,
            intervals,
            residuals,
            rms,
            warnings: Vec::new(),
        })
    }

    /// The variance to reckon with: that of the residuals, enlarged where they go together.
    fn variance(&self, scaled: &Scaled, best: &Minimum, residuals: &[f64]) -> f64 {
        let count = residuals.len();
        let inflation = inflation(self.correlation(scaled, residuals), count);
        best.sum / (count - UNKNOWNS) as f64 * inflation
    }

    fn correlation(&self, scaled: &Scaled, residuals: &[f64]) -> f64 {
        let branches = self.branches.iter().map(|branch| branch.points.len());
        correlation(residuals, branches, ROUNDING * scaled.unit)
    }

    /// What has to be known before the parameters are used.
    fn warnings(
        &self,
        fit: &Fit,
        scaled: &Scaled,
        best: &Minimum,
        valley: &[Bottom],
    ) -> Vec<Warning> {
        let correlation = self.correlation(scaled, &fit.residuals);
        let variance = self.variance(scaled, best, &fit.residuals);
        let mut warnings = Vec::new();
        let reach = fit.joint.displacement / self.amplitude;
        let gross = scaled.points.iter().filter(|p| p.distance >= reach).count();
        // Gross slip is shown when every curve without it, X_s from the amplitude on, fits worse than chance allows.
        let least_without = || {
            let without = Scaled {
                x_range: [1.0, X_RANGE[1]],
                ..scaled.clone()
            };
            let minimum = lowest(&without, &valley[X_STEPS[0] as usize..]);
            minimum.map_or(f64::INFINITY, |minimum| minimum.sum)
        };
        let rounding = (scaled.points.len() as f64) * ROUNDING * ROUNDING;
        if reach >= 1.0
            || gross == 0
            || least_without() - best.sum <= LIKELY * variance.max(rounding)
        {
            warnings.push(Warning::NoGrossSlip { reach });
        } else if fit.joint.force > CANCELLING * scaled.unit {
            warnings.push(Warning::NoJoint(fit.joint.force / scaled.unit));
        } else if gross < 2 * FEW_GROSS {
            warnings.push(Warning::FewGrossSlipPoints(gross));
        }
        let scatter = self.scatter / self.amplitude;
        if scatter > NOISY {
            warnings.push(Warning::NoisyDisplacement(scatter));
        }
        if reach <= X_RANGE[0] * (1.0 + 1e-9) {
            warnings.push(Warning::DisplacementAtBound(reach));
        }
        let up = scaled.points.iter().filter(|p| p.sign > 0.0).count();
        let fewest = up.min(scaled.points.len() - up);
        if fewest < FEW_POINTS {
            warnings.push(Warning::FewPoints(fewest));
        }
        for (index, value) in fit.joint.parameters().into_iter().enumerate() {
            let scale = match index {
                3 => 1.0,
                // A residual stiffness may well be zero: measured by the secant of the loop.
                2 => value.abs().max(0.1 * scaled.unit / self.amplitude),
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
        if correlation > CORRELATED {
            warnings.push(Warning::Misfit(correlation));
        }
        warnings
    }
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

/// The record in units of its amplitude and its half force range.
#[derive(Clone, Debug)]
struct Scaled {
    points: Vec<Point>,
    amplitude: f64,
    unit: f64,
    x_range: [f64; 2],
}

/// f(s) = 1 - (1 - s)^chi with its derivatives by s and chi.
fn shape(s: f64, chi: f64) -> [f64; 3] {
    if s >= 1.0 {
        return [1.0, 0.0, 0.0];
    }
    // Noise leads beyond the reversal: the curve goes on straight.
    if s < 0.0 {
        return [chi * s, chi, s];
    }
    let log = (-s).ln_1p();
    let rest = (chi * log).exp();
    [-(chi * log).exp_m1(), chi * rest / (1.0 - s), -rest * log]
}

/// A place on the bottom of the valley.
#[derive(Clone, Debug)]
struct Bottom {
    /// The sum of squares there.
    sum: f64,
    unknowns: DVector<f64>,
}

/// The least sum of squares near the lowest places of the valley.
fn lowest(scaled: &Scaled, valley: &[Bottom]) -> Option<Minimum> {
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
    search(scaled, |stride| scaled.every(stride), starts)
}

impl Scaled {
    fn new(record: &Record, x_range: [f64; 2]) -> Self {
        let amplitude = record.amplitude;
        let indices = record.branches.iter().flat_map(|b| &b.points);
        let (low, high) = indices.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            (low.min(record.force[i]), high.max(record.force[i]))
        });
        let unit = 0.5 * (high - low);
        Scaled {
            points: record.scaled(unit),
            amplitude,
            unit,
            x_range,
        }
    }

    /// The same with every so many-th point.
    fn every(&self, stride: usize) -> Self {
        Scaled {
            points: self.points.iter().step_by(stride).cloned().collect(),
            ..*self
        }
    }

    /// F_s / T, ln(X_s / A), k_alpha A / T, chi, mean force / T.
    fn unknowns(&self, joint: &Iwan, offset: f64) -> DVector<f64> {
        DVector::from_column_slice(&[
            joint.force / self.unit,
            (joint.displacement / self.amplitude).ln(),
            joint.residual * self.amplitude / self.unit,
            joint.chi(),
            offset / self.unit,
        ])
    }

    fn joint(&self, unknowns: &DVector<f64>) -> Result<(Iwan, f64), Error> {
        let joint = Iwan::new([
            unknowns[0] * self.unit,
            unknowns[1].exp() * self.amplitude,
            unknowns[2] * self.unit / self.amplitude,
            unknowns[3] - CHI_OFFSET,
        ]);
        let joint = joint.map_err(|_| {
            bad("the loop dissipates nothing, or turns the wrong way: no joint resembles it")
        })?;
        Ok((joint, unknowns[4] * self.unit))
    }

    /// The bottom of the valley, from the least X_s to the greatest.
    fn valley(&self) -> Vec<Bottom> {
        let [low, high] = X_RANGE.map(f64::ln);
        let part = |k: i32, steps: i32| f64::from(k) / f64::from(steps);
        let to_amplitude = (0..X_STEPS[0]).map(|k| low * (1.0 - part(k, X_STEPS[0])));
        let beyond = (0..=X_STEPS[1]).map(|k| high * part(k, X_STEPS[1]));
        let all = to_amplitude.chain(beyond);
        all.map(|log_x| self.bottom(log_x)).collect()
    }

    /// The best of the other unknowns for this X_s.
    fn bottom(&self, log_x: f64) -> Bottom {
        let stride = self.points.len().div_ceil(VALLEY_POINTS);
        let at = |chi: f64| self.linear(log_x, chi, stride);
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
                high = above.unknowns[3];
                above = below;
                below = at(high - inner(low, high));
            } else {
                low = below.unknowns[3];
                below = above;
                above = at(low + inner(low, high));
            }
        }
        // At an end of the range it is the end itself.
        better(cells[best].clone(), better(below, above))
    }

    /// Best F_s, k_alpha and mean force for given X_s and chi.
    fn linear(&self, log_x: f64, chi: f64, stride: usize) -> Bottom {
        let x = log_x.exp();
        let mut matrix = Matrix3::zeros();
        let mut right = Vector3::zeros();
        let mut square = 0.0;
        for p in self.points.iter().step_by(stride) {
            let friction = 2.0 * shape(p.distance / x, chi)[0] - shape(p.amplitude / x, chi)[0];
            let row = Vector3::new(p.sign * friction, p.displacement, 1.0);
            matrix += row * row.transpose();
            right += row * p.force;
            square += p.force * p.force;
        }
        let solution = matrix
            .cholesky()
            .map_or_else(Vector3::zeros, |c| c.solve(&right));
        // A friction force must be positive.
        let sum = if solution[0] > 0.0 {
            square - solution.dot(&right)
        } else {
            square
        };
        let unknowns = [solution[0].max(1e-6), log_x, solution[1], chi, solution[2]];
        Bottom {
            sum,
            unknowns: DVector::from_column_slice(&unknowns),
        }
    }
}

impl Problem for Scaled {
    fn residual(&self, unknowns: &DVector<f64>, index: usize, gradient: &mut [f64]) -> f64 {
        let p = &self.points[index];
        let [force, log_x, residual, chi, offset] =
            [0, 1, 2, 3, 4].map(|unknown| unknowns[unknown]);
        let x = log_x.exp();
        let (s, end) = (p.distance / x, p.amplitude / x);
        let (here, there) = (shape(s, chi), shape(end, chi));
        let friction = 2.0 * here[0] - there[0];
        gradient.copy_from_slice(&[
            p.sign * friction,
            -p.sign * force * (2.0 * here[1] * s - there[1] * end),
            p.displacement,
            p.sign * force * (2.0 * here[2] - there[2]),
            1.0,
        ]);
        p.sign * force * friction + residual * p.displacement + offset - p.force
    }

    fn count(&self) -> usize {
        self.points.len()
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        vec![
            [0.0, f64::INFINITY],
            self.x_range.map(f64::ln),
            free,
            CHI_RANGE,
            free,
        ]
    }
}

/// Least squares for `intercept_0`, `intercept_1` and a common slope: points (side, x, y). Returns the three, their standard
/// errors and the root mean square of the residuals.
pub(super) fn two_lines(points: &[(usize, f64, f64)]) -> Option<([f64; 3], [f64; 3], f64)> {
    let mut matrix = SMatrix::<f64, 3, 3>::zeros();
    let mut right = Vector3::zeros();
    let row = |side: usize, x: f64| {
        let mut row = Vector3::new(0.0, 0.0, x);
        row[side] = 1.0;
        row
    };
    for &(side, x, y) in points {
        matrix += row(side, x) * row(side, x).transpose();
        right += row(side, x) * y;
    }
    let inverse = matrix.try_inverse()?;
    let solution = inverse * right;
    let square: f64 = points
        .iter()
        .map(|&(side, x, y)| (y - solution.dot(&row(side, x))).powi(2))
        .sum();
    let variance = square / points.len().checked_sub(3).filter(|n| *n > 0)? as f64;
    let errors = [0, 1, 2].map(|k| (inverse[(k, k)] * variance).max(0.0).sqrt());
    Some((solution.into(), errors, variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_residual() {
        let point = |sign: f64, distance: f64| Point {
            sign,
            distance,
            amplitude: 1.0,
            displacement: sign * (2.0 * distance - 1.0),
            force: 0.1,
        };
        let scaled = Scaled {
            points: vec![point(1.0, 0.1), point(-1.0, 0.3), point(1.0, 0.9)],
            amplitude: 1.0,
            unit: 1.0,
            x_range: X_RANGE,
        };
        for log_x in [-0.8, 0.3] {
            let at = DVector::from_column_slice(&[0.8, log_x, 0.2, 1.7, 0.01]);
            let mut gradient = [0.0; UNKNOWNS];
            let mut unused = [0.0; UNKNOWNS];
            for index in 0..scaled.count() {
                scaled.residual(&at, index, &mut gradient);
                for k in 0..UNKNOWNS {
                    let h = 1e-6;
                    let (mut above, mut below) = (at.clone(), at.clone());
                    above[k] += h;
                    below[k] -= h;
                    let rise = scaled.residual(&above, index, &mut unused)
                        - scaled.residual(&below, index, &mut unused);
                    assert!((rise / (2.0 * h) - gradient[k]).abs() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn student_of_the_tables() {
        for (degrees, table) in [(10.0, 2.228), (30.0, 2.042), (100.0, 1.984)] {
            assert!((student(degrees) - table).abs() < 2e-3);
        }
    }
}
