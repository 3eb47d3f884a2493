//! Retrieval by search: the Panda's two-step problem, other problems, stopping and going on.

#[path = "common/panda_problem.rs"]
mod panda_problem;
#[path = "common/two_link_problem.rs"]
mod two_link_problem;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use lacuna::form::{Affine, Form};
use lacuna::retrieval::checkpoint::Checkpoint;
use lacuna::retrieval::penalty::{PaperEngine, PenaltyEngine, PenaltyForm, PenaltyTable};
use lacuna::retrieval::polish::Polish;
use lacuna::retrieval::{Audit, Identity, Problem, Quadratic, RetrievalEngine, Retrieved, Step, audit};
use lacuna::space::{Parameter, Space};
use nalgebra::{DMatrix, DVector};
use panda_problem::{panda_two_step, panda_two_step_within};
use two_link_problem::two_link;

/// Optimum of the Panda's problem, certified by a semidefinite solver from both sides.
const OPTIMUM: f64 = 3.726_204_8e-4;

fn on(_: &Step) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn solve(engine: &dyn RetrievalEngine, problem: &Problem) -> (Retrieved, Audit) {
    let found = engine.retrieve(problem, &on).expect("the engine runs");
    let audit = audit(problem, &found.z);
    (found, audit)
}

fn bits(found: &Retrieved) -> Vec<u64> {
    found.z.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn every_start_reaches_the_optimum_of_the_panda() {
    for seed in 0..20 {
        let problem = panda_two_step(seed);
        let (found, audit) = solve(&PenaltyEngine { runs: 1, ..PenaltyEngine::default() }, &problem);
        println!("{seed}: {:.7e} {:.0e} {}", audit.objective, audit.violation, found.evaluations);
        assert!(audit.feasible && audit.violation <= 0.0, "{seed}: {}", audit.violation);
        assert!(audit.objective < 1.001 * OPTIMUM, "{seed}: {:e}", audit.objective);
        assert!(audit.objective > (1.0 - 1e-7) * OPTIMUM, "{seed}: {:e}", audit.objective);
        let p = problem.chart.coordinates(&found.z);
        for (value, about) in p.iter().zip(&problem.chart.space().parameters) {
            assert!((about.lower..=about.upper).contains(value), "{} = {value}", about.name);
        }
    }
}

#[test]
fn the_best_of_five_reaches_the_optimum_under_the_bounds_of_the_table() {
    let problem = panda_two_step_within(1, -0.05);
    let (found, audit) = solve(&PenaltyEngine { runs: 5, ..PenaltyEngine::default() }, &problem);
    println!("{:.7e}, {}", audit.objective, found.status);
    assert!(audit.violation <= 0.0 && (audit.objective - 3.861_16e-4).abs() < 5e-9, "{:e}", audit.objective);
}

#[test]
fn the_paper_first_fits_without_constraints_and_ends_within_them() {
    let problem = panda_two_step(3);
    let engine = PaperEngine { runs: 2, stages: 1, evaluations: 500, ..PaperEngine::default() };
    let (_, first) = solve(&engine, &problem);
    assert!(first.objective < 1e-8 && first.violation > 1e-3, "{:e} {}", first.objective, first.violation);
    let (found, last) = solve(&PaperEngine { stages: 10, ..engine }, &problem);
    println!("penalty_paper: {:.6e} violation {:e}", last.objective, last.violation);
    assert!(last.violation <= 0.0, "{}", last.violation);
    assert!(last.objective < 1.01 * OPTIMUM, "{:e}", last.objective);
    assert_eq!((found.runs, found.stages), (2, 10));
}

#[test]
fn a_constant_penalty_gets_the_search_stuck() {
    let problem = panda_two_step(5);
    let polish = Polish::NelderMead;
    let engine = PaperEngine { runs: 3, stages: 3, evaluations: 2000, polish, ..PaperEngine::default() };
    let table = PenaltyTable::new(&engine, &problem, &on).expect("runs");
    println!("{table}");
    let row = |form| table.rows.iter().find(|r| r.form == form).expect("every form has a row");
    let total = |form| -> f64 { row(form).ends.iter().map(|e| e.1).sum() };
    assert!(total(PenaltyForm::Constant) > 10.0 * total(PenaltyForm::Linear));
}

#[test]
fn the_truth_of_two_links_is_found_from_every_start() {
    for seed in 0..10 {
        let problem = two_link(seed, false);
        let (_, audit) = solve(&PenaltyEngine { runs: 1, ..PenaltyEngine::default() }, &problem);
        assert!(
            audit.feasible && audit.objective < 1e-9,
            "{seed}: {:e} {}",
            audit.objective,
            audit.violation
        );
    }
}

#[test]
fn a_centre_of_mass_in_an_l_is_found() {
    let problem = two_link(0, true);
    assert!(audit(&problem, &two_link_problem::truth()).feasible);
    let good = (0..10).filter(|&seed| {
        let problem = two_link(seed, true);
        let (_, audit) = solve(&PenaltyEngine { runs: 1, ..PenaltyEngine::default() }, &problem);
        println!("{seed}: {:.2e} {:.0e}", audit.objective, audit.violation);
        audit.violation <= 0.0 && audit.objective < 1e-6
    });
    assert!(good.count() >= 9);
}

/// The point of the simplex that is nearest to `d`, with the first share fixed.
fn simplex(d: &[f64]) -> Problem {
    let mut space = Space::default();
    let bounds = |i: usize| if i == 0 { (0.25, 0.25) } else { (0.0, 1.0) };
    let member = |i: usize| Parameter::free(format!("x{i}"), "").within(bounds(i).0, bounds(i).1);
    space.push_group("shares", (0..d.len()).map(member));
    let sum = (0..d.len()).fold(Affine::constant(-1.0), |sum, i| sum.plus(1.0, &Affine::variable(i)));
    let forms = vec![
        Form::affine("at least one", "", 1.0, sum.clone()),
        Form::affine("at most one", "", 1.0, sum.times(-1.0)),
    ];
    let objective = Quadratic {
        r: DMatrix::identity(d.len(), d.len()),
        d: DVector::from_column_slice(d),
        floor: 1.5,
        unit: String::new(),
    };
    Problem { chart: Box::new(Identity { space: space.clone() }), space, objective, forms, seed: 4 }
}

#[test]
fn equations_hold_to_the_last_digit() {
    // Without the fixed share, 0.75 is left: (0.9, 0.4, -0.3) goes to (0.625, 0.125, 0).
    let problem = simplex(&[0.7, 0.9, 0.4, -0.3]);
    let (found, audit) = solve(&PenaltyEngine { runs: 2, ..PenaltyEngine::default() }, &problem);
    println!("{:?} {audit:?}", found.z);
    assert!(audit.feasible, "{}", audit.violation);
    for (value, truth) in found.z.iter().zip([0.25, 0.625, 0.125, 0.0]) {
        assert!((value - truth).abs() < 1e-4, "{:?}", found.z);
    }
    assert!((audit.objective - 1.5 - 0.45_f64.powi(2) - 2.0 * 0.275_f64.powi(2) - 0.09).abs() < 1e-5);
}

#[test]
fn polishes_agree_on_a_small_problem() {
    let problem = two_link(1, false);
    for polish in [Polish::InteriorPoint, Polish::NelderMead] {
        let (_, audit) = solve(&PenaltyEngine { runs: 4, polish, ..PenaltyEngine::default() }, &problem);
        println!("{polish:?}: {:e} {:e}", audit.objective, audit.violation);
        assert!(audit.objective < 1e-3 && audit.violation < 1e-3);
    }
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let problem = panda_two_step(9);
    let engine = PenaltyEngine { runs: 6, proposals: 5000, stages: 2, ..PenaltyEngine::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| solve(&engine, &problem).0)
    };
    let one = with(1);
    for threads in [2, 5] {
        let found = with(threads);
        assert_eq!(bits(&found), bits(&one));
        assert_eq!(found, one);
    }
}

#[test]
fn an_interrupted_search_goes_on_to_the_same_bits() {
    let problem = panda_two_step(2);
    let folder = tempfile::tempdir().expect("a folder");
    let checkpoint = |resume| Some(Checkpoint { folder: folder.path().into(), resume });
    let plain = PenaltyEngine { runs: 8, proposals: 5000, stages: 2, ..PenaltyEngine::default() };
    let whole = solve(&plain, &problem).0;
    let engine = PenaltyEngine { checkpoint: checkpoint(false), ..plain };
    let calls = AtomicUsize::new(0);
    let stop = |step: &Step| {
        assert!((0.0..=1.0).contains(&step.done));
        let enough = calls.fetch_add(1, Ordering::Relaxed) > 6;
        if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let part = engine.retrieve(&problem, &stop).expect("stops with its best");
    assert!(part.stopped && part.runs < 8, "{}", part.status);
    assert!(audit(&problem, &part.z).objective.is_finite());
    let resumed = PenaltyEngine { checkpoint: checkpoint(true), ..engine.clone() };
    let found = solve(&resumed, &problem).0;
    assert_eq!(bits(&found), bits(&whole));
    assert_eq!(found, whole);
    let foreign = resumed.retrieve(&panda_two_step(3), &on).expect_err("another seed");
    assert!(foreign.message().contains("seed 2"), "{foreign}");
    let other = PenaltyEngine { proposals: 6000, ..resumed };
    assert!(other.retrieve(&problem, &on).expect_err("other settings").message().contains("settings"));
}

#[test]
fn contradictory_constraints_end_with_a_violation() {
    let mut problem = panda_two_step(1);
    let total = (0..7).fold(Affine::constant(-90.0), |sum, link| sum.plus(1.0, &Affine::variable(10 * link)));
    problem.forms.push(Form::affine("total mass >= 90 kg", "kg", 90.0, total));
    let (found, audit) = solve(&PenaltyEngine { runs: 2, stages: 2, ..PenaltyEngine::default() }, &problem);
    assert!(!audit.feasible && !found.stopped);
    assert!(found.status.contains("0 feasible"), "{}", found.status);
}

#[test]
fn what_cannot_start_says_why() {
    let refused = |engine: PenaltyEngine, problem: &Problem| {
        engine.retrieve(problem, &on).expect_err("cannot start").to_string()
    };
    let text = refused(PenaltyEngine { runs: 0, ..PenaltyEngine::default() }, &simplex(&[0.5, 0.5]));
    assert!(text.contains("`runs` is 0") && text.contains("help"), "{text}");
    let bounded = |lower, upper| {
        let mut problem = simplex(&[0.5, 0.5]);
        let mut space = problem.space.clone();
        (space.parameters[1].lower, space.parameters[1].upper) = (lower, upper);
        problem.chart = Box::new(Identity { space });
        refused(PenaltyEngine::default(), &problem)
    };
    assert!(bounded(1.0, 0.0).contains("x1: the lower bound 1 exceeds"), "{}", bounded(1.0, 0.0));
    assert!(bounded(0.0, f64::INFINITY).contains("no finite bounds"));
    let hot = PaperEngine { temperature: 0.0, ..PaperEngine::default() };
    assert!(hot.retrieve(&simplex(&[0.5, 0.5]), &on).is_err());
}

#[test]
fn engines_read_from_a_scenario_by_name() {
    let read = |text: &str| lacuna::text::from_ron::<Box<dyn RetrievalEngine>>(text);
    let engine = read(r#"{"penalty": (label: "mine", runs: 3, penalty: Squared, polish: NelderMead)}"#);
    assert_eq!(engine.expect("reads").label(), "mine");
    assert_eq!(read(r#"{"penalty_paper": ()}"#).expect("reads").label(), "penalty_paper");
    let typo = read(r#"{"penalty": (run: 3)}"#).expect_err("a typo");
    assert!(typo.to_string().contains("`runs`"), "{typo}");
}
