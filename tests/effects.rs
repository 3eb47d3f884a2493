//! Effects: known truth comes back from runs that share no code with the columns.

mod common;

#[path = "effects/settled.rs"]
mod settled;
