use lacuna::constraints;
use lacuna::effects::{About, CATALOGUE};
use lacuna::retrieval::catalogue::{self, EngineAbout};
use lacuna::{Error, Result};
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
    let abouts: Vec<About> = CATALOGUE.iter().map(|entry| entry.about).collect();
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
    let abouts: Vec<About> = CATALOGUE.iter().map(|entry| entry.about).collect();
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

#[derive(Serialize)]
struct ConstraintEntry<'a> {
    name: &'a str,
    title: &'a str,
    text: &'a str,
    condition: &'a str,
    settings: Vec<Setting<'a>>,
    form: &'a str,
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
    }
}

fn all_constraints(global: &Global) -> Result<bool> {
    let abouts: Vec<constraints::About> = constraints::CATALOGUE.iter().map(|about| about()).collect();
    if global.json {
        print_json(&abouts.iter().map(constraint_entry).collect::<Vec<_>>())?;
        return Ok(true);
    }
    let width = abouts.iter().map(|a| a.name.len()).max().unwrap_or(0);
    let lines: String = abouts.iter().map(|a| format!("{:width$}  {}\n", a.name, a.title)).collect();
    print(&(lines + "\nlacuna list constraints NAME explains one\n"))?;
    Ok(true)
}

fn one_constraint(name: &str, global: &Global) -> Result<bool> {
    let abouts: Vec<constraints::About> = constraints::CATALOGUE.iter().map(|about| about()).collect();
    let Some(about) = abouts.iter().find(|a| a.name == name) else {
        let known: Vec<&str> = abouts.iter().map(|a| a.name).collect();
        return Err(Error::new(format!("no constraint called `{name}`"))
            .help(format!("known are {}", known.join(", "))));
    };
    if global.json {
        print_json(&constraint_entry(about))?;
        return Ok(true);
    }
    let paragraph = |text: &str, indent: &str| -> String {
        lacuna::report::wrap(text, 78 - indent.len()).iter().map(|line| format!("{indent}{line}\n")).collect()
    };
    let mut text = format!("{}: {}\n\n{}\n", about.name, about.title, paragraph(about.text, ""));
    text += &paragraph(about.condition, "  ");
    text += "\nsettings\n";
    for (name, unit, meaning) in about.settings {
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        text += &format!("  {name}{unit}\n{}", paragraph(meaning, "      "));
    }
    text += &format!("\n{}", paragraph(&format!("form: {}", about.form), ""));
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
    })
}

fn all_engines(global: &Global) -> Result<bool> {
    let entries: Vec<EngineEntry> = catalogue::CATALOGUE.iter().map(engine_entry).collect::<Result<_>>()?;
    if global.json {
        print_json(&entries)?;
        return Ok(true);
    }
    let width = entries.iter().map(|e| e.name.len()).max().unwrap_or(0);
    let lines: String = entries.iter().map(|e| format!("{:width$}  {}\n", e.name, e.title)).collect();
    print(&(lines + "\nlacuna list engines NAME explains one\n"))?;
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
    let mut text = format!("{}: {}\n\n", entry.name, entry.title);
    for line in lacuna::report::wrap(entry.text, 78) {
        text += &format!("{line}\n");
    }
    text.push('\n');
    for line in lacuna::report::wrap(&format!("takes: {}", entry.takes), 78) {
        text += &format!("{line}\n");
    }
    if !entry.available {
        text += "not in this build\n";
    }
    text += "\nsettings, as they are when a scenario does not say otherwise\n";
    for setting in &entry.settings {
        let usual = if setting.usual == "None" { "not set" } else { &setting.usual };
        text += &format!("  {}: {usual}\n      {}\n", setting.name, setting.meaning);
    }
    text += &format!("\nin a scenario: engines: [{{\"{name}\": ()}}]\n");
    print(&text)?;
    Ok(true)
}
