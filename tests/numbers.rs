//! Every number that an input can state, taken through values that are none or too small or too large: nothing
//! panics, no memory follows from a number alone, nothing hangs, and what is refused is refused with its place.
//!
//! Numbers are found by themselves: whole examples of every type of input are written out with all their fields,
//! and every number in the text is replaced in turn.

#[path = "numbers/inputs.rs"]
mod inputs;
#[path = "numbers/plugins.rs"]
mod plugins;
#[path = "numbers/walk.rs"]
mod walk;

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use walk::Input;

/// Memory that the walk may take, its program and threads included [KiB].
const MEMORY: &str = "2000000";
/// Longest that one number may take \[s\], on a machine that is busy with other things.
const LONGEST: Duration = Duration::from_secs(20);

fn all() -> Vec<Input> {
    [inputs::all(), plugins::all()].into_iter().flatten().collect()
}

/// Runs the walk in a process of its own, whose memory is limited: what asks for more ends there and not here.
#[test]
#[cfg(target_os = "linux")]
fn no_number_of_any_input_panics_hangs_or_takes_the_memory() {
    let own = std::env::current_exe().expect("this test is a file");
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\" 2>&1")])
        .arg(own)
        .args(["--exact", "the_walk_itself", "--ignored", "--nocapture", "--test-threads", "1"])
        .env("RAYON_NUM_THREADS", "2")
        .stdout(Stdio::piped())
        .spawn()
        .expect("sh runs");
    let (tell, told) = mpsc::channel();
    let lines = BufReader::new(child.stdout.take().expect("piped"));
    let reader = std::thread::spawn(move || {
        lines.lines().map_while(Result::ok).try_for_each(|line| tell.send(line)).ok();
    });
    let (mut last, mut broken) = (String::new(), Vec::new());
    loop {
        match told.recv_timeout(LONGEST) {
            Ok(line) if line.starts_with("at ") => last = line,
            Ok(line) => broken.push(line),
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => {
                child.kill().expect("it is ours");
                child.wait().expect("it ends");
                panic!("over {LONGEST:?}: {last}\n{}", broken.join("\n"));
            }
        }
    }
    reader.join().expect("the reader ends");
    let status = child.wait().expect("it ends");
    let told = broken.join("\n");
    assert!(status.success(), "{status}, last {last}\n{told}");
    println!("{told}");
}

#[test]
#[ignore = "run by the test above, in a process whose memory is limited"]
fn the_walk_itself() {
    let broken: Vec<String> = all().iter().flat_map(walk::walk).collect();
    assert!(broken.is_empty(), "{} broken\n{}", broken.len(), broken.join("\n"));
}

/// A plug-in that is not walked through is one that nobody looked at.
#[test]
fn every_plug_in_has_an_example() {
    let all = all();
    for (room, known) in [
        ("effects", plugins::names_in("crates/lacuna/src/effects")),
        ("plant", plugins::names_in("crates/lacuna-plant/src")),
        ("constraints", plugins::names_in("crates/lacuna/src/constraints")),
        ("retrieval", plugins::names_in("crates/lacuna-retrieval/src")),
    ] {
        assert!(known.len() >= 4, "{room}: {known:?}");
        for name in known {
            let has = |input: &&Input| input.room == room && input.text.contains(&format!("\"{name}\""));
            assert!(all.iter().any(|input| has(&input)), "{room}: {name} has no example");
        }
    }
}

/// The numbers of the command line: every one ends with an exit code, none with a signal.
#[test]
fn numbers_on_the_command_line_end_with_an_exit_code() {
    let commands: [&[&str]; 7] = [
        &["check", "robots/two_link.ron", "--gravity=0,0,X"],
        &["check", "robots/two_link.ron", "--jobs=X"],
        &["scenario", "nothing.ron", "--seed=X"],
        &["benchmark", "--part", "nothing_here", "--rounds=X"],
        &["diagnose", "--robot", "robots/two_link.ron", "--data", "nothing.csv", "--band=X"],
        &["diagnose", "--robot", "robots/two_link.ron", "--data", "nothing.csv", "--nested=X"],
        &["workbench", "nothing.ron", "--port=X"],
    ];
    for command in commands {
        for value in walk::VALUES {
            let arguments: Vec<String> = command.iter().map(|a| a.replace('X', value)).collect();
            let done = Command::new(env!("CARGO_BIN_EXE_lacuna"))
                .args(&arguments)
                .current_dir(env!("CARGO_MANIFEST_DIR"))
                .stdin(Stdio::null())
                .output()
                .expect("the program runs");
            let message = String::from_utf8_lossy(&done.stderr).into_owned();
            assert!(matches!(done.status.code(), Some(0..=2)), "{arguments:?}: {} {message}", done.status);
            assert!(done.status.success() || !message.contains("panicked"), "{arguments:?}: {message}");
        }
    }
}
