//! The FRIC face: the user friction routine of Abaqus/Standard, all 39 arguments.
//!
//! The argument list and its meaning were taken from the manual and from working sources; what is not confirmed is
//! marked in docs/hosts.md. Arrays are column-major, integers 32 bits.

use super::guard;
use super::standard::Standard;
use super::user::{self, array, read, required, vector, write};
use crate::error::{Error, Kind};
use crate::lagrange::Rigid;
use crate::law::{Law, Response, SQUARED, within};
use crate::memory::{Curve, Matrix, Vector};
use crate::properties::Method;
use crate::state::{HEADER, Header};
use libc::{c_char, c_double};
use std::slice;

/// Relative motion flag: slip or elastic stick, TAU and its derivatives count.
const SLIPPING: i32 = 0;
/// Relative motion flag: rigid stick by Lagrange multiplier.
const STICKING: i32 = 1;
/// Relative motion flag: open before, frictionless in this increment.
const OPEN: i32 = 2;

/// The arguments that are used, as the host passes them.
#[derive(Clone, Copy)]
struct Arguments {
    shared: Standard,
    lm: *mut i32,
    tau: *mut c_double,
    ddtddg: *mut c_double,
    ddtddp: *mut c_double,
    dslip: *mut c_double,
    sed: *mut c_double,
    ddtddt: *mut c_double,
    statev: *mut c_double,
    dgam: *const c_double,
    taulm: *const c_double,
    press: *const c_double,
    drot: *const c_double,
    nfdir: *const i32,
}

impl Arguments {
    /// Runs the routine; whatever goes wrong is told to the user and asks the host for a smaller increment.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn run(&self) {
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            match read("NFDIR", self.nfdir)? {
                1 => self.shared.with_law(&user::ONE, |law| self.update(law)),
                2 => self.shared.with_law(&user::TWO, |law| self.update(law)),
                other => Err(Error::new(
                    Kind::BadInput,
                    format!("NFDIR = {other}: must be 1 or 2 slip directions"),
                )),
            }
        });
        if let Err(error) = outcome {
            let error = user::in_host_words(error, host_name);
            // SAFETY: as the caller says.
            unsafe { self.shared.refuse("FRIC", &error, || self.offer()) }
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NFDIR = N.
    #[inline(always)]
    unsafe fn update<const N: usize>(&self, law: &Law<N>) -> Result<(), Error> {
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            let layout = law.layout();
            let lm = read("LM", self.lm)?;
            self.check_outputs()?;
            let mut memory = Curve::new();
            let (header, before, slip, pressure) = if lm == OPEN {
                let (header, before) = self.read_forgotten(law, &mut memory);
                (header, before, user::hint(self.dgam), 0.0)
            } else {
                let header = user::read_turned("STATEV", law, self.statev, self.drot, &mut memory)?;
                let pressure = read("PRESS", self.press)?;
                let before = law.last_deflection(&memory);
                (header, before, vector("DGAM", self.dgam, 1)?, pressure)
            };
            // Everything has been read: from here on STATEV is only written.
            let state1 = slice::from_raw_parts_mut(self.statev, layout.nstate);
            let gcr = law
                .properties()
                .critical_slip(self.shared.characteristic_length())?;
            let rigid = law.properties().method == Method::Lagrange;
            let response = match lm {
                // The point was open: forget, and stay frictionless for this increment.
                OPEN => {
                    law.friction_from(header, &mut memory, gcr, &Vector::zeros(), pressure, state1)?
                }
                SLIPPING | STICKING if rigid => {
                    let multiplier = match lm {
                        STICKING => vector::<N>("TAULM", self.taulm, 1)?,
                        // Only a hint then, and not always set.
                        _ => user::hint(self.taulm),
                    };
                    let held = lm == STICKING;
                    match law.lagrange_from(
                        header,
                        &mut memory,
                        held,
                        &multiplier,
                        &slip,
                        pressure,
                        state1,
                    )? {
                        Rigid::Stick { dissipated } => {
                            *self.lm = STICKING;
                            write(self.dslip, Vector::<N>::zeros().as_slice());
                            *self.sed = 0.0;
                            *self.shared.sfd = dissipated;
                            return Ok(());
                        }
                        Rigid::Slip(response) => response,
                    }
                }
                SLIPPING | STICKING => {
                    law.friction_from(header, &mut memory, gcr, &slip, pressure, state1)?
                }
                other => {
                    return Err(Error::new(
                        Kind::BadInput,
                        format!("LM = {other}: must be 0, 1 or 2"),
                    ));
                }
            };
            // What the last slip element takes up is the elastic part of the slip.
            let elastic = if rigid {
                Vector::zeros()
            } else {
                let slot = HEADER + (layout.base - 1) * N;
                let after = Vector::<N>::from_column_slice(&state1[slot..slot + N]);
                (after - before) * gcr
            };
            *self.lm = if lm == OPEN { OPEN } else { SLIPPING };
            self.answer(&response);
            write(self.dslip, (slip - elastic).as_slice());
            Ok(())
        }
    }

    /// The state of a point that was open, and the deflection of its last slip element. Whatever is there will be
    /// forgotten, so nothing can be wrong with it.
    ///
    /// # Safety
    /// As [`Arguments::run`], NFDIR = N.
    unsafe fn read_forgotten<const N: usize>(
        &self,
        law: &Law<N>,
        memory: &mut Curve<N>,
    ) -> (Header, Vector<N>) {
        // SAFETY: sizes as the host declares them, copied at once.
        unsafe {
            // Numbers whose squares are none are not even looked at: some hosts trap that.
            let state = array("STATEV", self.statev, law.layout().used());
            if state.is_ok_and(|state| state.iter().all(|x| within(*x, SQUARED)))
                && let Ok(header) = user::read_turned("STATEV", law, self.statev, self.drot, memory)
            {
                return (header, law.last_deflection(memory));
            }
        }
        (Header::default(), Vector::zeros())
    }

    #[inline(always)]
    fn check_outputs(&self) -> Result<(), Error> {
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
                self.shared.sfd,
                self.shared.pnewdt,
            ],
        )
    }

    /// # Safety
    /// As [`Arguments::run`]; the outputs have been checked to be there.
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
            *self.shared.sfd = response.dissipated;
        }
    }

    /// What a refused call gives: TAU and STATEV stay as they were.
    ///
    /// # Safety
    /// As [`Arguments::run`].
    unsafe fn offer(&self) {
        // SAFETY: null, or as the host's manual says.
        unsafe {
            if let Some(lm) = self.lm.as_mut() {
                *lm = SLIPPING;
            }
            match read("NFDIR", self.nfdir) {
                Ok(1) => self.offer_sticking::<1>(),
                Ok(2) => self.offer_sticking::<2>(),
                // Nobody knows how long the arrays are.
                _ => {}
            }
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NFDIR = N.
    unsafe fn offer_sticking<const N: usize>(&self) {
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            let [_, tangential] = self.shared.sticking::<N>(read("PRESS", self.press));
            let operator = Matrix::<N>::identity() * tangential;
            write(self.ddtddg, operator.as_slice());
            write(self.ddtddp, Vector::<N>::zeros().as_slice());
            write(self.ddtddt, &[0.0; 4][..2 * N]);
        }
    }
}

/// What the host calls an argument of the library.
fn host_name(ours: &str, index: usize) -> Option<String> {
    match ours {
        "slip_increment" => Some(format!("DGAM({})", index + 1)),
        "pressure" => Some("PRESS".to_string()),
        "multiplier" => Some(format!("TAULM({})", index + 1)),
        _ => user::common_name(ours, index),
    }
}

/// One definition for both symbols: with the underscore that Fortran compilers on Linux append, and without.
macro_rules! export_fric {
    ($symbol:ident) => {
        /// FRIC of Abaqus/Standard: see docs/hosts.md for what each argument means and what is used.
        ///
        /// The hidden string lengths that follow the arguments are not declared: they are not needed, and on every
        /// calling convention in use the caller removes them.
        ///
        /// # Safety
        /// Arguments are as the host's manual describes them.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol(
            lm: *mut i32,
            tau: *mut c_double,
            ddtddg: *mut c_double,
            ddtddp: *mut c_double,
            dslip: *mut c_double,
            sed: *mut c_double,
            sfd: *mut c_double,
            ddtddt: *mut c_double,
            pnewdt: *mut c_double,
            statev: *mut c_double,
            dgam: *const c_double,
            taulm: *const c_double,
            press: *const c_double,
            _dpress: *const c_double,
            _ddpddh: *const c_double,
            _slip: *const c_double,
            kstep: *const i32,
            kinc: *const i32,
            _time: *const c_double,
            _dtime: *const c_double,
            _noel: *const i32,
            ciname: *const c_char,
            _slname: *const c_char,
            _msname: *const c_char,
            _npt: *const i32,
            node: *const i32,
            _npatch: *const i32,
            _coords: *const c_double,
            _rcoord: *const c_double,
            drot: *const c_double,
            _temp: *const c_double,
            _predef: *const c_double,
            nfdir: *const i32,
            _mcrd: *const i32,
            _npred: *const i32,
            nstatv: *const i32,
            chrlngth: *const c_double,
            props: *const c_double,
            nprops: *const i32,
        ) {
            let arguments = Arguments {
                shared: Standard {
                    sfd,
                    pnewdt,
                    ciname,
                    node,
                    kstep,
                    kinc,
                    nstatv,
                    chrlngth,
                    props,
                    nprops,
                },
                lm,
                tau,
                ddtddg,
                ddtddp,
                dslip,
                sed,
                ddtddt,
                statev,
                dgam,
                taulm,
                press,
                drot,
                nfdir,
            };
            // SAFETY: the host's arguments.
            unsafe { arguments.run() }
        }
    };
}

export_fric!(fric_);
export_fric!(fric);
