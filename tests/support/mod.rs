//! What several test files share: a contact point that remembers its state, paths, small numerics.

// Each test file is a crate of its own and uses its part of this.
#![allow(dead_code)]

pub mod flags;
pub mod fric;
pub mod native;
pub mod paths;
pub mod programs;
pub mod structures;
pub mod tangent;
pub mod vectors;

use mepc::{Law, Response, Vector, default_state_size};

/// Numbers in the header of a state.
pub const HEADER: usize = 12;

/// A state array with room for so many knots; four is the least.
pub fn state_size(ndir: usize, knots: usize) -> usize {
    HEADER + knots * (1 + ndir)
}

/// Properties of the power law in physical units.
pub fn power(mu: f64, gcr: f64, chi: f64) -> Vec<f64> {
    vec![mu, gcr, chi]
}

/// Properties for which slip, traction and energy are the normalised ones (at pressure 1).
pub fn unit(chi: f64) -> Vec<f64> {
    power(1.0, 1.0, chi)
}

/// Segalman's backbone with mu = gcr = 1; c is the exponent of the density, in (-1, 0].
pub fn segalman(c: f64, beta: f64) -> Vec<f64> {
    with(&with(&unit(c + 2.0), 10, 1.0), 11, beta)
}

/// Properties with another entry (1-based, as the property table counts); the entries before it that are not given are 0,
/// which is their default.
pub fn with(props: &[f64], number: usize, value: f64) -> Vec<f64> {
    let mut all = props.to_vec();
    all.resize(all.len().max(number), 0.0);
    all[number - 1] = value;
    all
}

/// The consistent rule: properties with reference pressure 1.
pub fn consistent(props: &[f64]) -> Vec<f64> {
    with(props, 5, 1.0)
}

/// A contact point as a host keeps it: every step starts from the state that the step before left.
#[derive(Clone)]
pub struct Point<const N: usize> {
    pub law: Law<N>,
    pub gcr: f64,
    pub state: Vec<f64>,
    pub slip: [f64; N],
    /// The caller's factor on mu.
    pub mu_factor: f64,
}

impl<const N: usize> Point<N> {
    /// A virgin point with a state of default size.
    pub fn new(props: &[f64]) -> Self {
        let nstate = default_state_size(props, N).expect("good properties");
        Self::with_state_size(props, nstate)
    }

    pub fn with_state_size(props: &[f64], nstate: usize) -> Self {
        let law = Law::<N>::new(props, nstate).expect("good properties");
        let gcr = law.critical_slip(0.0).expect("gcr > 0");
        Point {
            law,
            gcr,
            state: vec![0.0; nstate],
            slip: [0.0; N],
            mu_factor: 1.0,
        }
    }

    /// What an increment would give, and the state it would leave.
    pub fn trial(&self, increment: [f64; N], pressure: f64) -> (Response<N>, Vec<f64>) {
        let mut end = vec![f64::NAN; self.state.len()];
        let response = self
            .law
            .friction(
                self.gcr,
                &Vector::from(increment),
                pressure,
                self.mu_factor,
                &self.state,
                &mut end,
            )
            .expect("a valid increment");
        (response, end)
    }

    /// Slides by an increment.
    pub fn step(&mut self, increment: [f64; N], pressure: f64) -> Response<N> {
        let (response, end) = self.trial(increment, pressure);
        self.state = end;
        for (slip, d) in self.slip.iter_mut().zip(increment) {
            *slip += d;
        }
        response
    }

    /// Slides to a total slip in one step.
    pub fn move_to(&mut self, target: [f64; N], pressure: f64) -> Response<N> {
        let increment = std::array::from_fn(|i| target[i] - self.slip[i]);
        let response = self.step(increment, pressure);
        self.slip = target;
        response
    }

    /// Slides to a total slip in `steps` equal steps; gives the last response and all that was dissipated.
    pub fn move_in_steps(
        &mut self,
        target: [f64; N],
        pressure: f64,
        steps: u32,
    ) -> (Response<N>, f64) {
        let start = self.slip;
        let mut dissipated = 0.0;
        let mut last = None;
        for k in 1..=steps {
            let part = f64::from(k) / f64::from(steps);
            let at = std::array::from_fn(|i| start[i] + (target[i] - start[i]) * part);
            let response = self.move_to(if k == steps { target } else { at }, pressure);
            dissipated += response.dissipated;
            last = Some(response);
        }
        (last.expect("at least one step"), dissipated)
    }
}

/// The rotation by an angle, and the vector turned by it.
pub fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// A number between 10^low and 10^high, every decade as likely as the next.
pub fn decades(random: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * random.f64())
}

/// A number between -1 and 1.
pub fn signed(random: &mut fastrand::Rng) -> f64 {
    2.0 * random.f64() - 1.0
}

/// Integral of f from a to b: Simpson's rule, halving where f has a kink.
pub fn integral(f: &impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64) -> f64 {
    fn halve(
        f: &impl Fn(f64) -> f64,
        ends: [(f64, f64); 3],
        whole: f64,
        tolerance: f64,
        depth: u32,
    ) -> f64 {
        let [(a, fa), (m, fm), (b, fb)] = ends;
        let (l, r) = (0.5 * (a + m), 0.5 * (m + b));
        let (fl, fr) = (f(l), f(r));
        let left = (m - a) / 6.0 * (fa + 4.0 * fl + fm);
        let right = (b - m) / 6.0 * (fm + 4.0 * fr + fb);
        let error = (left + right - whole) / 15.0;
        if depth == 0 || error.abs() < tolerance {
            return left + right + error;
        }
        halve(
            f,
            [(a, fa), (l, fl), (m, fm)],
            left,
            0.5 * tolerance,
            depth - 1,
        ) + halve(
            f,
            [(m, fm), (r, fr), (b, fb)],
            right,
            0.5 * tolerance,
            depth - 1,
        )
    }
    let m = 0.5 * (a + b);
    let (fa, fm, fb) = (f(a), f(m), f(b));
    let whole = (b - a) / 6.0 * (fa + 4.0 * fm + fb);
    halve(f, [(a, fa), (m, fm), (b, fb)], whole, tolerance, 30)
}
