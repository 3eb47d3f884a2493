use std::time::Instant;

use lacuna::benchmark::{Item, PARTS, Part, Record, Table, plan, run, seed_of_commit, tables};
use lacuna::{Error, Result, text};
use serde::Serialize;

use super::console::Console;
use super::interrupt::Interrupt;
use super::{Global, claim, elsewhere, json, print, print_json};

/// What has been examined so far.
const RECORD: &str = "benchmark.json";

/// Flags of `lacuna benchmark`.
#[derive(Debug, clap::Args)]
pub(super) struct Benchmark {
    /// Part: nothing, strong, even, weak, pairs, contact, outside, or small; repeat the flag for several.
    #[arg(long, value_name = "NAME", default_values_t = [String::from("small")])]
    part: Vec<String>,
    /// Rounds of each part, instead of those of a full run.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    rounds: Option<u16>,
    /// Hash of the commit that is examined: the seed of all draws comes from it.
    #[arg(long, value_name = "HASH", conflicts_with = "seed")]
    commit: Option<String>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Summary<'a> {
    lacuna: &'static str,
    seed: u64,
    tables: Vec<Table>,
    record: &'a Record,
}

impl Benchmark {
    pub(super) fn run(&self, global: &Global, console: &Console) -> Result<bool> {
        let seed = match &self.commit {
            Some(hash) => seed_of_commit(hash)?,
            None => global.seed.unwrap_or(1),
        };
        let items = self.items(seed)?;
        // What is done stands in the folder, so it ends at once.
        Interrupt::install(global.quiet)?;
        let out = global.out.as_deref().or(global.resume.as_deref());
        let output = out.map(|out| claim(out, "benchmark", &[RECORD])).transpose()?;
        let mut record = match &global.resume {
            Some(folder) => Record::open(&folder.join(RECORD), seed)?,
            None => Record::new(seed),
        };
        let (start, known) = (Instant::now(), record.sets.len());
        console.say(&format!("examining {} data sets", items.len()));
        run(&items, &mut record, &mut |record, left| {
            let done = record.sets.len() - known;
            let each = start.elapsed().as_secs_f64() / done.max(1) as f64;
            console
                .say(&format!("{done} data sets examined, {left} left, about {:.0} s", each * left as f64));
            match &output {
                Some(output) => output.write(RECORD, (json(record)? + "\n").as_bytes()).map_err(elsewhere),
                None => Ok(()),
            }
        })?;
        console.clear();
        self.tell(&record, global)?;
        Ok(true)
    }

    fn items(&self, seed: u64) -> Result<Vec<Item>> {
        let mut items = Vec::new();
        for name in &self.part {
            let part = Part::named(name).ok_or_else(|| {
                let help = text::suggestion(name, PARTS.iter().map(|(_, name, _)| *name));
                Error::new(format!("--part: no part called `{name}`")).help(help)
            })?;
            items.extend(plan(part, self.rounds.map_or(part.rounds(), usize::from), seed));
        }
        Ok(items)
    }

    fn tell(&self, record: &Record, global: &Global) -> Result<()> {
        let tables = tables(&record.sets);
        if global.json {
            return print_json(&Summary {
                lacuna: env!("CARGO_PKG_VERSION"),
                seed: record.seed,
                tables,
                record,
            });
        }
        let mut all = format!("seed {}; which answers count: src/benchmark/answers.ron\n\n", record.seed);
        for table in &tables {
            all += &table.text();
        }
        for set in &record.sets {
            all += &line(set);
        }
        print(&all)
    }
}

/// One line for one data set: what was hidden, what was said.
fn line(set: &lacuna::benchmark::Examination) -> String {
    let hidden = if set.wanted.is_empty() { "nothing".to_string() } else { set.wanted.join(" + ") };
    let Some(mark) = &set.mark else {
        let reason = set.excluded.as_deref().unwrap_or("");
        return format!("{} {:>3}  {hidden}\n    excluded: {reason}\n", set.part, set.number);
    };
    let said = |a: &lacuna::benchmark::Answer| {
        let joint = a.joint.as_deref().map_or_else(String::new, |j| format!(" {j}"));
        let on =
            if a.depends_on.is_empty() { String::new() } else { format!(" ({})", a.depends_on.join(", ")) };
        format!("{}{}{joint}{on}", if a.right { "" } else { "? " }, a.effect)
    };
    let answers: Vec<String> = mark.answers.iter().map(said).collect();
    let errors = if mark.before.is_finite() {
        format!("  {:.2} -> {:.3}", mark.before, mark.after)
    } else {
        String::new()
    };
    let answers = if answers.is_empty() { "-".to_string() } else { answers.join("; ") };
    format!("{} {:>3}  {hidden}\n    {answers}{errors}\n", set.part, set.number)
}
