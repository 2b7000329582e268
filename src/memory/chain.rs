//! The floating knots that an increment leaves, and its fronts.

use super::grid::Grid;
use super::knot::{Front, Knot, weight};
use super::{Curve, MOST_KNOTS, NEGLIGIBLE, SAME};
use crate::backbone::Values;
use crate::state::MAX_BASE;
use arrayvec::ArrayVec;

/// The floating knots at the end of an increment, and its fronts.
pub(super) struct Chain<const N: usize> {
    pub(super) knots: ArrayVec<Knot<N>, MOST_KNOTS>,
    /// The fronts among them, in their order.
    pub(super) fronts: ArrayVec<Front<N>, MOST_FRONTS>,
    /// Fronts without a knot of their own.
    pub(super) strays: ArrayVec<Stray<N>, MOST_FRONTS>,
    /// One fell on knot 0.
    pub(super) at_origin: bool,
}

/// A front without a knot of its own.
pub(super) struct Stray<const N: usize> {
    pub(super) lost: Lost,
    /// The base knot it fell on, or lay below.
    pub(super) k: usize,
    pub(super) front: Front<N>,
}

/// How a front comes to have no knot.
#[derive(PartialEq)]
pub(super) enum Lost {
    /// It fell on a base knot, which stands for it.
    OnBase,
    /// It and the front before it fell on the same base knot, which just touches its limit: the knot still sticks.
    Touching,
    /// There was no room for it: what sticks beside it does not move with a front.
    Dropped,
}

/// One between any two knots.
const MOST_FRONTS: usize = 2 * MAX_BASE;

impl<const N: usize> Chain<N> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Chain {
            knots: ArrayVec::new(),
            fronts: ArrayVec::new(),
            strays: ArrayVec::new(),
            at_origin: false,
        }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.knots.clear();
        self.fronts.clear();
        self.strays.clear();
        self.at_origin = false;
    }

    /// Stores a front below base knot k; a base knot that it falls on becomes the front.
    #[inline(always)]
    pub(super) fn place(
        &mut self,
        front: &Front<N>,
        values: &Values,
        k: usize,
        grid: &Grid<N>,
        end: &Curve<N>,
    ) {
        let bottom = if N == 1 || k == 0 {
            0.0
        } else {
            grid.nodes[k - 1].r
        };
        let top = if N == 1 { 1.0 } else { grid.nodes[k].r };
        let last = match self.knots.last() {
            Some(last) if N == 1 || last.above as usize == k => last.r,
            _ => bottom,
        };
        if front.r - last >= SAME && top - front.r >= SAME {
            self.push(
                Knot::new(front.r, front.n * front.r, values, k, true),
                grid,
                end,
            );
            if N > 1 {
                self.fronts.push(*front);
            }
        } else {
            self.place_close(*front, *values, k, grid);
        }
    }

    /// Stores a front that has all but fallen on another knot.
    #[cold]
    fn place_close(&mut self, front: Front<N>, values: Values, k: usize, grid: &Grid<N>) {
        while let Some(last) = self.knots.last_mut()
            && last.above as usize == k
            && front.r - last.r < SAME
        {
            if last.is_front {
                // Two fronts in one place: what was between them just touches its limit and sticks, or is gone.
                last.is_front = false;
                self.fronts.pop();
                if !front.stick_above {
                    self.knots.pop();
                }
                return;
            }
            self.knots.pop();
        }
        let bottom = if k == 0 { 0.0 } else { grid.nodes[k - 1].r };
        if grid.nodes[k].r - front.r < SAME {
            self.stray(front, k);
        } else if front.r - bottom >= SAME {
            self.knots
                .push(Knot::new(front.r, front.n * front.r, &values, k, true));
            self.fronts.push(front);
        } else if k == 0 {
            self.at_origin = true;
        } else {
            self.stray(front, k - 1);
        }
    }

    /// A front falls on base knot k.
    fn stray(&mut self, front: Front<N>, k: usize) {
        let mut lost = Lost::OnBase;
        if let Some(last) = self.strays.last()
            && last.k == k
        {
            self.strays.pop();
            if !front.stick_above {
                return;
            }
            lost = Lost::Touching;
        }
        self.strays.push(Stray { lost, k, front });
    }

    /// Drops a knot for which there is no room.
    pub(super) fn drop(&mut self, index: usize) {
        let knot = self.knots.remove(index);
        let before = self.knots[..index].iter().filter(|knot| knot.is_front);
        if knot.is_front
            && let Some(front) = self.fronts.pop_at(before.count())
        {
            self.strays.push(Stray {
                lost: Lost::Dropped,
                k: knot.above as usize,
                front,
            });
        }
    }

    /// Stores a knot.
    #[inline(always)]
    pub(super) fn push(&mut self, knot: Knot<N>, grid: &Grid<N>, end: &Curve<N>) {
        self.drop_needless(&knot, knot.above as usize, grid, end);
        self.knots.push(knot);
    }

    /// Step 4: floating knots next to a front that do not matter go. `above`, below base knot k or that knot itself,
    /// comes next.
    #[inline(always)]
    pub(super) fn drop_needless(
        &mut self,
        above: &Knot<N>,
        k: usize,
        grid: &Grid<N>,
        end: &Curve<N>,
    ) {
        while let Some((last, before)) = self.knots.split_last()
            && !last.is_front
            && (N == 1 || last.above as usize == k)
        {
            let below = match before.last() {
                Some(below) if N == 1 || below.above as usize == k => *below,
                _ => end.settled(grid, k),
            };
            if !(below.is_front || above.is_front) {
                return;
            }
            let (loss, scale) = weight(&below, last, above);
            if last.r - below.r >= SAME && loss >= NEGLIGIBLE * scale {
                return;
            }
            self.knots.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backbone::{Backbone, PowerLaw};
    use crate::memory::Vector;

    /// Two fronts one after the other, below these base knots, on a grid of 0.25, 0.5, 0.75, 1; what lies between them sticks or
    /// slips.
    fn two_fronts(sticks_between: bool, places: [(f64, usize); 2]) -> Chain<2> {
        let backbone = PowerLaw::new(2.0);
        let grid = Grid::<2>::new(&backbone, 4);
        let mut end = Curve::new();
        assert!(end.set_base(&grid, &[[0.0; 2]; 4]));
        let mut chain = Chain::new();
        for ((r, k), stick_above) in places.into_iter().zip([sticks_between, !sticks_between]) {
            let front = Front {
                r,
                n: Vector::from([0.6, 0.8]),
                stick_above,
                gain: 1.0,
                inner: Vector::zeros(),
            };
            chain.place(&front, &backbone.at(r), k, &grid, &end);
        }
        chain
    }

    #[test]
    fn fronts_apart_stay_two() {
        for sticks_between in [true, false] {
            let chain = two_fronts(sticks_between, [(0.3, 1), (0.4, 1)]);
            assert!(chain.knots.iter().all(|knot| knot.is_front));
            assert_eq!((chain.knots.len(), chain.fronts.len()), (2, 2));
            assert!(chain.strays.is_empty());
        }
    }

    /// What stuck between two fronts in one place is gone with them; what slipped there touches its limit and sticks.
    #[test]
    fn two_fronts_in_one_place_are_none() {
        for sticks_between in [true, false] {
            let chain = two_fronts(sticks_between, [(0.3, 1), (0.3 + 0.1 * SAME, 1)]);
            assert!(chain.fronts.is_empty() && chain.strays.is_empty());
            let left: Vec<_> = chain
                .knots
                .iter()
                .map(|knot| (knot.r, knot.is_front))
                .collect();
            assert_eq!(
                left,
                if sticks_between {
                    vec![]
                } else {
                    vec![(0.3, false)]
                }
            );
        }
    }

    /// The same on a base knot, from below, from above, and from both sides.
    #[test]
    fn two_fronts_on_one_base_knot_are_none() {
        let (below, above) = ((0.5 - 0.1 * SAME, 1), (0.5 + 0.1 * SAME, 2));
        for places in [[below, below], [below, above], [above, above]] {
            for sticks_between in [true, false] {
                let chain = two_fronts(sticks_between, places);
                assert!(chain.knots.is_empty() && chain.fronts.is_empty());
                let touching: Vec<_> = chain
                    .strays
                    .iter()
                    .map(|stray| (stray.k, stray.lost == Lost::Touching))
                    .collect();
                assert_eq!(
                    touching,
                    if sticks_between {
                        vec![]
                    } else {
                        vec![(1, true)]
                    }
                );
            }
        }
    }
}
