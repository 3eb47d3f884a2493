//! Scripts put together at random from what scripts are made of: whatever they say, the answer is forms or an
//! error with a place.

use proptest::prelude::*;

use super::forms;

const PIECES: [&str; 62] = [
    "link.mass",
    "link.com",
    "link.com.x",
    "link.inertia",
    "link.principal_moments",
    "link.name",
    "robot",
    "robot.gravity",
    "with",
    "1",
    "2.5",
    "0",
    "-1e300",
    "\"a\"",
    "true",
    "()",
    "[",
    "]",
    "(",
    ")",
    "{",
    "}",
    "#{",
    ",",
    ";",
    "+",
    "-",
    "*",
    "/",
    "**",
    "<",
    "<=",
    ">",
    ">=",
    "==",
    "!=",
    "&&",
    "||",
    "!",
    "=",
    "let a =",
    "a",
    "if",
    "else",
    "while",
    "loop",
    "break",
    "for i in 0..3",
    "for l in links",
    "return",
    "min(",
    "max(",
    "norm(",
    "psd(",
    "any_of(",
    "holds(",
    "sqrt(",
    "rule(\"r\",",
    "margin(\"m\",",
    ".x",
    "|v| v",
    "fn f(x) { x }",
];

const RULES: [&str; 14] = [
    "link.mass >= 1",
    "norm(link.com) <= a",
    "link.com.x * b <= 2",
    "any_of([link.com.x >= b, a <= 3])",
    "psd(link.pseudo_inertia)",
    "a >= b",
    "min(a, b) >= 0",
    "sqrt(a) <= 5",
    "a / b <= 1",
    "a ** b <= 2",
    "abs(a - link.mass) <= 1",
    "rule(\"r\", link.mass >= b)",
    "margin(\"m\", a * link.mass)",
    "max(a, b) == 1",
];

const VALUES: [&str; 12] = [
    "link.mass",
    "2.0",
    "3",
    "link.com.y",
    "norm(link.com)",
    "if link.mass > 2 { 1.0 } else { 2.0 }",
    "link.mass * link.mass",
    "sqrt(link.mass)",
    "min(link.mass, 2)",
    "link.principal_moments.x",
    "1 / 3",
    "if link.com.x < 0 { link.mass } else { 2 * link.mass }",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_answered(picks in prop::collection::vec(0..PIECES.len(), 1..24)) {
        let body: Vec<&str> = picks.into_iter().map(|i| PIECES[i]).collect();
        let text = format!("fn constrain_link(robot, link, with) {{ {} }}", body.join(" "));
        if let Err(error) = forms(&text) {
            prop_assert!(error.place().is_some_and(|p| p.line.is_some()), "{text}: {error}");
        }
    }

    #[test]
    fn any_rules_are_answered(a in 0..VALUES.len(), b in 0..VALUES.len(), rules in prop::collection::vec(0..RULES.len(), 1..5)) {
        let rules: Vec<&str> = rules.into_iter().map(|i| RULES[i]).collect();
        let text = format!(
            "fn constrain_link(robot, link, with) {{ let a = {}; let b = {}; [ {} ] }}",
            VALUES[a], VALUES[b], rules.join(", ")
        );
        match forms(&text) {
            Ok(forms) => prop_assert!(!forms.is_empty()),
            Err(error) => prop_assert!(error.place().is_some_and(|p| p.line.is_some()), "{text}: {error}"),
        }
    }
}
