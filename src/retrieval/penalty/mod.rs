//! Engines that search: Algorithm 1 of Gaz et al. 2019 as printed (`penalty_paper`) and as it works better
//! ([`PenaltyEngine`]).

mod anneal;
mod eigenvalue;
mod engine;
mod function;
mod runs;
#[cfg(test)]
pub(crate) mod testing;
mod walk;

pub use engine::PenaltyEngine;
pub use function::PenaltyForm;
