//! The forms against the interpreter that runs the script anew at every point, and gradients against differences.

use lacuna::constraints::{Constraint, LinkSpace, Scripted};
use lacuna::form::{Body, Form};
use lacuna::robot::Robot;
use lacuna::script::{Body as Seen, Limits, Script, Settings, Subject};

use super::{link_rules, points, two_link};

/// Rules of many kinds, each on the two-link robot's link 1 or 2.
const RULES: [&str; 18] = [
    "[link.mass >= 0.1, link.mass <= 10]",
    "[link.com.x <= 0.2, -0.3 <= link.com.y]",
    "[norm(link.com) <= 0.4]",
    "[norm([link.first_moment.x, link.first_moment.z]) <= 0.1 * link.mass]",
    "[psd(link.pseudo_inertia)]",
    "[link.inertia.xx >= 0.001, link.inertia.yz <= 0.5]",
    "let p = link.principal_moments;\n[p.x + p.y >= p.z, p[0] >= -5]",
    "[link.com.x * link.com.y <= 0.1 ** 2]",
    "[sqrt(abs(link.com.x)) + exp(link.com.y / (0.1 + norm(link.com))) <= 2]",
    "[any_of([link.com.x >= 0.1, [link.com.y >= 0.05, link.mass <= 3]])]",
    "[min(link.mass, 4.0) >= 2.0, max(link.com.x, link.com.y) >= 0.0]",
    "if link.mass > 2.0 { [link.com.x <= 0.1] } else { [link.com.x <= 0.3, link.com.z <= 0.2] }",
    "let a = if link.com.z < -0.01 { link.mass } else { 2.0 * link.mass };\nif a > 4 { [a <= 9] } else { [] }",
    "[trace(link.inertia_at_origin) >= 2.0 * link.inertia_at_origin.xx]",
    "let heavy = link.mass > 3;\nif holds(heavy) && link.com.x < 0.0 { [link.com.y <= 0.0] } else { [] }",
    "[dot(link.com, vector(1, 2, 3)) <= 0.7, (link.com - vector(0.1, 0, 0)).x * 2 <= 1]",
    "[link.mass == 2.0, margin(\"swing\", 9.0 - link.mass * norm(link.com) ** 1.5, \"odd\")]",
    "[psd(link.inertia - 0.001 * identity(3)), tanh(link.com.x / 0.1) + sin(link.com.y / 1.0) <= 1.5]",
];

fn wrap(rules: &str) -> String {
    format!("fn constrain_link(robot, link, with) {{\n{rules}\n}}")
}

fn subject(robot: &Robot, space: &LinkSpace) -> Subject {
    let body = |i: usize| Seen {
        name: space.names[i].clone(),
        mass: space.mass(i),
        first_moment: std::array::from_fn(|axis| space.first_moment(i, axis)),
        inertia_at_origin: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            .map(|(r, c)| space.inertia_at_origin(i, r, c)),
    };
    Subject {
        name: robot.name.clone(),
        gravity: robot.gravity.into(),
        bodies: (0..space.links).map(body).collect(),
        chosen: (0..space.links).collect(),
        unknowns: space.space.parameters.iter().map(|p| p.name.clone()).collect(),
    }
}

/// For every place in the script, the smallest of the margins stated there.
fn smallest(all: impl Iterator<Item = ((usize, usize), f64)>) -> Vec<((usize, usize), f64)> {
    let mut found: Vec<((usize, usize), f64)> = Vec::new();
    for (place, margin) in all {
        match found.iter_mut().find(|(p, _)| *p == place) {
            Some((_, least)) => *least = least.min(margin),
            None => found.push((place, margin)),
        }
    }
    found
}

#[test]
fn forms_say_what_the_interpreter_says() {
    let (robot, space) = two_link();
    let subject = subject(&robot, &space);
    let mut compared = 0;
    for rules in RULES {
        let script = Script::new("test.rhai", wrap(rules));
        let limits = Limits::default();
        let lowered = script.lower(&subject, &Settings::new(), &limits).unwrap_or_else(|e| panic!("{e}"));
        let oracle = script.interpreter(&subject, &Settings::new(), &limits).expect("compiles");
        for z in points(&robot, 60) {
            let expected =
                smallest(oracle.margins(&z).unwrap_or_else(|e| panic!("{rules}: {e}")).into_iter());
            let by_rule = lowered.rules.iter().map(|rule| {
                let forms = &lowered.forms[rule.forms.clone()];
                (rule.place, forms.iter().map(|f| f.reported_margin(&z)).fold(f64::INFINITY, f64::min))
            });
            let got = smallest(by_rule);
            for (place, margin) in &expected {
                let (_, found) = got.iter().find(|(p, _)| p == place).expect("every rule has forms");
                // Where a rule does not apply to one of the links, its own bound stands in.
                let same = (found - margin).abs() <= 1e-10 * (1.0 + margin.abs());
                assert!(same || (*found > 0.0 && *margin > *found), "{rules} {place:?}: {found} {margin}");
                compared += usize::from(same);
            }
            for (place, found) in &got {
                let applies = expected.iter().any(|(p, _)| p == place);
                assert!(applies || *found > 0.0, "{rules} {place:?} does not apply but gives {found}");
            }
        }
    }
    assert!(compared > 1500, "{compared}");
}

fn check_gradient(form: &Form, z: &[f64], rules: &str) -> usize {
    let (_, gradient) = form.gradient(z);
    let mut checked = 0;
    for (i, slope) in gradient {
        let moved = |h: f64| {
            let mut z = z.to_vec();
            z[i] += h;
            form.margin(&z)
        };
        let slopes = [1e-6, 1e-5].map(|h| (moved(h) - moved(-h)) / (2.0 * h));
        // Where the two differences disagree there is a branch between them.
        if (slopes[0] - slopes[1]).abs() > 1e-5 * (1.0 + slopes[0].abs()) {
            continue;
        }
        assert!((slope - slopes[0]).abs() < 2e-5 * (1.0 + slope.abs()), "{rules} {i}: {slope} {slopes:?}");
        checked += 1;
    }
    checked
}

#[test]
fn gradients_are_exact_through_the_branches() {
    let (robot, _) = two_link();
    let mut checked = 0;
    for rules in RULES {
        for form in link_rules(rules).unwrap_or_else(|e| panic!("{rules}: {e}")) {
            for z in points(&robot, 25) {
                checked += check_gradient(&form, &z, rules);
                if let Some(measure) = &form.measure {
                    let body =
                        Body::General { function: measure.clone(), why: String::new(), implied: vec![] };
                    checked += check_gradient(&Form::new("measure", "", 1.0, body), &z, rules);
                }
            }
        }
    }
    assert!(checked > 5000, "{checked}");
}

#[test]
fn the_sign_of_a_measure_is_that_of_its_body() {
    let (robot, _) = two_link();
    for rules in RULES {
        for form in link_rules(rules).expect("lowers") {
            for mut z in points(&robot, 40) {
                for shrink in [1.0, 1e-7, 0.0] {
                    z.iter_mut().for_each(|v| *v *= shrink);
                    let (body, measure) = (form.margin(&z), form.reported_margin(&z));
                    assert!(body * measure >= 0.0, "{}: {body} {measure}", form.label);
                }
            }
        }
    }
}

#[test]
fn kinds_are_recognised() {
    let kind = |rules: &str| {
        let forms = link_rules(rules).unwrap_or_else(|e| panic!("{rules}: {e}"));
        match &forms[0].body {
            Body::Affine(_) => "affine".to_string(),
            Body::Norm { .. } => "norm".into(),
            Body::Psd { .. } => "psd".into(),
            Body::General { why, .. } => why.clone(),
        }
    };
    for rules in [
        "[link.com.x <= 0.2]",
        "[2 * link.com.x - link.com.y / 4 + 0.1 <= 0.2]",
        "[link.com.x * link.mass <= 0.2]",
        "[link.first_moment.x / link.mass <= 0.2]",
        "[abs(link.com.x) <= 0.2]",
        "[max(link.com.x, link.com.y, ) <= 0.2]",
        "[min([link.com.x, link.com.y, link.com.z]) >= 0.2]",
        "[total_mass([link]) >= 1]",
    ] {
        assert_eq!(kind(rules), "affine", "{rules}");
    }
    assert_eq!(kind("[norm(link.com - vector(0.1, 0.2, 0.0)) <= 0.3 - link.com.x]"), "norm");
    assert_eq!(kind("[0.3 >= 2 * norm(link.first_moment) + link.first_moment.x]"), "norm");
    assert_eq!(kind("[psd(link.inertia_at_origin)]"), "psd");
    assert!(kind("[norm(link.com) >= 0.1]").contains("from below"));
    let why = kind("[link.com.x * link.com.y >= 0.1]");
    assert!(why.contains("product of unknowns (line 2, column 13)"), "{why}");
    assert!(kind("[link.inertia.xx >= 0.1]").contains("product"));
    assert!(kind("if link.mass > 1 { [link.com.x <= 0.1] } else { [] }").contains("choice"));
}

#[test]
fn the_same_script_gives_the_same_bits_twice() {
    let (robot, space) = two_link();
    let script = Script::open("constraints/cone_tip.rhai".as_ref()).expect("reads");
    let margins = || {
        let forms =
            Scripted::from_script(script.clone(), Settings::new()).forms(&robot, &space).expect("lowers");
        let points = points(&robot, 20);
        points.iter().flat_map(|z| forms.iter().map(|f| f.margin(z).to_bits()).collect::<Vec<_>>()).collect()
    };
    let (first, second): (Vec<u64>, Vec<u64>) = (margins(), margins());
    assert_eq!(first, second);
}
