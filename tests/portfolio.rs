//! The engines know no robots: the example that follows a market index, against its certified optimum.

#[allow(dead_code)] // its `main` is not called here
#[path = "../examples/portfolio.rs"]
mod portfolio;

use std::ops::ControlFlow;

use lacuna::form::{Affine, Form};
use lacuna::retrieval::penalty::{PaperEngine, PenaltyEngine};
use lacuna::retrieval::{Audit, LmiEngine, Problem, RetrievalEngine, Step, audit};
use portfolio::{CASH, SMALL, problem};

fn solve(engine: &dyn RetrievalEngine, problem: &Problem) -> Audit {
    let on = |_: &Step| ControlFlow::Continue(());
    audit(problem, &engine.retrieve(problem, &on).expect("the engine runs").z)
}

/// The if-else rule holds where either of its halves does, and each half is convex: the better of the two
/// certified optima is the optimum of the whole.
fn optimum() -> f64 {
    let little = SMALL.iter().fold(Affine::constant(0.1), |sum, &i| sum.plus(-1.0, &Affine::variable(i)));
    let cash = Affine::variable(CASH).plus(-0.08, &Affine::constant(1.0));
    let half = |row: Affine| {
        let mut problem = problem();
        problem.forms.pop();
        problem.forms.push(Form::affine("half of the rule", "share", 0.1, row));
        // The semidefinite engine reads bounds from forms.
        for (i, share) in problem.chart.space().parameters.clone().iter().enumerate() {
            let above = Affine::variable(i).plus(-share.lower, &Affine::constant(1.0));
            problem.forms.push(Form::affine(share.name.clone(), "share", 1.0, above));
        }
        solve(&LmiEngine::default(), &problem).objective
    };
    let (few, safe) = (half(little), half(cash));
    println!("few small ones {few:.6e}, enough cash {safe:.6e}");
    assert!((few - safe).abs() > 0.01 * few.min(safe), "the rule would decide nothing");
    few.min(safe)
}

#[test]
fn the_index_is_followed_as_closely_as_the_rules_allow() {
    let (problem, optimum) = (problem(), optimum());
    let engines: [&dyn RetrievalEngine; 2] =
        [&PenaltyEngine::default(), &PaperEngine { runs: 4, evaluations: 2000, ..PaperEngine::default() }];
    for engine in engines {
        let found = solve(engine, &problem);
        println!("{}: {:.6e}, violation {:.0e}", engine.name(), found.objective, found.violation);
        assert!(found.feasible, "{}: {}", engine.name(), found.violation);
        assert!(found.objective >= optimum * (1.0 - 1e-6), "{}: below the optimum", engine.name());
        assert!(found.objective <= optimum * 1.001, "{}: {:e}", engine.name(), found.objective);
    }
}
