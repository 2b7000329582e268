//! The language-neutral vectors through the Rust API and through the built library's C interface.

mod support;

use support::native::NativeLaw;
use support::vectors::{Row, VectorFile, all, every};
use support::{Point, with};

#[test]
fn every_vector_through_the_rust_api() {
    fn run<const N: usize>(file: &VectorFile) {
        let mut point = Point::<N>::with_state_size(&file.props, file.nstate);
        let mut dissipated = 0.0;
        for (index, row) in file.rows.iter().enumerate() {
            let target = std::array::from_fn(|i| row.slip[i]);
            point.mu_factor = row.mu_factor;
            let response = point.move_to(target, row.pressure);
            dissipated += response.dissipated;
            let status = response.contact as i32;
            file.check(
                index,
                response.traction.as_slice(),
                response.stored,
                dissipated,
                status,
            );
            let [in_state, pressure, _, stored, so_far] = point.state[..5] else {
                panic!("a short state");
            };
            assert_eq!(
                [in_state, pressure, stored],
                [f64::from(status), row.pressure.max(0.0), response.stored]
            );
            assert_eq!(so_far, dissipated, "{}, row {index}", file.name());
        }
    }
    for file in every() {
        if file.ndir == 1 {
            run::<1>(&file);
        } else {
            run::<2>(&file);
        }
    }
}

#[test]
fn every_vector_through_the_friction_form_of_the_library() {
    for file in all() {
        let law = NativeLaw::with_state_size(&file.props, file.ndir, file.nstate);
        let mut state = vec![0.0; file.nstate];
        let (mut at, mut dissipated) = (vec![0.0; file.ndir], 0.0);
        for (index, row) in file.rows.iter().enumerate() {
            let increment: Vec<f64> = row
                .slip
                .iter()
                .zip(&at)
                .map(|(to, from)| to - from)
                .collect();
            let out = law.friction(&increment, row.pressure, &mut state);
            assert!(out.status >= 0);
            at.clone_from(&row.slip);
            dissipated += out.energy[1];
            file.check(
                index,
                &out.traction,
                out.energy[0],
                dissipated,
                state[0] as i32,
            );
        }
    }
}

/// Whether a contact closes in an increment with slip: there the two forms differ (docs/theory.md, section 6).
fn closes_with_slip(rows: &[Row]) -> bool {
    let still = vec![0.0; rows[0].slip.len()];
    let mut before = (0.0, &still);
    rows.iter().any(|row| {
        let (pressure, slip) = std::mem::replace(&mut before, (row.pressure, &row.slip));
        pressure <= 0.0 && row.pressure > 0.0 && *slip != row.slip
    })
}

/// The pressure comes from the opening here: kn is a power of two, so that it is the file's to the last bit.
#[test]
fn every_vector_through_the_interface_form_of_the_library() {
    let kn = 1024.0;
    let mut count = 0;
    for file in all() {
        if closes_with_slip(&file.rows) {
            continue;
        }
        count += 1;
        let law = NativeLaw::with_state_size(&with(&file.props, 7, kn), file.ndir, file.nstate);
        let mut state = vec![0.0; file.nstate];
        let mut dissipated = 0.0;
        for (index, row) in file.rows.iter().enumerate() {
            let mut opening = vec![-row.pressure / kn];
            opening.extend(&row.slip);
            let out = law.interface(&opening, &mut state);
            assert!(out.status >= 0);
            dissipated += out.energy[1];
            assert_eq!(out.traction[0], -row.pressure.max(0.0));
            // Touching without pressure is stiff already.
            assert_eq!(out.tangent[0], if row.pressure >= 0.0 { kn } else { 0.0 });
            // The state keeps the energy of friction; the output has that of the normal spring besides.
            let pressure = row.pressure.max(0.0);
            let spring = out.energy[0] - state[3];
            assert!((spring - pressure * pressure / (2.0 * kn)).abs() <= 1e-12 * out.energy[0]);
            file.check(
                index,
                &out.traction[1..],
                state[3],
                dissipated,
                state[0] as i32,
            );
        }
    }
    assert!(count > 40, "only {count} vectors");
}
