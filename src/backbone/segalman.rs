//! Segalman's four-parameter Iwan model as a backbone (D. J. Segalman, J. Appl. Mech. 72 (2005) 752).

use super::{Backbone, Values};

/// A power-law density r^c of slip elements up to r = 1, and one element more at r = 1.
///
/// f = [(1 + beta)(c + 2) r - r^(c + 2)] / N with N = (c + 1) + beta (c + 2).
///
/// With q = r^(c + 1) - 1 that is f = r (1 - q/N): for c near -1, where N is small, nothing cancels then.
#[derive(Clone, Debug)]
pub struct Segalman {
    /// The exponent of the density, in (-1, 0].
    c: f64,
    beta: f64,
    /// N, which makes f(1) = 1.
    norm: f64,
}

impl Segalman {
    /// Exponent `c` in (-1, 0] and stiffness ratio `beta` >= 0 (of the element at r = 1 to all others).
    pub fn new(c: f64, beta: f64) -> Self {
        Segalman {
            c,
            beta,
            norm: (c + 1.0) + beta * (c + 2.0),
        }
    }
}

impl Backbone for Segalman {
    #[inline]
    fn at(&self, r: f64) -> Values {
        let c = self.c;
        // The logarithm of 0 raises a floating-point flag that some hosts trap.
        let q = ((c + 1.0) * r.max(f64::MIN_POSITIVE).ln()).exp_m1();
        let square = r * r;
        Values {
            f: r * (1.0 - q / self.norm),
            slope: (c + 2.0) * (self.beta - q) / self.norm,
            integral: square * (0.5 + (0.5 * (c + 1.0) - q) / ((c + 3.0) * self.norm)),
            loss: (c + 1.0) * square * (1.0 + q) / ((c + 3.0) * self.norm),
        }
    }

    fn initial_slope(&self) -> f64 {
        (self.c + 2.0) * (1.0 + self.beta) / self.norm
    }

    fn grid(&self, k: usize, count: usize) -> f64 {
        (k as f64 / count as f64).powf(2.0 / (self.c + 2.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ends_at_one_and_integrates() {
        for (c, beta) in [
            (0.0, 0.0),
            (-0.5, 0.2),
            (-0.84, 0.0),
            (-0.99, 3.0),
            (-0.99, 0.0),
        ] {
            let law = Segalman::new(c, beta);
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
