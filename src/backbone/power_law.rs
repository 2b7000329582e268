//! The power law f = 1 - (1 - r)^chi, the paper's Eq. (9).

use super::{Backbone, Values};

/// Below this over chi the integrals of f come from their series.
const SERIES_BELOW: f64 = 0.05;
/// Terms of the Taylor series used at small r.
const TERMS: usize = 12;
/// The largest 2 chi for which powers of a square root replace the logarithm.
const MOST_HALVES: usize = 12;

/// f = 1 - (1 - r)^chi with chi >= 1.
///
/// chi = 1 is the standard penalty method, chi = 3/2 Cattaneo's and Mindlin's sphere on a flat,
/// chi = 5/2 the paper's choice.
#[derive(Clone, Debug)]
pub struct PowerLaw {
    chi: f64,
    /// 2 chi where that is a small whole number, else 0.
    halves: usize,
    /// Coefficients of r^(n+1), n = 1.., in F.
    integral_series: [f64; TERMS],
    /// Coefficients of r^(n+1), n = 1.., in L.
    loss_series: [f64; TERMS],
    end: Values,
}

impl PowerLaw {
    /// The power law with exponent `chi` >= 1.
    pub fn new(chi: f64) -> Self {
        // f = sum c_n r^n, so F = sum c_n r^(n+1) / (n+1) and L = sum c_n (1-n)/(1+n) r^(n+1).
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
        let mut curve = PowerLaw {
            chi,
            halves: if doubled.fract() == 0.0 && doubled <= MOST_HALVES as f64 {
                doubled as usize
            } else {
                0
            },
            integral_series,
            loss_series,
            end: Values::default(),
        };
        curve.end = curve.at(1.0);
        curve
    }

    /// Any exponent: one logarithm and one exponential.
    #[inline(never)]
    fn general(&self, r: f64) -> Values {
        let chi = self.chi;
        let rest = 1.0 - r;
        if rest <= 0.0 {
            // The corner: all elements slip. chi > 1 here, so that f' is 0.
            return Values {
                f: 1.0,
                slope: 0.0,
                integral: chi / (chi + 1.0),
                loss: (chi - 1.0) / (chi + 1.0),
            };
        }
        // f without the cancellation of 1 - (1 - r)^chi at small r, the power without that of 1 - f at large r.
        let log = chi * (-r).ln_1p();
        let (f, power) = if log > -0.5 {
            let f = -log.exp_m1();
            (f, 1.0 - f)
        } else {
            let power = log.exp();
            (1.0 - power, power)
        };
        let (integral, loss) = if r * chi < SERIES_BELOW {
            let series = |c: &[f64; TERMS]| c.iter().rev().fold(0.0, |sum, c| sum * r + c) * r * r;
            (series(&self.integral_series), series(&self.loss_series))
        } else {
            // 1 - (1 - r)^(chi + 1) = f + r power.
            let integral = (chi * r - rest * f) / (chi + 1.0);
            (integral, 2.0 * integral - r * f)
        };
        Values {
            f,
            slope: chi * power / rest,
            integral,
            loss,
        }
    }
}

/// The coefficients of what is left of f, F (chi + 1) and L (chi + 1) after z^k = (1 - y)^k has been taken out, k = 1, 2, 3,
/// as polynomials in y = sqrt(1 - r); N = 2 chi. All are positive, so that nothing cancels.
///
/// r = 1 - y^2, f = 1 - y^N, F (chi + 1) = (chi + 1) r - (1 - y^(N+2)), L = 2 F - r f.
/// Multiplied by 2 the coefficients are whole numbers.
const fn coefficients<const N: usize>(factors: usize) -> [f64; MOST_HALVES + 3] {
    let mut c = [0i64; MOST_HALVES + 5];
    let n = N as i64;
    if factors == 1 {
        // 2 f
        c[0] = 2;
        c[N] -= 2;
    } else {
        // 2 F (chi + 1) = (N + 2)(1 - y^2) - 2 + 2 y^(N+2)
        c[0] = n;
        c[2] -= n + 2;
        c[N + 2] += 2;
        if factors == 3 {
            // 2 L (chi + 1) = 2 [2 F (chi + 1)] - (N + 2) r f, and r f = 1 - y^2 - y^N + y^(N+2)
            let mut k = 0;
            while k < c.len() {
                c[k] *= 2;
                k += 1;
            }
            c[0] -= n + 2;
            c[2] += n + 2;
            c[N] += n + 2;
            c[N + 2] -= n + 2;
        }
    }
    // Divide by (1 - y): the quotient's coefficients are the running sums.
    let mut times = 0;
    while times < factors {
        let mut k = 1;
        while k < c.len() {
            c[k] += c[k - 1];
            k += 1;
        }
        times += 1;
    }
    let scale = if factors == 1 { 2.0 } else { (n + 2) as f64 };
    let mut out = [0.0; MOST_HALVES + 3];
    let mut k = 0;
    while k < out.len() {
        out[k] = c[k] as f64 / scale;
        k += 1;
    }
    out
}

/// Half-integer exponents chi = N/2: powers of a square root, no cancellation anywhere.
struct Halves<const N: usize>;

impl<const N: usize> Halves<N> {
    const F: [f64; MOST_HALVES + 3] = coefficients::<N>(1);
    const INTEGRAL: [f64; MOST_HALVES + 3] = coefficients::<N>(2);
    const LOSS: [f64; MOST_HALVES + 3] = coefficients::<N>(3);

    #[inline(always)]
    fn at(r: f64) -> Values {
        let square = 1.0 - r;
        let y = square.sqrt();
        let z = r / (1.0 + y);
        let zz = z * z;
        // (1 - r)^(chi - 1) = y^(N - 2)
        let mut slope = if N % 2 == 1 { y } else { 1.0 };
        for _ in 0..(N - 2) / 2 {
            slope *= square;
        }
        Values {
            f: z * polynomial(&Self::F, N - 1, y, square),
            slope: 0.5 * N as f64 * slope,
            integral: zz * polynomial(&Self::INTEGRAL, N, y, square),
            loss: zz * z * polynomial(&Self::LOSS, N - 1, y, square),
        }
    }
}

/// The power law with the paper's exponent, 5/2. Of its own, so that it is inlined: values that travel through memory stall the
/// pipeline for longer than the square root takes.
#[derive(Clone, Debug)]
pub struct FiveHalves;

impl Backbone for FiveHalves {
    #[inline(always)]
    fn at(&self, r: f64) -> Values {
        Halves::<5>::at(r)
    }

    #[inline(always)]
    fn end(&self) -> Values {
        Values {
            f: 1.0,
            slope: 0.0,
            integral: 5.0 / 7.0,
            loss: 3.0 / 7.0,
        }
    }

    #[inline(always)]
    fn initial_slope(&self) -> f64 {
        2.5
    }
}

/// sum c_k y^k up to `degree`, as two interleaved Horner schemes in y^2: a shorter chain of results that wait for each
/// other.
#[inline(always)]
fn polynomial(c: &[f64; MOST_HALVES + 3], degree: usize, y: f64, square: f64) -> f64 {
    let (mut even, mut odd) = (0.0, 0.0);
    for k in (0..=degree / 2).rev() {
        even = even * square + c[2 * k];
        odd = odd * square + c[2 * k + 1];
    }
    even + y * odd
}

impl Backbone for PowerLaw {
    fn at(&self, r: f64) -> Values {
        match self.halves {
            5 => Halves::<5>::at(r),
            2 => Halves::<2>::at(r),
            3 => Halves::<3>::at(r),
            4 => Halves::<4>::at(r),
            6 => Halves::<6>::at(r),
            7 => Halves::<7>::at(r),
            8 => Halves::<8>::at(r),
            9 => Halves::<9>::at(r),
            10 => Halves::<10>::at(r),
            11 => Halves::<11>::at(r),
            12 => Halves::<12>::at(r),
            _ => self.general(r),
        }
    }

    #[inline(always)]
    fn end(&self) -> Values {
        self.end
    }

    #[inline]
    fn initial_slope(&self) -> f64 {
        self.chi
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_coefficients_of_the_papers_exponent() {
        // f = z (1 + y + y2 + y3 + y4), F = z2 (5 + 10y + 8y2 + 6y3 + 4y4 + 2y5)/7, L = z3 (3 + 9y + 11y2 + 9y3 + 3y4)/7.
        assert_eq!(Halves::<5>::F[..6], [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
        let sevenths = |c: &[f64]| c.iter().map(|c| (7.0 * c).round()).collect::<Vec<_>>();
        assert_eq!(
            sevenths(&Halves::<5>::INTEGRAL[..7]),
            [5.0, 10.0, 8.0, 6.0, 4.0, 2.0, 0.0]
        );
        assert_eq!(
            sevenths(&Halves::<5>::LOSS[..6]),
            [3.0, 9.0, 11.0, 9.0, 3.0, 0.0]
        );
    }

    #[test]
    fn square_roots_and_logarithms_give_the_same_curve() {
        for halves in 2..=MOST_HALVES {
            let fast = PowerLaw::new(halves as f64 / 2.0);
            let slow = PowerLaw {
                halves: 0,
                ..fast.clone()
            };
            for k in 0..1000 {
                let r = k as f64 / 1000.0;
                let (a, b) = (fast.at(r), slow.at(r));
                assert_relative_eq!(a.f, b.f, epsilon = 0.0, max_relative = 2e-15);
                assert_relative_eq!(a.slope, b.slope, epsilon = 0.0, max_relative = 2e-14);
                assert_relative_eq!(a.integral, b.integral, epsilon = 0.0, max_relative = 1e-12);
                assert_relative_eq!(a.loss, b.loss, epsilon = 1e-13 * r, max_relative = 1e-10);
            }
        }
        let end = PowerLaw::new(2.5).at(1.0);
        assert_eq!((end.f, end.slope), (1.0, 0.0));
    }

    #[test]
    fn series_joins_the_closed_form() {
        for chi in [1.3, 2.51, 8.0, 40.0, 1000.0] {
            let law = PowerLaw::new(chi);
            let r = SERIES_BELOW / chi;
            let (below, above) = (law.at(r * (1.0 - 1e-15)), law.at(r * (1.0 + 1e-15)));
            assert_relative_eq!(
                below.integral,
                above.integral,
                epsilon = 0.0,
                max_relative = 1e-11
            );
            // L is about chi - 1 times smaller than F: compare on the scale of r f.
            assert_relative_eq!(below.loss, above.loss, epsilon = 1e-13 * r);
        }
    }

    #[test]
    fn slope_is_the_derivative_and_f_of_the_integral() {
        for chi in [1.0, 1.2, 2.5, 3.7, 5.5] {
            let law = PowerLaw::new(chi);
            for r in [1e-3, 0.1, 0.5, 0.9] {
                let h = 1e-5 * r;
                let (a, b, here) = (law.at(r - h), law.at(r + h), law.at(r));
                assert_relative_eq!((b.f - a.f) / (2.0 * h), here.slope, max_relative = 1e-7);
                let f = (b.integral - a.integral) / (2.0 * h);
                assert_relative_eq!(f, here.f, max_relative = 1e-7);
            }
        }
    }
}
