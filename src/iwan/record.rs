//! Measured data cut into branches: from one reversal of the displacement to the next.
//!
//! A steady loop gives branches that all start at the ends of the loop. Where the amplitude changes, the rule of
//! return-point memory tells what every branch starts from: a stack of open reversals, of which a pair is closed when
//! the displacement passes the older one, and under all of them the curve of first loading.

// Rows of a branch are a list of ranges, often of one.
#![expect(clippy::single_range_in_vec_init)]

use super::Direction;
use super::least_squares::two_lines;
use crate::error::{Error, Kind};
use nalgebra::{Matrix3, Vector3};
use std::ops::{Range, RangeInclusive};

/// A change of direction counts as a reversal when the displacement comes back by this part of its whole range;
/// less is noise, or a nested loop.
const REVERSAL: f64 = 0.2;
/// Where amplitudes differ it is this part, or so many standard deviations of the noise of the displacement.
const SMALL_REVERSAL: f64 = 0.02;
const NO_NOISE: f64 = 12.0;
/// A branch this long, as a part of the whole range, belongs to the loop; shorter ones are first loading or smaller
/// loops.
const COMPLETE: f64 = 0.9;
/// What starts or ends this close, as a part of the whole range, starts or ends at the same place.
const SAME: f64 = 0.02;
/// A record that starts this close to the middle of displacement and force, as a part of their ranges, starts at rest.
const AT_REST: f64 = 0.05;
/// Samples this close to a turn, as a part of the whole range, tell where it is, if there are so many.
const NEAR: f64 = 0.05;
const FEWEST_NEAR: usize = 8;
/// At most so many of them are used, and so many places tried for a corner between them.
const MOST_NEAR: usize = 2000;
const CORNERS: usize = 100;
/// A curve is good enough when the samples are no farther from it than so many times their noise, or than this part of
/// the range.
const MISFIT: f64 = 2.0;
const GOOD: f64 = 2e-4;
/// The median of normal noise, without its sign, in standard deviations.
const MEDIAN: f64 = 0.6745;
/// At most so many second differences tell the noise of a record.
const SECOND_DIFFERENCES: usize = 20_000;
/// Forces this close, as a part of their whole range, close the loop.
const CLOSED: f64 = 0.05;
/// Sums of the squares of such numbers neither overflow nor vanish.
const SQUARABLE: RangeInclusive<f64> = 1e-100..=1e100;
/// Five unknowns (the parameters and the mean force) need some points on each side.
const MIN_POINTS: usize = 8;

/// A stretch of data on one curve: friction there is that of the node, plus a multiple of the curve of first loading.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Which way it goes.
    pub direction: Direction,
    /// Displacement where the curve starts: at a reversal, or at rest.
    pub start: f64,
    /// Half the length of the half cycle it belongs to.
    pub amplitude: f64,
    /// First loading, of which distances count whole and once; else they count half and twice (Masing).
    pub virgin: bool,
    /// Index into [`Record::nodes`] of the friction at the start; None at rest.
    pub node: Option<usize>,
    /// The rows, in their order.
    pub rows: Vec<Range<usize>>,
}

impl Branch {
    /// The points, as indices into the record.
    pub fn points(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.rows.iter().cloned().flatten()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.rows.iter().map(ExactSizeIterator::len).sum()
    }

    /// Factor of the curve of first loading H, with the sign, and of the distance from the start in its argument.
    pub fn masing(&self) -> (f64, f64) {
        let sign = self.direction.sign();
        if self.virgin {
            (sign, 1.0)
        } else {
            (2.0 * sign, 0.5)
        }
    }
}

/// Friction at a reversal: that of the parent (0 without one) plus `weight` times the curve of first loading at
/// `distance`.
#[derive(Clone, Debug)]
pub struct Node {
    /// The reversal that the branch to this one started from; its index is smaller.
    pub parent: Option<usize>,
    /// Of the curve of first loading.
    pub weight: f64,
    /// Its argument.
    pub distance: f64,
}

/// From one reversal to the next.
#[derive(Clone, Debug)]
pub struct HalfCycle {
    /// Which way it goes.
    pub direction: Direction,
    /// Half the distance between the reversals.
    pub amplitude: f64,
    /// The rows, in their order.
    pub rows: Vec<Range<usize>>,
}

impl HalfCycle {
    fn points(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows.iter().cloned().flatten()
    }
}

/// Where the first reversal came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// From rest in the middle of the record.
    Centre,
    /// From rest at the first sample; first loading is part of the data.
    Start,
}

/// A displacement-force record: one or more cycles about any centre, in the order of time.
#[derive(Clone, Debug)]
pub struct Record {
    /// Displacements.
    pub displacement: Vec<f64>,
    /// Forces.
    pub force: Vec<f64>,
    /// The branches that are fitted.
    pub branches: Vec<Branch>,
    /// Friction at the reversals.
    pub nodes: Vec<Node>,
    /// From reversal to reversal; of a steady loop the same as the branches.
    pub half_cycles: Vec<HalfCycle>,
    /// Half the distance between the reversals: mean of all branches of a steady loop, else that of the longest half
    /// cycle.
    pub amplitude: f64,
    /// The middle between these reversals.
    pub centre: f64,
    /// How much the displacement scatters where it turns; 0 where it is monotonic on both sides.
    pub scatter: f64,
    /// Where the amplitudes differ: what came before the first reversal. None for a steady loop.
    pub origin: Option<Origin>,
    /// The rows that were chosen.
    chosen: Option<Range<usize>>,
}

/// What the displacements alone tell.
struct Cut {
    branches: Vec<Branch>,
    nodes: Vec<Node>,
    half_cycles: Vec<HalfCycle>,
    scatter: f64,
    amplitude: f64,
    centre: f64,
    origin: Option<Origin>,
}

impl Record {
    /// Finds the reversals and the branches between them.
    ///
    /// # Errors
    /// [`Kind::BadInput`]: lengths that differ, numbers that are not finite, no loop in the data (no branch in one of
    /// the directions, or fewer than eight points on it), no memory for a copy.
    pub fn new(displacement: &[f64], force: &[f64]) -> Result<Self, Error> {
        Self::from_vectors(copy(displacement)?, copy(force)?)
    }

    /// The same of data that need not be copied.
    ///
    /// # Errors
    /// As [`Record::new`].
    pub fn from_vectors(displacement: Vec<f64>, force: Vec<f64>) -> Result<Self, Error> {
        check(&displacement, &force)?;
        Self::build(displacement, force, None, None)
    }

    fn build(
        displacement: Vec<f64>,
        force: Vec<f64>,
        origin: Option<Origin>,
        chosen: Option<Range<usize>>,
    ) -> Result<Self, Error> {
        let cut = cut(&displacement, &force, origin);
        let mut record = Record {
            displacement,
            force,
            branches: cut.branches,
            nodes: cut.nodes,
            half_cycles: cut.half_cycles,
            amplitude: cut.amplitude,
            centre: cut.centre,
            scatter: cut.scatter,
            origin: cut.origin,
            chosen,
        };
        record.choose();
        record.check_branches()?;
        Ok(record)
    }

    /// The same with the other displacements, whose reversals are found anew.
    ///
    /// # Errors
    /// As [`Record::new`].
    pub fn with_displacement(&self, displacement: Vec<f64>) -> Result<Self, Error> {
        Self::build(
            displacement,
            copy(&self.force)?,
            self.origin,
            self.chosen.clone(),
        )
    }

    /// The same with the displacement `late` samples earlier: what is recorded at sample i + late belongs to the force
    /// at i. A fraction is interpolated; rows that lose their partner are not fitted.
    ///
    /// # Errors
    /// As [`Record::new`].
    pub fn without_lag(&self, late: f64) -> Result<Self, Error> {
        let count = self.displacement.len();
        let whole = late.floor();
        let fraction = late - whole;
        let whole = whole as isize;
        let x = |index: isize| self.displacement[index.clamp(0, count as isize - 1) as usize];
        let mut displacement = room(count)?;
        let mut force = room(count)?;
        for at in 0..count as isize {
            // A cubic through four samples, with the slopes of central differences.
            let [a, b, c, d] = [-1, 0, 1, 2].map(|k| x(at + k));
            let slope = [0.5 * (c - a), 0.5 * (d - b)];
            let t = fraction;
            let bend = 2.0 * (b - c) + slope[0] + slope[1];
            let curve = -3.0 * (b - c) - 2.0 * slope[0] - slope[1];
            displacement.push(((bend * t + curve) * t + slope[0]) * t + b);
            force.push(self.force[(at - whole).clamp(0, count as isize - 1) as usize]);
        }
        let moved = |index: usize| (index as isize + whole).clamp(0, count as isize) as usize;
        let known = self.chosen.clone().unwrap_or(0..count);
        let last = moved(known.end).min(if fraction > 0.0 { count - 1 } else { count });
        let chosen = moved(known.start).min(last)..last;
        Self::build(displacement, force, self.origin, Some(chosen))
    }

    /// Every `stride`-th row up to row `end`, for what need not be known to the last digit.
    pub(super) fn thinned(&self, stride: usize, end: usize) -> Result<Self, Error> {
        let thin = |values: &[f64]| values[..end].iter().step_by(stride).copied().collect();
        let chosen = self.chosen.clone();
        let chosen = chosen.map(|c| c.start.div_ceil(stride)..c.end.min(end).div_ceil(stride));
        Self::build(
            thin(&self.displacement),
            thin(&self.force),
            self.origin,
            chosen,
        )
    }

    /// The same with another past, where the amplitudes differ; None for a steady loop.
    pub fn with_origin(&self, origin: Origin) -> Option<Self> {
        self.origin?;
        let data = (copy(&self.displacement).ok()?, copy(&self.force).ok()?);
        Self::build(data.0, data.1, Some(origin), self.chosen.clone()).ok()
    }

    /// The same with other forces, for resampling.
    pub fn with_force(&self, force: Vec<f64>) -> Self {
        Record {
            force,
            ..self.clone()
        }
    }

    /// Whole cycles, counted from the first reversal, as rows.
    pub fn cycles(&self) -> Vec<Range<usize>> {
        let pairs = self.half_cycles.chunks_exact(2);
        pairs
            .map(|pair| {
                let rows = || pair.iter().flat_map(|half| &half.rows);
                let first = rows().map(|r| r.start).min().unwrap_or(0);
                first..rows().map(|r| r.end).max().unwrap_or(first)
            })
            .collect()
    }

    /// Only these rows are fitted; the others still tell what went before.
    ///
    /// # Errors
    /// [`Kind::BadInput`] when fewer than eight points are left in a direction.
    pub fn with_rows(mut self, rows: Range<usize>) -> Result<Self, Error> {
        self.chosen = Some(rows);
        self.choose();
        self.check_branches()?;
        Ok(self)
    }

    fn choose(&mut self) {
        let Some(chosen) = self.chosen.clone() else {
            return;
        };
        for branch in &mut self.branches {
            for rows in &mut branch.rows {
                rows.start = rows.start.clamp(chosen.start, chosen.end);
                rows.end = rows.end.clamp(rows.start, chosen.end);
            }
            branch.rows.retain(|rows| !rows.is_empty());
        }
        self.branches.retain(|branch| !branch.rows.is_empty());
    }

    fn check_branches(&self) -> Result<(), Error> {
        let counts = [Direction::Loading, Direction::Unloading].map(|direction| {
            let ours = self.branches.iter().filter(|b| b.direction == direction);
            ours.map(Branch::count).sum::<usize>()
        });
        if counts.iter().any(|count| *count < MIN_POINTS) {
            let half_cycles = self.half_cycles.len();
            return Err(bad(format!(
                "n = {}: no loop: {half_cycles} whole half cycles, with {} points while the displacement grows and {} while it \
                 falls; at least {MIN_POINTS} are needed in each direction, between two reversals",
                self.displacement.len(),
                counts[0],
                counts[1]
            )));
        }
        // What loads lies above what unloads.
        if let Some(([loading, unloading, _], ..)) = two_lines(self.sides())
            && loading <= unloading
        {
            return Err(bad(
                "force: the loop dissipates nothing, or turns the wrong way".to_string(),
            ));
        }
        Ok(())
    }

    /// Side (0 loading), displacement and force of the points.
    fn sides(&self) -> impl Iterator<Item = (usize, f64, f64)> + Clone + '_ {
        self.branches.iter().flat_map(move |b| {
            let side = usize::from(b.direction == Direction::Unloading);
            b.points()
                .map(move |i| (side, self.displacement[i], self.force[i]))
        })
    }

    /// Points that are fitted.
    pub fn points(&self) -> usize {
        self.branches.iter().map(Branch::count).sum()
    }

    /// Half the range of the forces that are fitted.
    pub fn force_unit(&self) -> f64 {
        let forces = self.branches.iter().flat_map(|b| b.points());
        let (low, high) = forces.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), i| {
            (low.min(self.force[i]), high.max(self.force[i]))
        });
        0.5 * (high - low)
    }

    /// Energy of one cycle as measured, between the largest amplitudes: the mean work of the half cycles that load plus
    /// that of those that unload; NaN where none was recorded to its end.
    pub fn loop_area(&self) -> f64 {
        let work = |direction| {
            let ours: Vec<f64> = self
                .half_cycles
                .iter()
                .filter(|half| half.direction == direction && self.is_whole(half))
                .map(|half| self.work(half))
                .collect();
            ours.iter().sum::<f64>() / ours.len() as f64
        };
        let both = work(Direction::Loading) + work(Direction::Unloading);
        if both.is_finite() {
            return both;
        }
        // One direction was not recorded to its end: the other one, about the mean force, is half of the loop.
        let one = [Direction::Loading, Direction::Unloading].map(|direction| {
            let half = work(direction);
            2.0 * (half - direction.sign() * 2.0 * self.amplitude * self.mean_force())
        });
        one.into_iter().find(|w| w.is_finite()).unwrap_or(f64::NAN)
    }

    /// The middle of the forces.
    fn mean_force(&self) -> f64 {
        let [low, high] = range(&self.force);
        0.5 * (low + high)
    }

    /// Whether it is as long as the loop, was recorded to its end, and is among the rows that were chosen.
    fn is_whole(&self, half: &HalfCycle) -> bool {
        let mut points = half.points();
        let (Some(first), Some(last)) = (points.next(), points.last()) else {
            return false;
        };
        let length = (self.displacement[last] - self.displacement[first]).abs();
        let chosen = self
            .chosen
            .as_ref()
            .is_none_or(|rows| rows.contains(&first) && rows.contains(&last));
        chosen && length > COMPLETE * 2.0 * self.amplitude
    }

    /// Work along a half cycle by trapezoids, from the reversal (the point before the first one).
    fn work(&self, half: &HalfCycle) -> f64 {
        let first = half.points().next();
        let reversal = first.and_then(|first| first.checked_sub(1));
        let mut before = reversal;
        let mut work = 0.0;
        for index in half.points() {
            if let Some(before) = before {
                let dx = self.displacement[index] - self.displacement[before];
                work += 0.5 * (self.force[before] + self.force[index]) * dx;
            }
            before = Some(index);
        }
        work
    }
}

/// A copy, or words where memory ends.
pub(super) fn copy(values: &[f64]) -> Result<Vec<f64>, Error> {
    let mut copy = room(values.len())?;
    copy.extend_from_slice(values);
    Ok(copy)
}

/// An empty vector with room for so many numbers, or words where memory ends.
pub(super) fn room(count: usize) -> Result<Vec<f64>, Error> {
    let mut vector = Vec::new();
    match vector.try_reserve_exact(count) {
        Ok(()) => Ok(vector),
        Err(_) => Err(bad(format!("n = {count}: not enough memory"))),
    }
}

fn check(displacement: &[f64], force: &[f64]) -> Result<(), Error> {
    if displacement.len() != force.len() {
        return Err(bad(format!(
            "{} displacements and {} forces: must be as many",
            displacement.len(),
            force.len()
        )));
    }
    for (name, values) in [("displacement", displacement), ("force", force)] {
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let value = values[index];
            return Err(bad(format!("{name}[{index}] = {value:?}: must be finite")));
        }
        let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        if largest != 0.0 && !SQUARABLE.contains(&largest) {
            return Err(bad(format!(
                "{name}: the largest value, {largest:e}, is not from {:e} to {:e}",
                SQUARABLE.start(),
                SQUARABLE.end()
            )));
        }
    }
    let [low, high] = range(displacement);
    if !(high - low).is_normal() {
        return Err(bad(format!(
            "displacement = {low:?} .. {high:?} in {} points: no loop, the displacement does not move",
            displacement.len()
        )));
    }
    let force_range = range(force);
    if !(force_range[1] - force_range[0]).is_normal() {
        return Err(bad(format!(
            "force = {:?} throughout: no loop",
            force_range[0]
        )));
    }
    Ok(())
}

fn bad(message: String) -> Error {
    Error::new(Kind::BadInput, message)
}

/// Least and greatest value.
fn range(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
            [low.min(value), high.max(value)]
        })
}

/// Indices where the displacement turns.
fn reversals(x: &[f64], threshold: f64) -> Vec<usize> {
    let mut turns = Vec::new();
    // The extreme reached since the last turn; the direction is known once the first threshold is passed.
    let (mut lowest, mut highest) = (0, 0);
    let mut direction = None;
    for (index, &value) in x.iter().enumerate() {
        if value > x[highest] {
            highest = index;
        }
        if value < x[lowest] {
            lowest = index;
        }
        let rises = value - x[lowest] >= threshold;
        let falls = x[highest] - value >= threshold;
        if rises && direction != Some(Direction::Loading) {
            if direction.is_some() {
                turns.push(lowest);
            }
            direction = Some(Direction::Loading);
            highest = index;
        } else if falls && direction != Some(Direction::Unloading) {
            if direction.is_some() {
                turns.push(highest);
            }
            direction = Some(Direction::Unloading);
            lowest = index;
        }
    }
    turns
}

/// The direction from one displacement to another.
fn direction(from: f64, to: f64) -> Direction {
    if to > from {
        Direction::Loading
    } else {
        Direction::Unloading
    }
}

/// The sample that goes farthest in a direction, the first one of several.
fn farthest(
    x: &[f64],
    samples: impl Iterator<Item = usize>,
    direction: Direction,
) -> Option<usize> {
    let reach = |index: &usize| -direction.sign() * x[*index];
    samples.min_by(|a, b| reach(a).total_cmp(&reach(b)))
}

/// Where the displacement turned at sample `turn`, and how much the samples about it scatter. The extreme one of noisy
/// samples lies beyond the turn: then the tip of a curve through them, with or without a corner, is taken.
fn settled(x: &[f64], turn: usize, length: f64) -> (f64, f64) {
    let mut reach = NEAR * length;
    loop {
        let tip = Tip::new(x, turn, reach);
        // The curve cannot follow a dwell between two ramps: then fewer samples are better.
        if tip.scatter <= (MISFIT * tip.noise).max(GOOD * length) {
            return (tip.place, tip.scatter);
        }
        reach *= 0.5;
    }
}

/// Where the displacement turned, by the samples about it.
struct Tip {
    place: f64,
    /// How far the samples are from the curve, root mean square.
    scatter: f64,
    /// What is noise of that: from the second differences.
    noise: f64,
}

impl Tip {
    /// By the samples within `reach` of sample `turn`; that sample itself where they are few, or monotonic on both
    /// sides.
    fn new(x: &[f64], turn: usize, reach: f64) -> Self {
        let alone = Tip {
            place: x[turn],
            scatter: 0.0,
            noise: 0.0,
        };
        let near = |index: &usize| (x[*index] - x[turn]).abs() <= reach;
        let first = (0..turn).rev().take_while(near).last().unwrap_or(turn);
        let last = (turn + 1..x.len()).take_while(near).last().unwrap_or(turn);
        let approaches = x[first..=turn].windows(2).map(|pair| pair[1] - pair[0]);
        let leaves = x[turn..=last].windows(2).map(|pair| pair[0] - pair[1]);
        let (rises, falls) = approaches
            .chain(leaves)
            .fold((false, false), |(rises, falls), step| {
                (rises || step > 0.0, falls || step < 0.0)
            });
        let width = last - first;
        if !(rises && falls) || width < FEWEST_NEAR {
            return alone;
        }
        let differences = x[first..=last].windows(3);
        let mut second: Vec<f64> = differences
            .map(|three| (three[0] - 2.0 * three[1] + three[2]).abs())
            .collect();
        let middle = second.len() / 2;
        let (_, median, _) = second.select_nth_unstable_by(middle, f64::total_cmp);
        // Of independent noise the second difference has six times the variance; a corner moves the median little.
        let noise = *median / (MEDIAN * 6f64.sqrt());
        let samples = || (first..=last).step_by(1 + width / MOST_NEAR);
        let outward = if x[first] < x[turn] { 1.0 } else { -1.0 };
        // The sum of squares for every place where a corner may be, of which the least counts, and the tip.
        let curves = (first..=last)
            .step_by(1 + width / CORNERS)
            .filter_map(|corner| {
                let row = |index: usize| {
                    let u = (index as f64 - corner as f64) / width as f64;
                    Vector3::new(1.0, u.abs(), u * u)
                };
                let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
                for index in samples() {
                    let row = row(index);
                    matrix += row * row.transpose();
                    right += row * (x[index] - x[turn]);
                }
                let curve = matrix.cholesky()?.solve(&right);
                let (mut square, mut tip) = (0.0, f64::NEG_INFINITY);
                for index in samples() {
                    let value = curve.dot(&row(index));
                    square += (x[index] - x[turn] - value).powi(2);
                    tip = tip.max(outward * value);
                }
                Some((square, outward * tip))
            });
        let best = curves.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or(alone, |(square, tip)| Tip {
            place: x[turn] + tip,
            scatter: (square / samples().count() as f64).sqrt(),
            noise,
        })
    }
}

/// Standard deviation of the noise of a series, from its second differences; of a coarsely sampled one more than that.
pub(super) fn noise(x: &[f64]) -> f64 {
    let stride = 1 + x.len() / SECOND_DIFFERENCES;
    let mut second: Vec<f64> = x
        .windows(3)
        .step_by(stride)
        .map(|three| (three[0] - 2.0 * three[1] + three[2]).abs())
        .collect();
    if second.is_empty() {
        return 0.0;
    }
    let middle = second.len() / 2;
    // Of independent noise the second difference has six times the variance.
    *second.select_nth_unstable_by(middle, f64::total_cmp).1 / (MEDIAN * 6f64.sqrt())
}

/// Cuts the displacements into branches: of a steady loop, or of one whose amplitude changes.
fn cut(x: &[f64], force: &[f64], origin: Option<Origin>) -> Cut {
    let [low, high] = range(x);
    let length = high - low;
    let threshold = (NO_NOISE * noise(x)).clamp(SMALL_REVERSAL * length, REVERSAL * length);
    let turns = reversals(x, threshold);
    let grows = turns
        .windows(2)
        .any(|pair| (x[pair[1]] - x[pair[0]]).abs() < COMPLETE * length);
    if !grows {
        return steady(x, force);
    }
    let at_rest = |values: &[f64]| {
        let [low, high] = range(values);
        (values[0] - 0.5 * (low + high)).abs() <= AT_REST * (high - low)
    };
    let origin = origin.unwrap_or(if at_rest(x) && at_rest(force) {
        Origin::Start
    } else {
        Origin::Centre
    });
    remembered(x, &turns, origin)
}

/// The branches of a record whose amplitude changes, by return-point memory.
fn remembered(x: &[f64], turns: &[usize], origin: Origin) -> Cut {
    let last = x.len() - 1;
    let (first_turn, last_turn) = (turns[0], turns[turns.len() - 1]);
    let near = |k: usize| {
        let own = x[turns[k]];
        let other = |k: Option<usize>| {
            k.and_then(|k| turns.get(k))
                .map_or(f64::INFINITY, |&turn| (x[turn] - own).abs())
        };
        other(k.checked_sub(1)).min(other(Some(k + 1)))
    };
    let (ends, scatter): (Vec<f64>, Vec<f64>) = (0..turns.len())
        .map(|k| settled(x, turns[k], near(k)))
        .unzip();
    let mut legs = Vec::new();
    if origin == Origin::Start {
        legs.push((0..first_turn + 1, x[0], ends[0]));
    }
    for (pair, ends) in turns.windows(2).zip(ends.windows(2)) {
        legs.push((pair[0] + 1..pair[1] + 1, ends[0], ends[1]));
    }
    // After the last turn; the record may turn once more, too close to its end for a threshold.
    let from = ends[ends.len() - 1];
    let tail = direction(x[last_turn], x[turns[turns.len() - 2]]);
    if let Some(end) = farthest(x, (last_turn..=last).rev(), tail).filter(|end| *end > last_turn) {
        legs.push((last_turn + 1..end + 1, from, x[end]));
    }
    let (low, high) = ends
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &end| {
            (low.min(end), high.max(end))
        });
    let centre = 0.5 * (low + high);
    let rest = match origin {
        Origin::Start => x[0],
        // The first reversal lies on that side of the place of rest to which the displacement went.
        Origin::Centre if (ends[0] - centre) * (ends[0] - ends[1]) > 0.0 => centre,
        Origin::Centre => 0.5 * (ends[0] + ends[1]),
    };
    let mut nodes = Vec::new();
    // Reversals that are open: displacement and node.
    let mut open: Vec<(f64, usize)> = Vec::new();
    let mut reversal = (origin == Origin::Centre).then(|| {
        nodes.push(Node {
            parent: None,
            weight: (ends[0] - rest).signum(),
            distance: (ends[0] - rest).abs(),
        });
        (ends[0], 0)
    });
    let (mut branches, mut half_cycles) = (Vec::new(), Vec::new());
    for (mut rows, from, to) in legs {
        let direction = direction(from, to);
        let sign = direction.sign();
        let amplitude = 0.5 * (to - from).abs();
        if reversal.is_some() {
            half_cycles.push(HalfCycle {
                direction,
                amplitude,
                rows: vec![rows.clone()],
            });
        }
        open.extend(reversal);
        loop {
            // The curve that is followed, and where it meets an older one.
            let count = open.len();
            let (node, start, closes) = match open.last() {
                None => (None, rest, None),
                Some(&(start, node)) if count == 1 => (Some(node), start, Some(2.0 * rest - start)),
                Some(&(start, node)) => (Some(node), start, Some(open[count - 2].0)),
            };
            let mut branch = Branch {
                direction,
                start,
                amplitude,
                virgin: node.is_none(),
                node,
                rows: Vec::new(),
            };
            let (weight, factor) = branch.masing();
            let passed = closes.filter(|place| sign * (to - place) > 0.0);
            let Some(place) = passed else {
                nodes.push(Node {
                    parent: node,
                    weight,
                    distance: factor * (to - start).abs(),
                });
                branch.rows.push(rows);
                branches.push(branch);
                break;
            };
            let split = rows
                .clone()
                .find(|&index| sign * (x[index] - place) >= 0.0)
                .unwrap_or(rows.end);
            branch.rows.push(rows.start..split);
            branches.push(branch);
            rows.start = split;
            open.truncate(count.saturating_sub(2));
        }
        reversal = Some((to, nodes.len() - 1));
    }
    branches.retain(|branch| branch.count() > 0);
    Cut {
        branches,
        nodes,
        half_cycles,
        scatter: scatter.iter().sum::<f64>() / scatter.len() as f64,
        amplitude: 0.5 * (high - low),
        centre,
        origin: Some(origin),
    }
}

/// The branches that belong to the loop between the ends of the displacement.
fn steady(x: &[f64], force: &[f64]) -> Cut {
    let (found, scatter) = branches(x, force);
    let count = found.len() as f64;
    let amplitude = found.iter().map(|b| b.amplitude).sum::<f64>() / count;
    // Branch by branch the middle lies half a branch after its start.
    let middle = found
        .iter()
        .map(|b| b.start + b.direction.sign() * b.amplitude);
    let nodes = found.iter().map(|b| Node {
        parent: None,
        weight: -b.direction.sign(),
        distance: b.amplitude,
    });
    let half_cycles = found.iter().map(|b| HalfCycle {
        direction: b.direction,
        amplitude: b.amplitude,
        rows: b.rows.clone(),
    });
    Cut {
        centre: middle.sum::<f64>() / count,
        nodes: nodes.collect(),
        half_cycles: half_cycles.collect(),
        branches: found,
        scatter,
        amplitude,
        origin: None,
    }
}

/// The branches that belong to the largest loop, and how much the displacement scatters.
fn branches(x: &[f64], force: &[f64]) -> (Vec<Branch>, f64) {
    let [low, high] = range(x);
    let length = high - low;
    let mut turns = reversals(x, REVERSAL * length);
    let (Some(&first_turn), Some(&last_turn)) = (turns.first(), turns.last()) else {
        return (Vec::new(), 0.0);
    };
    let last = x.len() - 1;
    let extreme = |direction| match direction {
        Direction::Loading => high,
        Direction::Unloading => low,
    };
    let ends_loop =
        |index: usize, direction| (x[index] - extreme(direction)).abs() <= SAME * length;
    // The record may turn once more, too close to its start or its end for a threshold.
    let head = direction(x[0], x[first_turn]);
    let start = farthest(x, 0..=first_turn, head.opposite()).unwrap_or(0);
    let head_is_full = ends_loop(start, head.opposite());
    if head_is_full && start > 0 {
        turns.insert(0, start);
    }
    let before = turns[..turns.len() - 1].last().copied().unwrap_or(0);
    let tail = direction(x[last_turn], x[before]);
    let end = farthest(x, (last_turn..=last).rev(), tail).unwrap_or(last);
    if ends_loop(end, tail) && (x[last] - x[end]).abs() > SAME * length {
        turns.push(end);
    }
    let settled_turns = turns.iter().map(|&turn| settled(x, turn, length));
    let (ends, scatter): (Vec<f64>, Vec<f64>) = settled_turns.unzip();

    let mut found: Vec<Branch> = Vec::new();
    for (pair, ends) in turns.windows(2).zip(ends.windows(2)) {
        if (ends[1] - ends[0]).abs() >= COMPLETE * length {
            found.push(Branch {
                direction: direction(ends[0], ends[1]),
                start: ends[0],
                amplitude: 0.5 * (ends[1] - ends[0]).abs(),
                virgin: false,
                node: None,
                rows: vec![pair[0] + 1..pair[1] + 1],
            });
        }
    }
    let turn_is_full = |index: usize| {
        let nearest = (x[index] - low).abs().min((x[index] - high).abs());
        nearest <= (1.0 - COMPLETE) * length
    };
    // Before the first turn: a branch of the loop if it starts where the loop turns.
    let whole_head = head_is_full && start == 0;
    if whole_head && turn_is_full(first_turn) {
        let others = found.iter().filter(|b| b.direction == head);
        let starts: Vec<f64> = others.map(|b| b.start).collect();
        let start = if starts.is_empty() {
            extreme(head.opposite())
        } else {
            starts.iter().sum::<f64>() / starts.len() as f64
        };
        found.insert(
            0,
            Branch {
                direction: head,
                start,
                amplitude: 0.5 * (ends[0] - start).abs(),
                virgin: false,
                node: None,
                rows: vec![0..first_turn + 1],
            },
        );
    }
    // After the last turn: its start is known even if the record ends half way. What comes after its own end is too
    // short to be a branch.
    let (first_turn, last_turn) = (turns[0], turns[turns.len() - 1]);
    let start = ends[turns.len() - 1];
    let stop = if last_turn == end { last } else { end };
    if turn_is_full(last_turn) && stop > last_turn {
        let tail = direction(start, x[stop]);
        let reached = 0.5 * (settled(x, stop, length).0 - start).abs();
        let usual = found.last().map_or(0.5 * length, |b| b.amplitude);
        let mut rows = vec![last_turn + 1..stop + 1];
        // A record of one steady cycle may start anywhere: then its first points complete the last branch.
        let closes = tail == direction(x[0], x[first_turn])
            && !whole_head
            && (x[stop] - x[0]).abs() <= SAME * length
            && (force[stop] - force[0]).abs() <= CLOSED * (range(force)[1] - range(force)[0]);
        if closes && turn_is_full(first_turn) {
            rows.push(0..first_turn + 1);
        }
        found.push(Branch {
            direction: tail,
            start,
            // It may have gone on.
            amplitude: reached.max(usual),
            virgin: false,
            node: None,
            rows,
        });
    }
    let scatter = scatter.iter().sum::<f64>() / scatter.len() as f64;
    // Every branch starts from a node of its own.
    for (index, branch) in found.iter_mut().enumerate() {
        branch.node = Some(index);
    }
    (found, scatter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cosine(cycles: f64, steps: usize, phase: f64) -> Vec<f64> {
        (0..=(cycles * steps as f64) as usize)
            .map(|k| -((k as f64 / steps as f64 + phase) * std::f64::consts::TAU).cos())
            .collect()
    }

    #[test]
    fn three_cycles_have_six_branches() {
        let x = cosine(3.0, 100, 0.0);
        let branches = branches(&x, &x).0;
        assert_eq!(branches.len(), 6);
        assert_eq!(branches.iter().map(|b| b.count()).sum::<usize>(), x.len());
        for (k, b) in branches.iter().enumerate() {
            assert_eq!(b.direction == Direction::Loading, k % 2 == 0);
            assert_eq!((b.start.abs(), b.amplitude), (1.0, 1.0));
        }
    }

    #[test]
    fn first_loading_is_left_out() {
        // From 0 to the first peak, then a full cycle; the force of first loading is not that of the loop.
        let x = cosine(1.25, 100, 0.25);
        let mut force = x.clone();
        force[0] = 5.0;
        let branches = branches(&x, &force).0;
        assert_eq!(branches.len(), 2);
        assert_eq!(branches[0].rows[0].start, 26);
    }

    #[test]
    fn one_cycle_from_the_middle_closes() {
        let x = cosine(1.0, 100, 0.25);
        let branches = branches(&x, &x).0;
        assert_eq!(branches.len(), 2);
        assert_eq!(branches.iter().map(|b| b.count()).sum::<usize>(), x.len());
    }

    #[test]
    fn noise_does_not_turn() {
        let mut x = cosine(2.0, 400, 0.0);
        let mut random = 1u32;
        for value in &mut x {
            random = random.wrapping_mul(1664525).wrapping_add(1013904223);
            *value += 0.02 * (f64::from(random) / f64::from(u32::MAX) - 0.5);
        }
        assert_eq!(branches(&x, &x).0.len(), 4);
    }

    #[test]
    fn what_is_no_loop_is_refused() {
        let line: Vec<f64> = (0..50).map(f64::from).collect();
        for (x, force, word) in [
            (line.clone(), line.clone(), "no loop: 0 whole half cycles"),
            (vec![1.0; 50], line.clone(), "does not move"),
            (cosine(1.0, 50, 0.0), vec![2.0; 51], "no loop"),
            (line.clone(), vec![f64::NAN; 50], "force[0]"),
            (line.clone(), vec![0.0; 3], "as many"),
            (Vec::new(), Vec::new(), "in 0 points"),
        ] {
            let message = Record::new(&x, &force).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
