//! Flags that every command takes, offered only where they do something; elsewhere they are taken, and said to do
//! nothing.

use std::path::PathBuf;

use clap::{Arg, ArgAction, Command, value_parser};

use super::{Global, say};

/// Heading of these flags in help texts.
pub(super) const HEADING: &str = "Common options";

/// Flags that do nothing, command by command.
const IDLE: [(&str, &[&str]); 10] = [
    ("scenario", &[]),
    ("compare", &["seed", "out", "resume"]),
    ("benchmark", &[]),
    ("check", &["seed", "out", "resume"]),
    ("diagnose", &["resume"]),
    ("list", &["seed", "jobs", "out", "resume"]),
    ("export", &["seed", "jobs", "resume"]),
    ("dynamics", &["json", "seed", "jobs", "out", "resume"]),
    ("workbench", &[]),
    ("simulate", &["resume"]),
];

/// What `--out` and `--seed` mean where they mean something else than usual.
const OWN: [(&str, &str, &str); 9] = [
    ("scenario", "out", "Folder for results [default: out/<name of the scenario>]"),
    ("diagnose", "out", "Folder for diagnosis.json, report.html and model.ron; none is written without it"),
    ("diagnose", "seed", "Seed of the sign flips that calibrate the threshold, instead of the scenario's"),
    ("benchmark", "out", "Folder for benchmark.json, written after every data set"),
    ("export", "out", "File to write, or a folder for a file named after the robot; stdout without it"),
    ("workbench", "json", "Print the address and the study's folder as one JSON document"),
    ("workbench", "out", "Folder of the study [default: out/workbench/<name of scenario or log>]"),
    ("workbench", "resume", "Folder of an earlier study, to go on with it"),
    ("simulate", "out", "Folder for the logs; must be given"),
];

/// The command line with these flags hidden where they do nothing and described where they are special.
pub(super) fn adjust(mut command: Command) -> Command {
    for (name, idle) in IDLE {
        let hide = idle.iter().map(|flag| plain(flag).hide(true));
        let own = OWN.iter().filter(|(of, ..)| *of == name);
        let own = own.map(|(_, flag, help)| plain(flag).help(*help).help_heading(HEADING));
        let args: Vec<Arg> = hide.chain(own).collect();
        command = command.mut_subcommand(name, |c| c.args(args));
    }
    command
}

/// The flag as [`Global`] has it; clap keeps a command's own one of the same name.
fn plain(flag: &&'static str) -> Arg {
    let arg = Arg::new(*flag).long(*flag).global(true);
    match *flag {
        "json" => arg.action(ArgAction::SetTrue),
        "seed" => arg.value_name("N").value_parser(value_parser!(u64)),
        "jobs" => arg.value_name("N").value_parser(value_parser!(u16).range(1..=1024)),
        _ => arg.value_name("DIR").value_parser(value_parser!(PathBuf)),
    }
}

/// Says which of the given flags do nothing for this command.
pub(super) fn note_idle(name: &str, global: &Global) {
    let given = [
        ("seed", global.seed.is_some(), "draws no random numbers"),
        ("jobs", global.jobs.is_some(), "works on one thread"),
        ("out", global.out.is_some(), "writes no files: redirect what it prints"),
    ];
    let idle = IDLE.iter().find(|(of, _)| *of == name).map_or(&[][..], |(_, idle)| idle);
    for (flag, given, why) in given {
        if given && idle.contains(&flag) && !global.quiet {
            say(&format!("note: --{flag} does nothing here: `{name}` {why}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::Arguments;
    use super::*;

    #[test]
    fn every_command_is_listed_and_the_whole_is_consistent() {
        let mut command = adjust(Arguments::command());
        command.build();
        command.clone().debug_assert();
        let names: Vec<&str> =
            command.get_subcommands().map(Command::get_name).filter(|n| *n != "help").collect();
        for name in &names {
            assert!(IDLE.iter().any(|(of, _)| of == name), "{name} is not listed");
        }
        assert_eq!(names.len(), IDLE.len());
    }
}
