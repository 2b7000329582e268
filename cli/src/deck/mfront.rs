//! Hosts of the MFront interface: OpenGeoSys, where the contact is a thin layer, and MTest, where it is a cohesive zone.

use super::{Deck, Host};
use crate::numbers::exact;
use anyhow::{Result, bail};
use std::fmt::Write as _;

/// Material properties by their names, which are contracts of the behaviours.
fn properties(deck: &Deck) -> Vec<(&'static str, f64)> {
    let p = &deck.properties;
    vec![
        ("FrictionCoefficient", p.mu),
        ("CriticalSlip", p.gcr),
        ("Exponent", p.exponent),
        ("NormalStiffness", p.kn),
        ("InitialGap", p.gap0),
        ("ReferencePressure", p.reference_pressure),
    ]
}

/// Parameters of the behaviours and the property (from 1) that each one is.
const PARAMETERS: [(&str, usize); 9] = [
    ("Method", 4),
    ("NormalExponent", 9),
    ("Backbone", 10),
    ("Beta", 11),
    ("Cohesion", 12),
    ("MaximalTraction", 13),
    ("LateFrictionCoefficient", 14),
    ("LateSlipLength", 15),
    ("Resolution", 16),
];

/// The parameters that are not at their default.
fn parameters<'a>(deck: &'a Deck) -> impl Iterator<Item = (&'static str, usize, f64)> + 'a {
    let all = PARAMETERS
        .iter()
        .map(|&(name, property)| (name, property, deck.complete[property - 1]));
    all.filter(|(_, _, value)| *value != 0.0)
}

/// A project patch: applied by `ogs -p friction.xml project.prj`.
pub fn opengeosys(deck: &Deck) -> Result<String> {
    if let Some((name, property, value)) = parameters(deck).next() {
        bail!(
            "--props: PROPS({property}) {} = {}: is the parameter {name} of the behaviour, which a project of OpenGeoSys cannot set; \
             it hands over mu, gcr, exponent, kn, gap0 and reference_pressure only",
            mepc::NAMES[property - 1],
            exact(value)
        );
    }
    let mut values = properties(deck);
    values.push(("Thickness", deck.layer()?));
    let mut relation = String::new();
    let mut parameters = String::new();
    for (name, value) in values {
        let parameter = format!("{}_{name}", deck.name);
        let _ = writeln!(
            relation,
            "                <material_property name=\"{name}\" parameter=\"{parameter}\"/>"
        );
        let _ = write!(
            parameters,
            "        <parameter>\n            <name>{parameter}</name>\n            <type>Constant</type>\n            \
             <value>{}</value>\n        </parameter>\n",
            exact(value)
        );
    }
    let library = escape(&deck.library);
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <!-- Friction with memory as a thin layer of material {id}, normal along {normal}: ogs -p THIS.xml PROJECT.prj -->\n\
         <!-- {rule} -->\n\
         <!-- Output: <variables/> with nothing in it writes the state, too, at the integration points: {slots};\n\
         \x20    each between material_state_variable_ and _ip -->\n\
         <OpenGeoSysProjectDiff>\n\
         \x20   <add sel=\"/*/processes/process[1]\">\n\
         \x20       <constitutive_relation id=\"{id}\">\n\
         \x20           <type>MFront</type>\n\
         \x20           <library>{library}</library>\n\
         \x20           <behaviour>MemoryPenaltyLayer</behaviour>\n\
         \x20           <material_properties>\n{relation}\
         \x20           </material_properties>\n\
         \x20       </constitutive_relation>\n\
         \x20   </add>\n\
         \x20   <add sel=\"/*/parameters\">\n{parameters}\
         \x20   </add>\n\
         </OpenGeoSysProjectDiff>\n",
        id = deck.material,
        normal = if deck.directions == 1 { "y" } else { "z" },
        rule = deck.rule(),
        slots = deck.slots("")?.join(", "),
    ))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// A test: closed by a tenth of the critical slip, then a cycle of slip of twice the critical one.
pub fn mtest(deck: &Deck) -> Result<String> {
    let (hypothesis, tangential): (_, &[&str]) = if deck.directions == 1 {
        ("PlaneStrain", &["Ut"])
    } else {
        ("Tridimensional", &["Ut1", "Ut2"])
    };
    let mut text = format!(
        "// Friction with memory as a cohesive zone. {}.\n\
         // {}.\n\
         @ModellingHypothesis '{hypothesis}';\n\
         @Behaviour<generic> '{}' 'MemoryPenaltyContact';\n",
        Host::Mtest.checked(),
        deck.rule(),
        deck.library.replace('\'', "")
    );
    for (name, value) in properties(deck) {
        let _ = writeln!(
            text,
            "@MaterialProperty<constant> '{name}' {};",
            exact(value)
        );
    }
    for (name, _, value) in parameters(deck) {
        let _ = writeln!(text, "@Parameter '{name}' {};", exact(value));
    }
    let (gcr, gap) = (deck.properties.gcr, deck.properties.gap0);
    let closed = exact(-gap - 0.1 * gcr);
    let slip = exact(2.0 * gcr);
    text += "@ExternalStateVariable 'Temperature' 293.15;\n";
    let _ = writeln!(
        text,
        "@ImposedOpeningDisplacement 'Un' {{0: 0, 1: {closed}, 4: {closed}}};"
    );
    for (k, name) in tangential.iter().enumerate() {
        let course = if k == 0 {
            format!("{{0: 0, 1: 0, 2: {slip}, 3: -{slip}, 4: {slip}}}")
        } else {
            "0".to_string()
        };
        let _ = writeln!(text, "@ImposedOpeningDisplacement '{name}' {course};");
    }
    text += "@Times {0, 1 in 1, 4 in 120};\n";
    let _ = writeln!(
        text,
        "// Output: after time, openings and tractions the state: {}",
        deck.slots("")?.join(", ")
    );
    Ok(text)
}
