//! Curves of many points, as small as they can be drawn without a difference to the eye.
//!
//! Points are taken in the whole units of the canvas. A curve of few points is drawn as it is; one of more points as few
//! that are nowhere farther from it than a tenth of the line's width; what is still too much (noise, many cycles) as
//! the area that it covers: vertical bars of the columns of the picture. All lines of one colour are taken together.

use super::{Curve, FINE, Stroke};
use std::collections::BTreeMap;

/// Width of a column of the area: that of a line.
pub const COLUMN: i32 = 2 * FINE;
/// Lines of one colour with more points than this, after thinning, become an area.
const MANY: usize = 4000;
/// Curves of more points than this are not worth the search for fewer.
const TOO_MANY: usize = 400_000;
/// So far may a thinned line be from the points.
const TOLERANCE: f64 = 0.2 * FINE as f64;
/// Bars of one area; gaps between them are closed until there are no more.
const BARS: usize = 1500;

/// What is to be drawn for a curve.
#[derive(Debug, PartialEq)]
pub enum Seen {
    /// A line through these points.
    Line(Vec<(i32, i32)>),
    /// Bars (x, top, bottom), and the mean of the points along x where the curves run one way in x (else empty).
    Area {
        runs: Vec<[i32; 3]>,
        mean: Vec<(i32, i32)>,
    },
    /// It is drawn with an earlier one of its colour.
    Nothing,
}

/// What is to be drawn for each of the curves; `place` is where a point is on the canvas.
pub fn dense(curves: &[Curve], place: impl Fn(&[f64; 2]) -> [i32; 2]) -> Vec<Seen> {
    let mut seen: Vec<Seen> = curves.iter().map(|_| Seen::Nothing).collect();
    let mut done = vec![false; curves.len()];
    for first in 0..curves.len() {
        if done[first] || curves[first].stroke != Stroke::Solid {
            continue;
        }
        let alike: Vec<usize> = (first..curves.len())
            .filter(|&k| {
                curves[k].stroke == Stroke::Solid && curves[k].colour == curves[first].colour
            })
            .collect();
        let lines: Vec<Vec<[i32; 2]>> = alike
            .iter()
            .map(|&k| line(&curves[k].points, &place))
            .collect();
        let count: usize = lines.iter().map(Vec::len).sum();
        let few = if count <= MANY {
            Some(lines.clone())
        } else if count <= TOO_MANY {
            let few: Vec<Vec<[i32; 2]>> = lines.iter().map(|line| fewer(line)).collect();
            (few.iter().map(Vec::len).sum::<usize>() <= MANY).then_some(few)
        } else {
            None
        };
        match few {
            Some(few) => {
                for (&k, line) in alike.iter().zip(few) {
                    seen[k] = Seen::Line(line.into_iter().map(|[x, y]| (x, y)).collect());
                }
            }
            None => {
                seen[first] = Seen::Area {
                    runs: bars(&lines),
                    mean: mean(&lines),
                };
            }
        }
        for k in alike {
            done[k] = true;
        }
    }
    seen
}

/// The points on the canvas, each once where it comes several times in a row.
fn line(points: &[[f64; 2]], place: impl Fn(&[f64; 2]) -> [i32; 2]) -> Vec<[i32; 2]> {
    let mut line: Vec<[i32; 2]> = points.iter().map(place).collect();
    line.dedup();
    line
}

/// Ramer's and Douglas and Peucker's algorithm: the ends, and the farthest point between them as long as it is too far.
fn fewer(line: &[[i32; 2]]) -> Vec<[i32; 2]> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut kept = vec![false; line.len()];
    kept[0] = true;
    kept[line.len() - 1] = true;
    let mut open = vec![(0, line.len() - 1)];
    while let Some((start, end)) = open.pop() {
        let between = start + 1..end;
        let far = between
            .map(|k| (distance(line[k], line[start], line[end]), k))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, k)) = far.filter(|(distance, _)| *distance > TOLERANCE) {
            kept[k] = true;
            open.extend([(start, k), (k, end)]);
        }
    }
    let kept = line.iter().zip(kept).filter(|(_, kept)| *kept);
    kept.map(|(point, _)| *point).collect()
}

/// From a point to a segment.
fn distance(point: [i32; 2], start: [i32; 2], end: [i32; 2]) -> f64 {
    let along = [end[0] - start[0], end[1] - start[1]].map(f64::from);
    let to = [point[0] - start[0], point[1] - start[1]].map(f64::from);
    let square = along[0] * along[0] + along[1] * along[1];
    let part = match square {
        0.0 => 0.0,
        _ => ((to[0] * along[0] + to[1] * along[1]) / square).clamp(0.0, 1.0),
    };
    (to[0] - part * along[0]).hypot(to[1] - part * along[1])
}

/// The bars that lines cover: x of the middle of a column, top and bottom.
fn bars(lines: &[Vec<[i32; 2]>]) -> Vec<[i32; 3]> {
    // Cells of FINE units in height, column by column.
    let mut cells: BTreeMap<i32, Vec<bool>> = BTreeMap::new();
    let mut cover = |column: i32, low: i32, high: i32| {
        let column = cells.entry(column).or_default();
        if column.len() <= high as usize {
            column.resize(high as usize + 1, false);
        }
        column[low as usize..=high as usize].fill(true);
    };
    let row = |y: f64| (y / f64::from(FINE)).floor().max(0.0) as i32;
    for line in lines {
        if let [[x, y]] = line[..] {
            cover(x.div_euclid(COLUMN), row(f64::from(y)), row(f64::from(y)));
        }
        for pair in line.windows(2) {
            let (mut a, mut b) = (pair[0].map(f64::from), pair[1].map(f64::from));
            if a[0] > b[0] {
                std::mem::swap(&mut a, &mut b);
            }
            let at = |x: f64| match b[0] - a[0] {
                0.0 => a[1],
                length => a[1] + (b[1] - a[1]) * ((x - a[0]) / length).clamp(0.0, 1.0),
            };
            let width = f64::from(COLUMN);
            let (first, last) = ((a[0] / width).floor() as i32, (b[0] / width).floor() as i32);
            for column in first..=last {
                let (left, right) = (f64::from(column) * width, f64::from(column + 1) * width);
                let (mut low, mut high) = (at(left.max(a[0])), at(right.min(b[0])));
                if a[0] == b[0] {
                    (low, high) = (a[1], b[1]);
                }
                cover(column, row(low.min(high)), row(low.max(high)));
            }
        }
    }
    let mut gap = 0;
    loop {
        let mut found: Vec<[i32; 3]> = Vec::new();
        for (&column, covered) in &cells {
            let x = column * COLUMN + COLUMN / 2;
            let before = found.len();
            for (y, _) in covered.iter().enumerate().filter(|(_, covered)| **covered) {
                let y = y as i32;
                match found[before..].last_mut() {
                    Some(run) if y * FINE - run[2] <= gap * FINE => run[2] = (y + 1) * FINE,
                    _ => found.push([x, y * FINE, (y + 1) * FINE]),
                }
            }
        }
        if found.len() <= BARS || gap > 1 << 20 {
            return found;
        }
        gap = 2 * gap + 1;
    }
}

/// The mean height of the points in each column; empty if a line runs forth and back in x.
fn mean(lines: &[Vec<[i32; 2]>]) -> Vec<(i32, i32)> {
    let one_way = |line: &Vec<[i32; 2]>| {
        let mut pairs = line.windows(2);
        pairs.clone().all(|p| p[1][0] >= p[0][0]) || pairs.all(|p| p[1][0] <= p[0][0])
    };
    if !lines.iter().all(one_way) {
        return Vec::new();
    }
    let mut sums: BTreeMap<i32, (f64, f64)> = BTreeMap::new();
    for [x, y] in lines.iter().flatten() {
        let sum = sums.entry(x.div_euclid(COLUMN)).or_default();
        *sum = (sum.0 + f64::from(*y), sum.1 + 1.0);
    }
    let means = sums.into_iter();
    means
        .map(|(column, (sum, count))| (column * COLUMN + COLUMN / 2, (sum / count).round() as i32))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BLUE, GREEN};

    fn curve(points: Vec<[f64; 2]>, colour: crate::RGBColor) -> Curve {
        Curve {
            label: String::new(),
            points,
            stroke: Stroke::Solid,
            colour,
        }
    }

    fn place(p: &[f64; 2]) -> [i32; 2] {
        p.map(|v| v.round() as i32)
    }

    #[test]
    fn few_points_stay() {
        let points: Vec<[f64; 2]> = (0..50).map(|k| [f64::from(k), f64::from(k * k)]).collect();
        let seen = dense(&[curve(points.clone(), BLUE)], place);
        let all: Vec<(i32, i32)> = points.iter().map(|p| (p[0] as i32, p[1] as i32)).collect();
        assert_eq!(seen, [Seen::Line(all)]);
    }

    /// A smooth curve of a million points is a line of some hundred, and nowhere off.
    #[test]
    fn smooth_curves_become_short() {
        let circle = |k: u32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 1e6;
            [4000.0 + 3000.0 * angle.cos(), 3000.0 + 2500.0 * angle.sin()]
        };
        let seen = dense(&[curve((0..=1_000_000).map(circle).collect(), BLUE)], place);
        let [Seen::Line(line)] = &seen[..] else {
            panic!("a line");
        };
        assert!((50..1000).contains(&line.len()), "{}", line.len());
        for k in (0..1_000_000).step_by(997) {
            let p = place(&circle(k));
            let near = line
                .windows(2)
                .map(|pair| distance(p, [pair[0].0, pair[0].1], [pair[1].0, pair[1].1]))
                .fold(f64::INFINITY, f64::min);
            assert!(near <= TOLERANCE + 1.0, "{k}: {near}");
        }
    }

    /// Noise becomes bars that hold every point, and the mean of what runs one way.
    #[test]
    fn noise_becomes_an_area() {
        let noise = |k: i32| f64::from((k * 7919) % 1000) - 500.0;
        let sweep = |offset: f64| -> Vec<[f64; 2]> {
            (0..100_000)
                .map(|k| [f64::from(k) * 0.08, offset + noise(k)])
                .collect()
        };
        let curves = [
            curve(sweep(2000.0), BLUE),
            curve(sweep(4000.0), GREEN),
            curve(sweep(2000.0), BLUE),
        ];
        let seen = dense(&curves, place);
        let Seen::Area { runs, mean } = &seen[0] else {
            panic!("an area");
        };
        assert_eq!(seen[2], Seen::Nothing);
        assert!(runs.len() <= BARS && mean.len() > 300);
        for p in curves[0].points.iter().map(place) {
            let holds = |run: &&[i32; 3]| {
                (run[0] - p[0]).abs() <= COLUMN && run[1] <= p[1] && p[1] <= run[2]
            };
            assert!(runs.iter().any(|run| holds(&run)), "{p:?}");
        }
        // The noise has a mean of -.5; the last column has a few points only.
        let inner = &mean[..mean.len() - 1];
        assert!(inner.iter().all(|(_, y)| (y - 2000).abs() < 20), "{mean:?}");
        let forth_and_back: Vec<[f64; 2]> = sweep(2000.0)
            .into_iter()
            .chain(sweep(2000.0).into_iter().rev())
            .collect();
        let seen = dense(&[curve(forth_and_back, BLUE)], place);
        assert!(matches!(&seen[0], Seen::Area { mean, .. } if mean.is_empty()));
    }
}
