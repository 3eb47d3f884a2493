//! The rows of a table of numbers, parsed straight into columns.

use std::collections::BTreeMap;

use super::Dropped;
use super::header::Header;
use super::number::{Reason, number};
use super::source::Source;
use crate::error::{Error, Part, Result};
use crate::text::names::shorten;

/// How fields are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    /// Between two fields; a blank stands for any run of blanks and tabs.
    pub delimiter: u8,
    /// Whether `0,5` is a half.
    pub decimal_comma: bool,
}

impl Default for Format {
    fn default() -> Self {
        Self { delimiter: b',', decimal_comma: false }
    }
}

/// A column to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wanted {
    /// Its index in the file, from 0.
    pub field: usize,
    /// Whether a row without a number here is useless. A column that is only nice to have is itself
    /// left out when most of its rows hold no number.
    pub needed: bool,
}

/// Numbers of the wanted columns, in the order they were wanted.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// `columns[c][k]`; empty where a column was left out.
    pub columns: Vec<Vec<f64>>,
    /// Which row of the file (from 0, bad rows counted) each row is.
    pub ordinals: Vec<u32>,
    /// Rows left out, by reason.
    pub dropped: BTreeMap<String, Dropped>,
    /// Wanted columns left out, with the reason.
    pub ignored: BTreeMap<usize, String>,
}

/// The first useless row, kept for the message.
#[derive(Debug)]
struct Bad {
    line: usize,
    /// Field index, from 0.
    field: usize,
    reason: Reason,
    text: String,
    fields: usize,
}

/// Rows of a nice-to-have column that hold no number.
#[derive(Debug, Clone, Copy, Default)]
struct Gap {
    rows: usize,
    first_line: usize,
}

/// Reads all rows after the header. `line` holds the first of them where the file has no header.
pub(super) fn read(
    source: &mut Source<'_>,
    format: &Format,
    header: &Header,
    wanted: &[Wanted],
    line: &mut Vec<u8>,
) -> Result<Table> {
    let mut reader = Reader::new(format, header, wanted);
    let mut more = !header.named || source.next_line(line)?;
    while more {
        reader.row(line, source.line_number());
        more = source.next_line(line)?;
    }
    reader.finish()
}

struct Reader<'a> {
    format: &'a Format,
    header: &'a Header,
    wanted: &'a [Wanted],
    /// Which wanted column a field feeds.
    slots: Vec<Option<usize>>,
    /// The row being read.
    row: Vec<f64>,
    gaps: Vec<Gap>,
    first_bad: Option<Bad>,
    total: usize,
    table: Table,
}

impl<'a> Reader<'a> {
    fn new(format: &'a Format, header: &'a Header, wanted: &'a [Wanted]) -> Self {
        let mut slots = vec![None; header.names.len()];
        for (c, column) in wanted.iter().enumerate() {
            slots[column.field] = Some(c);
        }
        let n = wanted.len();
        let table = Table { columns: vec![Vec::new(); n], ..Table::default() };
        let (row, gaps) = (vec![0.0; n], vec![Gap::default(); n]);
        Self { format, header, wanted, slots, row, gaps, first_bad: None, total: 0, table }
    }

    fn row(&mut self, line: &[u8], number: usize) {
        match self.parse(line, number) {
            Ok(()) => {
                for (c, &value) in self.row.iter().enumerate() {
                    self.table.columns[c].push(value);
                    if value.is_nan() {
                        let gap = &mut self.gaps[c];
                        gap.rows += 1;
                        gap.first_line = if gap.rows == 1 { number } else { gap.first_line };
                    }
                }
                self.table.ordinals.push(u32::try_from(self.total).unwrap_or(u32::MAX));
            }
            Err(bad) => {
                count(&mut self.table.dropped, bad.reason.name(), bad.line, bad.field);
                self.first_bad.get_or_insert(bad);
            }
        }
        self.total += 1;
    }

    /// Parses one line into `self.row`; NaN marks a gap in a column that is only nice to have.
    fn parse(&mut self, line: &[u8], line_number: usize) -> Result<(), Bad> {
        let (slots, wanted, row) = (&self.slots, self.wanted, &mut self.row);
        let decimal_comma = self.format.decimal_comma;
        let (mut fields, mut bad) = (0, None);
        split(line, self.format, |text| {
            if let Some(&Some(c)) = slots.get(fields) {
                row[c] = number(text, decimal_comma).unwrap_or_else(|reason| {
                    if wanted[c].needed && bad.is_none() {
                        bad = Some((fields, reason, start_of(text)));
                    }
                    f64::NAN
                });
            }
            fields += 1;
        });
        if fields != slots.len() {
            // The first field that is missing, or the first too many.
            let field = fields.min(slots.len());
            bad = Some((field, Reason::FieldCount, start_of(line)));
        }
        match bad {
            Some((field, reason, text)) => Err(Bad { line: line_number, field, reason, text, fields }),
            None => Ok(()),
        }
    }

    fn finish(mut self) -> Result<Table> {
        if self.total == 0 {
            return Err(self.header.error("there is a header line but no row").help("record some samples"));
        }
        let good = self.table.ordinals.len();
        if let Some(bad) = self.first_bad.as_ref().filter(|_| good * 2 < self.total) {
            return Err(self.mostly_bad(bad, self.total - good));
        }
        self.close_gaps()?;
        for column in &mut self.table.columns {
            column.shrink_to_fit();
        }
        Ok(self.table)
    }

    /// Leaves out columns that are mostly gaps, then rows where any other column has one.
    fn close_gaps(&mut self) -> Result<()> {
        let rows = self.table.ordinals.len();
        let mut keep = vec![true; rows];
        let mut worst: Option<usize> = None;
        for c in (0..self.wanted.len()).filter(|&c| self.gaps[c].rows > 0) {
            let Gap { rows: missing, first_line } = self.gaps[c];
            if missing * 2 > rows {
                self.table.columns[c] = Vec::new();
                let why = format!("no number in {missing} of {rows} rows, first in line {first_line}");
                self.table.ignored.insert(c, why);
                continue;
            }
            let name = format!("no number in `{}`", self.header.names[self.wanted[c].field]);
            let mut new = 0;
            for (kept, value) in keep.iter_mut().zip(&self.table.columns[c]) {
                new += usize::from(*kept && value.is_nan());
                *kept &= !value.is_nan();
            }
            if new > 0 {
                let first_column = self.wanted[c].field + 1;
                self.table.dropped.insert(name, Dropped { rows: new, first_line, first_column });
            }
            worst = worst.filter(|&w| self.gaps[w].rows >= missing).or(Some(c));
        }
        let Some(worst) = worst else { return Ok(()) };
        let good = keep.iter().filter(|kept| **kept).count();
        if good * 2 < self.total {
            return Err(self.too_many_gaps(worst, self.total - good));
        }
        for column in self.table.columns.iter_mut().filter(|column| !column.is_empty()) {
            retain(column, &keep);
        }
        retain(&mut self.table.ordinals, &keep);
        Ok(())
    }

    fn too_many_gaps(&self, column: usize, bad: usize) -> Error {
        let field = self.wanted[column].field;
        Error::new(format!(
            "{bad} of {} rows lack a number, most of them in `{}`",
            self.total,
            shorten(&self.header.names[field])
        ))
        .at(self.gaps[column].first_line, field + 1)
        .help("remove that column, or pass a column map with `other_columns: Ignore`")
    }

    fn mostly_bad(&self, bad: &Bad, count: usize) -> Error {
        let name = shorten(&self.header.names[bad.field.min(self.header.names.len() - 1)]);
        let text = shorten(&bad.text);
        let expected = self.header.names.len();
        let first = match bad.reason {
            Reason::FieldCount => format!("{} fields instead of {expected}", bad.fields),
            Reason::Empty => format!("nothing in `{name}`"),
            Reason::NotANumber => format!("`{text}` in `{name}` is not a number"),
            Reason::NotFinite => format!("`{text}` in `{name}` is not a finite number"),
        };
        let what = format!("{count} of {} rows are of no use; the first: {first}", self.total);
        let error = Error::new(what).at(bad.line, bad.field + 1).help(self.remedy(bad));
        // Every remedy that names a map offers one.
        if self.remedy(bad).contains("column map") { error.of_part(Part::Columns) } else { error }
    }

    fn remedy(&self, bad: &Bad) -> &'static str {
        let expected = self.header.names.len();
        let comma = || number(bad.text.as_bytes(), true).is_ok();
        match bad.reason {
            Reason::FieldCount if bad.text.starts_with('#') => "remove the comment lines",
            Reason::FieldCount
                if self.format.delimiter == b',' && (expected + 1..=2 * expected).contains(&bad.fields) =>
            {
                "if the numbers have decimal commas, save the file with decimal points"
            }
            Reason::FieldCount => "every row needs as many fields as the header has names",
            Reason::NotANumber if comma() => {
                "save it with decimal points, or give a column map with `decimal_comma: true`"
            }
            _ => "record the missing numbers, remove the column, or map another one with a column map",
        }
    }
}

/// Enough of a text to recognise it in a message.
fn start_of(text: &[u8]) -> String {
    String::from_utf8_lossy(&text[..text.len().min(80)]).trim().to_owned()
}

fn count(dropped: &mut BTreeMap<String, Dropped>, reason: &str, line: usize, field: usize) {
    match dropped.get_mut(reason) {
        Some(known) => known.rows += 1,
        None => {
            let first = Dropped { rows: 1, first_line: line, first_column: field + 1 };
            dropped.insert(reason.to_owned(), first);
        }
    }
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| keep.next().copied().unwrap_or(true));
}

/// Calls `each` with every field of a line, quotes removed, blanks around it kept.
pub(super) fn split(line: &[u8], format: &Format, each: impl FnMut(&[u8])) {
    let blanks = format.delimiter == b' ';
    if line.contains(&b'"') {
        return split_quoted(line, format, each);
    }
    if blanks {
        line.split(|b| matches!(b, b' ' | b'\t')).filter(|field| !field.is_empty()).for_each(each);
    } else {
        line.split(|b| *b == format.delimiter).for_each(each);
    }
}

/// Quotes are rare in logs, so they may cost a reader of their own; a quote left open ends with its line.
fn split_quoted(line: &[u8], format: &Format, mut each: impl FnMut(&[u8])) {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(format.delimiter)
        .buffer_capacity(line.len())
        .from_reader(line);
    let mut record = csv::ByteRecord::new();
    // Reading from memory without a fixed width cannot fail; an empty record has no fields to give.
    if reader.read_byte_record(&mut record).is_ok() {
        let blanks = format.delimiter == b' ';
        record.iter().filter(|field| !blanks || !field.is_empty()).for_each(&mut each);
    }
}
