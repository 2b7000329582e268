//! Nonlinear least squares by Levenberg and Marquardt's method, for a handful of bounded parameters.

use nalgebra::{DMatrix, DVector};

/// A minimum that was found.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The parameters.
    pub parameters: DVector<f64>,
    /// The sum of squared residuals there.
    pub sum: f64,
    /// J^T J there: its inverse times the variance of the residuals is the covariance of the parameters.
    pub normal: DMatrix<f64>,
}

/// What is to be made small: residuals, and their derivatives row by row.
pub trait Problem {
    /// Residual `index` at these parameters; writes its derivative by every parameter into `gradient`.
    fn residual(&self, parameters: &DVector<f64>, index: usize, gradient: &mut [f64]) -> f64;

    /// How many residuals there are.
    fn count(&self) -> usize;

    /// The least and the greatest value of every parameter.
    fn bounds(&self) -> Vec<[f64; 2]>;
}

/// Steps after which the search ends in any case.
const MAX_STEPS: usize = 200;
/// A step that lowers the sum by less than this part has arrived.
const ARRIVED: f64 = 1e-15;

/// At most so many residuals choose between several starts.
const SEARCH: usize = 20_000;

/// The minimum near `start`.
pub fn minimise(problem: &impl Problem, start: DVector<f64>) -> Minimum {
    let bounds = problem.bounds();
    let inside = |mut parameters: DVector<f64>| {
        for (value, [low, high]) in parameters.iter_mut().zip(&bounds) {
            *value = value.clamp(*low, *high);
        }
        parameters
    };
    let mut at = Normal::new(problem, inside(start));
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
        let next = Normal::new(problem, inside(&at.parameters + step));
        if next.sum < at.sum {
            idle = if at.sum - next.sum <= ARRIVED * at.sum {
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
        normal: at.matrix,
    }
}

/// The least of the minima near several starts; of very many residuals some tell which it is. `every` gives the problem of every
/// k-th one. None without a start.
pub fn search<P: Problem>(
    problem: &P,
    every: impl FnOnce(usize) -> P,
    starts: impl IntoIterator<Item = DVector<f64>>,
) -> Option<Minimum> {
    let least = |problem: &P| {
        let minima = starts.into_iter().map(|start| minimise(problem, start));
        minima.min_by(|a, b| a.sum.total_cmp(&b.sum))
    };
    let stride = problem.count().div_ceil(SEARCH);
    if stride <= 1 {
        return least(problem);
    }
    let best = least(&every(stride))?;
    Some(minimise(problem, best.parameters))
}

/// Correlation of neighbouring residuals within stretches of these lengths, that follow each other; none where all are smaller
/// than `rounding`.
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

/// The normal equations at one place.
struct Normal {
    parameters: DVector<f64>,
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    sum: f64,
}

impl Normal {
    fn new(problem: &impl Problem, parameters: DVector<f64>) -> Self {
        let n = parameters.len();
        let mut matrix = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let mut sum = 0.0;
        let mut row = vec![0.0; n];
        for index in 0..problem.count() {
            let residual = problem.residual(&parameters, index, &mut row);
            sum += residual * residual;
            for i in 0..n {
                gradient[i] += row[i] * residual;
                for k in 0..=i {
                    matrix[(i, k)] += row[i] * row[k];
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        Normal {
            parameters,
            matrix,
            gradient,
            sum,
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
        fn residual(&self, p: &DVector<f64>, index: usize, gradient: &mut [f64]) -> f64 {
            if index == 0 {
                gradient.copy_from_slice(&[-1.0, 0.0]);
                1.0 - p[0]
            } else {
                gradient.copy_from_slice(&[-20.0 * p[0], 10.0]);
                10.0 * (p[1] - p[0] * p[0])
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
        let found = minimise(&Valley { most: 5.0 }, start.clone());
        assert!((found.parameters[0] - 1.0).abs() < 1e-7 && found.sum < 1e-14);
        // The bound cuts the valley: the rest is minimal along it.
        let cut = minimise(&Valley { most: 0.5 }, start);
        assert_eq!(cut.parameters[0], 0.5);
        assert!((cut.parameters[1] - 0.25).abs() < 1e-9);
    }
}
