//! The lines of a text file, one after the other, in bounded memory, whatever their ends and their encoding.

use anyhow::{Result, anyhow, bail};
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use encoding_rs_io::DecodeReaderBytesBuilder;
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

/// A longer line is no row of a table (bytes).
pub const LONGEST: usize = 8 << 20;
/// So much is looked at to tell what kind of file it is (bytes).
const START: u64 = 4096;

/// How files begin that hold tables, but are no text.
const OTHER_KINDS: [(&[u8], &str); 8] = [
    (
        b"PK\x03\x04",
        "a ZIP archive (an .xlsx or .ods spreadsheet?): save the sheet as CSV",
    ),
    (
        b"\xd0\xcf\x11\xe0",
        "an old Office file (.xls?): save the sheet as CSV",
    ),
    (
        b"\x89HDF",
        "an HDF5 file (.mat, .h5?): export the columns as CSV",
    ),
    (b"MATLAB 5.0", "a MATLAB file: export the columns as CSV"),
    (b"TDSm", "a TDMS file: export the channels as CSV"),
    (b"\x1f\x8b", "compressed: unpack it first"),
    (b"7z\xbc\xaf", "compressed: unpack it first"),
    (b"%PDF-", "a PDF document"),
];

/// Text as it comes: UTF-8 or Latin-1 bytes (UTF-16 is turned into UTF-8).
pub struct Lines {
    reader: Box<dyn BufRead>,
    line: Vec<u8>,
    /// Number of the line that was read last, from 1.
    number: usize,
    /// A line feed at the next place belongs to the end of the last line.
    half_end: bool,
    /// The encoding, if it had to be translated.
    pub encoding: Option<&'static str>,
}

impl Lines {
    /// Opens a file, or standard input for `-`.
    ///
    /// # Errors
    /// A file that cannot be read, or whose first bytes are those of another kind of file.
    pub fn open(file: &Path) -> Result<Self> {
        let named = |error: std::io::Error| anyhow!("{}: {error}", file.display());
        let mut reader: Box<dyn Read> = if file.as_os_str() == "-" {
            Box::new(std::io::stdin())
        } else {
            Box::new(File::open(file).map_err(named)?)
        };
        let mut start = Vec::new();
        reader
            .by_ref()
            .take(START)
            .read_to_end(&mut start)
            .map_err(named)?;
        for (bytes, words) in OTHER_KINDS {
            if start.starts_with(bytes) {
                bail!("{}: is no table but {words}", file.display());
            }
        }
        let encoding = utf_16(&start);
        if encoding.is_none() && start.contains(&0) {
            bail!("{}: is not a text file", file.display());
        }
        let reader = DecodeReaderBytesBuilder::new()
            .encoding(encoding)
            .strip_bom(true)
            .bom_override(true)
            .build(Cursor::new(start).chain(reader));
        Ok(Self::new(
            BufReader::with_capacity(1 << 16, reader),
            encoding.map(|_| "UTF-16"),
        ))
    }

    /// From a reader of UTF-8 or Latin-1.
    pub fn new(reader: impl BufRead + 'static, encoding: Option<&'static str>) -> Self {
        Lines {
            reader: Box::new(reader),
            line: Vec::new(),
            number: 0,
            half_end: false,
            encoding,
        }
    }

    /// The next line with its number, without its end: LF, CRLF, or a lone CR. None after the last one.
    ///
    /// # Errors
    /// What cannot be read, is no text, or has no end.
    pub fn next(&mut self) -> Result<Option<(usize, &[u8])>> {
        self.line.clear();
        let mut any = false;
        loop {
            let number = self.number + 1;
            let buffer = self
                .reader
                .fill_buf()
                .map_err(|error| anyhow!("{number}: {error}"))?;
            if buffer.is_empty() {
                if !any {
                    return Ok(None);
                }
                break;
            }
            if std::mem::take(&mut self.half_end) && buffer[0] == b'\n' {
                self.reader.consume(1);
                continue;
            }
            any = true;
            let end = memchr::memchr2(b'\n', b'\r', buffer);
            let part = &buffer[..end.unwrap_or(buffer.len())];
            if memchr::memchr(0, part).is_some() {
                bail!("{number}: is not text");
            }
            if self.line.len() + part.len() > LONGEST {
                bail!(
                    "{number}: a line of more than {} MB is no row of a table",
                    LONGEST >> 20
                );
            }
            self.line.extend_from_slice(part);
            let used = part.len() + usize::from(end.is_some());
            self.half_end = end.is_some_and(|end| buffer[end] == b'\r');
            self.reader.consume(used);
            if end.is_some() {
                break;
            }
        }
        self.number += 1;
        Ok(Some((self.number, &self.line)))
    }

    /// Everything that is left, for a reader of another format.
    pub fn into_reader(self) -> Box<dyn BufRead> {
        self.reader
    }

    /// Whether the text begins as JSON does: an object, or an array of what a line of a table does not begin with.
    ///
    /// # Errors
    /// What cannot be read.
    pub fn is_json(&mut self) -> Result<bool> {
        let buffer = self.reader.fill_buf()?;
        let mut bytes = buffer.iter().filter(|byte| !byte.is_ascii_whitespace());
        Ok(match (bytes.next(), bytes.next()) {
            (Some(b'{'), second) => matches!(second, Some(b'"' | b'}')),
            (Some(b'['), Some(second)) => b"[{-\"0123456789".contains(second),
            _ => false,
        })
    }
}

/// UTF-16 by its mark, or by zeros in every other byte.
fn utf_16(start: &[u8]) -> Option<&'static Encoding> {
    match start {
        [0xff, 0xfe, ..] => return Some(UTF_16LE),
        [0xfe, 0xff, ..] => return Some(UTF_16BE),
        _ => {}
    }
    let zeros = |odd: usize| {
        let bytes = start.iter().skip(odd).step_by(2);
        bytes.filter(|byte| **byte == 0).count()
    };
    let (even, odd, pairs) = (zeros(0), zeros(1), start.len() / 2);
    match pairs {
        0 | 1 => None,
        _ if even == 0 && 10 * odd > 9 * pairs => Some(UTF_16LE),
        _ if odd == 0 && 10 * even > 9 * pairs => Some(UTF_16BE),
        _ => None,
    }
}

/// The characters of a line: UTF-8, or else Latin-1 as Windows has it.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8]) -> Vec<(usize, String)> {
        let mut lines = Lines::new(Cursor::new(text.to_vec()), None);
        let mut found = Vec::new();
        while let Some((number, line)) = lines.next().expect("lines") {
            found.push((number, decode(line).into_owned()));
        }
        found
    }

    #[test]
    fn every_end_of_a_line_counts_once() {
        let expected: Vec<(usize, String)> = [(1, "a"), (2, ""), (3, "b"), (4, "µ")]
            .map(|(number, text)| (number, text.to_string()))
            .into();
        for text in [
            &b"a\n\nb\n\xb5"[..],
            b"a\r\n\r\nb\r\n\xb5\r\n",
            b"a\r\rb\r\xb5\r",
        ] {
            assert_eq!(all(text), expected);
        }
        // A lone CR among LF.
        assert_eq!(all(b"a\n\rb\r\xc2\xb5\n"), expected);
        assert!(all(b"").is_empty());
    }

    /// Ends that fall between two readings of the buffer.
    #[test]
    fn ends_across_the_buffer() {
        let text = b"ab\r\ncd\r\nef";
        for size in 1..8 {
            let reader = BufReader::with_capacity(size, Cursor::new(text.to_vec()));
            let mut lines = Lines::new(reader, None);
            for expected in ["ab", "cd", "ef"] {
                let (_, line) = lines.next().expect("a line").expect("not the end");
                assert_eq!(decode(line), expected);
            }
            assert!(lines.next().expect("the end").is_none());
        }
    }

    #[test]
    fn utf_16_without_a_mark() {
        let text: Vec<u8> = "x,y\n1,2\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        assert_eq!(utf_16(&text), Some(UTF_16LE));
        let text: Vec<u8> = "x,y\n1,2\n"
            .encode_utf16()
            .flat_map(u16::to_be_bytes)
            .collect();
        assert_eq!(utf_16(&text), Some(UTF_16BE));
        assert_eq!(utf_16(b"x,y\n1,2\n"), None);
        assert_eq!(utf_16(&[0; 64]), None);
    }
}
