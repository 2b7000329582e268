//! The contact law: properties checked once; the friction form and the interface form.

use crate::backbone::Choice;
use crate::error::{Error, Kind};
use crate::limit::{Limit, Traction};
use crate::memory::{self, Increment, Matrix, Outcome, Vector};
use crate::number::{finite, within};
use crate::properties::{HIGHEST, Method, Properties};
use crate::state::{Contact, End, Header, Knot, Knots, Layout};

/// Where the host has no Lagrange multipliers, this factor on the critical slip stands for rigid stick.
pub const RIGID: f64 = 1e-3;
/// The longest slip increment, over the critical slip; fourth powers of it are still numbers.
const LONGEST: f64 = 1e60;
/// The largest number taken where its square must be one.
pub(crate) const SQUARED: f64 = 1e150;
/// An opening that the host does not know (its -1e36 in the other sign).
pub const UNKNOWN_OPENING: f64 = 1e36;
/// When the limit, or the critical slip, falls below these parts of what it was, nothing of the curve is left.
const LIMIT_LEFT: f64 = 1e-30;
const CRITICAL_LEFT: f64 = 1e-12;
/// A critical slip below this, a length, holds no curve: it is as if there were no limit.
const CRITICAL_LEAST: f64 = 1e-130;
/// Critical slips in which the memory curve counts as it is: fourth powers of lengths are numbers.
const ORDINARY: [f64; 2] = [1e-10, 1e10];
/// In one direction a knot that was worth less than this part of T is not missed, in two less than this.
const MISSED: [f64; 2] = [1e-14, 1e-3];

/// The law for N tangential directions (1 or 2). Immutable; share it between threads.
#[derive(Clone, Debug)]
pub struct Law<const N: usize> {
    properties: Properties,
    layout: Layout,
    backbone: Choice,
    limit: Limit,
    /// 1 / chi of the consistent rule, None for the proportional rule.
    growth: Option<f64>,
}

/// What the contact gives at the end of an increment, friction form. All per area.
#[derive(Clone, Debug, PartialEq)]
pub struct Response<const N: usize> {
    /// Friction traction, with the sign of the slip.
    pub traction: Vector<N>,
    /// d traction_i / d slip_j: consistent tangent, not symmetric in general.
    pub dtraction_dslip: Matrix<N>,
    /// d traction / d pressure at the end of the increment.
    pub dtraction_dpressure: Vector<N>,
    /// Elastic energy held by friction at the end.
    pub stored: f64,
    /// Energy dissipated in the increment.
    pub dissipated: f64,
    /// Change of the elastic slip: the deflection of the slip element that slips last.
    pub elastic_slip: Vector<N>,
    /// Where the contact stands.
    pub contact: Contact,
    /// True when a knot that mattered had to be forgotten because the state array is full.
    pub memory_full: bool,
}

/// What the contact gives at the end of an increment, interface form.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceResponse<const N: usize> {
    /// Normal traction, negative in compression.
    pub normal_traction: f64,
    /// d normal traction / d normal opening.
    pub normal_stiffness: f64,
    /// d tangential traction / d normal opening.
    pub dtraction_dopening: Vector<N>,
    /// Elastic energy of the normal spring, per area.
    pub normal_energy: f64,
    /// The tangential part.
    pub friction: Response<N>,
}

/// Where an increment starts: what the state holds, or a curve that takes its place.
pub(crate) struct Start<const N: usize> {
    pub header: Header,
    pub knots: Knots<N>,
}

impl<const N: usize> Start<N> {
    /// A place to read a state into.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Start {
            header: Header::default(),
            knots: Knots::new(),
        }
    }

    /// Deflection of the slip element that slips last; zero when there is no curve.
    #[inline(always)]
    pub(crate) fn last_deflection(&self) -> Vector<N> {
        last_deflection(&self.knots)
    }
}

#[inline(always)]
fn last_deflection<const N: usize>(knots: &Knots<N>) -> Vector<N> {
    knots.last().map_or(Vector::zeros(), |knot| knot.u.into())
}

impl<const N: usize> Law<N> {
    /// The law that PROPS name, for states of `nstate` numbers.
    ///
    /// # Errors
    /// Bad properties, an array too short for four knots, or N not 1 or 2.
    pub fn new(props: &[f64], nstate: usize) -> Result<Self, Error> {
        check_directions(N)?;
        let properties = Properties::new(props)?;
        let layout = Layout::new(N, nstate)?;
        let chi = match properties.method {
            Method::Memory => properties.exponent,
            Method::Penalty | Method::Lagrange => 1.0,
        };
        Ok(Law {
            layout,
            backbone: properties.backbone(),
            limit: Limit::new(&properties),
            growth: (properties.reference_pressure > 0.0).then_some(1.0 / chi),
            properties,
        })
    }

    /// The checked properties.
    pub fn properties(&self) -> &Properties {
        &self.properties
    }

    /// How the state array is divided.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The critical slip at the reference pressure used by [`Law::friction`]: rigid stick becomes a stiff penalty.
    ///
    /// # Errors
    /// gcr = 0 without a characteristic length (0: the host has none).
    pub fn critical_slip(&self, characteristic_length: f64) -> Result<f64, Error> {
        let gcr = self.properties.critical_slip(characteristic_length)?;
        Ok(match self.properties.method {
            Method::Lagrange => gcr * RIGID,
            Method::Memory | Method::Penalty => gcr,
        })
    }

    /// Stiffness of the sticking contact that closed under this pressure, traction per length; `gcr` as in [`Law::friction`].
    pub fn sticking_stiffness(&self, gcr: f64, pressure: f64) -> f64 {
        let limit = self.limit.at(pressure.max(0.0), 1.0, 0.0).limit;
        let critical = self.fresh_critical(gcr, limit);
        if pressure > 0.0 && critical > 0.0 {
            limit / critical * self.backbone.initial_slope()
        } else {
            0.0
        }
    }

    /// Friction form: the slip increment (length), the pressure at its end and the caller's factor on mu (1: none).
    ///
    /// `gcr` comes from [`Law::critical_slip`]. Reads `state0` (start of the increment), writes `state1` only on
    /// success; both hold `nstate` numbers.
    ///
    /// # Errors
    /// Numbers that are not finite, gcr <= 0, increments beyond 1e60 critical slips, pressures beyond 1e300, a corrupt state.
    #[inline]
    pub fn friction(
        &self,
        gcr: f64,
        slip_increment: &Vector<N>,
        pressure: f64,
        mu_factor: f64,
        state0: &[f64],
        state1: &mut [f64],
    ) -> Result<Response<N>, Error> {
        self.check_end(state1)?;
        let mut start = Start::new();
        let mut end = End::new();
        self.read(state0, &mut start)?;
        let response = self.friction_from(
            &mut start,
            gcr,
            slip_increment,
            pressure,
            mu_factor,
            &mut end,
        )?;
        self.layout.write(&end, state1);
        Ok(response)
    }

    /// Interface form: the total opening, normal (positive when open) and tangential (lengths).
    ///
    /// # Errors
    /// As [`Law::friction`]; kn = 0.
    #[inline]
    pub fn interface(
        &self,
        gcr: f64,
        normal: f64,
        tangential: &Vector<N>,
        mu_factor: f64,
        state0: &[f64],
        state1: &mut [f64],
    ) -> Result<InterfaceResponse<N>, Error> {
        self.check_end(state1)?;
        let mut start = Start::new();
        let mut end = End::new();
        self.read(state0, &mut start)?;
        let response =
            self.interface_from(&mut start, gcr, normal, tangential, mu_factor, &mut end)?;
        self.layout.write(&end, state1);
        Ok(response)
    }

    /// Reads and checks a state.
    #[inline(always)]
    pub(crate) fn read(&self, state0: &[f64], start: &mut Start<N>) -> Result<(), Error> {
        self.layout
            .read(state0, &mut start.header, &mut start.knots)
    }

    /// Refuses an end state of another length.
    #[inline(always)]
    pub(crate) fn check_end(&self, state1: &[f64]) -> Result<(), Error> {
        if state1.len() == self.layout.nstate {
            return Ok(());
        }
        let expected = format!("must have room for {} numbers", self.layout.nstate);
        Err(Error::about(Kind::BadState, "state1", expected).count(state1.len()))
    }

    /// G of a contact that closes under the limit T: gcr (T/T0)^(1/chi), or gcr.
    #[inline(always)]
    fn fresh_critical(&self, gcr: f64, limit: f64) -> f64 {
        let reference = self.limit.reference();
        match self.growth {
            Some(_) if limit == reference || reference == 0.0 => gcr,
            Some(power) => gcr * (limit / reference).powf(power),
            None => gcr,
        }
    }

    /// The limit traction of this increment.
    #[inline(always)]
    pub(crate) fn limit(&self, pressure: f64, mu_factor: f64, header: &Header) -> Traction {
        self.limit.at(pressure, mu_factor, header.slip_length)
    }

    /// [`Law::friction`] from a state that was read, to one not yet written.
    #[inline(always)]
    pub(crate) fn friction_from(
        &self,
        start: &mut Start<N>,
        gcr: f64,
        slip_increment: &Vector<N>,
        pressure: f64,
        mu_factor: f64,
        end: &mut End<N>,
    ) -> Result<Response<N>, Error> {
        check_critical_slip(gcr)?;
        check_pressure(pressure)?;
        check_factor(mu_factor)?;
        for (index, slip) in slip_increment.iter().enumerate() {
            check_within("slip_increment", index, *slip, SQUARED)?;
        }
        if pressure <= 0.0 {
            return self.open(start, end);
        }
        let limit = self.limit(pressure, mu_factor, &start.header);
        if start.header.pressure == 0.0 {
            // A fresh start: first the critical slip at the new pressure, then the slip.
            self.close(start, gcr, limit.limit);
        }
        self.advance(start, gcr, slip_increment, pressure, limit, end)
    }

    /// [`Law::interface`] from a state that was read, to one not yet written.
    #[inline(always)]
    pub(crate) fn interface_from(
        &self,
        start: &mut Start<N>,
        gcr: f64,
        normal: f64,
        tangential: &Vector<N>,
        mu_factor: f64,
        end: &mut End<N>,
    ) -> Result<InterfaceResponse<N>, Error> {
        let Properties {
            kn,
            gap0,
            normal_exponent: m,
            ..
        } = self.properties;
        check_critical_slip(gcr)?;
        check_factor(mu_factor)?;
        if kn <= 0.0 {
            let expected = "must be > 0: the interface form needs a normal stiffness";
            return Err(Error::about(Kind::BadProperty, "PROPS", expected)
                .index(6)
                .name("kn")
                .number(kn));
        }
        check_within("opening", 0, normal, SQUARED)?;
        let jump = start.header.jump;
        let mut increment = Vector::<N>::zeros();
        for (index, value) in tangential.iter().enumerate() {
            check_within("opening", 1 + index, *value, SQUARED)?;
            increment[index] = value - jump[index];
        }
        // The gap before and after; closed where it is negative.
        let before = start.header.opening + gap0;
        let unknown = start.header.opening >= UNKNOWN_OPENING;
        let after = normal + gap0;
        start.header.opening = normal;
        start.header.jump[..N].copy_from_slice(tangential.as_slice());
        if after >= 0.0 {
            let friction = self.open(start, end)?;
            return Ok(InterfaceResponse {
                // Not -0: an open point has no sign.
                normal_traction: 0.0,
                // A point that just touches is stiff already: a host's first iteration starts there.
                normal_stiffness: if after == 0.0 && m == 1.0 { kn } else { 0.0 },
                dtraction_dopening: Vector::zeros(),
                normal_energy: 0.0,
                friction,
            });
        }
        // p = kn (-gap)^m.
        let power = if m == 1.0 {
            1.0
        } else {
            (-after).powf(m - 1.0)
        };
        let (pressure, stiffness) = (kn * power * -after, m * kn * power);
        if !within(pressure, HIGHEST) || !within(stiffness * self.properties.mu.max(1.0), HIGHEST) {
            let expected = "must be such that the pressure and mu times the normal stiffness that follow are no larger than 1e300";
            return Err(Error::about(Kind::BadInput, "opening", expected)
                .index(0)
                .number(normal));
        }
        let limit = self.limit(pressure, mu_factor, &start.header);
        // The part of the step in which the contact is closed, and how it changes with the opening.
        let (mut part, mut part_slope) = (1.0, 0.0);
        if unknown {
            start.header.pressure = 0.0;
            self.close(start, gcr, limit.limit);
        } else if before < 0.0 {
            if start.header.pressure == 0.0 {
                // Closed from the first: an interference.
                let first = if m == 1.0 {
                    kn * -before
                } else {
                    kn * (-before).powf(m)
                };
                let first = first.min(HIGHEST);
                let limit = self.limit(first, mu_factor, &start.header).limit;
                self.close(start, gcr, limit);
                start.header.pressure = first;
            }
        } else {
            // It closes within the step: from the limit without pressure, straight in slip and critical slip.
            let travel = before - after;
            (part, part_slope) = (-after / travel, -before / (travel * travel));
            let limit = match self.growth {
                Some(_) => self.limit(0.0, mu_factor, &start.header).limit,
                None => limit.limit,
            };
            self.close(start, gcr, limit);
        }
        let mut friction = self.advance(start, gcr, &(increment * part), pressure, limit, end)?;
        let by_opening = friction.dtraction_dpressure * -stiffness
            + friction.dtraction_dslip * increment * part_slope;
        friction.dtraction_dslip *= part;
        let normal_energy = pressure * -after / (m + 1.0);
        if !(finite(normal_energy) && finite(by_opening.sum())) {
            return Err(not_a_result(pressure, &increment));
        }
        Ok(InterfaceResponse {
            normal_traction: -pressure,
            normal_stiffness: stiffness,
            dtraction_dopening: by_opening,
            normal_energy,
            friction,
        })
    }

    /// The traction is gone, and with it the energy it held.
    #[cold]
    fn open(&self, start: &Start<N>, end: &mut End<N>) -> Result<Response<N>, Error> {
        let old = start.header;
        end.header = Header {
            dissipated: old.dissipated + old.stored,
            slip_length: old.slip_length,
            opening: old.opening,
            jump: old.jump,
            ..Header::default()
        };
        end.knots.clear();
        if !finite(end.header.dissipated) {
            return Err(not_a_result(0.0, &Vector::<N>::zeros()));
        }
        Ok(Response {
            traction: Vector::zeros(),
            dtraction_dslip: Matrix::zeros(),
            dtraction_dpressure: Vector::zeros(),
            stored: 0.0,
            dissipated: old.stored,
            elastic_slip: -start.last_deflection(),
            contact: Contact::Open,
            memory_full: false,
        })
    }

    /// A contact that closes under the limit T: all slip elements without deflection.
    #[inline(always)]
    fn close(&self, start: &mut Start<N>, gcr: f64, limit: f64) {
        start.knots.clear();
        start.header.limit = limit;
        let critical = self.fresh_critical(gcr, limit);
        if limit > 0.0 || self.growth.is_none() {
            start.knots.push(Knot {
                r: critical,
                u: [0.0; N],
            });
        }
    }

    /// A closed contact goes on: the critical slip that follows from the limit, the memory curve, the physical units.
    // Not inlined: one copy per number of directions, not one per face.
    #[inline(never)]
    fn advance(
        &self,
        start: &mut Start<N>,
        gcr: f64,
        slip_increment: &Vector<N>,
        pressure: f64,
        limit: Traction,
        end: &mut End<N>,
    ) -> Result<Response<N>, Error> {
        let (strength, old_strength) = (limit.limit, start.header.limit);
        let deflection = start.last_deflection();
        let before = start.knots.last().map_or(0.0, |knot| knot.r);
        // G before and after, and what psi loses besides slip.
        let (mut from, mut to, mut lost) = (before, before, 0.0);
        let same = match self.growth {
            None => strength == old_strength && before == gcr,
            Some(_) => strength == old_strength && before >= CRITICAL_LEAST,
        };
        if !same {
            (from, to, lost) = self.grow(start, gcr, strength);
            if to == 0.0 {
                return self.without_limit(start, slip_increment, pressure, limit, end);
            }
        }
        if !within(to, SQUARED) || !within(strength, HIGHEST) {
            return Err(not_a_result(pressure, slip_increment));
        }
        let length = slip_increment.norm();
        if length * (1.0 / LONGEST) > to {
            return Err(too_long(slip_increment, to));
        }
        // A slip whose square is none has no direction.
        let mut increment = Increment {
            slip: if length > 0.0 {
                *slip_increment
            } else {
                Vector::zeros()
            },
            before: from,
            critical: to,
            limit_ratio: if from == to {
                1.0
            } else {
                old_strength / strength
            },
            room: self.layout.knots,
            resolution: self.properties.resolution,
            forgotten: start.header.forgotten,
        };
        let mut unit = 1.0;
        if !(ORDINARY[0]..=ORDINARY[1]).contains(&to) {
            // In a unit of length in which G is about 1; a power of two, so that nothing is rounded.
            unit = power_of_two_near(to);
            scale(&mut start.knots, 1.0 / unit);
            increment.slip /= unit;
            increment.before /= unit;
            increment.critical /= unit;
            if increment.slip.amax() < 1e-140 {
                increment.slip.fill(0.0);
            }
        }
        let nothing = same && slip_increment.iter().all(|d| *d == 0.0);
        let copy = if nothing {
            Some(start.knots.clone())
        } else {
            None
        };
        let mut outcome = Outcome::new();
        match &self.backbone {
            Choice::FiveHalves(curve) => {
                memory::step(
                    curve,
                    &mut start.knots,
                    &mut increment,
                    &mut end.knots,
                    &mut outcome,
                );
            }
            Choice::PowerLaw(curve) => {
                memory::step(
                    curve,
                    &mut start.knots,
                    &mut increment,
                    &mut end.knots,
                    &mut outcome,
                );
            }
            Choice::Segalman(curve) => {
                memory::step(
                    curve,
                    &mut start.knots,
                    &mut increment,
                    &mut end.knots,
                    &mut outcome,
                );
            }
        }
        let old = &start.header;
        let energy = strength * unit;
        let mut stored = (outcome.stored * energy).max(0.0);
        if let Some(copy) = copy {
            // Not a bit changes.
            end.knots = copy;
            stored = old.stored;
            outcome.forgotten = old.forgotten;
            if old.contact != Contact::Open {
                outcome.contact = old.contact;
            }
        }
        if unit != 1.0 {
            scale(&mut end.knots, unit);
        }
        let by_pressure = match self.growth {
            // dG/dT = G / (chi T)
            Some(power) => outcome.by_growth * (limit.slope * increment.critical * power),
            None => outcome.traction * limit.slope,
        };
        let response = Response {
            traction: outcome.traction * strength,
            dtraction_dslip: outcome.by_slip * (strength / unit),
            dtraction_dpressure: by_pressure,
            stored,
            dissipated: outcome.dissipated * energy + lost,
            elastic_slip: last_deflection(&end.knots) - deflection,
            contact: outcome.contact,
            memory_full: !nothing && outcome.forgotten > MISSED[N - 1],
        };
        end.header = Header {
            contact: response.contact,
            pressure,
            limit: strength,
            stored,
            dissipated: old.dissipated + response.dissipated,
            slip_length: old.slip_length + length,
            opening: old.opening,
            jump: old.jump,
            forgotten: if N == 1 { 0.0 } else { outcome.forgotten },
        };
        // Huge but finite inputs may overflow in a product; nothing infinite may leave.
        let sum = response.traction.sum()
            + response.dtraction_dslip.sum()
            + response.dtraction_dpressure.sum()
            + end.header.stored
            + end.header.dissipated
            + end.header.slip_length;
        if !finite(sum) {
            return Err(not_a_result(pressure, slip_increment));
        }
        Ok(response)
    }

    /// What a changed limit, or another gcr under the proportional rule, makes of the curve: G before and after, and what psi
    /// loses besides slip. G = 0 after: there is no limit.
    #[inline(never)]
    fn grow(&self, start: &mut Start<N>, gcr: f64, limit: f64) -> (f64, f64, f64) {
        let Start { header: old, knots } = start;
        let before = knots.last().map_or(0.0, |knot| knot.r);
        let Some(power) = self.growth else {
            if before == 0.0 {
                knots.push(Knot {
                    r: gcr,
                    u: [0.0; N],
                });
                return (gcr, gcr, 0.0);
            }
            if before != gcr {
                // The host changed gcr, or the state comes from elsewhere: the curve scales with it.
                scale(knots, gcr / before);
                knots.last_mut().expect("a curve").r = gcr;
            }
            let lost = if old.stored > 0.0 {
                old.stored * (1.0 - limit / old.limit.max(f64::MIN_POSITIVE) * (gcr / before))
            } else {
                0.0
            };
            return (gcr, gcr, lost);
        };
        // Bounded: what follows from a larger one is not used.
        let ratio = limit / old.limit.max(LIMIT_LEFT * limit).max(f64::MIN_POSITIVE);
        let mut critical = before;
        if limit != old.limit {
            critical = before * ratio.powf(power);
        }
        let (mut from, mut lost) = (before, 0.0);
        if before < CRITICAL_LEFT * critical || old.limit < LIMIT_LEFT * limit || before == 0.0 {
            // Nothing that matters is left of the curve: it grows from the apex.
            critical = self.fresh_critical(gcr, limit);
            (from, lost) = (0.0, old.stored);
            knots.clear();
        }
        let gone = limit < LIMIT_LEFT * old.limit || critical < CRITICAL_LEFT * before;
        if gone || limit == 0.0 || critical < CRITICAL_LEAST {
            critical = 0.0;
        }
        (from, critical, lost)
    }

    /// Closed, but without any limit (consistent rule): no traction, and what was stored is dissipated.
    #[cold]
    fn without_limit(
        &self,
        start: &Start<N>,
        slip_increment: &Vector<N>,
        pressure: f64,
        limit: Traction,
        end: &mut End<N>,
    ) -> Result<Response<N>, Error> {
        let old = start.header;
        let response = Response {
            contact: Contact::GrossSlip,
            ..self.open(start, end)?
        };
        end.header.contact = Contact::GrossSlip;
        end.header.pressure = pressure;
        end.header.limit = limit.limit;
        end.header.slip_length = old.slip_length + slip_increment.norm();
        if !finite(end.header.slip_length) {
            return Err(not_a_result(pressure, slip_increment));
        }
        Ok(response)
    }
}

/// The default length of the state array for properties and directions that are valid.
///
/// # Errors
/// Bad properties, or `ndir` not 1 or 2.
pub fn default_state_size(props: &[f64], ndir: usize) -> Result<usize, Error> {
    check_directions(ndir)?;
    Properties::new(props)?;
    Ok(Layout::default_size(ndir))
}

pub(crate) fn check_directions(ndir: usize) -> Result<(), Error> {
    if ndir == 1 || ndir == 2 {
        return Ok(());
    }
    Err(Error::about(
        Kind::BadInput,
        "ndir",
        "must be 1 or 2 tangential directions",
    )
    .count(ndir))
}

fn scale<const N: usize>(knots: &mut Knots<N>, factor: f64) {
    for knot in knots {
        knot.r *= factor;
        knot.u.iter_mut().for_each(|u| *u *= factor);
    }
}

/// 2^k with 1 <= length / 2^k < 2.
#[inline(always)]
fn power_of_two_near(length: f64) -> f64 {
    f64::from_bits(length.to_bits() & (0x7ff << 52))
}

/// Refuses a critical slip that did not come from [`Law::critical_slip`].
#[inline]
fn check_critical_slip(gcr: f64) -> Result<(), Error> {
    if within(gcr, SQUARED) && gcr >= RIGID * 1e-100 {
        return Ok(());
    }
    let expected = "must be a length from 1e-103 to 1e150";
    Err(Error::about(Kind::BadInput, "gcr", expected).number(gcr))
}

#[inline(always)]
pub(crate) fn check_pressure(pressure: f64) -> Result<(), Error> {
    if within(pressure, HIGHEST) {
        return Ok(());
    }
    let expected = "must be finite and no larger than 1e300";
    Err(Error::about(Kind::BadInput, "pressure", expected).number(pressure))
}

#[inline(always)]
pub(crate) fn check_factor(factor: f64) -> Result<(), Error> {
    if within(factor, SQUARED) && factor >= 0.0 {
        return Ok(());
    }
    let expected = "must be from 0 to 1e150";
    Err(Error::about(Kind::BadInput, "mu_factor", expected).number(factor))
}

/// Refuses number `index` of an argument beyond `limit`.
#[inline(always)]
pub(crate) fn check_within(
    argument: &'static str,
    index: usize,
    value: f64,
    limit: f64,
) -> Result<(), Error> {
    if within(value, limit) {
        return Ok(());
    }
    Err(too_large(argument, index, value, limit))
}

#[cold]
fn too_large(argument: &'static str, index: usize, value: f64, limit: f64) -> Error {
    let expected = format!("must be finite and no larger than {limit:e}");
    Error::about(Kind::BadInput, argument, expected)
        .index(index)
        .number(value)
}

#[cold]
fn too_long<const N: usize>(slip_increment: &Vector<N>, critical: f64) -> Error {
    let index = slip_increment.iamax();
    let expected =
        format!("must be a slip of no more than {LONGEST:e} critical slips ({critical:?})");
    Error::about(Kind::BadInput, "slip_increment", expected)
        .index(index)
        .number(slip_increment[index])
}

/// The refusal of inputs that are finite while what follows from them is not.
#[cold]
pub(crate) fn not_a_result<const N: usize>(pressure: f64, slip_increment: &Vector<N>) -> Error {
    let expected = format!(
        "with the slip increment {:?} the result would not be a finite number",
        slip_increment.as_slice()
    );
    Error::about(Kind::BadInput, "pressure", expected).number(pressure)
}
