use std::path::Path;

use lacuna::check::{Kind, misplaced};
use lacuna::simulate::{self, Recorded};
use lacuna::{Error, Result};
use serde::Serialize;

use super::console::Console;
use super::{Global, claim, elsewhere, print, print_json};

/// What `--json` prints.
#[derive(Serialize)]
struct Summary<'a> {
    lacuna: &'static str,
    seed: u64,
    logs: &'a [Recorded],
}

/// `lacuna simulate FILE.ron --out DIR`.
pub(super) fn run(file: &Path, global: &Global, console: &Console) -> Result<bool> {
    let Some(out) = &global.out else {
        return Err(Error::new("--out is missing").help("name a folder for the logs: --out DIR"));
    };
    let of_file = |e: Error| misplaced(e, file, &[Kind::Experiment]);
    let output = claim(out, "simulate", &simulate::files(file).map_err(of_file)?)?;
    console.say("simulating");
    let outcome = simulate::run(file, global.seed).map_err(of_file)?;
    let logs = outcome.write_to(&output).map_err(elsewhere)?;
    console.clear();
    if global.json {
        print_json(&Summary {
            lacuna: env!("CARGO_PKG_VERSION"),
            seed: outcome.experiment.seed,
            logs: &logs,
        })?;
        return Ok(true);
    }
    let list =
        |x: &[f64], digits: usize| x.iter().map(|x| format!("{x:.digits$}")).collect::<Vec<_>>().join("  ");
    let mut text = String::new();
    for log in &logs {
        let milliradians: Vec<f64> = log.tracking_rms.iter().map(|x| 1e3 * x).collect();
        text += &format!("{}\n", log.file.display());
        text += &format!("  {} rows over {:.3} s\n", log.rows, log.duration_s);
        text += &format!("  torque rms [N m, N]      {}\n", list(&log.torque_rms, 3));
        text += &format!("  tracking rms [mrad, mm]  {}\n", list(&milliradians, 2));
    }
    print(&text)?;
    Ok(true)
}
