use lacuna::constraints;
use lacuna::effects::{self, About, CATALOGUE};
use lacuna::report::hanging;
use lacuna::retrieval::catalogue::{self, EngineAbout};
use lacuna::{Error, Result, text};
use serde::Serialize;

use super::{Global, print, print_json};

/// `lacuna list effects|constraints|engines [NAME]`.
pub(super) fn run(what: &str, name: Option<&str>, global: &Global) -> Result<bool> {
    match (what, name) {
        ("effects", None) => all(global),
        ("effects", Some(name)) => one(name, global),
        ("constraints", None) => all_constraints(global),
        ("constraints", Some(name)) => one_constraint(name, global),
        ("engines", None) => all_engines(global),
        ("engines", Some(name)) => one_engine(name, global),
        _ => Err(Error::new(format!("cannot list `{what}`"))
            .help(text::suggestion(what, ["effects", "constraints", "engines"]))),
    }
}

/// Names and titles in two columns, and how to see more of one.
fn table<'a>(what: &str, entries: impl Iterator<Item = (&'a str, &'a str)> + Clone) -> String {
    let width = entries.clone().map(|(name, _)| name.len()).max().unwrap_or(0);
    let line = |(name, title): (&str, &str)| hanging(&format!("{name:width$}  "), title, width + 2);
    let lines: String = entries.map(line).collect();
    format!("{lines}\nlacuna list {what} NAME explains one\n")
}

/// What to say of a name that none of them has.
fn unknown<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Error {
    Error::new(format!("no {kind} called `{name}`")).help(text::suggestion(name, known))
}

/// Symbol, unit and meaning; what is long hangs below the meaning.
fn parameters(of: &[effects::Parameter]) -> String {
    let width = |length: fn(&effects::Parameter) -> usize| of.iter().map(length).max().unwrap_or(0);
    let symbol = width(|p| p.symbol.chars().count());
    let unit = width(|p| p.unit.chars().count()).min(22);
    let line = |p: &effects::Parameter| {
        hanging(&format!("  {:symbol$}  {:unit$}  ", p.symbol, p.unit), p.meaning, symbol + unit + 6)
    };
    of.iter().map(line).collect()
}

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    title: &'static str,
    text: &'static str,
    equation: &'static str,
    parameters: &'static [effects::Parameter],
    cause: &'static str,
    confused_with: &'static str,
    separating_motion: &'static str,
    example: &'static str,
    drawn_against: effects::Variable,
    at_rest: effects::AtRest,
    reach: effects::Reach,
    stage: effects::Stage,
    imitated_by: &'static [effects::Imitation],
    exports: effects::Exports,
}

fn entry(about: &About) -> Entry {
    Entry {
        name: about.name,
        title: about.title,
        text: about.text,
        equation: about.equation,
        parameters: about.parameters,
        cause: about.cause,
        confused_with: about.confused_with,
        separating_motion: about.separation.motion,
        example: about.example,
        drawn_against: about.drawn_against,
        at_rest: about.at_rest,
        reach: about.reach,
        stage: about.stage,
        imitated_by: about.imitated_by,
        exports: about.special.exports,
    }
}

/// Values of a parameter that cannot be, or are odd, and what they would mean.
fn bounds(of: &[effects::Parameter]) -> String {
    let unit = |p: &effects::Parameter| if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
    // The least number above zero stands for zero itself.
    let at = |x: f64| if x.abs() < 1e-300 { 0.0 } else { x };
    let says = |p: &effects::Parameter, side: &str, bound: Option<effects::Bound>| {
        bound.map(|b| hanging(&format!("{} {side} {}{}: ", p.symbol, at(b.at), unit(p)), b.beyond, 4))
    };
    let one = |p| [says(p, "below", p.least), says(p, "above", p.most)];
    of.iter().flat_map(one).flatten().collect()
}

fn all(global: &Global) -> Result<bool> {
    let abouts: Vec<About> = CATALOGUE.iter().map(|entry| entry.about).collect();
    if global.json {
        print_json(&abouts.iter().map(entry).collect::<Vec<_>>())?;
        return Ok(true);
    }
    print(&table("effects", abouts.iter().map(|a| (a.name, a.title))))?;
    Ok(true)
}

fn one(name: &str, global: &Global) -> Result<bool> {
    let abouts: Vec<About> = CATALOGUE.iter().map(|entry| entry.about).collect();
    let Some(about) = abouts.iter().find(|a| a.name == name) else {
        return Err(unknown("effect", name, abouts.iter().map(|a| a.name)));
    };
    if global.json {
        print_json(&entry(about))?;
        return Ok(true);
    }
    let mut text = hanging(&format!("{}: ", about.name), about.title, 4) + "\n";
    text += &hanging("", about.text, 0);
    text += &format!("\n{}\n", hanging("  ", about.equation, 6));
    text += &parameters(about.parameters);
    text += &format!("\n{}", hanging("easily confused with: ", about.confused_with, 4));
    text += &hanging("told apart by: ", about.separation.motion, 4);
    text += &hanging("usual cause: ", about.cause, 4);
    text += &bounds(about.parameters);
    text += &hanging("in a scenario: ", about.example, 4);
    print(&text)?;
    Ok(true)
}

/// How a scenario writes it, to be copied.
fn in_scenario(field: &str, example: &str) -> String {
    format!("\nin a scenario\n{}", hanging("  ", &format!("{field}: [{example}],"), 6))
}

#[derive(Serialize)]
struct ConstraintEntry<'a> {
    name: &'a str,
    title: &'a str,
    text: &'a str,
    condition: &'a str,
    settings: Vec<Setting<'a>>,
    form: &'a str,
    example: &'a str,
}

#[derive(Serialize)]
struct Setting<'a> {
    name: &'a str,
    unit: &'a str,
    meaning: &'a str,
}

fn constraint_entry(about: &constraints::About) -> ConstraintEntry<'static> {
    let settings = about.settings.iter().map(|(name, unit, meaning)| Setting { name, unit, meaning });
    ConstraintEntry {
        name: about.name,
        title: about.title,
        text: about.text,
        condition: about.condition,
        settings: settings.collect(),
        form: about.form,
        example: about.example,
    }
}

fn all_constraints(global: &Global) -> Result<bool> {
    let abouts: Vec<constraints::About> = constraints::CATALOGUE.iter().map(|about| about()).collect();
    if global.json {
        print_json(&abouts.iter().map(constraint_entry).collect::<Vec<_>>())?;
        return Ok(true);
    }
    print(&table("constraints", abouts.iter().map(|a| (a.name, a.title))))?;
    Ok(true)
}

fn one_constraint(name: &str, global: &Global) -> Result<bool> {
    let abouts: Vec<constraints::About> = constraints::CATALOGUE.iter().map(|about| about()).collect();
    let Some(about) = abouts.iter().find(|a| a.name == name) else {
        return Err(unknown("constraint", name, abouts.iter().map(|a| a.name)));
    };
    if global.json {
        print_json(&constraint_entry(about))?;
        return Ok(true);
    }
    let mut text = hanging(&format!("{}: ", about.name), about.title, 4) + "\n";
    text += &hanging("", about.text, 0);
    text += &format!("\n{}\nsettings\n", hanging("  ", about.condition, 6));
    for (name, unit, meaning) in about.settings {
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        text += &format!("  {name}{unit}\n{}", hanging("      ", meaning, 6));
    }
    text += &format!("\n{}", hanging("form: ", about.form, 6));
    text += &in_scenario("constraints", about.example);
    print(&text)?;
    Ok(true)
}

#[derive(Serialize)]
struct EngineEntry {
    name: &'static str,
    title: &'static str,
    text: &'static str,
    takes: &'static str,
    available: bool,
    settings: Vec<EngineSetting>,
    example: &'static str,
}

#[derive(Serialize)]
struct EngineSetting {
    name: String,
    usual: String,
    meaning: &'static str,
}

fn engine_entry(about: &EngineAbout) -> Result<EngineEntry> {
    let engine = catalogue::engine(about.name)?;
    let setting = |(name, usual): (String, String)| {
        let meaning = about.settings.iter().find(|(known, _)| *known == name).map_or("", |(_, text)| text);
        EngineSetting { name, usual, meaning }
    };
    Ok(EngineEntry {
        name: about.name,
        title: about.title,
        text: about.text,
        takes: about.takes,
        available: engine.available().is_ok(),
        settings: catalogue::usual_settings(engine.as_ref())?.into_iter().map(setting).collect(),
        example: about.example,
    })
}

fn all_engines(global: &Global) -> Result<bool> {
    let entries: Vec<EngineEntry> = catalogue::CATALOGUE.iter().map(engine_entry).collect::<Result<_>>()?;
    if global.json {
        print_json(&entries)?;
        return Ok(true);
    }
    print(&table("engines", entries.iter().map(|e| (e.name, e.title))))?;
    Ok(true)
}

fn one_engine(name: &str, global: &Global) -> Result<bool> {
    catalogue::engine(name)?;
    let Some(about) = catalogue::CATALOGUE.iter().find(|about| about.name == name) else { return Ok(false) };
    let entry = engine_entry(about)?;
    if global.json {
        print_json(&entry)?;
        return Ok(true);
    }
    let mut text = hanging(&format!("{}: ", entry.name), entry.title, 4) + "\n";
    text += &format!("{}\n{}", hanging("", entry.text, 0), hanging("takes: ", entry.takes, 7));
    if !entry.available {
        text += "not in this build\n";
    }
    text += "\nsettings, as they are when a scenario does not say otherwise\n";
    for setting in &entry.settings {
        let usual = if setting.usual == "None" { "not set" } else { &setting.usual };
        text += &format!("  {}: {usual}\n{}", setting.name, hanging("      ", setting.meaning, 6));
    }
    text += &in_scenario("engines", entry.example);
    print(&text)?;
    Ok(true)
}
