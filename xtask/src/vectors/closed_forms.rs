//! Histories under changing pressure that have closed forms of their own.

use mepc_oracle::masing::Masing;
use mepc_oracle::{Status, closed};

use super::paths::{PLACES, branches};
use super::vector::{EXACT, Energies, Expected, Law, Step, Vector, source};
use crate::generated::decimals;

/// Contact opens and closes again: each time a virgin point, and the closing step counts in full.
pub fn opening(law: Law) -> Vector {
    let p = 25.0;
    // Slip over gcr and pressure.
    let rows = [
        (0.0, 0.0),
        (0.2, p),
        (0.7, p),
        (0.3, p),
        (0.3, 0.0),
        (0.9, 0.0),
        (1.2, p),
        (1.0, p),
        (1.1, -3.0),
        (1.1, p),
        (1.6, p),
        (3.0, p),
        (3.0, 0.0),
        (2.5, 0.0),
        (1.0, p),
        (1.4, p),
    ];
    let (limit, energy) = (law.mu * p, law.mu * p * law.gcr);
    let mut point = Masing::new(law.backbone());
    let (mut lost, mut closed_at, mut previous) = (0.0, None, 0.0);
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    for (s, pressure) in rows {
        let slip = decimals(s * law.gcr, PLACES);
        steps.push(Step {
            slip: [slip, 0.0],
            pressure,
        });
        let status = if pressure <= 0.0 {
            lost += energy * (point.dissipated() + point.stored());
            point = Masing::new(law.backbone());
            closed_at = None;
            Status::Open
        } else {
            let start = *closed_at.get_or_insert(previous);
            let before = point.slip();
            point.move_to((slip - start) / law.gcr);
            if point.slip() == before {
                Status::Stick
            } else {
                point.status()
            }
        };
        previous = slip;
        expected.push(Expected {
            traction: [limit * point.traction(), 0.0],
            dissipated: lost + energy * point.dissipated(),
            stored: energy * point.stored(),
            status: Some(status),
        });
    }
    Vector {
        name: "opening_and_closing".to_string(),
        about: "pressure zero at the start, opening, slip while open, closing with and without slip, negative pressure",
        source: source(
            &law,
            "Masing's rules, a virgin point at each closing, stored energy lost on opening",
        ),
        law,
        directions: 1,
        steps,
        expected,
        energies: Energies::Both,
        tolerance: EXACT,
    }
}

/// In gross slip the traction is mu p at every pressure.
pub fn gross_slip_under_falling_pressure(law: Law) -> Vector {
    let slips = branches(law.gcr, &[0.0, 1.25, 3.25], 5);
    let pressures = [
        20.0, 20.0, 20.0, 20.0, 20.0, 20.0, 16.0, 11.0, 7.5, 3.0, 0.5,
    ];
    let steps: Vec<Step> = slips
        .iter()
        .zip(pressures)
        .map(|(&slip, pressure)| Step {
            slip: [slip, 0.0],
            pressure,
        })
        .collect();
    let expected = steps
        .iter()
        .map(|step| {
            let s = step.slip[0] / law.gcr;
            Expected {
                traction: [law.mu * step.pressure * law.backbone().traction(s), 0.0],
                dissipated: 0.0,
                stored: 0.0,
                status: (s > 1.0).then_some(Status::GrossSlip),
            }
        })
        .collect();
    Vector {
        name: "pressure_fall_gross_slip".to_string(),
        about: "verification item 11: gross slip under falling pressure",
        source: source(&law, "traction mu p f(s)"),
        law,
        directions: 1,
        steps,
        expected,
        energies: Energies::None,
        tolerance: EXACT,
    }
}

pub fn loading_after_pressure_rise(law: Law) -> Vector {
    let (first, low, high) = (0.6, 5.0, 12.5);
    let backbone = law.backbone();
    let start = decimals(first * law.gcr, PLACES);
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    let mut add = |slip: f64, pressure: f64, t: f64| {
        steps.push(Step {
            slip: [slip, 0.0],
            pressure,
        });
        expected.push(Expected {
            traction: [law.mu * pressure * t, 0.0],
            dissipated: 0.0,
            stored: 0.0,
            status: None,
        });
    };
    add(0.0, low, 0.0);
    add(start, low, backbone.traction(start / law.gcr));
    add(start, high, low / high * backbone.traction(start / law.gcr));
    for k in 1..=12 {
        let slip = decimals((first + 0.08 * f64::from(k)) * law.gcr, PLACES);
        let further = (slip - start) / law.gcr;
        add(
            slip,
            high,
            closed::loading_after_pressure_rise(backbone, start / law.gcr, low / high, further),
        );
    }
    Vector {
        name: "pressure_rise_loading".to_string(),
        about: "slip, rise of pressure at fixed slip, slip further in the same direction",
        source: source(
            &law,
            "f(x) + q (f(s) - f(x)) with x = d/(1 - q) < s, then f(q s + d); q = p_old/p_new",
        ),
        law,
        directions: 1,
        steps,
        expected,
        energies: Energies::None,
        tolerance: EXACT,
    }
}

/// Under the proportional rule traction over mu p does not see the pressure.
pub fn proportional_rule(law: Law) -> Vector {
    let slips = branches(law.gcr, &[0.0, 0.8, -0.3, 0.4, -1.2, 0.1], 4);
    let mut point = Masing::new(law.backbone());
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    for (k, slip) in slips.into_iter().enumerate() {
        // Up and down between 4 and 16 MPa.
        let pressure = 10.0 + [0.0, 3.5, 6.0, 2.0, -1.0, -6.0, -2.5][k % 7];
        point.move_to(slip / law.gcr);
        steps.push(Step {
            slip: [slip, 0.0],
            pressure,
        });
        expected.push(Expected {
            traction: [law.mu * pressure * point.traction(), 0.0],
            dissipated: 0.0,
            stored: 0.0,
            status: None,
        });
    }
    Vector {
        name: "pressure_proportional".to_string(),
        about: "slip back and forth while the pressure goes up and down, proportional rule",
        source: source(&law, "mu p(t) times Masing's rules"),
        law,
        directions: 1,
        steps,
        expected,
        energies: Energies::None,
        tolerance: EXACT,
    }
}
