//! Rigid stick for a host that enforces it with Lagrange multipliers (method 2).
//!
//! The host finds the traction that keeps the point from slipping; the law says whether Coulomb's limit allows
//! it. Only the direction of slip is remembered, as the deflection of a memory that slips as a whole.

use crate::error::Error;
use crate::law::{
    Law, Response, SQUARED, check_finite, check_pressure, check_within, not_a_result,
};
use crate::memory::{Curve, Matrix, Vector, onto_limit};
use crate::state::{Contact, Header};

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

impl<const N: usize> Law<N> {
    /// Decides between stick and slip.
    ///
    /// `sticks`: the host held the point in this iteration, so `multiplier` is its traction. Otherwise the point
    /// slips by `slip_increment`, and sticks again when that turns against the slip before, unless the multiplier
    /// has just reached the limit in the new direction: another one than at the end of the last increment, which the
    /// state keeps in place of a jump. `state1` is written only on success.
    ///
    /// # Errors
    /// Numbers that are not finite; a slip or a limit mu p beyond 1e150; a corrupt state.
    pub fn lagrange(
        &self,
        sticks: bool,
        multiplier: &Vector<N>,
        slip_increment: &Vector<N>,
        pressure: f64,
        state0: &[f64],
        state1: &mut [f64],
    ) -> Result<Rigid<N>, Error> {
        let mut memory = Curve::new();
        let header = self.read(state0, &mut memory)?;
        self.lagrange_from(
            header,
            &mut memory,
            sticks,
            multiplier,
            slip_increment,
            pressure,
            state1,
        )
    }

    /// [`Law::lagrange`] from a state that was read.
    #[expect(clippy::too_many_arguments, reason = "those of lagrange")]
    pub(crate) fn lagrange_from(
        &self,
        mut header: Header,
        memory: &mut Curve<N>,
        sticks: bool,
        multiplier: &Vector<N>,
        slip_increment: &Vector<N>,
        pressure: f64,
        state1: &mut [f64],
    ) -> Result<Rigid<N>, Error> {
        self.check_end(state1)?;
        check_pressure(pressure)?;
        for (index, value) in multiplier.iter().enumerate() {
            check_finite(&format_args!("multiplier[{index}]"), *value)?;
        }
        for (index, value) in slip_increment.iter().enumerate() {
            check_within(&format_args!("slip_increment[{index}]"), *value, SQUARED)?;
        }
        // A huge one keeps its direction; it is beyond every limit that is taken.
        let multiplier = &(multiplier * (SQUARED / multiplier.amax().max(SQUARED)));
        // What the host held has not slipped: an increment there is noise.
        let held = Vector::zeros();
        let slip_increment = if sticks { &held } else { slip_increment };
        let before = self.last_deflection(memory);
        let limit = self.properties().mu * pressure.max(0.0);
        check_within(&"mu p", limit, SQUARED)?;
        let beyond = multiplier.norm() >= limit;
        let slip = slip_increment.norm();
        let stays = if pressure <= 0.0 {
            false
        } else if sticks {
            !beyond
        } else if slip == 0.0 {
            before.norm_squared() == 0.0
        } else {
            let turned = slip_increment.dot(&before) < 0.0;
            // What the host left there since the point last stuck says nothing of this increment.
            let new = multiplier.as_slice() != &header.jump[..N];
            turned && !(new && beyond && multiplier.dot(slip_increment) > 0.0)
        };
        header.jump[..N].copy_from_slice(multiplier.as_slice());
        let lost = header.stored;
        header.stored = 0.0;
        header.pressure = pressure.max(0.0);
        memory.forget();
        if stays {
            header.contact = Contact::Stick;
            header.dissipated += lost;
            check_finite(&"accumulated dissipation", header.dissipated)?;
            self.layout().write(&header, Some(memory), state1);
            return Ok(Rigid::Stick { dissipated: lost });
        }
        let along = if sticks {
            multiplier
        } else if slip == 0.0 {
            &before
        } else {
            slip_increment
        };
        let direction = if pressure > 0.0 && along.amax() > 0.0 {
            // First to the size of 1: squares of huge or tiny numbers are none.
            onto_limit(1.0, &(along / along.amax()))
        } else {
            Vector::zeros()
        };
        memory.saturate(&direction, self.grid().nodes());
        header.contact = if pressure > 0.0 {
            Contact::GrossSlip
        } else {
            Contact::Open
        };
        let traction = direction * limit;
        let dissipated = traction.dot(slip_increment) + lost;
        header.dissipated += dissipated;
        header.slip_length += if pressure > 0.0 { slip } else { 0.0 };
        // Not by zero in either case: compilers divide first, and some hosts trap that. Without slip by 1.
        let turning = limit / (slip + f64::from(u8::from(slip == 0.0)));
        let turning = if slip > 0.0 && !sticks { turning } else { 0.0 };
        let tangent = (Matrix::identity() - direction * direction.transpose()) * turning;
        let sum = traction.sum() + tangent.sum() + header.dissipated + header.slip_length;
        if !sum.is_finite() {
            return Err(not_a_result(pressure, slip_increment));
        }
        self.layout().write(&header, Some(memory), state1);
        Ok(Rigid::Slip(Response {
            traction,
            dtraction_dslip: tangent,
            dtraction_dpressure: direction * self.properties().mu,
            stored: 0.0,
            dissipated,
            contact: header.contact,
            memory_full: false,
        }))
    }
}
