//! The base grid: knots that are never dropped, and what follows from them once and for all.

use super::knot::Knot;
use super::lane::{Lane, WIDTH};
use super::{ROUNDING, Vector, outside};
use crate::backbone::{Backbone, Values};
use std::array::from_fn;

/// A knot of the base grid with all that does not change.
#[derive(Clone, Debug)]
pub struct Node {
    /// Slip limit.
    pub r: f64,
    /// Squared length from which a trial deflection is outside.
    pub(super) outside: f64,
    /// Squared length that a deflection may have.
    limit2: f64,
    pub(super) values: Values,
    /// 1 / width of the segment below.
    pub(super) inverse_width: f64,
    /// Secants of f and G over the segment below.
    pub(super) secant: f64,
    pub(super) loss_secant: f64,
    /// Weight of e in the traction: secant below - secant above.
    pub(super) weight: f64,
    /// Weights of |e|^2, and of e times the deflection of the knot below, in the stored energy.
    pub(super) energy: f64,
    pub(super) energy_below: f64,
}

/// Some knots of the base grid side by side, for loops that treat them at once.
///
/// Past the last knot there are some without weight that never slip.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    pub(super) r: Lane,
    pub(super) outside: Lane,
    /// Weight of a slipping knot's excess over its limit in the dissipated energy: secant of G above - secant below.
    pub(super) loss: Lane,
    /// Weight over r^2: weight times n n^T for a knot that slips in the direction n is this times e e^T.
    pub(super) turn: Lane,
}

/// Equal parts of 0 <= r < 1 in which the search for a base knot starts.
const BUCKETS: usize = 64;

/// The base grid of a backbone.
#[derive(Clone, Debug)]
pub struct Grid<const N: usize> {
    pub(super) nodes: Vec<Node>,
    pub(super) lanes: Vec<Lanes>,
    /// How many knots lie at or below the start of each bucket of r.
    start: [u8; BUCKETS],
    pub(super) initial_slope: f64,
}

impl<const N: usize> Grid<N> {
    /// `count` knots (knot 0 is not stored), the last at r = 1.
    pub fn new(backbone: &impl Backbone, count: usize) -> Self {
        let at = |k: usize| {
            let r = backbone.grid(k, count);
            (r, backbone.at(r))
        };
        let nodes: Vec<Node> = (1..=count)
            .map(|k| {
                let (below, (r, values)) = (at(k - 1), at(k));
                let inverse_width = 1.0 / (r - below.0);
                let lower = Secants::new(below, (r, values));
                // Above r = 1 there is nothing.
                let upper = if k < count {
                    Secants::new((r, values), at(k + 1))
                } else {
                    Secants::default()
                };
                Node {
                    r,
                    outside: outside(r),
                    limit2: r * r * (1.0 + ROUNDING),
                    values,
                    inverse_width,
                    secant: lower.f,
                    loss_secant: (values.loss - below.1.loss) * inverse_width,
                    weight: lower.f - upper.f,
                    energy: lower.energy_end + upper.energy_start,
                    energy_below: lower.energy_product,
                }
            })
            .collect();
        let lanes = (0..count.div_ceil(WIDTH))
            .map(|chunk| {
                let column = |value: &dyn Fn(usize, &Node) -> f64, beyond| {
                    Lane(from_fn(|lane| {
                        let k = chunk * WIDTH + lane;
                        nodes.get(k).map_or(beyond, |node| value(k, node))
                    }))
                };
                // By parts, with G' = 1 at r = 1.
                let secant_above = |k: usize| nodes.get(k + 1).map_or(1.0, |node| node.loss_secant);
                Lanes {
                    r: column(&|_, node| node.r, 2.0),
                    outside: column(&|_, node| node.outside, f64::INFINITY),
                    loss: column(&|k, node| secant_above(k) - node.loss_secant, 0.0),
                    turn: column(&|_, node| node.weight / (node.r * node.r), 0.0),
                }
            })
            .collect();
        let start = from_fn(|bucket| {
            let r = bucket as f64 / BUCKETS as f64;
            nodes.partition_point(|node| node.r <= r) as u8
        });
        Grid {
            nodes,
            lanes,
            start,
            initial_slope: backbone.initial_slope(),
        }
    }

    /// The knots, ascending in r.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Base knot k with the deflection e.
    #[inline(always)]
    pub(super) fn knot(&self, k: usize, e: Vector<N>) -> Knot<N> {
        let node = &self.nodes[k];
        Knot::new(node.r, e, &node.values, k, false)
    }

    /// Knot 0.
    #[inline(always)]
    pub(super) fn origin(&self) -> Knot<N> {
        let values = Values {
            slope: self.initial_slope,
            ..Values::default()
        };
        Knot::new(0.0, Vector::zeros(), &values, 0, false)
    }

    /// Whether these deflections of the base knots are within their slip limits, to rounding.
    #[inline(always)]
    pub(super) fn holds(&self, base: &[[f64; N]]) -> bool {
        // All of them, without a branch: they nearly always do.
        let pairs = self.nodes.iter().zip(base);
        pairs.fold(true, |holds, (node, e)| {
            holds & (Vector::from(*e).norm_squared() <= node.limit2)
        })
    }

    /// The base knot next above r; in one direction there is only one.
    #[inline(always)]
    pub fn interval(&self, r: f64) -> usize {
        if N == 1 {
            return 0;
        }
        let bucket = usize::from((r * BUCKETS as f64) as u8);
        let mut above = self
            .start
            .get(bucket)
            .map_or(self.nodes.len(), |k| usize::from(*k));
        while let Some(node) = self.nodes.get(above)
            && node.r <= r
        {
            above += 1;
        }
        above
    }

    /// f'(0), the sticking stiffness.
    pub fn initial_slope(&self) -> f64 {
        self.initial_slope
    }
}

/// What a segment of the base grid gives.
#[derive(Default)]
struct Secants {
    f: f64,
    /// The energy stored in a segment from a to b with slope m = (e_b - e_a) / width,
    /// m.(f_b e_b - f_a e_a) - |m|^2 (F_b - F_a), as a form in e_a and e_b.
    energy_start: f64,
    energy_product: f64,
    energy_end: f64,
}

impl Secants {
    fn new((a, below): (f64, Values), (b, above): (f64, Values)) -> Self {
        let inverse_width = 1.0 / (b - a);
        let mean = (above.integral - below.integral) * inverse_width;
        Secants {
            f: (above.f - below.f) * inverse_width,
            energy_start: (below.f - mean) * inverse_width,
            energy_product: (2.0 * mean - below.f - above.f) * inverse_width,
            energy_end: (above.f - mean) * inverse_width,
        }
    }
}
