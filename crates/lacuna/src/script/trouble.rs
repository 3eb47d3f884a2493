//! What the interpreter complains about, in the words of this crate: place, remedy, and what is known.

use rhai::{EvalAltResult, LexError, ParseError, ParseErrorType, Position};

use super::budget::TOO_LARGE;
use super::dialect::Dialect;
use super::effect;
use super::engine::{CANCELLED, OUT_OF_TIME};
use super::functions::FUNCTIONS;
use super::subject::PROPERTIES;
use super::tracer::spot;
use crate::error::Error;
use crate::text::names::did_you_mean;

/// The error at a position of the script.
pub(super) fn at(error: Error, position: Position) -> Error {
    let (line, column) = spot(position);
    if line == 0 { error } else { error.at(line, column.max(1)) }
}

fn functions(dialect: &Dialect) -> Vec<String> {
    let own = dialect.functions.iter().map(|(name, d)| format!("{name}({})", d.arguments.join(", ")));
    FUNCTIONS.iter().map(|f| f.0.to_string()).chain(own).collect()
}

/// The nearest name, where one is near enough to be meant, and everything that is known.
fn known(wrong: &str, names: &[String]) -> String {
    let bare = names.iter().map(|name| name.split(['(', ' ']).next().unwrap_or(name));
    format!("{}known are {}", did_you_mean(wrong, bare), names.join(", "))
}

/// An error found while reading the script.
pub(super) fn parsing(error: &ParseError, dialect: &Dialect) -> Error {
    let told = match error.err_type() {
        ParseErrorType::VariableUndefined(name) => {
            let arguments = dialect.functions.values().flat_map(|d| d.arguments.iter());
            let mut names: Vec<String> = arguments.chain(&dialect.variables).cloned().collect();
            names.sort();
            names.dedup();
            Error::new(format!("nothing is called `{name}` here")).help(format!(
                "{}; a function sees its own arguments and `let`s, nothing from outside",
                known(name, &names)
            ))
        }
        ParseErrorType::BadInput(LexError::ImproperSymbol(word, _)) => Error::new(format!(
            "`{word}` is not part of the language of constraints"
        ))
        .help("a constraint computes and compares; it reads no files, prints nothing, runs no other code"),
        ParseErrorType::Reserved(word) => Error::new(format!("`{word}` cannot be used as a name here"))
            .help("it is a word of the script language, or one that constraints may not use"),
        ParseErrorType::ExprTooDeep => {
            Error::new("expressions are nested too deeply").help("keep parts of it in variables by `let`")
        }
        other => Error::new(other.to_string()).help("the script language is rhai: https://rhai.rs/book"),
    };
    at(told, error.position())
}

/// An error while the script ran.
pub(super) fn running(error: &EvalAltResult, dialect: &Dialect, seconds: f64) -> Error {
    let mut inner = error;
    let mut place = inner.position();
    while let EvalAltResult::ErrorInFunctionCall(_, _, deeper, _) = inner {
        inner = deeper;
        if !inner.position().is_none() {
            place = inner.position();
        }
    }
    at(explain(inner, dialect, seconds), place)
}

fn explain(error: &EvalAltResult, dialect: &Dialect, seconds: f64) -> Error {
    use EvalAltResult as E;
    match error {
        E::ErrorRuntime(what, _) => stated(what.to_string()),
        E::ErrorFunctionNotFound(signature, _) => {
            let name = signature.split(" (").next().unwrap_or(signature);
            Error::new(format!("no function `{}`", readable(signature)))
                .help(known(name, &functions(dialect)))
        }
        E::ErrorDotExpr(what, _) | E::ErrorIndexingType(what, _) => property(what),
        E::ErrorPropertyNotFound(name, _) => Error::new(format!("the map has no `{name}`"))
            .help("settings are those that `fn settings()` returns, memory what `fn about()` lists"),
        E::ErrorVariableNotFound(name, _) => Error::new(format!("nothing is called `{name}` here"))
            .help("a function sees its own arguments and `let`s, nothing from outside"),
        E::ErrorMismatchDataType(wanted, got, _) if wanted == "bool" => Error::new(format!(
            "true or false is needed here, not a {got}"
        ))
        .help(
            "compare inside the `if` itself, or ask `holds(relation)`; rules that must all hold are a list",
        ),
        E::ErrorTooManyOperations(_) => Error::new("the script does not come to an end")
            .help("a loop never stops, or does far more than a constraint needs"),
        E::ErrorTerminated(token, _) if token.to_string() == OUT_OF_TIME => out_of_time(seconds),
        E::ErrorTerminated(token, _) if token.to_string() == CANCELLED => cancelled(),
        E::ErrorStackOverflow(_) => {
            Error::new("functions call each other without end").help("at most 24 calls may be open at a time")
        }
        E::ErrorDataTooLarge(what, _) => Error::new(format!("a value grows too large: {what}"))
            .help("texts end at 4096 letters, lists at 1000 entries"),
        E::ErrorTooManyVariables(_) => {
            Error::new("the script has too many variables").help("at most 256 may be in sight at a time")
        }
        E::ErrorArrayBounds(count, index, _) => {
            Error::new(format!("a list of {count} has no [{index}]")).help("entries are counted from 0")
        }
        other => Error::new(other.to_string().split(" (line ").next().unwrap_or_default().to_string())
            .help("the script language is rhai: https://rhai.rs/book"),
    }
}

/// An error in the words of this crate.
pub(super) fn stated(what: String) -> Error {
    let help = if what == TOO_LARGE {
        "build fewer or shorter expressions: a sum over all links is as long as the robot has parameters, and every new \
         one is kept"
    } else {
        "`lacuna check` on the script shows what it means to the engines"
    };
    Error::new(what).help(help)
}

/// The time of the script ran out.
pub(super) fn out_of_time(seconds: f64) -> Error {
    Error::new(format!("the script took more than {seconds} s, all it did counted together"))
        .help("simplify it, or allow more with `seconds`")
        .ending()
}

/// Somebody stopped the study.
pub(super) fn cancelled() -> Error {
    Error::new("the script was stopped from outside").help("run it again to go on").ending()
}

/// Signatures without the interpreter's own names.
fn readable(signature: &str) -> String {
    signature
        .replace("&str | ImmutableString | String", "text")
        .replace("i64", "number")
        .replace("f64", "number")
}

fn property(what: &str) -> Error {
    let wrong = what.split('\'').nth(1).unwrap_or_default();
    let owner = what.split('\'').nth(3).unwrap_or_default();
    match PROPERTIES.iter().chain(&effect::PROPERTIES).find(|(name, _)| *name == owner) {
        Some((_, list)) => {
            let names: Vec<String> = list.split(", ").map(str::to_string).collect();
            Error::new(format!("a {owner} has no `{wrong}`")).help(known(wrong, &names))
        }
        None => Error::new(what.to_string())
            .help("numbers, texts and lists have no such property; links and the robot have some"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelled_function_is_found_without_its_arguments() {
        let names = ["inertia(link)".to_string(), "mass".to_string()];
        assert_eq!(known("inerita", &names), "did you mean `inertia`? known are inertia(link), mass");
        assert_eq!(known("sine", &names), "known are inertia(link), mass");
    }
}
