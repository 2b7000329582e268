//! An increment of slip: the trial curve, the fronts on it, and what the curve at the end gives.
//!
//! The base grid is moved as a whole and gives sums with fixed weights. Only the segments of it in which slip ends or
//! begins, or floating knots lie, are looked at knot by knot, and put right in the sums: one or two in nearly all steps.

use super::chain::{Chain, Lost, Stray};
use super::grid::Grid;
use super::knot::{Front, Knot, Segment, Trial, front};
use super::{Curve, Increment, Matrix, STICK, Vector, is_outside, length, onto_limit};
use crate::backbone::Backbone;
use crate::state::Contact;

/// A step: the curve at its start (already scaled), and how it moves.
pub(super) struct Step<'a, const N: usize, B> {
    pub(super) backbone: &'a B,
    pub(super) grid: &'a Grid<N>,
    pub(super) start: &'a mut Curve<N>,
    pub(super) d: &'a Vector<N>,
    /// Something slips: at least the elements without a limit.
    pub(super) moves: bool,
    /// Bit k: base knot k slips.
    pub(super) base_slips: u64,
    /// Bit i: floating knot i slips.
    pub(super) floating_slips: u64,
}

/// What the way along the trial curve gives.
#[derive(Default)]
struct Passed {
    /// Slope of the backbone at the highest front below sticking elements.
    slope: f64,
    /// Energy dissipated in the segments that fronts and floating knots divide, beyond what the base grid counts.
    dissipated: f64,
}

/// The sticking end of a segment that lies along the yield boundary.
enum Along {
    /// Base knot, from 0.
    Base(usize),
    /// Floating knot, from 0.
    Floating(usize),
}

/// Traction, stored energy and tangent.
struct Sums<const N: usize> {
    traction: Vector<N>,
    stored: f64,
    tangent: Matrix<N>,
    /// Weight times e of the knots that slip, beyond what the base grid alone gives.
    slipping: Vector<N>,
    /// How much the fronts' shift along r would add if all deflections grew.
    shift: Vector<N>,
}

impl<const N: usize> Sums<N> {
    #[inline(always)]
    fn add(&mut self, a: &Knot<N>, b: &Knot<N>, segment: &Segment<N>, times: f64) {
        self.traction += (b.e - a.e) * (segment.secant * times);
        let stored = segment.slope.dot(&(b.e * b.f - a.e * a.f))
            - segment.slope.norm_squared() * (b.integral - a.integral);
        self.stored += stored * times;
    }

    /// A front where the backbone has this slope, with the segment on its slipping side.
    ///
    /// By parts, the weights of all that sticks between two fronts add up to the secants beside them.
    #[inline(always)]
    fn add_front(&mut self, front: &Front<N>, slope: f64, slipping: &Segment<N>) {
        let slowing = slope - slipping.secant;
        let (sign, bend) = if front.stick_above {
            (1.0, slipping.slope - front.inner)
        } else {
            (-1.0, front.inner - slipping.slope)
        };
        // In one direction how fast the front moves and how far the slopes differ cancel.
        let shift = if N == 1 {
            front.n * slowing
        } else {
            bend * (slowing * front.gain)
        };
        self.tangent += Matrix::identity() * (sign * slipping.secant) + shift * front.n.transpose();
        self.shift += shift * front.r;
    }

    /// A slipping knot of the base grid whose weight changes.
    #[inline(always)]
    fn add_slipping(&mut self, e: &Vector<N>, turn: &Matrix<N>, weight: f64) {
        self.slipping += e * weight;
        self.tangent += turn * weight;
    }
}

impl<const N: usize, B: Backbone> Step<'_, N, B> {
    /// Makes the step; `end`, empty, gets the curve at its end, with at most `room` floating knots.
    #[inline(always)]
    pub(super) fn run(mut self, scaled: bool, room: usize, end: &mut Curve<N>) -> Increment<N> {
        let mut full = false;
        if self.moves && self.start.floating.len() >= room {
            self.make_room(room, &mut full);
        }
        let mut moved = self.start.move_base(self.grid, self.d, end);
        self.base_slips = moved.slips;
        self.mark_floating(self.d);
        let mut chain = Chain::new();
        let passed = loop {
            match self.place_fronts(&mut chain, end) {
                // Rounding must not cut it: it slips as a whole.
                Err(sticking_end) => moved.turn += self.yield_whole(sticking_end, end),
                Ok(passed) => {
                    if chain.knots.len() <= room {
                        break passed;
                    }
                    if !self.drop_least(&mut full) {
                        chain.drop_to(room, self.grid, end, &mut full);
                        break passed;
                    }
                    self.mark_floating(self.d);
                }
            }
        };
        let contact = self.moves.then(|| self.contact(passed.slope));
        for stray in &chain.strays {
            moved.turn += self.stand_on_base(stray, end);
        }

        let mut sums = Sums {
            traction: Vector::zeros(),
            stored: 0.0,
            tangent: moved.turn,
            slipping: Vector::zeros(),
            shift: Vector::zeros(),
        };
        // In one direction the floating knots divide the only segment of the base grid.
        if N > 1 || chain.knots.is_empty() {
            (sums.traction, sums.stored) = end.base_sums(self.grid);
        }
        self.add_chain(&chain, end, &mut sums);
        for stray in &chain.strays {
            sums = self.add_stray(stray, &chain.knots, end, sums);
        }
        // Where nothing slips, not even the elements without a limit, the front stands on knot 0.
        if chain.at_origin || !self.moves {
            sums.tangent += Matrix::identity() * self.grid.initial_slope;
        }
        for knot in &chain.knots {
            end.push_floating(knot.r, knot.e, knot.above as usize);
        }
        Increment {
            traction: sums.traction,
            tangent: sums.tangent,
            shrinkage: if scaled {
                let remembered = sums.traction - sums.slipping - self.slipping(end) + sums.shift;
                remembered - sums.tangent * self.d
            } else {
                Vector::zeros()
            },
            stored: sums.stored,
            dissipated: moved.dissipated + passed.dissipated,
            contact,
            full,
        }
    }

    /// Where the contact stands after a slip.
    #[inline(always)]
    fn contact(&self, front_slope: f64) -> Contact {
        if self.slips(self.count() - 1) {
            Contact::GrossSlip
        } else if front_slope >= STICK * self.grid.initial_slope {
            Contact::Stick
        } else {
            Contact::MicroSlip
        }
    }

    /// How many base knots there are: in one direction r = 1 is enough.
    #[inline(always)]
    fn count(&self) -> usize {
        if N == 1 { 1 } else { self.grid.nodes.len() }
    }

    /// Marks the floating knots that slip when all have moved by `shift`; the base knots have been marked.
    #[inline(always)]
    pub(super) fn mark_floating(&mut self, shift: &Vector<N>) {
        self.floating_slips = 0;
        for (index, knot) in self.start.floating.iter().enumerate() {
            let slips = is_outside(knot.r, &(knot.e + shift), self.d);
            self.floating_slips |= u64::from(slips) << index;
        }
        self.settle_order();
    }

    /// In one direction everything below the largest outside knot is outside.
    #[inline(always)]
    fn settle_order(&mut self) {
        if N == 1 {
            self.floating_slips = if self.base_slips == 1 {
                u64::MAX
            } else {
                u64::MAX
                    .checked_shr(self.floating_slips.leading_zeros())
                    .unwrap_or(0)
            };
        }
    }

    /// The segments of the base grid in which slip ends or begins, or floating knots lie, by the knot above.
    #[inline(always)]
    fn divided(&self) -> u64 {
        if N == 1 {
            // Walked in any case.
            return 1;
        }
        let all = u64::MAX >> (u64::BITS as usize - self.count());
        let changes = self.base_slips ^ (self.base_slips << 1 | u64::from(self.moves));
        self.start
            .floating
            .iter()
            .fold(changes & all, |bits, knot| bits | 1 << knot.above)
    }

    /// Base knot number `count` on the trial curve, 0 for the origin. That has no limit and no deflection: whenever
    /// something slips, it does.
    #[inline(always)]
    fn trial(&self, count: usize) -> Trial<N> {
        match count.checked_sub(1) {
            Some(k) => {
                let node = &self.grid.nodes[k];
                let e = Vector::from(self.start.base[1 + k]) + self.d;
                Trial::new(node.r, e, node.values.loss, self.slips(k))
            }
            None => Trial::new(0.0, *self.d, 0.0, self.moves),
        }
    }

    /// Step 2: fronts where slipping ends or begins; `chain` gets them and the floating knots that stick. Also the
    /// energy dissipated in the segments that are not plain segments of the base grid.
    #[inline(always)]
    fn place_fronts(&self, chain: &mut Chain<N>, end: &Curve<N>) -> Result<Passed, Along> {
        chain.clear();
        let mut passed = Passed::default();
        let floating = &self.start.floating[..];
        let mut index = 0;
        let mut divided = self.divided();
        if divided & 1 == 0 {
            passed.dissipated += length(self.d) * self.grid.nodes[0].loss_secant;
        }
        while divided != 0 {
            let k = divided.trailing_zeros() as usize;
            divided &= divided - 1;
            let top = self.trial(k + 1);
            let mut below = self.trial(k);
            let counted = if k == 0 { 0.0 } else { below.excess };
            passed.dissipated -= (counted - top.excess) * self.grid.nodes[k].loss_secant;
            while let Some(knot) = floating.get(index)
                && (N == 1 || knot.above == k)
            {
                let values = self.backbone.at(knot.r);
                let e = knot.e + self.d;
                let slips = self.floating_slips(index);
                let here = Trial::new(knot.r, e, values.loss, slips);
                if below.slips != slips {
                    let Some(front) = self.place_front(&below, &here, k, chain, end, &mut passed)
                    else {
                        return Err(self.along(below.slips, Along::Floating(index), index, k));
                    };
                    below = front;
                }
                if slips {
                    // It has nothing left to remember.
                    passed.dissipated += below.dissipated(&here);
                } else {
                    chain.push(Knot::new(knot.r, e, &values, k, false), self.grid, end);
                }
                below = here;
                index += 1;
            }
            if below.slips != top.slips {
                let Some(front) = self.place_front(&below, &top, k, chain, end, &mut passed) else {
                    return Err(self.along(below.slips, Along::Base(k), index, k));
                };
                below = front;
            }
            if top.slips {
                passed.dissipated += below.dissipated(&top);
            }
            chain.drop_needless(&end.settled(self.grid, k + 1), k, self.grid, end);
        }
        Ok(passed)
    }

    /// Places the front between a slipping knot of the trial curve and a sticking one below base knot k, and gives it;
    /// None where the segment lies along the yield boundary.
    #[inline(always)]
    fn place_front(
        &self,
        below: &Trial<N>,
        above: &Trial<N>,
        k: usize,
        chain: &mut Chain<N>,
        end: &Curve<N>,
        passed: &mut Passed,
    ) -> Option<Trial<N>> {
        let front = front(below, above, self.d)?;
        let values = self.backbone.at(front.r);
        let trial = Trial {
            r: front.r,
            loss: values.loss,
            excess: 0.0,
            ..*below
        };
        if front.stick_above {
            passed.slope = values.slope;
            passed.dissipated += below.dissipated(&trial);
        }
        chain.place(&front, &values, k, self.grid, end);
        Some(trial)
    }

    #[cold]
    fn along(&self, slips_below: bool, above: Along, index: usize, k: usize) -> Along {
        if slips_below {
            above
        } else if index > 0 && self.start.floating[index - 1].above == k {
            Along::Floating(index - 1)
        } else {
            Along::Base(k - 1)
        }
    }

    /// Corrects what the base grid alone gives in those of its segments that the knots of the chain divide, and adds
    /// the fronts.
    #[inline(always)]
    fn add_chain(&self, chain: &Chain<N>, end: &Curve<N>, sums: &mut Sums<N>) {
        let (mut knots, mut fronts) = (&chain.knots[..], &chain.fronts[..]);
        while let Some(first) = knots.first() {
            let k = if N == 1 { 0 } else { first.above as usize };
            let bottom = end.settled(self.grid, k);
            let top = end.settled(self.grid, k + 1);
            let node = &self.grid.nodes[k];
            let chord = Segment {
                secant: node.secant,
                slope: (top.e - bottom.e) * node.inverse_width,
            };
            if N > 1 {
                sums.add(&bottom, &top, &chord, -1.0);
            }
            let mut below = bottom;
            // A front that sticks below takes the segment above it.
            let mut waiting: Option<(&Front<N>, f64)> = None;
            while let Some((here, rest)) = knots.split_first()
                && (N == 1 || here.above as usize == k)
            {
                let segment = Segment::between(&below, here);
                sums.add(&below, here, &segment, 1.0);
                if let Some((front, slope)) = waiting.take() {
                    sums.add_front(front, slope, &segment);
                }
                if N > 1 && below.r == bottom.r && k > 0 && self.slips(k - 1) {
                    sums.add_slipping(
                        &bottom.e,
                        &self.turn(k - 1, &bottom.e),
                        chord.secant - segment.secant,
                    );
                }
                if N == 1 && here.is_front {
                    // The only one. How fast it moves and how far the slopes differ cancel.
                    sums.tangent += Matrix::identity() * here.slope;
                    sums.shift += here.e * (here.slope - segment.secant);
                } else if here.is_front
                    && let Some((front, others)) = fronts.split_first()
                {
                    fronts = others;
                    if front.stick_above {
                        sums.add_front(front, here.slope, &segment);
                    } else {
                        waiting = Some((front, here.slope));
                    }
                }
                below = *here;
                knots = rest;
            }
            let segment = Segment::between(&below, &top);
            sums.add(&below, &top, &segment, 1.0);
            if let Some((front, slope)) = waiting {
                sums.add_front(front, slope, &segment);
            }
            if N > 1 && self.slips(k) {
                sums.add_slipping(&top.e, &self.turn(k, &top.e), segment.secant - chord.secant);
            }
        }
    }

    /// Whether base knot k slips.
    #[inline(always)]
    pub(super) fn slips(&self, k: usize) -> bool {
        self.base_slips >> k & 1 == 1
    }

    /// Whether floating knot `index` slips.
    #[inline(always)]
    pub(super) fn floating_slips(&self, index: usize) -> bool {
        self.floating_slips >> index & 1 == 1
    }

    /// How base knot k, brought back to e, turns on its limit: r / |trial| (I - n n^T), where r n = e.
    #[inline(always)]
    fn turn(&self, k: usize, e: &Vector<N>) -> Matrix<N> {
        let trial = Vector::from(self.start.base[1 + k]) + self.d;
        (Matrix::identity() * e.norm_squared() - e * e.transpose()) / e.dot(&trial)
    }

    /// Weight times e of the base knots that slip, with the weights of the base grid alone.
    fn slipping(&self, end: &Curve<N>) -> Vector<N> {
        let knots = self.grid.nodes.iter().zip(end.base()).enumerate();
        let slipping = knots.filter(|(k, _)| self.slips(*k));
        slipping
            .map(|(_, (node, e))| Vector::from(*e) * node.weight)
            .sum()
    }

    /// A segment along the yield boundary slips as a whole; gives what that adds to the part of the tangent that turns.
    #[cold]
    fn yield_whole(&mut self, sticking_end: Along, end: &mut Curve<N>) -> Matrix<N> {
        let mut turn = Matrix::zeros();
        match sticking_end {
            Along::Floating(index) => self.floating_slips |= 1 << index,
            Along::Base(k) => {
                self.base_slips |= 1 << k;
                let node = &self.grid.nodes[k];
                let e = onto_limit(node.r, &end.base[1 + k].into());
                turn = self.turn(k, &e) * node.weight;
                end.base[1 + k] = e.into();
            }
        }
        self.settle_order();
        turn
    }

    /// A base knot on which a front fell moves with it; gives what that adds to the part of the tangent that turns.
    #[cold]
    fn stand_on_base(&mut self, stray: &Stray<N>, end: &mut Curve<N>) -> Matrix<N> {
        if stray.lost == Lost::Dropped {
            return Matrix::zeros();
        }
        let k = stray.k;
        let node = &self.grid.nodes[k];
        let before = std::mem::replace(&mut end.base[1 + k], (stray.front.n * node.r).into());
        if !self.slips(k) {
            return Matrix::zeros();
        }
        self.base_slips &= !(1 << k);
        self.turn(k, &before.into()) * -node.weight
    }

    /// Adds to the tangent what a front gives that has no knot.
    #[cold]
    fn add_stray(
        &self,
        stray: &Stray<N>,
        knots: &[Knot<N>],
        end: &Curve<N>,
        mut sums: Sums<N>,
    ) -> Sums<N> {
        let Stray { lost, k, front } = stray;
        match lost {
            Lost::Touching => {}
            Lost::Dropped => {
                let secant = self.segment(*k, front.r, knots, end).secant;
                let secant = if front.stick_above { secant } else { -secant };
                sums.tangent += Matrix::identity() * secant;
            }
            Lost::OnBase => {
                let here = end.settled(self.grid, k + 1);
                let segment = if front.stick_above {
                    self.segment(*k, here.r, knots, end)
                } else if k + 1 < self.count() {
                    self.segment(k + 1, here.r, knots, end)
                } else {
                    Segment::beyond()
                };
                sums.add_front(front, here.slope, &segment);
            }
        }
        sums
    }

    /// The segment below base knot k, or that part of it that holds r.
    fn segment(&self, k: usize, r: f64, knots: &[Knot<N>], end: &Curve<N>) -> Segment<N> {
        let mut inside = knots.iter().filter(|knot| knot.above as usize == k);
        let below = inside.clone().rfind(|knot| knot.r < r).copied();
        let above = inside.find(|knot| knot.r > r).copied();
        Segment::between(
            &below.unwrap_or_else(|| end.settled(self.grid, k)),
            &above.unwrap_or_else(|| end.settled(self.grid, k + 1)),
        )
    }
}
