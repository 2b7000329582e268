//! What the residuals of a fit show: noise, or the shape of another loop.
//!
//! The residuals are put into bins along the branches, loading and unloading apart, cycles on top of each other. Noise
//! leaves the mean of a bin near zero, as near as the scatter within the bins, and its correlation, allow; the rest is
//! shape.

use super::record::Record;
use super::warning::Warning;

/// Bins along a branch, and points of one at least.
const BINS: usize = 24;
const BIN_POINTS: usize = 8;
/// Branches are told apart by their amplitude, so many of them.
const AMPLITUDES: usize = 4;
/// A sum of squares so many standard deviations above what noise gives is none.
const NO_NOISE: f64 = 6.0;
/// Bounds as parts of T_max: residual, its part that is shape, that in which the branches differ, the force at the
/// ends.
const MISFIT: f64 = 0.05;
const SHAPE: f64 = 0.02;
const BRANCHES: f64 = 0.015;
const PEAK: f64 = 0.03;
/// Unknowns of the model, which take so much out of the bins.
const UNKNOWNS: f64 = 5.0;

/// A sum of squares over bins, against noise.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Excess {
    /// Mean square of what is no noise; noise may make it negative.
    pub square: f64,
    /// How far it lies above noise, in standard deviations.
    pub deviations: f64,
}

impl Excess {
    /// From the sum of squares over their variances, and the variance of the mean square of one unit of it.
    fn new(sum: f64, free: f64, unit: f64) -> Self {
        if free < 1.0 {
            return Excess::default();
        }
        Excess {
            square: (sum - free) * unit,
            deviations: (sum - free) / (2.0 * free).sqrt(),
        }
    }

    /// Whether noise does not have it.
    pub fn is_plain(&self) -> bool {
        self.deviations > NO_NOISE
    }
}

/// What residuals show.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residuals {
    /// In all bins.
    pub shape: Excess,
    /// In the difference of loading and unloading.
    pub branches: Excess,
    /// At the end of the largest branches, with the sign of the force there, and its standard deviation.
    peak: [f64; 2],
}

/// Sums over a bin: points, place, its square, residual, and place times residual.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: f64,
    place: f64,
    square: f64,
    sum: f64,
    product: f64,
}

impl Bin {
    fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// How far a residual is from the line through the bin.
    fn deviation(&self, place: f64, residual: f64) -> f64 {
        let middle = self.place / self.count;
        let width = self.square - self.place * middle;
        let slope = if width > 1e-12 * self.square {
            (self.product - self.sum * middle) / width
        } else {
            0.0
        };
        residual - self.mean() - slope * (place - middle)
    }
}

impl Residuals {
    /// Of residuals in the order of the branches; those below `rounding` are none.
    pub fn new(record: &Record, residuals: &[f64], rounding: f64) -> Self {
        let bins = (record.points() / (2 * BIN_POINTS)).clamp(4, BINS);
        // Bin, place in it, and the residual turned so that every branch loads.
        let each = |take: &mut dyn FnMut(usize, f64, f64)| {
            let mut rest = residuals.iter();
            for branch in &record.branches {
                let sign = branch.direction.sign();
                let size = branch.amplitude / record.amplitude * AMPLITUDES as f64;
                let size = ((size - 0.5).max(0.0) as usize).min(AMPLITUDES - 1);
                let side = usize::from(sign < 0.0) * AMPLITUDES + size;
                for (index, residual) in branch.points().zip(&mut rest) {
                    let x = sign * (record.displacement[index] - record.centre) / branch.amplitude;
                    // Equal parts of a harmonic motion: fine near the ends.
                    let phase = x.clamp(-1.0, 1.0).asin() / std::f64::consts::PI + 0.5;
                    let at = phase * bins as f64;
                    let bin = (at as usize).min(bins - 1);
                    take(side * bins + bin, at - bin as f64, sign * residual);
                }
            }
        };
        let mut all = vec![Bin::default(); 2 * AMPLITUDES * bins];
        each(&mut |bin, place, residual| {
            let bin = &mut all[bin];
            bin.count += 1.0;
            bin.place += place;
            bin.square += place * place;
            bin.sum += residual;
            bin.product += place * residual;
        });
        let (mut square, mut product) = (0.0, 0.0);
        let mut before = (usize::MAX, 0.0);
        each(&mut |bin, place, residual| {
            let deviation = all[bin].deviation(place, residual);
            square += deviation * deviation;
            if before.0 == bin {
                product += before.1 * deviation;
            }
            before = (bin, deviation);
        });
        let used = || all.iter().filter(|bin| bin.count > 2.0);
        let points = residuals.len() as f64;
        let free = (points - 2.0 * used().count() as f64).max(1.0);
        let variance = (square / free).max(rounding * rounding);
        let correlation = (product / square.max(f64::MIN_POSITIVE)).clamp(0.0, 0.95);
        let chance = 3.0 / points.sqrt();
        let inflation = if correlation > chance {
            (1.0 + correlation) / (1.0 - correlation)
        } else {
            1.0
        };
        let variance = variance * inflation;
        let unit = variance / points;
        let sum: f64 = used().map(|b| b.count * b.mean().powi(2)).sum::<f64>() / variance;
        let shape = Excess::new(sum, used().count() as f64 - UNKNOWNS, unit);
        let (up, down) = all.split_at(AMPLITUDES * bins);
        let pairs = || {
            let pairs = up.iter().zip(down);
            pairs.filter(|(a, b)| a.count > 2.0 && b.count > 2.0)
        };
        // A half of the difference, with the weight that makes its variance that of one residual.
        let sum = pairs().map(|(a, b)| {
            let half = 0.5 * (a.mean() - b.mean());
            4.0 / (1.0 / a.count + 1.0 / b.count) * half * half
        });
        let branches = Excess::new(
            sum.sum::<f64>() / variance,
            pairs().count() as f64 - 1.0,
            unit,
        );
        let ends = [&up[AMPLITUDES * bins - 1], &down[AMPLITUDES * bins - 1]];
        let count: f64 = ends.iter().map(|bin| bin.count).sum();
        let end = ends.iter().map(|bin| bin.sum).sum::<f64>() / count.max(1.0);
        Residuals {
            shape,
            branches,
            peak: [end, (variance / count.max(1.0)).sqrt()],
        }
    }

    /// What makes the fit one that does not describe the loop, for a force `peak` at its ends and this misfit.
    pub fn warnings(&self, peak: f64, misfit: f64) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if misfit > MISFIT {
            warnings.push(Warning::Misfit(misfit));
        }
        let part = |excess: Excess| {
            let part = excess.square.max(0.0).sqrt() / peak.abs();
            if excess.is_plain() { part } else { 0.0 }
        };
        let shape = part(self.shape);
        if shape > SHAPE {
            warnings.push(Warning::Shape(shape));
        }
        let branches = part(self.branches);
        if branches > BRANCHES {
            warnings.push(Warning::Branches(branches));
        }
        let [end, deviation] = self.peak;
        if end.abs() > PEAK * peak.abs() && end.abs() > NO_NOISE * deviation {
            warnings.push(Warning::Peak(end.abs() / peak.abs()));
        }
        warnings
    }
}
