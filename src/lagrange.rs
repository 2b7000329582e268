//! Rigid stick for a host that enforces it with Lagrange multipliers (method 2).
//!
//! The host finds the traction that keeps the point from slipping; the law says whether the limit allows it. Only the
//! direction of slip is remembered, as one knot at its limit.

use crate::error::{Error, Kind};
use crate::law::{
    Law, Response, SQUARED, Start, check_factor, check_pressure, check_within, not_a_result,
};
use crate::memory::{Matrix, Vector};
use crate::number::finite;
use crate::state::{Contact, End, Knot};

/// What the point does.
#[derive(Clone, Debug, PartialEq)]
pub enum Rigid<const N: usize> {
    /// It sticks: the multiplier is the traction.
    Stick {
        /// Energy lost with a memory that another method left.
        dissipated: f64,
    },
    /// It slips (or is open) with this traction.
    Slip(Response<N>),
}

/// What the host did in this iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Host<const N: usize> {
    /// It held the point; this is the traction that took.
    Held(Vector<N>),
    /// It let the point slip by `slip`; `multiplier` is what it left from the last time the point stuck.
    Slipped {
        /// Slip increment, length.
        slip: Vector<N>,
        /// The old multiplier, traction.
        multiplier: Vector<N>,
    },
}

impl<const N: usize> Law<N> {
    /// Decides between stick and slip.
    ///
    /// A point that slips sticks again when its slip turns against the slip before, unless the multiplier has just
    /// reached the limit in the new direction: another one than at the end of the last increment, which the state keeps
    /// in place of a jump.
    ///
    /// # Errors
    /// Numbers that are not finite; a slip or a limit beyond 1e150; a corrupt state.
    pub(crate) fn lagrange_from(
        &self,
        start: &Start<N>,
        host: &Host<N>,
        gcr: f64,
        pressure: f64,
        mu_factor: f64,
        end: &mut End<N>,
    ) -> Result<Rigid<N>, Error> {
        check_pressure(pressure)?;
        check_factor(mu_factor)?;
        let (held, multiplier, slip_increment) = match host {
            Host::Held(multiplier) => (true, multiplier, &Vector::zeros()),
            Host::Slipped { slip, multiplier } => (false, multiplier, slip),
        };
        for (index, value) in multiplier.iter().enumerate() {
            check_within("multiplier", index, *value, f64::MAX)?;
        }
        for (index, value) in slip_increment.iter().enumerate() {
            check_within("slip_increment", index, *value, SQUARED)?;
        }
        // A huge one keeps its direction; it is beyond every limit that is taken.
        let multiplier = &(multiplier * (SQUARED / multiplier.amax().max(SQUARED)));
        let before = start.last_deflection();
        let limit = self.limit(pressure, mu_factor, &start.header);
        let closed = pressure > 0.0;
        let strength = if closed { limit.limit } else { 0.0 };
        if strength > SQUARED {
            let expected = "must be such that the limit traction is no larger than 1e150";
            return Err(Error::about(Kind::BadInput, "pressure", expected).number(pressure));
        }
        let beyond = multiplier.norm() >= strength;
        let slip = slip_increment.norm();
        let stays = if !closed {
            false
        } else if held {
            !beyond
        } else if slip == 0.0 {
            before.amax() == 0.0
        } else {
            let turned = slip_increment.dot(&before) < 0.0;
            // What the host left there since the point last stuck says nothing of this increment.
            let new = multiplier.as_slice() != &start.header.jump[..N];
            turned && !(new && beyond && multiplier.dot(slip_increment) > 0.0)
        };
        let lost = start.header.stored;
        end.header = start.header;
        end.header.jump[..N].copy_from_slice(multiplier.as_slice());
        end.header.stored = 0.0;
        end.header.forgotten = 0.0;
        end.header.pressure = pressure.max(0.0);
        end.header.limit = strength;
        end.knots.clear();
        if stays {
            end.header.contact = Contact::Stick;
            end.header.dissipated += lost;
            if !finite(end.header.dissipated) {
                return Err(not_a_result(pressure, slip_increment));
            }
            return Ok(Rigid::Stick { dissipated: lost });
        }
        let along = if held {
            multiplier
        } else if slip == 0.0 {
            &before
        } else {
            slip_increment
        };
        let mut direction = Vector::zeros();
        if closed && along.amax() > 0.0 {
            // First to the size of 1: squares of huge or tiny numbers are none.
            direction = (along / along.amax()).normalize();
            let u = direction * gcr;
            end.knots.push(Knot {
                r: gcr,
                u: u.into(),
            });
        }
        end.header.contact = if closed {
            Contact::GrossSlip
        } else {
            Contact::Open
        };
        let traction = direction * strength;
        let dissipated = traction.dot(slip_increment) + lost;
        end.header.dissipated += dissipated;
        end.header.slip_length += if closed { slip } else { 0.0 };
        // Not by zero in either case: compilers divide first, and some hosts trap that. Without slip by 1.
        let turning = strength / (slip + f64::from(u8::from(slip == 0.0)));
        let turning = if slip > 0.0 && !held { turning } else { 0.0 };
        let tangent = (Matrix::identity() - direction * direction.transpose()) * turning;
        let sum = traction.sum() + tangent.sum() + end.header.dissipated + end.header.slip_length;
        if !finite(sum) {
            return Err(not_a_result(pressure, slip_increment));
        }
        Ok(Rigid::Slip(Response {
            traction,
            dtraction_dslip: tangent,
            dtraction_dpressure: direction * limit.slope,
            stored: 0.0,
            dissipated,
            // Rigid: all slip is plastic.
            elastic_slip: Vector::zeros(),
            contact: end.header.contact,
            memory_full: false,
        }))
    }
}
