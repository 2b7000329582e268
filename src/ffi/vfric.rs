//! The VFRIC and VFRICTION faces: the user friction routines of Abaqus/Explicit, double precision.
//!
//! The argument lists were taken from working sources; what is not confirmed is marked in docs/hosts.md. Both hand
//! over a block of contact points and take **forces** against the slip. Their first direction is that of the current
//! slip and turns with every increment, so the memory is kept in a frame of its own, made from the normal.

use super::arguments::{
    Integer, Real, RealOut, Text, array, count, finite, fortran_name, name, null, positive,
    properties, read, routine, write,
};
use super::guard;
use super::laws::{ONE, TWO, ThreadLaws, mu_factor, with_law};
use super::messages::{Place, Severity, report};
use crate::error::{Error, Kind};
use crate::law::{Law, SQUARED, Start, check_within};
use crate::memory::Vector;
use crate::number::within;
use crate::state::End;
use std::slice;

/// How far the length of a unit vector may be from one.
const UNIT: f64 = 1e-3;

/// How far the square of the length of one in single precision may be.
const SINGLE: f64 = 1e-5;

type Global = Vector<3>;

/// One contact point of a block: what the two routines keep in different places.
struct Contact {
    state: RealOut,
    area: f64,
    /// The number by which the user knows the node.
    node: i32,
    /// Where the predefined fields of the point are, and how far apart.
    fields: Real,
    stride: usize,
}

/// The arguments that both routines have.
#[derive(Clone, Copy)]
struct Block {
    /// The routine and its names of the state, and of the numbers of states, of points and of predefined fields.
    routine: &'static str,
    state: &'static str,
    states: (&'static str, Integer),
    points: (&'static str, Integer),
    fields: (&'static str, Integer),
    field_name: &'static str,
    f_tangential: RealOut,
    n_fric_dir: Integer,
    n_dir: Integer,
    props: Real,
    n_props: Integer,
    slip: Real,
    f_normal: Real,
    normal: Real,
    slip_direction: Real,
    interaction: Text,
    step: Integer,
    increment: Integer,
}

/// A routine of Abaqus/Explicit for a block of contact points.
trait Routine {
    /// The arguments that both routines have.
    fn block(&self) -> Block;

    /// What the routine keeps of point `k` (from 0), for states of a length.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn contact(&self, k: usize, states: usize) -> Result<Contact, Error>;

    /// Runs the routine.
    ///
    /// # Safety
    /// As [`Routine::contact`].
    unsafe fn run(&self) {
        // SAFETY: as the caller says.
        unsafe { self.block().run(&|k, states| self.contact(k, states)) }
    }
}

impl Block {
    /// Runs the routine. There is no way to refuse: a point that fails is frictionless, after a message that asks the
    /// host to stop.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn run(&self, contact: &dyn Fn(usize, usize) -> Result<Contact, Error>) {
        // SAFETY: as the caller says, here and below.
        let single = unsafe { self.in_single_precision() };
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            if let Some(cosines) = single {
                let expected =
                    "must be in double precision, these are in single: run with double=both";
                return Err(Error::about(Kind::BadInput, "dircosN", expected).numbers(&cosines));
            }
            match (
                read("nDir", self.n_dir)?,
                read("nFricDir", self.n_fric_dir)?,
            ) {
                (2, 1) => self.all(&ONE, contact),
                (3, 2) => self.all(&TWO, contact),
                (directions, tangential) => {
                    let expected =
                        format!("must be 1 with nDir = 2, or 2 with 3; nDir is {directions}");
                    Err(Error::about(Kind::BadInput, "nFricDir", expected).count(tangential))
                }
            }
        });
        if let Err(error) = outcome {
            // SAFETY: as the caller says. A second failure in here has nothing left to say.
            let _ = guard(|| unsafe {
                self.tell(0, &error);
                let numbers = count("", self.points.1)? * count("", self.n_fric_dir)?;
                if self.f_tangential.is_null() {
                    return Ok(());
                }
                match single {
                    Some(_) => {
                        slice::from_raw_parts_mut(self.f_tangential.cast(), numbers).fill(0f32)
                    }
                    None => slice::from_raw_parts_mut(self.f_tangential, numbers).fill(0.0),
                }
                Ok(())
            });
        }
    }

    /// The first normal as a host in single precision means it, None where the host is not one. It is a unit vector there,
    /// and so is the direction of the slip, to the last digits of that precision; and two such numbers read as one of
    /// double precision are less than 2^-7, as the second one holds its exponent.
    ///
    /// # Safety
    /// As [`Block::run`].
    unsafe fn in_single_precision(&self) -> Option<[f64; 3]> {
        // SAFETY: as the caller says; what is read is half of the vectors in double precision, all of those in single.
        unsafe {
            let n = match read("", self.n_dir).ok()? {
                2 => 2,
                3 => 3,
                _ => return None,
            };
            let unit = |vector: Real| {
                if vector.is_null() {
                    return None;
                }
                let cosines = slice::from_raw_parts(vector.cast::<f32>(), n);
                let mut wide = [0.0; 3];
                for (wide, narrow) in wide.iter_mut().zip(cosines) {
                    // Compared by bits: half of a number in double precision may be anything.
                    if narrow.to_bits() & 0x7fff_ffff > 1.001f32.to_bits() {
                        return None;
                    }
                    *wide = f64::from(*narrow);
                }
                let square: f64 = wide.iter().map(|x| x * x).sum();
                ((square - 1.0).abs() < SINGLE && within(*vector, 0.0079)).then_some(wide)
            };
            if read("", self.points.1).ok()? < 1 {
                return None;
            }
            // Without slip it has no direction.
            let still = |vector: Real| {
                !vector.is_null()
                    && slice::from_raw_parts(vector.cast::<u32>(), n)
                        .iter()
                        .all(|bits| *bits == 0)
            };
            if !still(self.slip_direction) {
                unit(self.slip_direction)?;
            }
            unit(self.normal)
        }
    }

    /// # Safety
    /// As [`Block::run`], nFricDir = N.
    unsafe fn all<const N: usize>(
        &self,
        laws: &'static ThreadLaws<N>,
        contact: &dyn Fn(usize, usize) -> Result<Contact, Error>,
    ) -> Result<(), Error> {
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            if self.f_tangential.is_null() {
                return Err(null("fTangential"));
            }
            let states = count(self.states.0, self.states.1)?;
            let props = properties(self.props, self.n_props)?;
            with_law(laws, props, states, |law| {
                let gcr = law.critical_slip(0.0)?;
                for k in 0..count(self.points.0, self.points.1)? {
                    let mut node = 0;
                    let force = contact(k, states).and_then(|contact| {
                        node = contact.node;
                        self.point(law, gcr, props, k, &contact)
                    });
                    let force = force.unwrap_or_else(|error| {
                        self.tell(node, &error);
                        Vector::zeros()
                    });
                    write(self.f_tangential.add(k * N), force.as_slice());
                }
                Ok(())
            })
        }
    }

    /// The friction force of a point in the host's directions; its state is advanced.
    ///
    /// # Safety
    /// As [`Block::run`], nFricDir = N; the contact's state is `nStateVar` long.
    unsafe fn point<const N: usize>(
        &self,
        law: &Law<N>,
        gcr: f64,
        props: &[f64],
        k: usize,
        contact: &Contact,
    ) -> Result<Vector<N>, Error> {
        let (mut start, mut end) = (Start::new(), End::new());
        // SAFETY: sizes as the host declares them.
        unsafe {
            law.read(
                array(self.state, contact.state, law.layout().used())?,
                &mut start,
            )?;
            let fields = || count(self.fields.0, self.fields.1);
            let place = |index| index * contact.stride;
            let factor = mu_factor(props, fields, self.field_name, contact.fields, place)?;
            let force = finite("fNormal", array("fNormal", self.f_normal, k + 1)?[k])?;
            let (pressure, area) = if force > 0.0 {
                let area = positive(
                    Kind::BadInput,
                    "the area of the contact point",
                    contact.area,
                )?;
                (force / area, area)
            } else {
                (0.0, 0.0)
            };
            let slip: Global = global(array("dSlipFric", self.slip, (k + 1) * (1 + N))?, k, 1 + N);
            for (index, value) in slip.iter().enumerate() {
                check_within("dSlipFric", index, *value, SQUARED)?;
            }
            let normal = global(array("dircosN", self.normal, (k + 1) * (1 + N))?, k, 1 + N);
            let along = global(
                array("dircosSl", self.slip_direction, (k + 1) * (1 + N))?,
                k,
                1 + N,
            );
            let normal = unit("dircosN", normal)?;
            // Without slip its direction may be anything; the force then has none either.
            let along = match unit("dircosSl", along) {
                Err(error) if slip.norm_squared() > 0.0 => return Err(error),
                along => along.unwrap_or_else(|_| Global::zeros()),
            };
            // The length of the slip along its direction: right whether the host counts dSlipFric in global
            // directions or in those of the contact.
            let slip = along * slip.norm();
            let frame = frame::<N>(&normal);
            let increment = Vector::<N>::from_fn(|i, _| frame[i].dot(&slip));
            let response =
                law.friction_from(&mut start, gcr, &increment, pressure, factor, &mut end)?;
            let traction = (frame.iter().zip(&response.traction))
                .fold(Global::zeros(), |sum, (direction, t)| sum + direction * *t);
            let host = [along, normal.cross(&along)];
            let force = Vector::<N>::from_fn(|i, _| -area * traction.dot(&host[i]));
            finite("fNormal", force.sum()).map_err(|error| error.number(pressure * area))?;
            // All of the state has been read: there is no other reference to it.
            law.layout().write(
                &end,
                slice::from_raw_parts_mut(contact.state, law.layout().nstate),
            );
            Ok(force)
        }
    }

    /// # Safety
    /// As [`Block::run`].
    #[cold]
    unsafe fn tell(&self, node: i32, error: &Error) {
        let host_name = |ours: &str, index| {
            let theirs = match ours {
                // The memory has directions of its own.
                "slip_increment" => return Some("a component of dSlipFric".to_string()),
                "pressure" => {
                    return Some("fNormal over the area of the contact point".to_string());
                }
                "state" | "state0" => self.state,
                "nstate" => self.states.0,
                "nprops" => "nProps",
                "mu_factor" => "predefined field that multiplies mu",
                _ => ours,
            };
            fortran_name(theirs, index)
        };
        // SAFETY: null, or as the host's manual says.
        unsafe {
            let contact = name(self.interaction);
            report(
                &Place {
                    routine: self.routine,
                    contact: &contact,
                    node,
                    step: read("", self.step).unwrap_or(0),
                    increment: read("", self.increment).unwrap_or(0),
                },
                Severity::Fatal,
                error,
                &host_name,
            );
        }
    }
}

/// Column `k` of an array of vectors, with a zero third component in two dimensions.
fn global(columns: &[f64], k: usize, directions: usize) -> Global {
    let column = &columns[k * directions..];
    Global::from_fn(|i, _| if i < directions { column[i] } else { 0.0 })
}

fn unit(name: &'static str, vector: Global) -> Result<Global, Error> {
    if vector.iter().all(|x| within(*x, 1.0 + UNIT)) {
        let length = vector.norm();
        if (length - 1.0).abs() < UNIT {
            return Ok(vector / length);
        }
    }
    Err(Error::about(Kind::BadInput, name, "must be a unit vector").numbers(vector.as_slice()))
}

/// N directions along a surface that depend on its normal alone, and smoothly.
///
/// In space: two fixed directions, turned by the smallest rotation that takes a fixed axis to the normal. No such
/// choice is smooth for every normal; this one jumps only at the axis reversed, so the axis is one along which no
/// model's surface lies by design.
fn frame<const N: usize>(normal: &Global) -> [Global; N] {
    if N == 1 {
        return [Global::new(-normal.y, normal.x, 0.0); N];
    }
    let axis = Global::new(2.0, 3.0, 6.0) / 7.0;
    let fixed = [
        Global::new(3.0, -6.0, 2.0) / 7.0,
        Global::new(6.0, 2.0, -3.0) / 7.0,
    ];
    let cosine = axis.dot(normal);
    std::array::from_fn(|i| {
        if 1.0 + cosine < f64::EPSILON {
            return fixed[i];
        }
        fixed[i] - (axis + normal) * (fixed[i].dot(normal) / (1.0 + cosine))
    })
}

routine! {
    /// VFRIC of Abaqus/Explicit (contact pairs), real numbers in double precision: see docs/hosts.md.
    struct Vfric of vfric_(), vfric();
    take f_tangential: RealOut, take statev: RealOut, take k_step: Integer, take k_inc: Integer,
    take n_contact: Integer, skip n_fac_nod: Integer, take n_slv_nod: Integer, skip n_mst_nod: Integer,
    take n_fric_dir: Integer, take n_dir: Integer, take n_state_var: Integer, take n_props: Integer,
    skip n_temp: Integer, take n_pred: Integer, skip num_def_tfv: Integer, take j_slv_uid: Integer,
    skip j_mst_uid: Integer, take j_con_slvid: Integer, skip j_con_mstid: Integer, skip tim_step: Real,
    skip tim_glb: Real, skip d_tim_cur: Real, take surf_int: Text, skip surf_slv: Text, skip surf_mst: Text,
    skip l_con_type: Integer, take d_slip_fric: Real, skip f_stick_force: Real, skip f_tang_prev: Real,
    take f_normal: Real, skip friction_work: Real, skip shape: Real, skip coord_slv: Real, skip coord_mst: Real,
    take dir_cos_sl: Real, take dircos_n: Real, take props: Real, take area_slv: Real, skip temp_slv: Real,
    take pre_def_slv: Real, skip temp_mst: Real, skip pre_def_mst: Real,
}

impl Routine for Vfric {
    fn block(&self) -> Block {
        Block {
            routine: "VFRIC",
            state: "statev",
            states: ("nStateVar", self.n_state_var),
            points: ("nContact", self.n_contact),
            fields: ("nPred", self.n_pred),
            field_name: "preDefSlv",
            f_tangential: self.f_tangential,
            n_fric_dir: self.n_fric_dir,
            n_dir: self.n_dir,
            props: self.props,
            n_props: self.n_props,
            slip: self.d_slip_fric,
            f_normal: self.f_normal,
            normal: self.dircos_n,
            slip_direction: self.dir_cos_sl,
            interaction: self.surf_int,
            step: self.k_step,
            increment: self.k_inc,
        }
    }

    unsafe fn contact(&self, k: usize, states: usize) -> Result<Contact, Error> {
        // SAFETY: sizes as the host declares them; the node is checked.
        unsafe {
            // States and areas belong to slave nodes: jConSlvid tells which one is in contact.
            let nodes = read("nSlvNod", self.n_slv_nod)?;
            if self.j_con_slvid.is_null() {
                return Err(null("jConSlvid"));
            }
            let node = *self.j_con_slvid.add(k);
            if node < 1 || node > nodes {
                let expected = format!("must be a slave node, 1 to {nodes}");
                return Err(Error::about(Kind::BadInput, "jConSlvid", expected)
                    .index(k)
                    .count(node));
            }
            let index = node as usize - 1;
            if self.statev.is_null() {
                return Err(null("statev"));
            }
            Ok(Contact {
                state: self.statev.add(index * states),
                area: array("areaSlv", self.area_slv, index + 1)?[index],
                node: if self.j_slv_uid.is_null() {
                    node
                } else {
                    *self.j_slv_uid.add(index)
                },
                fields: at(self.pre_def_slv, k),
                stride: count("nContact", self.n_contact)?,
            })
        }
    }
}

routine! {
    /// VFRICTION of Abaqus/Explicit (general contact), real numbers in double precision: see docs/hosts.md.
    struct Vfriction of vfriction_(), vfriction();
    take f_tangential: RealOut, take state: RealOut, take n_block: Integer, skip n_block_anal: Integer,
    skip n_block_edge: Integer, take n_nod_state: Integer, take n_nod_slv: Integer, skip n_nod_mst: Integer,
    take n_fric_dir: Integer, take n_dir: Integer, take n_states: Integer, take n_props: Integer,
    skip n_temp: Integer, take n_fields: Integer, take j_flags: Integer, skip r_data: Real, take surf_int: Text,
    skip surf_slv: Text, skip surf_mst: Text, take j_con_slv_uid: Integer, skip j_con_mst_uid: Integer,
    take props: Real, take d_slip_fric: Real, skip f_stick_force: Real, skip f_tang_prev: Real, take f_normal: Real,
    take area_cont: Real, take dircos_n: Real, take dircos_sl: Real, skip shape_slv: Real, skip shape_mst: Real,
    skip coord_slv: Real, skip coord_mst: Real, skip vel_slv: Real, skip vel_mst: Real, skip temp_slv: Real,
    skip temp_mst: Real, take field_slv: Real, skip field_mst: Real,
}

impl Routine for Vfriction {
    fn block(&self) -> Block {
        Block {
            routine: "VFRICTION",
            state: "state",
            states: ("nStates", self.n_states),
            points: ("nBlock", self.n_block),
            fields: ("nFields", self.n_fields),
            field_name: "fieldSlv",
            f_tangential: self.f_tangential,
            n_fric_dir: self.n_fric_dir,
            n_dir: self.n_dir,
            props: self.props,
            n_props: self.n_props,
            slip: self.d_slip_fric,
            f_normal: self.f_normal,
            normal: self.dircos_n,
            slip_direction: self.dircos_sl,
            interaction: self.surf_int,
            // jFlags: step, increment, type of contact.
            step: self.j_flags,
            increment: at(self.j_flags, 1),
        }
    }

    unsafe fn contact(&self, k: usize, states: usize) -> Result<Contact, Error> {
        // SAFETY: sizes as the host declares them.
        unsafe {
            // A contact has nNodState states (4 where the slave is an edge); the first holds the memory.
            let per_contact = count("nNodState", self.n_nod_state)?;
            if per_contact == 0 {
                return Err(Error::about(Kind::BadInput, "nNodState", "must be >= 1").count(0));
            }
            if self.state.is_null() {
                return Err(null("state"));
            }
            Ok(Contact {
                state: self.state.add(k * states * per_contact),
                area: array("areaCont", self.area_cont, k + 1)?[k],
                node: if self.j_con_slv_uid.is_null() {
                    0
                } else {
                    *self
                        .j_con_slv_uid
                        .add(k * count("nNodSlv", self.n_nod_slv)?)
                },
                fields: match self.field_slv.is_null() {
                    true => self.field_slv,
                    false => at(self.field_slv, k * count("nFields", self.n_fields)?),
                },
                stride: 1,
            })
        }
    }
}

/// Number `index` of an array that may not be there.
fn at<T>(array: *const T, index: usize) -> *const T {
    if array.is_null() {
        array
    } else {
        array.wrapping_add(index)
    }
}

#[cfg(test)]
mod tests {
    use super::{Global, frame};

    #[test]
    fn the_frame_lies_in_the_surface_and_is_smooth() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut direction = || {
            let mut number = || random.f64() - 0.5;
            Global::new(number(), number(), number()).normalize()
        };
        for _ in 0..10_000 {
            let normal = direction();
            let [a, b] = frame::<2>(&normal);
            for zero in [
                a.dot(&normal),
                b.dot(&normal),
                a.dot(&b),
                a.norm() - 1.0,
                b.norm() - 1.0,
            ] {
                assert!(zero.abs() < 1e-9, "{normal}");
            }
            // A right-handed frame everywhere: turning it never flips a direction.
            assert!((a.cross(&b).dot(&normal) - 1.0).abs() < 1e-9, "{normal}");
        }
        // About every axis of a model, where normals are likely to be, a small turn turns the frame as little.
        for axis in [
            Global::x(),
            Global::y(),
            Global::z(),
            -Global::x(),
            -Global::y(),
            -Global::z(),
        ] {
            let near = (axis + direction() * 1e-6).normalize();
            for (p, q) in frame::<2>(&axis).iter().zip(frame::<2>(&near)) {
                assert!((p - q).norm() < 1e-4, "{axis}");
            }
        }
    }
}
