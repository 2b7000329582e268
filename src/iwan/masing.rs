//! Masing's branches of any curve of first loading, as a least-squares problem over the points of a record.
//!
//! Everything is scaled: displacement by the amplitude A, force by the half range T of the forces. The unknowns are
//! those of the curve, then the parallel stiffness times A / T, the mean force over T, the factors of further columns,
//! and the stop's.

use super::least_squares::Problem;
use super::record::{Branch, Record};
use nalgebra::DVector;

/// Most unknowns.
const MOST: usize = 16;

/// A curve of first loading, H(u) for u >= 0, of N unknowns.
pub trait Curve<const N: usize> {
    /// H(u) and its derivatives by the unknowns. Noise leads to u < 0: the curve goes on straight there.
    fn at(&self, u: f64, unknowns: &[f64; N]) -> (f64, [f64; N]);

    /// The least and the greatest value of every unknown.
    fn bounds(&self) -> [[f64; 2]; N];
}

/// Springs that bear beyond a clearance on either side: unknowns are both clearances and their stiffness.
pub(super) const STOP: usize = 3;
/// Clearances from the middle of the loop, over the amplitude; at the greatest the stop is not reached.
pub(super) const CLEARANCES: [f64; 2] = [0.02, 1.0];

/// A record against a curve.
#[derive(Clone)]
pub struct Masing<'a, C, const N: usize> {
    /// The data.
    pub record: &'a Record,
    /// The curve of first loading.
    pub curve: C,
    /// The force T.
    pub unit: f64,
    /// Columns that are linear in a further unknown each; one number for every row of the record.
    pub columns: Vec<Vec<f64>>,
    /// Whether there are stops.
    pub stop: bool,
}

impl<'a, C: Curve<N>, const N: usize> Masing<'a, C, N> {
    /// Of a record, without further unknowns.
    pub fn new(record: &'a Record, curve: C) -> Self {
        Masing {
            unit: record.force_unit(),
            record,
            curve,
            columns: Vec::new(),
            stop: false,
        }
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> usize {
        N + 2 + self.columns.len() + if self.stop { STOP } else { 0 }
    }

    /// Measured less modelled force, branch after branch.
    pub fn residuals(&self, unknowns: &DVector<f64>, residuals: &mut Vec<f64>) {
        self.visit(unknowns, 1, &mut |residual, _| {
            residuals.push(-residual * self.unit);
        });
    }

    /// How many points the branches have.
    pub fn lengths(&self) -> impl Iterator<Item = usize> + '_ {
        self.record.branches.iter().map(Branch::count)
    }
}

impl<C: Curve<N>, const N: usize> Problem for Masing<'_, C, N> {
    fn visit(&self, unknowns: &DVector<f64>, stride: usize, take: &mut impl FnMut(f64, &[f64])) {
        let count = self.unknowns();
        let amplitude = self.record.amplitude;
        let of_curve: [f64; N] = std::array::from_fn(|k| unknowns[k]);
        let (residual, offset) = (unknowns[N], unknowns[N + 1]);
        let first_column = N + 2;
        let first_stop = first_column + self.columns.len();
        // Friction at the reversals, and its derivatives.
        let mut reversals: Vec<(f64, [f64; N])> = Vec::with_capacity(self.record.nodes.len());
        for node in &self.record.nodes {
            let (mut force, mut by) = node.parent.map_or((0.0, [0.0; N]), |k| reversals[k]);
            let (h, d) = self.curve.at(node.distance / amplitude, &of_curve);
            force += node.weight * h;
            for k in 0..N {
                by[k] += node.weight * d[k];
            }
            reversals.push((force, by));
        }
        let mut row = [0.0; MOST];
        let mut skipped = 0;
        for branch in &self.record.branches {
            let (base, base_by) = branch.node.map_or((0.0, [0.0; N]), |k| reversals[k]);
            let (weight, factor) = branch.masing();
            let along = factor * branch.direction.sign() / amplitude;
            for rows in &branch.rows {
                let from = rows.start + skipped;
                skipped = if from < rows.end {
                    (stride - (rows.end - from) % stride) % stride
                } else {
                    from - rows.end
                };
                for index in (from..rows.end).step_by(stride) {
                    let x = self.record.displacement[index];
                    let (h, d) = self.curve.at(along * (x - branch.start), &of_curve);
                    for k in 0..N {
                        row[k] = base_by[k] + weight * d[k];
                    }
                    let place = (x - self.record.centre) / amplitude;
                    row[N] = place;
                    row[N + 1] = 1.0;
                    let mut force = base + weight * h + residual * place + offset;
                    for (k, column) in self.columns.iter().enumerate() {
                        row[first_column + k] = column[index];
                        force += unknowns[first_column + k] * column[index];
                    }
                    if self.stop {
                        let [above, below, stiffness] = [0, 1, 2].map(|k| unknowns[first_stop + k]);
                        let (over, under) = ((place - above).max(0.0), (place + below).min(0.0));
                        let side = |inside: f64| if inside == 0.0 { 0.0 } else { stiffness };
                        row[first_stop] = -side(over);
                        row[first_stop + 1] = side(under);
                        row[first_stop + 2] = over + under;
                        force += stiffness * (over + under);
                    }
                    take(force - self.record.force[index] / self.unit, &row[..count]);
                }
            }
        }
    }

    fn count(&self) -> usize {
        self.record.points()
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        let mut bounds = self.curve.bounds().to_vec();
        bounds.resize(N + 2 + self.columns.len(), free);
        if self.stop {
            bounds.extend([CLEARANCES, CLEARANCES, [0.0, f64::INFINITY]]);
        }
        bounds
    }
}
