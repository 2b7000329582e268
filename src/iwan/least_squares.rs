//! Nonlinear least squares by Levenberg and Marquardt's method, for a handful of bounded parameters.
//!
//! The crate `levenberg-marquardt` was considered: it knows no bounds and keeps the derivatives of all residuals (m x n
//! numbers, several times), where the normal equations here are summed over millions of points in n x n numbers.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

/// A minimum that was found.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The parameters.
    pub parameters: DVector<f64>,
    /// The sum of squared residuals there.
    pub sum: f64,
    /// How many residuals were summed.
    pub count: usize,
    /// J^T J there: its inverse times the variance of the residuals is the covariance of the parameters.
    pub normal: DMatrix<f64>,
}

/// What is to be made small: residuals, and their derivatives row by row.
pub trait Problem {
    /// Hands every `stride`-th residual at these parameters, with its derivatives by every parameter, to `take`.
    fn visit(&self, parameters: &DVector<f64>, stride: usize, take: &mut impl FnMut(f64, &[f64]));

    /// How many residuals there are.
    fn count(&self) -> usize;

    /// The least and the greatest value of every parameter.
    fn bounds(&self) -> Vec<[f64; 2]>;
}

/// Steps after which the search ends in any case.
const MAX_STEPS: usize = 200;
/// A step that lowers the sum by less than this part has arrived: for parameters to all digits, and for sums to
/// compare.
pub const EXACT: f64 = 1e-15;
/// See [`EXACT`].
pub const ROUGH: f64 = 1e-9;

/// At most so many residuals choose between several starts.
const SEARCH: usize = 20_000;

/// The minimum near `start`, of every `stride`-th residual; `arrived` is [`EXACT`] or [`ROUGH`].
pub fn minimise(
    problem: &impl Problem,
    start: DVector<f64>,
    stride: usize,
    arrived: f64,
) -> Minimum {
    let bounds = problem.bounds();
    let inside = |mut parameters: DVector<f64>| {
        for (value, [low, high]) in parameters.iter_mut().zip(&bounds) {
            *value = value.clamp(*low, *high);
        }
        parameters
    };
    let mut at = Normal::new(problem, inside(start), stride);
    let mut damping = 1e-3;
    let mut idle = 0;
    for _ in 0..MAX_STEPS {
        let Some(step) = at.step(damping, &bounds) else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
            continue;
        };
        let next = Normal::new(problem, inside(&at.parameters + step), stride);
        if next.sum < at.sum {
            idle = if at.sum - next.sum <= arrived * at.sum {
                idle + 1
            } else {
                0
            };
            at = next;
            damping = (damping * 0.2).max(1e-15);
        } else {
            damping *= 5.0;
        }
        // Rounding makes the last steps rise and fall at random: two without gain, or none left to take.
        if idle >= 2 || damping > 1e12 {
            break;
        }
    }
    Minimum {
        parameters: at.parameters,
        sum: at.sum,
        count: at.count,
        normal: at.matrix,
    }
}

/// The least of the minima near several starts; of very many residuals some tell which it is. None without a start.
pub fn search<P: Problem>(
    problem: &P,
    starts: impl IntoIterator<Item = DVector<f64>>,
) -> Option<Minimum> {
    let best = rough_search(problem, starts)?;
    // Of very many residuals rounding is the limit earlier.
    let arrived = if search_stride(problem) == 1 {
        EXACT
    } else {
        ROUGH
    };
    Some(minimise(problem, best.parameters, 1, arrived))
}

/// The same without the last refinement: of some of the residuals, as many as the minimum tells.
pub fn rough_search<P: Problem>(
    problem: &P,
    starts: impl IntoIterator<Item = DVector<f64>>,
) -> Option<Minimum> {
    let stride = search_stride(problem);
    let minima = starts
        .into_iter()
        .map(|start| minimise(problem, start, stride, ROUGH));
    minima.min_by(|a, b| a.sum.total_cmp(&b.sum))
}

/// Every so many-th residual takes part in a search.
pub fn search_stride(problem: &impl Problem) -> usize {
    problem.count().div_ceil(SEARCH).max(1)
}

/// The sum of the squares of every `stride`-th residual.
pub fn sum_of_squares(problem: &impl Problem, parameters: &DVector<f64>, stride: usize) -> f64 {
    let mut sum = 0.0;
    problem.visit(parameters, stride, &mut |residual, _| {
        sum += residual * residual
    });
    sum
}

/// Correlation of neighbouring residuals within stretches of these lengths, that follow each other; none where all are
/// smaller than `rounding`.
pub fn correlation(
    residuals: &[f64],
    stretches: impl IntoIterator<Item = usize>,
    rounding: f64,
) -> f64 {
    let mut rest = residuals;
    let (mut product, mut square) = (0.0, 0.0);
    for length in stretches {
        let (ours, others) = rest.split_at(length);
        product += ours.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        square += ours.iter().map(|r| r * r).sum::<f64>();
        rest = others;
    }
    if square <= residuals.len() as f64 * rounding * rounding {
        return 0.0;
    }
    (product / square).clamp(-1.0, 1.0)
}

/// What the variance of so many residuals grows by when their correlation is more than chance: they count as
/// n (1 - c)/(1 + c) independent ones.
pub fn inflation(correlation: f64, count: usize) -> f64 {
    if correlation > 3.0 / (count as f64).sqrt() {
        (1.0 + correlation) / (1.0 - correlation).max(1e-3)
    } else {
        1.0
    }
}

/// Least squares for `intercept_0`, `intercept_1` and a common slope: points (side, x, y). Returns the three, their
/// standard errors and the root mean square of the residuals.
pub fn two_lines(
    points: impl Iterator<Item = (usize, f64, f64)> + Clone,
) -> Option<([f64; 3], [f64; 3], f64)> {
    let mut matrix = SMatrix::<f64, 3, 3>::zeros();
    let mut right = Vector3::zeros();
    let mut count = 0usize;
    let row = |side: usize, x: f64| {
        let mut row = Vector3::new(0.0, 0.0, x);
        row[side] = 1.0;
        row
    };
    for (side, x, y) in points.clone() {
        matrix += row(side, x) * row(side, x).transpose();
        right += row(side, x) * y;
        count += 1;
    }
    let inverse: Matrix3<f64> = matrix.try_inverse()?;
    let solution = inverse * right;
    let square: f64 = points
        .map(|(side, x, y)| (y - solution.dot(&row(side, x))).powi(2))
        .sum();
    let variance = square / count.checked_sub(3).filter(|n| *n > 0)? as f64;
    let errors = [0, 1, 2].map(|k| (inverse[(k, k)] * variance).max(0.0).sqrt());
    Some((solution.into(), errors, variance.sqrt()))
}

/// The normal equations at one place.
struct Normal {
    parameters: DVector<f64>,
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    sum: f64,
    count: usize,
}

impl Normal {
    fn new(problem: &impl Problem, parameters: DVector<f64>, stride: usize) -> Self {
        let n = parameters.len();
        let mut matrix = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let (mut sum, mut count) = (0.0, 0);
        problem.visit(&parameters, stride, &mut |residual, row| {
            sum += residual * residual;
            count += 1;
            for i in 0..n {
                gradient[i] += row[i] * residual;
                for k in 0..=i {
                    matrix[(i, k)] += row[i] * row[k];
                }
            }
        });
        matrix.fill_upper_triangle_with_lower_triangle();
        Normal {
            parameters,
            matrix,
            gradient,
            sum,
            count,
        }
    }

    /// The damped step; parameters that press against a bound stay. None when the matrix is singular.
    fn step(&self, damping: f64, bounds: &[[f64; 2]]) -> Option<DVector<f64>> {
        let n = self.parameters.len();
        let mut matrix = self.matrix.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..n {
            let [low, high] = bounds[i];
            let outward = (self.parameters[i] <= low && gradient[i] > 0.0)
                || (self.parameters[i] >= high && gradient[i] < 0.0);
            if outward {
                matrix.row_mut(i).fill(0.0);
                matrix.column_mut(i).fill(0.0);
                matrix[(i, i)] = 1.0;
                gradient[i] = 0.0;
            }
            // A parameter without any influence must not make the matrix singular.
            matrix[(i, i)] = matrix[(i, i)] * (1.0 + damping) + f64::MIN_POSITIVE;
        }
        Some(-matrix.cholesky()?.solve(&gradient))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley: residuals 1 - x and 10 (y - x^2).
    struct Valley {
        most: f64,
    }

    impl Problem for Valley {
        fn visit(&self, p: &DVector<f64>, stride: usize, take: &mut impl FnMut(f64, &[f64])) {
            take(1.0 - p[0], &[-1.0, 0.0]);
            if stride == 1 {
                take(10.0 * (p[1] - p[0] * p[0]), &[-20.0 * p[0], 10.0]);
            }
        }

        fn count(&self) -> usize {
            2
        }

        fn bounds(&self) -> Vec<[f64; 2]> {
            vec![[-5.0, self.most], [-5.0, 5.0]]
        }
    }

    #[test]
    fn finds_the_end_of_the_valley() {
        let start = DVector::from_column_slice(&[-1.2, 1.0]);
        let found = minimise(&Valley { most: 5.0 }, start.clone(), 1, EXACT);
        assert!((found.parameters[0] - 1.0).abs() < 1e-7 && found.sum < 1e-14);
        // The bound cuts the valley: the rest is minimal along it.
        let cut = minimise(&Valley { most: 0.5 }, start, 1, EXACT);
        assert_eq!(cut.parameters[0], 0.5);
        assert!((cut.parameters[1] - 0.25).abs() < 1e-9);
    }
}
