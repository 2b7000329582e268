//! The memory curve: what the contact remembers, and how it moves.
//!
//! Everything here is normalised: slip by the critical slip, traction by mu p. The state is a curve e(r),
//! 0 <= r <= 1: the elastic deflection of the slip element whose slip limit is r, with |e(r)| <= r and
//! e(0) = 0. It is kept as sorted knots, linear in between. Two kinds of knot: those of a fixed **base** grid are
//! never dropped, **floating** ones stand where a reversal turned and at the front of the slipping elements.
//!
//! The traction is the sum over the elements, integrated by parts so that only secants of the backbone are needed:
//!
//! ```text
//! t = sum_k (e_k+1 - e_k) / (r_k+1 - r_k) (f(r_k+1) - f(r_k))
//! ```
//!
//! A slip increment d moves every element by d; those beyond their limit slip (radial return). On a straight
//! path that is exact to rounding, for any number of reversals that the floating knots can hold.

use crate::backbone::{Backbone, Values};
use crate::state::{Contact, MAX_BASE, MAX_FLOATING};
use arrayvec::ArrayVec;
use nalgebra::{SMatrix, SVector};

/// A vector in the tangential plane: N = 1 or 2 directions.
pub type Vector<const N: usize> = SVector<f64, N>;
/// A tangent in the tangential plane.
pub type Matrix<const N: usize> = SMatrix<f64, N, N>;

/// Rounding of r and e: what is closer than this is the same.
const SAME: f64 = 1e-14;
/// A floating knot whose removal changes the traction by less than this is not needed.
const NEGLIGIBLE: f64 = 1e-14;
/// A segment whose slope agrees with the yield boundary's to this lies along it.
const ALONG_BOUNDARY: f64 = 1e-7;
/// Below this length, relative to r, a secant of the backbone loses digits and the mean of the slopes is better.
const SHORT: f64 = 1e-7;
/// Squared length of an increment too small to have a direction.
const NO_SLIP: f64 = 1e-280;
/// The largest part of the sticking stiffness that may have slipped in a contact called sticking.
const STICK: f64 = 0.99;

/// A knot of the base grid with all that does not change.
///
/// With base knots only, the sums of the curve are sums over the knots with fixed weights.
#[derive(Clone, Debug)]
pub struct Node {
    /// Slip limit.
    pub r: f64,
    inverse_r: f64,
    /// Squared length from which a trial deflection is outside.
    outside: f64,
    values: Values,
    /// 1 / width of the segment below.
    inverse_width: f64,
    /// Secants of f and G over the segment below.
    secant: f64,
    loss_secant: f64,
    /// Weight of e in the traction: secant below - secant above.
    weight: f64,
    /// Weights of |e|^2, and of e times the deflection of the knot below, in the stored energy.
    energy: f64,
    energy_below: f64,
}

/// The base grid of a backbone.
#[derive(Clone, Debug)]
pub struct Grid {
    nodes: Vec<Node>,
    initial_slope: f64,
}

impl Grid {
    /// `count` knots (knot 0 is not stored), the last at r = 1.
    pub fn new(backbone: &impl Backbone, count: usize) -> Self {
        let at = |k: usize| {
            let r = backbone.grid(k, count);
            (r, backbone.at(r))
        };
        let nodes = (1..=count)
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
                    inverse_r: 1.0 / r,
                    outside: outside(r),
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
        Grid {
            nodes,
            initial_slope: backbone.initial_slope(),
        }
    }

    /// The knots, ascending in r.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
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

/// Squared length from which a trial deflection is outside the slip limit r.
#[inline]
fn outside(r: f64) -> f64 {
    let limit = (r - SAME).max(0.0);
    limit * limit
}

/// `e` brought radially onto the slip limit r.
pub fn onto_limit<const N: usize>(r: f64, e: &Vector<N>) -> Vector<N> {
    e * (r / e.norm())
}

/// How a knot moves with the increment.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Inside its slip limit: it moves with the increment.
    Sticking,
    /// Beyond its slip limit, brought back onto it.
    Slipping,
    /// The front between slipping elements and the sticking ones above it.
    FrontBelowStick,
    /// The front between sticking elements and the slipping ones above it.
    FrontAboveStick,
}

/// One knot of the curve.
#[derive(Clone, Copy, Debug)]
pub struct Knot<const N: usize> {
    /// Slip limit.
    pub r: f64,
    /// Elastic deflection.
    pub e: Vector<N>,
    values: Values,
    /// The base knot next above (for a floating knot), or the knot itself.
    above: usize,
    motion: Motion,
    /// Knots that slip: r / |trial|. Fronts: 1 / (1 - n.m), how fast the front moves with the increment.
    gain: f64,
}

impl<const N: usize> Knot<N> {
    #[inline]
    fn new(r: f64, e: Vector<N>, values: Values, above: usize) -> Self {
        Knot {
            r,
            e,
            values,
            above,
            motion: Motion::Sticking,
            gain: 0.0,
        }
    }

    /// Knot 0. It has no limit and no deflection: whenever something slips, it does.
    #[inline]
    fn origin(trial: &Vector<N>, grid: &Grid) -> Self {
        let values = Values {
            slope: grid.initial_slope,
            ..Values::default()
        };
        let mut knot = Knot::new(0.0, *trial, values, 0);
        knot.motion = Motion::Slipping;
        knot
    }

    fn slips(&self) -> bool {
        self.motion == Motion::Slipping
    }

    fn is_front(&self) -> bool {
        matches!(
            self.motion,
            Motion::FrontBelowStick | Motion::FrontAboveStick
        )
    }

    /// How far a trial knot is beyond its limit, if it slips.
    #[inline]
    fn excess(&self) -> f64 {
        if self.slips() {
            (self.e.norm() - self.r).max(0.0)
        } else {
            0.0
        }
    }
}

/// A memory curve: the deflections of the base grid, and the floating knots between them.
#[derive(Clone, Debug, Default)]
pub struct Curve<const N: usize> {
    base: ArrayVec<Vector<N>, MAX_BASE>,
    floating: ArrayVec<Knot<N>, ROOM>,
    /// Bit k: base knot k slips.
    slipping: u64,
    /// Bit k: floating knots lie below base knot k (and above the base knot before it).
    occupied: u64,
}

/// Room for what a full state holds, or for every front that one increment can make.
const ROOM: usize = 2 * MAX_BASE;
const _: () = assert!(ROOM >= MAX_FLOATING && MAX_BASE <= 64);

/// What an increment gives, normalised.
#[derive(Clone, Debug)]
pub struct Increment<const N: usize> {
    /// Traction over mu p.
    pub traction: Vector<N>,
    /// d traction / d slip increment.
    pub tangent: Matrix<N>,
    /// What the traction loses when the remembered deflections shrink: -d traction / d(log of their scale).
    pub shrinkage: Vector<N>,
    /// Stored energy over gcr mu p.
    pub stored: f64,
    /// Energy dissipated by slip over gcr mu p.
    pub dissipated: f64,
    /// Where the contact stands; None for a zero increment, which changes nothing.
    pub contact: Option<Contact>,
    /// A reversal that mattered had to be dropped.
    pub full: bool,
}

/// What the fronts of an increment give.
#[derive(Default)]
struct Fronts {
    count: usize,
    /// One fell on knot 0.
    at_origin: bool,
    /// Slope of the backbone at the highest front below sticking elements.
    slope: f64,
    /// Energy dissipated in the segments next to fronts and floating knots.
    dissipated: f64,
}

/// A front that fell on a base knot, which stands for it.
struct BaseFront<const N: usize> {
    k: usize,
    direction: Vector<N>,
    motion: Motion,
    gain: f64,
}

/// A segment that lies along the yield boundary, by the end that was taken to stick.
enum Along {
    Base(usize),
    Floating(usize),
}

impl<const N: usize> Curve<N> {
    /// An empty curve.
    #[inline]
    pub fn new() -> Self {
        Curve {
            base: ArrayVec::new(),
            floating: ArrayVec::new(),
            slipping: 0,
            occupied: 0,
        }
    }

    /// Deflections of the base knots, ascending in r.
    pub fn base(&self) -> &[Vector<N>] {
        &self.base
    }

    /// The floating knots, ascending in r.
    pub fn floating(&self) -> &[Knot<N>] {
        &self.floating
    }

    /// Adds the next base knot.
    #[inline]
    pub fn push_base(&mut self, e: Vector<N>) {
        self.base.push(e);
    }

    /// Adds the next floating knot, which lies below base knot `above` (from 0).
    #[inline]
    pub fn push_floating(&mut self, r: f64, e: Vector<N>, above: usize) {
        self.occupied |= 1 << above;
        self.floating
            .push(Knot::new(r, e, Values::default(), above));
    }

    /// Empties the memory.
    pub fn forget(&mut self) {
        self.floating.clear();
        self.occupied = 0;
        self.saturate(&Vector::zeros(), &[]);
    }

    /// All slip elements at their limit in one direction (a unit vector, or zero for none).
    pub fn saturate(&mut self, direction: &Vector<N>, nodes: &[Node]) {
        for (k, e) in self.base.iter_mut().enumerate() {
            *e = direction * nodes.get(k).map_or(0.0, |node| node.r);
        }
    }

    /// Moves the curve by the slip increment `d` after scaling it by `scale` (pressure rule); `next`, empty, gets
    /// the curve at the end, with at most `room` floating knots. This curve is used up.
    #[inline]
    pub fn advance<B: Backbone>(
        &mut self,
        backbone: &B,
        grid: &Grid,
        d: &Vector<N>,
        scale: f64,
        room: usize,
        next: &mut Curve<N>,
    ) -> Increment<N> {
        for knot in &mut self.floating {
            knot.values = backbone.at(knot.r);
            knot.e *= scale;
        }
        if scale != 1.0 {
            self.base.iter_mut().for_each(|e| *e *= scale);
        }
        let mut full = false;
        let mut contact = None;
        let mut on_base = ArrayVec::new();
        let mut fronts = Fronts::default();
        if d.norm_squared() < NO_SLIP {
            // Nothing slips, not even the elements without a limit.
            fronts.at_origin = true;
            next.floating.extend(self.floating.iter().copied());
        } else {
            fronts = self.turn(backbone, grid, d, room, next, &mut on_base, &mut full);
            contact = Some(self.contact(grid, &fronts));
        }
        let mut sums = Sums::new();
        self.slip(grid, d, &on_base, next, &mut sums);
        next.drop_beside_fronts(grid);
        while next.floating.len() > room && next.drop_least(grid, &Vector::zeros(), &mut full) {}
        self.refine(grid, next, &mut sums);
        for front in &on_base {
            next.add_base_front(grid, front, &mut sums);
        }
        if fronts.at_origin {
            sums.stick += grid.initial_slope - next.first_secant(grid);
        }
        let tangent = Matrix::identity() * sums.stick + sums.turn;
        Increment {
            traction: sums.traction,
            tangent,
            shrinkage: sums.remembered - tangent * d,
            stored: sums.stored,
            dissipated: fronts.dissipated + sums.dissipated,
            contact,
            full,
        }
    }

    /// Steps 1 and 2: the trial curve, and the fronts on it.
    #[expect(
        clippy::too_many_arguments,
        reason = "buffers that travel in a struct cost more than the step"
    )]
    #[inline]
    fn turn<B: Backbone>(
        &mut self,
        backbone: &B,
        grid: &Grid,
        d: &Vector<N>,
        room: usize,
        next: &mut Curve<N>,
        on_base: &mut ArrayVec<BaseFront<N>, ROOM>,
        full: &mut bool,
    ) -> Fronts {
        // A full array must give way when slip turns, whatever the length of this increment: a long one that would
        // wipe out a knot and a short one that would not have to go on from the same curve.
        if self.floating.len() >= room {
            self.mark(grid, d, &Vector::zeros());
            while self.needed() > room && self.drop_least(grid, &Vector::zeros(), full) {}
            self.unmark();
        }
        self.mark(grid, d, d);
        loop {
            next.floating.clear();
            on_base.clear();
            match self.place_fronts(backbone, grid, d, next, on_base) {
                // Rounding must not cut it: it slips as a whole.
                Err(Along::Base(k)) => self.slipping |= 1 << k,
                Err(Along::Floating(index)) => self.floating[index].motion = Motion::Slipping,
                Ok(fronts) => {
                    // Decided, and done, on the curve before the fronts stand on it. The choice then does not depend
                    // on how far the increment goes: a branch in one step and in a thousand drop the same reversal
                    // and travel on the same curve.
                    let enough =
                        self.floating.len() + fronts.count <= room || self.needed() <= room;
                    if enough || !self.drop_least(grid, d, full) {
                        return fronts;
                    }
                }
            }
        }
    }

    /// Where the contact stands after a slip.
    fn contact(&self, grid: &Grid, fronts: &Fronts) -> Contact {
        if self.base_slips(self.base.len() - 1) {
            Contact::GrossSlip
        } else if fronts.slope >= STICK * grid.initial_slope {
            Contact::Stick
        } else {
            Contact::MicroSlip
        }
    }

    #[inline]
    fn base_slips(&self, k: usize) -> bool {
        self.slipping >> k & 1 == 1
    }

    /// Base knot k as a knot.
    #[inline]
    fn base_knot(&self, grid: &Grid, k: usize) -> Knot<N> {
        let node = &grid.nodes[k];
        let mut knot = Knot::new(node.r, self.base[k], node.values, k);
        if self.base_slips(k) {
            knot.motion = Motion::Slipping;
        }
        knot
    }

    /// The knot at the lower end of the segment below base knot k; knot 0 has the deflection `origin`.
    #[inline]
    fn base_below(&self, grid: &Grid, k: usize, origin: &Vector<N>) -> Knot<N> {
        match k.checked_sub(1) {
            Some(below) => self.base_knot(grid, below),
            None => Knot::origin(origin, grid),
        }
    }

    /// Adds `shift` to all deflections, and marks which knots are then outside their slip limit, or at it and on
    /// the way out.
    #[inline]
    fn mark(&mut self, grid: &Grid, d: &Vector<N>, shift: &Vector<N>) {
        for (k, (e, node)) in self.base.iter_mut().zip(&grid.nodes).enumerate() {
            *e += shift;
            let slips = (e.norm_squared() >= node.outside) & (d.dot(e) > 0.0);
            self.slipping |= u64::from(slips) << k;
        }
        for knot in &mut self.floating {
            knot.e += shift;
            if knot.e.norm_squared() >= outside(knot.r) && d.dot(&knot.e) > 0.0 {
                knot.motion = Motion::Slipping;
            }
        }
        if N == 1 {
            // In one direction everything below the largest outside knot is outside.
            let top = (u64::BITS - self.slipping.leading_zeros()) as usize;
            let mut below = |k: usize| self.slipping |= !(u64::MAX << k);
            below(top);
            let mut slips = false;
            for knot in self.floating.iter_mut().rev() {
                slips |= knot.slips() || knot.above < top;
                if slips {
                    knot.motion = Motion::Slipping;
                    below(knot.above);
                }
            }
        }
    }

    /// Takes the marks back.
    fn unmark(&mut self) {
        self.slipping = 0;
        for knot in &mut self.floating {
            knot.motion = Motion::Sticking;
        }
    }

    /// The segments of the base grid in which slip ends or begins, or floating knots lie, by the knot above.
    #[inline]
    fn divided(&self) -> u64 {
        let all = u64::MAX >> (u64::BITS as usize - self.base.len());
        ((self.slipping ^ (self.slipping << 1 | 1)) & all) | self.occupied
    }

    /// How many floating knots stay, and how many fronts come.
    fn needed(&self) -> usize {
        let mut floating = self.floating.iter().peekable();
        let (mut needed, mut slips) = (0, true);
        for k in 0..self.base.len() {
            while let Some(knot) = floating.next_if(|knot| knot.above == k) {
                needed += usize::from(!knot.slips()) + usize::from(knot.slips() != slips);
                slips = knot.slips();
            }
            needed += usize::from(self.base_slips(k) != slips);
            slips = self.base_slips(k);
        }
        needed
    }

    /// Drops the floating knot that matters least among those that stay; false if there is none.
    #[cold]
    fn drop_least(&mut self, grid: &Grid, origin: &Vector<N>, full: &mut bool) -> bool {
        let mut least = None;
        for (index, knot) in self.floating.iter().enumerate() {
            if !knot.slips() {
                let weight = self.weight(grid, origin, index);
                if least.is_none_or(|(lightest, _)| weight < lightest) {
                    least = Some((weight, index));
                }
            }
        }
        if let Some((weight, index)) = least {
            self.floating.remove(index);
            *full |= weight >= NEGLIGIBLE;
        }
        least.is_some()
    }

    /// How much the traction changes when a floating knot is taken out; knot 0 has the deflection `origin`.
    fn weight(&self, grid: &Grid, origin: &Vector<N>, index: usize) -> f64 {
        let knot = &self.floating[index];
        let beside =
            |other: Option<&Knot<N>>| other.filter(|other| other.above == knot.above).copied();
        let a = beside(index.checked_sub(1).map(|before| &self.floating[before]))
            .unwrap_or_else(|| self.base_below(grid, knot.above, origin));
        let b = beside(self.floating.get(index + 1))
            .unwrap_or_else(|| self.base_knot(grid, knot.above));
        let (low, high) = (knot.r - a.r, b.r - knot.r);
        // Distance of the knot from the chord, times the kink of the backbone there.
        let off = (knot.e - a.e) * high - (b.e - knot.e) * low;
        let kink = (knot.values.f - a.values.f) * high - (b.values.f - knot.values.f) * low;
        off.norm() * kink.abs() / (low * high * (low + high))
    }

    /// Step 2: fronts where slipping ends or begins; `next` gets them and the floating knots that stick. Also the
    /// energy dissipated in the segments that are not plain segments of the base grid.
    #[inline]
    fn place_fronts<B: Backbone>(
        &self,
        backbone: &B,
        grid: &Grid,
        d: &Vector<N>,
        next: &mut Curve<N>,
        on_base: &mut ArrayVec<BaseFront<N>, ROOM>,
    ) -> Result<Fronts, Along> {
        let mut fronts = Fronts::default();
        let mut index = 0;
        let mut divided = self.divided();
        while divided != 0 {
            let k = divided.trailing_zeros() as usize;
            divided &= divided - 1;
            let (bottom, top) = (self.base_below(grid, k, d), self.base_knot(grid, k));
            let mut below = &bottom;
            let mut excess_below = below.excess();
            loop {
                let floating = self.floating.get(index).filter(|knot| knot.above == k);
                let here = floating.unwrap_or(&top);
                let excess = here.excess();
                if below.slips() != here.slips() {
                    let mut front = front(below, here);
                    if front.gain.is_nan() || front.gain.abs() * ALONG_BOUNDARY > 1.0 {
                        return Err(match (below.slips(), floating) {
                            (true, Some(_)) => Along::Floating(index),
                            (true, None) => Along::Base(k),
                            (false, _) if below.above == k => Along::Floating(index - 1),
                            (false, _) => Along::Base(k - 1),
                        });
                    }
                    front.values = backbone.at(front.r);
                    if below.slips() {
                        front.motion = Motion::FrontBelowStick;
                        fronts.slope = front.values.slope;
                    } else {
                        front.motion = Motion::FrontAboveStick;
                    }
                    fronts.count += 1;
                    fronts.dissipated += excess_below * loss_secant(below, &front)
                        - excess * loss_secant(&front, here);
                    fronts.at_origin |= next.place_front(&front, grid, on_base);
                } else if here.slips() {
                    fronts.dissipated += (excess_below - excess) * loss_secant(below, here);
                }
                let Some(knot) = floating else {
                    break;
                };
                // A floating knot that slipped has nothing left to remember.
                if !knot.slips() {
                    next.floating.push(*knot);
                }
                (below, excess_below) = (knot, excess);
                index += 1;
            }
        }
        Ok(fronts)
    }

    /// Stores a front; a base knot that it falls on becomes the front. True if it fell on knot 0.
    #[inline]
    fn place_front(
        &mut self,
        front: &Knot<N>,
        grid: &Grid,
        on_base: &mut ArrayVec<BaseFront<N>, ROOM>,
    ) -> bool {
        while let Some(last) = self.floating.last()
            && last.above == front.above
            && front.r - last.r < SAME
        {
            // Two fronts in one place: what was between them is gone.
            let closed = last.is_front();
            self.floating.pop();
            if closed {
                return false;
            }
        }
        let k = front.above;
        let below = if k == 0 { 0.0 } else { grid.nodes[k - 1].r };
        let fallen_on = if grid.nodes[k].r - front.r < SAME {
            k
        } else if front.r - below >= SAME {
            self.floating.push(*front);
            return false;
        } else if k == 0 {
            return true;
        } else {
            k - 1
        };
        on_base.push(BaseFront {
            k: fallen_on,
            direction: front.e / front.r,
            motion: front.motion,
            gain: front.gain,
        });
        false
    }

    /// Step 3: radial return of the base knots; `next` gets them. All that the base grid alone gives.
    ///
    /// The dissipated energy is the integral of -f'' r (|trial| - r) over the slipping elements, exact for an
    /// excess that is linear between knots: by parts, with G'' = -r f'' and G' = f - r f' (1 at r = 1).
    #[inline]
    fn slip(
        &mut self,
        grid: &Grid,
        d: &Vector<N>,
        on_base: &[BaseFront<N>],
        next: &mut Curve<N>,
        sums: &mut Sums<N>,
    ) {
        let divided = self.divided();
        for front in on_base {
            // It moves with the front, and like a sticking knot but for what add_base_front adds.
            self.base[front.k] = front.direction * grid.nodes[front.k].r;
            self.slipping &= !(1 << front.k);
        }
        let mut below = Vector::zeros();
        let mut excess_below = d.norm();
        for (k, (trial, node)) in self.base.iter().zip(&grid.nodes).enumerate() {
            let mut e = *trial;
            let mut excess = 0.0;
            if self.base_slips(k) {
                let length = e.norm();
                let gain = node.r / length;
                e *= gain;
                excess = (length - node.r).max(0.0);
                sums.add_slipping(&(e * node.inverse_r), node.weight * gain);
            } else {
                sums.stick += node.weight;
                sums.remembered += e * node.weight;
            }
            if divided >> k & 1 == 0 {
                sums.dissipated += (excess_below - excess) * node.loss_secant;
            }
            sums.traction += e * node.weight;
            sums.stored += e.norm_squared() * node.energy + e.dot(&below) * node.energy_below;
            next.base.push(e);
            (below, excess_below) = (e, excess);
        }
        sums.dissipated += excess_below;
    }

    /// Step 4: floating knots next to a front that do not matter go.
    #[inline]
    fn drop_beside_fronts(&mut self, grid: &Grid) {
        let mut index = 0;
        while index < self.floating.len() {
            if self.floating[index].is_front() {
                while self.is_needless(grid, index + 1) {
                    self.floating.remove(index + 1);
                }
                while index > 0 && self.is_needless(grid, index - 1) {
                    self.floating.remove(index - 1);
                    index -= 1;
                }
            }
            index += 1;
        }
    }

    fn is_needless(&self, grid: &Grid, index: usize) -> bool {
        self.floating.get(index).is_some_and(|knot| {
            let doubled = index > 0 && knot.r - self.floating[index - 1].r < SAME;
            knot.motion == Motion::Sticking
                && (doubled || self.weight(grid, &Vector::zeros(), index) < NEGLIGIBLE)
        })
    }

    /// Corrects what the base grid alone gives in those of its segments that the floating knots of `next` divide.
    #[inline]
    fn refine(&self, grid: &Grid, next: &Curve<N>, sums: &mut Sums<N>) {
        let settled = |k: usize| {
            let node = &grid.nodes[k];
            let mut knot = Knot::new(node.r, next.base[k], node.values, k);
            if self.base_slips(k) {
                knot.motion = Motion::Slipping;
                knot.gain = node.r / self.base[k].norm();
            }
            knot
        };
        let mut floating = next.floating.iter().peekable();
        while let Some(knot) = floating.next() {
            let k = knot.above;
            let top = settled(k);
            let bottom = match k.checked_sub(1) {
                Some(below) => settled(below),
                None => Knot::origin(&Vector::zeros(), grid),
            };
            let chord = Segment {
                secant: grid.nodes[k].secant,
                slope: (top.e - bottom.e) * grid.nodes[k].inverse_width,
            };
            sums.add_segment(&bottom, &top, &chord, -1.0);
            let (mut below, mut lower, mut here) = (&bottom, chord, knot);
            loop {
                let upper = Segment::between(below, here);
                sums.add_segment(below, here, &upper, 1.0);
                sums.add(below, &lower, &upper);
                (below, lower) = (here, upper);
                if here.r == top.r {
                    break;
                }
                here = floating.next_if(|knot| knot.above == k).unwrap_or(&top);
            }
            sums.add(&top, &lower, &chord);
        }
    }

    /// Adds what a front gives that stands on a base knot, besides what the knot gives by sticking.
    #[cold]
    fn add_base_front(&self, grid: &Grid, front: &BaseFront<N>, sums: &mut Sums<N>) {
        let k = front.k;
        let here = self.base_knot(grid, k);
        let below = self.floating.iter().rfind(|knot| knot.above == k).copied();
        let below = below.unwrap_or_else(|| self.base_below(grid, k, &Vector::zeros()));
        let above = self
            .floating
            .iter()
            .find(|knot| knot.above == k + 1)
            .copied();
        let above =
            above.or_else(|| (k + 1 < self.base.len()).then(|| self.base_knot(grid, k + 1)));
        let lower = Segment::between(&below, &here);
        let upper = above.map_or_else(Segment::beyond, |above| Segment::between(&here, &above));
        let knot = Knot {
            motion: front.motion,
            gain: front.gain,
            ..here
        };
        sums.add_shift(&knot, &lower, &upper);
    }

    /// Secant of the backbone over the lowest segment.
    fn first_secant(&self, grid: &Grid) -> f64 {
        let origin = Knot::origin(&Vector::zeros(), grid);
        match self.floating.first() {
            Some(knot) if knot.above == 0 => Segment::between(&origin, knot).secant,
            _ => grid.nodes[0].secant,
        }
    }
}

/// Secant of G between two knots.
#[inline]
fn loss_secant<const N: usize>(a: &Knot<N>, b: &Knot<N>) -> f64 {
    if b.r > a.r {
        (b.values.loss - a.values.loss) / (b.r - a.r)
    } else {
        0.0
    }
}

/// The front on the trial segment from a slipping knot to a sticking one, or back: where |trial| = r.
///
/// Its gain is 1 / (1 - n.m), large where the segment lies along the yield boundary.
#[inline]
fn front<const N: usize>(below: &Knot<N>, above: &Knot<N>) -> Knot<N> {
    let width = above.r - below.r;
    let m = (above.e - below.e) / width;
    // |trial|^2 - r^2 = a u^2 + 2 b u + c with u counted from the knot below.
    let a = m.norm_squared() - 1.0;
    let b = below.e.dot(&m) - below.r;
    let c = below.e.norm_squared() - below.r * below.r;
    // The root where the sign changes the right way, without cancellation; c has the sign of the knot below.
    let u = if below.slips() {
        let c = c.max(0.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        if b > 0.0 {
            -(b + root) / a
        } else if c > 0.0 {
            c / (root - b)
        } else {
            0.0
        }
    } else {
        let c = c.min(0.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        if b > 0.0 {
            -c / (b + root)
        } else {
            (root - b) / a
        }
    };
    // Rounding alone leads out of the segment, or to no number at all where it lies along the boundary.
    let u = if u.is_finite() {
        u.clamp(0.0, width)
    } else {
        width
    };
    let r = below.r + u;
    let trial = below.e + m * u;
    let direction = trial / trial.norm();
    let mut front = Knot::new(r, direction * r, Values::default(), above.above);
    let closing = 1.0 - direction.dot(&m);
    // Along the boundary the front moves at any speed; the number stays finite.
    front.gain = 1.0
        / if closing.abs() < 0.5 * ALONG_BOUNDARY {
            0.5 * ALONG_BOUNDARY
        } else {
            closing
        };
    front
}

/// A segment between two knots.
#[derive(Clone, Copy)]
struct Segment<const N: usize> {
    /// Secant of the backbone.
    secant: f64,
    /// Slope of the deflection.
    slope: Vector<N>,
}

impl<const N: usize> Segment<N> {
    #[inline]
    fn between(a: &Knot<N>, b: &Knot<N>) -> Self {
        let width = b.r - a.r;
        let inverse_width = 1.0 / width;
        Segment {
            // At r = 1 the slope may jump or be steep: there the secant itself is better.
            secant: if width < SHORT * b.r && b.r < 1.0 {
                0.5 * (a.values.slope + b.values.slope)
            } else {
                (b.values.f - a.values.f) * inverse_width
            },
            slope: (b.e - a.e) * inverse_width,
        }
    }

    /// Above r = 1 there is nothing.
    fn beyond() -> Self {
        Segment {
            secant: 0.0,
            slope: Vector::zeros(),
        }
    }
}

/// Traction, stored energy and consistent tangent, knot by knot.
///
/// With weights w = secant below - secant above, the traction is the sum of w e. A sticking knot moves with the
/// increment, a slipping one turns on its limit, a front also shifts along r.
struct Sums<const N: usize> {
    traction: Vector<N>,
    stored: f64,
    dissipated: f64,
    /// The part of the tangent that is a multiple of the identity, and the rest.
    stick: f64,
    turn: Matrix<N>,
    /// The same derivative applied to the deflections, which shrink when new pressure arrives unloaded.
    remembered: Vector<N>,
}

impl<const N: usize> Sums<N> {
    fn new() -> Self {
        Sums {
            traction: Vector::zeros(),
            stored: 0.0,
            dissipated: 0.0,
            stick: 0.0,
            turn: Matrix::zeros(),
            remembered: Vector::zeros(),
        }
    }

    /// Traction and stored energy of a segment, `times` over.
    #[inline]
    fn add_segment(&mut self, a: &Knot<N>, b: &Knot<N>, segment: &Segment<N>, times: f64) {
        self.traction += (b.e - a.e) * (segment.secant * times);
        let stored = segment.slope.dot(&(b.e * b.values.f - a.e * a.values.f))
            - segment.slope.norm_squared() * (b.values.integral - a.values.integral);
        self.stored += stored * times;
    }

    /// Adds what a knot between two segments gives to the tangent.
    #[inline]
    fn add(&mut self, knot: &Knot<N>, lower: &Segment<N>, upper: &Segment<N>) {
        let weight = lower.secant - upper.secant;
        if knot.slips() {
            // Knot 0 has no limit to turn on.
            if knot.r > 0.0 {
                self.add_slipping(&(knot.e / knot.r), weight * knot.gain);
            }
            return;
        }
        self.stick += weight;
        self.remembered += knot.e * weight;
        if knot.is_front() {
            self.add_shift(knot, lower, upper);
        }
    }

    /// A knot that slips in the direction n turns on its limit.
    #[inline]
    fn add_slipping(&mut self, n: &Vector<N>, weight: f64) {
        // In one direction there is nowhere to turn.
        if N > 1 {
            self.stick += weight;
            self.turn -= n * (n * weight).transpose();
        }
    }

    /// A front shifts along r.
    #[inline]
    fn add_shift(&mut self, front: &Knot<N>, lower: &Segment<N>, upper: &Segment<N>) {
        let slipping = if front.motion == Motion::FrontBelowStick {
            lower.secant
        } else {
            upper.secant
        };
        let shift = (lower.slope - upper.slope) * ((front.values.slope - slipping) * front.gain);
        let n = front.e / front.r;
        self.turn += shift * n.transpose();
        self.remembered += shift * n.dot(&front.e);
    }
}
