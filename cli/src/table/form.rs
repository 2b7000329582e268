//! The form of a table, told from its first lines: separator, decimal mark, where the numbers begin, names and units.
//!
//! Every pair of separator and decimal mark is tried on the first lines. A pair is worth the numbers it makes of the lines that
//! have as many fields as most have, less the fields that are no numbers; the best one is taken, the more common one of equals.
//! The numbers begin with the first line that has numbers wherever most lines have them. The names are in the line above
//! that (a row of units between them is one), or in the last comment.

use super::MOST_COLUMNS;
use super::lines::decode;
use crate::units;
use std::ops::Range;

/// A line without its end, and its number.
pub type Line = (usize, Vec<u8>);

/// What is between the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// This byte.
    Byte(u8),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Separator {
    /// For messages.
    pub fn name(self) -> String {
        match self {
            Separator::Byte(b'\t') => "tab".to_string(),
            Separator::Byte(b';') => "semicolon".to_string(),
            Separator::Byte(b',') => "comma".to_string(),
            Separator::Byte(byte) => format!("'{}'", char::from(byte)),
            Separator::Blanks => "blanks".to_string(),
        }
    }
}

/// The mark before the decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// No number with decimals was seen yet.
    Unknown,
    Point,
    Comma,
}

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Field {
    Number(f64),
    /// Empty, or a word for a sample that is not there.
    Missing,
    /// Anything else, and what is wrong with it as a number.
    Text(&'static str),
}

/// What programs write where there is no sample.
const MISSING: [&str; 18] = [
    "nan",
    "-nan",
    "na",
    "n/a",
    "#n/a",
    "#na",
    "#ref!",
    "null",
    "none",
    "-",
    "--",
    "---",
    "#num!",
    "#div/0!",
    "#value!",
    "-nan(ind)",
    "1.#qnan",
    "-1.#ind",
];

impl Field {
    /// Reads a field; blanks about it do not count. The first number with decimals settles an unknown mark.
    pub fn read(bytes: &[u8], decimal: &mut Decimal) -> Field {
        let bytes = bytes.trim_ascii();
        if bytes.is_empty() {
            return Field::Missing;
        }
        let mut buffer = [0; 64];
        let numeric = bytes.iter().all(|b| b"0123456789+-.,eEdD".contains(b))
            && bytes.iter().any(u8::is_ascii_digit);
        if !numeric || bytes.len() > buffer.len() {
            return Field::word(bytes);
        }
        let mut mark = None;
        for (to, from) in buffer.iter_mut().zip(bytes) {
            *to = match from {
                b',' | b'.' if mark.is_some() => {
                    return Field::Text("is not a number (thousands are not separated)");
                }
                b',' => {
                    mark = Some(Decimal::Comma);
                    b'.'
                }
                b'.' => {
                    mark = Some(Decimal::Point);
                    b'.'
                }
                b'd' | b'D' => b'e',
                other => *other,
            };
        }
        match (mark, *decimal) {
            (Some(Decimal::Comma), Decimal::Point) => {
                return Field::Text("has a decimal comma where the table has decimal points");
            }
            (Some(Decimal::Point), Decimal::Comma) => {
                return Field::Text("has a decimal point where the table has decimal commas");
            }
            // A comma that ends a field is no decimal mark.
            (Some(Decimal::Comma), _) if bytes.ends_with(b",") => {
                return Field::Text("is not a number");
            }
            (Some(mark), Decimal::Unknown) => *decimal = mark,
            _ => {}
        }
        let text = std::str::from_utf8(&buffer[..bytes.len()]).unwrap_or_default();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Field::Number(value),
            Ok(_) => Field::Text("is too large"),
            Err(_) => Field::Text("is not a number"),
        }
    }

    fn word(bytes: &[u8]) -> Field {
        let text = decode(bytes);
        let text = text.trim().to_lowercase();
        if text.is_empty() || MISSING.contains(&text.as_str()) {
            return Field::Missing;
        }
        // A minus sign of the typesetter.
        if let Some(digits) = text.strip_prefix('\u{2212}')
            && let Field::Number(value) = Field::read(digits.as_bytes(), &mut Decimal::Unknown)
        {
            return Field::Number(-value);
        }
        match text.trim_start_matches(['+', '-']) {
            "inf" | "infinity" | "1.#inf" => Field::Text("is not finite"),
            _ => Field::Text("is not a number"),
        }
    }

    pub fn is_number(self) -> bool {
        matches!(self, Field::Number(_))
    }

    fn kind(self) -> Kind {
        match self {
            Field::Number(_) => Kind::Number,
            Field::Missing => Kind::Missing,
            Field::Text(_) => Kind::Text,
        }
    }
}

/// A [`Field`] without its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Number,
    Missing,
    Text,
}

/// Cuts lines into fields.
pub struct Splitter {
    separator: Separator,
    quotes: csv_core::Reader,
    /// The fields without their quotation marks, if there are any.
    unquoted: Vec<u8>,
    is_unquoted: bool,
    is_too_wide: bool,
    fields: Vec<Range<usize>>,
}

impl Splitter {
    pub fn new(separator: Separator) -> Self {
        let delimiter = match separator {
            Separator::Byte(byte) => byte,
            Separator::Blanks => b' ',
        };
        Splitter {
            separator,
            quotes: csv_core::ReaderBuilder::new().delimiter(delimiter).build(),
            unquoted: Vec::new(),
            is_unquoted: false,
            is_too_wide: false,
            fields: Vec::new(),
        }
    }

    /// Cuts a line; false if it cannot be cut: see [`Splitter::trouble`].
    pub fn split(&mut self, line: &[u8]) -> bool {
        self.is_unquoted = false;
        self.fields.clear();
        self.is_too_wide = match self.separator {
            Separator::Byte(byte) => memchr::memchr_iter(byte, line).count() >= MOST_COLUMNS,
            Separator::Blanks => {
                line.len() > MOST_COLUMNS
                    && line.split(u8::is_ascii_whitespace).count() > 2 * MOST_COLUMNS
            }
        };
        if self.is_too_wide {
            return false;
        }
        match self.separator {
            Separator::Byte(byte) => {
                let mut start = 0;
                for end in memchr::memchr_iter(byte, line) {
                    self.fields.push(start..end);
                    start = end + 1;
                }
                self.fields.push(start..line.len());
            }
            Separator::Blanks => {
                let mut start = None;
                for (at, byte) in line.iter().enumerate() {
                    match (start, byte.is_ascii_whitespace()) {
                        (None, false) => start = Some(at),
                        (Some(from), true) => {
                            self.fields.push(from..at);
                            start = None;
                        }
                        _ => {}
                    }
                }
                self.fields.extend(start.map(|from| from..line.len()));
            }
        }
        let quoted = self
            .fields
            .iter()
            .any(|field| line[field.clone()].trim_ascii().starts_with(b"\""));
        !quoted || self.split_quoted(line)
    }

    fn split_quoted(&mut self, line: &[u8]) -> bool {
        if memchr::memchr_iter(b'"', line).count() % 2 == 1 {
            return false;
        }
        // A quotation mark counts at the start of a field only: the blanks before it go.
        let mut input = Vec::with_capacity(line.len());
        for &byte in line {
            let after_separator = match input.last() {
                None => true,
                Some(&last) => Separator::Byte(last) == self.separator,
            };
            match byte {
                b'\t' if self.separator == Separator::Blanks => input.push(b' '),
                b' ' if after_separator && self.separator != Separator::Blanks => {}
                _ => input.push(byte),
            }
        }
        let mut ends = vec![0; input.len() + 2];
        self.unquoted.resize(input.len() + 1, 0);
        self.quotes.reset();
        let (_, read, written, count) =
            self.quotes
                .read_record(&input, &mut self.unquoted, &mut ends);
        let (_, _, _, last) = self.quotes.read_record(
            &input[read..],
            &mut self.unquoted[written..],
            &mut ends[count..],
        );
        self.fields.clear();
        let mut start = 0;
        for &end in &ends[..count + last] {
            if self.separator != Separator::Blanks || end > start {
                self.fields.push(start..end);
            }
            start = end;
        }
        self.is_unquoted = true;
        true
    }

    /// Why a line could not be cut.
    pub fn trouble(&self) -> String {
        if self.is_too_wide {
            format!("has more than {MOST_COLUMNS} columns")
        } else {
            "a quotation mark is not closed".to_string()
        }
    }

    /// How many fields the line has.
    pub fn len(&self) -> usize {
        self.fields.len()
    }

    /// Field `k` of the line that was cut last.
    pub fn field<'a>(&'a self, line: &'a [u8], k: usize) -> &'a [u8] {
        let range = self.fields[k].clone();
        if self.is_unquoted {
            &self.unquoted[range]
        } else {
            &line[range]
        }
    }

    fn texts(&mut self, line: &[u8]) -> Vec<String> {
        self.split(line);
        (0..self.len()).map(|k| tidy(self.field(line, k))).collect()
    }
}

/// The characters of a field, without blanks and quotation marks about them.
fn tidy(field: &[u8]) -> String {
    decode(field).trim().trim_matches('"').trim().to_string()
}

/// What a spreadsheet writes instead of a number, which is no comment.
const SHEET_ERRORS: [&[u8]; 5] = [b"#N/A", b"#NUM!", b"#DIV/0!", b"#VALUE!", b"#REF!"];

/// Whether a line is a comment; its text.
pub fn comment(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii();
    let first = line.first().filter(|b| b"#%".contains(b))?;
    if SHEET_ERRORS.iter().any(|error| line.starts_with(error)) {
        return None;
    }
    let mut rest = line;
    while rest.first() == Some(first) {
        rest = &rest[1..];
    }
    Some(rest.trim_ascii())
}

/// Whether a line has nothing but blanks.
pub fn is_blank(line: &[u8]) -> bool {
    line.trim_ascii().is_empty()
}

/// A rule between names and numbers.
fn is_rule(line: &[u8]) -> bool {
    line.iter().all(|b| b"-=_+|*;,\t ".contains(b)) && line.iter().any(|b| b"-=_".contains(b))
}

/// The form of a table.
#[derive(Debug)]
pub struct Form {
    pub separator: Separator,
    pub decimal: Decimal,
    /// Fields of a line of numbers; more are empty.
    pub columns: usize,
    /// Whether a column holds numbers.
    pub numeric: Vec<bool>,
    /// One per column, empty where there is none; no names at all: no entries.
    pub names: Vec<String>,
    /// As `names`: the row of units.
    pub units: Vec<String>,
    /// Line of the names.
    pub header_line: Option<usize>,
    /// The names were in a comment.
    pub in_comment: bool,
    /// Line of the first row of numbers.
    pub first_line: usize,
    /// The line that should hold the names, and how many it has, if not as many as columns.
    pub misfit: Option<(usize, usize)>,
    /// The separator was told by a line `sep=`.
    pub told: bool,
    /// The first row of numbers, for messages.
    pub sample: Vec<String>,
}

/// `sep=;`, which Excel writes and reads.
fn told_separator(line: &[u8]) -> Option<Separator> {
    let line = decode(line);
    let text = line.trim_matches(['"', ' ']);
    let (key, value) = text.split_at_checked(4)?;
    if !key.eq_ignore_ascii_case("sep=") {
        return None;
    }
    match value.as_bytes() {
        b"\\t" => Some(Separator::Byte(b'\t')),
        [byte] if byte.is_ascii() => Some(Separator::Byte(*byte)),
        [] => Some(Separator::Blanks),
        _ => None,
    }
}

/// One way to read the first lines.
struct Trial {
    separator: Separator,
    decimal: Decimal,
    /// Fields of most lines with numbers.
    columns: usize,
    worth: f64,
    /// The first line that cannot be cut into fields, and why.
    uncut: Option<(usize, String)>,
}

/// What a field counts that is no number, in numbers.
const TEXT: f64 = 0.9;

impl Trial {
    fn new(lines: &[&Line], separator: Separator, decimal: Decimal) -> Self {
        let mut splitter = Splitter::new(separator);
        // Lines of so many fields, and what they are worth.
        let mut worths: Vec<(usize, f64)> = Vec::new();
        let mut mark = decimal;
        let mut uncut = None;
        for (number, line) in lines {
            if !splitter.split(line) {
                uncut.get_or_insert_with(|| (*number, splitter.trouble()));
                continue;
            }
            let (mut numbers, mut texts) = (0.0, 0.0);
            for k in 0..splitter.len() {
                match Field::read(splitter.field(line, k), &mut mark) {
                    Field::Number(_) => numbers += 1.0,
                    Field::Text(_) => texts += 1.0,
                    Field::Missing => {}
                }
            }
            if numbers == 0.0 {
                continue;
            }
            let worth = numbers - TEXT * texts;
            match worths
                .iter_mut()
                .find(|(count, _)| *count == splitter.len())
            {
                Some((_, sum)) => *sum += worth,
                None => worths.push((splitter.len(), worth)),
            }
        }
        let best = worths.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let (columns, worth) = best.unwrap_or((0, f64::NEG_INFINITY));
        Trial {
            separator,
            decimal: mark,
            columns,
            worth,
            uncut,
        }
    }
}

/// What is wrong with the first lines of a file.
pub enum Trouble {
    /// There is no line that counts.
    Empty,
    /// Nothing below the header on this line.
    NoRows(usize),
    /// No line holds numbers; the number of the last line looked at.
    NoNumbers(usize),
    /// This line cannot be cut into fields, and why.
    Uncut(usize, String),
}

impl Form {
    /// Tells the form from the first lines of a file.
    ///
    /// # Errors
    /// No line of numbers.
    pub fn new(head: &[Line]) -> Result<Self, Trouble> {
        let filled = head.iter().filter(|(_, line)| !is_blank(line));
        let (comments, mut lines): (Vec<&Line>, Vec<&Line>) =
            filled.partition(|(_, line)| comment(line).is_some());
        let told = lines.first().and_then(|(_, line)| told_separator(line));
        if told.is_some() {
            lines.remove(0);
        }
        let (first, last) = match lines.as_slice() {
            [] => return Err(Trouble::Empty),
            [first, ..] => (first.0, lines[lines.len() - 1].0),
        };
        let trial = best_trial(&lines, told);
        let (separator, mut decimal) = (trial.separator, trial.decimal);
        if trial.columns == 0 {
            return Err(match trial.uncut {
                Some((line, words)) => Trouble::Uncut(line, words),
                None if first == last => Trouble::NoRows(first),
                None => Trouble::NoNumbers(last),
            });
        }

        // Which columns hold numbers, by the lines that have some. What a field holds takes one byte here.
        let mut splitter = Splitter::new(separator);
        let mut balance = vec![0i64; trial.columns];
        let mut filled = vec![false; trial.columns];
        let mut kinds: Vec<Option<Vec<Kind>>> = Vec::new();
        for (_, line) in &lines {
            if !splitter.split(line) {
                kinds.push(None);
                continue;
            }
            let fits = splitter.len() == trial.columns;
            let fields = if fits { 0..trial.columns } else { 0..0 };
            let kind: Vec<Kind> = fields
                .map(|k| Field::read(splitter.field(line, k), &mut decimal).kind())
                .collect();
            if kind.contains(&Kind::Number) {
                for (k, kind) in kind.iter().enumerate() {
                    balance[k] += if *kind == Kind::Text { -1 } else { 1 };
                    filled[k] |= *kind != Kind::Missing;
                }
            }
            kinds.push(Some(kind));
        }
        let numeric: Vec<bool> = balance.iter().map(|b| *b >= 0).collect();
        let is_row = |kind: &Option<Vec<Kind>>| {
            let kind = kind.as_deref().unwrap_or_default();
            let mut numbers = kind.iter().zip(&numeric).filter(|(_, numeric)| **numeric);
            numbers.clone().all(|(kind, _)| *kind != Kind::Text)
                && numbers.any(|(kind, _)| *kind == Kind::Number)
        };
        let Some(mut start) = kinds.iter().position(is_row) else {
            return Err(Trouble::NoNumbers(last));
        };
        // What is at the end of every line and never filled is no column, unless it has a name.
        let fewest = filled
            .iter()
            .rposition(|filled| *filled)
            .map_or(1, |k| k + 1);

        let mut form = Form {
            separator,
            decimal,
            columns: trial.columns,
            numeric: numeric.clone(),
            names: Vec::new(),
            units: Vec::new(),
            header_line: None,
            in_comment: false,
            first_line: 0,
            misfit: None,
            told: told.is_some(),
            sample: Vec::new(),
        };
        let widths = [fewest, trial.columns];
        // Lines directly above that have some numbers, or cannot be cut, are rows with a fault, if the names are above them.
        let is_faulty = |kind: &&Option<Vec<Kind>>| {
            kind.as_ref()
                .is_none_or(|kind| kind.contains(&Kind::Number))
        };
        let faulty = kinds[..start].iter().rev().take_while(is_faulty).count();
        if faulty > 0 && form.take_names(&lines[..start - faulty], widths, &mut splitter, false) {
            start -= faulty;
        } else {
            let _ = form.take_names(&lines[..start], widths, &mut splitter, false);
        }
        form.first_line = lines[start].0;
        if form.names.is_empty() && form.units.is_empty() {
            let above: Vec<Line> = comments
                .iter()
                .filter(|(number, _)| *number < form.first_line)
                .filter_map(|(number, line)| Some((*number, comment(line)?.to_vec())))
                .filter(|(_, line)| !line.is_empty())
                .collect();
            let above: Vec<&Line> = above.iter().collect();
            let misfit = form.misfit;
            form.in_comment = form.take_names(&above, widths, &mut splitter, true);
            form.misfit = misfit;
        }
        form.sample = splitter.texts(&lines[start].1);
        Ok(form)
    }

    /// Takes names and units from the last of these lines; false if there are none.
    fn take_names(
        &mut self,
        above: &[&Line],
        widths: [usize; 2],
        splitter: &mut Splitter,
        is_comment: bool,
    ) -> bool {
        self.misfit = None;
        let mut above = above.iter().rev().filter(|(_, line)| !is_rule(line));
        let Some((number, line)) = above.next() else {
            return false;
        };
        let Some(names) = split_names(line, widths, splitter) else {
            if !is_comment {
                self.misfit = Some((*number, splitter.texts(line).len()));
            }
            return false;
        };
        if names
            .iter()
            .all(|name| name.is_empty() || units::is_unit(name))
        {
            // Units; the names are above them.
            let higher = above.next().and_then(|(number, line)| {
                let names = split_names(line, widths, splitter)?;
                Some((*number, names))
            });
            self.units = names
                .iter()
                .map(|unit| units::bare(unit).to_string())
                .collect();
            if let Some((number, names)) = higher {
                self.header_line = Some(number);
                self.names = names;
            }
            return true;
        }
        self.header_line = Some(*number);
        self.names = names;
        true
    }

    /// Whether this is what any reader of CSV takes: nothing needs to be said about it.
    pub fn is_plain(&self) -> bool {
        self.separator == Separator::Byte(b',')
            && self.decimal != Decimal::Comma
            && !(self.header_line.is_none() || self.in_comment || self.told)
            && self.units.is_empty()
    }

    /// What was told, in one line.
    pub fn words(&self, encoding: Option<&str>) -> String {
        let mut words: Vec<String> = encoding.map(str::to_string).into_iter().collect();
        words.push(match (self.columns, self.told) {
            (1, _) => "one column".to_string(),
            (_, true) => format!("{} (sep=)", self.separator.name()),
            _ => self.separator.name(),
        });
        if self.decimal == Decimal::Comma {
            words.push("decimal comma".to_string());
        }
        words.push(match self.header_line {
            Some(line) if self.in_comment => format!("header in the comment of line {line}"),
            Some(line) => format!("header line {line}"),
            None => "no header".to_string(),
        });
        if !self.units.is_empty() {
            words.push("units row".to_string());
        }
        if self.header_line.is_none() && self.first_line > 1 {
            words.push(format!("numbers from line {}", self.first_line));
        }
        words.join(", ")
    }
}

fn best_trial(lines: &[&Line], told: Option<Separator>) -> Trial {
    let bytes = [b'\t', b';', b','].map(Separator::Byte);
    let separators = match told {
        Some(separator) => vec![separator],
        None => [&bytes[..], &[Separator::Blanks]].concat(),
    };
    let mut best: Option<Trial> = None;
    for decimal in [Decimal::Point, Decimal::Comma] {
        for &separator in &separators {
            let trial = Trial::new(lines, separator, decimal);
            match &mut best {
                Some(best) if trial.worth <= best.worth => {
                    // Where nothing is found, this may be why.
                    if best.uncut.is_none() {
                        best.uncut = trial.uncut;
                    }
                }
                _ => best = Some(trial),
            }
        }
    }
    let mut best = best.expect("there is a separator");
    // Without any decimals either mark may come.
    if best.decimal == Decimal::Point && best.separator != Separator::Byte(b',') {
        let open = Trial::new(lines, best.separator, Decimal::Unknown);
        best.decimal = if open.worth >= best.worth {
            open.decimal
        } else {
            best.decimal
        };
    }
    best
}

/// A line of names or units as so many fields (the fewest and the most); None if it cannot be cut like that. The line may be cut
/// in another way than the numbers.
fn split_names(
    line: &[u8],
    [fewest, most]: [usize; 2],
    splitter: &mut Splitter,
) -> Option<Vec<String>> {
    let fit = |mut fields: Vec<String>| {
        while fields.len() > fewest && fields.last().is_some_and(String::is_empty) {
            fields.pop();
        }
        let is_text =
            |field: &String| !Field::read(field.as_bytes(), &mut Decimal::Unknown).is_number();
        let good = (fewest..=most).contains(&fields.len())
            && fields.iter().all(is_text)
            && fields.iter().any(|field| !field.is_empty());
        good.then(|| {
            fields.resize(most, String::new());
            fields
        })
    };
    if let Some(fields) = fit(splitter.texts(line)) {
        return Some(fields);
    }
    for separator in [b'\t', b';', b','].map(Separator::Byte) {
        if let Some(fields) = fit(Splitter::new(separator).texts(line)) {
            return Some(fields);
        }
    }
    let text = decode(line);
    let wide = text.trim().replace('\t', "  ");
    let wide = wide
        .split("  ")
        .map(str::trim)
        .filter(|name| !name.is_empty());
    if let Some(fields) = fit(wide.map(str::to_string).collect()) {
        return Some(fields);
    }
    // A unit in brackets belongs to the name before it.
    let mut words: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match words.last_mut() {
            Some(last) if word.starts_with(['(', '[', '{', '<']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_string()),
        }
    }
    fit(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(text: &str) -> Form {
        let lines: Vec<Line> = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k + 1, line.as_bytes().to_vec()))
            .collect();
        Form::new(&lines).unwrap_or_else(|_| panic!("no form in {text}"))
    }

    #[test]
    fn separators_and_decimal_marks() {
        use Decimal::{Comma, Point, Unknown};
        let byte = Separator::Byte;
        for (text, separator, decimal, columns) in [
            ("x,y\n1.5,2\n3,4\n", byte(b','), Point, 2),
            ("x;y\n1,5;2\n3;4\n", byte(b';'), Comma, 2),
            ("x;y\n1.5;2\n3;4\n", byte(b';'), Point, 2),
            ("x;y\n1;2\n3;4\n", byte(b';'), Unknown, 2),
            ("x\ty\n1,5\t2\n3\t4\n", byte(b'\t'), Comma, 2),
            ("x y\n1,5 2\n3 4\n", Separator::Blanks, Comma, 2),
            ("x y\n  1.5   2\n 3 \t 4\n", Separator::Blanks, Point, 2),
            ("x, y\n1, 2\n3, 4\n", byte(b','), Point, 2),
            ("x\ty\tz\n1.0\t\t2\n3\t\t4\n", byte(b'\t'), Point, 3),
            (
                "\"x\",\"y\"\n\"1,5\",\"2\"\n\"3\",\"4,25\"\n",
                byte(b','),
                Comma,
                2,
            ),
            (
                "date;x;y\n01.02.2024;1,5;2,5\n01.02.2024;1,5;2,5\n",
                byte(b';'),
                Comma,
                3,
            ),
            ("x|y\nsep\n", byte(b'|'), Unknown, 2),
        ] {
            let text = text.replace("x|y\nsep\n", "sep=|\nx|y\n1|2\n");
            let form = form(&text);
            assert_eq!(
                (form.separator, form.decimal, form.columns),
                (separator, decimal, columns),
                "{text}"
            );
            assert_eq!(form.names.len(), columns, "{text}");
        }
    }

    #[test]
    fn names_and_units() {
        for (text, names, units, header, first) in [
            ("1 2\n3 4\n", &[][..], &[][..], None, 1),
            (
                "Test: 7\nRate;100\n\nx;F\nmm;N\n1;2\n",
                &["x", "F"],
                &["mm", "N"],
                Some(4),
                6,
            ),
            (
                "# test\n% x (mm), F (kN)\n1 2\n3 4\n",
                &["x (mm)", "F (kN)"],
                &[],
                Some(2),
                3,
            ),
            (
                "  x (mm)   F (N)\n 1 2\n",
                &["x (mm)", "F (N)"],
                &[],
                Some(1),
                2,
            ),
            (
                "Disp mm\tLoad N\n-------\t------\n1\t2\n",
                &["Disp mm", "Load N"],
                &[],
                Some(1),
                3,
            ),
            ("x,F\n1,2,\n3,4,\n", &["x", "F", ""], &[], Some(1), 2),
            // A fault in the first row is no header.
            ("x,F\n0,abc\n1,2\n3,4\n", &["x", "F"], &[], Some(1), 2),
            (
                "t,x,F\ns,mm,N\n1,2,3\n",
                &["t", "x", "F"],
                &["s", "mm", "N"],
                Some(1),
                3,
            ),
            ("mm,N\n1,2\n", &[], &["mm", "N"], None, 2),
        ] {
            let form = form(text);
            assert_eq!(form.names, names, "{text}");
            assert_eq!(form.units, units, "{text}");
            assert_eq!(
                (form.header_line, form.first_line),
                (header, first),
                "{text}"
            );
        }
        assert_eq!(form("a,b,c\n1,2\n3,4\n").misfit, Some((1, 3)));
        let form = form("name,x,F,state\nA1,1,2,ok\nA2,1,2,ok\n");
        assert_eq!(form.numeric, [false, true, true, false]);
    }

    #[test]
    fn fields() {
        let read = |text: &str, mut decimal| Field::read(text.as_bytes(), &mut decimal);
        for (text, value) in [
            ("1.5e-3", 1.5e-3),
            (" -2D2 ", -200.0),
            ("+1.", 1.0),
            ("\u{2212}3", -3.0),
        ] {
            assert_eq!(read(text, Decimal::Point), Field::Number(value), "{text}");
        }
        assert_eq!(read("-1,5E+003", Decimal::Comma), Field::Number(-1500.0));
        for text in ["", "NaN", " nan ", "#N/A", "-", "null", "-1.#IND"] {
            assert_eq!(read(text, Decimal::Point), Field::Missing, "{text}");
        }
        for (text, decimal) in [
            ("1,5", Decimal::Point),
            ("1.5", Decimal::Comma),
            ("1.234,5", Decimal::Comma),
            ("1,", Decimal::Comma),
            ("1e999", Decimal::Point),
            ("-inf", Decimal::Point),
            ("0x10", Decimal::Point),
            ("--1", Decimal::Point),
            ("12:00", Decimal::Point),
        ] {
            assert_eq!(read(text, decimal).kind(), Kind::Text, "{text}");
        }
        let mut decimal = Decimal::Unknown;
        assert!(Field::read(b"1", &mut decimal).is_number() && decimal == Decimal::Unknown);
        assert!(Field::read(b"1,5", &mut decimal).is_number() && decimal == Decimal::Comma);
    }

    #[test]
    fn quotation_marks() {
        let mut splitter = Splitter::new(Separator::Byte(b';'));
        assert_eq!(
            splitter.texts(b" a ; \"b;c\" ;\"d\"\"e\""),
            ["a", "b;c", "d\"e"]
        );
        assert_eq!(splitter.texts(b"3.5\" pipe;b"), ["3.5\" pipe", "b"]);
        assert!(!splitter.split(b"a;\"b"));
        let mut splitter = Splitter::new(Separator::Blanks);
        assert_eq!(splitter.texts(b"  \"x (mm)\"\t F"), ["x (mm)", "F"]);
    }
}
