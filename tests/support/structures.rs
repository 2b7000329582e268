//! Small structures on the law: a rigid patch behind a spring, and an elastic bar.

use super::Point;

/// Contact points under a rigid motion, if wanted behind a spring, found by Newton's method.
pub struct Patch {
    /// A point, its area and its pressure.
    points: Vec<(Point<1>, f64, f64)>,
    series: Option<f64>,
    pub slip: f64,
    pub dissipated: f64,
    pub iterations: u32,
}

impl Patch {
    pub fn new(
        props: &[f64],
        points: impl IntoIterator<Item = (f64, f64)>,
        series: Option<f64>,
    ) -> Self {
        let point = Point::<1>::new(props);
        Patch {
            points: points
                .into_iter()
                .map(|(area, p)| (point.clone(), area, p))
                .collect(),
            series,
            slip: 0.0,
            dissipated: 0.0,
            iterations: 0,
        }
    }

    /// Force and stiffness when the patch slides to `slip`.
    pub fn response(&self, slip: f64) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for (point, area, pressure) in &self.points {
            let (response, _) = point.trial([slip - point.slip[0]], *pressure);
            sum.0 += area * response.traction[0];
            sum.1 += area * response.dtraction_dslip[(0, 0)];
        }
        sum
    }

    pub fn force(&self) -> f64 {
        self.response(self.slip).0
    }

    pub fn move_to(&mut self, displacement: f64) {
        self.slip = match self.series {
            None => displacement,
            Some(series) => self.newton(displacement, series),
        };
        for (point, area, pressure) in &mut self.points {
            self.dissipated += *area * point.move_to([self.slip], *pressure).dissipated;
        }
    }

    fn newton(&mut self, displacement: f64, series: f64) -> f64 {
        let mut slip = self.slip;
        for _ in 0..50 {
            self.iterations += 1;
            let (force, stiffness) = self.response(slip);
            let change = (series * (displacement - slip) - force) / (series + stiffness);
            slip += change;
            if change.abs() <= 1e-14 * displacement.abs() {
                return slip;
            }
        }
        panic!("no slip found for the displacement {displacement}");
    }
}

/// A long elastic bar on the law: linear elements, friction at the nodes, the first node is moved.
pub struct Bar {
    points: Vec<Point<1>>,
    /// Length of an element.
    length: f64,
    axial: f64,
}

impl Bar {
    pub fn new(props: &[f64], axial: f64, length: f64, elements: usize) -> Self {
        Bar {
            points: vec![Point::new(props); elements + 1],
            length: length / elements as f64,
            axial,
        }
    }

    /// Moves the first node to `end`: Newton's method, with tridiagonal elimination in each iteration. Gives the
    /// force at that end and the number of iterations.
    pub fn move_to(&mut self, end: f64) -> (f64, u32) {
        let n = self.points.len();
        let spring = self.axial / self.length;
        // Half an element belongs to each end node.
        let share = |i: usize| {
            if i == 0 || i == n - 1 {
                0.5 * self.length
            } else {
                self.length
            }
        };
        let mut u: Vec<f64> = self.points.iter().map(|point| point.slip[0]).collect();
        u[0] = end;
        for iteration in 1..=60 {
            let friction: Vec<(f64, f64)> = (0..n)
                .map(|i| {
                    let (response, _) = self.points[i].trial([u[i] - self.points[i].slip[0]], 1.0);
                    (
                        share(i) * response.traction[0],
                        share(i) * response.dtraction_dslip[(0, 0)],
                    )
                })
                .collect();
            // Unknowns 1..n: -spring u[i-1] + (2 spring + friction) u[i] - spring u[i+1] = 0, the far end is free.
            let (mut diagonal, mut change) = (vec![1.0; n], vec![0.0; n]);
            for i in 1..n {
                let pull = if i + 1 < n { u[i + 1] - u[i] } else { 0.0 };
                change[i] = spring * (u[i - 1] - u[i] + pull) - friction[i].0;
                diagonal[i] = spring * if i + 1 < n { 2.0 } else { 1.0 } + friction[i].1;
                if i > 1 {
                    let factor = spring / diagonal[i - 1];
                    diagonal[i] -= factor * spring;
                    change[i] += factor * change[i - 1];
                }
            }
            for i in (1..n).rev() {
                let above = if i + 1 < n {
                    spring * change[i + 1]
                } else {
                    0.0
                };
                change[i] = (change[i] + above) / diagonal[i];
                u[i] += change[i];
            }
            let size = change.iter().fold(0.0, |worst: f64, c| worst.max(c.abs()));
            if size < 1e-13 {
                for (point, u) in self.points.iter_mut().zip(&u) {
                    point.move_to([*u], 1.0);
                }
                return (spring * (u[0] - u[1]) + friction[0].0, iteration);
            }
        }
        panic!("no equilibrium of the bar at {end}");
    }
}
