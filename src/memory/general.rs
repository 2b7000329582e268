//! Any step: slip may begin and end in several places, and a full state must drop a reversal.

use super::grid::{Grid, outside};
use super::segment::{Knot, Motion, Segment, Sums, front, loss_secant};
use super::{ALONG_BOUNDARY, Curve, Increment, Matrix, NEGLIGIBLE, NO_SLIP, SAME, STICK, Vector};
use crate::backbone::Backbone;
use crate::state::{Contact, MAX_BASE, MAX_FLOATING};
use arrayvec::ArrayVec;

/// A memory curve on its way through an increment.
#[derive(Clone, Debug, Default)]
struct Chain<const N: usize> {
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
    inner: Vector<N>,
}

/// A segment that lies along the yield boundary, by the end that was taken to stick.
enum Along {
    Base(usize),
    Floating(usize),
}

impl<const N: usize> Curve<N> {
    /// [`Curve::advance`] for any step.
    #[inline(never)]
    pub(super) fn advance_any<B: Backbone>(
        &self,
        backbone: &B,
        grid: &Grid<N>,
        d: &Vector<N>,
        scale: f64,
        room: usize,
        next: &mut Curve<N>,
    ) -> Increment<N> {
        let mut end = Chain::default();
        let increment =
            Chain::start(backbone, grid, self, scale).advance(backbone, grid, d, room, &mut end);
        end.finish(next);
        increment
    }
}

impl<const N: usize> Chain<N> {
    /// The curve at the start, its deflections scaled by `scale`.
    fn start<B: Backbone>(backbone: &B, grid: &Grid<N>, curve: &Curve<N>, scale: f64) -> Self {
        let mut chain = Chain::default();
        for (_, e) in grid.nodes.iter().zip(&curve.base) {
            chain.base.push(Vector::from(*e) * scale);
        }
        for knot in &curve.floating {
            chain.occupied |= 1 << knot.above;
            chain.floating.push(Knot::new(
                knot.r,
                knot.e * scale,
                backbone.at(knot.r),
                knot.above,
            ));
        }
        chain
    }

    /// What is remembered of the curve at the end.
    fn finish(&self, curve: &mut Curve<N>) {
        curve.base.clear();
        curve.base.extend(self.base.iter().map(|e| (*e).into()));
        curve.floating.clear();
        for knot in &self.floating {
            curve.push_floating(knot.r, knot.e, knot.above);
        }
    }

    /// The step of a curve that was scaled; `next`, empty, gets the curve at the end. This curve is used up.
    fn advance<B: Backbone>(
        &mut self,
        backbone: &B,
        grid: &Grid<N>,
        d: &Vector<N>,
        room: usize,
        next: &mut Chain<N>,
    ) -> Increment<N> {
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
        grid: &Grid<N>,
        d: &Vector<N>,
        room: usize,
        next: &mut Chain<N>,
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
    fn contact(&self, grid: &Grid<N>, fronts: &Fronts) -> Contact {
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
    fn base_knot(&self, grid: &Grid<N>, k: usize) -> Knot<N> {
        let node = &grid.nodes[k];
        let mut knot = Knot::new(node.r, self.base[k], node.values, k);
        if self.base_slips(k) {
            knot.motion = Motion::Slipping;
        }
        knot
    }

    /// The knot at the lower end of the segment below base knot k; knot 0 has the deflection `origin`.
    #[inline]
    fn base_below(&self, grid: &Grid<N>, k: usize, origin: &Vector<N>) -> Knot<N> {
        match k.checked_sub(1) {
            Some(below) => self.base_knot(grid, below),
            None => Knot::origin(origin, grid),
        }
    }

    /// Adds `shift` to all deflections, and marks which knots are then outside their slip limit, or at it and on
    /// the way out.
    #[inline]
    fn mark(&mut self, grid: &Grid<N>, d: &Vector<N>, shift: &Vector<N>) {
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
    fn drop_least(&mut self, grid: &Grid<N>, origin: &Vector<N>, full: &mut bool) -> bool {
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
    fn weight(&self, grid: &Grid<N>, origin: &Vector<N>, index: usize) -> f64 {
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
        grid: &Grid<N>,
        d: &Vector<N>,
        next: &mut Chain<N>,
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
        grid: &Grid<N>,
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
            inner: front.inner,
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
        grid: &Grid<N>,
        d: &Vector<N>,
        on_base: &[BaseFront<N>],
        next: &mut Chain<N>,
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
                sums.add_slipping(&(e / node.r), node.weight * gain);
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
    fn drop_beside_fronts(&mut self, grid: &Grid<N>) {
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

    fn is_needless(&self, grid: &Grid<N>, index: usize) -> bool {
        self.floating.get(index).is_some_and(|knot| {
            let doubled = index > 0 && knot.r - self.floating[index - 1].r < SAME;
            knot.motion == Motion::Sticking
                && (doubled || self.weight(grid, &Vector::zeros(), index) < NEGLIGIBLE)
        })
    }

    /// Corrects what the base grid alone gives in those of its segments that the floating knots of `next` divide.
    #[inline]
    fn refine(&self, grid: &Grid<N>, next: &Chain<N>, sums: &mut Sums<N>) {
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
    fn add_base_front(&self, grid: &Grid<N>, front: &BaseFront<N>, sums: &mut Sums<N>) {
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
            inner: front.inner,
            ..here
        };
        sums.add_shift(&knot, &lower, &upper);
    }

    /// Secant of the backbone over the lowest segment.
    fn first_secant(&self, grid: &Grid<N>) -> f64 {
        let origin = Knot::origin(&Vector::zeros(), grid);
        match self.floating.first() {
            Some(knot) if knot.above == 0 => Segment::between(&origin, knot).secant,
            _ => grid.nodes[0].secant,
        }
    }
}
