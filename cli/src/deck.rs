//! `mepc deck`: what to paste into a host's input, from the properties.

mod calculix;
mod kratos;
mod mfront;
mod programs;

use crate::props::{self, Props, list};
use crate::{Outcome, numbers, print, say, wrong_use};
use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use mepc::state::{HEADER, Layout};
use mepc::{COMMON, Properties};
use std::path::{Path, PathBuf};

/// Print what to paste into a host's input.
///
/// The text goes to standard output, what has to be known about it to standard error. Options that the deck of a host has no use for
/// are refused.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  mepc deck abaqus --props mu=.3,gcr=.0027,reference_pressure=10 >> joint.inp
  mepc deck kratos --props mu=.3,gcr=.0027,reference_pressure=10,kn=1e5 --library target/release/libmepc.so > Materials.json
  mepc deck opengeosys --props mu=.3,gcr=.0027,reference_pressure=10,kn=1e5 --thickness 0.1 --material 1 > friction.xml
  mepc deck c --props mu=.3,gcr=.0027,reference_pressure=10 > friction.c

Hosts that hand over an opening instead of a pressure (kratos, opengeosys, calculix, mtest) need kn. The reference pressure is the
one at which gcr holds, the mean pressure of the preload: with it the stiffness of the contact follows the pressure, and a joint
that sticks neither creeps nor gains energy when the pressure pulses.")]
pub struct Arguments {
    /// Which host, or language.
    #[arg(value_enum)]
    host: Host,
    #[arg(long, required = true, value_name = "mu,gcr,..", allow_hyphen_values = true, value_parser = props::read, help = props::HELP)]
    props: Props,
    /// Tangential directions: 2 for surfaces, 1 for plane models; not for calculix [default: 2].
    #[arg(long, value_name = "N", value_parser = |text: &str| numbers::whole::<u8>(text, 1..=2))]
    directions: Option<u8>,
    /// The shared library (kratos, opengeosys, mtest) [default: libmepc.so].
    #[arg(long, value_name = "PATH")]
    library: Option<PathBuf>,
    /// Name of the interaction (abaqus), of the model part (kratos), of the parameters (opengeosys) [default: Joint].
    #[arg(long, value_parser = name)]
    name: Option<String>,
    /// Thickness of the layer that stands for the contact (calculix, opengeosys).
    #[arg(long, value_name = "h", allow_negative_numbers = true, value_parser = numbers::positive)]
    thickness: Option<f64>,
    /// Number of the material (kratos: properties_id; opengeosys: MaterialID) [default: 1].
    #[arg(long, value_name = "ID", value_parser = |text: &str| numbers::whole::<u32>(text, 0..=u64::from(u32::MAX)))]
    material: Option<u32>,
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

    /// The options that its deck has a place for, beside --props.
    fn options(self) -> &'static [&'static str] {
        match self {
            Host::Abaqus => &["--directions", "--name"],
            Host::Kratos => &["--directions", "--library", "--name", "--material"],
            Host::Opengeosys => &[
                "--directions",
                "--library",
                "--name",
                "--thickness",
                "--material",
            ],
            Host::Calculix => &["--thickness"],
            Host::Mtest => &["--directions", "--library"],
            Host::C | Host::Fortran => &["--directions"],
        }
    }

    /// Its name on the command line.
    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or(String::new(), |value| value.get_name().to_string())
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
    /// All common ones, zeros where nothing is given.
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

    /// The slots of the state that say something by themselves, as `1 ContactStatus (0 open, ..), 2 Pressure, ..`, each number
    /// after a prefix.
    fn slots(&self, prefix: &str) -> Result<Vec<String>> {
        let layout =
            Layout::new(self.directions, self.nstate).map_err(|error| anyhow!("{error}"))?;
        let shown = (0..HEADER)
            .filter(|&slot| slot < KNOTS && (self.directions == 2 || slot != SECOND_JUMP));
        Ok(shown
            .filter_map(|slot| {
                let name = layout.slot_name(slot)?;
                let words = if slot == 0 {
                    " (0 open, 1 stick, 2 micro-slip, 3 gross slip)"
                } else {
                    ""
                };
                Some(format!("{prefix}{} {name}{words}", slot + 1))
            })
            .collect())
    }

    /// Why there is a reference pressure, or that there is none.
    fn rule(&self) -> String {
        match self.properties.reference_pressure {
            0.0 => "No reference pressure: gcr is the same under every pressure, which may create energy when the pressure changes"
                .to_string(),
            pressure => format!(
                "gcr holds at the reference pressure {}: a sticking joint neither creeps nor gains energy when the pressure pulses",
                numbers::exact(pressure)
            ),
        }
    }
}

/// The slots of the header from here on say how the memory is kept.
const KNOTS: usize = 10;
/// Empty in one direction.
const SECOND_JUMP: usize = 8;

/// Refuses options that the host's deck has no place for.
fn check_options(arguments: &Arguments) -> Result<()> {
    let given = [
        ("--directions", arguments.directions.is_some()),
        ("--library", arguments.library.is_some()),
        ("--name", arguments.name.is_some()),
        ("--thickness", arguments.thickness.is_some()),
        ("--material", arguments.material.is_some()),
    ];
    let known = arguments.host.options();
    if let Some((option, _)) = given
        .iter()
        .find(|(option, given)| *given && !known.contains(option))
    {
        let host = arguments.host.name();
        return Err(wrong_use(format!(
            "{option}: the deck for {host} has no place for it, it takes {}",
            known.join(", ")
        )));
    }
    Ok(())
}

/// Runs the command.
///
/// # Errors
/// Properties that are bad, or not enough for the host.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let host = arguments.host;
    check_options(arguments)?;
    let props = arguments.props.0.as_slice();
    let properties = props::check(props)?;
    if props.len() > COMMON && host != Host::Abaqus {
        bail!(
            "--props: {} entries: those from {} on belong to the host, and the deck for {} writes its own",
            props.len(),
            COMMON + 1,
            host.name()
        );
    }
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
    let directions = usize::from(arguments.directions.unwrap_or(2));
    // Six slots have two shears, in plane models too.
    let shears = if matches!(host, Host::Kratos | Host::Calculix) {
        2
    } else {
        directions
    };
    let library = arguments
        .library
        .as_deref()
        .unwrap_or(Path::new("libmepc.so"));
    let mut deck = Deck {
        complete: props::complete(props),
        props,
        directions,
        nstate: Layout::default_size(shears),
        library: library.display().to_string(),
        name: arguments.name.as_deref().unwrap_or("Joint"),
        thickness: arguments.thickness,
        material: arguments.material.unwrap_or(1),
        properties,
    };
    let text = match host {
        Host::Abaqus => abaqus(&deck)?,
        Host::Kratos => {
            deck.library = absolute(library);
            say(&format!(
                "note: output in gauss_point_variables_in_elements: {}",
                deck.slots("STATE_VARIABLE_")?.join(", ")
            ));
            kratos::material(&deck)
        }
        Host::Opengeosys => mfront::opengeosys(&deck)?,
        Host::Calculix => calculix::material(&deck)?,
        Host::Mtest => mfront::mtest(&deck)?,
        Host::C => programs::c(&deck),
        Host::Fortran => programs::fortran(&deck),
    };
    if deck.properties.reference_pressure == 0.0 && !deck.properties.segalman {
        say(
            "warning: --props: no reference_pressure: gcr is then the same under every pressure (the paper's proportional rule), \
             which may create energy; give the pressure at which gcr holds, the mean pressure of the preload",
        );
    }
    say(&format!("note: {}", host.checked()));
    print(&text)
}

/// Kratos opens the library by its absolute path.
fn absolute(library: &Path) -> String {
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

/// Comment lines of a keyword deck, no longer than the 132 columns that are read.
fn comments(text: &[String]) -> String {
    const WIDTH: usize = 120;
    let mut lines = String::from("**");
    let mut length = 2;
    for (k, part) in text.iter().enumerate() {
        let end = if k + 1 < text.len() { "," } else { "" };
        if length + part.len() + 2 > WIDTH {
            lines += "\n**  ";
            length = 4;
        }
        lines += &format!(" {part}{end}");
        length += part.len() + 2;
    }
    lines + "\n"
}

fn abaqus(deck: &Deck) -> Result<String> {
    Ok(format!(
        "** Friction with memory, routine FRIC of libmepc. {}\n\
         ** Add UNSYMM=YES to every *STEP; run with user=, see docs/hosts.md.\n\
         ** {}.\n\
         *SURFACE INTERACTION, NAME={}\n\
         *FRICTION, USER=FRIC, DEPVAR={}, PROPERTIES={}\n {}\n\
         ** Output, without the stars into every *STEP; whether SDV is had of contact is not confirmed:\n\
         ** *OUTPUT, FIELD\n\
         ** *CONTACT OUTPUT\n\
         **  CSTATUS, CSTRESS, CDISP, SDV\n\
         ** *OUTPUT, HISTORY\n\
         ** *ENERGY OUTPUT\n\
         **  ALLFD, ALLSE\n\
         {}",
        Host::Abaqus.checked(),
        deck.rule(),
        deck.name,
        deck.nstate,
        deck.props.len(),
        Deck::lines(deck.props, 8),
        comments(&deck.slots("SDV")?),
    ))
}
