//! PROPS from the command line.

use crate::numbers;
use anyhow::{Result, anyhow};
use mepc::Properties;

/// Help for --props, everywhere the same.
pub const HELP: &str = "Properties of the contact law in their order: mu,gcr,chi,method,pressure_rule,fraction,kn,\
gap0,base_knots,backbone,beta; trailing ones may be left out";

/// The entries, checked.
///
/// # Errors
/// Names the entry.
pub fn check(props: &[f64]) -> Result<Properties> {
    Properties::new(props).map_err(|error| anyhow!("--props: {error}"))
}

/// The checked properties as the whole common list, defaults filled in.
pub fn complete(properties: &Properties) -> Vec<f64> {
    let number = |yes: bool| f64::from(u8::from(yes));
    vec![
        properties.mu,
        properties.gcr,
        properties.chi,
        match properties.method {
            mepc::Method::Memory => 0.0,
            mepc::Method::Penalty => 1.0,
            mepc::Method::Lagrange => 2.0,
        },
        number(properties.pressure_rule == mepc::PressureRule::Proportional),
        properties.fraction,
        properties.kn,
        properties.gap0,
        properties.base_knots as f64,
        number(properties.segalman),
        properties.beta,
        0.0,
    ]
}

/// Numbers for a deck: short where that is exact.
pub fn list(props: &[f64]) -> Vec<String> {
    props.iter().map(|&value| numbers::exact(value)).collect()
}
