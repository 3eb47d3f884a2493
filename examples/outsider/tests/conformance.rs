//! A stranger's plug-ins keep their promises, and the checks notice when plug-ins do not.

use std::path::Path;
use std::sync::Arc;

use lacuna::Result;
use lacuna::conformance;
use lacuna::constraints::{About, Constraint, LinkSpace};
use lacuna::effects::{self, Columns, Effect, RigidBody, Stretch, Term};
use lacuna::excitation::FourierMotion;
use lacuna::form::{Affine, Body, Form, General};
use lacuna::identify::{Evidence, Weighting, fit};
use lacuna::model::Model;
use lacuna::plant::{Moment, Plant, PlantEffect};
use lacuna::retrieval::catalogue::EngineAbout;
use lacuna::retrieval::{Problem, RetrievalEngine, Retrieved, Watch};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run};
use lacuna::text;
use serde::{Deserialize, Serialize};

// Nothing else mentions the crate: without this line its plug-ins would not be linked.
use lacuna_outsider as _;

fn robot() -> Robot {
    Robot::open("../../robots/two_link.ron").expect("the shipped robot reads")
}

fn check(ron: &str) -> Result<()> {
    conformance::constraint(ron, &robot(), Path::new("."), &[])
}

#[test]
fn the_constraint_keeps_its_promises() -> Result<()> {
    check(r#"{"com_outside_sphere": (links: All, center: (0.0, 0.0, 0.1), radius: 0.05)}"#)?;
    check(r#"{"com_outside_sphere": (links: Only(["link2"]), center: (0.0, 0.0, 0.0), radius: 0.3)}"#)
}

#[test]
fn the_engine_solves_every_problem_convex_or_not() -> Result<()> {
    let solved = conformance::engine(r#"{"random_walk": ()}"#, 0.02)?;
    assert_eq!(solved, ["simplex", "ball", "matrix", "ring"]);
    Ok(())
}

fn check_effect(ron: &str) -> Result<()> {
    conformance::effect(ron, &robot(), Path::new("."), &[])
}

#[test]
fn the_effect_keeps_its_promises() -> Result<()> {
    check_effect(r#"{"gas_spring": (rest: 0.3)}"#)?;
    check_effect(r#"{"gas_spring": (joints: Only(["joint2"]), rest: -1.0)}"#)?;
    // What ships keeps them as well, scripts included.
    check_effect(r#"{"viscous_friction": ()}"#)?;
    check_effect(r#"{"torque_gain": ()}"#)?;
    let scripts = Path::new("../..");
    for script in ["quadratic_friction", "end_stop", "warm_friction"] {
        let ron = format!(r#"{{"script": (path: "effects/{script}.rhai")}}"#);
        conformance::effect(&ron, &robot(), scripts, &[])?;
    }
    conformance::effect(
        r#"{"script": (path: "effects/channel_friction.rhai")}"#,
        &robot(),
        scripts,
        &["temperature"],
    )
}

/// The last effect's parameters, fitted together with rigid bodies to what a plant measured.
#[test]
fn the_effect_takes_part_in_a_fit() -> Result<()> {
    let (robot, plant) = (robot(), Plant::new(robot())?.with_effect(Pushed));
    let motion = FourierMotion::random(&robot, 5, 5, 6.0, 0.6)?;
    let truth = plant.simulate(&motion, 8.0, 1)?.truth;
    let thin = |c: &[Vec<f64>]| -> Vec<Vec<f64>> {
        c.iter().map(|c| c.iter().skip(1500).step_by(4).copied().collect()).collect()
    };
    let run = Run {
        dt: 4.0 * (truth.t[1] - truth.t[0]),
        q: thin(&truth.q),
        dq: thin(&truth.dq),
        ddq: thin(&truth.ddq),
        tau: thin(&truth.tau),
        ..Run::default()
    };
    let spring: Box<dyn Effect> = text::from_ron(r#"{"gas_spring": (joints: Only(["joint1"]), rest: 0.4)}"#)?;
    let model = Model::new(&robot, vec![Box::new(RigidBody::default()), spring])?;
    let folds = Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() };
    let evidence = Evidence::collect(&model, &[run], &folds)?;
    let found = fit(&model, &evidence, None, Weighting::Ordinary)?;
    let last = found.x.last().copied().unwrap_or(f64::NAN);
    assert!((last - 6.0).abs() < 0.05, "{last} N m instead of 6");
    Ok(())
}

/// The plant's own spring: 6 N m on joint 1, without lever at 0.4 rad.
#[derive(Debug, Serialize, Deserialize)]
struct Pushed;

#[typetag::serde(name = "outsider_pushed")]
impl PlantEffect for Pushed {
    fn check(&self, _: usize) -> Result<()> {
        Ok(())
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        load[0] += 6.0 * (now.q[0] - 0.4).sin();
    }
}

/// An effect that breaks one promise.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wrong {
    breaks: String,
}

#[typetag::serde(name = "wrong_effect")]
impl Effect for Wrong {
    fn about(&self) -> effects::About {
        effects::About {
            name: "wrong_effect",
            title: "breaks one promise",
            text: "An effect that is wrong on purpose, to see that the checks notice what is wrong with it.",
            equation: "tau_j = k dq_j",
            parameters: const { &[effects::Parameter::new("k", "N m", "strength")] },
            cause: "a test",
            confused_with: "nothing",
            example: if self.breaks == "example" { "wrong" } else { r#"{"wrong_effect": (breaks: "")}"# },
            ..lacuna_outsider::GasSpring::ABOUT
        }
    }

    fn terms(&self, _robot: &Robot) -> Result<Vec<Term>> {
        let term = |j: usize| Term { symbol: format!("k{j}"), unit: "N m", joints: vec![j] };
        let second = if self.breaks == "symbols" { 0 } else { 1 };
        Ok(vec![term(0), Term { joints: vec![1], ..term(second) }])
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let other = if self.breaks == "joint" { 0 } else { 1 };
        out.column(0, 0, |slot| slot.copy_from_slice(at.dq(0)));
        out.column(1, other, |slot| match self.breaks.as_str() {
            "cut" => slot[0] = 1.0,
            "torque" => slot.copy_from_slice(&at.run.tau[1][at.range.clone()]),
            "number" => slot.fill(f64::NAN),
            _ => slot.copy_from_slice(at.dq(1)),
        });
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

#[test]
fn wrong_effects_are_noticed() {
    let wrong = |breaks: &str| check_effect(&format!(r#"{{"wrong_effect": (breaks: "{breaks}")}}"#));
    wrong("nothing").expect("nothing is wrong with this one");
    for (breaks, what) in [
        ("symbols", "two terms are called `k0`"),
        ("joint", "which that term does not name"),
        ("cut", "cut into stretches"),
        ("torque", "explain itself"),
        ("number", "no number"),
        ("example", "cannot be read"),
    ] {
        let message = wrong(breaks).expect_err(breaks).to_string();
        assert!(message.contains(what), "{breaks}: {message}");
    }
}

#[test]
fn an_unknown_name_answers_with_what_is_known() {
    let message = check(r#"{"com_outside_cube": ()}"#).expect_err("unknown").to_string();
    assert!(message.contains("com_outside_sphere") && message.contains("total_mass"), "{message}");
}

/// A constraint that breaks one promise.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Broken {
    promise: Promise,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Promise {
    Gradient,
    Support,
    Implied,
    Labels,
    Example,
    Nothing,
}

#[typetag::serde(name = "broken")]
impl Constraint for Broken {
    fn about(&self) -> About {
        About {
            name: "broken",
            title: "breaks one promise",
            text: "A constraint that is wrong on purpose, to see that the checks notice what is wrong with it.",
            condition: "m <= 5",
            settings: &[("promise", "", "which one")],
            example: match self.promise {
                Promise::Example => r#"{"broken": (min: 1.0)}"#,
                _ => r#"{"broken": (promise: Nothing)}"#,
            },
            form: "general",
        }
    }

    fn forms(&self, _robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let limit = if self.promise == Promise::Implied { 0.01 } else { 50.0 };
        let row = Affine::constant(limit).plus(-1.0, &space.mass(0));
        let form = |label: &str| {
            let body = Body::General {
                function: Arc::new(Product(self.promise)),
                why: "it is wrong".into(),
                implied: vec![Form::affine("implied", "kg", 1.0, row.clone())],
            };
            Form::new(label, "kg^2", 1.0, body)
        };
        let second = if self.promise == Promise::Labels { "first" } else { "second" };
        Ok(vec![form("first"), form(second)])
    }
}

/// `25 - m1 m1`, unless it is broken.
#[derive(Debug)]
struct Product(Promise);

impl General for Product {
    fn support(&self) -> Vec<usize> {
        vec![0]
    }

    fn margin(&self, z: &[f64]) -> f64 {
        let hidden = if self.0 == Promise::Support { z[1] } else { 0.0 };
        25.0 - z[0] * z[0] + hidden
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let factor = if self.0 == Promise::Gradient { -1.0 } else { -2.0 };
        (self.margin(z), vec![factor * z[0]])
    }
}

#[test]
fn broken_constraints_are_noticed() {
    check(r#"{"broken": (promise: Nothing)}"#).expect("nothing is wrong with this one");
    for (promise, what) in [
        ("Gradient", "the slope of `first` in unknown 0"),
        ("Support", "not in its support"),
        ("Implied", "which it says it implies"),
        ("Labels", "two forms are called `first`"),
        ("Example", "the example of broken cannot be read: there is no field `min` here"),
    ] {
        let message =
            check(&format!(r#"{{"broken": (promise: {promise})}}"#)).expect_err(promise).to_string();
        assert!(message.contains(what), "{promise}: {message}");
    }
}

/// An engine that answers with the middle of the bounds, and boasts.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Boaster {
    bound: Option<f64>,
    answer: Vec<f64>,
}

#[typetag::serde(name = "boaster")]
impl RetrievalEngine for Boaster {
    fn about(&self) -> EngineAbout {
        EngineAbout {
            name: "boaster",
            title: "answers what it is told to",
            text: "An engine that is wrong on purpose.",
            takes: "affine forms",
            example: if self.answer.is_empty() {
                "{\"lmi\": ()}"
            } else {
                r#"{"boaster": (bound: None, answer: [1.0])}"#
            },
            settings: &[("bound", "the bound that it claims"), ("answer", "its answer")],
        }
    }

    fn label(&self) -> &str {
        "boaster"
    }

    fn accepts(&self, form: &Form) -> Result<(), String> {
        if matches!(form.body, Body::Affine(_)) { Ok(()) } else { Err("only affine forms".into()) }
    }

    fn retrieve(&self, _problem: &Problem, _watch: &Watch<'_>) -> Result<Retrieved> {
        Ok(Retrieved {
            z: self.answer.clone(),
            runs: 1,
            stages: 1,
            evaluations: 1,
            status: "best there is".into(),
            stopped: false,
            lower_bound: self.bound,
        })
    }
}

#[test]
fn engines_that_boast_are_noticed() {
    let engine = |ron: &str| conformance::engine(ron, 1e-6);
    assert_eq!(engine(r#"{"boaster": (bound: None, answer: [0.5, 0.5, 0.0, 0.0])}"#), Ok(vec!["simplex"]));
    for (ron, what) in [
        (r#"{"boaster": (bound: Some(1.76), answer: [0.5, 0.5, 0.0, 0.0])}"#, "is above the best objective"),
        (r#"{"boaster": (bound: None, answer: [0.6, 0.5, 0.0, 0.0])}"#, "violates the forms"),
        (r#"{"boaster": (bound: None, answer: [0.4, 0.5, 0.0, 0.0])}"#, "the best is"),
        (r#"{"boaster": (bound: None, answer: [0.5])}"#, "not 4 finite numbers"),
        (r#"{"boaster": (bound: None, answer: [])}"#, "the example of boaster is one of `lmi`"),
    ] {
        let message = engine(ron).expect_err(ron).to_string();
        assert!(message.contains(what), "{ron}: {message}");
    }
}
