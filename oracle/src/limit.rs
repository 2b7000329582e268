//! The limit traction: T = min(c + mu p, cap), mu = factor [mu_late + (mu - mu_late) exp(-slip length / slip_late)].

/// What the limit traction depends on.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// Friction coefficient.
    pub mu: f64,
    /// Limit traction at no pressure.
    pub cohesion: f64,
    /// Largest limit traction; infinite where there is none.
    pub cap: f64,
    /// Friction coefficient after long slip, and the slip length over which it goes there.
    pub run_in: Option<(f64, f64)>,
}

/// T and dT/dp.
#[derive(Debug, Clone, Copy)]
pub struct LimitTraction {
    /// T.
    pub traction: f64,
    /// dT/dp, 0 at and above the cap.
    pub slope: f64,
}

impl Limit {
    /// Coulomb's limit mu p.
    pub fn coulomb(mu: f64) -> Limit {
        Limit {
            mu,
            cohesion: 0.0,
            cap: f64::INFINITY,
            run_in: None,
        }
    }

    /// The limit at a pressure, the caller's factor on mu, and a slip length.
    pub fn at(&self, pressure: f64, factor: f64, slip_length: f64) -> LimitTraction {
        let mu = match self.run_in {
            Some((late, length)) => late + (self.mu - late) * (-slip_length / length).exp(),
            None => self.mu,
        };
        let free = self.cohesion + factor * mu * pressure;
        LimitTraction {
            traction: free.min(self.cap),
            slope: if free < self.cap { factor * mu } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cohesion_cap_and_run_in() {
        let limit = Limit {
            mu: 0.4,
            cohesion: 1.0,
            cap: 6.0,
            run_in: Some((0.2, 5.0)),
        };
        let at = limit.at(10.0, 1.0, 0.0);
        assert!((at.traction - 5.0).abs() < 1e-15 && at.slope == 0.4);
        let late = limit.at(10.0, 1.0, 500.0);
        assert!((late.traction - 3.0).abs() < 1e-15 && (late.slope - 0.2).abs() < 1e-15);
        let capped = limit.at(10.0, 2.0, 0.0);
        assert_eq!((capped.traction, capped.slope), (6.0, 0.0));
    }
}
