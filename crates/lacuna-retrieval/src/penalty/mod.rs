//! Engines that search: Algorithm 1 of Gaz et al. 2019 as printed ([`PaperEngine`]) and as it works better
//! ([`PenaltyEngine`]).

mod anneal;
mod compare;
mod eigenvalue;
mod engine;
mod function;
mod paper;
pub mod runs;
#[cfg(test)]
pub(crate) mod testing;
mod walk;

pub use compare::{PenaltyRow, PenaltyTable};
pub use engine::PenaltyEngine;
pub use function::PenaltyForm;
pub use paper::PaperEngine;
pub use walk::{Ground, Walk};
