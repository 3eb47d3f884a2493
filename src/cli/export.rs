use std::path::{Path, PathBuf};

use lacuna::export::{Exported, Parameters, json, mjcf, urdf};
use lacuna::model_file::ModelFile;
use lacuna::robot::Robot;
use lacuna::text::{read, write_whole};
use lacuna::{Error, Result};
use serde::Serialize;

use super::{Global, open_model, open_robot, print_document, print_json, say};

/// Arguments of `lacuna export`.
#[derive(Debug, clap::Args)]
pub(super) struct Export {
    /// Model file (RON) with all link parameters, as a retrieval writes it.
    model: PathBuf,
    /// What to write; to stdout, or to the file that --out names.
    #[arg(long, value_enum)]
    format: Format,
    /// Robot file: URDF, or a Denavit-Hartenberg table in RON. When not given, one with the model's robot
    /// name is looked for beside the model and in `robots`.
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<String>,
    /// Write parameters that no body can have, too.
    #[arg(long)]
    force: bool,
}

/// Formats that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Unified Robot Description Format; in the frames of the original file when there was one.
    Urdf,
    /// MuJoCo's model format.
    Mjcf,
    /// Links, kinematics and every other parameter as JSON.
    Json,
}

/// The answer with `--json` for formats that are not JSON themselves.
#[derive(Serialize)]
struct Wrapped<'a> {
    format: &'static str,
    text: &'a str,
    notes: &'a [String],
}

impl Export {
    pub(super) fn run(self, global: &Global) -> Result<bool> {
        let file = open_model(&self.model)?;
        let robot_path = self.robot.clone().map_or_else(|| find_robot(&self.model, &file.robot), Ok)?;
        let robot = open_robot(&robot_path, self.gravity.as_deref())?;
        let parameters = Parameters::read(&file, &robot).map_err(|e| e.in_file(&self.model))?;
        let doubts = parameters.doubts(&robot);
        if !doubts.is_empty() && !self.force {
            say(&refusal(&self.model, &parameters, &doubts));
            return Ok(false);
        }
        let mut exported = self.document(&file, &robot_path, &robot, &parameters)?;
        exported.notes.extend(doubts.into_iter().map(|d| format!("not physical: {d}")));
        if file.robot != robot.name {
            exported.notes.push(format!("the model is of `{}`, the robot is `{}`", file.robot, robot.name));
        }
        self.deliver(&exported, &robot, global)?;
        Ok(true)
    }

    fn document(
        &self,
        file: &ModelFile,
        robot_path: &Path,
        robot: &Robot,
        parameters: &Parameters,
    ) -> Result<Exported> {
        match self.format {
            Format::Mjcf => mjcf(robot, parameters),
            Format::Json => json(robot, parameters, file),
            Format::Urdf => {
                let is_table = robot_path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"));
                let original = if is_table { None } else { Some(read(robot_path)?) };
                urdf(robot, parameters, original.as_deref()).map_err(|e| e.in_file(robot_path))
            }
        }
    }

    fn deliver(&self, exported: &Exported, robot: &Robot, global: &Global) -> Result<()> {
        if !global.quiet {
            exported.notes.iter().for_each(|note| say(&format!("note: {note}")));
        }
        let (format, ending) = match self.format {
            Format::Urdf => ("urdf", "urdf"),
            Format::Mjcf => ("mjcf", "xml"),
            Format::Json => ("json", "json"),
        };
        if let Some(out) = &global.out {
            let is_folder = out.is_dir();
            let path =
                if is_folder { out.join(format!("{}.{ending}", plain(&robot.name))) } else { out.clone() };
            may_replace(&path)?;
            write_whole(&path, exported.text.as_bytes())?;
            if !global.quiet {
                say(&format!("wrote {}", path.display()));
            }
            return Ok(());
        }
        if global.json && self.format != Format::Json {
            return print_json(&Wrapped { format, text: &exported.text, notes: &exported.notes });
        }
        print_document(&exported.text)
    }
}

/// A name as that of a file: a robot's name comes from a file and is no path.
fn plain(name: &str) -> String {
    let fine = |c: char| if c.is_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
    let name: String = name.chars().map(fine).take(100).collect();
    let name = name.trim_matches(['.', ' ']);
    if name.is_empty() { "robot".to_string() } else { name.to_string() }
}

/// An earlier export may be replaced, and an empty file; whatever else lies there is the user's.
///
/// # Errors
/// When it is.
fn may_replace(path: &Path) -> Result<()> {
    let ours = |text: &str| {
        text.trim().is_empty() || ["by lacuna ", "\"lacuna\":"].iter().any(|mark| text.contains(mark))
    };
    if !path.exists() || read(path).is_ok_and(|text| ours(&text)) {
        return Ok(());
    }
    Err(Error::new("a file lies here that no export has written")
        .in_file(path)
        .help("name another file with --out, or move this one away"))
}

fn refusal(model: &Path, parameters: &Parameters, doubts: &[String]) -> String {
    let mut text = format!("{}: the parameters are not physical, so nothing is written", model.display());
    for doubt in doubts {
        text += &format!("\n  {doubt}");
    }
    let help = parameters.explanation();
    let help = help.unwrap_or_else(|| "retrieve feasible parameters first".to_string());
    format!("{text}\n  help: {help}; or write them all the same with --force")
}

/// A robot file with the model's robot name.
fn find_robot(model: &Path, name: &str) -> Result<PathBuf> {
    let folders = [model.parent().unwrap_or(Path::new("")), Path::new("robots")];
    // A name is not a path: one with separators in it names no file here.
    let plain = !name.contains(['/', '\\']) && !name.is_empty();
    let files = folders.iter().flat_map(|f| ["urdf", "ron"].map(|ending| f.join(format!("{name}.{ending}"))));
    files.filter(|_| plain).find(|f| f.is_file()).ok_or_else(|| {
        Error::new(format!("no robot file called `{name}` beside the model or in `robots`"))
            .in_file(model)
            .help("give it with --robot FILE")
    })
}
