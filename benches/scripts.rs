//! What a scripted rule costs per evaluation: the rule of `constraints/cone_tip.rhai` in Rust, as a lowered
//! form, and interpreted anew at every point.

use std::hint::black_box;

use divan::Bencher;
use lacuna::constraints::{Constraint, LinkSpace, Links, Scripted};
use lacuna::effects::{CoulombFriction, Effect, Joints, ScriptedEffect};
use lacuna::form::Form;
use lacuna::model::{Model, ModelBlock};
use lacuna::robot::Robot;
use lacuna::script::{Body, Limits, Script, Settings, Subject};
use lacuna::signals::Run;

fn main() {
    divan::main();
}

fn robot() -> (Robot, LinkSpace, Vec<f64>) {
    let robot = Robot::open("robots/two_link.ron").expect("the robot reads");
    let space = LinkSpace::new(&robot, &[]);
    let z = robot.inertial_parameters().expect("known");
    (robot, space, z)
}

fn form(name: &str) -> (Form, Vec<f64>) {
    let (robot, space, z) = robot();
    let script = Script::open(&std::path::Path::new("constraints").join(name)).expect("reads");
    let mut constraint = Scripted::from_script(script, Settings::new());
    constraint.links = Links::Only(vec!["link2".into()]);
    (constraint.forms(&robot, &space).expect("lowers").swap_remove(0), z)
}

fn native(z: &[f64]) -> f64 {
    let m = z[10].max(1e-6);
    let (x, y, w) = (z[11] / m, z[12] / m, z[13] / m);
    let allowed = if x < -0.2 { 0.08 } else { 0.08 + (0.02 - 0.08) * (0.2 + x) / 0.2 };
    allowed - (y * y + w * w).sqrt()
}

#[divan::bench]
fn margin_in_rust(bencher: Bencher) {
    let (_, _, z) = robot();
    bencher.bench(|| native(black_box(&z)));
}

#[divan::bench]
fn margin_lowered(bencher: Bencher) {
    let (form, z) = form("cone_tip.rhai");
    bencher.bench(|| form.margin(black_box(&z)));
}

#[divan::bench]
fn gradient_lowered(bencher: Bencher) {
    let (form, z) = form("cone_tip.rhai");
    bencher.bench(|| form.gradient(black_box(&z)));
}

#[divan::bench]
fn margin_as_cone(bencher: Bencher) {
    let (form, z) = form("cone_tip_convex.rhai");
    bencher.bench(|| form.margin(black_box(&z)));
}

#[divan::bench]
fn margin_interpreted(bencher: Bencher) {
    let (robot, space, z) = robot();
    let body = |i: usize| Body {
        name: space.names[i].clone(),
        mass: space.mass(i),
        first_moment: std::array::from_fn(|axis| space.first_moment(i, axis)),
        inertia_at_origin: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            .map(|(r, c)| space.inertia_at_origin(i, r, c)),
    };
    let subject = Subject {
        name: robot.name.clone(),
        gravity: robot.gravity.into(),
        bodies: (0..space.links).map(body).collect(),
        chosen: vec![1],
        unknowns: Vec::new(),
    };
    let script = Script::open("constraints/cone_tip.rhai".as_ref()).expect("reads");
    let limits = Limits { seconds: 1e6, ..Limits::default() };
    let oracle = script.interpreter(&subject, &Settings::new(), &limits).expect("compiles");
    bencher.bench_local(|| oracle.margins(black_box(&z)));
}

#[divan::bench]
fn reading_and_lowering(bencher: Bencher) {
    bencher.bench(|| form("cone_tip.rhai"));
}

/// A made-up run of the two-link robot.
fn run() -> Run {
    let wave = |shift: f64| -> Vec<Vec<f64>> {
        let column = |j: usize| (0..SAMPLES).map(|k| (0.01 * k as f64 + shift + j as f64).sin()).collect();
        (0..2).map(column).collect()
    };
    Run { dt: 1e-3, q: wave(0.0), dq: wave(1.0), ddq: wave(2.0), tau: wave(3.0), ..Run::default() }
}

const SAMPLES: usize = 10_000;

/// Columns of both joints of an effect at all samples.
fn columns(bencher: Bencher, effect: Box<dyn Effect>) {
    let robot = Robot::open("robots/two_link.ron").expect("the robot reads");
    let (run, model) = (run(), Model::new(&robot, vec![effect]).expect("fits the robot"));
    let mut block = ModelBlock::new(&model, SAMPLES);
    bencher.bench_local(|| model.fill(black_box(&run), 0..SAMPLES, &mut block).expect("computes"));
}

#[divan::bench]
fn columns_in_rust(bencher: Bencher) {
    columns(bencher, Box::new(CoulombFriction { width: 0.1, ..CoulombFriction::default() }));
}

#[divan::bench]
fn columns_scripted(bencher: Bencher) {
    columns(bencher, script("quadratic_friction.rhai"));
}

#[divan::bench]
fn columns_scripted_with_memory(bencher: Bencher) {
    columns(bencher, script("warm_friction.rhai"));
}

fn script(name: &str) -> Box<dyn Effect> {
    let path = std::path::Path::new("effects").join(name);
    ScriptedEffect::open(&path, Joints::All).expect("reads").boxed()
}
