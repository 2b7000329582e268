//! The Jenkins element: a spring of constant stiffness in series with a slider whose limit changes, the contact element
//! of turbomachinery (for example Griffin 1980; with a changing normal load Yang, Chu and Menq 1998).

/// One element; stiffness in traction per length.
#[derive(Debug, Clone)]
pub struct Jenkins {
    stiffness: f64,
    /// The traction it holds.
    pub traction: [f64; 2],
    limit: Option<f64>,
}

impl Jenkins {
    /// An element without load.
    pub fn new(stiffness: f64) -> Self {
        Jenkins {
            stiffness,
            traction: [0.0; 2],
            limit: None,
        }
    }

    /// Slides by d while the limit goes straight to `limit` (at the first step it is there at once), in so many parts. One
    /// part is exact in one direction and on straight lines through the origin.
    pub fn step(&mut self, d: [f64; 2], limit: f64, parts: u32) {
        let from = self.limit.replace(limit).unwrap_or(limit);
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let now = from + (limit - from) * share;
            let trial = [0, 1].map(|i| self.traction[i] + self.stiffness * d[i] / f64::from(parts));
            let size = trial[0].hypot(trial[1]);
            self.traction = if size > now {
                trial.map(|t| t * now / size)
            } else {
                trial
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sticks_slides_and_follows_its_limit() {
        let mut spring = Jenkins::new(10.0);
        spring.step([0.1, 0.0], 2.0, 1);
        assert_eq!(spring.traction, [1.0, 0.0]);
        spring.step([0.0, 0.0], 0.4, 1);
        let close = |t: [f64; 2]| (t[0] - 0.4).abs() < 1e-15 && t[1] == 0.0;
        assert!(close(spring.traction));
        // What the limit took away does not come back.
        spring.step([0.0, 0.0], 2.0, 1);
        assert!(close(spring.traction));
        spring.step([-3.0, -4.0], 5.0, 1000);
        assert!((spring.traction[0].hypot(spring.traction[1]) - 5.0).abs() < 1e-12);
    }
}
