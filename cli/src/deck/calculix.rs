//! CalculiX: the contact as a thin layer of C3D8 elements, normal along z, by its UMAT interface.

use super::{Deck, Host, comments};
use anyhow::Result;

/// PROPS 21: a layer, components in Abaqus' order.
const LAYOUT: f64 = 2.0;
/// PROPS 24: the host makes the matrix symmetric, with which only the sticking one converges.
const STICKING: f64 = 1.0;

/// The material.
pub fn material(deck: &Deck) -> Result<String> {
    let mut props = deck.complete.clone();
    // PROPS 25: the order of the matrix is that of the symbol.
    props.extend([LAYOUT, 1.0, deck.layer()?, STICKING, 0.0]);
    let constants = props.len();
    // The temperature for which they hold; without it the host refuses the deck.
    props.push(0.0);
    Ok(format!(
        "** Friction with memory as a thin layer, normal along z, without NLGEOM. {}\n\
         ** The host loads libMEPC.so (a link to libmepc.so), if it was built with external behaviours.\n\
         ** {}.\n\
         *MATERIAL, NAME=@ABAQUS_MEPC\n\
         *USER MATERIAL, CONSTANTS={}\n {}\n\
         *DEPVAR\n {}\n\
         ** Output, without the stars into every *STEP:\n\
         ** *EL FILE\n\
         **  S, SDV\n\
         {}",
        Host::Calculix.checked(),
        deck.rule(),
        constants,
        Deck::lines(&props, 8),
        deck.nstate,
        comments(&deck.slots("SDV")?),
    ))
}
