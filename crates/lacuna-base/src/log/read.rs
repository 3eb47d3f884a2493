//! From an open file to a [`Log`].

use std::io::Read;
use std::path::Path;

use super::columns::ColumnMap;
use super::header::Header;
use super::layout::{self, Clock, Feed, Layout};
use super::source::Source;
use super::table::{self, Format, Table};
use super::{Log, Needs};
use crate::error::{Error, Result};
use crate::robot::Robot;

pub(super) fn open(path: &Path, robot: &Robot, columns: Option<&ColumnMap>, needs: Needs) -> Result<Log> {
    let log = Source::open(path).and_then(|source| from_source(source, robot, columns, needs));
    log.map(|log| Log { name: file_name(path), ..log }).map_err(|e| e.in_file(path))
}

pub(super) fn read(
    bytes: Box<dyn Read + '_>,
    name: &str,
    robot: &Robot,
    columns: Option<&ColumnMap>,
    needs: Needs,
) -> Result<Log> {
    let log = from_source(Source::new(bytes)?, robot, columns, needs)?;
    Ok(Log { name: name.to_owned(), ..log })
}

/// The part of a path that names the file.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn from_source(
    mut source: Source<'_>,
    robot: &Robot,
    columns: Option<&ColumnMap>,
    needs: Needs,
) -> Result<Log> {
    let standard = ColumnMap::default();
    let map = columns.unwrap_or(&standard);
    // The map's reader lets only ASCII pass; a map built by hand may hold anything.
    let delimiter = u8::try_from(map.delimiter).ok().filter(u8::is_ascii);
    let delimiter = delimiter.ok_or_else(|| Error::new("the delimiter of a column map must be ASCII"))?;
    let format = Format { delimiter, decimal_comma: map.decimal_comma };
    let mut line = Vec::new();
    let header = Header::read(&mut source, &format, map.header, &mut line)?;
    let layout = layout::of_log(&header, robot, map, needs)?;
    let table = table::read(&mut source, &format, &header, &layout.wanted, &mut line)?;
    Ok(assemble(&header, layout, table))
}

fn assemble(header: &Header, layout: Layout, mut table: Table) -> Log {
    let mut take = |feeds: &[Feed]| feeds.iter().map(|f| f.take(&mut table)).collect::<Vec<_>>();
    let q = take(&layout.q);
    let dq = layout.dq.as_deref().map(&mut take);
    let ddq = layout.ddq.as_deref().map(&mut take);
    let tau = layout.tau.as_deref().unwrap_or_default();
    // Currents are still to become channels, so the torques are made from copies.
    let tau = if layout.tau_from_current { tau.iter().map(|f| f.copy(&table)).collect() } else { take(tau) };
    let t = match layout.time {
        Clock::Stamps(feed) => feed.take(&mut table),
        Clock::Rate(hz) => table.ordinals.iter().map(|&k| f64::from(k) / hz).collect(),
        Clock::None => Vec::new(),
    };
    let mut log = Log { t, q, dq, ddq, tau, named_joints: layout.named_joints, ..Log::default() };
    log.ignored = layout.ignored;
    for (name, column) in layout.channels {
        match table.ignored.remove(&column) {
            Some(why) => {
                log.ignored.insert(header.names[layout.wanted[column].field].clone(), why);
            }
            None => {
                log.channels.insert(name, std::mem::take(&mut table.columns[column]));
            }
        }
    }
    log.dropped = table.dropped;
    log
}
