//! Named, bounded parameters. Nothing here knows robots.

use serde::{Deserialize, Serialize};

/// One unknown of a problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name, unique in its space.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Smallest value; may be `-inf`.
    pub lower: f64,
    /// Largest value; may be `inf`.
    pub upper: f64,
}

impl Parameter {
    /// A parameter without bounds.
    pub fn free(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), lower: f64::NEG_INFINITY, upper: f64::INFINITY }
    }

    /// The same parameter with bounds.
    #[must_use]
    pub fn within(self, lower: f64, upper: f64) -> Self {
        Self { lower, upper, ..self }
    }
}

/// Unknowns in order, in groups that move together (all parameters of a link, say).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Space {
    /// The unknowns.
    pub parameters: Vec<Parameter>,
    /// Consecutive groups: name and number of members; they cover all parameters.
    pub groups: Vec<(String, usize)>,
}

impl Space {
    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// Appends a group.
    pub fn push_group(&mut self, name: impl Into<String>, members: impl IntoIterator<Item = Parameter>) {
        let before = self.parameters.len();
        self.parameters.extend(members);
        self.groups.push((name.into(), self.parameters.len() - before));
    }

    /// Index range of every group.
    pub fn ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut next = 0;
        self.groups
            .iter()
            .map(|(_, members)| {
                let range = next..next + members;
                next = range.end;
                range
            })
            .collect()
    }

    /// Index of a parameter by name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }
}
