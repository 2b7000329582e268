//! The UINTER face: the user interface routine of Abaqus/Standard, all 47 arguments.
//!
//! The argument list was taken from working sources; what is not confirmed is marked in docs/hosts.md. Penetration and
//! compression are positive here, so the normal component changes its sign on the way in and out.

use super::components::{Components, Order, consistent, uncoupled};
use super::guard;
use super::host::{Place, Severity, report};
use super::user::{
    self, Laws, StateCopy, array, count, cut_back, name, properties, read, required, turn, vector,
    write,
};
use crate::error::{Error, Kind};
use crate::law::{Law, check_finite};
use crate::memory::Vector;
use libc::{c_char, c_double};
use std::slice;

/// Penetration below this stands for a point without a partner (the host passes -1e36).
const UNPAIRED: f64 = -1e35;
/// Where the tangential jump of the last increment is in a state.
const JUMP: usize = 5;

/// The arguments that are used.
#[derive(Clone, Copy)]
struct Arguments {
    stress: *mut c_double,
    ddsddr: *mut c_double,
    amki: *mut c_double,
    amski: *mut c_double,
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
    ciname: *const c_char,
    props: *const c_double,
    drot: *const c_double,
    chrlngth: *const c_double,
    node: *const i32,
    ndir: *const i32,
    nstatv: *const i32,
    nprops: *const i32,
    kstep: *const i32,
    kinc: *const i32,
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
                2 => user::ONE.with_borrow_mut(|laws| self.update(laws)),
                3 => user::TWO.with_borrow_mut(|laws| self.update(laws)),
                other => Err(Error::new(
                    Kind::BadInput,
                    format!("NDIR = {other}: must be 2 or 3 directions, the normal included"),
                )),
            }
        });
        if let Err(error) = outcome {
            // SAFETY: as the caller says. A second failure in here has nothing left to say.
            let _ = guard(|| unsafe {
                self.refuse(&error);
                Ok(())
            });
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NDIR = 1 + N.
    unsafe fn update<const N: usize>(&self, laws: &mut Laws<N>) -> Result<(), Error> {
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            let law = self.law(laws)?;
            let gcr = law.critical_slip(self.characteristic_length())?;
            let mut copy = StateCopy::new();
            let state0 = user::state("STATEV", law.layout(), self.statev, &mut copy)?;
            if N == 2 {
                turn(self.drot, law.layout(), state0)?;
            }
            required(
                ["STRESS", "DDSDDR", "SED", "SFD", "PNEWDT"],
                [self.stress, self.ddsddr, self.sed, self.sfd, self.pnewdt],
            )?;
            let penetration = read("RDISP", self.rdisp)?;
            check_finite(&"RDISP(1)", penetration)?;
            let unpaired = penetration <= UNPAIRED;
            // The increment is the host's: RDISP may start anew when the point slides onto another face.
            let slip = if unpaired {
                Vector::<N>::zeros()
            } else {
                vector("DRDISP", array("DRDISP", self.drdisp, 1 + N)?[1..].as_ptr())?
            };
            let jump = Vector::<N>::from_column_slice(&state0[JUMP..JUMP + N]) + slip;
            // Everything has been read: from here on STATEV is only written.
            let state1 = slice::from_raw_parts_mut(self.statev, law.layout().nstate);
            let response = law.interface(gcr, -penetration, &jump, state0, state1)?;
            let components = Self::components::<N>();
            components.write_forces(&response, self.stress);
            components.write_operator::<N>(&consistent(&response), Order::ColumnMajor, self.ddsddr);
            self.clear_the_rest(1 + N);
            *self.sed = response.friction.stored;
            *self.sfd = response.friction.dissipated;
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

    /// # Safety
    /// As [`Arguments::run`].
    unsafe fn law<'a, const N: usize>(&self, laws: &'a mut Laws<N>) -> Result<&'a Law<N>, Error> {
        // SAFETY: PROPS has NPROPS entries by the host's word.
        unsafe {
            laws.get(
                properties(self.props, self.nprops)?,
                count("NSTATV", self.nstatv)?,
            )
        }
    }

    /// The characteristic length, 0 where the host has none.
    ///
    /// # Safety
    /// As [`Arguments::run`].
    unsafe fn characteristic_length(&self) -> f64 {
        // SAFETY: null or readable.
        unsafe { read("CHRLNGTH", self.chrlngth) }.unwrap_or(0.0)
    }

    /// Leaves STRESS and STATEV as they were, offers the stiffness of the closed and sticking contact, and asks for a
    /// smaller increment.
    ///
    /// # Safety
    /// As [`Arguments::run`].
    #[cold]
    unsafe fn refuse(&self, error: &Error) {
        // SAFETY: null pointers are skipped, sizes as the host declares them.
        unsafe {
            let number = |pointer: *const i32| read("", pointer).unwrap_or(0);
            let contact = name(self.ciname);
            report(
                &Place {
                    routine: "UINTER",
                    contact: &contact,
                    node: number(self.node),
                    step: number(self.kstep),
                    increment: number(self.kinc),
                },
                Severity::Error,
                error,
            );
            cut_back(self.pnewdt);
            write(self.sfd, &[0.0]);
            match number(self.ndir) {
                2 => user::ONE.with_borrow_mut(|laws| self.offer_sticking(laws)),
                3 => user::TWO.with_borrow_mut(|laws| self.offer_sticking(laws)),
                _ => {}
            }
        }
    }

    /// # Safety
    /// As [`Arguments::run`], NDIR = 1 + N.
    unsafe fn offer_sticking<const N: usize>(&self, laws: &mut Laws<N>) {
        // SAFETY: as the caller says; a law that cannot be made has no stiffness.
        unsafe {
            let stiffness = self.law(laws).and_then(|law| {
                let gcr = law.critical_slip(self.characteristic_length())?;
                let tangential = law.sticking_stiffness(gcr, read("STRESS", self.stress)?);
                Ok((law.properties().kn, tangential))
            });
            let finite =
                |stiffness: &(f64, f64)| stiffness.0.is_finite() && stiffness.1.is_finite();
            let (normal, tangential) = stiffness.ok().filter(finite).unwrap_or((0.0, 0.0));
            let operator = uncoupled(normal, tangential);
            Self::components::<N>().write_operator::<N>(&operator, Order::ColumnMajor, self.ddsddr);
        }
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
                stress,
                ddsddr,
                amki,
                amski,
                ddfddt,
                ddsddt,
                ddfddr,
                statev,
                sed,
                sfd,
                spd,
                svd,
                scd,
                pnewdt,
                rdisp,
                drdisp,
                ciname,
                props,
                drot,
                chrlngth,
                node,
                ndir,
                nstatv,
                nprops,
                kstep,
                kinc,
                lopenclose,
            };
            // SAFETY: the host's arguments.
            unsafe { arguments.run() }
        }
    };
}

export_uinter!(uinter_);
export_uinter!(uinter);
