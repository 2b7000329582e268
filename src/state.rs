//! The state array: one layout for every host (STATEV, internal state variables).
//!
//! A header of [`HEADER`] numbers, then up to K knots of 1 + ndir numbers: the slip limit R (a length), the deflection
//! u of the slip element with that limit (a length, ndir components). Unused slots are zero; all zeros is the virgin
//! state.

use crate::error::{Error, Kind};
use crate::number::{finite, within};
use arrayvec::ArrayVec;

/// Numbers before the knots.
pub const HEADER: usize = 12;
/// The most knots that are used, however long the array.
pub const MAX_KNOTS: usize = 64;
/// The fewest knots: fewer cannot hold a reversal, the branch that follows it and the end of the curve.
const MIN_KNOTS: usize = 4;
/// The longest array taken; past the used part there are only zeros.
pub const MAX_STATE: usize = 1_000_000;
/// The most numbers a state uses.
pub const MAX_USED: usize = HEADER + 3 * MAX_KNOTS;
/// The number of this layout, kept in every state that was used.
pub const LAYOUT: f64 = 2.0;

/// A deflection may be this part longer than its slip limit: a state stored with few digits, or turned by a host.
const TOLERANCE: f64 = 1e-5;
/// Two knots that few digits have brought together are within this of each other, relative to R.
const TOGETHER: f64 = 1e-6;
/// The longest and the shortest R of a state, length.
const LONGEST: f64 = 1e150;
const SHORTEST: f64 = 1e-150;

/// From here on squares of lengths are numbers without a second thought.
const ORDINARY: f64 = 1e-140;

const HEADER_NAMES: [&str; HEADER] = [
    "ContactStatus",
    "Pressure",
    "ShearLimit",
    "StoredEnergy",
    "DissipatedEnergy",
    "SlipLength",
    "NormalOpening",
    "TangentialJump1",
    "TangentialJump2",
    "Forgotten",
    "Knots",
    "Layout",
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
    /// Pressure at the end of the last increment; 0 when open.
    pub pressure: f64,
    /// T at the end of the last increment, traction.
    pub limit: f64,
    /// Elastic energy held by friction, per area.
    pub stored: f64,
    /// Energy dissipated so far, per area.
    pub dissipated: f64,
    /// Length of the slip path while closed, stick included.
    pub slip_length: f64,
    /// Normal opening at the last increment (interface form).
    pub opening: f64,
    /// Tangential jump at the last increment (interface form); FRIC keeps the last Lagrange multiplier here.
    pub jump: [f64; 2],
    /// Fraction of T that the last increment gave up for want of knots (two directions).
    pub forgotten: f64,
}

/// One knot of the memory curve: the elastic deflection u (length) of the slip element whose slip limit is R (length).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<const N: usize> {
    /// Slip limit.
    pub r: f64,
    /// Elastic deflection, |u| <= R.
    pub u: [f64; N],
}

/// The knots of a curve, R ascending; the last one is at R = G. While an increment is made there may be two more than a
/// state holds: an old apex and a front.
pub type Knots<const N: usize> = ArrayVec<Knot<N>, { MAX_KNOTS + 2 }>;

/// The end of an increment, not yet written.
#[derive(Clone, Debug)]
pub struct End<const N: usize> {
    /// The first numbers.
    pub header: Header,
    /// The curve; empty when open, or when the limit is 0.
    pub knots: Knots<N>,
}

impl<const N: usize> End<N> {
    /// A place for the end of an increment.
    #[expect(
        clippy::new_without_default,
        reason = "a place to write to is no value"
    )]
    #[inline(always)]
    pub fn new() -> Self {
        End {
            header: Header::default(),
            knots: Knots::new(),
        }
    }
}

/// How a state of a given length is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Numbers in the array.
    pub nstate: usize,
    /// Tangential directions.
    pub ndir: usize,
    /// Knots K that fit.
    pub knots: usize,
}

impl Layout {
    /// The layout for `ndir` directions in an array of `nstate` numbers.
    ///
    /// # Errors
    /// [`Kind::BadState`] when fewer than four knots fit, or beyond [`MAX_STATE`].
    pub fn new(ndir: usize, nstate: usize) -> Result<Self, Error> {
        let least = HEADER + MIN_KNOTS * (1 + ndir);
        if !(least..=MAX_STATE).contains(&nstate) {
            let expected = format!(
                "must be from {least} (default {}) to {MAX_STATE} state variables for {ndir} tangential direction(s)",
                Self::default_size(ndir)
            );
            return Err(Error::about(Kind::BadState, "nstate", expected).count(nstate));
        }
        let knots = ((nstate - HEADER) / (1 + ndir)).min(MAX_KNOTS);
        Ok(Layout {
            nstate,
            ndir,
            knots,
        })
    }

    /// The default length of the array: 16 knots for one direction, 24 for two.
    pub fn default_size(ndir: usize) -> usize {
        let knots = if ndir == 1 { 16 } else { 24 };
        HEADER + knots * (1 + ndir)
    }

    /// Numbers of the array that are used; the rest stays zero.
    pub fn used(&self) -> usize {
        HEADER + self.knots * (1 + self.ndir)
    }

    /// The name of slot `index` (0-based), None past the end.
    pub fn slot_name(&self, index: usize) -> Option<String> {
        if index >= self.nstate {
            return None;
        }
        if let Some(name) = HEADER_NAMES.get(index) {
            return Some((*name).to_string());
        }
        if index >= self.used() {
            return Some(format!("Unused{}", index - self.used() + 1));
        }
        let at = index - HEADER;
        let knot = at / (1 + self.ndir) + 1;
        Some(match at % (1 + self.ndir) {
            0 => format!("Knot{knot}_R"),
            direction => format!("Knot{knot}_u{direction}"),
        })
    }

    /// Reads and checks a state, of which the used part is enough, into `header` and `knots`, both empty before. Every
    /// deflection is brought onto its slip limit.
    ///
    /// # Errors
    /// [`Kind::BadState`] names the slot, its value and what it may be.
    #[inline(always)]
    pub fn read<const N: usize>(
        &self,
        state: &[f64],
        header: &mut Header,
        knots: &mut Knots<N>,
    ) -> Result<(), Error> {
        debug_assert_eq!(N, self.ndir);
        let used = HEADER + self.knots * (1 + N);
        let Some((first, memory)) = state
            .get(..used)
            .and_then(|state| state.split_first_chunk::<HEADER>())
        else {
            let expected = format!("must hold {} numbers", self.nstate);
            return Err(Error::about(Kind::BadState, "state0", expected).count(state.len()));
        };
        // First one look at all of it; only where that finds something it is told what.
        if !all_below(first, 1024) || first[11] != LAYOUT {
            return self.read_carefully(state, knots);
        }
        let [
            status,
            pressure,
            limit,
            stored,
            dissipated,
            slip_length,
            opening,
            jump1,
            jump2,
            forgotten,
            count,
            _,
        ] = *first;
        let (number, contact) = (
            usize::from(count as u8),
            Contact::ALL[usize::from(status as u8 & 3)],
        );
        let counts =
            number as f64 == count && number <= self.knots && (pressure != 0.0 || number == 0);
        let signs = [pressure, limit, stored, slip_length, forgotten]
            .iter()
            .fold(0, |bits, value| bits | value.to_bits());
        if !(counts && signs >> 63 == 0 && f64::from(contact as u8) == status) {
            return self.read_carefully(state, knots);
        }
        *header = Header {
            contact,
            pressure,
            limit,
            stored,
            dissipated,
            slip_length,
            opening,
            jump: [jump1, jump2],
            forgotten,
        };
        let memory = &memory[..number * (1 + N)];
        if !all_below(memory, 498) || !read_knots(memory, knots) {
            return self.read_carefully(state, knots);
        }
        Ok(())
    }

    /// Number by number: what is wrong with a state, or a state of lengths so large, so small or so near to each other that
    /// their squares say nothing. The header is right, or that of a virgin state.
    #[cold]
    fn read_carefully<const N: usize>(
        &self,
        state: &[f64],
        knots: &mut Knots<N>,
    ) -> Result<(), Error> {
        knots.clear();
        if let Some(index) = state[..HEADER].iter().position(|value| !finite(*value)) {
            return Err(self.bad(state, index, "must be finite"));
        }
        if state[11] != LAYOUT {
            return self.read_unused(state);
        }
        let status = state[0];
        if f64::from(status as u8) != status || usize::from(status as u8) >= Contact::ALL.len() {
            return Err(self.bad(state, 0, "must be 0, 1, 2 or 3"));
        }
        if let Some(index) = [1, 2, 3, 5, 9]
            .into_iter()
            .find(|index| state[*index] < 0.0)
        {
            return Err(self.bad(state, index, "must be >= 0"));
        }
        let number = state[10] as u8;
        if f64::from(number) != state[10] || usize::from(number) > self.knots {
            let expected = format!("must be a whole number from 0 to {}", self.knots);
            return Err(self.bad(state, 10, expected));
        }
        if state[1] == 0.0 && number > 0 {
            return Err(self.bad(state, 10, "must be 0 in an open contact"));
        }
        let mut below = Knot {
            r: 0.0,
            u: [0.0; N],
        };
        for index in 0..usize::from(number) {
            let first = HEADER + index * (1 + N);
            let slots = &state[first..first + 1 + N];
            if let Some(slot) = slots.iter().position(|value| !within(*value, LONGEST)) {
                return Err(self.bad(state, first + slot, "must be a length of at most 1e150"));
            }
            let r = slots[0];
            let mut u: [f64; N] = std::array::from_fn(|i| slots[1 + i]);
            let mut apart = r > below.r.max(SHORTEST);
            if !apart && r > SHORTEST && r >= below.r * (1.0 - TOGETHER) {
                // Few digits have brought two knots together: the upper one stands for both.
                let near = |i: usize| (u[i] - below.u[i]).abs() <= TOLERANCE * r;
                if (0..N).all(near) {
                    knots.pop();
                    below = knots.last().copied().unwrap_or(Knot {
                        r: 0.0,
                        u: [0.0; N],
                    });
                    apart = r > below.r;
                }
            }
            if !apart {
                let expected = "must be > 0 and above the slip limit of the knot before it";
                return Err(self.bad(state, first, expected));
            }
            if N == 1 && (u[0] - below.u[0]).abs() > (r - below.r) + TOLERANCE * r {
                let expected =
                    "must differ from the deflection before it by no more than the slip limits do";
                return Err(self.bad(state, first + 1, expected));
            }
            if !onto_limit(r, &mut u) {
                let expected =
                    format!("must be part of a deflection no longer than its slip limit {r:?}");
                return Err(self.bad(state, first + 1, expected));
            }
            below = Knot { r, u };
            knots.push(below);
        }
        Ok(())
    }

    /// Takes a state without the number of this layout: only the virgin one, all zeros.
    #[cold]
    fn read_unused(&self, state: &[f64]) -> Result<(), Error> {
        if state[..self.used()].iter().all(|value| *value == 0.0) {
            return Ok(());
        }
        Err(self.bad(
            state,
            11,
            "must be 2 in a state that was used: this one was averaged by the host, comes from another version of the library, or from another program",
        ))
    }

    /// Writes a state.
    #[inline(always)]
    pub fn write<const N: usize>(&self, end: &End<N>, state: &mut [f64]) {
        let (start, memory) = state.split_at_mut(HEADER);
        let header = &end.header;
        start.copy_from_slice(&[
            f64::from(header.contact as u8),
            header.pressure,
            header.limit,
            header.stored,
            header.dissipated,
            header.slip_length,
            header.opening,
            header.jump[0],
            header.jump[1],
            header.forgotten,
            end.knots.len() as f64,
            LAYOUT,
        ]);
        let (used, unused) = memory.split_at_mut(end.knots.len() * (1 + N));
        for (slots, knot) in used.chunks_exact_mut(1 + N).zip(&end.knots) {
            slots[0] = knot.r;
            slots[1..].copy_from_slice(&knot.u);
        }
        unused.fill(0.0);
    }

    /// The error for a number that no state holds there.
    #[cold]
    fn bad(
        &self,
        state: &[f64],
        index: usize,
        expected: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Error {
        Error::about(Kind::BadState, "state", expected)
            .index(index)
            .name(self.slot_name(index).unwrap_or_default())
            .number(state[index])
    }
}

/// Whether all numbers are below 2^`power` in size; 1024: finite. Bits only: comparing a signalling NaN raises a flag that some
/// hosts trap.
#[inline(always)]
fn all_below(values: &[f64], power: u64) -> bool {
    const EXPONENT: u64 = 0x7ff << 52;
    // An exponent beyond carries into the sign.
    let carried = |value: &f64| (value.to_bits() & EXPONENT) + ((1025 - power) << 52);
    values.iter().fold(0, |bits, value| bits | carried(value)) >> 63 == 0
}

/// The knots of a state of numbers below 1e150; false when they break a rule or are too small for their squares.
#[inline(always)]
fn read_knots<const N: usize>(memory: &[f64], knots: &mut Knots<N>) -> bool {
    const LONGER: f64 = 1.0 + TOLERANCE;
    let mut below = Knot {
        r: ORDINARY,
        u: [0.0; N],
    };
    let mut good = true;
    for slots in memory.chunks_exact(1 + N) {
        let r = slots[0];
        let mut u: [f64; N] = std::array::from_fn(|i| slots[1 + i]);
        good &= r > below.r;
        if N == 1 {
            let apart = (u[0] - below.u[0]).abs() - (r - below.r);
            good &= (apart <= TOLERANCE * r) & (u[0].abs() <= r * LONGER);
            u[0] = if u[0].abs() > r {
                r.copysign(u[0])
            } else {
                u[0]
            };
        } else {
            let (square, limit) = (u[0] * u[0] + u[N - 1] * u[N - 1], r * r);
            good &= square <= limit * (LONGER * LONGER);
            // Rounding of the last bits is left alone: a projection there would only move it.
            if square > limit * (1.0 + 1e-13) {
                let part = r / square.sqrt();
                u.iter_mut().for_each(|x| *x *= part);
            }
        }
        below = Knot { r, u };
        knots.push(below);
    }
    good
}

/// Brings a deflection that is a little too long onto its slip limit; false when it is longer than few digits explain.
#[inline(always)]
fn onto_limit<const N: usize>(r: f64, u: &mut [f64; N]) -> bool {
    if N == 1 {
        let long = u[0].abs();
        if long > r {
            u[0] = r.copysign(u[0]);
        }
        return long <= r * (1.0 + TOLERANCE);
    }
    if u.iter().any(|x| x.abs() > 2.0 * r) {
        return false;
    }
    // R may be so small that its square is none.
    let (a, b) = (u[0] / r, u[N - 1] / r);
    let square = a * a + b * b;
    if square > 1.0 {
        if square > (1.0 + TOLERANCE) * (1.0 + TOLERANCE) {
            return false;
        }
        // Rounding of the last bits is left alone: a projection there would only move it.
        if square > 1.0 + 1e-13 {
            let part = 1.0 / square.sqrt();
            u.iter_mut().for_each(|x| *x *= part);
        }
    }
    true
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
    turn(&mut state[7..9]);
    for knot in state[HEADER..layout.used()].chunks_exact_mut(3) {
        turn(&mut knot[1..]);
    }
}
