//! Files that scenarios name: relative to the scenario, and never outside its repository or folder.

use std::path::{Component, Path, PathBuf};

use crate::error::{Error, Result};

/// The place of `path` below `folder`.
///
/// # Errors
/// When it is absolute, is not there, or leaves the repository (the nearest folder upwards that holds
/// `.git`), or `folder` itself where there is no repository; links are followed first.
pub fn inside(folder: &Path, path: &Path) -> Result<PathBuf> {
    let error = |text: String| Error::new(text).in_file(path);
    if path.components().any(|c| matches!(c, Component::RootDir | Component::Prefix(_))) {
        return Err(error("the path is absolute".into()).help("write it relative to the scenario file"));
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let folder =
        folder.canonicalize().map_err(|e| error(format!("cannot find the scenario's folder: {e}")))?;
    let root = folder.ancestors().find(|f| f.join(".git").exists()).unwrap_or(&folder);
    // A path that climbs out is refused before anything outside is looked at.
    let mut depth = folder.strip_prefix(root).map_or(0, |p| p.components().count());
    for part in path.components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::ParentDir if depth == 0 => return Err(outside(path)),
            Component::ParentDir => depth -= 1,
            _ => {}
        }
    }
    let found = folder.join(path).canonicalize().map_err(|e| {
        error(format!("cannot read the file: {e}")).help("the path is relative to the scenario file")
    })?;
    if found.starts_with(root) { Ok(found) } else { Err(outside(path)) }
}

fn outside(path: &Path) -> Error {
    Error::new("the path leaves the scenario's repository or folder")
        .in_file(path)
        .help("put the file beside the scenario")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside() -> std::io::Result<()> {
        let root = std::env::temp_dir().join(format!("lacuna-inside-{}", std::process::id()));
        let study = root.join("repository/study");
        std::fs::create_dir_all(study.join("meshes"))?;
        std::fs::create_dir_all(root.join("repository/.git"))?;
        for file in ["outside.stl", "repository/beside.stl", "repository/study/meshes/in.stl"] {
            std::fs::write(root.join(file), "x")?;
        }
        let at = |path: &str| inside(&study, Path::new(path)).map_err(|e| e.message().to_string());
        assert!(at("meshes/in.stl").is_ok());
        assert!(at("../beside.stl").is_ok(), "the repository is one folder up");
        assert_eq!(
            at("../../outside.stl"),
            Err("the path leaves the scenario's repository or folder".into())
        );
        assert_eq!(at("/etc/hostname"), Err("the path is absolute".into()));
        assert!(at("meshes/absent.stl").is_err_and(|e| e.starts_with("cannot read the file")));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(root.join("outside.stl"), study.join("link.stl"))?;
            assert!(at("link.stl").is_err_and(|e| e.contains("leaves")), "links are followed first");
        }
        std::fs::remove_dir_all(&root)
    }
}
