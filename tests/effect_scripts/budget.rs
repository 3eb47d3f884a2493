//! What scripts of effects may use up with data.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use lacuna::check;
use lacuna::effects::Effect;

use super::{columns, motion, one, robot};

/// Columns that take some hundred thousand steps for a handful of samples.
const SLOW: &str = "let s = 0.0;\nfor i in 0..30000 { s += sin(now.q * i); }\n[s]";

fn log(folder: &Path, rows: usize) -> PathBuf {
    let mut text = String::from("t,q1,q2,dq1,dq2,tau1,tau2\n");
    for k in 0..rows {
        let t = 0.005 * k as f64;
        let (a, b) = (0.7 * t, 1.3 * t);
        let tau = 9.0 * (a.sin() + 0.3 * b.cos());
        let _ = writeln!(
            text,
            "{t:.3},{:.6},{:.6},{:.6},{:.6},{tau:.5},{:.5}",
            a.sin(),
            b.cos(),
            0.7 * a.cos(),
            -1.3 * b.sin(),
            0.4 * tau
        );
    }
    let file = folder.join("log.csv");
    std::fs::write(&file, text).expect("writes");
    file
}

#[test]
fn the_time_of_a_script_counts_at_the_samples_too() {
    let written = format!(
        r#"{{"script": (path: "slow.rhai", seconds: 2.0, text: {:?})}}"#,
        one(&SLOW.replace("30000", "5000"))
    );
    let effect: Box<dyn Effect> = lacuna::text::from_ron(&written).expect("reads");
    let (arm, run) = (robot("two_link.ron"), motion(60_000));
    let error = columns(effect.as_ref(), &arm, &run, 400).expect_err("takes minutes");
    let told = error.to_string();
    assert!(told.contains("more than 2 s") && told.contains("slow.rhai:2:4"), "{told}");
    assert!(told.contains("`columns`") && told.contains("help: ") && told.contains("`seconds`"), "{told}");
    let again = columns(effect.boxed().as_ref(), &arm, &motion(1), 1).expect_err("nothing is left");
    assert!(again.to_string().contains("more than 2 s"), "{again}");
}

#[test]
fn a_check_of_a_slow_script_on_a_log_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("slow.rhai");
    std::fs::write(&script, one(SLOW)).expect("writes");
    let options = check::Options {
        robot: Some("robots/two_link.ron".into()),
        data: Some(log(folder.path(), 60_000)),
        ..check::Options::default()
    };
    let report = check::file(&script, &options);
    let told = report.text();
    assert!(told.contains("more than 10 s") && told.contains("slow.rhai:2:4"), "{told}");
}

#[test]
fn a_memory_that_does_not_fit_is_refused_before_it_is_filled() {
    let names: Vec<String> = (0..400).map(|k| format!("m{k}: 0.0")).collect();
    let kept: Vec<String> = (0..400).map(|k| format!("m{k}: now.q")).collect();
    let text = one("[memory.m0]")
        .replace("parameters:", &format!("memory: #{{ {} }}, parameters:", names.join(", ")))
        + format!("\nfn remember(joint, now, memory, with) {{ #{{ {} }} }}", kept.join(", ")).as_str();
    let effect = super::scripted(&text).expect("reads");
    let arm = robot("two_link.ron");
    assert!(columns(&effect, &arm, &motion(1000), 1000).is_ok());
    let error = columns(&effect, &arm, &motion(100_000), 100).expect_err("320 MB").to_string();
    assert!(error.contains("more than 256 MB") && error.contains("400 numbers"), "{error}");
    assert!(error.contains("test.rhai:5:4") && error.contains("help:"), "{error}");
}
