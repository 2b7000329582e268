//! The UINTER face: the user interface routine of Abaqus/Standard, all 47 arguments.
//!
//! The argument list was taken from working sources; what is not confirmed is marked in docs/hosts.md. Penetration and
//! compression are positive here, so the normal component changes its sign on the way in and out.

use super::components::{Components, Order, consistent, uncoupled};
use super::guard;
use super::standard::Standard;
use super::user::{self, read, required, vector, write};
use crate::error::{Error, Kind};
use crate::law::{Law, check_finite};
use crate::memory::{Curve, Vector};
use libc::{c_char, c_double};
use std::slice;

/// Penetration below this stands for a point without a partner (the host passes -1e36).
const UNPAIRED: f64 = -1e35;

/// The arguments that are used.
#[derive(Clone, Copy)]
struct Arguments {
    shared: Standard,
    stress: *mut c_double,
    ddsddr: *mut c_double,
    amki: *mut c_double,
    amski: *mut c_double,
    ddfddt: *mut c_double,
    ddsddt: *mut c_double,
    ddfddr: *mut c_double,
    statev: *mut c_double,
    sed: *mut c_double,
    spd: *mut c_double,
    svd: *mut c_double,
    scd: *mut c_double,
    rdisp: *const c_double,
    drdisp: *const c_double,
    drot: *const c_double,
    ndir: *const i32,
    lopenclose: *mut i32,
}

impl Arguments {
    /// Runs the routine; whatever goes wrong is told to the user and asks the host for a smaller increment.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn run(&self) {
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            match read("NDIR", self.ndir)? {
                2 => self.shared.with_law(&user::ONE, |law| self.update(law)),
                3 => self.shared.with_law(&user::TWO, |law| self.update(law)),
                other => Err(Error::new(
                    Kind::BadInput,
                    format!("NDIR = {other}: must be 2 or 3 directions, the normal included"),
                )),
            }
        });
        if let Err(error) = outcome {
            let error = user::in_host_words(error, host_name);
            // SAFETY: as the caller says.
            unsafe { self.shared.refuse("UINTER", &error, || self.offer()) }
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NDIR = 1 + N.
    unsafe fn update<const N: usize>(&self, law: &Law<N>) -> Result<(), Error> {
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            let gcr = law.critical_slip(self.shared.characteristic_length())?;
            let mut memory = Curve::new();
            let header = user::read_turned("STATEV", law, self.statev, self.drot, &mut memory)?;
            required(
                ["STRESS", "DDSDDR", "SED", "SFD", "PNEWDT"],
                [
                    self.stress,
                    self.ddsddr,
                    self.sed,
                    self.shared.sfd,
                    self.shared.pnewdt,
                ],
            )?;
            let penetration = read("RDISP", self.rdisp)?;
            check_finite(&"RDISP(1)", penetration)?;
            let unpaired = penetration <= UNPAIRED;
            // The increment is the host's: RDISP may start anew when the point slides onto another face.
            let slip = if unpaired {
                Vector::<N>::zeros()
            } else {
                vector("DRDISP", self.drdisp, 2)?
            };
            let jump = Vector::<N>::from_column_slice(&header.jump[..N]) + slip;
            // Everything has been read: from here on STATEV is only written.
            let state1 = slice::from_raw_parts_mut(self.statev, law.layout().nstate);
            let response =
                law.interface_from(header, &mut memory, gcr, -penetration, &jump, state1)?;
            let components = Self::components::<N>();
            components.write_forces(&response, self.stress);
            components.write_operator::<N>(&consistent(&response), Order::ColumnMajor, self.ddsddr);
            self.clear_the_rest(1 + N);
            *self.sed = response.friction.stored;
            *self.shared.sfd = response.friction.dissipated;
            if let Some(open_or_closed) = self.lopenclose.as_mut() {
                *open_or_closed = i32::from(response.normal_traction < 0.0);
            }
            Ok(())
        }
    }

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
    /// As [`Arguments::run`].
    unsafe fn clear_the_rest(&self, ndir: usize) {
        let zeros = [0.0; 9];
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            for matrix in [self.amki, self.amski] {
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

    /// What a refused call gives: STRESS and STATEV stay as they were.
    ///
    /// # Safety
    /// As [`Arguments::run`].
    unsafe fn offer(&self) {
        // SAFETY: as the caller says.
        unsafe {
            match read("NDIR", self.ndir) {
                Ok(2) => self.offer_sticking::<1>(),
                Ok(3) => self.offer_sticking::<2>(),
                // Nobody knows how long the arrays are.
                _ => {}
            }
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NDIR = 1 + N.
    unsafe fn offer_sticking<const N: usize>(&self) {
        // SAFETY: null, or sizes as the host declares them.
        unsafe {
            let pressure = read("STRESS", self.stress.cast_const());
            let [normal, tangential] = self.shared.sticking::<N>(pressure);
            let operator = uncoupled(normal, tangential);
            Self::components::<N>().write_operator::<N>(&operator, Order::ColumnMajor, self.ddsddr);
            self.clear_the_rest(1 + N);
        }
    }
}

/// What the host calls an argument of the library.
fn host_name(ours: &str, index: usize) -> Option<String> {
    match (ours, index) {
        // An opening is a negative penetration.
        ("opening", 0) => Some("-RDISP(1)".to_string()),
        ("opening", _) => Some(format!("DRDISP({})", index + 1)),
        _ => user::common_name(ours, index),
    }
}

/// One definition for both symbols: with the underscore that Fortran compilers on Linux append, and without.
macro_rules! export_uinter {
    ($symbol:ident) => {
        /// UINTER of Abaqus/Standard: see docs/hosts.md for what each argument means and what is used.
        ///
        /// The hidden string lengths that follow the arguments are not declared: they are not needed.
        ///
        /// # Safety
        /// Arguments are as the host's manual describes them.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol(
            stress: *mut c_double,
            ddsddr: *mut c_double,
            amki: *mut c_double,
            amski: *mut c_double,
            _flux: *mut c_double,
            ddfddt: *mut c_double,
            ddsddt: *mut c_double,
            ddfddr: *mut c_double,
            statev: *mut c_double,
            sed: *mut c_double,
            sfd: *mut c_double,
            spd: *mut c_double,
            svd: *mut c_double,
            scd: *mut c_double,
            pnewdt: *mut c_double,
            rdisp: *const c_double,
            drdisp: *const c_double,
            _temp: *const c_double,
            _dtemp: *const c_double,
            _predef: *const c_double,
            _dpred: *const c_double,
            _time: *const c_double,
            _dtime: *const c_double,
            _freqr: *const c_double,
            ciname: *const c_char,
            _slname: *const c_char,
            _msname: *const c_char,
            props: *const c_double,
            _coords: *const c_double,
            _alocaldir: *const c_double,
            drot: *const c_double,
            _area: *const c_double,
            chrlngth: *const c_double,
            node: *const i32,
            ndir: *const i32,
            nstatv: *const i32,
            _npred: *const i32,
            nprops: *const i32,
            _mcrd: *const i32,
            kstep: *const i32,
            kinc: *const i32,
            _kit: *const i32,
            _linper: *const i32,
            lopenclose: *mut i32,
            _lstate: *mut i32,
            _lsdi: *mut i32,
            _lprint: *const i32,
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
                stress,
                ddsddr,
                amki,
                amski,
                ddfddt,
                ddsddt,
                ddfddr,
                statev,
                sed,
                spd,
                svd,
                scd,
                rdisp,
                drdisp,
                drot,
                ndir,
                lopenclose,
            };
            // SAFETY: the host's arguments.
            unsafe { arguments.run() }
        }
    };
}

export_uinter!(uinter_);
export_uinter!(uinter);
