//! The paper's own procedure: the residual line, the point where the data leave it, and the exponent from Eq. (24) on
//! double-logarithmic paper.
//!
//! Two readings make Eq. (24) right: x is half the distance from the reversal, and T_max = F_s + k_alpha A. Two things
//! stay rough: where the data leave the line is a matter of tolerance (X_s comes out some per cent short, the more the
//! larger chi), and the logarithms weigh the smallest differences most.

use super::fit::{Fit, bad, student};
use super::least_squares::two_lines;
use super::record::Record;
use super::{CHI_OFFSET, Iwan};
use crate::error::{Error, Kind};

/// Branches of less than this part of the loop are left out.
const COMPLETE: f64 = 0.9;
/// The line is first laid through this last part of every branch.
const LAST_PART: f64 = 0.25;
/// The data leave the line where their running mean is away from it by this part of F_s, unless told otherwise.
pub const TOLERANCE: f64 = 0.001;
/// The running mean is over as many points as the noise asks for, and no more than this part of all.
const WINDOW: f64 = 1.0 / 40.0;
/// Standard deviations that noise may be away from the line, and those that it never is.
const NOISE: f64 = 3.0;
const BEYOND_NOISE: f64 = 5.0;
/// Part of X_s whose points give the exponent: at its ends the logarithms are all noise.
const SHAPE: [f64; 2] = [0.05, 0.9];

/// A point with the unloading branches turned round, so that every branch loads.
struct Point {
    side: usize,
    /// Distance from the reversal, halved.
    x: f64,
    displacement: f64,
    force: f64,
}

impl Record {
    /// The four parameters by the paper's procedure; the data leave the residual line where they are away from it by
    /// `tolerance` (a part of F_s, see [`TOLERANCE`]), or by more if there is noise. X_s and kappa depend on it: with a
    /// small one a slightly bent residual line counts as micro-slip, with a large one X_s comes out short.
    ///
    /// Standard errors are those of the two straight lines; that of X_s is half the distance of the points there.
    ///
    /// # Errors
    /// [`Kind::BadInput`] where the procedure has nothing to work on: a tolerance not within 0 to 1, no straight end of
    /// the branches (no gross slip), or no points between reversal and gross slip.
    pub fn paper(&self, tolerance: f64) -> Result<Fit, Error> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(Error::new(
                Kind::BadInput,
                format!("tolerance = {tolerance:?}: must be above 0 and below 1"),
            ));
        }
        let mut points = self.turned();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let a = self.amplitude;
        let mut onset = (1.0 - LAST_PART) * a;
        let mut line = Line::through(&points, onset)?;
        // The line and the point where the data leave it depend on each other.
        for _ in 0..10 {
            onset = line.left_at(&points, onset, tolerance)?;
            line = Line::through(&points, onset)?;
        }
        if onset >= (1.0 - 0.5 * LAST_PART) * a {
            return Err(bad(
                "no straight end of the branches, there seems to be no gross slip: the paper's procedure has nothing \
                 to lay its line through",
            ));
        }
        let force = 0.5 * (line.intercept[0] + line.intercept[1]);
        let peak = force + line.slope * a;
        // ln(1 - (T_max + T - 2 k x)/(2 F_s)) = chi ln(1 - x/X_s): the slope of a line through the origin.
        let (mut xx, mut xy, mut yy, mut count) = (0.0, 0.0, 0.0, 0.0);
        for p in &points {
            let s = p.x / onset;
            let about_zero = p.force - (line.intercept[p.side] - force);
            let rest = 1.0 - (peak + about_zero - 2.0 * line.slope * p.x) / (2.0 * force);
            if (SHAPE[0]..=SHAPE[1]).contains(&s) && rest > 0.0 {
                let (x, y) = ((-s).ln_1p(), rest.ln());
                xx += x * x;
                xy += x * y;
                yy += y * y;
                count += 1.0;
            }
        }
        let chi = xy / xx;
        if count < 3.0 || !chi.is_finite() {
            return Err(bad("too few points between reversal and gross slip"));
        }
        let chi_error = ((yy - chi * xy).max(0.0) / (count - 1.0) / xx).sqrt();
        let joint = Iwan::new([force, onset, line.slope, chi - CHI_OFFSET])
            .map_err(|e| bad(&format!("the paper's procedure gives {e}")))?;
        let offset = 0.5 * (line.intercept[0] - line.intercept[1]);
        let residuals = self.residuals(&joint, offset)?;
        let spacing = points
            .windows(2)
            .filter(|pair| pair[1].x >= 0.8 * onset && pair[0].x <= 1.2 * onset)
            .map(|pair| pair[1].x - pair[0].x)
            .fold(0.0, f64::max);
        let standard_errors = [
            0.5 * line.intercept_error[0].hypot(line.intercept_error[1]),
            0.5 * spacing,
            line.slope_error,
            chi_error,
        ];
        let t = student((points.len() - 4) as f64);
        let parameters = joint.parameters();
        Ok(Fit {
            joint,
            offset,
            stop: None,
            peak: joint.peak_force(self.amplitude),
            standard_errors,
            intervals: std::array::from_fn(|i| {
                [-1.0, 1.0].map(|sign| parameters[i] + sign * t * standard_errors[i])
            }),
            rms: (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt(),
            residuals,
            warnings: Vec::new(),
        })
    }

    /// The points of the branches that go from one end of the loop to the other.
    fn turned(&self) -> Vec<Point> {
        let near = |length: f64| length >= COMPLETE * self.amplitude;
        let whole = self
            .branches
            .iter()
            .filter(|b| !b.virgin && near(b.amplitude) && near((b.start - self.centre).abs()));
        whole
            .flat_map(|branch| {
                let sign = branch.direction.sign();
                branch.points().map(move |index| {
                    let x = self.displacement[index];
                    Point {
                        side: usize::from(sign < 0.0),
                        x: (0.5 * sign * (x - branch.start)).max(0.0),
                        displacement: sign * (x - self.centre),
                        force: sign * self.force[index],
                    }
                })
            })
            .collect()
    }
}

/// The residual lines of both sides, with one slope.
struct Line {
    intercept: [f64; 2],
    intercept_error: [f64; 2],
    slope: f64,
    slope_error: f64,
    scatter: f64,
}

impl Line {
    /// Through the points from half the distance `from` on.
    fn through(points: &[Point], from: f64) -> Result<Self, Error> {
        let end = points
            .iter()
            .filter(|p| p.x >= from)
            .map(|p| (p.side, p.displacement, p.force));
        let (solution, errors, scatter) =
            two_lines(end).ok_or_else(|| bad("too few points at the end of the branches"))?;
        let line = Line {
            intercept: [solution[0], solution[1]],
            intercept_error: [errors[0], errors[1]],
            slope: solution[2],
            slope_error: errors[2],
            scatter,
        };
        if line.intercept[0] + line.intercept[1] > 0.0 {
            return Ok(line);
        }
        Err(bad(
            "the residual lines of loading and unloading cross: no loop",
        ))
    }

    /// Where the data leave the line, coming back from its end.
    fn left_at(&self, points: &[Point], onset: f64, tolerance: f64) -> Result<f64, Error> {
        let force = 0.5 * (self.intercept[0] + self.intercept[1]);
        let noise = NOISE * self.scatter;
        let wanted = (noise / (tolerance * force)).powi(2).ceil();
        let most = (WINDOW * points.len() as f64).max(5.0);
        let window = wanted.clamp(1.0, most) as usize;
        let root = (window as f64).sqrt();
        let tolerance = (tolerance * force).max(noise / root);
        let beyond_noise = BEYOND_NOISE * self.scatter / root;
        let below = |p: &Point| self.intercept[p.side] + self.slope * p.displacement - p.force;
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        sums.extend(points.iter().map(|point| {
            sum += below(point);
            sum
        }));
        let pairs = sums.iter().zip(&sums[window..]);
        let means: Vec<f64> = pairs.map(|(a, b)| (b - a) / window as f64).collect();
        // The last window whose mean is below the line, and the line holds from its end on. Noise lifts one of many
        // windows: what counts goes on in the window before, or is beyond noise.
        let left = (0..means.len()).rev().find(|&index| {
            let before = index
                .checked_sub(window)
                .map_or(f64::INFINITY, |k| means[k]);
            means[index] > tolerance && (before > tolerance || means[index] > beyond_noise)
        });
        let Some(index) = left else {
            return Err(bad(
                "the data never leave the residual line: no stick in the loop",
            ));
        };
        let middle = points[index + window / 2].x;
        // Points of the last part that are below their own line are a bent end, not an onset.
        Ok(middle
            .max(points.first().map_or(onset, |p| p.x))
            .max(1e-3 * onset))
    }
}
