//! One point under prescribed slip and pressure: the shortest complete use of the friction form.

use super::{Common, Replay, check_sign};
use crate::pictures::Replayed;
use crate::table::{Gaps, Table, check_time, csv_line};
use anyhow::{Result, anyhow};
use mepc::Vector;
use std::path::Path;

/// Replays the history.
///
/// # Errors
/// Bad input.
pub fn run(history: &Path, common: &Common) -> Result<Replay> {
    let table = Table::open(history)?;
    if table.has("slip_2")? {
        replay::<2>(history, table, common)
    } else {
        replay::<1>(history, table, common)
    }
}

fn replay<const N: usize>(history: &Path, table: Table, common: &Common) -> Result<Replay> {
    let mut columns = vec![table.find("time", "")?];
    for direction in 1..=N {
        columns.push(table.find(&format!("slip_{direction}"), "")?);
    }
    columns.push(table.find("pressure", "")?);
    table.note_unused(&columns);
    let rows = table.read(&columns, Gaps::Refused, "")?;
    let (time, slips, pressure) = (&rows.columns[0], &rows.columns[1..=N], &rows.columns[N + 1]);
    check_time(time, &rows)?;
    let column = format!("{}: column pressure", history.display());
    check_sign(pressure.iter().copied(), &column)?;
    let law = common.law::<N>()?;
    let gcr = law
        .critical_slip(0.0)
        .map_err(|error| anyhow!("--props: {error}"))?;
    let mut state = vec![0.0; law.layout().nstate];
    let mut next = state.clone();
    let numbered = |name: &str| -> String { (1..=N).map(|k| format!(",{name}_{k}")).collect() };
    let mut text = format!(
        "time{},pressure{},stored_energy,dissipated_energy,status\n",
        numbered("slip"),
        numbered("traction")
    );
    let mut drawn = Replayed::new("slip (mm)", "traction (MPa)", "energy (N/mm)", N);
    let mut before = Vector::<N>::zeros();
    let (mut dissipated, mut forgotten) = (0.0, 0);
    for row in 0..rows.len() {
        let slip = Vector::<N>::from_fn(|direction, _| slips[direction][row]);
        let response = law
            .friction(gcr, &(slip - before), pressure[row], 1.0, &state, &mut next)
            .map_err(|error| anyhow!("{}: step {}: {error}", rows.place(row), row + 1))?;
        std::mem::swap(&mut state, &mut next);
        before = slip;
        dissipated += response.dissipated;
        forgotten += usize::from(response.memory_full);
        let mut values = vec![time[row]];
        values.extend(slip.iter());
        values.push(pressure[row]);
        values.extend(response.traction.iter());
        values.extend([
            response.stored,
            dissipated,
            f64::from(response.contact as u8),
        ]);
        text += &csv_line(&values);
        let places = (0..N).map(|k| [slip[k], response.traction[k]]);
        drawn.push(time[row], places, [response.stored, dissipated]);
    }
    Ok(Replay {
        text,
        forgotten,
        drawn,
    })
}
