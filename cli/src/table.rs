//! CSV files: columns by name, and errors that name file, line and column.
//!
//! The text is UTF-8, or else Latin-1. Lines that start with # and blank lines are skipped; the first other line is the
//! header. Fields are separated by commas, or by semicolons or tabs if the header has no comma.

use crate::{numbers, say};
use anyhow::{Result, anyhow, bail};
use std::cell::Cell;
use std::io::Read;
use std::path::Path;

/// A CSV file in memory.
pub struct Table {
    file: String,
    header_line: usize,
    names: Vec<String>,
    /// Per column: has it been asked for?
    used: Vec<Cell<bool>>,
    rows: Vec<csv::StringRecord>,
    lines: Vec<usize>,
}

impl Table {
    /// Reads a file, or standard input for `-`.
    ///
    /// # Errors
    /// A file that cannot be read, no header, no rows, a name that appears twice, rows of another length than the header.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.display().to_string();
        let bytes = if file == "-" {
            let mut bytes = Vec::new();
            std::io::stdin().read_to_end(&mut bytes).map(|_| bytes)
        } else {
            std::fs::read(path)
        };
        let bytes = bytes.map_err(|error| anyhow!("{file}: {error}"))?;
        // Programs of test rigs write Latin-1, whose bytes are the first characters of Unicode.
        let text = String::from_utf8(bytes).unwrap_or_else(|error| {
            error
                .as_bytes()
                .iter()
                .map(|&byte| char::from(byte))
                .collect()
        });
        Self::parse(file, &text)
    }

    fn parse(file: String, text: &str) -> Result<Self> {
        if text.contains('\0') {
            bail!("{file}: is not a text file");
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        // The lines that count, with their numbers: the reader below would lose count at comments.
        let (lines, kept): (Vec<usize>, Vec<&str>) = text
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
            .unzip();
        let Some(header) = kept.first() else {
            bail!("{file}:1: is empty: no header line");
        };
        let delimiter = [b',', b';', b'\t']
            .into_iter()
            .find(|d| header.as_bytes().contains(d))
            .unwrap_or(b',');
        let kept = kept.join("\n");
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(kept.as_bytes());
        let mut records = Vec::new();
        for (record, line) in reader.records().zip(&lines) {
            records.push(record.map_err(|error| anyhow!("{file}:{line}: {error}"))?);
        }
        if records.len() < lines.len() {
            bail!(
                "{file}:{}: a quotation mark is not closed",
                lines[records.len().max(1) - 1]
            );
        }
        let names: Vec<String> = records.remove(0).iter().map(str::to_string).collect();
        let header_line = lines[0];
        for (index, name) in names.iter().enumerate() {
            if !name.is_empty() && names[..index].contains(name) {
                bail!("{file}:{header_line}: column {name}: appears twice in the header");
            }
        }
        for (record, line) in records.iter().zip(&lines[1..]) {
            let (found, columns) = (record.len(), names.len());
            if found < columns {
                bail!(
                    "{file}:{line}: column {}: missing, the line has {found} fields and the header {columns}",
                    names[found]
                );
            }
            if found > columns {
                bail!(
                    "{file}:{line}: column {}: has no name, the line has {found} fields and the header {columns}",
                    columns + 1
                );
            }
        }
        if records.is_empty() {
            bail!("{file}:{header_line}: has a header but no row below it");
        }
        Ok(Table {
            file,
            header_line,
            used: vec![Cell::new(false); names.len()],
            names,
            rows: records,
            lines: lines[1..].to_vec(),
        })
    }

    /// Whether there is such a column.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// No such column, or a field that is not a finite number.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let Some(column) = self.names.iter().position(|n| n == name) else {
            bail!(
                "{}:{}: column {name}: missing in the header, which has {}",
                self.file,
                self.header_line,
                self.names.join(", ")
            );
        };
        self.used[column].set(true);
        self.rows
            .iter()
            .enumerate()
            .map(|(row, record)| {
                let field = &record[column];
                numbers::read(field).map_err(|words| {
                    anyhow!("{}: column {name}: '{field}' {words}", self.place(row))
                })
            })
            .collect()
    }

    /// A column if it is there.
    ///
    /// # Errors
    /// As [`Table::column`], but for a missing one.
    pub fn optional(&self, name: &str) -> Result<Option<Vec<f64>>> {
        self.has(name).then(|| self.column(name)).transpose()
    }

    /// The column `time`, which must not decrease.
    ///
    /// # Errors
    /// As [`Table::column`]; time that goes back.
    pub fn time(&self) -> Result<Vec<f64>> {
        let time = self.column("time")?;
        for row in 1..time.len() {
            if time[row] < time[row - 1] {
                bail!(
                    "{}: column time: {} comes after {}, time must not decrease",
                    self.place(row),
                    time[row],
                    time[row - 1]
                );
            }
        }
        Ok(time)
    }

    /// The names of the columns that were not asked for.
    fn unused(&self) -> Vec<String> {
        let columns = self.names.iter().zip(&self.used).enumerate();
        columns
            .filter(|(_, (_, used))| !used.get())
            .map(|(index, (name, _))| match name.as_str() {
                "" => format!("{} (no name)", index + 1),
                name => name.to_string(),
            })
            .collect()
    }

    /// A note on standard error about columns that were not asked for: one of them may be an optional column mistyped. Files
    /// with more columns than a replay needs are common (records of a rig, the output of another replay), so it is no error.
    pub fn note_unused(&self) {
        let unused = self.unused();
        if !unused.is_empty() {
            let place = self.header_place();
            say(&format!(
                "note: {place}: columns not used: {}",
                unused.join(", ")
            ));
        }
    }

    /// FILE:LINE of a row, for messages.
    pub fn place(&self, row: usize) -> String {
        format!("{}:{}", self.file, self.lines[row])
    }

    /// FILE:LINE of the header.
    pub fn header_place(&self) -> String {
        format!("{}:{}", self.file, self.header_line)
    }

    /// How many rows there are below the header.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }
}

/// A row of numbers as a line of CSV.
pub fn csv_line(values: &[f64]) -> String {
    let fields: Vec<String> = values.iter().map(|&value| numbers::exact(value)).collect();
    fields.join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        let column = Table::parse("loop.csv".to_string(), text).and_then(|t| t.column("force"));
        column.expect_err("bad input").to_string()
    }

    #[test]
    fn columns_by_name() {
        let text = "\u{feff}# made by hand\n\n displacement ;\"force\"; note\n1;2D1;a\n# between\n 3 ;4;b\n";
        let table = Table::parse("loop.csv".to_string(), text).expect("a table");
        assert_eq!(table.column("force").expect("numbers"), [20.0, 4.0]);
        assert_eq!(table.place(1), "loop.csv:6");
        assert!(table.optional("time").expect("absent").is_none());
    }

    #[test]
    fn errors_name_line_and_column() {
        for (text, expected) in [
            ("", "loop.csv:1: is empty: no header line"),
            (
                "# x\nforce\n",
                "loop.csv:2: has a header but no row below it",
            ),
            (
                "a,force\n1,2\n# x\n3\n",
                "loop.csv:4: column force: missing, the line has 1 fields and the header 2",
            ),
            (
                "force\n1,2\n",
                "loop.csv:2: column 2: has no name, the line has 2 fields and the header 1",
            ),
            (
                "a,force\n1,2\n\n3,x\n",
                "loop.csv:4: column force: 'x' is not a number",
            ),
            (
                "force,force\n1,2\n",
                "loop.csv:1: column force: appears twice in the header",
            ),
            (
                "a,b\n1,2\n",
                "loop.csv:1: column force: missing in the header, which has a, b",
            ),
        ] {
            assert_eq!(message(text), expected);
        }
    }
}
