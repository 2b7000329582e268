//! `mepc deck`: what to paste into a host's input, from the properties.

mod calculix;
mod kratos;
mod mfront;
mod programs;

use crate::props::{self, list};
use crate::{Outcome, numbers, print, say};
use anyhow::{Result, anyhow, bail};
use clap::{ArgAction, ValueEnum};
use mepc::{Properties, default_state_size};
use std::path::PathBuf;

/// Print what to paste into a host's input.
///
/// The text goes to standard output, what has to be known about it to standard error.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc deck abaqus --props 0.3,0.002,2.5 >> joint.inp
  mepc deck kratos --props 0.3,0.002,2.5,0,0,0.005,1e5 --library target/release/libmepc.so > Materials.json
  mepc deck opengeosys --props 0.3,0.002,2.5,0,0,0.005,1e5 --thickness 0.1 --material 1 > friction.xml
  mepc deck c --props 0.3,0.002,2.5 > friction.c

Hosts that hand over an opening instead of a pressure (kratos, opengeosys, calculix, mtest) need kn, the 7th property.")]
pub struct Arguments {
    /// Which host, or language.
    #[arg(value_enum)]
    host: Host,
    #[arg(long, required = true, value_name = "mu,gcr,..", value_delimiter = ',', action = ArgAction::Set,
        allow_hyphen_values = true, value_parser = numbers::argument, help = props::HELP)]
    props: Vec<f64>,
    /// Tangential directions: 2 for surfaces, 1 for plane models.
    #[arg(long, default_value_t = 2, value_parser = |text: &str| numbers::whole::<u8>(text, 1..=2))]
    directions: u8,
    /// The shared library.
    #[arg(long, value_name = "PATH", default_value = "libmepc.so")]
    library: PathBuf,
    /// Name of the interaction, material or model part.
    #[arg(long, default_value = "Joint", value_parser = name)]
    name: String,
    /// Thickness of the layer that stands for the contact (calculix, opengeosys).
    #[arg(long, value_name = "h", allow_negative_numbers = true, value_parser = numbers::positive)]
    thickness: Option<f64>,
    /// Number of the material (kratos: properties_id; opengeosys: MaterialID).
    #[arg(long, value_name = "ID", default_value_t = 1,
        value_parser = |text: &str| numbers::whole::<u32>(text, 0..=u64::from(u32::MAX)))]
    material: u32,
}

/// What can be written for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Host {
    /// *FRICTION, USER=FRIC of Abaqus/Standard.
    Abaqus,
    /// Materials JSON for the interface elements of the GeoMechanics application.
    Kratos,
    /// Patch for an OpenGeoSys project: the contact as a thin layer.
    Opengeosys,
    /// *USER MATERIAL for a thin layer.
    Calculix,
    /// MTest file with a cycle of slip.
    Mtest,
    /// C program.
    C,
    /// Fortran program.
    Fortran,
}

impl Host {
    /// How far the text has been checked.
    fn checked(self) -> &'static str {
        match self {
            Host::Abaqus | Host::Calculix | Host::Mtest => "checked for form only, not by the host",
            Host::Kratos => "parsed as JSON by the tests",
            Host::Opengeosys => "parsed as XML by the tests",
            Host::C | Host::Fortran => "compiled and run by the tests",
        }
    }

    /// Whether the host hands over openings, which needs a normal stiffness.
    fn needs_normal_stiffness(self) -> bool {
        matches!(
            self,
            Host::Kratos | Host::Opengeosys | Host::Calculix | Host::Mtest
        )
    }
}

fn name(text: &str) -> Result<String, String> {
    let good = !text.is_empty()
        && text
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b));
    if good {
        Ok(text.to_string())
    } else {
        Err("must be letters, digits, and _ - . in between".to_string())
    }
}

/// What the writers work with.
struct Deck<'a> {
    properties: Properties,
    /// As given.
    props: &'a [f64],
    /// All common ones.
    complete: Vec<f64>,
    directions: usize,
    nstate: usize,
    library: String,
    name: &'a str,
    thickness: Option<f64>,
    material: u32,
}

impl Deck<'_> {
    fn layer(&self) -> Result<f64> {
        self.thickness.ok_or_else(|| {
            anyhow!("--thickness is missing: this host runs the contact as a thin layer")
        })
    }

    /// Numbers, so many per line.
    fn lines(values: &[f64], per_line: usize) -> String {
        let lines: Vec<String> = values
            .chunks(per_line)
            .map(|chunk| list(chunk).join(", "))
            .collect();
        lines.join(",\n ")
    }
}

/// Runs the command.
///
/// # Errors
/// Properties that are bad, or not enough for the host.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let host = arguments.host;
    let properties = props::check(&arguments.props)?;
    if host.needs_normal_stiffness() && properties.kn <= 0.0 {
        bail!(
            "--props: PROPS(7) kn = {}: this host hands over openings and needs a normal stiffness > 0",
            properties.kn
        );
    }
    if host != Host::Abaqus {
        properties
            .critical_slip(0.0)
            .map_err(|error| anyhow!("--props: {error}"))?;
    }
    let directions = usize::from(arguments.directions);
    let nstate = |directions| default_state_size(&arguments.props, directions);
    let mut deck = Deck {
        complete: props::complete(&properties),
        props: &arguments.props,
        directions,
        nstate: nstate(directions).map_err(|error| anyhow!("--props: {error}"))?,
        library: arguments.library.display().to_string(),
        name: &arguments.name,
        thickness: arguments.thickness,
        material: arguments.material,
        properties,
    };
    if matches!(host, Host::Kratos | Host::Calculix) {
        // Six slots have two shears, in plane models too.
        deck.nstate = nstate(2).map_err(|error| anyhow!("--props: {error}"))?;
    }
    let text = match host {
        Host::Abaqus => abaqus(&deck),
        Host::Kratos => {
            deck.library = absolute(&arguments.library);
            kratos::material(&deck)
        }
        Host::Opengeosys => mfront::opengeosys(&deck)?,
        Host::Calculix => calculix::material(&deck)?,
        Host::Mtest => mfront::mtest(&deck)?,
        Host::C => programs::c(&deck),
        Host::Fortran => programs::fortran(&deck),
    };
    say(&format!("note: {}", host.checked()));
    print(&text)
}

/// Kratos opens the library by its absolute path.
fn absolute(library: &std::path::Path) -> String {
    match library.canonicalize() {
        Ok(path) => path.display().to_string(),
        Err(error) => {
            say(&format!(
                "warning: --library {}: {error}; the host needs the absolute path of the library",
                library.display()
            ));
            library.display().to_string()
        }
    }
}

fn abaqus(deck: &Deck) -> String {
    format!(
        "** Friction with memory, routine FRIC of libmepc. {}\n\
         ** Add UNSYMM=YES to every *STEP; run with user=, see docs/hosts.md.\n\
         *SURFACE INTERACTION, NAME={}\n\
         *FRICTION, USER=FRIC, DEPVAR={}, PROPERTIES={}\n {}\n",
        Host::Abaqus.checked(),
        deck.name,
        deck.nstate,
        deck.props.len(),
        Deck::lines(deck.props, 8)
    )
}
