//! Static poses: gravity torque and inertia matrix read out at rest.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use super::Dropped;
use super::header::Header;
use super::layout::{Feed, Finder};
use super::read::file_name;
use super::source::Source;
use super::table::{self, Format};
use crate::error::Result;
use crate::robot::Robot;

/// Read-outs of the gravity torque and the inertia matrix at `rows` configurations (joint by joint).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StaticPoses {
    /// File name without folder, or where the poses come from.
    pub name: String,
    /// Configurations `q[joint][pose]` [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Gravity torques `g[joint][pose]` [N m, N].
    pub g: Vec<Vec<f64>>,
    /// Lower triangle of the inertia matrix by rows: `m[i * (i + 1) / 2 + j][pose]`, `j <= i`
    /// [kg m², kg m, kg].
    pub m: Vec<Vec<f64>>,
    /// Rows left out while reading, by reason.
    pub dropped: BTreeMap<String, Dropped>,
}

impl StaticPoses {
    /// Reads `q1..qn, g1..gn, m11,m21,m22,m31,..,mnn` from a CSV or `.csv.gz` file. A joint's name may stand
    /// for its number in `q` and `g`; other columns are passed over.
    ///
    /// # Errors
    /// When the file is not such a table; with file, line, column and remedy.
    pub fn open(path: impl AsRef<Path>, robot: &Robot) -> Result<Self> {
        let path = path.as_ref();
        let poses = Source::open(path).and_then(|source| Self::from_source(source, robot));
        poses.map(|poses| Self { name: file_name(path), ..poses }).map_err(|e| e.in_file(path))
    }

    /// As [`StaticPoses::open`], from bytes that are at hand already (plain or gzip).
    ///
    /// # Errors
    /// When the bytes are not such a table; with line, column and remedy.
    pub fn from_reader(bytes: impl Read, name: &str, robot: &Robot) -> Result<Self> {
        let poses = Source::new(Box::new(bytes)).and_then(|source| Self::from_source(source, robot));
        poses.map(|poses| Self { name: name.to_owned(), ..poses }).map_err(|e| e.in_file(name))
    }

    fn from_source(mut source: Source<'_>, robot: &Robot) -> Result<Self> {
        let format = Format::default();
        let mut line = Vec::new();
        let header = Header::read(&mut source, &format, true, &mut line)?;
        let mut finder = Finder::new(&header, robot);
        let q = finder.standard("q", true)?.0.unwrap_or_default();
        let g = finder.standard("g", true)?.0.unwrap_or_default();
        let mut m = Vec::with_capacity(robot.dof() * (robot.dof() + 1) / 2);
        for (i, j) in (1..=robot.dof()).flat_map(|i| (1..=i).map(move |j| (i, j))) {
            let name = format!("m{i}{j}");
            let field = header.find(&name).ok_or_else(|| header.missing(&name))?;
            m.push(finder.want(field, true)?);
        }
        let mut table = table::read(&mut source, &format, &header, &finder.wanted, &mut line)?;
        let mut take = |feeds: Vec<Feed>| feeds.iter().map(|f| f.take(&mut table)).collect();
        let (q, g) = (take(q), take(g));
        let m = m.into_iter().map(|column| std::mem::take(&mut table.columns[column])).collect();
        Ok(Self { name: String::new(), q, g, m, dropped: table.dropped })
    }

    /// Number of poses.
    pub fn rows(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }
}
