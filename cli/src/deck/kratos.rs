//! Kratos: materials for `UPwSmallStrainInterfaceElement2D4N` and `3D8N`, whose law is a UMAT.

use super::Deck;
use serde_json::json;

/// PROPS 21: six slots, normal third.
const LAYOUT: f64 = 1.0;
/// PROPS 22: the law sees half of the jump, and its traction counts half.
const SCALE: f64 = 2.0;

/// The materials file. The fluid's constants are required by the element and without effect where the water pressure is fixed.
pub fn material(deck: &Deck) -> String {
    let law = if deck.directions == 1 {
        "SmallStrainUMAT2DInterfaceLaw"
    } else {
        "SmallStrainUMAT3DInterfaceLaw"
    };
    let mut props = deck.complete.clone();
    props.extend([LAYOUT, SCALE, 0.0, 0.0, 0.0]);
    let file = json!({
        "properties": [{
            "model_part_name": deck.name,
            "properties_id": deck.material,
            "Material": {
                "constitutive_law": { "name": law },
                "Variables": {
                    "UDSM_NAME": deck.library,
                    "IS_FORTRAN_UDSM": true,
                    "UMAT_PARAMETERS": props,
                    "STATE_VARIABLES": vec![0.0; deck.nstate],
                    "GEO_DRAINAGE_TYPE": "CONSTANT_PW_FIELD",
                    "MINIMUM_JOINT_WIDTH": 1e-3,
                    "YOUNG_MODULUS": deck.properties.kn,
                    "POISSON_RATIO": 0.0,
                    "DENSITY_SOLID": 0.0,
                    "DENSITY_WATER": 0.0,
                    "POROSITY": 0.3,
                    "BIOT_COEFFICIENT": 1.0,
                    "BULK_MODULUS_SOLID": 1e9,
                    "BULK_MODULUS_FLUID": 1e9,
                    "DYNAMIC_VISCOSITY": 1e-3,
                    "TRANSVERSAL_PERMEABILITY": 0.0,
                    "RETENTION_LAW": "SaturatedLaw",
                    "SATURATED_SATURATION": 1.0
                },
                "Tables": {}
            }
        }]
    });
    format!("{file:#}\n")
}
