//! The UINTER face: the user interface routine of Abaqus/Standard, all 47 arguments.
//!
//! The argument list was taken from working sources; what is not confirmed is marked in docs/hosts.md. Penetration and
//! compression are positive here, so the normal component changes its sign on the way in and out.

use super::arguments::{
    Integer, IntegerOut, Real, RealOut, Text, count, finite, fortran_name, read, read_turned,
    required, routine, vector, write,
};
use super::components::{Components, Order, consistent, uncoupled};
use super::laws::mu_factor;
use super::refusal::{Routine, Shared, shared, sticking};
use crate::error::Error;
use crate::law::{Law, Start, UNKNOWN_OPENING};
use crate::memory::Vector;
use crate::state::End;
use std::slice;

/// Penetration below this stands for a point without a partner (the host passes -1e36).
const UNPAIRED: f64 = -1e35;

routine! {
    /// UINTER of Abaqus/Standard: see docs/hosts.md for what each argument means and what is used.
    struct Arguments of uinter_(), uinter();
    take stress: RealOut, take ddsddr: RealOut, take dviscous: RealOut, take dstructural: RealOut,
    skip flux: RealOut, take ddfddt: RealOut, take ddsddt: RealOut, take ddfddr: RealOut, take statev: RealOut,
    take sed: RealOut, take sfd: RealOut, take spd: RealOut, take svd: RealOut, take scd: RealOut,
    take pnewdt: RealOut, take rdisp: Real, take drdisp: Real, skip temp: Real, skip dtemp: Real, take predef: Real,
    skip dpred: Real, skip time: Real, skip dtime: Real, skip freqr: Real, take ciname: Text, skip secname: Text,
    skip mainname: Text, take props: Real, skip coords: Real, skip alocaldir: Real, take drot: Real,
    skip area: Real, take chrlngth: Real, take node: Integer, take ndir: Integer, take nstatv: Integer,
    take npred: Integer, take nprops: Integer, skip mcrd: Integer, take kstep: Integer, take kinc: Integer,
    skip kit: Integer, skip linper: Integer, take lopenclose: IntegerOut, skip lstate: IntegerOut,
    skip lsdi: IntegerOut, skip lprint: Integer,
}

impl Routine for Arguments {
    const NAME: &'static str = "UINTER";
    const DIRECTIONS: (&'static str, fn(i32) -> i32, &'static str) = (
        "NDIR",
        |directions| directions.saturating_sub(1),
        "must be 2 or 3 directions, the normal included",
    );

    #[inline(always)]
    fn directions(&self) -> *const i32 {
        self.ndir
    }

    #[inline(always)]
    fn shared(&self) -> Shared {
        shared!(self)
    }

    fn host_name(ours: &str, index: Option<usize>) -> Option<String> {
        match (ours, index) {
            // An opening is a negative penetration.
            ("opening", Some(0)) => Some("-RDISP(1)".to_string()),
            ("opening", _) => fortran_name("DRDISP", index),
            _ => fortran_name(ours, index),
        }
    }

    #[inline(always)]
    unsafe fn update<const N: usize>(
        &self,
        law: &Law<N>,
        props: &[f64],
        shared: &Shared,
    ) -> Result<(), Error> {
        let (mut start, mut end) = (Start::new(), End::new());
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            let gcr = law.critical_slip(shared.characteristic_length())?;
            read_turned("STATEV", law, self.statev, self.drot, &mut start)?;
            required(
                ["STRESS", "DDSDDR", "SED", "SFD", "PNEWDT"],
                [self.stress, self.ddsddr, self.sed, self.sfd, self.pnewdt],
            )?;
            let penetration = finite("RDISP(1)", read("RDISP", self.rdisp)?)?;
            // The first of a pair is on the slave surface.
            let fields = || count("NPRED", self.npred);
            let factor = mu_factor(props, fields, "PREDEF", self.predef, |index| 2 * index)?;
            // Without a partner nothing is known of the opening, and there is no slip.
            let (opening, slip) = if penetration <= UNPAIRED {
                (UNKNOWN_OPENING, Vector::<N>::zeros())
            } else {
                // The increment is the host's: RDISP may start anew when the point slides onto another face.
                (-penetration, vector("DRDISP", self.drdisp, 2)?)
            };
            let mut jump = Vector::<N>::zeros();
            for (index, slip) in slip.iter().enumerate() {
                let slip = finite("DRDISP", *slip).map_err(|error| error.index(1 + index))?;
                jump[index] = start.header.jump[index] + slip;
            }
            let response = law.interface_from(&mut start, gcr, opening, &jump, factor, &mut end)?;
            let components = Self::components::<N>();
            components.write_forces(&response, self.stress);
            components.write_operator::<N>(&consistent(&response), Order::ColumnMajor, self.ddsddr);
            self.clear_the_rest(1 + N);
            *self.sed = response.friction.stored + response.normal_energy;
            *self.sfd = response.friction.dissipated;
            if let Some(open_or_closed) = self.lopenclose.as_mut() {
                *open_or_closed = i32::from(response.normal_traction < 0.0);
            }
            // NSTATV numbers, all of them read: there is no other reference to them.
            law.layout().write(
                &end,
                slice::from_raw_parts_mut(self.statev, law.layout().nstate),
            );
            Ok(())
        }
    }

    unsafe fn offer<const N: usize>(&self, shared: &Shared) {
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            let pressure = read("STRESS", self.stress.cast_const());
            let [normal, tangential] = sticking::<N>(shared, pressure);
            let operator = uncoupled(normal, tangential);
            Self::components::<N>().write_operator::<N>(&operator, Order::ColumnMajor, self.ddsddr);
            self.clear_the_rest(1 + N);
        }
    }
}

impl Arguments {
    /// Penetration is a negative opening, and STRESS(1) a negative normal traction.
    fn components<const N: usize>() -> Components {
        Components {
            size: 1 + N,
            slots: [0, 1, 2],
            weights: [-1.0, 1.0, 1.0],
            length: 1.0,
        }
    }

    /// Derivatives, damping and energies that this contact has none of.
    ///
    /// # Safety
    /// As [`Routine::update`].
    unsafe fn clear_the_rest(&self, ndir: usize) {
        let zeros = [0.0; 9];
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            for matrix in [self.dviscous, self.dstructural] {
                write(matrix, &zeros[..ndir * ndir]);
            }
            for matrix in [self.ddsddt, self.ddfddr] {
                write(matrix, &zeros[..2 * ndir]);
            }
            write(self.ddfddt, &zeros[..4]);
            for energy in [self.spd, self.svd, self.scd] {
                write(energy, &zeros[..1]);
            }
        }
    }
}
