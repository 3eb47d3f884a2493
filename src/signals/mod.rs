//! From a raw [`crate::log::Log`] to uniformly sampled, filtered motion: the one documented signal step.

/// A motion on a uniform clock, ready for regressors. Joint quantities are stored joint by joint:
/// `q[j][k]` is joint `j` at sample `k`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// Name of the log it came from.
    pub name: String,
    /// Sampling time [s].
    pub dt: f64,
    /// Time of the first sample [s], on the log's own clock.
    pub start: f64,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s].
    pub dq: Vec<Vec<f64>>,
    /// Accelerations [rad/s², m/s²].
    pub ddq: Vec<Vec<f64>>,
    /// Torques [N m, N].
    pub tau: Vec<Vec<f64>>,
    /// Every other column, on the same clock.
    pub channels: std::collections::BTreeMap<String, Vec<f64>>,
}
