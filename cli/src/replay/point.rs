//! One point under prescribed slip and pressure: the shortest complete use of the friction form.

use super::Common;
use crate::table::{Gaps, Table, check_time, csv_line};
use anyhow::{Result, anyhow};
use mepc::Vector;
use std::path::Path;

/// The output table, and how many updates had to forget a reversal.
pub fn run(history: &Path, common: &Common) -> Result<(String, usize)> {
    let table = Table::open(history)?;
    if table.has("slip_2")? {
        replay::<2>(table, common)
    } else {
        replay::<1>(table, common)
    }
}

fn replay<const N: usize>(table: Table, common: &Common) -> Result<(String, usize)> {
    let mut columns = vec![table.find("time", "")?];
    for direction in 1..=N {
        columns.push(table.find(&format!("slip_{direction}"), "")?);
    }
    columns.push(table.find("pressure", "")?);
    table.note_unused(&columns);
    let rows = table.read(&columns, Gaps::Refused, "")?;
    let (time, slips, pressure) = (&rows.columns[0], &rows.columns[1..=N], &rows.columns[N + 1]);
    check_time(time, &rows)?;
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
    let mut before = Vector::<N>::zeros();
    let (mut dissipated, mut forgotten) = (0.0, 0);
    for row in 0..rows.len() {
        let slip = Vector::<N>::from_fn(|direction, _| slips[direction][row]);
        let response = law
            .friction(gcr, &(slip - before), pressure[row], &state, &mut next)
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
    }
    Ok((text, forgotten))
}
