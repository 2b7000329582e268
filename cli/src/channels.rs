//! Displacement and force of a record, in mm and N, with the units of the file.
//!
//! ```ignore
//! #[command(flatten)] columns: Columns,          // --displacement, --force, --displacement-unit, --force-unit
//! let channels = arguments.columns.read(path)?;  // says on standard error what was read
//! channels.displacement, channels.force          // mm, N: Vec<f64> of one length
//! channels.units                                 // of the file: for tables, channels.units.length.size() mm
//! channels.record()?                             // cut into branches
//! ```

use crate::table::{Gaps, Rows, Table};
use crate::units::{Force, Length};
use anyhow::{Result, anyhow, bail};
use mepc::iwan::Record;
use std::path::Path;

/// What files call a displacement.
const DISPLACEMENT: [&str; 16] = [
    "displacement",
    "displacements",
    "disp",
    "displ",
    "dis",
    "deflection",
    "extension",
    "elongation",
    "stroke",
    "position",
    "travel",
    "weg",
    "verschiebung",
    "déplacement",
    "deplacement",
    "lvdt",
];
/// What files call a force.
const FORCE: [&str; 8] = [
    "force", "forces", "load", "loads", "kraft", "last", "charge", "loadcell",
];

/// Which columns hold the loop, and in what unit.
#[derive(clap::Args)]
pub struct Columns {
    /// Displacement column, by name or by number from 1 [default: the one called displacement, disp, ..].
    #[arg(long, value_name = "COLUMN")]
    displacement: Option<String>,
    /// Force column, by name or by number from 1 [default: the one called force, load, ..].
    #[arg(long, value_name = "COLUMN")]
    force: Option<String>,
    /// Unit of the displacement [default: from the name or the row of units, else mm].
    #[arg(long, value_name = "UNIT", value_enum)]
    displacement_unit: Option<Length>,
    /// Unit of the force [default: from the name or the row of units, else N].
    #[arg(long, value_name = "UNIT", value_enum)]
    force_unit: Option<Force>,
}

/// The units of a file, in which tables are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Units {
    pub length: Length,
    pub force: Force,
}

/// A record as it was read.
pub struct Channels {
    /// In mm.
    pub displacement: Vec<f64>,
    /// In N.
    pub force: Vec<f64>,
    /// Units of the file.
    pub units: Units,
    /// FILE:LINE of the header and names of the columns, for messages.
    place: String,
}

impl Columns {
    /// Unit of the displacement, where an option says it.
    pub fn displacement_unit(&self) -> Option<Length> {
        self.displacement_unit
    }

    /// Unit of the force, likewise.
    pub fn force_unit(&self) -> Option<Force> {
        self.force_unit
    }

    /// Reads displacement and force.
    ///
    /// # Errors
    /// What the table is refused for.
    pub fn read(&self, file: &Path) -> Result<Channels> {
        let table = Table::open(file)?;
        let x = match &self.displacement {
            Some(wanted) => table.find(wanted, "--displacement"),
            None => table.find_by_words("displacement", &DISPLACEMENT, "--displacement"),
        };
        let f = match &self.force {
            Some(wanted) => table.find(wanted, "--force"),
            None => table.find_by_words("force", &FORCE, "--force"),
        };
        let (x, f) = match (x, f) {
            // Without names both are missing: one message for both.
            (Err(error), Err(_)) if !error.to_string().contains("missing in the header") => {
                let example = match table.width() {
                    ..=2 => "--displacement 1 --force 2",
                    _ => "for example --displacement 2 --force 3",
                };
                let words = error.to_string().replace("--displacement NUMBER", example);
                bail!(
                    "{}",
                    words.replace("column displacement:", "columns displacement and force:")
                );
            }
            (x, f) => (x?, f?),
        };
        let place = table.header_place();
        let unit = |column, option: &str, wrong: Option<bool>| -> Result<()> {
            let name = table.name(column);
            match (table.unit(column), wrong) {
                (Some(unit), Some(true)) => {
                    bail!("{place}: column {name}: is in {unit}, {option} is needed if it is right")
                }
                _ => Ok(()),
            }
        };
        let said = |column: usize| table.unit(column).unwrap_or("");
        let length = match self.displacement_unit {
            Some(unit) => unit,
            None => {
                unit(
                    x,
                    "--displacement-unit",
                    Some(Force::read(said(x)).is_some()),
                )?;
                Length::read(said(x)).unwrap_or(Length::Mm)
            }
        };
        let force = match self.force_unit {
            Some(unit) => unit,
            None => {
                unit(f, "--force-unit", Some(Length::read(said(f)).is_some()))?;
                Force::read(said(f)).unwrap_or(Force::N)
            }
        };
        let remark = format!(
            "'{}' ({}), '{}' ({})",
            table.name(x),
            length.name(),
            table.name(f),
            force.name()
        );
        let place = format!("{place}: columns {}, {}", table.name(x), table.name(f));
        let Rows { columns, .. } = table.read(&[x, f], Gaps::LeftOut, &remark)?;
        let mut columns = columns.into_iter();
        let mut next = |size: f64| {
            let mut values = columns.next().unwrap_or_default();
            if size != 1.0 {
                values.iter_mut().for_each(|value| *value *= size);
            }
            values
        };
        Ok(Channels {
            displacement: next(length.size()),
            force: next(force.size()),
            units: Units { length, force },
            place,
        })
    }
}

impl Channels {
    /// Cut into branches.
    ///
    /// # Errors
    /// No loop in the data.
    pub fn record(self) -> Result<Record> {
        let rows = self.force.len();
        Record::from_vectors(self.displacement, self.force)
            .map_err(|error| anyhow!("{}, {rows} rows: {}", self.place, crate::sentence(&error)))
    }
}

impl Units {
    /// Millimetres as a number in the unit of length.
    pub fn length(self, mm: f64) -> f64 {
        mm / self.length.size()
    }

    /// Newtons as a number in the unit of force.
    pub fn force(self, newtons: f64) -> f64 {
        newtons / self.force.size()
    }

    /// N/mm as a number in force per length.
    pub fn stiffness(self, newtons_per_mm: f64) -> f64 {
        newtons_per_mm * self.length.size() / self.force.size()
    }

    /// F_s (N), X_s (mm), k_alpha (N/mm) and kappa in these units.
    pub fn joint(self, [force, displacement, stiffness, kappa]: [f64; 4]) -> [f64; 4] {
        [
            self.force(force),
            self.length(displacement),
            self.stiffness(stiffness),
            kappa,
        ]
    }

    /// N.mm as a number in force times length.
    pub fn energy(self, newton_mm: f64) -> f64 {
        newton_mm / (self.length.size() * self.force.size())
    }
}
