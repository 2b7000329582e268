// SPDX-License-Identifier: MIT OR Apache-2.0
//! Three increments of one point; tractions against Masing's rules on f(s) = 1 - (1 - s)^2.5.

use mepc::{Law, Vector};

fn main() -> Result<(), mepc::Error> {
    let f = |s: f64| 1.0 - (1.0 - s).powf(2.5);
    let first = f(0.5);
    let second = first - 2.0 * f(0.375);
    let exact = [first, second, second + 2.0 * f(0.125)].map(|part| 30.0 * part);

    let law = Law::<1>::new(&[0.3, 0.002, 2.5, 0.0, 100.0], 44)?;
    let gcr = law.critical_slip(0.0)?;
    let mut state = [0.0; 44];
    for (slip, exact) in [0.001, -0.0015, 0.0005].into_iter().zip(exact) {
        let mut next = [0.0; 44];
        let response = law.friction(gcr, &Vector::<1>::new(slip), 100.0, 1.0, &state, &mut next)?;
        assert!((response.traction[0] - exact).abs() < 1e-10);
        state = next;
    }
    println!("three tractions");
    Ok(())
}
