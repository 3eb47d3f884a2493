//! A folder to work in, and the program run in it as a person runs it.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

/// A plane arm of two links; Denavit-Hartenberg, joints `joint1` and `joint2`.
pub const ARM: &str = "(
    name: \"arm\",
    convention: Standard,
    gravity: (0.0, -9.81, 0.0),
    rows: [
        (a: 0.5, alpha: 0.0, d: 0.0, theta: 0.0, inertia: (mass: 2.0, com: (-0.2, 0.0, 0.0),
            tensor: (xx: 0.01, xy: 0.0, xz: 0.0, yy: 0.02, yz: 0.0, zz: 0.02))),
        (a: 0.4, alpha: 0.0, d: 0.0, theta: 0.0, inertia: (mass: 1.0, com: (-0.1, 0.0, 0.0),
            tensor: (xx: 0.01, xy: 0.0, xz: 0.0, yy: 0.02, yz: 0.0, zz: 0.02))),
    ],
)
";

/// The motion that scenarios of these tests are simulated with.
pub const SIMULATED: &str =
    "Simulated((motion: Random(harmonics: 3, period_s: 2.0, amplitude: 0.5), duration_s: 6.0))";

pub struct Folder(TempDir);

pub struct Answer {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Folder {
    /// Holds `arm.ron`, `good.ron` (a simulated scenario), `files.ron` (one that takes logs), `model.ron`
    /// of that arm, a log `log.csv` and states `states.csv`.
    pub fn new() -> Self {
        let folder = Self(TempDir::new().expect("a temporary folder"));
        folder.write("arm.ron", ARM);
        folder.write("good.ron", format!("(robot: \"arm.ron\", logs: {SIMULATED})"));
        folder.write("files.ron", "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"]))");
        folder.write("model.ron", MODEL);
        let rows = |k: i32| {
            let (t, w) = (0.01 * f64::from(k), 0.03 * f64::from(k));
            format!("{t},{},{},{},{}\n", w.sin(), (0.7 * w).cos(), (1.3 * w).sin() + 2.0, w.cos())
        };
        folder.write("log.csv", format!("{LOG_HEADER}{}", (0..600).map(rows).collect::<String>()));
        folder.write("states.csv", format!("{STATES_HEADER}0.1,0.2,0.3,0.4,0.5,0.6\n"));
        folder
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: impl AsRef<Path>, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("temporary files can be written");
    }

    pub fn command(&self, arguments: &[impl AsRef<OsStr>]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.args(arguments).current_dir(self.0.path()).env_remove("LACUNA_DATA").stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[impl AsRef<OsStr>]) -> Answer {
        let output = self.command(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Answer { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// The paths of all files below.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        let (mut found, mut open) = (BTreeSet::new(), vec![self.0.path().to_path_buf()]);
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(folder).expect("temporary folders read") {
                let path = entry.expect("entries read").path();
                if path.is_dir() {
                    open.push(path.clone());
                }
                found.insert(path);
            }
        }
        found
    }

    /// Runs what must be refused: exit code 2, nothing on stdout, no file made, and a message at `place`
    /// with these words and a remedy.
    #[track_caller]
    pub fn refused(&self, arguments: &[&str], place: &str, words: &[&str]) {
        let before = self.files();
        let answer = self.run(arguments);
        let said = format!("{arguments:?} ({:?}): {}", answer.code, answer.err);
        assert_eq!(answer.code, Some(2), "{said}");
        assert_eq!(answer.out, "", "stdout: {said}");
        assert_eq!(self.files(), before, "files: {said}");
        let error = answer.err.lines().position(|line| line.starts_with("error: "));
        let error = answer.err.lines().skip(error.expect(&said)).collect::<Vec<_>>().join("\n");
        assert!(error.starts_with(&format!("error: {place}")), "not at {place}: {said}");
        for word in words.iter().chain(&["\n  help: "]) {
            assert!(error.contains(word), "`{word}` is not in: {said}");
        }
        assert!(error.len() < 1200, "too long: {said}");
    }
}

pub const LOG_HEADER: &str = "t,q1,q2,tau1,tau2\n";
pub const STATES_HEADER: &str = "q1,q2,dq1,dq2,ddq1,ddq2\n";

pub const MODEL: &str = "(
    lacuna: \"0.1.0\",
    robot: \"arm\",
    origin: \"by hand\",
    signals: (band_hz: 5.0),
    effects: [{\"torque_offset\": (joints: All)}, {\"viscous_friction\": (joints: Only([\"joint2\"]))}],
    parameters: [
        (symbol: \"fo1\", value: 1.0, unit: \"N m\"),
        (symbol: \"fo2\", value: 0.5, unit: \"N m\"),
        (symbol: \"fv2\", value: 0.1, unit: \"N m s/rad\"),
    ],
)
";
