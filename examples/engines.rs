//! All retrieval engines on the Panda's two-step problem: 70 unknowns, the 41 published coefficients that
//! the paper keeps (seven digits), and its constraints.
//!
//! `cargo run --release --example engines` (with `--features nlopt` for those of NLopt, too)

#[path = "../tests/common/panda_problem.rs"]
mod panda_problem;

use std::ops::ControlFlow;
use std::time::Instant;

use lacuna::Result;
use lacuna::retrieval::nlopt::{NloptAlgorithm, NloptEngine};
use lacuna::retrieval::penalty::{PaperEngine, PenaltyEngine};
use lacuna::retrieval::{LmiEngine, Problem, RetrievalEngine, audit};
use panda_problem::{C5Z_REPOSITORY, panda_two_step_within};

fn engines() -> Vec<Box<dyn RetrievalEngine>> {
    let paper = PaperEngine { runs: 10, ..PaperEngine::default() };
    let simplex = NloptEngine {
        label: Some("nlopt, Sbplx".into()),
        algorithm: NloptAlgorithm::Sbplx,
        ..NloptEngine::default()
    };
    let slsqp = NloptEngine { label: Some("nlopt, SLSQP".into()), ..NloptEngine::default() };
    vec![
        Box::new(PenaltyEngine::default()),
        Box::new(paper),
        Box::new(LmiEngine::default()),
        Box::new(slsqp),
        Box::new(simplex),
    ]
}

fn row(engine: &dyn RetrievalEngine, problem: &Problem) -> Result<()> {
    if engine.available().is_err() {
        println!("{:<14} not part of this build", engine.label());
        return Ok(());
    }
    let start = Instant::now();
    let found = engine.retrieve(problem, &|_| ControlFlow::Continue(()))?;
    let seconds = start.elapsed().as_secs_f64();
    let audit = audit(problem, &found.z);
    println!(
        "{:<14} {:.6e} {:>8.1e} {seconds:>7.2} s  {}",
        engine.label(),
        audit.objective,
        audit.violation,
        found.status
    );
    Ok(())
}

fn main() -> Result<()> {
    for c5z in [C5Z_REPOSITORY, -0.05] {
        println!("c5z >= {c5z}\n{:<14} {:>12} {:>8} {:>9}", "engine", "objective", "violated", "time");
        let problem = panda_two_step_within(1, c5z);
        engines().iter().try_for_each(|engine| row(engine.as_ref(), &problem))?;
    }
    println!("\npenalty_paper, one run, stage by stage\n{:>4} {:>12} {:>9}", "xi", "objective", "violated");
    let problem = panda_two_step_within(1, C5Z_REPOSITORY);
    for stages in 1..=10 {
        let engine = PaperEngine { runs: 1, stages, ..PaperEngine::default() };
        let found = audit(&problem, &engine.retrieve(&problem, &|_| ControlFlow::Continue(()))?.z);
        println!("{:>4} {:>12.4e} {:>9.1e}", 10 * (stages - 1), found.objective, found.violation);
    }
    Ok(())
}
