//! The retrieval engines know nothing of robots: here they follow a market index with twelve shares.
//!
//! The money is all invested (an equation), nobody is sold short, technology stays below a third, the
//! risk below a ceiling (a norm), and one rule is an if-else that no cone expresses: whoever puts more than
//! 10 % into small companies must keep 8 % in cash.
//!
//! `cargo run --release --example portfolio`

use std::ops::ControlFlow;
use std::sync::Arc;

use lacuna::Result;
use lacuna::form::{Affine, Body, Form, General};
use lacuna::retrieval::penalty::PenaltyEngine;
use lacuna::retrieval::{Identity, Problem, Quadratic, RetrievalEngine, audit};
use lacuna::space::{Parameter, Space};
use nalgebra::{DMatrix, DVector};

const SHARES: usize = 12;
/// The one that is cash.
pub const CASH: usize = 11;
/// Those of small companies.
pub const SMALL: [usize; 3] = [8, 9, 10];

/// `if small > 0.1 then cash >= 0.08`.
#[derive(Debug)]
struct CashRule;

impl General for CashRule {
    fn support(&self) -> Vec<usize> {
        [&SMALL[..], &[CASH]].concat()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.gradient(z).0
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let little = 0.1 - SMALL.iter().map(|&i| z[i]).sum::<f64>();
        let cash = z[CASH] - 0.08;
        // The rule holds where either part does.
        if little >= cash { (little, vec![-1.0, -1.0, -1.0, 0.0]) } else { (cash, vec![0.0, 0.0, 0.0, 1.0]) }
    }
}

fn sum(members: impl IntoIterator<Item = usize>) -> Affine {
    members.into_iter().fold(Affine::default(), |sum, i| sum.plus(1.0, &Affine::variable(i)))
}

/// Everything that must hold.
fn forms() -> Vec<Form> {
    let invested = sum(0..SHARES).plus(-1.0, &Affine::constant(1.0));
    let risk = (0..SHARES).map(|i| Affine::variable(i).times(0.05 + 0.03 * i as f64 * f64::from(i != CASH)));
    let technology = Affine::constant(1.0 / 3.0).plus(-1.0, &sum(0..3));
    vec![
        Form::affine("all is invested", "share", 1.0, invested.clone()),
        Form::affine("no more than all", "share", 1.0, invested.times(-1.0)),
        Form::affine("technology <= 1/3", "share", 1.0, technology),
        Form::new("risk", "share", 0.1, Body::Norm { rows: risk.collect(), bound: Affine::constant(0.07) }),
        Form::new(
            "cash rule",
            "share",
            0.1,
            Body::General { function: Arc::new(CashRule), why: "an if-else".into(), implied: vec![] },
        ),
    ]
}

/// What the index did in thirty weeks, and what each share did: made up, but always the same.
pub fn problem() -> Problem {
    let weeks = 30;
    let wave =
        |week: usize, share: usize| libm::sin(0.7 * week as f64 * (1.0 + share as f64).sqrt() + share as f64);
    let r = DMatrix::from_fn(weeks, SHARES, |w, s| if s == CASH { 0.01 } else { wave(w, s) });
    let index = DVector::from_fn(SHARES, |s, _| {
        [0.2, 0.15, 0.1, 0.05, 0.05, 0.05, 0.05, 0.05, 0.1, 0.1, 0.1, 0.0][s]
    });
    let mut space = Space::default();
    space.push_group(
        "shares",
        (0..SHARES).map(|s| Parameter::free(format!("share {s}"), "").within(0.0, 1.0)),
    );
    let objective = Quadratic { d: &r * index, r, floor: 0.0, unit: "%^2".into() };
    Problem { chart: Box::new(Identity { space: space.clone() }), space, objective, forms: forms(), seed: 7 }
}

fn main() -> Result<()> {
    let problem = problem();
    let found = PenaltyEngine::default().retrieve(&problem, &|_| ControlFlow::Continue(()))?;
    let audit = audit(&problem, &found.z);
    println!("{}", found.status);
    println!(
        "tracking error {:.6} {}, violation {:.1e}",
        audit.objective, problem.objective.unit, audit.violation
    );
    for (parameter, value) in problem.space.parameters.iter().zip(&found.z) {
        println!("{:>9} {:6.2} %", parameter.name, 100.0 * value);
    }
    for constraint in &audit.constraints {
        let state = if constraint.active { "holds it back" } else { "" };
        println!("{:<18} margin {:9.2e} {} {state}", constraint.label, constraint.margin, constraint.unit);
    }
    Ok(())
}
