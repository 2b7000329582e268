//! The power law f = 1 - (1 - r)^chi, the paper's Eq. (9).

use super::{Backbone, Values};

/// Below this over chi the integrals of f come from their series.
const SERIES_BELOW: f64 = 0.05;
/// Terms of the Taylor series used at small r.
const TERMS: usize = 12;

/// From this r on 1 - (1 - r)^chi of the paper's exponent loses nothing worth a division.
const DIRECT_FROM: f64 = 0.1;

/// The paper's exponent, for which the shortest formula is written out.
const PAPER: f64 = 2.5;

/// f = 1 - (1 - r)^chi with chi >= 1.
///
/// chi = 1 is the standard penalty method, chi = 3/2 Cattaneo's and Mindlin's sphere on a flat,
/// chi = 5/2 the paper's choice.
#[derive(Clone, Debug)]
pub struct PowerLaw {
    chi: f64,
    /// 1 / (chi + 1)
    inverse_next: f64,
    /// 2 chi where that is a small whole number: then a square root replaces the logarithm.
    half_powers: Option<u32>,
    /// From this r on the formulas of the paper's exponent hold.
    paper_from: f64,
    /// Coefficients of r^(n+1), n = 1.., in F.
    integral_series: [f64; TERMS],
    /// Coefficients of r^(n+1), n = 1.., in G.
    loss_series: [f64; TERMS],
}

impl PowerLaw {
    /// The power law with exponent `chi` >= 1.
    pub fn new(chi: f64) -> Self {
        // f = sum c_n r^n, so F = sum c_n r^(n+1) / (n+1) and G = sum c_n (1-n)/(1+n) r^(n+1).
        let mut integral_series = [0.0; TERMS];
        let mut loss_series = [0.0; TERMS];
        let mut c = chi;
        for n in 1..=TERMS {
            let order = n as f64;
            integral_series[n - 1] = c / (order + 1.0);
            loss_series[n - 1] = c * (1.0 - order) / (1.0 + order);
            c *= (order - chi) / (order + 1.0);
        }
        let doubled = 2.0 * chi;
        PowerLaw {
            chi,
            inverse_next: 1.0 / (chi + 1.0),
            half_powers: (doubled.fract() == 0.0 && doubled <= 16.0).then_some(doubled as u32),
            paper_from: if chi == PAPER {
                SERIES_BELOW / PAPER
            } else {
                f64::INFINITY
            },
            integral_series,
            loss_series,
        }
    }
}

impl PowerLaw {
    /// Below this r the integrals come from their series: 2 F - r f would cancel.
    fn series_below(&self) -> f64 {
        // The line of chi = 1 is its own series: no loss at all below r = 1.
        if self.chi == 1.0 {
            1.0
        } else {
            SERIES_BELOW / self.chi
        }
    }

    /// All from f and f'. Without the series 2 F - r f cancels at small r.
    #[inline(always)]
    fn values(&self, r: f64, f: f64, slope: f64) -> Values {
        // 1 - (1 - r)^(chi + 1) = r + (1 - r) f. What waits for f is kept short.
        let without = r * (1.0 - self.inverse_next);
        let weight = (1.0 - r) * self.inverse_next;
        Values {
            f,
            slope,
            integral: without - weight * f,
            loss: 2.0 * without - (2.0 * weight + r) * f,
        }
    }

    /// f and f' for any exponent at any r.
    #[inline(never)]
    fn curve(&self, r: f64) -> (f64, f64) {
        let rest = 1.0 - r;
        // f without the cancellation of 1 - (1 - r)^chi, and slope = chi (1 - r)^(chi - 1).
        if let Some(n) = self.half_powers {
            // With u = sqrt(1 - r) and n = 2 chi: 1 - u^n = (1 - u)(1 + u + .. + u^(n-1)) and
            // 1 - u = r / (1 + u).
            let u = rest.sqrt();
            let mut power = 1.0;
            let mut sum = 0.0;
            for _ in 2..n {
                sum += power;
                power *= u;
            }
            sum += power * (1.0 + u);
            (r * sum / (1.0 + u), self.chi * power)
        } else if r < 1.0 {
            let log = (-r).ln_1p();
            (
                -(self.chi * log).exp_m1(),
                self.chi * ((self.chi - 1.0) * log).exp(),
            )
        } else {
            (1.0, 0.0)
        }
    }

    /// F and G from their series.
    #[inline(never)]
    fn series(&self, r: f64) -> (f64, f64) {
        let series = |c: &[f64; TERMS]| c.iter().rev().fold(0.0, |sum, c| sum * r + c) * r * r;
        (series(&self.integral_series), series(&self.loss_series))
    }
}

impl Backbone for PowerLaw {
    // Inlined: values that travel through memory stall the pipeline for longer than the square root takes.
    #[inline(always)]
    fn at(&self, r: f64) -> Values {
        if r >= self.paper_from {
            let rest = 1.0 - r;
            let u = rest.sqrt();
            let f = if r >= DIRECT_FROM {
                1.0 - u * (rest * rest)
            } else {
                // 1 - u rest^2 = (1 - u) + u (1 - rest^2), and 1 - u = r / (1 + u).
                r * (1.0 / (1.0 + u) + u * (1.0 + rest))
            };
            return self.values(r, f, PAPER * rest * u);
        }
        let (f, slope) = self.curve(r);
        let mut values = self.values(r, f, slope);
        if r < self.series_below() {
            (values.integral, values.loss) = self.series(r);
        }
        values
    }

    fn initial_slope(&self) -> f64 {
        self.chi
    }

    fn grid(&self, k: usize, count: usize) -> f64 {
        if k == count {
            return 1.0;
        }
        // 1 - (1 - k/count)^(2/chi)
        -(2.0 / self.chi * (-(k as f64) / count as f64).ln_1p()).exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn square_roots_and_logarithms_give_the_same_curve() {
        for chi in [1.0, 1.5, 2.0, 2.5, 3.0, 6.5] {
            let fast = PowerLaw::new(chi);
            let mut slow = fast.clone();
            slow.half_powers = None;
            slow.paper_from = f64::INFINITY;
            for k in 0..1000 {
                let (a, b) = (fast.at(k as f64 / 1000.0), slow.at(k as f64 / 1000.0));
                assert_relative_eq!(a.f, b.f, epsilon = 0.0, max_relative = 2e-15);
                assert_relative_eq!(a.slope, b.slope, epsilon = 0.0, max_relative = 1e-14);
                assert_relative_eq!(a.integral, b.integral, epsilon = 0.0, max_relative = 1e-12);
            }
        }
    }

    #[test]
    fn series_joins_the_closed_form() {
        for chi in [1.0, 1.3, 2.5, 8.0, 40.0, 1000.0] {
            let law = PowerLaw::new(chi);
            let r = law.series_below();
            let (below, above) = (law.at(r * (1.0 - 1e-15)), law.at(r));
            assert_relative_eq!(
                below.integral,
                above.integral,
                epsilon = 0.0,
                max_relative = 1e-11
            );
            // G is about chi - 1 times smaller than F: compare on the scale of r f.
            assert_relative_eq!(below.loss, above.loss, epsilon = 1e-13 * r);
        }
    }

    #[test]
    fn slope_is_the_derivative_and_f_of_the_integral() {
        for chi in [1.0, 1.2, 2.5, 3.7] {
            let law = PowerLaw::new(chi);
            for r in [1e-3, 0.1, 0.5, 0.9] {
                let h = 1e-5 * r;
                let (a, b) = (law.at(r - h), law.at(r + h));
                let here = law.at(r);
                assert_relative_eq!((b.f - a.f) / (2.0 * h), here.slope, max_relative = 1e-7);
                assert_relative_eq!(
                    (b.integral - a.integral) / (2.0 * h),
                    here.f,
                    max_relative = 1e-7
                );
            }
        }
    }
}
