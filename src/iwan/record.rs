//! Measured data cut into branches: from one reversal of the displacement to the next.

use super::Direction;
use super::fit::two_lines;
use crate::error::{Error, Kind};
use nalgebra::{Matrix3, Vector3};
use std::ops::RangeInclusive;

/// A change of direction counts as a reversal when the displacement comes back by this part of its whole range;
/// less is noise, or a nested loop.
const REVERSAL: f64 = 0.2;
/// A branch this long, as a part of the whole range, belongs to the loop; shorter ones are first loading or smaller loops.
const COMPLETE: f64 = 0.9;
/// What starts or ends this close, as a part of the whole range, starts or ends at the same place.
const SAME: f64 = 0.02;
/// Samples this close to a turn, as a part of the whole range, tell where it is, if there are so many.
const NEAR: f64 = 0.05;
const FEWEST_NEAR: usize = 8;
/// At most so many of them are used, and so many places tried for a corner between them.
const MOST_NEAR: usize = 2000;
const CORNERS: usize = 100;
/// A curve is good enough when the samples are no farther from it than so many times their noise, or than this part of the range.
const MISFIT: f64 = 2.0;
const GOOD: f64 = 2e-4;
/// The median of normal noise, without its sign, in standard deviations.
const MEDIAN: f64 = 0.6745;
/// Forces this close, as a part of their whole range, close the loop.
const CLOSED: f64 = 0.05;
/// Sums of the squares of such numbers neither overflow nor vanish.
const SQUARABLE: RangeInclusive<f64> = 1e-100..=1e100;
/// Five unknowns (the parameters and the mean force) need some points on each side.
const MIN_POINTS: usize = 8;

/// A stretch of data between two reversals.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Which way it goes.
    pub direction: Direction,
    /// Displacement at the reversal where it starts.
    pub start: f64,
    /// Half the distance from there to the reversal at its end.
    pub amplitude: f64,
    /// The points, as indices into the record, in their order.
    pub points: Vec<usize>,
}

/// A displacement-force record: one or more cycles about any centre, in the order of time.
#[derive(Clone, Debug)]
pub struct Record {
    /// Displacements.
    pub displacement: Vec<f64>,
    /// Forces.
    pub force: Vec<f64>,
    /// The branches of the loop; first loading and smaller loops are left out.
    pub branches: Vec<Branch>,
    /// Half the distance between the reversals, mean of all branches.
    pub amplitude: f64,
    /// The middle between the reversals.
    pub centre: f64,
    /// How much the displacement scatters where it turns; 0 where it is monotonic on both sides.
    pub scatter: f64,
}

/// A point of the loop in units of the record's amplitude and of some force: what Masing's rule needs.
#[derive(Clone, Debug)]
pub struct Point {
    /// 1 on a loading branch, -1 on an unloading one.
    pub sign: f64,
    /// Half the distance from the reversal: 0 to 1, or a little beyond by noise.
    pub distance: f64,
    /// Amplitude of this branch over the mean one.
    pub amplitude: f64,
    /// Displacement from the centre.
    pub displacement: f64,
    /// Force.
    pub force: f64,
}

impl Record {
    /// Finds the reversals and the branches between them.
    ///
    /// # Errors
    /// [`Kind::BadInput`]: lengths that differ, numbers that are not finite, no loop in the data (no branch in one of the
    /// directions, or fewer than eight points on it).
    pub fn new(displacement: &[f64], force: &[f64]) -> Result<Self, Error> {
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
        let length = high - low;
        if !length.is_normal() {
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
        let (branches, scatter) = branches(displacement, force);
        for direction in [Direction::Loading, Direction::Unloading] {
            let ours = branches.iter().filter(|b| b.direction == direction);
            let points: usize = ours.map(|b| b.points.len()).sum();
            if points < MIN_POINTS {
                return Err(bad(format!(
                    "n = {}: {points} points on a {direction:?} branch of the loop: at least {MIN_POINTS} are needed in each \
                     direction, between reversals that are one loop apart",
                    displacement.len()
                )));
            }
        }
        let all = branches.iter().flat_map(|b| {
            let side = usize::from(b.direction == Direction::Unloading);
            b.points
                .iter()
                .map(move |&i| (side, displacement[i], force[i]))
        });
        // What loads lies above what unloads.
        if let Some(([loading, unloading, _], ..)) = two_lines(&all.collect::<Vec<_>>())
            && loading <= unloading
        {
            return Err(bad(
                "force: the loop dissipates nothing, or turns the wrong way".to_string(),
            ));
        }
        let count = branches.len() as f64;
        let amplitude = branches.iter().map(|b| b.amplitude).sum::<f64>() / count;
        // Branch by branch the middle lies half a branch after its start.
        let middle = branches
            .iter()
            .map(|b| b.start + b.direction.sign() * b.amplitude);
        Ok(Record {
            displacement: displacement.to_vec(),
            force: force.to_vec(),
            amplitude,
            centre: middle.sum::<f64>() / count,
            scatter,
            branches,
        })
    }

    /// The same record with other forces, for resampling.
    pub fn with_force(&self, force: Vec<f64>) -> Self {
        Record {
            force,
            ..self.clone()
        }
    }

    /// The points of the loop, branch by branch, forces over `unit`.
    pub fn scaled(&self, unit: f64) -> Vec<Point> {
        let points = self.branches.iter().flat_map(|branch| {
            let sign = branch.direction.sign();
            branch.points.iter().map(move |&index| {
                let x = self.displacement[index];
                Point {
                    sign,
                    distance: 0.5 * sign * (x - branch.start) / self.amplitude,
                    amplitude: branch.amplitude / self.amplitude,
                    displacement: (x - self.centre) / self.amplitude,
                    force: self.force[index] / unit,
                }
            })
        });
        points.collect()
    }

    /// Points that belong to the loop.
    pub fn points(&self) -> usize {
        self.branches.iter().map(|b| b.points.len()).sum()
    }

    /// Energy of one cycle as measured: the mean work of the loading branches plus that of the unloading ones; NaN where
    /// no branch was recorded to its end.
    pub fn loop_area(&self) -> f64 {
        let work = |direction| {
            let ours: Vec<f64> = self
                .branches
                .iter()
                .filter(|b| b.direction == direction && self.reach(b) > COMPLETE)
                .map(|b| self.work(b))
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

    /// Part of its length that the branch's points cover.
    fn reach(&self, branch: &Branch) -> f64 {
        let x = |index: &usize| self.displacement[*index];
        let first = branch.points.first().map_or(branch.start, x);
        let last = branch.points.last().map_or(branch.start, x);
        // Measured from the first point: a branch without its start has no full work either.
        (last - first).abs() / (2.0 * branch.amplitude)
    }

    /// Work along a branch by trapezoids, from the reversal (the point before the first one).
    fn work(&self, branch: &Branch) -> f64 {
        let first = branch.points.first();
        let reversal = first.and_then(|first| first.checked_sub(1));
        let all: Vec<usize> = reversal
            .into_iter()
            .chain(branch.points.iter().copied())
            .collect();
        all.windows(2)
            .map(|pair| {
                let dx = self.displacement[pair[1]] - self.displacement[pair[0]];
                0.5 * (self.force[pair[0]] + self.force[pair[1]]) * dx
            })
            .sum()
    }
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

/// Where the displacement turned at sample `turn`, and how much the samples about it scatter. The extreme one of noisy samples
/// lies beyond the turn: then the tip of a curve through them, with or without a corner, is taken.
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
    /// By the samples within `reach` of sample `turn`; that sample itself where they are few, or monotonic on both sides.
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
                points: (pair[0] + 1..=pair[1]).collect(),
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
                points: (0..=first_turn).collect(),
            },
        );
    }
    // After the last turn: its start is known even if the record ends half way. What comes after its own end is too short to
    // be a branch.
    let (first_turn, last_turn) = (turns[0], turns[turns.len() - 1]);
    let start = ends[turns.len() - 1];
    let stop = if last_turn == end { last } else { end };
    if turn_is_full(last_turn) && stop > last_turn {
        let tail = direction(start, x[stop]);
        let reached = 0.5 * (settled(x, stop, length).0 - start).abs();
        let usual = found.last().map_or(0.5 * length, |b| b.amplitude);
        let mut points: Vec<usize> = (last_turn + 1..=stop).collect();
        // A record of one steady cycle may start anywhere: then its first points complete the last branch.
        let closes = tail == direction(x[0], x[first_turn])
            && !whole_head
            && (x[stop] - x[0]).abs() <= SAME * length
            && (force[stop] - force[0]).abs() <= CLOSED * (range(force)[1] - range(force)[0]);
        if closes && turn_is_full(first_turn) {
            points.extend(0..=first_turn);
        }
        found.push(Branch {
            direction: tail,
            start,
            // It may have gone on.
            amplitude: reached.max(usual),
            points,
        });
    }
    let scatter = scatter.iter().sum::<f64>() / scatter.len() as f64;
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
        assert_eq!(
            branches.iter().map(|b| b.points.len()).sum::<usize>(),
            x.len()
        );
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
        assert_eq!(branches[0].points[0], 26);
    }

    #[test]
    fn one_cycle_from_the_middle_closes() {
        let x = cosine(1.0, 100, 0.25);
        let branches = branches(&x, &x).0;
        assert_eq!(branches.len(), 2);
        assert_eq!(
            branches.iter().map(|b| b.points.len()).sum::<usize>(),
            x.len()
        );
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
            (line.clone(), line.clone(), "Loading"),
            (vec![1.0; 50], line.clone(), "does not move"),
            (cosine(1.0, 50, 0.0), vec![2.0; 51], "no loop"),
            (line.clone(), vec![f64::NAN; 50], "force[0]"),
            (line.clone(), vec![0.0; 3], "as many"),
            (Vec::new(), Vec::new(), "0 points"),
        ] {
            let message = Record::new(&x, &force).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
