//! The library through its public interface: identities, known truth, published numbers, bad input. One binary, for
//! each one more costs a link of everything.

mod common;

#[path = "constraints.rs"]
mod constraints;
#[path = "damaged.rs"]
mod damaged;
#[path = "effect_scripts.rs"]
mod effect_scripts;
#[path = "effects.rs"]
mod effects;
#[path = "portfolio.rs"]
mod example_portfolio;
#[path = "hidden.rs"]
mod hidden;
#[path = "identification.rs"]
mod identification;
#[path = "lmi/main.rs"]
mod lmi;
#[path = "logs.rs"]
mod logs;
#[path = "panda_data.rs"]
mod panda_data;
#[path = "penalty.rs"]
mod penalty;
#[path = "plant.rs"]
mod plant;
#[path = "robots.rs"]
mod robots;
#[path = "robots_bad_input.rs"]
mod robots_bad_input;
#[path = "scripts.rs"]
mod scripts;
#[path = "signals.rs"]
mod signals;
#[path = "two_link.rs"]
mod two_link;
#[path = "ur10e_data.rs"]
mod ur10e_data;
