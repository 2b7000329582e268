//! The UMAT face: a material routine as the contact law of interface elements or of a thin layer.
//!
//! All 37 arguments of the usual list, of which few are touched: hosts pass null or stale pointers for the rest
//! (docs/hosts.md). The routine has no way to refuse, so bad input ends the run, after a message.

use super::components::{Components, Order, consistent, sticking};
use super::guard;
use super::host::stop;
use super::user::{self, StateCopy, array, count, null, properties, read, with_law};
use crate::error::{Error, Kind};
use crate::law::{Law, check_finite};
use crate::properties::COMMON;
use libc::{c_char, c_double};
use std::slice;

/// This host's own properties follow the common ones: where the components are, and in what scale.
struct Arrangement {
    components: Components,
    /// Tangential directions.
    directions: usize,
    /// Whether the sticking tangent is returned whatever slips.
    always_sticking: bool,
}

impl Arrangement {
    /// From PROPS 13 (layout), 14 (scale), 15 (thickness) and 16 (tangent), and the length of the host's vectors.
    fn new(props: &[f64], ntens: usize) -> Result<Self, Error> {
        let entry = |number: usize, default: f64| props.get(number - 1).copied().unwrap_or(default);
        let bad = |number: usize, name: &str, allowed: &str| {
            let value = entry(number, f64::NAN);
            let message = format!("PROPS({number}) {name} = {value}: must be {allowed}");
            Err(Error::new(Kind::BadProperty, message))
        };
        let layout = entry(COMMON + 1, 0.0);
        let scale = entry(COMMON + 2, 1.0);
        let thickness = entry(COMMON + 3, 0.0);
        let tangent = entry(COMMON + 4, 0.0);
        // Per layout: the lengths of the host's vectors, and the slots of normal, shear 1, shear 2.
        let (sizes, slots, length): (&[usize], _, _) = if layout == 0.0 {
            (&[2, 3], [0, 1, 2], 1.0)
        } else if layout == 1.0 {
            (&[6], [2, 5, 4], 1.0)
        } else if layout == 2.0 {
            (&[6], [2, 4, 5], thickness)
        } else {
            return bad(
                COMMON + 1,
                "layout",
                "0 (interface), 1 (interface in 6 slots) or 2 (thin layer)",
            );
        };
        if !(scale > 0.0 && scale.is_finite()) {
            return bad(COMMON + 2, "scale", "finite and > 0");
        }
        if !(length > 0.0 && length.is_finite()) {
            return bad(
                COMMON + 3,
                "thickness",
                "given, finite and > 0 for a thin layer",
            );
        }
        if tangent != 0.0 && tangent != 1.0 {
            return bad(COMMON + 4, "tangent", "0 (consistent) or 1 (sticking)");
        }
        if !sizes.contains(&ntens) {
            return Err(Error::new(
                Kind::BadInput,
                format!("NTENS = {ntens}: PROPS(13) layout {layout} is for NTENS in {sizes:?}"),
            ));
        }
        Ok(Arrangement {
            components: Components {
                size: ntens,
                slots,
                weights: [scale; 3],
                length,
            },
            directions: if ntens == 2 { 1 } else { 2 },
            always_sticking: tangent == 1.0,
        })
    }
}

/// The arguments that are used.
struct Arguments {
    stress: *mut c_double,
    statev: *mut c_double,
    ddsdde: *mut c_double,
    stran: *const c_double,
    dstran: *const c_double,
    ntens: *const i32,
    nstatv: *const i32,
    props: *const c_double,
    nprops: *const i32,
    noel: *const i32,
    npt: *const i32,
    kstep: *const i32,
    kinc: *const i32,
}

impl Arguments {
    /// Runs the routine; bad input ends the run.
    ///
    /// # Safety
    /// The pointers are what their names say, or null.
    unsafe fn run(&self, order: Order) {
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            let props = properties(self.props, self.nprops)?;
            let arrangement = Arrangement::new(props, count("NTENS", self.ntens)?)?;
            let nstate = count("NSTATV", self.nstatv)?;
            match arrangement.directions {
                1 => with_law(&user::ONE, props, nstate, |law| {
                    self.update(law, &arrangement, order)
                }),
                _ => with_law(&user::TWO, props, nstate, |law| {
                    self.update(law, &arrangement, order)
                }),
            }
        });
        if let Err(error) = outcome {
            let error = user::in_host_words(error, user::common_name);
            // SAFETY: null or readable.
            let number = |pointer| unsafe { read("", pointer) }.unwrap_or(0);
            stop(&format!(
                "mepc UMAT: element {}, integration point {}, step {}, increment {}: {error}",
                number(self.noel),
                number(self.npt),
                number(self.kstep),
                number(self.kinc)
            ));
        }
    }

    /// # Safety
    /// As [`Arguments::run`]; vectors are NTENS long.
    unsafe fn update<const N: usize>(
        &self,
        law: &Law<N>,
        arrangement: &Arrangement,
        order: Order,
    ) -> Result<(), Error> {
        let components = &arrangement.components;
        // SAFETY: sizes as the host declares them.
        unsafe {
            let gcr = law.critical_slip(0.0)?;
            let mut copy = StateCopy::new();
            let state0 = user::state("STATEV", law.layout(), self.statev, &mut copy)?;
            let stran = array("STRAN", self.stran, components.size)?;
            let dstran = array("DSTRAN", self.dstran, components.size)?;
            let mut total = [0.0; 6];
            for slot in &components.slots[..1 + N] {
                for (name, values) in [("STRAN", stran), ("DSTRAN", dstran)] {
                    check_finite(&format_args!("{name}({})", slot + 1), values[*slot])?;
                    total[*slot] += values[*slot];
                }
            }
            if self.stress.is_null() {
                return Err(null("STRESS"));
            }
            if self.ddsdde.is_null() {
                return Err(null("DDSDDE"));
            }
            let (normal, tangential) = components.opening::<N>(&total);
            // Everything has been read: from here on STATEV is only written.
            let state1 = slice::from_raw_parts_mut(self.statev, law.layout().nstate);
            let response = law.interface(gcr, normal, &tangential, state0, state1);
            let response = response.map_err(|error| {
                user::in_host_words(error, |ours, index| {
                    let slot = 1 + components.slots.get(index)?;
                    (ours == "opening").then(|| format!("jump of STRAN({slot}) + DSTRAN({slot})"))
                })
            })?;
            let operator = if arrangement.always_sticking {
                sticking(law, gcr, &response)
            } else {
                consistent(&response)
            };
            components.write_forces(&response, self.stress);
            components.write_operator::<N>(&operator, order, self.ddsdde);
        }
        Ok(())
    }
}

/// One definition for both symbols, which differ in the order of DDSDDE.
macro_rules! export_umat {
    ($symbol:ident, $order:expr, $words:literal) => {
        /// UMAT: see docs/hosts.md for what each argument means and what is used.
        #[doc = $words]
        ///
        /// The hidden length of CMNAME is not declared: it is not needed.
        ///
        /// # Safety
        /// The arguments that are used (see docs/hosts.md) are as their names say; the others may be anything.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol(
            stress: *mut c_double,
            statev: *mut c_double,
            ddsdde: *mut c_double,
            _sse: *mut c_double,
            _spd: *mut c_double,
            _scd: *mut c_double,
            _rpl: *mut c_double,
            _ddsddt: *mut c_double,
            _drplde: *mut c_double,
            _drpldt: *mut c_double,
            stran: *const c_double,
            dstran: *const c_double,
            _time: *const c_double,
            _dtime: *const c_double,
            _temp: *const c_double,
            _dtemp: *const c_double,
            _predef: *const c_double,
            _dpred: *const c_double,
            _cmname: *const c_char,
            _ndi: *const i32,
            _nshr: *const i32,
            ntens: *const i32,
            nstatv: *const i32,
            props: *const c_double,
            nprops: *const i32,
            _coords: *const c_double,
            _drot: *const c_double,
            _pnewdt: *mut c_double,
            _celent: *const c_double,
            _dfgrd0: *const c_double,
            _dfgrd1: *const c_double,
            noel: *const i32,
            npt: *const i32,
            _layer: *const i32,
            _kspt: *const i32,
            kstep: *const i32,
            kinc: *const i32,
        ) {
            let arguments = Arguments {
                stress,
                statev,
                ddsdde,
                stran,
                dstran,
                ntens,
                nstatv,
                props,
                nprops,
                noel,
                npt,
                kstep,
                kinc,
            };
            // SAFETY: the host's arguments.
            unsafe { arguments.run($order) }
        }
    };
}

export_umat!(
    umat_,
    Order::ColumnMajor,
    "DDSDDE is column-major, as Fortran's."
);
export_umat!(umat, Order::RowMajor, "DDSDDE is row-major, as C's.");
