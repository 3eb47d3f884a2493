//! How the measure of a violation decides where Algorithm 1 of Gaz et al. 2019 ends: the table over random
//! starts behind the sentence that a constant penalty gets the search stuck.
//!
//! `cargo run --release --example penalty_forms`

#[path = "../tests/common/panda_problem.rs"]
mod panda_problem;

use std::ops::ControlFlow;

use lacuna::Result;
use lacuna::retrieval::penalty::{PaperEngine, PenaltyTable};
use lacuna::retrieval::polish::Polish;

fn main() -> Result<()> {
    let problem = panda_problem::panda_two_step(1);
    for polish in [Polish::None, Polish::NelderMead, Polish::InteriorPoint] {
        let engine = PaperEngine { runs: 10, stages: 5, evaluations: 3000, polish, ..PaperEngine::default() };
        println!("The Panda's two-step problem, 10 starts, 5 stages, polish: {polish:?}");
        println!("{}", PenaltyTable::new(&engine, &problem, &|_| ControlFlow::Continue(()))?);
    }
    Ok(())
}
