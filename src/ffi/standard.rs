//! What FRIC and UINTER, the routines of Abaqus/Standard, share: arguments, the law they ask for, and how they refuse.

use super::guard;
use super::host::{Place, Severity, report};
use super::user::{ThreadLaws, count, cut_back, name, properties, read, with_law, write};
use crate::error::Error;
use crate::law::{Law, check_pressure, default_state_size};
use libc::{c_char, c_double};

/// The arguments that both routines use alike.
#[derive(Clone, Copy)]
pub(super) struct Standard {
    pub sfd: *mut c_double,
    pub pnewdt: *mut c_double,
    pub ciname: *const c_char,
    pub node: *const i32,
    pub kstep: *const i32,
    pub kinc: *const i32,
    pub nstatv: *const i32,
    pub chrlngth: *const c_double,
    pub props: *const c_double,
    pub nprops: *const i32,
}

impl Standard {
    /// Runs `body` with the law that PROPS and NSTATV ask for.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    #[inline(always)]
    pub(super) unsafe fn with_law<const N: usize>(
        &self,
        laws: &'static ThreadLaws<N>,
        body: impl FnOnce(&Law<N>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        // SAFETY: as the caller says.
        let (props, nstate) = unsafe {
            let props = properties(self.props, self.nprops)?;
            (props, count("NSTATV", self.nstatv)?)
        };
        with_law(laws, props, nstate, body)
    }

    /// The characteristic length, 0 where the host has none.
    ///
    /// # Safety
    /// As [`Standard::with_law`].
    #[inline(always)]
    pub(super) unsafe fn characteristic_length(&self) -> f64 {
        // SAFETY: null or readable.
        unsafe { read("CHRLNGTH", self.chrlngth) }.unwrap_or(0.0)
    }

    /// Ends a refused call: `offer` writes the routine's own outputs, the host is asked for a smaller increment, and
    /// the user is told. In this order, so that whatever happens while telling, the outputs are there.
    ///
    /// # Safety
    /// As [`Standard::with_law`].
    #[cold]
    pub(super) unsafe fn refuse(&self, routine: &str, error: &Error, offer: impl FnOnce()) {
        // SAFETY: as the caller says; a number that is not there is 0.
        let number = |pointer| unsafe { read("", pointer) }.unwrap_or(0);
        // A second failure in here has nothing left to say.
        let _ = guard(|| {
            offer();
            // SAFETY: as the caller says; null pointers are skipped.
            let contact = unsafe {
                write(self.sfd, &[0.0]);
                cut_back(self.pnewdt);
                name(self.ciname)
            };
            let place = Place {
                routine,
                contact: &contact,
                node: number(self.node),
                step: number(self.kstep),
                increment: number(self.kinc),
            };
            report(&place, Severity::Error, error);
            Ok(())
        });
    }

    /// Normal and tangential stiffness of the closed and sticking contact under this pressure, zero where they cannot
    /// be known.
    ///
    /// They follow from the properties alone: neither NSTATV nor the laws that the thread keeps may be at hand.
    ///
    /// # Safety
    /// As [`Standard::with_law`].
    pub(super) unsafe fn sticking<const N: usize>(&self, pressure: Result<f64, Error>) -> [f64; 2] {
        // SAFETY: as the caller says.
        let stiffness = pressure.and_then(|pressure| unsafe {
            check_pressure(pressure)?;
            let props = properties(self.props, self.nprops)?;
            let law = Law::<N>::new(props, default_state_size(props, N)?)?;
            let gcr = law.critical_slip(self.characteristic_length())?;
            Ok([law.properties().kn, law.sticking_stiffness(gcr, pressure)])
        });
        let finite = |stiffness: &[f64; 2]| stiffness.iter().all(|k| k.is_finite());
        stiffness.ok().filter(finite).unwrap_or_default()
    }
}
