use lacuna::effects::{About, CATALOGUE};
use lacuna::{Error, Result};
use serde::Serialize;

use super::{Global, print, print_json};

/// `lacuna list effects|constraints|engines [NAME]`.
pub(super) fn run(what: &str, name: Option<&str>, global: &Global) -> Result<bool> {
    match (what, name) {
        ("effects", None) => all(global),
        ("effects", Some(name)) => one(name, global),
        ("constraints" | "engines", None) => {
            let nothing: [&str; 0] = [];
            if global.json {
                print_json(&nothing)?
            } else {
                print(&format!("no {what} in this version\n"))?
            }
            Ok(true)
        }
        ("constraints" | "engines", Some(name)) => {
            Err(Error::new(format!("no {} called `{name}`", what.trim_end_matches('s')))
                .help(format!("this version ships no {what}")))
        }
        _ => Err(Error::new(format!("cannot list `{what}`")).help("known are effects, constraints, engines")),
    }
}

#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    title: &'a str,
    text: &'a str,
    equation: &'a str,
    parameters: Vec<Parameter<'a>>,
    confused_with: &'a str,
}

#[derive(Serialize)]
struct Parameter<'a> {
    symbol: &'a str,
    unit: &'a str,
    meaning: &'a str,
}

fn entry(about: &About) -> Entry<'static> {
    let parameters =
        about.parameters.iter().map(|(symbol, unit, meaning)| Parameter { symbol, unit, meaning });
    Entry {
        name: about.name,
        title: about.title,
        text: about.text,
        equation: about.equation,
        parameters: parameters.collect(),
        confused_with: about.confused_with,
    }
}

fn all(global: &Global) -> Result<bool> {
    let abouts: Vec<About> = CATALOGUE.iter().map(|about| about()).collect();
    if global.json {
        print_json(&abouts.iter().map(entry).collect::<Vec<_>>())?;
        return Ok(true);
    }
    let width = abouts.iter().map(|a| a.name.len()).max().unwrap_or(0);
    let lines: String = abouts.iter().map(|a| format!("{:width$}  {}\n", a.name, a.title)).collect();
    print(&(lines + "\nlacuna list effects NAME explains one\n"))?;
    Ok(true)
}

fn one(name: &str, global: &Global) -> Result<bool> {
    let abouts: Vec<About> = CATALOGUE.iter().map(|about| about()).collect();
    let Some(about) = abouts.iter().find(|a| a.name == name) else {
        let known: Vec<&str> = abouts.iter().map(|a| a.name).collect();
        return Err(
            Error::new(format!("no effect called `{name}`")).help(format!("known are {}", known.join(", ")))
        );
    };
    if global.json {
        print_json(&entry(about))?;
        return Ok(true);
    }
    let mut text = format!("{}: {}\n\n", about.name, about.title);
    for line in lacuna::report::wrap(about.text, 78) {
        text += &format!("{line}\n");
    }
    text += &format!("\n  {}\n\n", about.equation);
    for (symbol, unit, meaning) in about.parameters {
        text += &format!("  {symbol:30} {unit:10} {meaning}\n");
    }
    text += &format!("\neasily confused with: {}\n", about.confused_with);
    print(&text)?;
    Ok(true)
}
