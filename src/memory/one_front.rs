//! The common step: everything slips from the weakest element up to one front, or altogether, and sticks above.
//!
//! In one direction nothing else is possible, and on a curved path nearly all steps are of this kind. The base
//! grid is then one sum with fixed weights; only the segments around the front and the floating knots need a look
//! of their own. What is not of this kind, or comes too close to a knot, is left to the general step.

use super::grid::{Grid, Lanes, outside};
use super::lane::Lane;
use super::{
    ALONG_BOUNDARY, Curve, Increment, Matrix, NEGLIGIBLE, NO_SLIP, SAME, SHORT, STICK, Vector,
    length,
};
use crate::backbone::{Backbone, Values};
use crate::state::Contact;
use std::array::from_fn;

/// A step: the curve at its start, and how it moves.
struct Step<'a, const N: usize, B> {
    curve: &'a Curve<N>,
    backbone: &'a B,
    grid: &'a Grid<N>,
    d: &'a Vector<N>,
    scale: f64,
}

/// How many base knots slip, and how many floating knots.
struct Reach {
    base: usize,
    floating: usize,
}

/// Where slip ends.
struct Front<const N: usize> {
    r: f64,
    direction: Vector<N>,
    /// The segment of the trial curve that it stands on: slope m = rise / width.
    width: f64,
    rise: Vector<N>,
    /// width (1 - n.m): the front moves by width / closing with the increment.
    closing: f64,
}

/// A knot of the curve at the end.
#[derive(Clone, Copy)]
struct Point<const N: usize> {
    r: f64,
    e: Vector<N>,
    f: f64,
    integral: f64,
}

/// How far a trial knot is beyond its limit.
#[derive(Clone, Copy)]
struct Excess {
    r: f64,
    excess: f64,
    /// G(r)
    loss: f64,
}

impl Excess {
    /// Energy dissipated between two knots: the integral of -f'' r times the excess, by parts.
    #[inline(always)]
    fn dissipated(&self, above: &Excess) -> f64 {
        if above.r > self.r {
            (self.excess - above.excess) * (above.loss - self.loss) / (above.r - self.r)
        } else {
            0.0
        }
    }
}

/// Traction and stored energy.
struct Sums<const N: usize> {
    traction: Vector<N>,
    stored: f64,
}

impl<const N: usize> Sums<N> {
    /// Adds a segment; gives the secant of the backbone over it and its slope, None if it is too short for that.
    #[inline(always)]
    fn add(&mut self, a: &Point<N>, b: &Point<N>) -> Option<(f64, Vector<N>)> {
        let width = b.r - a.r;
        if width < SHORT * b.r {
            return None;
        }
        let inverse_width = 1.0 / width;
        let (secant, slope) = ((b.f - a.f) * inverse_width, (b.e - a.e) * inverse_width);
        self.add_chord(a, b, secant, &slope, 1.0);
        Some((secant, slope))
    }

    #[inline(always)]
    fn add_chord(
        &mut self,
        a: &Point<N>,
        b: &Point<N>,
        secant: f64,
        slope: &Vector<N>,
        times: f64,
    ) {
        self.traction += (b.e - a.e) * (secant * times);
        let stored =
            slope.dot(&(b.e * b.f - a.e * a.f)) - slope.norm_squared() * (b.integral - a.integral);
        self.stored += stored * times;
    }
}

impl<const N: usize> Curve<N> {
    /// [`Curve::advance`] where slip reaches from r = 0 up to one front; None where it does not.
    #[inline(always)]
    pub(super) fn advance_one_front<B: Backbone>(
        &self,
        backbone: &B,
        grid: &Grid<N>,
        d: &Vector<N>,
        scale: f64,
        next: &mut Curve<N>,
    ) -> Option<Increment<N>> {
        let step = Step {
            curve: self,
            backbone,
            grid,
            d,
            scale,
        };
        step.run(next)
    }
}

impl<const N: usize, B: Backbone> Step<'_, N, B> {
    #[inline(always)]
    fn run(&self, next: &mut Curve<N>) -> Option<Increment<N>> {
        let grid = self.grid;
        if self.d.norm_squared() < NO_SLIP {
            return None;
        }
        let moved = self.move_base(next);
        let reach = self.reach(&moved)?;
        if reach.base == self.count() {
            return Some(self.gross_slip(&moved, &reach, next));
        }
        // In one direction there is no other segment of the base grid.
        let b = if N == 1 { 0 } else { reach.base };
        let front = self.front(&reach)?;
        let bottom = if b == 0 { 0.0 } else { grid.nodes[b - 1].r };
        if !(front.r - bottom >= SAME && grid.nodes[b].r - front.r >= SAME) {
            return None;
        }
        let values = self.backbone.at(front.r);
        let dissipated = self.dissipated(&moved, &reach, Some((front.r, &values)));

        let mut sums = if N == 1 {
            // The front divides the only segment of the base grid.
            Sums {
                traction: Vector::zeros(),
                stored: 0.0,
            }
        } else {
            self.base_sums(next)
        };
        let bottom = self.settled(next, b);
        let at_front = Point {
            r: front.r,
            e: front.direction * front.r,
            f: values.f,
            integral: values.integral,
        };
        let (lower_secant, lower_slope) = sums.add(&bottom, &at_front)?;
        self.add_sticking(&at_front, &reach, next, &mut sums)?;

        // By parts, the weights of the front and of all that sticks above it add up to the secant below it.
        let slowing = values.slope - lower_secant;
        let shift = if N == 1 {
            // How fast the front moves and how far the slopes differ cancel.
            front.direction * slowing
        } else {
            (lower_slope * front.width - front.rise) * (slowing / front.closing)
        };
        let mut tangent = moved.turn() + shift * front.direction.transpose();
        let mut secant = lower_secant;
        if N > 1 && b > 0 {
            // The knot below the front slips with the front's segment above it instead of the grid's.
            let gain = bottom.r / length(&self.base(b - 1));
            let weight = (grid.nodes[b].secant - lower_secant) * gain;
            let n = bottom.e / bottom.r;
            tangent -= n * (n * weight).transpose();
            secant += weight;
        }
        tangent += Matrix::identity() * secant;
        let mut shrinkage = Vector::zeros();
        if self.scale != 1.0 {
            // What sticks shrinks, and the front moves with it.
            let mut slipping = Vector::zeros();
            for (node, e) in grid.nodes[..b].iter().zip(&next.base) {
                slipping += Vector::from(*e) * node.weight;
            }
            slipping += bottom.e * (grid.nodes[b].secant - lower_secant);
            shrinkage = sums.traction - slipping + shift * front.r - tangent * self.d;
        }
        Some(Increment {
            traction: sums.traction,
            tangent,
            shrinkage,
            stored: sums.stored,
            dissipated,
            contact: Some(if values.slope >= STICK * grid.initial_slope {
                Contact::Stick
            } else {
                Contact::MicroSlip
            }),
            full: false,
        })
    }

    /// The front and the sticking floating knots go to `next`, the segments between them and the base knots to the
    /// sums, in place of those of the base grid. None if a segment is too short.
    #[inline(always)]
    fn add_sticking(
        &self,
        front: &Point<N>,
        reach: &Reach,
        next: &mut Curve<N>,
        sums: &mut Sums<N>,
    ) -> Option<()> {
        let floating = &self.curve.floating[..];
        let mut index = reach.floating;
        let mut interval = if N == 1 { 0 } else { reach.base };
        let mut below = *front;
        next.push_floating(front.r, front.e, interval);
        loop {
            let top = self.settled(next, interval + 1);
            if N > 1 {
                let bottom = self.settled(next, interval);
                let node = &self.grid.nodes[interval];
                let slope = (top.e - bottom.e) * node.inverse_width;
                sums.add_chord(&bottom, &top, node.secant, &slope, -1.0);
            }
            let beside = |index: usize| {
                floating
                    .get(index)
                    .is_some_and(|knot| N == 1 || knot.above == interval)
            };
            let knot = |index: usize| {
                if beside(index) {
                    self.point(index)
                } else {
                    top
                }
            };
            let mut here = knot(index);
            // A front that closes a loop leaves the knot of that loop behind.
            while next.floating.len() == 1 && beside(index) {
                let above = knot(index + 1);
                if here.r - front.r >= SAME && matters(&below, &here, &above) {
                    break;
                }
                here = above;
                index += 1;
            }
            loop {
                sums.add(&below, &here)?;
                if !beside(index) {
                    break;
                }
                next.push_floating(here.r, here.e, interval);
                below = here;
                index += 1;
                here = knot(index);
            }
            let Some(knot) = floating.get(index) else {
                return Some(());
            };
            interval = knot.above;
            below = self.settled(next, interval);
        }
    }

    /// How many base knots there are: in one direction r = 1 is enough.
    #[inline(always)]
    fn count(&self) -> usize {
        if N == 1 { 1 } else { self.grid.nodes.len() }
    }

    /// Everything slips.
    #[inline(always)]
    fn gross_slip(&self, moved: &Base<N>, reach: &Reach, next: &Curve<N>) -> Increment<N> {
        let sums = self.base_sums(next);
        let tangent = moved.turn();
        Increment {
            traction: sums.traction,
            tangent,
            shrinkage: if self.scale == 1.0 {
                Vector::zeros()
            } else {
                tangent * -self.d
            },
            stored: sums.stored,
            dissipated: self.dissipated(moved, reach, None),
            contact: Some(Contact::GrossSlip),
            full: false,
        }
    }

    /// Base knot k on the trial curve.
    #[inline(always)]
    fn base(&self, k: usize) -> Vector<N> {
        Vector::from(self.curve.base[k]) * self.scale + self.d
    }

    /// A floating knot on the trial curve.
    #[inline(always)]
    fn floating(&self, index: usize) -> Vector<N> {
        self.curve.floating[index].e * self.scale + self.d
    }

    /// A floating knot that sticks.
    #[inline(always)]
    fn point(&self, index: usize) -> Point<N> {
        let r = self.curve.floating[index].r;
        let values = self.backbone.at(r);
        Point {
            r,
            e: self.floating(index),
            f: values.f,
            integral: values.integral,
        }
    }

    /// Base knot number `count`, 0 for the origin, at the end of the step.
    #[inline(always)]
    fn settled(&self, next: &Curve<N>, count: usize) -> Point<N> {
        match count.checked_sub(1) {
            Some(k) => {
                let node = &self.grid.nodes[k];
                Point {
                    r: node.r,
                    e: next.base[k].into(),
                    f: node.values.f,
                    integral: node.values.integral,
                }
            }
            None => Point {
                r: 0.0,
                e: Vector::zeros(),
                f: 0.0,
                integral: 0.0,
            },
        }
    }

    /// The base grid, each knot moved and brought back onto its limit: `next` gets it.
    #[inline(always)]
    fn move_base(&self, next: &mut Curve<N>) -> Base<N> {
        let mut moved = Base::new();
        next.base.clear();
        let count = self.count();
        // It has room for as many.
        let _ = next.base.try_extend_from_slice(&self.curve.base[..count]);
        let (chunks, rest) = next.base[..count].as_chunks_mut::<N>();
        let (lanes, last) = self.grid.lanes[..count.div_ceil(N)].split_at(chunks.len());
        for (lanes, e) in lanes.iter().zip(chunks) {
            *e = moved.add(lanes, e, self.d, self.scale);
        }
        if let ([e], [lanes]) = (rest, last) {
            let mut chunk = [[0.0; N]; N];
            chunk[0] = *e;
            *e = moved.add(lanes, &chunk, self.d, self.scale)[0];
        }
        moved
    }

    /// What the base knots alone give.
    #[inline(always)]
    fn base_sums(&self, next: &Curve<N>) -> Sums<N> {
        let (mut traction, mut stored) = (Lane::ZERO, Lane::ZERO);
        let mut below = Lane::ZERO;
        for (weights, e) in self.grid.weights.iter().zip(&next.base[..self.count()]) {
            let e = Lane(*e);
            traction = traction + e * weights.traction;
            stored = stored + e * (e * weights.energy + below * weights.energy_below);
            below = e;
        }
        Sums {
            traction: traction.0.into(),
            stored: stored.sum(),
        }
    }

    /// How far slip reaches; None when something sticks below a knot that slips.
    #[inline(always)]
    fn reach(&self, moved: &Base<N>) -> Option<Reach> {
        let base = usize::from(moved.count.sum() as u8);
        let mut ordered = base == 0 || moved.top.largest() == self.grid.nodes[base - 1].r;
        let mut reached = 0;
        for (index, knot) in self.curve.floating.iter().enumerate() {
            let e = knot.e * self.scale + self.d;
            if e.norm_squared() >= outside(knot.r) && self.d.dot(&e) > 0.0 {
                ordered &= reached == index && knot.above <= base;
                reached = index + 1;
            } else {
                ordered &= knot.above >= base;
            }
        }
        if N == 1 {
            // Everything below the largest outside knot is outside.
            ordered = true;
            if base == 1 {
                reached = self.curve.floating.len();
            }
        }
        ordered.then_some(Reach {
            base,
            floating: reached,
        })
    }

    /// The front on the trial curve between the last slipping and the first sticking knot: where |trial| = r. None
    /// where that segment lies along the yield boundary.
    #[inline(always)]
    fn front(&self, reach: &Reach) -> Option<Front<N>> {
        let b = if N == 1 { 0 } else { reach.base };
        let (nodes, floating) = (&self.grid.nodes, &self.curve.floating);
        let (r, e) = match reach.floating.checked_sub(1) {
            Some(index) if N == 1 || floating[index].above == b => {
                (floating[index].r, self.floating(index))
            }
            _ => match b.checked_sub(1) {
                Some(k) => (nodes[k].r, self.base(k)),
                None => (0.0, *self.d),
            },
        };
        let (above, end) = match floating.get(reach.floating) {
            Some(knot) if N == 1 || knot.above == b => (knot.r, self.floating(reach.floating)),
            _ => (nodes[b].r, self.base(b)),
        };
        let width = above - r;
        let rise = end - e;
        let (s, direction, closing) = if N == 1 {
            // Everything that slips is deflected along the increment, and the excess falls linearly.
            let n = Vector::<N>::repeat(1f64.copysign(self.d[0]));
            let excess = (n.dot(&e) - r).max(0.0);
            let closing = excess + (above - n.dot(&end));
            (excess / closing, n, closing)
        } else {
            // |trial|^2 - r^2 = a s^2 + 2 b s + c with s from 0 to 1, and its root where it turns negative, without
            // cancellation.
            let a = rise.norm_squared() - width * width;
            let b = e.dot(&rise) - r * width;
            let c = (e.norm_squared() - r * r).max(0.0);
            let root = (b * b - a * c).max(0.0).sqrt();
            let s = if b > 0.0 {
                -(b + root) / a
            } else if c > 0.0 {
                c / (root - b)
            } else {
                0.0
            };
            // Rounding alone leads out of the segment.
            let s = if s < 1.0 { s.max(0.0) } else { 1.0 };
            let trial = e + rise * s;
            let n = trial / trial.norm();
            (s, n, width - n.dot(&rise))
        };
        (closing.abs() > ALONG_BOUNDARY * width).then_some(Front {
            r: r + width * s,
            direction,
            width,
            rise,
            closing,
        })
    }

    /// How far the trial curve is beyond its limit at base knot number `count`, 0 for the origin.
    #[inline(always)]
    fn excess(&self, count: usize) -> Excess {
        match count.checked_sub(1) {
            Some(k) => Excess {
                r: self.grid.nodes[k].r,
                excess: (length(&self.base(k)) - self.grid.nodes[k].r).max(0.0),
                loss: self.grid.nodes[k].values.loss,
            },
            None => Excess {
                r: 0.0,
                excess: length(self.d),
                loss: 0.0,
            },
        }
    }

    /// Energy dissipated up to the front, on the trial curve.
    #[inline(always)]
    fn dissipated(&self, moved: &Base<N>, reach: &Reach, front: Option<(f64, &Values)>) -> f64 {
        let mut sum = 0.0;
        let nodes = &self.grid.nodes;
        let b = match front {
            Some(_) if N == 1 => 0,
            _ => reach.base,
        };
        if b > 0 {
            sum = length(self.d) * nodes[0].loss_secant + moved.dissipated.sum();
        }
        // A segment of the base grid gives way to those between the knots that divide it.
        let mut interval = 0;
        let mut from = self.excess(0);
        let close = |interval: usize, from: &Excess| {
            let end = self.excess(interval + 1);
            let start = self.excess(interval);
            from.dissipated(&end) - (start.excess - end.excess) * nodes[interval].loss_secant
        };
        let mut divided = false;
        for knot in &self.curve.floating[..reach.floating] {
            if N > 1 && knot.above != interval {
                if divided {
                    sum += close(interval, &from);
                }
                interval = knot.above;
                from = self.excess(interval);
            }
            let here = Excess {
                r: knot.r,
                excess: (length(&(knot.e * self.scale + self.d)) - knot.r).max(0.0),
                loss: self.backbone.at(knot.r).loss,
            };
            sum += from.dissipated(&here);
            from = here;
            divided = true;
        }
        if interval != b {
            if divided {
                sum += close(interval, &from);
            }
            from = self.excess(b);
        }
        if let Some((r, values)) = front {
            sum += from.dissipated(&Excess {
                r,
                excess: 0.0,
                loss: values.loss,
            });
            if b > 0 {
                sum -= self.excess(b).excess * nodes[b].loss_secant;
            }
        }
        sum
    }
}

/// Whether a floating knot matters: its distance from the chord, times the kink of the backbone there, is the
/// traction that would be lost with it.
#[inline(always)]
fn matters<const N: usize>(below: &Point<N>, knot: &Point<N>, above: &Point<N>) -> bool {
    let (low, high) = (knot.r - below.r, above.r - knot.r);
    let off = (knot.e - below.e) * high - (above.e - knot.e) * low;
    let kink = (knot.f - below.f) * high - (above.f - knot.f) * low;
    let least = NEGLIGIBLE * (low * high * (low + high));
    off.norm_squared() * (kink * kink) >= least * least
}

/// What the base knots alone give, lane by lane.
struct Base<const N: usize> {
    /// The largest r that slips, 0 for none, and how many slip.
    top: Lane<N>,
    count: Lane<N>,
    dissipated: Lane<N>,
    /// Sum of weight times gain times n n^T over the slipping knots: lower triangle.
    turn: [[Lane<N>; N]; N],
}

impl<const N: usize> Base<N> {
    fn new() -> Self {
        Base {
            top: Lane::ZERO,
            count: Lane::ZERO,
            dissipated: Lane::ZERO,
            turn: [[Lane::ZERO; N]; N],
        }
    }

    /// Moves N base knots.
    #[inline(always)]
    fn add(
        &mut self,
        lanes: &Lanes<N>,
        knots: &[[f64; N]; N],
        d: &Vector<N>,
        scale: f64,
    ) -> [[f64; N]; N] {
        let mut e: [Lane<N>; N] =
            from_fn(|i| Lane(from_fn(|lane| knots[lane][i])) * Lane::all(scale) + Lane::all(d[i]));
        let length2 = dot(&e, &e);
        let slips = length2.reaches(lanes.outside, dot(&e, &from_fn(|i| Lane::all(d[i]))));
        if slips.any() {
            let one = slips.number();
            self.count = self.count + one;
            self.top = self.top.max(lanes.r * one);
            let length = if N == 1 { e[0].abs() } else { length2.sqrt() };
            let gain = slips.ratio_or_one(lanes.r, length);
            let excess = ((length - lanes.r) * one).max(Lane::ZERO);
            self.dissipated = self.dissipated + excess * lanes.loss;
            for e in &mut e {
                *e = *e * gain;
            }
            // In one direction there is nowhere to turn.
            if N > 1 {
                let turn = lanes.turn * gain * one;
                for i in 0..N {
                    for j in 0..i + 1 {
                        self.turn[i][j] = self.turn[i][j] + turn * (e[i] * e[j]);
                    }
                }
            }
        }
        from_fn(|lane| from_fn(|i| e[i].0[lane]))
    }

    /// A slipping knot turns on its limit: weight times gain times (I - n n^T).
    #[inline(always)]
    fn turn(&self) -> Matrix<N> {
        if N == 1 {
            return Matrix::zeros();
        }
        let turn = Matrix::<N>::from_fn(|i, j| self.turn[i.max(j)][i.min(j)].sum());
        Matrix::identity() * turn.trace() - turn
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[Lane<N>; N], b: &[Lane<N>; N]) -> Lane<N> {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum = sum + a[i] * b[i];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backbone::{PowerLaw, Segalman};
    use approx::assert_abs_diff_eq;

    const ROOM: usize = 12;

    /// The general step gives the same; how many steps were of the common kind.
    fn compare<const N: usize>(backbone: &impl Backbone, count: usize, seed: u64) -> usize {
        let grid = Grid::<N>::new(backbone, count);
        let mut random = fastrand::Rng::with_seed(seed);
        let mut curve = Curve::new();
        assert!(curve.set_base(&grid, &vec![[0.0; N]; count]));
        let mut common = 0;
        for step in 0..20_000 {
            let size = 10f64.powf(random.f64() * 4.0 - 3.5);
            let d = Vector::from_fn(|_, _| size * (2.0 * random.f64() - 1.0));
            let scale = if step % 7 == 0 { random.f64() } else { 1.0 };
            let (mut one, mut any) = (Curve::new(), Curve::new());
            let general = curve.advance_any(backbone, &grid, &d, scale, ROOM, &mut any);
            if curve.floating.len() < ROOM
                && let Some(short) = curve.advance_one_front(backbone, &grid, &d, scale, &mut one)
            {
                common += 1;
                assert_eq!(short.contact, general.contact, "step {step}");
                assert_eq!(short.full, general.full, "step {step}");
                assert_abs_diff_eq!(short.traction, general.traction, epsilon = 1e-14);
                assert_abs_diff_eq!(short.tangent, general.tangent, epsilon = 1e-8);
                assert_abs_diff_eq!(short.stored, general.stored, epsilon = 1e-13);
                assert_abs_diff_eq!(short.dissipated, general.dissipated, epsilon = 1e-13);
                if scale != 1.0 {
                    assert_abs_diff_eq!(short.shrinkage, general.shrinkage, epsilon = 1e-8);
                }
                assert_eq!(one.floating.len(), any.floating.len(), "step {step}");
                for (a, b) in one.floating.iter().zip(&any.floating) {
                    assert_eq!(a.above, b.above, "step {step}");
                    assert_abs_diff_eq!(a.r, b.r, epsilon = 1e-12);
                    assert_abs_diff_eq!(a.e, b.e, epsilon = 1e-12);
                }
                for (a, b) in one.base.iter().zip(&any.base) {
                    assert_abs_diff_eq!(Vector::from(*a), Vector::from(*b), epsilon = 1e-14);
                }
            }
            curve = any;
        }
        common
    }

    #[test]
    fn the_common_step_is_the_general_step() {
        for (seed, chi) in [1.0, 1.5, 2.5, 3.3].into_iter().enumerate() {
            let backbone = PowerLaw::new(chi);
            assert!(compare::<1>(&backbone, 1, seed as u64) > 15_000);
            assert!(compare::<2>(&backbone, 16, seed as u64) > 10_000);
            assert!(compare::<2>(&backbone, 7, seed as u64) > 10_000);
        }
        let backbone = Segalman::new(-0.5, 0.3);
        assert!(compare::<1>(&backbone, 1, 5) > 15_000);
        assert!(compare::<2>(&backbone, 16, 6) > 10_000);
    }
}
