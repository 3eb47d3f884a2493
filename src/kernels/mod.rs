//! Rigid-body kernels.
