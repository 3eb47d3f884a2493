//! Lines of a text file, plain or gzip, with bounds that hostile files cannot break.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;
use std::rc::Rc;

use flate2::bufread::MultiGzDecoder;

use crate::error::{Error, Result};

/// Longest line accepted [bytes]: room for any real log, small enough to refuse a file without line ends.
const LONGEST_LINE: u64 = 1 << 20;
/// Most bytes that a gzip file may unpack to.
const LARGEST_UNPACKED: u64 = 4 << 30;
/// Numbers pack to a half or a third; a file that unpacks to more than this ratio ...
const LARGEST_RATIO: u64 = 200;
/// ... and to more than this many bytes is a gzip bomb.
const RATIO_COUNTS_FROM: u64 = 64 << 20;

/// First bytes of files that are often mistaken for CSV.
const FOREIGN: [(&[u8], &str); 9] = [
    (b"PK\x03\x04", "a zip archive or Excel workbook"),
    (b"\xD0\xCF\x11\xE0", "an old Excel workbook"),
    (b"PAR1", "a Parquet file"),
    (b"\x89HDF", "an HDF5 or new MATLAB file"),
    (b"MATLAB", "a MATLAB file"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"#ROSBAG", "a ROS bag"),
    (b"\x28\xB5\x2F\xFD", "a Zstandard archive"),
    (b"BZh", "a bzip2 archive"),
];

/// A text file, line by line.
pub(super) struct Source<'a> {
    reader: Box<dyn BufRead + 'a>,
    /// Compressed bytes consumed so far, for gzip.
    packed: Option<Rc<Cell<u64>>>,
    unpacked: u64,
    line: usize,
}

impl<'a> Source<'a> {
    /// Opens a file. Errors carry no file name; the caller adds it.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let unreadable = |e: io::Error| {
            Error::new(format!("cannot read the file: {e}")).help("check the path and its permissions")
        };
        let file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(Error::new("this is a folder, not a file").help("name the CSV file in it"));
        }
        Self::new(Box::new(file))
    }

    /// Reads from `bytes`, plain text or gzip (known by its magic number, not by its name).
    pub(super) fn new(bytes: Box<dyn Read + 'a>) -> Result<Self> {
        let (head, bytes) = peek(bytes)?;
        if !head.starts_with(&[0x1F, 0x8B]) {
            return Self::of_text(bytes, None);
        }
        let packed = Rc::new(Cell::new(0));
        let counted = Counted { bytes, count: Rc::clone(&packed) };
        let unzipped = MultiGzDecoder::new(BufReader::with_capacity(1 << 16, counted));
        Self::of_text(Box::new(unzipped), Some(packed))
    }

    fn of_text(bytes: Box<dyn Read + 'a>, packed: Option<Rc<Cell<u64>>>) -> Result<Self> {
        let (head, mut bytes) = peek(bytes)?;
        if head.starts_with(&[0xFF, 0xFE]) || head.starts_with(&[0xFE, 0xFF]) {
            return Err(Error::new("the file is UTF-16 text").at(1, 1).help("save it as UTF-8"));
        }
        if let Some((_, what)) = FOREIGN.iter().find(|(magic, _)| head.starts_with(magic)) {
            return Err(Error::new(format!("this is {what}, not a CSV file"))
                .at(1, 1)
                .help("export the table as CSV (plain or .csv.gz)"));
        }
        if head.starts_with(b"\xEF\xBB\xBF") {
            bytes.read_exact(&mut [0; 3]).map_err(|e| broken(&e, 1))?;
        }
        let reader = Box::new(BufReader::with_capacity(1 << 16, bytes));
        Ok(Self { reader, packed, unpacked: 0, line: 0 })
    }

    /// Reads the next line that is not blank into `line`, without its end; `false` at the end of the file.
    pub(super) fn next_line(&mut self, line: &mut Vec<u8>) -> Result<bool> {
        loop {
            line.clear();
            let mut bounded = self.reader.by_ref().take(LONGEST_LINE + 1);
            let read = bounded.read_until(b'\n', line).map_err(|e| broken(&e, self.line + 1))? as u64;
            if read == 0 {
                return Ok(false);
            }
            self.line += 1;
            self.unpacked += read;
            self.check_bounds(read)?;
            while let Some(b'\n' | b'\r') = line.last() {
                line.pop();
            }
            if !line.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Number of the line read last, from 1.
    pub(super) fn line_number(&self) -> usize {
        self.line
    }

    fn check_bounds(&self, read: u64) -> Result<()> {
        if read > LONGEST_LINE {
            return Err(Error::new(format!("the line is longer than {LONGEST_LINE} bytes"))
                .at(self.line, 1)
                .help("write one sample per line, ended by a line feed"));
        }
        let Some(packed) = &self.packed else { return Ok(()) };
        let bomb = self.unpacked > RATIO_COUNTS_FROM && self.unpacked / LARGEST_RATIO > packed.get();
        if bomb || self.unpacked > LARGEST_UNPACKED {
            return Err(Error::new(format!(
                "the gzip file unpacks to more than {} MiB from {} KiB: refused as a gzip bomb",
                self.unpacked >> 20,
                packed.get() >> 10
            ))
            .at(self.line, 1)
            .help("unpack it yourself and pass the plain CSV if you trust it"));
        }
        Ok(())
    }
}

/// The first bytes (up to eight), and all bytes again.
fn peek<'a>(mut bytes: Box<dyn Read + 'a>) -> Result<(Vec<u8>, Box<dyn Read + 'a>)> {
    let mut head = Vec::with_capacity(8);
    bytes.by_ref().take(8).read_to_end(&mut head).map_err(|e| broken(&e, 1))?;
    Ok((head.clone(), Box::new(Cursor::new(head).chain(bytes))))
}

/// The decoder's trouble in words, so that a cut-off file is told from a damaged one.
fn broken(error: &io::Error, line: usize) -> Error {
    let (what, help) = match error.kind() {
        io::ErrorKind::UnexpectedEof => {
            ("the gzip file is cut off".to_owned(), "copy or record it again, completely")
        }
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
            (format!("the gzip file is damaged: {error}"), "copy or record it again")
        }
        _ => (format!("cannot read on: {error}"), "check the file and its medium"),
    };
    Error::new(what).at(line, 1).help(help)
}

/// Counts the bytes that pass through.
struct Counted<R> {
    bytes: R,
    count: Rc<Cell<u64>>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.bytes.read(buffer)?;
        self.count.set(self.count.get() + read as u64);
        Ok(read)
    }
}
