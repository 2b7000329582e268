//! The contact law: properties and a grid, made once and never changed; the friction and the interface form.

use crate::backbone::Choice;
use crate::error::{Error, Kind, Number};
use crate::memory::{Curve, Grid, Increment, Matrix, Vector, length};
use crate::properties::{Method, PressureRule, Properties};
use crate::state::{Contact, Header, Layout};
use std::fmt::Display;

/// Where the host has no Lagrange multipliers, this factor on the critical slip stands for rigid stick.
pub const RIGID: f64 = 1e-3;
/// The largest mu kn of the interface form: what follows from it is still a number.
const STIFFEST: f64 = 1e300;
/// The largest pressure taken, for the same reason.
const HIGHEST: f64 = 1e300;
/// The largest number taken where its square must be one.
pub(crate) const SQUARED: f64 = 1e150;
/// The longest slip increment taken, in critical slips; its square is still a number.
const LONGEST: f64 = 1e100;

/// The law for N tangential directions (1 or 2). Immutable; share it between threads.
#[derive(Clone, Debug)]
pub struct Law<const N: usize> {
    properties: Properties,
    layout: Layout,
    backbone: Choice,
    grid: Grid<N>,
    /// The smallest gap taken in the interface form: its pressure is the highest.
    deepest: f64,
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
    /// Elastic energy held at the end.
    pub stored: f64,
    /// Energy dissipated in the increment: by slip, and by the pressure change.
    pub dissipated: f64,
    /// Where the contact stands.
    pub contact: Contact,
    /// True when a reversal had to be forgotten because the state array is full.
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
    /// The tangential part.
    pub friction: Response<N>,
}

impl<const N: usize> Law<N> {
    /// The law that PROPS name, for states of `nstate` numbers.
    ///
    /// # Errors
    /// Bad properties, an array too short for two floating knots, or N not 1 or 2.
    pub fn new(props: &[f64], nstate: usize) -> Result<Self, Error> {
        check_directions(N)?;
        let properties = Properties::new(props)?;
        let layout = Layout::new(N, base_knots(&properties, N), nstate)?;
        let backbone = properties.backbone();
        let grid = match &backbone {
            Choice::PowerLaw(curve) => Grid::new(curve, layout.base),
            Choice::Segalman(curve) => Grid::new(curve, layout.base),
        };
        Ok(Law {
            deepest: -HIGHEST / properties.kn.max(1.0),
            properties,
            layout,
            backbone,
            grid,
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

    pub(crate) fn grid(&self) -> &Grid<N> {
        &self.grid
    }

    /// The critical slip used by [`Law::friction`]: rigid stick becomes a stiff penalty.
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

    /// Stiffness of the sticking contact, pressure per length, for the critical slip `gcr`.
    pub fn sticking_stiffness(&self, gcr: f64, pressure: f64) -> f64 {
        self.properties.mu * pressure.max(0.0) / gcr * self.grid.initial_slope()
    }

    /// Friction form: the slip increment (length) and the pressure at its end.
    ///
    /// `gcr` comes from [`Law::critical_slip`]. Reads `state0` (start of the increment), writes `state1` only on
    /// success; both hold `nstate` numbers.
    ///
    /// # Errors
    /// Numbers that are not finite, gcr <= 0, increments beyond 1e100 critical slips, pressures beyond 1e300, a corrupt state.
    #[inline]
    pub fn friction(
        &self,
        gcr: f64,
        slip_increment: &Vector<N>,
        pressure: f64,
        state0: &[f64],
        state1: &mut [f64],
    ) -> Result<Response<N>, Error> {
        check_critical_slip(gcr)?;
        let mut memory = Curve::new();
        let header = self.read(state0, &mut memory)?;
        self.friction_from(header, &mut memory, gcr, slip_increment, pressure, state1)
    }

    /// Refuses an end state of another length.
    #[inline(always)]
    pub(crate) fn check_end(&self, state1: &[f64]) -> Result<(), Error> {
        if state1.len() == self.layout.nstate {
            return Ok(());
        }
        Err(Error::new(
            Kind::BadState,
            format!(
                "state1 has {} numbers, not {}",
                state1.len(),
                self.layout.nstate
            ),
        ))
    }

    /// Deflection of the last slip element, r = 1, over gcr.
    #[inline(always)]
    pub(crate) fn last_deflection(&self, memory: &Curve<N>) -> Vector<N> {
        Vector::from(memory.base()[self.layout.base - 1])
    }

    /// Reads and checks a state; its memory goes to `memory`, empty before.
    #[inline(always)]
    pub(crate) fn read(&self, state0: &[f64], memory: &mut Curve<N>) -> Result<Header, Error> {
        self.layout.read(state0, &self.grid, memory)
    }

    /// Interface form: the total opening, normal (positive when open) and tangential (lengths).
    ///
    /// # Errors
    /// As [`Law::friction`]; kn = 0, or mu kn beyond 1e300.
    #[inline]
    pub fn interface(
        &self,
        gcr: f64,
        normal: f64,
        tangential: &Vector<N>,
        state0: &[f64],
        state1: &mut [f64],
    ) -> Result<InterfaceResponse<N>, Error> {
        check_critical_slip(gcr)?;
        let mut memory = Curve::new();
        let header = self.read(state0, &mut memory)?;
        self.interface_from(header, &mut memory, gcr, normal, tangential, state1)
    }

    /// [`Law::interface`] from a state that was read.
    #[inline]
    pub(crate) fn interface_from(
        &self,
        mut header: Header,
        memory: &mut Curve<N>,
        gcr: f64,
        normal: f64,
        tangential: &Vector<N>,
        state1: &mut [f64],
    ) -> Result<InterfaceResponse<N>, Error> {
        let Properties { mu, kn, gap0, .. } = self.properties;
        // The friction of the normal stiffness stands in the tangent: it must be a number, too.
        if kn <= 0.0 || kn * mu > STIFFEST {
            return Err(Error::new(
                Kind::BadProperty,
                format!(
                    "PROPS(7) kn = {kn:?}: the interface form needs a normal stiffness > 0, and mu kn no larger than {STIFFEST:e}"
                ),
            ));
        }
        let gap = normal + gap0;
        if !within(normal, HIGHEST) || gap < self.deepest {
            return Err(too_deep(normal));
        }
        let pressure = kn * (-gap).max(0.0);
        let increment = tangential - Vector::from_column_slice(&header.jump[..N]);
        for index in 0..N {
            check_length(
                "opening",
                1 + index,
                tangential[index],
                increment[index],
                gcr,
            )?;
        }
        header.jump[..N].copy_from_slice(tangential.as_slice());
        let friction = self.friction_from(header, memory, gcr, &increment, pressure, state1)?;
        // A point that just touches is stiff already: a host's first iteration starts there.
        let stiffness = if gap <= 0.0 { kn } else { 0.0 };
        Ok(InterfaceResponse {
            // Not -pressure: an open point has no sign.
            normal_traction: 0.0 - pressure,
            normal_stiffness: stiffness,
            dtraction_dopening: friction.dtraction_dpressure * -stiffness,
            friction,
        })
    }

    /// [`Law::friction`] from a state that was read: the pressure rule, the memory curve, the physical units.
    #[inline(always)]
    pub(crate) fn friction_from(
        &self,
        old: Header,
        memory: &mut Curve<N>,
        gcr: f64,
        slip_increment: &Vector<N>,
        pressure: f64,
        state1: &mut [f64],
    ) -> Result<Response<N>, Error> {
        self.check_end(state1)?;
        check_pressure(pressure)?;
        for (index, slip) in slip_increment.iter().enumerate() {
            check_length("slip_increment", index, *slip, *slip, gcr)?;
        }
        let d = slip_increment / gcr;
        let mut header = old;
        if pressure <= 0.0 {
            // Opening: the traction is gone, and with it the energy it held.
            header.contact = Contact::Open;
            header.pressure = 0.0;
            header.stored = 0.0;
            header.dissipated += old.stored;
            check_finite(&"accumulated dissipation", header.dissipated)?;
            self.layout.write::<N>(&header, None, state1);
            return Ok(Response {
                traction: Vector::zeros(),
                dtraction_dslip: Matrix::zeros(),
                dtraction_dpressure: Vector::zeros(),
                stored: 0.0,
                dissipated: old.stored,
                contact: Contact::Open,
                memory_full: false,
            });
        }
        let unloaded =
            self.properties.pressure_rule == PressureRule::Dissipative && pressure > old.pressure;
        let (scale, lost) = if old.pressure == 0.0 {
            // A fresh start: nothing to remember from before.
            memory.forget();
            (1.0, 0.0)
        } else if pressure == old.pressure {
            (1.0, 0.0)
        } else if unloaded {
            // New stiffness arrives unloaded: deflections shrink, tractions stay.
            let part = old.pressure / pressure;
            (part, old.stored * (1.0 - part))
        } else {
            (1.0, old.stored * (1.0 - pressure / old.pressure))
        };
        let mut next = Curve::new();
        let room = self.layout.floating;
        let Increment {
            traction,
            tangent,
            shrinkage,
            stored,
            dissipated,
            contact,
            full,
        } = match &self.backbone {
            Choice::PowerLaw(curve) => {
                memory.advance(curve, &self.grid, &d, scale, room, &mut next)
            }
            Choice::Segalman(curve) => {
                memory.advance(curve, &self.grid, &d, scale, room, &mut next)
            }
        };
        let limit = self.properties.mu * pressure;
        let energy = limit * gcr;
        let stored = if contact.is_none() && pressure == old.pressure {
            // Nothing happened: not a bit changes.
            old.stored
        } else {
            stored * energy
        };
        let response = Response {
            traction: traction * limit,
            dtraction_dslip: tangent * (limit / gcr),
            dtraction_dpressure: if unloaded {
                (traction - shrinkage) * self.properties.mu
            } else {
                traction * self.properties.mu
            },
            stored,
            dissipated: dissipated * energy + lost,
            contact: contact.unwrap_or(match old.contact {
                Contact::Open => Contact::Stick,
                stays => stays,
            }),
            memory_full: full,
        };
        header.contact = response.contact;
        header.pressure = pressure;
        header.stored = response.stored;
        header.dissipated += response.dissipated;
        header.slip_length += length(slip_increment);
        // Huge but finite inputs may overflow in a product; nothing infinite may leave.
        let sum = response.traction.sum()
            + response.dtraction_dslip.sum()
            + response.dtraction_dpressure.sum()
            + header.stored
            + header.dissipated
            + header.slip_length;
        if !sum.is_finite() {
            return Err(not_a_result(pressure, slip_increment));
        }
        self.layout.write(&header, Some(&next), state1);
        Ok(response)
    }
}

/// Knots of the base grid for `ndir` directions: one direction needs none but r = 1.
fn base_knots(properties: &Properties, ndir: usize) -> usize {
    if ndir == 1 { 1 } else { properties.base_knots }
}

/// The default length of the state array.
///
/// # Errors
/// Bad properties, or `ndir` not 1 or 2.
pub fn default_state_size(props: &[f64], ndir: usize) -> Result<usize, Error> {
    check_directions(ndir)?;
    let properties = Properties::new(props)?;
    Ok(Layout::default_size(ndir, base_knots(&properties, ndir)))
}

fn check_directions(ndir: usize) -> Result<(), Error> {
    if ndir == 1 || ndir == 2 {
        return Ok(());
    }
    Err(Error::new(
        Kind::BadInput,
        format!("ndir = {ndir}: must be 1 or 2 tangential directions"),
    ))
}

/// Refuses a critical slip that did not come from [`Law::critical_slip`].
#[inline]
fn check_critical_slip(gcr: f64) -> Result<(), Error> {
    if gcr.is_normal() && gcr > 0.0 {
        return Ok(());
    }
    Err(Error::new(
        Kind::BadInput,
        format!("gcr = {gcr:?}: must be a positive length"),
    ))
}

/// Refuses number `index` of the argument `array` where the slip that follows from it is no number, or too long.
#[inline(always)]
fn check_length(array: &str, index: usize, value: f64, slip: f64, gcr: f64) -> Result<(), Error> {
    // The quotient may overflow, this underflows at most. Not a number is not shorter.
    if slip.abs() * (1.0 / LONGEST) <= gcr {
        return Ok(());
    }
    Err(too_long(array, index, value, gcr))
}

#[cold]
fn too_long(array: &str, index: usize, value: f64, gcr: f64) -> Error {
    Error::new(
        Kind::BadInput,
        format!(
            "{array}[{index}] = {:?}: must be finite and a slip of no more than {LONGEST:e} critical slips ({gcr:?})",
            Number(value)
        ),
    )
}

#[cold]
fn too_deep(normal: f64) -> Error {
    Error::new(
        Kind::BadInput,
        format!(
            "opening[0] = {:?}: must be finite, and the pressure that follows no more than {HIGHEST:e}",
            Number(normal)
        ),
    )
}

/// Whether a number is no larger than `limit`, either sign; not a number is not.
///
/// By the bits: several comparisons at once, as compilers make them, raise a flag for what is not a number.
#[inline(always)]
pub(crate) fn within(value: f64, limit: f64) -> bool {
    value.abs().to_bits() <= limit.to_bits()
}

/// Refuses a number of which something that follows is none.
#[inline(always)]
pub(crate) fn check_within(name: &impl Display, value: f64, limit: f64) -> Result<(), Error> {
    if within(value, limit) {
        return Ok(());
    }
    Err(too_large(name, value, limit))
}

#[cold]
fn too_large(name: &impl Display, value: f64, limit: f64) -> Error {
    Error::new(
        Kind::BadInput,
        format!(
            "{name} = {:?}: must be finite and no larger than {limit:e}",
            Number(value)
        ),
    )
}

#[inline(always)]
pub(crate) fn check_pressure(pressure: f64) -> Result<(), Error> {
    check_within(&"pressure", pressure, HIGHEST)
}

#[inline(always)]
pub(crate) fn check_finite(name: &impl Display, value: f64) -> Result<(), Error> {
    if within(value, f64::MAX) {
        return Ok(());
    }
    Err(not_finite(name, value))
}

/// The refusal of inputs that are finite while what follows from them is not.
#[cold]
pub(crate) fn not_a_result<const N: usize>(pressure: f64, slip_increment: &Vector<N>) -> Error {
    Error::new(
        Kind::BadInput,
        format!(
            "pressure = {pressure:?} with slip increment {:?}: the result is not a finite number",
            slip_increment.as_slice()
        ),
    )
}

#[cold]
fn not_finite(name: &impl Display, value: f64) -> Error {
    Error::new(
        Kind::BadInput,
        format!("{name} = {:?}: must be finite", Number(value)),
    )
}
