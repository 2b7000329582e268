//! The C interface of the joint model: the force of a loop, and the parameters of a measured one.
// Array sizes in square brackets, as C documents them, are no links.
#![allow(rustdoc::broken_intra_doc_links)]

use super::arguments::{array, null, write};
use super::guard;
use super::native::{MEPC_NOT_DESCRIBED, remember, status};
use crate::error::{Error, Kind};
use crate::iwan::{Direction, Iwan, Options, PAPER_TOLERANCE, Record, identify};
use libc::c_double;
use std::slice;

/// The most points of one call; their displacements and forces fit any address space.
const MOST_POINTS: i64 = 1 << 40;

fn points(n: i64) -> Result<usize, Error> {
    if (0..=MOST_POINTS).contains(&n) {
        return Ok(n as usize);
    }
    Err(Error::new(
        Kind::BadInput,
        format!("n = {n}: must be from 0 to {MOST_POINTS} points"),
    ))
}

/// The improved four-parameter Iwan model of a joint: forces of its steady loop.
///
/// params: [4] F_s (force at gross slip), X_s (displacement at gross slip), k_alpha (residual stiffness), kappa
/// (exponent; chi = 5/2 + kappa >= 1). amplitude: of the loop, > 0. displacement: [n]; branch: [n] +1 while the
/// displacement grows, -1 while it falls. Beyond the amplitude the curve of first loading goes on. force: [n], with the
/// sign of the displacement; may be the array displacement itself.
///
/// Returns 0, or MEPC_NULL_POINTER, MEPC_BAD_PROPERTY (params), MEPC_BAD_INPUT.
///
/// # Safety
/// Arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_iwan_force(
    params: *const c_double,
    amplitude: c_double,
    n: i64,
    displacement: *const c_double,
    branch: *const i8,
    force: *mut c_double,
) -> i32 {
    status(guard(|| {
        // SAFETY: four numbers, and n of each, by the caller's word.
        let (params, displacement, branch) = unsafe {
            let params = array("params", params, 4)?;
            let points = points(n)?;
            if branch.is_null() {
                return Err(null("branch"));
            }
            (
                params,
                array("displacement", displacement, points)?,
                slice::from_raw_parts(branch, points),
            )
        };
        if force.is_null() {
            return Err(null("force"));
        }
        let joint = Iwan::new([params[0], params[1], params[2], params[3]])?;
        let bad = |message: String| Error::new(Kind::BadInput, message);
        if !(amplitude > 0.0 && amplitude.is_finite()) {
            return Err(bad(format!(
                "amplitude = {amplitude:?}: must be finite and > 0"
            )));
        }
        let forces = displacement
            .iter()
            .zip(branch)
            .enumerate()
            .map(|(index, (&x, &branch))| {
                let direction = match branch {
                    1 => Direction::Loading,
                    -1 => Direction::Unloading,
                    _ => {
                        return Err(bad(format!(
                            "branch[{index}] = {branch}: must be 1 (loading) or -1 (unloading)"
                        )));
                    }
                };
                let force = joint.steady(amplitude, x, direction);
                if force.is_finite() {
                    return Ok(force);
                }
                Err(bad(format!(
                    "displacement[{index}] = {x:?}: must be finite, and the force too ({force:?})"
                )))
            });
        let forces: Vec<f64> = forces.collect::<Result<_, _>>()?;
        // SAFETY: n numbers by the caller's word; `forces` is ours.
        unsafe { write(force, &forces) };
        Ok(0)
    }))
}

/// The four parameters of the improved Iwan model from a measured loop.
///
/// displacement, force: [n] in the order of time, cycles of one or of several amplitudes about any centre; reversals
/// are found in the data, noise is allowed. A time lag between the two is found and taken out. method: 0 least squares
/// over all branches at once, 1 the paper's own procedure (residual line, where the data leave it, exponent by
/// logarithms: rougher). params: [4] receives F_s, X_s, k_alpha, kappa. standard_errors: [4] of the same, or NULL.
/// misfit: root mean square residual over the force at the amplitude, or NULL.
///
/// A loop that does not show gross slip cannot give these parameters and is refused with MEPC_BAD_INPUT, as is one that
/// turns the wrong way, or that only a friction of more than twice the measured forces would resemble (viscous
/// damping). Returns 0, MEPC_NOT_DESCRIBED (outputs are written, and must not be used without a look at the loop), or
/// MEPC_NULL_POINTER, MEPC_BAD_INPUT (nothing is written; mepc_last_error tells what is wrong with the data).
///
/// # Safety
/// Arrays are as long as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mepc_iwan_identify(
    n: i64,
    displacement: *const c_double,
    force: *const c_double,
    method: i32,
    params: *mut c_double,
    standard_errors: *mut c_double,
    misfit: *mut c_double,
) -> i32 {
    status(guard(|| {
        let points = points(n)?;
        // SAFETY: n numbers each by the caller's word.
        let record = unsafe {
            Record::new(
                array("displacement", displacement, points)?,
                array("force", force, points)?,
            )?
        };
        if params.is_null() {
            return Err(null("params"));
        }
        let bad = |message: String| Error::new(Kind::BadInput, message);
        if !(0..=1).contains(&method) {
            return Err(bad(format!(
                "method = {method}: must be 0 (least squares) or 1 (the paper's)"
            )));
        }
        let found = identify(record, &Options::default())?;
        let fit = match method {
            0 => found.fit.clone(),
            _ => found.record.paper(PAPER_TOLERANCE)?,
        };
        let mut severe = found.fit.warnings.iter().filter(|w| w.reason().is_some());
        // A caller who only looks at the status must not take an extrapolation for a result.
        if let Some(warning) = severe.clone().find(|w| w.is_extrapolation()) {
            return Err(bad(format!("force: {warning}")));
        }
        // SAFETY: four numbers each and one by the caller's word, or NULL.
        unsafe {
            write(params, &fit.joint.parameters());
            write(standard_errors, &fit.standard_errors);
            write(misfit, &[fit.misfit()]);
        }
        if let Some(warning) = severe.next() {
            remember(&bad(format!("force: {warning}")));
            return Ok(MEPC_NOT_DESCRIBED);
        }
        Ok(0)
    }))
}
