//! The VFRIC and VFRICTION faces: the user friction routines of Abaqus/Explicit, double precision.
//!
//! The argument lists were taken from working sources; what is not confirmed is marked in docs/hosts.md. Both hand
//! over a block of contact points and take **forces** against the slip. Their first direction is that of the current
//! slip and turns with every increment, so the memory is kept in a frame of its own, made from the normal.

use super::guard;
use super::host::{Place, Severity, report};
use super::user::{
    self, StateCopy, ThreadLaws, array, count, name, null, properties, read, with_law, write,
};
use crate::error::{Error, Kind, numbers};
use crate::law::{Law, SQUARED, check_finite, check_within, within};
use crate::memory::Vector;
use libc::{c_char, c_double};
use std::slice;

/// How far the length of a unit vector may be from one.
const UNIT: f64 = 1e-3;

type Global = Vector<3>;

/// One contact point of a block: what the two routines keep in different places.
struct Contact {
    state: *mut c_double,
    area: f64,
    /// The number by which the user knows the node.
    node: i32,
}

/// The arguments that both routines have, and where the rest of a point is.
struct Block<P> {
    routine: &'static str,
    /// The routine's names of the state, and of the numbers of states and of points.
    names: [&'static str; 3],
    points: *const i32,
    f_tangential: *mut c_double,
    n_fric_dir: *const i32,
    n_dir: *const i32,
    n_states: *const i32,
    props: *const c_double,
    n_props: *const i32,
    slip: *const c_double,
    f_normal: *const c_double,
    normal: *const c_double,
    slip_direction: *const c_double,
    interaction: *const c_char,
    step: *const i32,
    increment: *const i32,
    /// State, area and number of point k (0-based) for states of a length.
    contact: P,
}

impl<P: Fn(usize, usize) -> Result<Contact, Error>> Block<P> {
    /// Runs the routine. There is no way to refuse: a point that fails is frictionless, after a message that asks the
    /// host to stop.
    ///
    /// # Safety
    /// The pointers are what the host's manual says, or null.
    unsafe fn run(&self) {
        // SAFETY: as the caller says.
        let outcome = guard(|| unsafe {
            match (
                read("nDir", self.n_dir)?,
                read("nFricDir", self.n_fric_dir)?,
            ) {
                (2, 1) => self.block(&user::ONE),
                (3, 2) => self.block(&user::TWO),
                (directions, tangential) => Err(Error::new(
                    Kind::BadInput,
                    format!(
                        "nFricDir = {tangential} with nDir = {directions}: must be 1 with 2, or 2 with 3"
                    ),
                )),
            }
        });
        if let Err(error) = outcome {
            // SAFETY: as the caller says. A second failure in here has nothing left to say.
            let _ = guard(|| unsafe {
                self.tell(0, &error);
                let numbers = count("", self.points)? * count("", self.n_fric_dir)?;
                if !self.f_tangential.is_null() {
                    slice::from_raw_parts_mut(self.f_tangential, numbers).fill(0.0);
                }
                Ok(())
            });
        }
    }

    /// # Safety
    /// As [`Block::run`], nFricDir = N.
    unsafe fn block<const N: usize>(&self, laws: &'static ThreadLaws<N>) -> Result<(), Error> {
        // SAFETY: sizes as the host declares them, throughout.
        unsafe {
            if self.f_tangential.is_null() {
                return Err(null("fTangential"));
            }
            let [_, n_states, n_points] = self.names;
            let states = count(n_states, self.n_states)?;
            let props = properties(self.props, self.n_props)?;
            with_law(laws, props, states, |law| {
                let gcr = law.critical_slip(0.0)?;
                for k in 0..count(n_points, self.points)? {
                    let mut node = 0;
                    let force = (self.contact)(k, states).and_then(|contact| {
                        node = contact.node;
                        self.point(law, gcr, k, &contact)
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
        k: usize,
        contact: &Contact,
    ) -> Result<Vector<N>, Error> {
        // SAFETY: sizes as the host declares them.
        unsafe {
            let mut copy = StateCopy::new();
            let state0 = user::state(self.names[0], law.layout(), contact.state, &mut copy)?;
            let force = array("fNormal", self.f_normal, k + 1)?[k];
            check_finite(&"fNormal", force)?;
            let pressure = if force > 0.0 {
                force / positive("the area of the contact point", contact.area)?
            } else {
                0.0
            };
            let slip: Global = global(array("dSlipFric", self.slip, (k + 1) * (1 + N))?, k, 1 + N);
            for (index, value) in slip.iter().enumerate() {
                check_within(&format_args!("dSlipFric({})", index + 1), *value, SQUARED)?;
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
            // Everything has been read: from here on the state is only written.
            let state1 = slice::from_raw_parts_mut(contact.state, law.layout().nstate);
            let response = law.friction(gcr, &increment, pressure, state0, state1)?;
            let traction = (frame.iter().zip(&response.traction))
                .fold(Global::zeros(), |sum, (direction, t)| sum + direction * *t);
            let host = [along, normal.cross(&along)];
            let area = if force > 0.0 { contact.area } else { 0.0 };
            Ok(Vector::from_fn(|i, _| -area * traction.dot(&host[i])))
        }
    }

    /// # Safety
    /// As [`Block::run`].
    #[cold]
    unsafe fn tell(&self, node: i32, error: &Error) {
        let error = user::in_host_words(error.clone(), |ours, index| {
            let [state, n_states, _] = self.names;
            Some(match ours {
                // The memory has directions of its own.
                "slip_increment" => "a component of dSlipFric".to_string(),
                "state" => format!("{state}({})", index + 1),
                "nstate" => n_states.to_string(),
                "nprops" => "nProps".to_string(),
                _ => return None,
            })
        });
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
                &error,
            );
        }
    }
}

/// Column `k` of an array of vectors, with a zero third component in two dimensions.
fn global(columns: &[f64], k: usize, directions: usize) -> Global {
    let column = &columns[k * directions..];
    Global::from_fn(|i, _| if i < directions { column[i] } else { 0.0 })
}

fn unit(name: &str, vector: Global) -> Result<Global, Error> {
    if vector.iter().all(|x| within(*x, 1.0 + UNIT)) {
        let length = vector.norm();
        if (length - 1.0).abs() < UNIT {
            return Ok(vector / length);
        }
    }
    Err(Error::new(
        Kind::BadInput,
        format!(
            "{name} = {:?}: must be a unit vector",
            numbers(vector.as_slice())
        ),
    ))
}

fn positive(name: &str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Error::new(
        Kind::BadInput,
        format!("{name} = {value}: must be finite and > 0"),
    ))
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

/// One definition for both symbols: with the underscore that Fortran compilers on Linux append, and without.
macro_rules! export_vfric {
    ($symbol:ident) => {
        /// VFRIC of Abaqus/Explicit (contact pairs): see docs/hosts.md.
        ///
        /// The hidden string lengths that follow the arguments are not declared: they are not needed.
        ///
        /// # Safety
        /// Arguments are as the host's manual describes them, real numbers in double precision.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol(
            f_tangential: *mut c_double,
            statev: *mut c_double,
            k_step: *const i32,
            k_inc: *const i32,
            n_contact: *const i32,
            _n_fac_nod: *const i32,
            n_slv_nod: *const i32,
            _n_mst_nod: *const i32,
            n_fric_dir: *const i32,
            n_dir: *const i32,
            n_state_var: *const i32,
            n_props: *const i32,
            _n_temp: *const i32,
            _n_pred: *const i32,
            _num_def_tfv: *const i32,
            j_slv_uid: *const i32,
            _j_mst_uid: *const i32,
            j_con_slvid: *const i32,
            _j_con_mstid: *const i32,
            _tim_step: *const c_double,
            _tim_glb: *const c_double,
            _d_tim_cur: *const c_double,
            surf_int: *const c_char,
            _surf_slv: *const c_char,
            _surf_mst: *const c_char,
            _l_con_type: *const i32,
            d_slip_fric: *const c_double,
            _f_stick_force: *const c_double,
            _f_tang_prev: *const c_double,
            f_normal: *const c_double,
            _friction_work: *const c_double,
            _shape: *const c_double,
            _coord_slv: *const c_double,
            _coord_mst: *const c_double,
            dir_cos_sl: *const c_double,
            dircos_n: *const c_double,
            props: *const c_double,
            area_slv: *const c_double,
            _temp_slv: *const c_double,
            _pre_def_slv: *const c_double,
            _temp_mst: *const c_double,
            _pre_def_mst: *const c_double,
        ) {
            // States and areas belong to slave nodes: jConSlvid tells which one is in contact.
            let contact = |k: usize, states: usize| {
                // SAFETY: sizes as the host declares them; the node is checked.
                unsafe {
                    let nodes = read("nSlvNod", n_slv_nod)?;
                    if j_con_slvid.is_null() {
                        return Err(null("jConSlvid"));
                    }
                    let node = *j_con_slvid.add(k);
                    if node < 1 || node > nodes {
                        return Err(Error::new(
                            Kind::BadInput,
                            format!(
                                "jConSlvid({}) = {node}: must be a slave node, 1 to {nodes}",
                                k + 1
                            ),
                        ));
                    }
                    let index = node as usize - 1;
                    if statev.is_null() {
                        return Err(null("statev"));
                    }
                    Ok(Contact {
                        state: statev.add(index * states),
                        area: array("areaSlv", area_slv, index + 1)?[index],
                        node: if j_slv_uid.is_null() {
                            node
                        } else {
                            *j_slv_uid.add(index)
                        },
                    })
                }
            };
            let block = Block {
                routine: "VFRIC",
                names: ["statev", "nStateVar", "nContact"],
                points: n_contact,
                f_tangential,
                n_fric_dir,
                n_dir,
                n_states: n_state_var,
                props,
                n_props,
                slip: d_slip_fric,
                f_normal,
                normal: dircos_n,
                slip_direction: dir_cos_sl,
                interaction: surf_int,
                step: k_step,
                increment: k_inc,
                contact,
            };
            // SAFETY: the host's arguments.
            unsafe { block.run() }
        }
    };
}

export_vfric!(vfric_);
export_vfric!(vfric);

/// As for VFRIC.
macro_rules! export_vfriction {
    ($symbol:ident) => {
        /// VFRICTION of Abaqus/Explicit (general contact): see docs/hosts.md.
        ///
        /// The hidden string lengths that follow the arguments are not declared: they are not needed.
        ///
        /// # Safety
        /// Arguments are as the host's manual describes them, real numbers in double precision.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol(
            f_tangential: *mut c_double,
            state: *mut c_double,
            n_block: *const i32,
            _n_block_anal: *const i32,
            _n_block_edge: *const i32,
            n_nod_state: *const i32,
            n_nod_slv: *const i32,
            _n_nod_mst: *const i32,
            n_fric_dir: *const i32,
            n_dir: *const i32,
            n_states: *const i32,
            n_props: *const i32,
            _n_temp: *const i32,
            _n_fields: *const i32,
            j_flags: *const i32,
            _r_data: *const c_double,
            surf_int: *const c_char,
            _surf_slv: *const c_char,
            _surf_mst: *const c_char,
            j_con_slv_uid: *const i32,
            _j_con_mst_uid: *const i32,
            props: *const c_double,
            d_slip_fric: *const c_double,
            _f_stick_force: *const c_double,
            _f_tang_prev: *const c_double,
            f_normal: *const c_double,
            area_cont: *const c_double,
            dircos_n: *const c_double,
            dircos_sl: *const c_double,
            _shape_slv: *const c_double,
            _shape_mst: *const c_double,
            _coord_slv: *const c_double,
            _coord_mst: *const c_double,
            _vel_slv: *const c_double,
            _vel_mst: *const c_double,
            _temp_slv: *const c_double,
            _temp_mst: *const c_double,
            _field_slv: *const c_double,
            _field_mst: *const c_double,
        ) {
            // A contact has nNodState states (4 where the slave is an edge); the first holds the memory.
            let contact = |k: usize, states: usize| {
                // SAFETY: sizes as the host declares them.
                unsafe {
                    let per_contact = count("nNodState", n_nod_state)?;
                    if per_contact == 0 {
                        let message = "nNodState = 0: must be >= 1";
                        return Err(Error::new(Kind::BadInput, message));
                    }
                    if state.is_null() {
                        return Err(null("state"));
                    }
                    Ok(Contact {
                        state: state.add(k * states * per_contact),
                        area: array("areaCont", area_cont, k + 1)?[k],
                        node: if j_con_slv_uid.is_null() {
                            0
                        } else {
                            *j_con_slv_uid.add(k * count("nNodSlv", n_nod_slv)?)
                        },
                    })
                }
            };
            let block = Block {
                routine: "VFRICTION",
                names: ["state", "nStates", "nBlock"],
                points: n_block,
                f_tangential,
                n_fric_dir,
                n_dir,
                n_states,
                props,
                n_props,
                slip: d_slip_fric,
                f_normal,
                normal: dircos_n,
                slip_direction: dircos_sl,
                interaction: surf_int,
                // jFlags: step, increment, type of contact.
                step: j_flags,
                increment: j_flags.wrapping_add(usize::from(!j_flags.is_null())),
                contact,
            };
            // SAFETY: the host's arguments.
            unsafe { block.run() }
        }
    };
}

export_vfriction!(vfriction_);
export_vfriction!(vfriction);

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
