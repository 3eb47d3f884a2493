//! The solvers behind the engine `nlopt`: those of Steven Johnson's NLopt, as a yardstick for ours.
//!
//! Without the feature `bundled` there is nothing here, so that a workspace builds where CMake is missing. With it,
//! NLopt is built and linked, parts of which are under the LGPL.

#[cfg(feature = "bundled")]
mod solve;

/// Makes the engine `nlopt` available in this process, where this crate was built with `bundled`.
pub fn install() {
    #[cfg(feature = "bundled")]
    lacuna_retrieval::nlopt::provide(solve::retrieve);
}
