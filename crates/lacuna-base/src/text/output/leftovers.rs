//! What processes left behind that were killed while they wrote.

use std::path::Path;

use super::super::partial;
use super::list::{self, List, names};

/// Stems of what is put down for a while in a study.
const STEMS: [&str; 3] = ["upload", "draft", "trial"];

/// Removes them from a folder whose lock is held: half-written files of names on the list, and in a study what was
/// put down for a while. Nothing else, and no links.
pub(super) fn clear(folder: &Path, list: &List) {
    let below = list.made.iter().filter_map(|name| Path::new(name).parent());
    let mut folders: Vec<&Path> = below.chain([Path::new("")]).collect();
    folders.sort();
    folders.dedup();
    for below in folders {
        let place = folder.join(below);
        if !below.as_os_str().is_empty() && !place.symlink_metadata().is_ok_and(|m| m.is_dir()) {
            continue;
        }
        for name in names(&place).unwrap_or_default() {
            let path = place.join(&name);
            let target = partial::target(&name).map(|t| below.join(t).to_string_lossy().into_owned());
            let half = target.is_some_and(|t| t == list::FILE || list.made.contains(&t));
            if half && path.symlink_metadata().is_ok_and(|m| m.is_file()) {
                // What cannot be removed is in nobody's way.
                let _ = std::fs::remove_file(&path);
            }
            if list.is_study() && below.as_os_str().is_empty() && is_put_down(&name) {
                remove(&path);
            }
        }
    }
}

/// `.upload-3`, `.draft-0` and the like.
fn is_put_down(name: &str) -> bool {
    let rest = |stem: &&str| name.strip_prefix('.')?.strip_prefix(*stem)?.strip_prefix('-');
    STEMS.iter().find_map(rest).is_some_and(|rest| {
        let digits = !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit());
        // Versions before tried robots under these names.
        digits || (name.starts_with(".trial-") && ["robot.urdf", "robot.ron"].contains(&rest))
    })
}

/// Removes a file, or a folder with nothing but files in it.
fn remove(path: &Path) {
    let Ok(kind) = path.symlink_metadata() else { return };
    if kind.is_file() {
        let _ = std::fs::remove_file(path);
    } else if kind.is_dir() {
        for name in names(path).unwrap_or_default() {
            let file = path.join(name);
            if file.symlink_metadata().is_ok_and(|m| m.is_file()) {
                let _ = std::fs::remove_file(file);
            }
        }
        let _ = std::fs::remove_dir(path);
    }
}
