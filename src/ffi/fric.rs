//! The FRIC face: the user friction routine of Abaqus/Standard, all 39 arguments.
//!
//! The argument list and its meaning were taken from the manual and from working sources; what is not confirmed is
//! marked in docs/hosts.md. Arrays are column-major, integers 32 bits.

use super::arguments::{
    Integer, IntegerOut, Real, RealOut, Text, array, count, fortran_name, hint, read, read_turned,
    required, routine, vector, write,
};
use super::laws::mu_factor;
use super::refusal::{Routine, Shared, shared, sticking};
use crate::error::{Error, Kind};
use crate::lagrange::{Host, Rigid};
use crate::law::{Law, Response, SQUARED, Start};
use crate::memory::{Matrix, Vector};
use crate::number::within;
use crate::properties::Method;
use crate::state::End;
use std::slice;

/// Relative motion flag: slip or elastic stick, TAU and its derivatives count.
const SLIPPING: i32 = 0;
/// Relative motion flag: rigid stick by Lagrange multiplier.
const STICKING: i32 = 1;
/// Relative motion flag: open before, frictionless in this increment.
const OPEN: i32 = 2;

routine! {
    /// FRIC of Abaqus/Standard: see docs/hosts.md for what each argument means and what is used.
    struct Arguments of fric_(), fric();
    take lm: IntegerOut, take tau: RealOut, take ddtddg: RealOut, take ddtddp: RealOut, take dslip: RealOut,
    take sed: RealOut, take sfd: RealOut, take ddtddt: RealOut, take pnewdt: RealOut, take statev: RealOut,
    take dgam: Real, take taulm: Real, take press: Real, skip dpress: Real, skip ddpddh: Real, skip slip: Real,
    take kstep: Integer, take kinc: Integer, skip time: Real, skip dtime: Real, skip noel: Integer,
    take ciname: Text, skip slname: Text, skip msname: Text, skip npt: Integer, take node: Integer,
    skip npatch: Integer, skip coords: Real, skip rcoord: Real, take drot: Real, skip temp: Real, take predef: Real,
    take nfdir: Integer, skip mcrd: Integer, take npred: Integer, take nstatv: Integer, take chrlngth: Real,
    take props: Real, take nprops: Integer,
}

impl Routine for Arguments {
    const NAME: &'static str = "FRIC";
    const DIRECTIONS: (&'static str, fn(i32) -> i32, &'static str) = (
        "NFDIR",
        |directions| directions,
        "must be 1 or 2 slip directions",
    );

    #[inline(always)]
    fn directions(&self) -> *const i32 {
        self.nfdir
    }

    #[inline(always)]
    fn shared(&self) -> Shared {
        shared!(self)
    }

    fn host_name(ours: &str, index: Option<usize>) -> Option<String> {
        let theirs = match ours {
            "slip_increment" => "DGAM",
            "pressure" => "PRESS",
            "multiplier" => "TAULM",
            _ => ours,
        };
        fortran_name(theirs, index)
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
            let lm = read("LM", self.lm)?;
            required(
                [
                    "STATEV", "TAU", "DDTDDG", "DDTDDP", "DSLIP", "SED", "SFD", "PNEWDT",
                ],
                [
                    self.statev,
                    self.tau,
                    self.ddtddg,
                    self.ddtddp,
                    self.dslip,
                    self.sed,
                    self.sfd,
                    self.pnewdt,
                ],
            )?;
            let slip = if lm == OPEN {
                self.read_forgotten(law, &mut start);
                hint(self.dgam)
            } else {
                read_turned("STATEV", law, self.statev, self.drot, &mut start)?;
                vector("DGAM", self.dgam, 1)?
            };
            let gcr = law
                .properties()
                .critical_slip(shared.characteristic_length())?;
            // The first of a pair is on the slave surface.
            let fields = || count("NPRED", self.npred);
            let factor = mu_factor(props, fields, "PREDEF", self.predef, |index| 2 * index)?;
            let rigid = law.properties().method == Method::Lagrange;
            let response = match lm {
                // The point was open: forget, and stay frictionless for this increment.
                OPEN => law.friction_from(&mut start, gcr, &Vector::zeros(), 0.0, 1.0, &mut end)?,
                SLIPPING | STICKING if rigid => {
                    let host = match lm {
                        STICKING => Host::Held(vector("TAULM", self.taulm, 1)?),
                        // Only a hint then, and not always set.
                        _ => Host::Slipped {
                            slip,
                            multiplier: hint(self.taulm),
                        },
                    };
                    let pressure = read("PRESS", self.press)?;
                    match law.lagrange_from(&start, &host, gcr, pressure, factor, &mut end)? {
                        Rigid::Stick { dissipated } => {
                            *self.lm = STICKING;
                            write(self.dslip, Vector::<N>::zeros().as_slice());
                            *self.sed = 0.0;
                            *self.sfd = dissipated;
                            self.keep(law, &end);
                            return Ok(());
                        }
                        Rigid::Slip(response) => response,
                    }
                }
                SLIPPING | STICKING => {
                    let pressure = read("PRESS", self.press)?;
                    law.friction_from(&mut start, gcr, &slip, pressure, factor, &mut end)?
                }
                other => {
                    return Err(
                        Error::about(Kind::BadInput, "LM", "must be 0, 1 or 2").count(other)
                    );
                }
            };
            *self.lm = if lm == OPEN { OPEN } else { SLIPPING };
            self.answer(&response);
            write(self.dslip, (slip - response.elastic_slip).as_slice());
            self.keep(law, &end);
            Ok(())
        }
    }

    unsafe fn offer<const N: usize>(&self, shared: &Shared) {
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            let [_, tangential] = sticking::<N>(shared, read("PRESS", self.press));
            let operator = Matrix::<N>::identity() * tangential;
            write(self.ddtddg, operator.as_slice());
            write(self.ddtddp, Vector::<N>::zeros().as_slice());
            write(self.ddtddt, &[0.0; 4][..2 * N]);
        }
    }

    unsafe fn flag(&self) {
        // SAFETY: null or writable.
        if let Some(lm) = unsafe { self.lm.as_mut() } {
            *lm = SLIPPING;
        }
    }
}

impl Arguments {
    /// The state of a point that was open. Whatever is there will be forgotten, so nothing can be wrong with it.
    ///
    /// # Safety
    /// As [`Routine::update`], NFDIR = N; STATEV is there.
    #[cold]
    unsafe fn read_forgotten<const N: usize>(&self, law: &Law<N>, start: &mut Start<N>) {
        // SAFETY: sizes as the host declares them.
        unsafe {
            // Numbers whose squares are none are not even looked at: some hosts trap that.
            let state = array("STATEV", self.statev, law.layout().used());
            let calm = state.is_ok_and(|state| state.iter().all(|x| within(*x, SQUARED)));
            if !calm || read_turned("STATEV", law, self.statev, self.drot, start).is_err() {
                *start = Start::new();
            }
        }
    }

    /// # Safety
    /// As [`Routine::update`]; STATEV is there, and all of it has been read.
    #[inline(always)]
    unsafe fn keep<const N: usize>(&self, law: &Law<N>, end: &End<N>) {
        // SAFETY: NSTATV numbers; there is no other reference to them.
        let state = unsafe { slice::from_raw_parts_mut(self.statev, law.layout().nstate) };
        law.layout().write(end, state);
    }

    /// # Safety
    /// As [`Routine::update`]; the outputs have been checked to be there.
    #[inline(always)]
    unsafe fn answer<const N: usize>(&self, response: &Response<N>) {
        // SAFETY: sizes as the host declares them.
        unsafe {
            write(self.tau, response.traction.as_slice());
            // nalgebra's order is column-major, as Fortran's.
            write(self.ddtddg, response.dtraction_dslip.as_slice());
            write(self.ddtddp, response.dtraction_dpressure.as_slice());
            write(self.ddtddt, &[0.0; 4][..2 * N]);
            *self.sed = response.stored;
            *self.sfd = response.dissipated;
        }
    }
}
