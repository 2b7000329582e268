//! Tables as rigs and programs write them, read in bounded memory. The one reader of the tool.
//!
//! ```ignore
//! let table = Table::open(path)?;                        // the form is told from the first lines
//! let x = table.find("displacement", "--displacement")?; // by name, or by number from 1
//! let f = table.find("2", "--force")?;
//! table.unit(f);                                         // from the name or the row of units
//! let rows = table.read(&[x, f], Gaps::LeftOut, "")?;    // one pass, only these columns; says what was read on standard error
//! let [x, f] = rows.columns;                             // Vec<f64> each, all finite and of one length
//! rows.place(7)                                          // FILE:LINE of row 7, for messages
//! ```
//!
//! For displacement and force with their units see [`crate::channels`].
//!
//! Read are: comma, semicolon, tab, blanks or what a line `sep=` says; decimal point or comma; UTF-8, UTF-16, Latin-1; LF, CRLF, CR; lines
//! before the names, a row of units, no names at all; comments (# and %), empty lines, quotation marks, empty columns at the end,
//! words for missing samples; text below the numbers; JSON with one array per column. See `docs/identify.md`.

mod form;
mod json;
mod lines;

use crate::{numbers, say, units};
use anyhow::{Result, anyhow, bail, ensure};
use form::{Decimal, Field, Form, Line, Splitter, Trouble, comment, is_blank};
use lines::{Lines, decode};
use std::path::Path;

/// The form is told from so many lines, and from about so many bytes.
const HEAD_LINES: usize = 1000;
const HEAD_BYTES: usize = 2 << 20;
/// More fields in a line are no table.
const MOST_COLUMNS: usize = 200_000;
/// More numbers are refused, for they would fill the memory.
const MOST_NUMBERS: usize = 50_000_000;
/// As many names are listed in a message.
const LISTED: usize = 12;
/// Names this alike (Jaro and Winkler's measure) are proposed.
const ALIKE: f64 = 0.75;

/// What to do with rows that lack a number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Gaps {
    /// Leave them out, count them, and say so.
    LeftOut,
    /// Refuse the table.
    Refused,
}

/// A file whose form is known and whose rows are still to be read.
pub struct Table {
    file: String,
    names: Vec<String>,
    units: Vec<Option<String>>,
    source: Source,
}

enum Source {
    Text {
        form: Form,
        head: Vec<Line>,
        lines: Box<Lines>,
    },
    Json(Vec<Vec<f64>>),
}

impl Table {
    /// Opens a file, or standard input for `-`, and tells its form.
    ///
    /// # Errors
    /// A file that cannot be read, is no text, or has no row of numbers.
    pub fn open(path: &Path) -> Result<Self> {
        Self::from_lines(path.display().to_string(), Lines::open(path)?)
    }

    fn from_lines(file: String, mut lines: Lines) -> Result<Self> {
        if lines.is_json()? {
            let columns =
                json::read(lines.into_reader()).map_err(|words| anyhow!("{file}: {words}"))?;
            ensure!(
                !columns.is_empty(),
                "{file}: is read as JSON: has no array of numbers"
            );
            let (names, columns): (Vec<String>, Vec<Vec<f64>>) = columns.into_iter().unzip();
            let units = names.iter().map(|name| unit_of(name, None)).collect();
            return Ok(Table {
                file,
                names,
                units,
                source: Source::Json(columns),
            });
        }
        let mut head: Vec<Line> = Vec::new();
        let mut bytes = 0;
        while head.len() < HEAD_LINES && (bytes < HEAD_BYTES || head.len() < 3) {
            let Some((number, line)) = lines.next().map_err(|error| anyhow!("{file}:{error}"))?
            else {
                break;
            };
            bytes += line.len();
            head.push((number, line.to_vec()));
        }
        let form = Form::new(&head).map_err(|trouble| match trouble {
            Trouble::Empty => anyhow!("{file}:1: is empty: no header line"),
            Trouble::NoRows(line) => anyhow!("{file}:{line}: has a header but no row below it"),
            Trouble::NoNumbers(line) => anyhow!("{file}: no row of numbers up to line {line}"),
            Trouble::Uncut(line, words) => anyhow!("{file}:{line}: {words}"),
        })?;
        if lines.encoding.is_none()
            && head
                .iter()
                .any(|(_, line)| std::str::from_utf8(line).is_err())
        {
            lines.encoding = Some("Latin-1");
        }
        let unit = |k: usize| {
            unit_of(
                form.names.get(k).map_or("", String::as_str),
                form.units.get(k),
            )
        };
        Ok(Table {
            file,
            units: (0..form.columns).map(unit).collect(),
            names: form.names.clone(),
            source: Source::Text {
                form,
                head,
                lines: Box::new(lines),
            },
        })
    }

    /// How many columns there are.
    pub fn width(&self) -> usize {
        self.units.len()
    }

    /// The index of a column that is wanted by its number, counted from 1, or by its name, without regard to case, blanks and
    /// a unit in it. None if there is no such column.
    ///
    /// # Errors
    /// More than one such column.
    fn look_up(&self, wanted: &str) -> Result<Option<usize>> {
        let wanted = wanted.trim();
        if let Ok(number) = wanted.parse::<usize>() {
            return Ok((1..=self.width()).contains(&number).then(|| number - 1));
        }
        let ways: [fn(&str) -> String; 4] = [
            |name| name.trim().to_string(),
            key,
            |name| key(units::split_name(name).0),
            |name| key(units::split_name(units::split_name(name).0).0),
        ];
        for way in ways {
            let this = way(wanted);
            let found: Vec<usize> = (0..self.names.len())
                .filter(|&k| !self.names[k].is_empty() && way(&self.names[k]) == this)
                .collect();
            match found[..] {
                [] => {}
                [column] => return Ok(Some(column)),
                _ => bail!(
                    "{}: column {wanted}: {} columns have this name: {}",
                    self.header_place(),
                    found.len(),
                    self.list(&found)
                ),
            }
        }
        Ok(None)
    }

    /// Whether there is such a column.
    ///
    /// # Errors
    /// More than one such column.
    pub fn has(&self, name: &str) -> Result<bool> {
        Ok(self.look_up(name)?.is_some())
    }

    /// The column of a name or number; `option` names the option to choose it by, if there is one.
    ///
    /// # Errors
    /// None or more than one of this name; names that are nearly right are proposed.
    pub fn find(&self, wanted: &str, option: &str) -> Result<usize> {
        match self.look_up(wanted)? {
            Some(column) => Ok(column),
            None => Err(self.absent(wanted, option)),
        }
    }

    /// As [`Table::find`] for a quantity that the user has not named: `words` are what files call it. One column must have one of
    /// them in its name.
    ///
    /// # Errors
    /// As [`Table::find`].
    pub fn find_by_words(&self, wanted: &str, words: &[&str], option: &str) -> Result<usize> {
        if let Some(column) = self.look_up(wanted)? {
            return Ok(column);
        }
        let has_word = |name: &str| {
            let (base, _) = units::split_name(name);
            let base = base.to_lowercase();
            base.split(|c: char| !c.is_alphabetic())
                .any(|word| words.contains(&word))
        };
        let found: Vec<usize> = (0..self.names.len())
            .filter(|&k| has_word(&self.names[k]))
            .collect();
        match found[..] {
            [column] => Ok(column),
            [] => Err(self.absent(wanted, option)),
            _ => bail!(
                "{}: column {wanted}: may be one of {}: choose with {option}",
                self.header_place(),
                self.list(&found)
            ),
        }
    }

    /// The message about a column that is not there.
    fn absent(&self, wanted: &str, option: &str) -> anyhow::Error {
        let width = self.width();
        let columns = if width == 1 {
            "1 column".to_string()
        } else {
            format!("{width} columns")
        };
        if wanted.trim().parse::<usize>().is_ok() {
            return anyhow!(
                "{}: column {wanted}: the table has {columns}, counted from 1",
                self.header_place()
            );
        }
        let by_number = match option {
            "" => String::new(),
            _ => format!(", choose by number, counted from 1: {option} NUMBER"),
        };
        if self.names.is_empty() {
            let sample = match &self.source {
                Source::Text { form, .. } => {
                    let shown: Vec<&str> = form
                        .sample
                        .iter()
                        .take(LISTED)
                        .map(String::as_str)
                        .collect();
                    let header = match form.misfit {
                        Some((line, 1)) => format!(", line {line} above is no header of {columns}"),
                        Some((line, names)) => format!(", line {line} above has {names} names"),
                        None => String::new(),
                    };
                    format!(
                        " ({columns}, line {}: {}{header})",
                        form.first_line,
                        shown.join(" | ")
                    )
                }
                Source::Json(_) => String::new(),
            };
            return anyhow!(
                "{}: column {wanted}: the table has no names{sample}{by_number}",
                self.header_place()
            );
        }
        let mut near: Vec<(f64, &str)> = self
            .names
            .iter()
            .filter(|name| !name.is_empty())
            .map(|name| {
                let whole = strsim::jaro_winkler(&key(name), &key(wanted));
                let base = strsim::jaro_winkler(&key(units::split_name(name).0), &key(wanted));
                (whole.max(base), name.as_str())
            })
            .filter(|(alike, _)| *alike >= ALIKE)
            .collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        let proposal = match near.first() {
            Some((_, name)) => format!("; did you mean '{name}'?"),
            None => String::new(),
        };
        let all: Vec<usize> = (0..self.names.len()).collect();
        anyhow!(
            "{}: column {wanted}: missing in the header, which has {}{proposal}{}",
            self.header_place(),
            self.list(&all),
            by_number.replacen(", choose", "; choose by name or", 1)
        )
    }

    /// Names of columns, for messages.
    fn list(&self, columns: &[usize]) -> String {
        let shown = columns.iter().take(LISTED);
        let mut shown: Vec<String> = shown
            .map(|&k| match self.names.get(k).map(String::as_str) {
                None | Some("") => format!("{} (no name)", k + 1),
                Some(name) => name.to_string(),
            })
            .collect();
        if columns.len() > LISTED {
            shown.push(format!("{} more", columns.len() - LISTED));
        }
        shown.join(", ")
    }

    /// The name of a column, or its number.
    pub fn name(&self, column: usize) -> String {
        match self.names.get(column).map(String::as_str) {
            None | Some("") => format!("column {}", column + 1),
            Some(name) => name.to_string(),
        }
    }

    /// What the name or the row of units says is the unit of a column.
    pub fn unit(&self, column: usize) -> Option<&str> {
        self.units.get(column)?.as_deref()
    }

    /// FILE:LINE of the header.
    pub fn header_place(&self) -> String {
        match &self.source {
            Source::Text { form, .. } => match form.header_line {
                Some(line) => format!("{}:{line}", self.file),
                None => self.file.clone(),
            },
            Source::Json(_) => self.file.clone(),
        }
    }

    /// A note on standard error about columns that are not used: one of them may be an optional column mistyped. Files with
    /// more columns than a replay needs are common (records of a rig, the output of another replay), so it is no error.
    pub fn note_unused(&self, used: &[usize]) {
        let unused: Vec<usize> = (0..self.width()).filter(|k| !used.contains(k)).collect();
        if !unused.is_empty() {
            say(&format!(
                "note: {}: columns not used: {}",
                self.header_place(),
                self.list(&unused)
            ));
        }
    }

    /// Reads the rows of these columns, and says on standard error how the file was read, with a remark of the caller.
    /// Without a remark nothing is said about plain CSV.
    ///
    /// # Errors
    /// A field that is no finite number, a line that has not as many fields as the table.
    pub fn read(self, columns: &[usize], gaps: Gaps, remark: &str) -> Result<Rows> {
        let file = self.file.clone();
        let remark = if remark.is_empty() {
            String::new()
        } else {
            format!(": {remark}")
        };
        let names: Vec<String> = columns.iter().map(|&k| self.name(k)).collect();
        let rows = match self.source {
            Source::Text { form, head, lines } => {
                if !remark.is_empty() || lines.encoding.is_some() || !form.is_plain() {
                    let words = form.words(lines.encoding);
                    say(&format!("{file}: reading: {words}{remark}"));
                }
                read_lines(file, &form, head, *lines, (columns, names, gaps))?
            }
            Source::Json(data) => {
                say(&format!(
                    "{file}: reading: JSON, {} arrays{remark}",
                    data.len()
                ));
                from_arrays(file, data, (columns, names, gaps))?
            }
        };
        if rows.left_out > 0 {
            say(&format!(
                "note: {}: {} of {} rows have no number in the columns used (the first in {}) and are left out",
                rows.file,
                rows.left_out,
                rows.left_out + rows.len(),
                rows.first_left_out,
            ));
        }
        if rows.len() == 0 {
            bail!("{}: no row has numbers in all columns used", rows.file);
        }
        Ok(rows)
    }
}

/// The unit of a column, by the row of units or by its name.
fn unit_of(name: &str, row: Option<&String>) -> Option<String> {
    match row {
        Some(unit) if !unit.is_empty() => Some(unit.clone()),
        _ => units::split_name(name).1.map(str::to_string),
    }
}

/// Names are the same if they are in lower case and without blanks.
fn key(name: &str) -> String {
    let kept = name.chars().filter(|c| !c.is_whitespace());
    kept.flat_map(char::to_lowercase).collect()
}

/// Columns of numbers.
pub struct Rows {
    /// One per column that was asked for, all finite and of one length.
    pub columns: Vec<Vec<f64>>,
    /// Rows that had no number in one of the columns.
    pub left_out: usize,
    first_left_out: String,
    file: String,
    /// Row and line from which on one follows the other; none: there are no lines.
    runs: Vec<(usize, usize)>,
}

impl Rows {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// FILE:LINE of a row, for messages.
    pub fn place(&self, row: usize) -> String {
        let run = self.runs.partition_point(|(first, _)| *first <= row);
        match run.checked_sub(1).map(|run| self.runs[run]) {
            Some((first, line)) => format!("{}:{}", self.file, line + row - first),
            None => format!("{}: element {}", self.file, row + 1),
        }
    }
}

/// Columns, their names, and what to do with gaps.
type Wanted<'a> = (&'a [usize], Vec<String>, Gaps);

fn from_arrays(
    file: String,
    mut data: Vec<Vec<f64>>,
    (columns, names, gaps): Wanted,
) -> Result<Rows> {
    let lengths: Vec<usize> = columns.iter().map(|&k| data[k].len()).collect();
    if let Some(other) = lengths.iter().position(|length| *length != lengths[0]) {
        bail!(
            "{file}: column {}: {} elements, column {} has {}",
            names[other],
            lengths[other],
            names[0],
            lengths[0]
        );
    }
    let mut found: Vec<Vec<f64>> = Vec::new();
    for (n, &k) in columns.iter().enumerate() {
        // The same array may be wanted twice.
        let again = columns[..n].iter().position(|&earlier| earlier == k);
        found.push(match again {
            Some(earlier) => found[earlier].clone(),
            None => std::mem::take(&mut data[k]),
        });
    }
    let rows = lengths.first().copied().unwrap_or(0);
    let whole: Vec<bool> = (0..rows)
        .map(|row| found.iter().all(|column| column[row].is_finite()))
        .collect();
    let left_out = whole.iter().filter(|whole| !**whole).count();
    let mut first_left_out = String::new();
    if let Some(row) = whole.iter().position(|whole| !whole) {
        first_left_out = format!("element {}", row + 1);
        if gaps == Gaps::Refused {
            let column = found
                .iter()
                .position(|column| !column[row].is_finite())
                .unwrap_or(0);
            bail!(
                "{file}: {first_left_out}: column {}: has no number",
                names[column]
            );
        }
        for column in &mut found {
            let mut row = 0;
            column.retain(|_| {
                row += 1;
                whole[row - 1]
            });
        }
    }
    Ok(Rows {
        columns: found,
        left_out,
        first_left_out,
        file,
        runs: Vec::new(),
    })
}

/// Lines below the numbers that hold none.
struct Tail {
    line: usize,
    text: String,
    count: usize,
}

/// Reads rows line by line.
struct RowReader<'a> {
    form: &'a Form,
    splitter: Splitter,
    decimal: Decimal,
    names: Vec<String>,
    wanted: &'a [usize],
    gaps: Gaps,
    rows: Rows,
    values: Vec<f64>,
    last_line: usize,
    tail: Option<Tail>,
}

fn read_lines(
    file: String,
    form: &Form,
    head: Vec<Line>,
    mut lines: Lines,
    (wanted, names, gaps): Wanted,
) -> Result<Rows> {
    let mut reader = RowReader {
        form,
        splitter: Splitter::new(form.separator),
        decimal: form.decimal,
        names,
        wanted,
        gaps,
        rows: Rows {
            columns: vec![Vec::new(); wanted.len()],
            left_out: 0,
            first_left_out: String::new(),
            file,
            runs: Vec::new(),
        },
        values: vec![0.0; wanted.len()],
        last_line: 0,
        tail: None,
    };
    for (number, line) in head {
        if number >= form.first_line {
            reader.take(number, &line)?;
        }
    }
    loop {
        let next = lines.next();
        let Some((number, line)) = next.map_err(|error| anyhow!("{}:{error}", reader.rows.file))?
        else {
            break;
        };
        reader.take(number, line)?;
    }
    if let Some(Tail { line, text, count }) = &reader.tail {
        let which = if *count == 1 {
            format!("line {line} below the numbers holds none and is left out")
        } else {
            format!(
                "the {count} lines from {line} on, below the numbers, hold none and are left out"
            )
        };
        say(&format!("note: {}: {which} ('{text}')", reader.rows.file));
    }
    for column in &mut reader.rows.columns {
        column.shrink_to_fit();
    }
    Ok(reader.rows)
}

impl RowReader<'_> {
    fn take(&mut self, number: usize, line: &[u8]) -> Result<()> {
        if is_blank(line) || comment(line).is_some() {
            return Ok(());
        }
        let place = |rows: &Rows| format!("{}:{number}", rows.file);
        if !self.splitter.split(line) {
            bail!("{}: {}", place(&self.rows), self.splitter.trouble());
        }
        let (fields, columns) = (self.splitter.len(), self.form.columns);
        let mut whole = true;
        let mut fault = None;
        for (k, &column) in self.wanted.iter().enumerate() {
            if column >= fields {
                fault = Some(format!(
                    "column {}: missing, the line has {fields} fields and the table {columns}",
                    self.names[k]
                ));
                break;
            }
            match Field::read(self.splitter.field(line, column), &mut self.decimal) {
                Field::Number(value) => self.values[k] = value,
                Field::Missing => whole = false,
                Field::Text(words) => {
                    let text = shown(self.splitter.field(line, column));
                    fault = Some(format!("column {}: '{text}' {words}", self.names[k]));
                    break;
                }
            }
        }
        let is_filled = |k: usize| !is_blank(self.splitter.field(line, k));
        if fault.is_none() && (columns..fields).any(is_filled) {
            fault = Some(format!(
                "column {}: has no name, the line has {fields} fields and the table {columns}",
                columns + 1
            ));
        }
        if fault.is_some() || !whole {
            if (0..fields).all(|k| !is_filled(k)) {
                return Ok(()); // separators only
            }
            let mut decimal = self.decimal;
            let (mut numbers, mut texts) = (false, fault.is_some());
            for k in 0..fields.min(columns) {
                match Field::read(self.splitter.field(line, k), &mut decimal) {
                    Field::Number(_) => numbers |= self.form.numeric[k],
                    Field::Text(_) => texts = true,
                    Field::Missing => {}
                }
            }
            if !numbers && texts && self.gaps == Gaps::LeftOut {
                let tail = self.tail.get_or_insert_with(|| Tail {
                    line: number,
                    text: shown(line),
                    count: 0,
                });
                tail.count += 1;
                return Ok(());
            }
            if let Some(words) = fault {
                bail!("{}: {words}", place(&self.rows));
            }
        }
        if let Some(Tail { line, text, .. }) = &self.tail {
            bail!(
                "{}:{line}: '{text}' holds no numbers, but line {number} below it does: cut the file there",
                self.rows.file
            );
        }
        if !whole {
            if self.gaps == Gaps::Refused {
                let missing = |column: &usize| {
                    let field = self.splitter.field(line, *column);
                    Field::read(field, &mut Decimal::Unknown) == Field::Missing
                };
                let k = self.wanted.iter().position(missing).unwrap_or(0);
                let text = shown(self.splitter.field(line, self.wanted[k]));
                bail!(
                    "{}: column {}: '{text}' is no number",
                    place(&self.rows),
                    self.names[k]
                );
            }
            if self.rows.left_out == 0 {
                self.rows.first_left_out = format!("line {number}");
            }
            self.rows.left_out += 1;
            return Ok(());
        }
        let row = self.rows.len();
        if row * self.values.len() >= MOST_NUMBERS {
            bail!(
                "{}: more than {row} rows of {} numbers: leave out samples, or cut the file",
                place(&self.rows),
                self.values.len()
            );
        }
        if self.rows.runs.is_empty() || number != self.last_line + 1 {
            self.rows.runs.push((row, number));
        }
        self.last_line = number;
        for (column, &value) in self.rows.columns.iter_mut().zip(&self.values) {
            column.push(value);
        }
        Ok(())
    }
}

/// The start of a text from a file, for messages.
fn shown(bytes: &[u8]) -> String {
    const LONGEST: usize = 60;
    let start = &bytes[..bytes.len().min(4 * LONGEST)];
    let text = decode(start);
    let text = text.trim();
    let short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() || start.len() < bytes.len() {
        short + ".."
    } else {
        short
    }
}

/// Refuses time that goes back.
///
/// # Errors
/// With the place of the row.
pub fn check_time(time: &[f64], rows: &Rows) -> Result<()> {
    for row in 1..time.len() {
        if time[row] < time[row - 1] {
            bail!(
                "{}: column time: {} comes after {}, time must not decrease",
                rows.place(row),
                time[row],
                time[row - 1]
            );
        }
    }
    Ok(())
}

/// A row of numbers as a line of CSV.
pub fn csv_line(values: &[f64]) -> String {
    let fields: Vec<String> = values.iter().map(|&value| numbers::exact(value)).collect();
    fields.join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn table(text: impl Into<Vec<u8>>) -> Result<Table> {
        let lines = Lines::new(Cursor::new(text.into()), None);
        Table::from_lines("loop.csv".to_string(), lines)
    }

    fn column(text: &str, name: &str, gaps: Gaps) -> Result<Rows> {
        let table = table(text)?;
        let column = table.find(name, "--force")?;
        table.read(&[column], gaps, "")
    }

    #[test]
    fn columns_by_name_and_number() {
        let text = "\n# made by hand\n\n displacement (mm) ;\"Force\"; note\n1;2D1;a\n# between\n 3 ;4;b\n";
        for name in ["force", "FORCE", " Force ", "Force (N)", "2"] {
            let rows = column(text, name, Gaps::Refused).expect("numbers");
            assert_eq!(rows.columns, [[20.0, 4.0]]);
            assert_eq!(
                (rows.place(0), rows.place(1)),
                ("loop.csv:5".to_string(), "loop.csv:7".to_string())
            );
        }
        let table = table(text).expect("a table");
        assert_eq!(table.find("Displacement", "").expect("found"), 0);
        assert_eq!((table.unit(0), table.unit(1)), (Some("mm"), None));
        assert!(!table.has("time").expect("no doubt"));
        let words = ["load", "force"];
        assert_eq!(table.find_by_words("x", &words, "").expect("found"), 1);
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
                "a,force\nb,c\nd,e\n",
                "loop.csv: no row of numbers up to line 3",
            ),
            (
                "a,force\n1,2\n# x\n3\n",
                "loop.csv:4: column force: missing, the line has 1 fields and the table 2",
            ),
            (
                "a,force\n1,2\n1,2,3\n2,2\n",
                "loop.csv:3: column 3: has no name, the line has 3 fields and the table 2",
            ),
            (
                "a,force\n1,2\n\n3,x\n",
                "loop.csv:4: column force: 'x' is not a number",
            ),
            (
                "force,force\n1,2\n",
                "loop.csv:1: column force: 2 columns have this name: force, force",
            ),
            (
                "a,forse\n1,2\n",
                "loop.csv:1: column force: missing in the header, which has a, forse; did you mean 'forse'?; choose by \
                 name or by number, counted from 1: --force NUMBER",
            ),
            (
                "1,2\n3,4\n",
                "loop.csv: column force: the table has no names (2 columns, line 1: 1 | 2), choose by number, counted from 1: \
                 --force NUMBER",
            ),
            (
                "a,force\n1,\"2\n",
                "loop.csv:2: a quotation mark is not closed",
            ),
            (
                "a,force\n1,2\nend,\n3,4\n",
                "loop.csv:3: column force: '' is no number",
            ),
            (
                "a,force\n1,2\n1,NaN\n",
                "loop.csv:3: column force: 'NaN' is no number",
            ),
        ] {
            let error = column(text, "force", Gaps::Refused).err().expect(text);
            assert_eq!(error.to_string(), expected);
        }
    }

    #[test]
    fn gaps_are_counted_and_no_row_is_lost() {
        let rows = column(
            "a,force\n1,2\n1,NaN\n1,\n,\n\n1,3\nend of test,\nx\n",
            "force",
            Gaps::LeftOut,
        )
        .expect("rows");
        assert_eq!(
            (rows.columns.as_slice(), rows.left_out),
            ([vec![2.0, 3.0]].as_slice(), 2)
        );
        assert_eq!(rows.place(1), "loop.csv:7");
        let error = column("a,force\n1,2\nend of test,x\n1,3\n", "force", Gaps::LeftOut)
            .err()
            .expect("two tables");
        assert!(
            error
                .to_string()
                .starts_with("loop.csv:3: 'end of test,x' holds no numbers"),
            "{error}"
        );
        // A lone CR among LF, which once ended the table.
        let rows = column("a,force\n1,2\n1,3\r1,4\n1,5\n", "force", Gaps::Refused).expect("rows");
        assert_eq!(rows.columns, [[2.0, 3.0, 4.0, 5.0]]);
    }

    #[test]
    fn json_is_a_table_too() {
        let text = "{\"x (mm)\": [1, 2, 3], \"Force\": [1, NaN, 3], \"long\": [1, 2, 3, 4]}";
        let rows = column(text, "force", Gaps::LeftOut).expect("rows");
        assert_eq!(
            (rows.columns.as_slice(), rows.left_out),
            ([vec![1.0, 3.0]].as_slice(), 1)
        );
        let error = column(text, "force", Gaps::Refused).err().expect("a gap");
        assert_eq!(
            error.to_string(),
            "loop.csv: element 2: column Force: has no number"
        );
        let error = table(text)
            .expect("a table")
            .read(&[0, 2], Gaps::LeftOut, "")
            .err()
            .expect("lengths");
        assert_eq!(
            error.to_string(),
            "loop.csv: column long: 4 elements, column x (mm) has 3"
        );
    }
}
