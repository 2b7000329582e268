//! A full state array: which floating knot must go.

use super::chain::Chain;
use super::grid::Grid;
use super::knot::{Knot, weight};
use super::step::Step;
use super::{Curve, NEGLIGIBLE, Vector, is_outside};
use crate::backbone::Backbone;
use crate::state::MAX_FLOATING;
use arrayvec::ArrayVec;

impl<const N: usize, B: Backbone> Step<'_, N, B> {
    /// Makes room for a turn of the slip, whatever the length of this increment: a long one that would wipe out a
    /// knot and a short one that would not have to go on from the same curve.
    #[cold]
    pub(super) fn make_room(&mut self, room: usize, full: &mut bool) {
        loop {
            let base = self.grid.nodes.iter().zip(self.start.base()).enumerate();
            self.base_slips = base.fold(0, |bits, (k, (node, e))| {
                bits | u64::from(is_outside(node.r, &Vector::from(*e), self.d)) << k
            });
            self.mark_floating(&Vector::zeros());
            if self.needed() <= room || !self.drop_least(full) {
                return;
            }
        }
    }

    /// How many floating knots stay, and how many fronts come.
    fn needed(&self) -> usize {
        let mut floating = self.start.floating.iter().enumerate().peekable();
        let (mut needed, mut slips) = (0, true);
        for k in 0..self.grid.nodes.len() {
            while let Some((index, _)) = floating.next_if(|(_, knot)| knot.above == k) {
                let here = self.floating_slips(index);
                needed += usize::from(!here) + usize::from(here != slips);
                slips = here;
            }
            needed += usize::from(self.slips(k) != slips);
            slips = self.slips(k);
        }
        needed
    }

    /// Drops the floating knot that matters least among those that stick; false if there is none.
    ///
    /// On the curve before the fronts stand on it: the choice then does not depend on how far the increment goes. A
    /// branch in one step and in a thousand drop the same reversal and travel on the same curve.
    #[cold]
    pub(super) fn drop_least(&mut self, full: &mut bool) -> bool {
        let floating = self.start.floating.iter();
        let knots: ArrayVec<_, MAX_FLOATING> = floating
            .map(|knot| Knot::new(knot.r, knot.e, &self.backbone.at(knot.r), knot.above, false))
            .collect();
        let sticks = |index: usize| !self.floating_slips(index);
        let least = self.start.least(&knots, self.grid, sticks);
        if let Some((index, weight)) = least {
            self.start.floating.remove(index);
            *full |= weight >= NEGLIGIBLE;
        }
        least.is_some()
    }
}

impl<const N: usize> Chain<N> {
    /// Drops the knots that matter least until no more than `room` are left.
    #[cold]
    pub(super) fn drop_to(&mut self, room: usize, grid: &Grid<N>, end: &Curve<N>, full: &mut bool) {
        while self.knots.len() > room
            && let Some((index, weight)) = end.least(&self.knots, grid, |_| true)
        {
            self.drop(index);
            *full |= weight >= NEGLIGIBLE;
        }
    }
}

impl<const N: usize> Curve<N> {
    /// The floating knot (its index) whose removal changes the traction least, among those that may go, and that
    /// change.
    fn least(
        &self,
        floating: &[Knot<N>],
        grid: &Grid<N>,
        may_go: impl Fn(usize) -> bool,
    ) -> Option<(usize, f64)> {
        let weights = (0..floating.len())
            .filter(|index| may_go(*index))
            .map(|index| {
                let (below, above) = self.neighbours(floating, index, grid);
                let (loss, scale) = weight(&below, &floating[index], &above);
                (index, loss / scale)
            });
        weights.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The knots next to a floating one: `floating` lie between the base knots of this curve.
    fn neighbours(&self, floating: &[Knot<N>], index: usize, grid: &Grid<N>) -> (Knot<N>, Knot<N>) {
        let k = floating[index].above as usize;
        let beside =
            |other: Option<&Knot<N>>| other.filter(|other| other.above as usize == k).copied();
        let below = beside(index.checked_sub(1).map(|before| &floating[before]));
        let above = beside(floating.get(index + 1));
        (
            below.unwrap_or_else(|| self.settled(grid, k)),
            above.unwrap_or_else(|| self.settled(grid, k + 1)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backbone::PowerLaw;

    /// A knot that slips is gone at the end of the step anyway: dropping it makes no room, however little it matters.
    #[test]
    fn only_a_knot_that_sticks_is_dropped() {
        let backbone = PowerLaw::new(2.5);
        let grid = Grid::<1>::new(&backbone, 1);
        let mut curve = Curve::new();
        assert!(curve.set_base(&grid, &[[0.0]]));
        // The first lies on the line between its neighbours: it does not matter at all.
        for (r, e) in [(0.3, 0.1), (0.6, 0.2)] {
            curve.push_floating(r, Vector::from([e]), 0);
        }
        let mut step = Step {
            backbone: &backbone,
            grid: &grid,
            start: &mut curve,
            d: &Vector::from([0.1]),
            moves: true,
            base_slips: 0,
            floating_slips: 0b01,
        };
        let mut full = false;
        assert!(step.drop_least(&mut full) && full);
        assert_eq!(step.start.floating.len(), 1);
        assert_eq!(step.start.floating[0].r, 0.3);
        assert!(!step.drop_least(&mut full), "none that sticks is left");
        assert_eq!(step.start.floating.len(), 1);
    }
}
