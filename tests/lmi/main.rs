//! The semidefinite engine, its certificate, intervals and tie-breaks, on problems whose answers are known.

mod panda;

use std::ops::ControlFlow;
use std::time::Instant;

use lacuna::retrieval::{LmiEngine, RetrievalEngine, Step, audit};

fn quiet(_: &Step) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn the_panda_optimum_is_reached_feasible_and_certified() {
    for (c5z, least, most) in [(panda::C5Z_REPOSITORY, 3.7261e-4, 3.7265e-4), (-0.05, 3.86111e-4, 3.86121e-4)]
    {
        let problem = panda::problem(c5z);
        let engine = LmiEngine::default();
        let start = Instant::now();
        let found = engine.retrieve(&problem, &quiet).expect("it solves");
        println!("{:?}", start.elapsed());
        let audit = audit(&problem, &found.z);
        let bound = found.lower_bound.expect("a bound");
        println!("{:.10e} {:.10e} {:e} {}", audit.objective, bound, audit.violation, found.status);
        assert!(audit.feasible && audit.objective <= most, "{} {}", audit.objective, audit.violation);
        assert!(bound >= least && bound <= audit.objective, "{bound}");
    }
}
