use std::fs;

use super::*;

fn said(result: Result<impl Sized>) -> String {
    result.map(|_| ()).expect_err("is refused").to_string()
}

#[test]
fn a_folder_with_something_of_somebody_else_is_refused_and_left_alone() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("thesis");
    fs::create_dir(&folder).expect("makes");
    fs::write(folder.join("model.ron"), "mine").expect("writes");
    assert!(said(Output::claim(&folder, "scenario")).contains("`model.ron`"));
    assert_eq!(fs::read_dir(&folder).expect("reads").count(), 1, "nothing is added");
    fs::remove_file(folder.join("model.ron")).expect("removes");
    assert!(Output::claim(&folder, "scenario").is_ok(), "an empty folder can be had");
    assert!(folder.is_dir(), "and stays: it was there before");
}

#[test]
fn what_was_made_is_replaced_and_what_was_not_is_never() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("a/b");
    drop(Output::claim(&folder, "scenario").expect("new"));
    assert!(!root.path().join("a").exists(), "what nothing was written to is gone again");
    let output = Output::claim(&folder, "scenario").expect("new");
    output.write("model.ron", b"1").expect("writes");
    output.write("truth/x.csv", b"1").expect("writes in a folder below");
    drop(output);
    fs::write(folder.join("notes.txt"), "mine").expect("writes");
    let output = Output::claim(&folder, "scenario").expect("ours");
    output.write("model.ron", b"2").expect("replaces");
    assert_eq!(fs::read_to_string(folder.join("model.ron")).expect("reads"), "2");
    assert!(said(output.write("notes.txt", b"2")).contains("did not make"));
    assert!(!output.remove("notes.txt").expect("does nothing"));
    assert!(output.remove("truth/x.csv").expect("removes"));
    for bad in ["../x", "/x", "", "a/../x", "a\nb"] {
        assert!(output.write(bad, b"").is_err() && !output.remove(bad).expect("nothing"), "{bad}");
    }
    assert_eq!(fs::read_to_string(folder.join("notes.txt")).expect("reads"), "mine");
}

#[test]
fn a_study_is_of_the_workbench_alone() {
    let root = tempfile::tempdir().expect("a folder");
    let (study, results) = (root.path().join("study"), root.path().join("results"));
    Output::claim_study(&study).expect("new").write("steps.json", b"{}").expect("writes");
    Output::claim(&results, "diagnose").expect("new").write("model.ron", b"()").expect("writes");
    assert!(said(Output::claim(&study, "scenario")).contains("study"));
    assert!(said(Output::claim_study(&results)).contains("`lacuna diagnose`"));
    assert!(Output::claim_study(&study).is_ok() && Output::claim(&results, "scenario").is_ok());
}

#[test]
fn damaged_lists_and_lists_that_lead_elsewhere_are_refused_with_their_place() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("out");
    Output::claim(&folder, "scenario").expect("new").write("model.ron", b"1").expect("writes");
    let list = folder.join(".lacuna.json");
    let text = fs::read_to_string(&list).expect("reads");
    fs::write(&list, text.replace("model.ron", "../precious")).expect("writes");
    let error = said(Output::claim(&folder, "scenario"));
    assert!(error.contains(".lacuna.json:8:") && error.contains("`../precious`"), "{error}");
    fs::write(&list, &text[..40]).expect("writes");
    assert!(said(Output::claim(&folder, "scenario")).contains("damaged"));
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let root = tempfile::tempdir().expect("a folder");
    let (folder, precious) = (root.path().join("out"), root.path().join("precious"));
    fs::create_dir(&precious).expect("makes");
    fs::write(precious.join("x"), "precious").expect("writes");
    let output = Output::claim_study(&folder).expect("new");
    output.write("a", b"1").expect("writes");
    output.write("below/x", b"1").expect("writes");
    fs::remove_file(folder.join("a")).expect("removes");
    symlink(precious.join("x"), folder.join("a")).expect("links");
    fs::remove_dir_all(folder.join("below")).expect("removes");
    symlink(&precious, folder.join("below")).expect("links");
    symlink(precious.join("x"), folder.join(".upload-0")).expect("links");
    for name in ["a", "below/x"] {
        assert!(said(output.write(name, b"2")).contains("link"), "{name}");
        assert!(
            !output.remove(name).expect("does nothing") && !output.has(name) && output.read(name).is_err()
        );
    }
    let (_, temporary) = output.temporary("upload").expect("another name");
    assert!(temporary.path().ends_with(".upload-1"));
    drop((temporary, output));
    drop(Output::claim_study(&folder).expect("ours"));
    assert_eq!(fs::read_to_string(precious.join("x")).expect("reads"), "precious");
    assert!(folder.join(".upload-0").is_symlink(), "what is a link is none of ours");
}

#[test]
fn what_dead_processes_left_is_cleared() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("out");
    Output::claim_study(&folder).expect("new").write("model.ron", b"1").expect("writes");
    let left = ["model.ron.77.partial", ".lacuna.json.77.partial", ".upload-3", ".trial-robot.ron"];
    let mine = ["data.csv.77.partial", ".upload-old", "upload-3"];
    for name in left.iter().chain(&mine) {
        fs::write(folder.join(name), "x").expect("writes");
    }
    fs::create_dir(folder.join(".draft-1")).expect("makes");
    fs::write(folder.join(".draft-1/script.rhai"), "x").expect("writes");
    drop(Output::claim_study(&folder).expect("ours"));
    assert!(left.iter().all(|name| !folder.join(name).exists()) && !folder.join(".draft-1").exists());
    assert!(mine.iter().all(|name| folder.join(name).exists()), "what is not ours stays");
}

#[test]
fn folders_of_versions_without_lists_are_known_by_what_they_hold() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("out");
    fs::create_dir(&folder).expect("makes");
    for (name, text) in [("report.json", "{\"lacuna\": \"0.1.0\"}"), ("model.ron", "1"), ("mine.csv", "1")] {
        fs::write(folder.join(name), text).expect("writes");
    }
    let output = Output::claim(&folder, "scenario").expect("known");
    output.write("model.ron", b"2").expect("replaces");
    assert!(output.write("mine.csv", b"2").is_err());
    drop(output);
    let other = root.path().join("other");
    fs::create_dir(&other).expect("makes");
    fs::write(other.join("report.json"), "{\"of\": \"another program\"}").expect("writes");
    assert!(Output::claim(&other, "scenario").is_err());
}
