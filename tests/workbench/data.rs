//! A folder with a robot and logs that hide a spring.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder for one test.
pub struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::copy("robots/two_link.ron", folder.path().join("two_link.ron")).expect("copies");
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).expect("reads")
    }

    /// Names of the files in a folder.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).expect("a folder");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    /// What is put down for a while and should be gone.
    pub fn half_done(&self, folder: &str) -> Vec<String> {
        let kept = [".lacuna.json", ".lacuna.lock"];
        let half = |name: &String| name.ends_with(".partial") || name.starts_with('.');
        self.names(folder).into_iter().filter(|n| half(n) && !kept.contains(&n.as_str())).collect()
    }

    /// Logs of the two-link robot with a spring on its first joint: two rounds of a motion, and another one.
    pub fn simulate(&self) {
        let log = |name: &str, a: &str, b: &str| {
            format!(
                "(name: \"{name}\", duration_s: 20.0, motion: Fourier((period_s: 10.0, a: {a}, b: {b}, q0: [-0.4, 0.3])))"
            )
        };
        let text = format!(
            "(robot: \"two_link.ron\", seed: 3, logs: [{}, {}], effects: [\
             {{\"viscous_friction\": (coefficients: [0.4, 0.3])}}, \
             {{\"joint_spring\": (stiffness: [1.5, 0.0], rest: [0.2, 0.0])}}], \
             sensors: (sampling_time_s: 0.005, torque_noise: [0.1]))",
            log("fit", "[[0.5, 0.3], [-0.6, 0.8], [0.7, -0.5]]", "[[0.4, -0.7], [0.5, 0.4], [-0.3, 0.6]]"),
            log("check", "[[-0.4, 0.5], [0.5, 0.6]]", "[[0.6, 0.3], [-0.5, 0.7]]")
        );
        std::fs::write(self.path("plant.ron"), text).expect("writes");
        self.run(&["simulate", "plant.ron", "--out", "logs"]);
        assert!(Path::new(&self.path("logs/fit.csv.gz")).is_file());
    }

    /// Exit code and words of a command that cannot be done.
    pub fn fail(&self, args: &[&str]) -> (Option<i32>, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        let output = command.current_dir(self.folder.path()).args(args).output().expect("runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    }

    /// Runs the command line in the folder; answers what it prints.
    pub fn run(&self, args: &[&str]) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        let output = command.current_dir(self.folder.path()).args(args).output().expect("runs");
        assert!(output.status.code() != Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}
