//! cases/cases.toml: what the demo replays.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// The library's methods, as its property 4 numbers them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The law with memory.
    Memory = 0,
    /// The standard penalty method.
    Penalty = 1,
    /// Rigid stick.
    Lagrange = 2,
}

impl Method {
    pub const ALL: [Method; 3] = [Method::Memory, Method::Penalty, Method::Lagrange];

    /// In file names and in the table.
    pub fn name(self) -> &'static str {
        ["memory", "penalty", "Lagrange"][self as usize]
    }
}

/// A history with the law it is replayed on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Base name of everything the demo writes for this case.
    pub name: String,
    /// Heading of its pictures.
    pub title: String,
    /// History file.
    pub history: PathBuf,
    /// Patch file; a single point without it.
    pub patch: Option<PathBuf>,
    /// Properties mu, gcr, chi; the demo fills in the method.
    pub props: [f64; 3],
    /// Reference pressure of the consistent rule; without it the proportional rule.
    #[serde(default)]
    pub reference_pressure: f64,
    /// Stiffness between the prescribed displacement and the patch.
    pub series: Option<f64>,
    /// Stiffness beside the patch.
    pub parallel: Option<f64>,
    /// The last so many steps are one closed loop; without it dissipation is that of the whole history.
    pub loop_steps: Option<usize>,
    /// Radius over gcr: the loop is a steady circle.
    pub circle: Option<f64>,
    /// Length of the state array, so short that the memory gets full; the library's default without it.
    pub nstate: Option<u32>,
    /// Only the method with memory.
    #[serde(default)]
    pub memory_only: bool,
    /// Name of the case whose force this one must reproduce.
    pub same_loop_as: Option<String>,
}

impl Case {
    pub fn mu(&self) -> f64 {
        self.props[0]
    }

    pub fn gcr(&self) -> f64 {
        self.props[1]
    }

    pub fn chi(&self) -> f64 {
        self.props[2]
    }

    /// The methods that it is replayed with.
    pub fn methods(&self) -> &'static [Method] {
        &Method::ALL[..if self.memory_only { 1 } else { 3 }]
    }

    /// The property array with the method.
    pub fn props(&self, method: Method) -> [f64; 5] {
        let [mu, gcr, chi] = self.props;
        [
            mu,
            gcr,
            chi,
            f64::from(method as u8),
            self.reference_pressure,
        ]
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    case: Vec<Case>,
}

/// Reads the manifest; file names in it are relative to its directory.
pub fn read(path: &Path) -> Result<Vec<Case>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let manifest: Manifest = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let directory = path.parent().unwrap_or(Path::new("."));
    let mut cases = manifest.case;
    for i in 0..cases.len() {
        if cases[..i].iter().any(|c| c.name == cases[i].name) {
            bail!("{}: two cases are called {}", path.display(), cases[i].name);
        }
        if let Some(other) = &cases[i].same_loop_as
            && !cases[..i].iter().any(|c| &c.name == other)
        {
            bail!(
                "{}: case {}: no case {other} before it",
                path.display(),
                cases[i].name
            );
        }
    }
    for case in &mut cases {
        case.history = directory.join(&case.history);
        case.patch = case.patch.as_ref().map(|patch| directory.join(patch));
    }
    Ok(cases)
}
