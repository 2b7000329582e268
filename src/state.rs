//! The state array: one layout for every host (STATEV, internal state variables).
//!
//! A header of [`HEADER`] numbers, the base-grid deflections (ndir each), the floating knots (1 + ndir each:
//! r, then e), zeros. All zeros is the virgin state.

use crate::error::{Error, Kind, Number};
use crate::memory::{self, Curve, Grid, Vector};

/// Numbers before the memory curve.
pub const HEADER: usize = 8;
/// The most knots a base grid may have.
pub const MAX_BASE: usize = 64;
/// The most floating knots that are used, however long the array.
pub const MAX_FLOATING: usize = 64;
/// Floating knots in a state of default size.
const DEFAULT_FLOATING: usize = 8;
/// Fewer floating knots cannot hold a reversal and the branch that follows it.
const MIN_FLOATING: usize = 2;
/// The longest array taken; past the used part there are only zeros.
pub const MAX_STATE: usize = 1_000_000;
/// The most numbers a state uses.
pub const MAX_USED: usize = HEADER + 2 * MAX_BASE + 3 * MAX_FLOATING;

/// A deflection longer than its slip limit by more than this part is not a state.
const DEFLECTION_TOLERANCE: f64 = 1e-9;
/// Knots closer than this in r are no knots of ours, and a slope between them would be noise.
const CLOSEST: f64 = 1e-15;

const HEADER_NAMES: [&str; HEADER] = [
    "ContactStatus",
    "Pressure",
    "StoredEnergy",
    "DissipatedEnergy",
    "SlipLength",
    "TangentialJump1",
    "TangentialJump2",
    "FloatingKnots",
];

/// Where the contact stands (the number in the state).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Contact {
    /// Open, or never closed.
    #[default]
    Open = 0,
    /// No more than a hundredth of the stiffness has slipped.
    Stick = 1,
    /// Part of the slip elements slip.
    MicroSlip = 2,
    /// All slip elements slip.
    GrossSlip = 3,
}

impl Contact {
    const ALL: [Self; 4] = [Self::Open, Self::Stick, Self::MicroSlip, Self::GrossSlip];
}

/// The first numbers of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Header {
    /// Where the contact stands.
    pub contact: Contact,
    /// Pressure at the end of the last increment.
    pub pressure: f64,
    /// Elastic energy held by the contact, per area.
    pub stored: f64,
    /// Energy dissipated so far, per area.
    pub dissipated: f64,
    /// Length of the slip path while closed.
    pub slip_length: f64,
    /// Tangential jump at the last increment (interface form); with Lagrange multipliers the last one of these.
    pub jump: [f64; 2],
}

/// How a state of a given length is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Numbers in the array.
    pub nstate: usize,
    /// Tangential directions.
    pub ndir: usize,
    /// Base knots B (1 for one direction).
    pub base: usize,
    /// Floating knots F that fit.
    pub floating: usize,
}

impl Layout {
    /// The layout for `ndir` directions with `base` knots in an array of `nstate` numbers.
    ///
    /// # Errors
    /// [`Kind::BadState`] when fewer than two floating knots fit, or beyond [`MAX_STATE`].
    pub fn new(ndir: usize, base: usize, nstate: usize) -> Result<Self, Error> {
        let least = Self::size(ndir, base, MIN_FLOATING);
        if nstate < least {
            return Err(Error::new(
                Kind::BadState,
                format!(
                    "nstate = {nstate}: {ndir} tangential direction(s) with {base} base knot(s) need at \
                     least {least} state variables, {} by default",
                    Self::default_size(ndir, base)
                ),
            ));
        }
        if nstate > MAX_STATE {
            return Err(Error::new(
                Kind::BadState,
                format!("nstate = {nstate}: must be at most {MAX_STATE}"),
            ));
        }
        let floating = (nstate - HEADER - base * ndir) / (1 + ndir);
        Ok(Layout {
            nstate,
            ndir,
            base,
            floating: floating.min(MAX_FLOATING),
        })
    }

    fn size(ndir: usize, base: usize, floating: usize) -> usize {
        HEADER + base * ndir + floating * (1 + ndir)
    }

    /// Numbers of the array that are used; the rest stays zero.
    pub fn used(&self) -> usize {
        Self::size(self.ndir, self.base, self.floating)
    }

    /// The default length of the array.
    pub fn default_size(ndir: usize, base: usize) -> usize {
        Self::size(ndir, base, DEFAULT_FLOATING)
    }

    /// The name of slot `index` (0-based), None past the end.
    pub fn slot_name(&self, index: usize) -> Option<String> {
        let floats = HEADER + self.base * self.ndir;
        let end = floats + self.floating * (1 + self.ndir);
        Some(if index >= self.nstate {
            return None;
        } else if index < HEADER {
            HEADER_NAMES[index].to_string()
        } else if index < floats {
            let at = index - HEADER;
            format!("Base{}_{}", at / self.ndir + 1, at % self.ndir + 1)
        } else if index < end {
            let at = index - floats;
            let knot = at / (1 + self.ndir) + 1;
            match at % (1 + self.ndir) {
                0 => format!("Knot{knot}_r"),
                direction => format!("Knot{knot}_e{direction}"),
            }
        } else {
            format!("Unused{}", index - end + 1)
        })
    }

    /// Reads and checks a state, of which the used part is enough.
    // Inlined: a header that travels through memory costs more than the whole check.
    #[inline(always)]
    pub(crate) fn read<const N: usize>(
        &self,
        state: &[f64],
        grid: &Grid<N>,
        curve: &mut Curve<N>,
    ) -> Result<Header, Error> {
        // In one direction r = 1 is all there is.
        let base_knots = if N == 1 { 1 } else { self.base };
        let used = HEADER + base_knots * N + self.floating * (1 + N);
        let Some((header, memory)) = state
            .get(..used)
            .and_then(|state| state.split_first_chunk::<HEADER>())
        else {
            return Err(Error::new(
                Kind::BadState,
                format!("state0 has {} numbers, not {}", state.len(), self.nstate),
            ));
        };
        let [
            status,
            pressure,
            stored,
            dissipated,
            slip_length,
            jump1,
            jump2,
            count,
        ] = *header;
        if header.iter().any(|x| !x.is_finite()) {
            return Err(self.not_finite(state));
        }
        let contact = match Contact::ALL.get(usize::from(status as u8)) {
            Some(contact) if f64::from(status as u8) == status => *contact,
            _ => return Err(self.bad(state, 0, "0, 1, 2 or 3")),
        };
        if pressure < 0.0 {
            return Err(self.bad(state, 1, ">= 0"));
        }
        let floating = count as u8;
        if f64::from(floating) != count || usize::from(floating) > self.floating {
            let allowed = format!("a whole number from 0 to {}", self.floating);
            return Err(self.bad(state, 7, &allowed));
        }
        let in_use = base_knots * N + usize::from(floating) * (1 + N);
        // Nothing in a memory is larger than 1. From 2 on, and for what is no number, the highest bit of the exponent is
        // set: a look at the bits keeps such numbers from comparisons and squares, which would raise flags.
        let bits = memory.iter().fold(0, |bits, x| bits | x.to_bits());
        if bits & 2f64.to_bits() != 0 {
            self.refuse_large(state, in_use)?;
        }
        let (base, floating) = memory[..in_use].split_at(base_knots * N);
        if !curve.set_base(grid, base.as_chunks().0) {
            self.project_base(state, grid, curve)?;
        }
        let mut previous = 0.0;
        for (index, knot) in floating.chunks_exact(1 + N).enumerate() {
            let slot = HEADER + base_knots * N + index * (1 + N);
            let r = knot[0];
            let above = grid.interval(r);
            let below = above.checked_sub(1).map_or(0.0, |k| grid.nodes()[k].r);
            let apart = grid
                .nodes()
                .get(above)
                .is_some_and(|node| node.r - r >= CLOSEST)
                && r - below >= CLOSEST
                && r - previous >= CLOSEST;
            if !apart {
                return Err(self.bad(
                    state,
                    slot,
                    "above the knot before it and between knots of the base grid",
                ));
            }
            previous = r;
            match deflection(r, &knot[1..]) {
                Some(e) => curve.push_floating(r, e, above),
                None => return Err(self.bad_deflection(state, slot + 1, r)),
            }
        }
        Ok(Header {
            contact,
            pressure,
            stored,
            dissipated,
            slip_length,
            jump: [jump1, jump2],
        })
    }

    /// Brings base deflections that are a little too long back onto their slip limits.
    #[cold]
    fn project_base<const N: usize>(
        &self,
        state: &[f64],
        grid: &Grid<N>,
        curve: &mut Curve<N>,
    ) -> Result<(), Error> {
        for (k, node) in grid.nodes().iter().enumerate() {
            let at = HEADER + k * N;
            match deflection(node.r, &state[at..at + N]) {
                Some(e) => curve.set_base_knot(k, e),
                None => return Err(self.bad_deflection(state, at, node.r)),
            }
        }
        Ok(())
    }

    /// Writes a state; `curve` None is an empty memory.
    #[inline(always)]
    pub(crate) fn write<const N: usize>(
        &self,
        header: &Header,
        curve: Option<&Curve<N>>,
        state: &mut [f64],
    ) {
        let base_knots = if N == 1 { 1 } else { self.base };
        let (start, memory) = state.split_at_mut(HEADER);
        let (base, memory) = memory.split_at_mut(base_knots * N);
        let mut count = 0;
        if let Some(curve) = curve {
            base.copy_from_slice(curve.base()[..base_knots].as_flattened());
            count = curve.floating().len();
        } else {
            base.fill(0.0);
        }
        let (floating, unused) = memory.split_at_mut(count * (1 + N));
        if let Some(curve) = curve {
            for (slots, knot) in floating.chunks_exact_mut(1 + N).zip(curve.floating()) {
                slots[0] = knot.r;
                slots[1..].copy_from_slice(knot.e.as_slice());
            }
        }
        unused.fill(0.0);
        start.copy_from_slice(&[
            f64::from(header.contact as u8),
            header.pressure,
            header.stored,
            header.dissipated,
            header.slip_length,
            header.jump[0],
            header.jump[1],
            count as f64,
        ]);
    }

    /// The error for the first number that is not finite.
    #[cold]
    fn not_finite(&self, state: &[f64]) -> Error {
        let index = state.iter().position(|x| !x.is_finite()).unwrap_or(0);
        self.bad(state, index, "finite")
    }

    /// Refuses what is no number, and what is 2 or more among the first `in_use` numbers of the memory.
    #[cold]
    fn refuse_large(&self, state: &[f64], in_use: usize) -> Result<(), Error> {
        if state.iter().any(|x| !x.is_finite()) {
            return Err(self.not_finite(state));
        }
        match state[HEADER..][..in_use]
            .iter()
            .position(|x| x.abs() >= 2.0)
        {
            Some(index) => Err(self.bad(state, HEADER + index, "no larger than 1")),
            None => Ok(()),
        }
    }

    /// The error for a number that no state holds there.
    #[cold]
    fn bad(&self, state: &[f64], index: usize, allowed: &str) -> Error {
        Error::new(
            Kind::BadState,
            format!(
                "state[{index}] {} = {:?}: must be {allowed}",
                self.slot_name(index).unwrap_or_default(),
                Number(state[index])
            ),
        )
    }

    /// The error for a deflection that starts at `index` and is beyond its slip limit.
    #[cold]
    fn bad_deflection(&self, state: &[f64], index: usize, limit: f64) -> Error {
        let allowed = format!("part of a deflection no longer than its slip limit {limit}");
        self.bad(state, index, &allowed)
    }
}

/// The deflection of a knot; None when it is longer than its slip limit r by more than a restart file or a
/// rotation can leave, projected when by less.
#[inline]
fn deflection<const N: usize>(r: f64, e: &[f64]) -> Option<Vector<N>> {
    let e = Vector::<N>::from_column_slice(e);
    let (length2, limit2) = (e.norm_squared(), r * r);
    if length2 <= limit2 * (1.0 + memory::ROUNDING) {
        Some(e)
    } else if length2 <= limit2 * (1.0 + DEFLECTION_TOLERANCE) * (1.0 + DEFLECTION_TOLERANCE) {
        Some(memory::onto_limit(r, &e))
    } else {
        None
    }
}

/// Turns the vectors of a state with the tangential directions: `rotation[i][j]` takes direction j to i.
pub fn rotate(layout: &Layout, rotation: &[[f64; 2]; 2], state: &mut [f64]) {
    let turn = |v: &mut [f64]| {
        let (a, b) = (v[0], v[1]);
        v[0] = rotation[0][0] * a + rotation[0][1] * b;
        v[1] = rotation[1][0] * a + rotation[1][1] * b;
    };
    if layout.ndir != 2 || state.len() < layout.used() {
        return;
    }
    turn(&mut state[5..7]);
    let (base, floating) = state[HEADER..].split_at_mut(2 * layout.base);
    base.chunks_exact_mut(2).for_each(turn);
    floating
        .chunks_exact_mut(3)
        .take(layout.floating)
        .for_each(|knot| turn(&mut knot[1..]));
}
