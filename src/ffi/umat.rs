//! The UMAT face: a material routine as the contact law of interface elements or of a thin layer.
//!
//! All 37 arguments of the usual list, of which few are touched: hosts pass null or stale pointers for the rest
//! (docs/hosts.md). The routine has no way to refuse, so bad input ends the run, after a message.

use super::arguments::{
    Integer, Real, RealOut, Text, array, count, finite, fortran_name, null, properties, read,
    routine,
};
use super::components::{Components, Order, consistent, sticking};
use super::guard;
use super::laws::{ONE, TWO, with_law};
use super::messages::stop;
use crate::error::{Error, Kind};
use crate::law::{Law, Start};
use crate::properties::COMMON;
use crate::state::End;
use std::slice;

/// This host's own properties, from 21 on.
const NAMES: [&str; 5] = ["layout", "scale", "thickness", "tangent", "order"];

/// What they say: where the components are, in what scale, and what DDSDDE is.
struct Arrangement {
    components: Components,
    /// Tangential directions.
    directions: usize,
    /// Whether the sticking tangent is returned whatever slips.
    always_sticking: bool,
    /// How DDSDDE lies in memory; None: as the symbol says.
    order: Option<Order>,
}

impl Arrangement {
    /// From PROPS and the length of the host's vectors.
    fn new(props: &[f64], ntens: usize) -> Result<Self, Error> {
        let mut own = [0.0; NAMES.len()];
        for (own, given) in own.iter_mut().zip(props.iter().skip(COMMON)) {
            *own = *given;
        }
        let bad = |index: usize, expected: &'static str| {
            let error = Error::about(Kind::BadProperty, "PROPS", expected);
            Err(error
                .index(COMMON + index)
                .name(NAMES[index])
                .number(own[index]))
        };
        if let Some(index) = own.iter().position(|value| finite("", *value).is_err()) {
            return bad(index, "must be finite");
        }
        // Not before: a compiler may compare first, and comparing a NaN raises a flag that hosts trap.
        let [layout, scale, thickness, tangent, order] = std::hint::black_box(own);
        let scale = if scale == 0.0 { 1.0 } else { scale };
        // Per layout: the lengths of the host's vectors, and the slots of normal, shear 1, shear 2.
        let (sizes, slots, length): (&[usize], _, _) = if layout == 0.0 {
            (&[2, 3], [0, 1, 2], 1.0)
        } else if layout == 1.0 {
            (&[6], [2, 5, 4], 1.0)
        } else if layout == 2.0 {
            // In the plane (11, 22, 33, 12) the layer's normal is 22, in space (.., 13, 23) it is 33.
            let slots = if ntens == 4 { [1, 3, 3] } else { [2, 4, 5] };
            (&[4, 6], slots, thickness)
        } else {
            return bad(
                0,
                "must be 0 (interface), 1 (interface in 6 slots) or 2 (thin layer)",
            );
        };
        if !(1e-100..=1e100).contains(&scale) {
            return bad(1, "must be 0 (1), or from 1e-100 to 1e100");
        }
        if !(1e-100..=1e100).contains(&length) {
            return bad(2, "must be given, from 1e-100 to 1e100, for a thin layer");
        }
        if tangent != 0.0 && tangent != 1.0 {
            return bad(3, "must be 0 (consistent) or 1 (sticking)");
        }
        let order = if order == 0.0 {
            None
        } else if order == 1.0 {
            Some(Order::RowMajor)
        } else if order == 2.0 {
            Some(Order::ColumnMajor)
        } else {
            return bad(
                4,
                "must be 0 (by symbol), 1 (row by row) or 2 (column by column)",
            );
        };
        if !sizes.contains(&ntens) {
            let expected = format!("must be in {sizes:?} for layout {layout} of PROPS(21)");
            return Err(Error::about(Kind::BadInput, "NTENS", expected).count(ntens));
        }
        Ok(Arrangement {
            components: Components {
                size: ntens,
                slots,
                weights: [scale; 3],
                length,
            },
            directions: if ntens == 2 || ntens == 4 { 1 } else { 2 },
            always_sticking: tangent == 1.0,
            order,
        })
    }

    /// What the host calls an argument of the library.
    fn host_name(&self, ours: &str, index: Option<usize>) -> Option<String> {
        match (ours, index) {
            ("opening", Some(index)) => {
                let slot = 1 + self.components.slots.get(index)?;
                Some(format!("jump of STRAN({slot}) + DSTRAN({slot})"))
            }
            _ => fortran_name(ours, index),
        }
    }
}

routine! {
    /// UMAT: see docs/hosts.md for what each argument means and what is used.
    ///
    /// DDSDDE is column-major behind `umat_`, as Fortran's, and row-major behind `umat`, as C's; PROPS(25) may say
    /// otherwise.
    struct Arguments of umat_(Order::ColumnMajor), umat(Order::RowMajor);
    take stress: RealOut, take statev: RealOut, take ddsdde: RealOut, skip sse: RealOut, skip spd: RealOut,
    skip scd: RealOut, skip rpl: RealOut, skip ddsddt: RealOut, skip drplde: RealOut, skip drpldt: RealOut,
    take stran: Real, take dstran: Real, skip time: Real, skip dtime: Real, skip temp: Real, skip dtemp: Real,
    skip predef: Real, skip dpred: Real, skip cmname: Text, skip ndi: Integer, skip nshr: Integer,
    take ntens: Integer, take nstatv: Integer, take props: Real, take nprops: Integer, skip coords: Real,
    skip drot: Real, skip pnewdt: RealOut, skip celent: Real, skip dfgrd0: Real, skip dfgrd1: Real,
    take noel: Integer, take npt: Integer, skip layer: Integer, skip kspt: Integer, take kstep: Integer,
    take kinc: Integer,
}

impl Arguments {
    /// Runs the routine; bad input ends the run.
    ///
    /// # Safety
    /// The pointers are what their names say, or null.
    unsafe fn run(&self, order: Order) {
        let mut arrangement = None;
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            let props = properties(self.props, self.nprops)?;
            let arrangement =
                arrangement.insert(Arrangement::new(props, count("NTENS", self.ntens)?)?);
            let nstate = count("NSTATV", self.nstatv)?;
            match arrangement.directions {
                1 => with_law(&ONE, props, nstate, |law| {
                    self.update(law, arrangement, order)
                }),
                _ => with_law(&TWO, props, nstate, |law| {
                    self.update(law, arrangement, order)
                }),
            }
        });
        if let Err(error) = outcome {
            let words = error.words(|ours, index| match &arrangement {
                Some(arrangement) => arrangement.host_name(ours, index),
                None => fortran_name(ours, index),
            });
            // SAFETY: null or readable.
            let number = |pointer| unsafe { read("", pointer) }.unwrap_or(0);
            stop(&format!(
                "mepc UMAT: element {}, integration point {}, step {}, increment {}: {words}",
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
        let (mut start, mut end) = (Start::new(), End::new());
        // SAFETY: sizes as the host declares them.
        unsafe {
            let gcr = law.critical_slip(0.0)?;
            law.read(
                array("STATEV", self.statev, law.layout().used())?,
                &mut start,
            )?;
            let stran = array("STRAN", self.stran, components.size)?;
            let dstran = array("DSTRAN", self.dstran, components.size)?;
            let mut total = [0.0; 6];
            for slot in &components.slots[..1 + N] {
                for (name, values) in [("STRAN", stran), ("DSTRAN", dstran)] {
                    total[*slot] +=
                        finite(name, values[*slot]).map_err(|error| error.index(*slot))?;
                }
            }
            if self.stress.is_null() {
                return Err(null("STRESS"));
            }
            if self.ddsdde.is_null() {
                return Err(null("DDSDDE"));
            }
            let (normal, tangential) = components.opening::<N>(&total);
            let response =
                law.interface_from(&mut start, gcr, normal, &tangential, 1.0, &mut end)?;
            let operator = if arrangement.always_sticking {
                sticking(law, gcr, &response)
            } else {
                consistent(&response)
            };
            components.write_forces(&response, self.stress);
            let order = arrangement.order.unwrap_or(order);
            components.write_operator::<N>(&operator, order, self.ddsdde);
            // NSTATV numbers, all of them read: there is no other reference to them.
            law.layout().write(
                &end,
                slice::from_raw_parts_mut(self.statev, law.layout().nstate),
            );
        }
        Ok(())
    }
}
