//! Dialects of tables of numbers: the separator of fields, the lines that are remarks, and the decimal mark.

use super::times::date_us;

/// Rows of a table's beginning that are looked at.
const LOOKED_AT: usize = 64;

/// Separators of fields, in the order that decides between equals.
pub(super) const SEPARATORS: [Option<u8>; 4] = [Some(b';'), Some(b'\t'), Some(b','), None];

/// Separator of the fields of a line, and decimal mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dialect {
    /// One of `,`, `;`, tab; none: blanks.
    pub(super) separator: Option<u8>,
    pub(super) decimal_comma: bool,
}

/// Separator and decimal mark of a table, as far as they are known before it is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Writing {
    /// The separator, as in [`Dialect`].
    pub(super) separator: Option<Option<u8>>,
    pub(super) decimal_comma: Option<bool>,
}

impl Default for Dialect {
    fn default() -> Self {
        Self {
            separator: Some(b','),
            decimal_comma: false,
        }
    }
}

impl Dialect {
    /// The dialect in which most fields behind the first line are values, and all lines have as many. A comma
    /// may be a decimal mark, and blanks may stand around any separator.
    pub(super) fn guess(start: &str, known: Writing) -> Self {
        let lines: Vec<&str> = whole_lines(start)
            .filter(|line| !is_remark(line))
            .take(LOOKED_AT)
            .collect();
        let mut best = (0.0, Self::default());
        let stated = known.separator.as_ref().map(std::slice::from_ref);
        best.1.separator = known.separator.unwrap_or(best.1.separator);
        for &separator in stated.unwrap_or(&SEPARATORS) {
            let dialect = Self {
                separator,
                decimal_comma: false,
            };
            let score = dialect.score(&lines);
            if score > best.0 {
                best = (score, dialect);
            }
        }
        let mut dialect = best.1;
        if let Some(stated) = known.decimal_comma {
            dialect.decimal_comma = stated;
        } else if dialect.separator != Some(b',') {
            let mut fields = Fields::new(dialect);
            let rows = lines.get(1..).filter(|rows| !rows.is_empty());
            dialect.decimal_comma = rows.unwrap_or(&lines).iter().any(|line| {
                let row = fields.split(line);
                row.iter().any(|f| f.contains(',') && is_value(f))
            });
        }
        dialect
    }

    /// The share of values among the fields behind the first line, in lines of equal width; 0 where there is one
    /// field.
    fn score(self, lines: &[&str]) -> f64 {
        let mut fields = Fields::new(self);
        let Some(first) = lines.first() else {
            return 0.0;
        };
        let width = fields.split(first).count();
        if width < 2 {
            return 0.0;
        }
        let rows = lines.get(1..).filter(|rows| !rows.is_empty());
        let (mut values, mut total) = (0, 0);
        for line in rows.unwrap_or(lines) {
            let row = fields.split(line);
            total += row.count();
            // A heading that ends with a separator has one field more.
            if row.has_width(width) || row.count() + 1 == width {
                values += row.iter().filter(|f| is_value(f)).count();
            }
        }
        // A heading alone has the separator that cuts it.
        let least = 0.01;
        (values as f64 / total.max(1) as f64).max(least)
    }
}

/// Lines of a text's beginning that are surely whole; the only line, where the text has one.
fn whole_lines(start: &str) -> impl Iterator<Item = &str> {
    let end = start.rfind('\n').map_or(start.len(), |end| end + 1);
    start.get(..end).unwrap_or_default().lines()
}

/// Returns true if a line holds neither names nor values.
pub(super) fn is_remark(line: impl AsRef<[u8]>) -> bool {
    let line = line.as_ref().trim_ascii_start();
    let marks: [&[u8]; 3] = [b"#", b"% ", b"//"];
    line.is_empty() || marks.iter().any(|mark| line.starts_with(mark))
}

/// Returns true if one of the whole lines of a text's beginning is no remark.
pub(super) fn has_row(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
    let lines = start.split_inclusive(|byte| *byte == b'\n');
    let mut whole = lines.filter(|line| line.ends_with(b"\n"));
    whole.any(|line| !is_remark(line))
}

/// Returns true if a field may be a value: a number, with either decimal mark, a date, or nothing.
pub(super) fn is_value(field: &str) -> bool {
    field.is_empty()
        || field.parse::<f64>().is_ok()
        || field.replacen(',', ".", 1).parse::<f64>().is_ok()
        || date_us(field).is_some()
}

/// Splitter of lines into fields, which reuses its memory for all lines.
#[derive(Debug)]
pub(super) struct Fields {
    dialect: Dialect,
    reader: csv_core::Reader,
    text: Vec<u8>,
    ends: Vec<usize>,
    spans: Vec<(usize, usize)>,
}

/// The fields of a line, without quotes and the spaces around them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<'l> {
    text: &'l str,
    spans: &'l [(usize, usize)],
}

impl Fields {
    pub(super) fn new(dialect: Dialect) -> Self {
        let delimiter = dialect.separator.unwrap_or(b' ');
        Self {
            dialect,
            reader: csv_core::ReaderBuilder::new().delimiter(delimiter).build(),
            text: Vec::new(),
            ends: Vec::new(),
            spans: Vec::new(),
        }
    }

    pub(super) fn split<'l>(&'l mut self, line: &'l str) -> Row<'l> {
        self.spans.clear();
        let text = if line.contains('"') && self.dialect.separator.is_some() {
            self.unquote(line);
            self.point();
            std::str::from_utf8(&self.text).unwrap_or_default()
        } else if self.dialect.decimal_comma {
            self.text.clear();
            self.text.extend_from_slice(line.as_bytes());
            self.point();
            cut(&self.text, self.dialect.separator, &mut self.spans);
            std::str::from_utf8(&self.text).unwrap_or_default()
        } else {
            cut(line.as_bytes(), self.dialect.separator, &mut self.spans);
            line
        };
        Row {
            text,
            spans: &self.spans,
        }
    }

    /// Turns decimal commas into decimal points.
    fn point(&mut self) {
        if self.dialect.decimal_comma {
            let commas = self.text.iter_mut().filter(|byte| **byte == b',');
            commas.for_each(|comma| *comma = b'.');
        }
    }

    /// Splits a line with quotes by a reader that knows them.
    fn unquote(&mut self, line: &str) {
        let separator = self.dialect.separator.unwrap_or(b',');
        // Fields are no longer than their line, and each but the first has a separator before it. Both buffers
        // have one more place, because the reader takes no end where there is none.
        let most = 2 + line.bytes().filter(|b| *b == separator).count();
        self.text.resize(line.len() + 1, 0);
        self.ends.resize(most, 0);
        self.reader.reset();
        let (_, _, written, ended) =
            self.reader
                .read_record(line.as_bytes(), &mut self.text, &mut self.ends);
        // The end of the line is the end of the record.
        let (text, ends) = (&mut self.text[written..], &mut self.ends[ended..]);
        let (_, _, more, last) = self.reader.read_record(&[], text, ends);
        self.text.truncate(written + more);
        let mut begin = 0;
        for end in self.ends.iter().take(ended + last) {
            self.spans.push((begin, *end));
            begin = *end;
        }
    }
}

/// Finds the fields of a line without quotes.
fn cut(line: &[u8], separator: Option<u8>, spans: &mut Vec<(usize, usize)>) {
    let mut begin = 0;
    match separator {
        Some(separator) => {
            for (place, byte) in line.iter().enumerate() {
                if *byte == separator {
                    spans.push((begin, place));
                    begin = place + 1;
                }
            }
            spans.push((begin, line.len()));
        }
        None => {
            for (place, byte) in line.iter().enumerate() {
                if matches!(byte, b' ' | b'\t') {
                    if place > begin {
                        spans.push((begin, place));
                    }
                    begin = place + 1;
                }
            }
            if line.len() > begin {
                spans.push((begin, line.len()));
            }
        }
    }
}

impl<'l> Row<'l> {
    pub(super) const fn count(self) -> usize {
        self.spans.len()
    }

    /// Returns true if the row has so many fields, or one more that is empty: some programs end each line with a
    /// separator.
    pub(super) fn has_width(self, width: usize) -> bool {
        let ends_empty = self.count() == width + 1 && self.get(width).is_empty();
        self.count() == width || (width > 0 && ends_empty)
    }

    /// A field; empty where there is none.
    pub(super) fn get(self, place: usize) -> &'l str {
        let span = self.spans.get(place);
        let field = span.and_then(|(begin, end)| self.text.get(*begin..*end));
        let field = field.unwrap_or_default();
        let is_plain = |byte: Option<&u8>| byte.is_some_and(|b| b.is_ascii_alphanumeric());
        // Most fields are bare numbers.
        if is_plain(field.as_bytes().first()) && is_plain(field.as_bytes().last()) {
            return field;
        }
        let field = field.trim();
        // Quotes behind a space are quotes to people alone.
        let quoted = field.strip_prefix('"').and_then(|f| f.strip_suffix('"'));
        quoted.unwrap_or(field)
    }

    pub(super) fn iter(self) -> impl Iterator<Item = &'l str> {
        (0..self.count()).map(move |place| self.get(place))
    }
}

#[cfg(test)]
#[path = "dialect_tests.rs"]
mod tests;
