//! The exact law for slip back and forth along a line at constant pressure, from Masing's rules:
//!
//! 1. a branch that leaves a reversal is the backbone at twice the scale, t = t_rev +- 2 f(|s - s_rev| / 2);
//! 2. a branch that meets the reversal before last has closed a loop: both are forgotten and the branch that
//!    the loop interrupted goes on;
//! 3. a branch that meets the mirror image of the first reversal goes on as first loading;
//! 4. beyond critical slip the origin of the first loading follows.

use crate::{Backbone, Status};

#[derive(Debug, Clone, Copy)]
struct Reversal {
    slip: f64,
    traction: f64,
}

/// A point that remembers its reversals. Slip, traction and energy are normalised.
#[derive(Debug, Clone)]
pub struct Masing {
    backbone: Backbone,
    origin: f64,
    slip: f64,
    direction: f64,
    reversals: Vec<Reversal>,
    work: f64,
    dissipated: f64,
}

impl Masing {
    /// A virgin point at slip 0.
    pub fn new(backbone: Backbone) -> Self {
        Masing {
            backbone,
            origin: 0.0,
            slip: 0.0,
            direction: 0.0,
            reversals: Vec::new(),
            work: 0.0,
            dissipated: 0.0,
        }
    }

    /// Slides on, in a straight line, to the total slip `target`.
    pub fn move_to(&mut self, target: f64) {
        if target == self.slip {
            return;
        }
        let direction = (target - self.slip).signum();
        if direction == -self.direction {
            self.reversals.push(Reversal {
                slip: self.slip,
                traction: self.traction(),
            });
        }
        self.direction = direction;
        loop {
            let end = match self.reversals.as_slice() {
                [] => break,
                [first] => 2.0 * self.origin - first.slip,
                [.., before_last, _] => before_last.slip,
            };
            if direction * (target - end) < 0.0 {
                break;
            }
            self.follow_branch(end);
            let closed = self.reversals.len().min(2);
            self.reversals.truncate(self.reversals.len() - closed);
        }
        self.follow_branch(target);
        if self.reversals.is_empty() && (self.slip - self.origin).abs() > 1.0 {
            self.origin = self.slip - direction;
        }
    }

    /// Moves along the present branch, which `end` does not leave.
    fn follow_branch(&mut self, end: f64) {
        let from = self.branch_parameter(self.slip);
        let to = self.branch_parameter(end);
        let b = self.backbone;
        match self.reversals.last() {
            None => {
                self.work += b.work(to) - b.work(from);
                self.dissipated += b.loss(to) - b.loss(from);
            }
            Some(last) => {
                self.work += last.traction * (end - self.slip) + 4.0 * (b.work(to) - b.work(from));
                // An element of limit r slides 2 (x - r) under the force r.
                self.dissipated += 2.0 * (b.loss(to) - b.loss(from));
            }
        }
        self.slip = end;
    }

    /// Argument of the backbone on the present branch: all elements with a smaller limit slide.
    fn branch_parameter(&self, slip: f64) -> f64 {
        match self.reversals.last() {
            None => (slip - self.origin).abs(),
            Some(last) => (slip - last.slip).abs() / 2.0,
        }
    }

    /// Total slip.
    pub fn slip(&self) -> f64 {
        self.slip
    }

    /// Traction, of the sign of the slip that causes it.
    pub fn traction(&self) -> f64 {
        let f = self.backbone.traction(self.branch_parameter(self.slip));
        match self.reversals.last() {
            None => self.direction * f,
            Some(last) => last.traction + self.direction * 2.0 * f,
        }
    }

    /// Energy dissipated since the start.
    pub fn dissipated(&self) -> f64 {
        self.dissipated
    }

    /// Energy stored: what went in and was not dissipated.
    pub fn stored(&self) -> f64 {
        self.work - self.dissipated
    }

    /// Contact status at the end of a step that moved.
    pub fn status(&self) -> Status {
        let sliding = self.branch_parameter(self.slip);
        let b = self.backbone;
        if sliding >= 1.0 - 1e-14 {
            Status::GrossSlip
        } else if b.tangent(sliding) >= 0.99 * b.tangent(0.0) {
            Status::Stick
        } else {
            Status::MicroSlip
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed;

    fn power(chi: f64) -> Masing {
        Masing::new(Backbone::Power { chi })
    }

    fn tractions(point: &mut Masing, path: &[f64]) -> Vec<f64> {
        path.iter()
            .map(|&s| {
                point.move_to(s);
                point.traction()
            })
            .collect()
    }

    /// Item 2 of the verification page.
    #[test]
    fn nested_path() {
        let path = [0.0, 0.8, -0.2, 0.3, -0.2, -0.8, -1.0];
        let expected = [
            0.0, 0.982111, -0.664335, 0.361386, -0.664335, -0.982111, -1.0,
        ];
        for (t, e) in tractions(&mut power(2.5), &path).iter().zip(expected) {
            assert!((t - e).abs() < 5e-7, "{t} {e}");
        }
    }

    /// Item 3: the origin moves to 4.
    #[test]
    fn slide_to_five_and_back() {
        let t = tractions(&mut power(2.5), &[5.0, 4.515717, 3.0, 2.0]);
        assert_eq!(t[0], 1.0);
        assert!(t[1].abs() < 2e-6);
        assert!((t[2] + 1.0).abs() < 1e-15);
        assert_eq!(t[3], -1.0);
    }

    /// Item 4.
    #[test]
    fn from_critical_slip_back_to_zero() {
        for (chi, expected) in [(2.5, -0.646447), (1.5, -0.292893), (2.0, -0.5)] {
            let t = tractions(&mut power(chi), &[1.0, 0.0]);
            assert!((t[1] - expected).abs() < 5e-7);
        }
    }

    /// Items 5 and 6: a cycle between +-a, and the energy of the first loading.
    #[test]
    fn cycles_and_first_loading() {
        for backbone in [
            Backbone::Power { chi: 1.0 },
            Backbone::Power { chi: 2.5 },
            Backbone::Segalman { c: -0.5, beta: 0.3 },
        ] {
            for a in [0.1, 0.5, 0.999, 1.0, 2.0] {
                let mut point = Masing::new(backbone);
                point.move_to(a);
                let before = point.dissipated();
                // Sliding elements store r^2/2, the others a^2/2: a f(a) - F(a) up to a = 1.
                let x: f64 = a.min(1.0);
                let stored = x * backbone.traction(x) - backbone.work(x);
                assert!((point.stored() - stored).abs() < 1e-14);
                point.move_to(-a);
                point.move_to(a);
                let cycle = point.dissipated() - before;
                assert!((cycle - closed::cycle_dissipation(backbone, a)).abs() < 1e-13);
            }
            let mut point = Masing::new(backbone);
            point.move_to(3.0);
            assert!((point.stored() - closed::saturated_energy(backbone)).abs() < 1e-14);
        }
    }

    /// Item 9: one step or a thousand per branch; a zero increment.
    #[test]
    fn step_size_does_not_matter() {
        let path: [f64; 7] = [0.7, -0.3, 0.2, -0.1, 0.65, -2.5, 0.4];
        let (mut coarse, mut fine) = (power(2.5), power(2.5));
        for target in path {
            coarse.move_to(target);
            let start = fine.slip();
            for k in 1..=1000 {
                fine.move_to(start + (target - start) * f64::from(k) / 1000.0);
                fine.move_to(fine.slip());
            }
            fine.move_to(target);
            assert!((coarse.traction() - fine.traction()).abs() < 1e-13);
            assert!((coarse.dissipated() - fine.dissipated()).abs() < 1e-12);
            assert!((coarse.stored() - fine.stored()).abs() < 1e-12);
        }
    }

    /// A closed inner loop leaves no trace, and gross slip forgets everything.
    #[test]
    fn return_point_memory() {
        let (mut direct, mut looped) = (power(3.0), power(3.0));
        tractions(&mut direct, &[0.9, -0.5]);
        tractions(&mut looped, &[0.9, 0.1, 0.6, 0.3, 0.4, -0.5]);
        assert!((direct.traction() - looped.traction()).abs() < 1e-15);
        assert!(looped.dissipated() > direct.dissipated());
        direct.move_to(4.0);
        assert_eq!(direct.reversals.len(), 0);
        assert_eq!(direct.origin, 3.0);
    }

    #[test]
    fn status_follows_the_sliding_elements() {
        let mut point = power(2.5);
        for (s, status) in [
            (1e-6, Status::Stick),
            (0.4, Status::MicroSlip),
            (1.0, Status::GrossSlip),
            (0.999, Status::Stick),
            (0.0, Status::MicroSlip),
            (-1.0, Status::GrossSlip),
            // A loop that closes at the onset of gross slip.
            (-0.5, Status::MicroSlip),
            (-1.0, Status::GrossSlip),
        ] {
            point.move_to(s);
            assert_eq!(point.status(), status, "at {s}");
        }
    }
}
