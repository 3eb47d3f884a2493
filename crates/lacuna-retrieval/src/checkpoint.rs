//! Finished runs on disk, so that an interrupted search goes on to the same bits.

use std::fmt::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::Problem;
use lacuna_base::error::{Error, Result};
use lacuna_base::text;

/// Where an engine keeps its finished runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checkpoint {
    /// Folder; the file in it is named after the engine's label.
    pub folder: PathBuf,
    /// Whether to go on from what is there (nothing there: from the start). Else it is overwritten.
    pub resume: bool,
}

/// What one run found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The unknowns.
    pub z: Vec<f64>,
    /// Value of the objective.
    pub objective: f64,
    /// Largest scaled violation.
    pub violation: f64,
    /// Evaluations of objective or constraints.
    pub evaluations: u64,
}

/// What a checkpoint belongs to: it fits nothing else.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of this library; another one may find other bits.
    pub lacuna: String,
    /// Name of the engine.
    pub engine: String,
    /// Its settings, as RON.
    pub settings: String,
    /// Seed of the problem.
    pub seed: u64,
    /// Digest of objective, forms and bounds.
    pub problem: String,
}

/// Numbers as their bits: a decimal detour must not change the last one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Bits {
    run: usize,
    z: Vec<u64>,
    objective: u64,
    violation: u64,
    evaluations: u64,
}

#[derive(Debug, Serialize, Deserialize)]
struct Content {
    origin: Origin,
    runs: Vec<Bits>,
    /// Digest of the rest.
    digest: String,
}

impl Origin {
    /// Of an engine with these settings on a problem.
    pub fn new(engine: &str, settings: String, problem: &Problem) -> Self {
        Self {
            lacuna: env!("CARGO_PKG_VERSION").into(),
            engine: engine.into(),
            settings,
            seed: problem.seed,
            problem: digest(problem),
        }
    }

    /// Why a checkpoint of `other` does not fit, if it does not.
    fn conflict(&self, other: &Self) -> Option<String> {
        let differs = |what: &str, here: &dyn fmt::Display, there: &dyn fmt::Display| {
            Some(format!("it was made with {what} {there}, this is {what} {here}"))
        };
        if self.lacuna != other.lacuna {
            differs("version", &self.lacuna, &other.lacuna)
        } else if self.engine != other.engine {
            differs("engine", &self.engine, &other.engine)
        } else if self.seed != other.seed {
            differs("seed", &self.seed, &other.seed)
        } else if self.settings != other.settings {
            Some("it was made with other settings of the engine".into())
        } else {
            (self.problem != other.problem).then(|| "it belongs to another problem".into())
        }
    }
}

impl Checkpoint {
    /// The file of an engine with this label.
    pub fn file(&self, label: &str) -> PathBuf {
        let mut name = String::new();
        for byte in label.bytes() {
            if byte.is_ascii_alphanumeric() || b"._-".contains(&byte) {
                name.push(char::from(byte));
            } else {
                // Writing to a string cannot fail.
                let _ = write!(name, "%{byte:02x}");
            }
        }
        self.folder.join(format!("{name}.checkpoint.json"))
    }

    /// Reads the finished runs of an earlier attempt, each with its number; none when there is no file or
    /// nothing is to be resumed.
    ///
    /// # Errors
    /// When the file is damaged or belongs to something else.
    pub fn load(&self, label: &str, origin: &Origin) -> Result<Vec<(usize, Outcome)>> {
        let path = self.file(label);
        if !self.resume || !path.is_file() {
            return Ok(Vec::new());
        }
        let again = "start without resuming, or give the folder that belongs to this study";
        let content: Content = parse(&text::read(&path)?, &path)?;
        if content.digest != seal(&content.origin, &content.runs) {
            return Err(Error::new("the checkpoint is damaged: its digest does not fit")
                .in_file(&path)
                .help(again));
        }
        if let Some(conflict) = origin.conflict(&content.origin) {
            return Err(Error::new(format!("the checkpoint does not fit: {conflict}"))
                .in_file(&path)
                .help(again));
        }
        Ok(content.runs.into_iter().map(|bits| (bits.run, bits.outcome())).collect())
    }

    /// Writes finished runs, whole or not at all.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn save(&self, label: &str, origin: &Origin, runs: &[Option<Outcome>]) -> Result<()> {
        let bits = |(run, outcome): (usize, &Option<Outcome>)| outcome.as_ref().map(|o| Bits::new(run, o));
        let runs: Vec<Bits> = runs.iter().enumerate().filter_map(bits).collect();
        let digest = seal(origin, &runs);
        let content = Content { origin: origin.clone(), runs, digest };
        let json = serde_json::to_vec(&content)
            .map_err(|e| Error::new(format!("cannot write the checkpoint: {e}")))?;
        text::write_whole(&self.file(label), &json)
    }

    /// Removes the file of an engine whose work is done, if there is one.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn discard(&self, label: &str) -> Result<()> {
        let path = self.file(label);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::new(format!("cannot remove the checkpoint: {e}")).in_file(&path))
            }
            _ => Ok(()),
        }
    }
}

fn parse(text: &str, path: &Path) -> Result<Content> {
    serde_json::from_str(text).map_err(|e| {
        Error::new(format!("the checkpoint is damaged: {e}"))
            .in_file(path)
            .at(e.line(), e.column())
            .help("start without resuming")
    })
}

impl Bits {
    fn new(run: usize, outcome: &Outcome) -> Self {
        Self {
            run,
            z: outcome.z.iter().map(|v| v.to_bits()).collect(),
            objective: outcome.objective.to_bits(),
            violation: outcome.violation.to_bits(),
            evaluations: outcome.evaluations,
        }
    }

    fn outcome(self) -> Outcome {
        Outcome {
            z: self.z.into_iter().map(f64::from_bits).collect(),
            objective: f64::from_bits(self.objective),
            violation: f64::from_bits(self.violation),
            evaluations: self.evaluations,
        }
    }
}

fn seal(origin: &Origin, runs: &[Bits]) -> String {
    let mut hash = Fnv::new();
    // Hashing cannot fail.
    let _ = write!(hash, "{origin:?}{runs:?}");
    hash.text()
}

/// Digest of everything that decides what a search finds, from its debug text: numbers appear there with
/// all their digits, plug-ins with all their fields.
fn digest(problem: &Problem) -> String {
    let mut hash = Fnv::new();
    let _ = write!(hash, "{problem:?}");
    hash.text()
}

/// The 64-bit hash of Fowler, Noll and Vo (variant 1a): guards against mistakes, not against forgers.
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn text(&self) -> String {
        format!("{:016x}", self.0)
    }
}

impl Write for Fnv {
    fn write_str(&mut self, s: &str) -> fmt::Result {
        for byte in s.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::penalty::testing;

    fn runs() -> Vec<Option<Outcome>> {
        let outcome =
            |x: f64| Outcome { z: vec![x, -0.0, 1.0 / 3.0], objective: x, violation: 0.0, evaluations: 7 };
        vec![Some(outcome(0.1)), None, Some(outcome(1e-300))]
    }

    #[test]
    fn what_is_written_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let checkpoint = Checkpoint { folder: folder.path().into(), resume: true };
        let origin = Origin::new("penalty", "()".into(), &testing::disc());
        assert!(checkpoint.load("a", &origin).expect("nothing there is fine").is_empty());
        checkpoint.save("a", &origin, &runs()).expect("saves");
        let back = checkpoint.load("a", &origin).expect("loads");
        assert_eq!(back.iter().map(|(run, _)| *run).collect::<Vec<_>>(), [0, 2]);
        for (run, outcome) in back {
            assert_eq!(format!("{:?}", Some(outcome)), format!("{:?}", runs()[run]));
        }
    }

    #[test]
    fn damaged_and_foreign_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let checkpoint = Checkpoint { folder: folder.path().into(), resume: true };
        let problem = testing::disc();
        let origin = Origin::new("penalty", "()".into(), &problem);
        checkpoint.save("a/b", &origin, &runs()).expect("saves");
        let file = checkpoint.file("a/b");
        assert_eq!(file.file_name().and_then(|n| n.to_str()), Some("a%2fb.checkpoint.json"));
        let refused =
            |origin: &Origin| checkpoint.load("a/b", origin).expect_err("refused").message().to_string();
        let seed = Origin { seed: 2, ..origin.clone() };
        assert!(refused(&seed).contains("seed 1, this is seed 2"), "{}", refused(&seed));
        let mut other = testing::disc();
        other.forms.pop();
        assert!(refused(&Origin::new("penalty", "()".into(), &other)).contains("another problem"));
        let text = std::fs::read_to_string(&file).expect("reads");
        std::fs::write(&file, text.replace("\"run\":2", "\"run\":1")).expect("writes");
        assert!(refused(&origin).contains("digest"));
        std::fs::write(&file, &text[..text.len() / 2]).expect("writes");
        assert!(refused(&origin).contains("damaged"));
    }
}
