//! Segalman's four-parameter Iwan model as a backbone (D. J. Segalman, J. Appl. Mech. 72 (2005) 752).

use super::{Backbone, Values};

/// A power-law density r^(q - 2) of slip elements up to r = 1, and one element more at r = 1.
///
/// f = [(1 + beta) q r - r^q] / N with N = (q - 1) + beta q; q = chi + 2 with Segalman's chi in (-1, 0].
///
/// With e = r^(q - 1) - 1 that is f = r (1 - e/N): for q near 1, where N is small, nothing cancels then.
#[derive(Clone, Debug)]
pub struct Segalman {
    /// The exponent, in (1, 2].
    q: f64,
    beta: f64,
    /// N, which makes f(1) = 1.
    norm: f64,
    end: Values,
}

impl Segalman {
    /// Exponent `q` in (1, 2] and stiffness ratio `beta` >= 0 (of the element at r = 1 to all others).
    pub fn new(q: f64, beta: f64) -> Self {
        let mut curve = Segalman {
            q,
            beta,
            norm: (q - 1.0) + beta * q,
            end: Values::default(),
        };
        curve.end = curve.at(1.0);
        curve
    }
}

impl Backbone for Segalman {
    #[inline]
    fn at(&self, r: f64) -> Values {
        let Segalman { q, beta, norm, .. } = *self;
        // The logarithm of 0 raises a floating-point flag that some hosts trap.
        let e = ((q - 1.0) * r.max(f64::MIN_POSITIVE).ln()).exp_m1();
        let square = r * r;
        Values {
            f: r * (1.0 - e / norm),
            slope: q * (beta - e) / norm,
            integral: square * (0.5 + (0.5 * (q - 1.0) - e) / ((q + 1.0) * norm)),
            loss: (q - 1.0) * square * (1.0 + e) / ((q + 1.0) * norm),
        }
    }

    #[inline(always)]
    fn end(&self) -> Values {
        self.end
    }

    #[inline]
    fn initial_slope(&self) -> f64 {
        self.q * (1.0 + self.beta) / self.norm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ends_at_one_and_integrates() {
        for (q, beta) in [
            (2.0, 0.0),
            (1.5, 0.2),
            (1.16, 0.0),
            (1.01, 3.0),
            (1.01, 0.0),
        ] {
            let law = Segalman::new(q, beta);
            assert_eq!(law.at(1.0).f, 1.0);
            assert_relative_eq!(law.at(1.0 - 1e-15).f, 1.0, epsilon = 1e-14);
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
                assert_relative_eq!(
                    here.loss,
                    2.0 * here.integral - r * here.f,
                    max_relative = 1e-9
                );
            }
        }
    }
}
