//! Constraint scripts: what is refused, what the shipped ones mean, and the interpreter as oracle of the forms.

#[path = "scripts/budget.rs"]
mod budget;
#[path = "scripts/check.rs"]
mod check;
#[path = "scripts/oracle.rs"]
mod oracle;
#[path = "scripts/refused.rs"]
mod refused;
#[path = "scripts/shipped.rs"]
mod shipped;
#[path = "scripts/soup.rs"]
mod soup;

use lacuna::constraints::{Constraint, LinkSpace, Scripted};
use lacuna::form::Form;
use lacuna::robot::{PARAMETERS_PER_LINK, Robot};
use lacuna::script::{Script, Settings};

pub(crate) fn two_link() -> (Robot, LinkSpace) {
    let robot = Robot::open("robots/two_link.ron").expect("the robot reads");
    let space = LinkSpace::new(&robot, &[]);
    (robot, space)
}

/// Forms of a script from memory on the two-link robot.
pub(crate) fn forms(text: &str) -> lacuna::Result<Vec<Form>> {
    let (robot, space) = two_link();
    Scripted::from_script(Script::new("test.rhai", text), Settings::new()).forms(&robot, &space)
}

/// Forms of rules that are asked link by link, in a function with `link` in sight.
pub(crate) fn link_rules(rules: &str) -> lacuna::Result<Vec<Form>> {
    forms(&format!("fn constrain_link(robot, link, with) {{\n{rules}\n}}"))
}

/// Plausible link parameters near those of the robot, as many as asked for, always the same.
pub(crate) fn points(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    let base = robot.inertial_parameters_or_zero();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let mut z = base.clone();
            for link in z.chunks_mut(PARAMETERS_PER_LINK) {
                link[0] = 0.3 + 8.0 * draw();
                link[1..4].iter_mut().for_each(|m| *m = 1.2 * (draw() - 0.5));
                link[4..].iter_mut().for_each(|j| *j += 0.4 * (draw() - 0.4));
            }
            z
        })
        .collect()
}
