//! How the routines of Abaqus/Standard run and refuse: FRIC and UINTER share their arguments and what they offer then.

use super::arguments::{count, fortran_name, name, properties, read, write};
use super::guard;
use super::laws::{ONE, TWO, ThreadLaws, with_law};
use super::messages::{Place, Severity, report};
use crate::error::{Error, Kind};
use crate::law::{Law, check_pressure, default_state_size};
use crate::number::finite;
use libc::{c_char, c_double};

/// What a refused increment is cut to.
pub(super) const CUTBACK: f64 = 0.5;

/// The arguments that both routines have.
#[derive(Clone, Copy)]
pub(super) struct Shared {
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

/// The shared ones among a routine's arguments.
macro_rules! shared {
    ($arguments:expr) => {
        $crate::ffi::refusal::Shared {
            sfd: $arguments.sfd,
            pnewdt: $arguments.pnewdt,
            ciname: $arguments.ciname,
            node: $arguments.node,
            kstep: $arguments.kstep,
            kinc: $arguments.kinc,
            nstatv: $arguments.nstatv,
            chrlngth: $arguments.chrlngth,
            props: $arguments.props,
            nprops: $arguments.nprops,
        }
    };
}
pub(super) use shared;

impl Shared {
    /// PROPS, NPROPS long.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    #[inline(always)]
    pub(super) unsafe fn props<'a>(&self) -> Result<&'a [f64], Error> {
        // SAFETY: as the caller says.
        unsafe { properties(self.props, self.nprops) }
    }

    /// The characteristic length, 0 where the host has none.
    ///
    /// # Safety
    /// As [`Shared::props`].
    #[inline(always)]
    pub(super) unsafe fn characteristic_length(&self) -> f64 {
        // SAFETY: null or readable.
        unsafe { read("CHRLNGTH", self.chrlngth) }.unwrap_or(0.0)
    }
}

/// A routine of Abaqus/Standard for a contact point: what FRIC and UINTER do alike.
pub(super) trait Routine {
    /// As the user knows it.
    const NAME: &'static str;
    /// What it calls the number of its directions, how many of them are tangential by that number, and what it may be.
    const DIRECTIONS: (&'static str, fn(i32) -> i32, &'static str);

    /// Its number of directions.
    fn directions(&self) -> *const i32;

    /// The arguments that both routines have.
    fn shared(&self) -> Shared;

    /// What the host calls an argument of the library.
    fn host_name(ours: &str, index: Option<usize>) -> Option<String> {
        fortran_name(ours, index)
    }

    /// The update of a point with N tangential directions.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn update<const N: usize>(
        &self,
        law: &Law<N>,
        props: &[f64],
        shared: &Shared,
    ) -> Result<(), Error>;

    /// What a refused call gives besides: outputs as if the point stuck; the stress and the state stay as they were.
    ///
    /// # Safety
    /// As [`Routine::update`].
    unsafe fn offer<const N: usize>(&self, shared: &Shared);

    /// What the host is told besides, whatever the number of directions.
    ///
    /// # Safety
    /// As [`Routine::update`].
    unsafe fn flag(&self) {}

    /// Runs the routine; whatever goes wrong is told to the user and asks the host for a smaller increment.
    ///
    /// # Safety
    /// As [`Routine::update`].
    #[inline(always)]
    unsafe fn run(&self) {
        let shared = self.shared();
        let (name, tangential, expected) = Self::DIRECTIONS;
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            let directions = read(name, self.directions())?;
            match tangential(directions) {
                1 => self.with(&ONE, &shared),
                2 => self.with(&TWO, &shared),
                _ => Err(Error::about(Kind::BadInput, name, expected).count(directions)),
            }
        });
        if let Err(error) = outcome {
            // SAFETY: as the caller says.
            unsafe { self.refuse(&shared, &error) }
        }
    }

    /// # Safety
    /// As [`Routine::update`].
    #[inline(always)]
    unsafe fn with<const N: usize>(
        &self,
        laws: &'static ThreadLaws<N>,
        shared: &Shared,
    ) -> Result<(), Error> {
        // SAFETY: as the caller says.
        unsafe {
            let props = shared.props()?;
            let nstate = count("NSTATV", shared.nstatv)?;
            with_law(laws, props, nstate, |law| self.update(law, props, shared))
        }
    }

    /// Ends a refused call: the routine's own outputs are written, the host is asked for a smaller increment, and the
    /// user is told. In this order, so that whatever happens while telling, the outputs are there.
    ///
    /// # Safety
    /// As [`Routine::update`].
    #[cold]
    unsafe fn refuse(&self, shared: &Shared, error: &Error) {
        // SAFETY: as the caller says; a number that is not there is 0.
        let number = |pointer| unsafe { read("", pointer) }.unwrap_or(0);
        // A second failure in here has nothing left to say.
        let _ = guard(|| {
            // SAFETY: as the caller says; null pointers are skipped.
            let contact = unsafe {
                self.flag();
                match Self::DIRECTIONS.1(number(self.directions())) {
                    1 => self.offer::<1>(shared),
                    2 => self.offer::<2>(shared),
                    // Nobody knows how long the arrays are.
                    _ => {}
                }
                write(shared.sfd, &[0.0]);
                cut_back(shared.pnewdt);
                name(shared.ciname)
            };
            let place = Place {
                routine: Self::NAME,
                contact: &contact,
                node: number(shared.node),
                step: number(shared.kstep),
                increment: number(shared.kinc),
            };
            report(&place, Severity::Error, error, &Self::host_name);
            Ok(())
        });
    }
}

/// Asks for a smaller increment.
///
/// # Safety
/// `pnewdt` is null or readable and writable.
pub(super) unsafe fn cut_back(pnewdt: *mut c_double) {
    // SAFETY: as the caller says.
    if let Some(pnewdt) = unsafe { pnewdt.as_mut() }
        // By bits: it may hold anything.
        && pnewdt.to_bits() > CUTBACK.to_bits()
    {
        *pnewdt = CUTBACK;
    }
}

/// Normal and tangential stiffness of the closed and sticking contact under this pressure, zero where they cannot be
/// known.
///
/// They follow from the properties alone: neither NSTATV nor the laws that the thread keeps may be at hand.
///
/// # Safety
/// As [`Routine::update`].
pub(super) unsafe fn sticking<const N: usize>(
    shared: &Shared,
    pressure: Result<f64, Error>,
) -> [f64; 2] {
    // SAFETY: as the caller says.
    let stiffness = pressure.and_then(|pressure| unsafe {
        check_pressure(pressure)?;
        let props = shared.props()?;
        let law = Law::<N>::new(props, default_state_size(props, N)?)?;
        let gcr = law.critical_slip(shared.characteristic_length())?;
        Ok([law.properties().kn, law.sticking_stiffness(gcr, pressure)])
    });
    let known = |stiffness: &[f64; 2]| stiffness.iter().all(|k| finite(*k));
    stiffness.ok().filter(known).unwrap_or_default()
}
