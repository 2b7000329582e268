//! Points that share one rigid tangential motion, behind a spring.
//!
//! The common slip g follows from r(g) = K (g - u) + sum of A_i tau_i(g) = 0 with the displacement u prescribed beyond the
//! spring: Newton with the law's consistent tangent, halving the way where the residual does not fall, halving the step
//! where that does not help. Every trial starts from the states of the last accepted step.

use super::{Common, Replay, Springs, check_sign};
use crate::loops::limit;
use crate::pictures::Replayed;
use crate::table::{Gaps, Rows, Table, check_time, csv_line};
use anyhow::{Result, anyhow, bail};
use mepc::state::Contact;
use mepc::{Law, Matrix, Vector};
use std::path::Path;

const MAX_ITERATIONS: usize = 50;
const MAX_BACKTRACKS: usize = 30;
const MAX_HALVINGS: u32 = 12;
/// A residual below this part of the forces at hand is rounding of the sums.
const TOLERANCE: f64 = 1e-13;

/// The contact points of a patch.
pub struct Points {
    /// Place of each point.
    pub x: Vec<f64>,
    /// Place of each point.
    pub y: Vec<f64>,
    /// Area of each point.
    pub area: Vec<f64>,
    /// Pressure at scale 1.
    pub pressure: Vec<f64>,
    /// Where they were read, for messages.
    pub places: Option<Rows>,
}

/// What is prescribed at the end of a step.
#[derive(Clone, Copy, PartialEq)]
pub struct Motion<const N: usize> {
    /// Beyond the series spring.
    pub displacement: Vector<N>,
    /// Small, about the origin.
    pub rotation: f64,
    /// Multiplies the pressures of the patch.
    pub pressure_scale: f64,
}

impl<const N: usize> Motion<N> {
    fn between(&self, target: &Self, part: f64) -> Self {
        let mix = |from: f64, to: f64| from + part * (to - from);
        Motion {
            displacement: self.displacement.zip_map(&target.displacement, mix),
            rotation: mix(self.rotation, target.rotation),
            pressure_scale: mix(self.pressure_scale, target.pressure_scale),
        }
    }
}

/// Sums over the points of a trial step.
struct Trial<const N: usize> {
    slip: Vector<N>,
    states: Vec<f64>,
    force: Vector<N>,
    stiffness: Matrix<N>,
    moment: f64,
    stored: f64,
    dissipated: f64,
    forgotten: usize,
    /// Friction limit of all points.
    limit: f64,
}

/// A patch in motion.
pub struct Patch<'a, const N: usize> {
    law: &'a Law<N>,
    gcr: f64,
    points: &'a Points,
    springs: Springs,
    /// Of the last accepted step.
    pub at: Motion<N>,
    /// Slip common to all points.
    pub slip: Vector<N>,
    /// Contact force.
    pub force: Vector<N>,
    /// Moment of the contact force about the origin.
    pub moment: f64,
    /// Elastic energy of the contact.
    pub stored: f64,
    /// Dissipated since the start.
    pub dissipated: f64,
    /// Updates that had to forget a reversal.
    pub forgotten: usize,
    states: Vec<f64>,
}

impl<'a, const N: usize> Patch<'a, N> {
    /// A virgin patch.
    ///
    /// # Errors
    /// A law without a critical slip.
    pub fn new(law: &'a Law<N>, points: &'a Points, springs: Springs) -> Result<Self> {
        let gcr = law
            .critical_slip(0.0)
            .map_err(|error| anyhow!("--props: {error}"))?;
        Ok(Patch {
            law,
            gcr,
            points,
            springs,
            at: Motion {
                displacement: Vector::zeros(),
                rotation: 0.0,
                pressure_scale: 0.0,
            },
            slip: Vector::zeros(),
            force: Vector::zeros(),
            moment: 0.0,
            stored: 0.0,
            dissipated: 0.0,
            forgotten: 0,
            states: vec![0.0; points.x.len() * law.layout().nstate],
        })
    }

    /// The force with the parallel spring.
    pub fn total_force(&self) -> Vector<N> {
        self.force + self.at.displacement * self.springs.parallel
    }

    /// How many points are open, stick, in micro-slip, in gross slip.
    pub fn counts(&self) -> [usize; 4] {
        let mut counts = [0; 4];
        for state in self.states.chunks(self.law.layout().nstate) {
            for kind in [
                Contact::Open,
                Contact::Stick,
                Contact::MicroSlip,
                Contact::GrossSlip,
            ] {
                counts[kind as usize] += usize::from(state[0] == f64::from(kind as u8));
            }
        }
        counts
    }

    /// Moves the patch to `target`; the number of Newton corrections that it took.
    ///
    /// # Errors
    /// No equilibrium, or a refused update.
    pub fn advance(&mut self, target: &Motion<N>) -> Result<usize> {
        let Some(series) = self.springs.series else {
            let trial = self.try_slip(target, target.displacement - self.slip)?;
            self.accept(target, trial);
            return Ok(0);
        };
        let start = self.at;
        let (mut iterations, mut halvings, mut done) = (0, 0, 0.0);
        while done < 1.0 {
            let end = done + 0.5f64.powi(halvings as i32);
            let goal = if end < 1.0 {
                start.between(target, end)
            } else {
                *target
            };
            if let Some(trial) = self.equilibrium(&goal, series, &mut iterations)? {
                self.accept(&goal, trial);
                done = end;
            } else {
                halvings += 1;
                if halvings > MAX_HALVINGS {
                    bail!(
                        "no equilibrium: Newton does not converge, not even for 1/{} of the step",
                        1u64 << MAX_HALVINGS
                    );
                }
            }
        }
        Ok(iterations)
    }

    fn accept(&mut self, target: &Motion<N>, trial: Trial<N>) {
        self.at = *target;
        self.slip += trial.slip;
        self.force = trial.force;
        self.moment = trial.moment;
        self.stored = trial.stored;
        self.dissipated += trial.dissipated;
        self.forgotten += trial.forgotten;
        self.states = trial.states;
    }

    /// Tries the common slip increment `slip` on the way to `target`, and sums up.
    fn try_slip(&self, target: &Motion<N>, slip: Vector<N>) -> Result<Trial<N>> {
        let turn = target.rotation - self.at.rotation;
        let nstate = self.law.layout().nstate;
        let mut trial = Trial {
            slip,
            states: vec![0.0; self.states.len()],
            force: Vector::zeros(),
            stiffness: Matrix::zeros(),
            moment: 0.0,
            stored: 0.0,
            dissipated: 0.0,
            forgotten: 0,
            limit: 0.0,
        };
        let states = self
            .states
            .chunks(nstate)
            .zip(trial.states.chunks_mut(nstate));
        for (i, (state0, state1)) in states.enumerate() {
            let (x, y) = (self.points.x[i], self.points.y[i]);
            let area = self.points.area[i];
            let mut increment = slip;
            increment[0] -= turn * y;
            if N == 2 {
                increment[1] += turn * x;
            }
            let pressure = target.pressure_scale * self.points.pressure[i];
            let response = self
                .law
                .friction(self.gcr, &increment, pressure, 1.0, state0, state1)
                .map_err(|error| match &self.points.places {
                    Some(rows) => anyhow!("point at {}: {error}", rows.place(i)),
                    None => anyhow!("{error}"),
                })?;
            trial.force += response.traction * area;
            trial.stiffness += response.dtraction_dslip * area;
            if N == 2 {
                trial.moment += area * (x * response.traction[1] - y * response.traction[0]);
            }
            trial.stored += area * response.stored;
            trial.dissipated += area * response.dissipated;
            trial.forgotten += usize::from(response.memory_full);
            trial.limit += area * limit(self.law.properties(), pressure.max(0.0));
        }
        Ok(trial)
    }

    /// The trial step in equilibrium with the spring; None if Newton does not get there.
    fn equilibrium(
        &self,
        target: &Motion<N>,
        series: f64,
        iterations: &mut usize,
    ) -> Result<Option<Trial<N>>> {
        let residual = |trial: &Trial<N>| {
            (self.slip + trial.slip - target.displacement) * series + trial.force
        };
        let newton = |trial: &Trial<N>| -> Option<Vector<N>> {
            let jacobian = trial.stiffness + Matrix::identity() * series;
            // A 2 x 2 inverse in closed form; one direction is a division.
            let inverse = if N == 1 {
                Matrix::from_element(1.0 / jacobian[(0, 0)])
            } else {
                let (a, b, c, d) = (
                    jacobian[(0, 0)],
                    jacobian[(0, N - 1)],
                    jacobian[(N - 1, 0)],
                    jacobian[(N - 1, N - 1)],
                );
                Matrix::from_row_slice(&[d, -b, -c, a][..N * N]) / (a * d - b * c)
            };
            let direction = -(inverse * residual(trial));
            direction.iter().all(|v| v.is_finite()).then_some(direction)
        };
        let mut trial = self.try_slip(target, Vector::zeros())?;
        let mut length = residual(&trial).norm();
        let reach = self.slip.norm().max(target.displacement.norm());
        let tolerance = TOLERANCE * (trial.limit + series * reach);
        if !length.is_finite() {
            return Ok(None);
        }
        if length <= tolerance {
            return Ok(Some(trial)); // nothing moves: rounding must not count as a slip
        }
        let mut count = 0;
        while length > tolerance {
            let Some(direction) = newton(&trial).filter(|_| count < MAX_ITERATIONS) else {
                return Ok(None);
            };
            let mut way = 1.0;
            let mut backtracks = 0;
            loop {
                let next = self.try_slip(target, trial.slip + direction * way)?;
                let next_length = residual(&next).norm();
                if next_length < length {
                    (trial, length) = (next, next_length);
                    break;
                }
                way *= 0.5;
                backtracks += 1;
                if backtracks == MAX_BACKTRACKS {
                    return Ok(None);
                }
            }
            count += 1;
            *iterations += 1;
        }
        // One more correction takes the last digits, unless it only adds rounding.
        if let Some(direction) = newton(&trial) {
            let next = self.try_slip(target, trial.slip + direction)?;
            if residual(&next).norm() <= length {
                trial = next;
            }
        }
        Ok(Some(trial))
    }
}

/// Replays the history.
///
/// # Errors
/// Bad input, or no equilibrium.
pub fn run(patch: &Path, history: &Path, common: &Common, springs: Springs) -> Result<Replay> {
    let history = Table::open(history)?;
    if history.has("displacement_2")? {
        replay::<2>(patch, history, common, springs)
    } else {
        if history.has("rotation")? {
            bail!(
                "{}: column displacement_2: missing in the header, rotation needs two directions",
                history.header_place()
            );
        }
        replay::<1>(patch, history, common, springs)
    }
}

fn read_points(file: &Path) -> Result<Points> {
    let table = Table::open(file)?;
    let columns = ["x", "y", "area", "pressure"].map(|name| table.find(name, ""));
    let columns: Vec<usize> = columns.into_iter().collect::<Result<_>>()?;
    table.note_unused(&columns);
    let mut rows = table.read(&columns, Gaps::Refused, "")?;
    let area = &rows.columns[2];
    if let Some(row) = area.iter().position(|area| *area < 0.0) {
        bail!(
            "{}: column area: {} is negative",
            rows.place(row),
            area[row]
        );
    }
    let [x, y, area, pressure] = [0, 1, 2, 3].map(|k| std::mem::take(&mut rows.columns[k]));
    Ok(Points {
        x,
        y,
        area,
        pressure,
        places: Some(rows),
    })
}

fn replay<const N: usize>(
    patch: &Path,
    history: Table,
    common: &Common,
    springs: Springs,
) -> Result<Replay> {
    let mut columns = vec![history.find("time", "")?];
    for direction in 1..=N {
        columns.push(history.find(&format!("displacement_{direction}"), "")?);
    }
    let mut optional = |name: &str| -> Result<Option<usize>> {
        if !history.has(name)? {
            return Ok(None);
        }
        columns.push(history.find(name, "")?);
        Ok(Some(columns.len() - 1))
    };
    let (rotation, scale) = (optional("rotation")?, optional("pressure_scale")?);
    history.note_unused(&columns);
    let rows = history.read(&columns, Gaps::Refused, "")?;
    let (time, displacements) = (&rows.columns[0], &rows.columns[1..=N]);
    let [rotation, scale] = [rotation, scale].map(|k| k.map(|k| &rows.columns[k]));
    check_time(time, &rows)?;
    let law = common.law::<N>()?;
    let points = read_points(patch)?;
    let column = format!("{}: column pressure", patch.display());
    check_sign(points.pressure.iter().copied(), &column)?;
    let mut drawn = Replayed::new("displacement (mm)", "force (N)", "energy (N.mm)", N);
    let mut patch = Patch::new(&law, &points, springs)?;

    let numbered = |name: &str| -> String { (1..=N).map(|k| format!(",{name}_{k}")).collect() };
    let if_turning = |name: &'static str| if rotation.is_some() { name } else { "" };
    let mut text = format!(
        "time{}{}{}{}{},stored_energy,dissipated_energy,open,stick,micro_slip,gross_slip,iterations\n",
        numbered("displacement"),
        if_turning(",rotation"),
        numbered("slip"),
        numbered("force"),
        if_turning(",moment"),
    );
    for row in 0..rows.len() {
        let target = Motion {
            displacement: Vector::<N>::from_fn(|direction, _| displacements[direction][row]),
            rotation: rotation.as_ref().map_or(0.0, |r| r[row]),
            pressure_scale: scale.as_ref().map_or(1.0, |s| s[row]),
        };
        let iterations = patch
            .advance(&target)
            .map_err(|error| anyhow!("{}: step {}: {error}", rows.place(row), row + 1))?;
        let mut values = vec![time[row]];
        values.extend(target.displacement.iter());
        values.extend(rotation.as_ref().map(|r| r[row]));
        values.extend(patch.slip.iter());
        values.extend(patch.total_force().iter());
        values.extend(rotation.as_ref().map(|_| patch.moment));
        values.extend([patch.stored, patch.dissipated]);
        values.extend(patch.counts().map(|count| count as f64));
        values.push(iterations as f64);
        if !values.iter().all(|value| value.is_finite()) {
            bail!(
                "{}: step {}: the result is not a finite number",
                rows.place(row),
                row + 1
            );
        }
        text += &csv_line(&values);
        let force = patch.total_force();
        let places = (0..N).map(|k| [target.displacement[k], force[k]]);
        drawn.push(time[row], places, [patch.stored, patch.dissipated]);
    }
    Ok(Replay {
        text,
        forgotten: patch.forgotten,
        drawn,
    })
}
