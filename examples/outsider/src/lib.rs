//! Plug-ins for lacuna in a crate of their own: copy this folder to begin one.
//!
//! A scenario names plug-ins by the names below, but they are only there if the crate is linked. A program
//! that uses nothing else of it must say so, or the linker leaves it out and the names are unknown:
//!
//! ```
//! use lacuna_outsider as _;
//! ```

mod com_outside_sphere;
mod gas_spring;
mod random_walk;

pub use com_outside_sphere::ComOutsideSphere;
pub use gas_spring::GasSpring;
pub use random_walk::RandomWalk;
