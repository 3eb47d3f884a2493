//! Column maps.

/// How foreign columns become ours.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ColumnMap {}
