//! Files that are written beside their place first: nobody ever sees half of one, and no link is followed.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

/// How often another name is tried where one is taken.
const TRIES: usize = 1000;

/// Makes a file that was not there. Whatever lies there, a link too, is left alone; a private file is read and
/// written by its owner only, and so is one in a folder that is closed to everybody else.
pub(super) fn create_new(path: &Path, private: bool) -> Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
        let folder = path.parent().map(|f| if f.as_os_str().is_empty() { Path::new(".") } else { f });
        let closed = || folder.and_then(|f| f.metadata().ok()).is_some_and(|m| m.mode() & 0o077 == 0);
        if private || closed() {
            options.mode(0o600);
        }
    }
    #[cfg(not(unix))]
    let _ = private;
    options.open(path)
}

/// Writes a file whole or not at all; what lies there is replaced, or refused.
pub(super) fn write(path: &Path, content: &[u8], private: bool, replace: bool) -> Result<()> {
    let (mut file, partial) = beside(path, private)?;
    let done = file.write_all(content).and_then(|()| file.sync_all());
    done.and_then(|()| put(&partial, path, replace)).inspect_err(|_| {
        // The half-written file is of no use to anybody; that removing it may fail too changes nothing.
        let _ = std::fs::remove_file(&partial);
    })
}

/// A new file beside a place, `<name>.<process id>.partial`.
fn beside(path: &Path, private: bool) -> Result<(File, PathBuf)> {
    let process = std::process::id();
    let named = |k: usize| {
        let more = if k == 0 { String::new() } else { format!("-{k}") };
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{process}{more}.partial"));
        PathBuf::from(name)
    };
    first_free(named, |place| create_new(place, private))
}

/// The first of several names under which something new can be made, with what was made.
pub(super) fn first_free<T>(
    named: impl Fn(usize) -> PathBuf,
    make: impl Fn(&Path) -> Result<T>,
) -> Result<(T, PathBuf)> {
    for k in 0..TRIES {
        let place = named(k);
        match make(&place) {
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            made => return made.map(|made| (made, place)),
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}

/// Moves a finished file to its place.
pub(super) fn put(from: &Path, to: &Path, replace: bool) -> Result<()> {
    if replace {
        return std::fs::rename(from, to);
    }
    match std::fs::hard_link(from, to) {
        Ok(()) => std::fs::remove_file(from),
        Err(e) if e.kind() == ErrorKind::AlreadyExists => Err(e),
        // Not every file system has such links.
        Err(_) if to.symlink_metadata().is_ok() => Err(ErrorKind::AlreadyExists.into()),
        Err(_) => std::fs::rename(from, to),
    }
}

/// The name that a partial file was to have, if this is the name of one.
pub(super) fn target(name: &str) -> Option<&str> {
    let (name, process) = name.strip_suffix(".partial")?.rsplit_once('.')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let (id, number) = process.split_once('-').unwrap_or((process, "0"));
    (digits(id) && digits(number) && !name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_files_are_told_by_their_names() {
        assert_eq!(target("model.ron.123.partial"), Some("model.ron"));
        assert_eq!(target("model.ron.123-4.partial"), Some("model.ron"));
        for other in
            ["model.ron", "a.partial", "a.b.partial", ".1.partial", "a.1-.partial", "a.1.partial.csv"]
        {
            assert_eq!(target(other), None, "{other}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_way_of_a_partial_file_is_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let precious = folder.path().join("precious");
        std::fs::write(&precious, "precious").expect("writes");
        let place = folder.path().join("x.ron");
        let partial = folder.path().join(format!("x.ron.{}.partial", std::process::id()));
        std::os::unix::fs::symlink(&precious, &partial).expect("links");
        write(&place, b"new", false, true).expect("another name is found");
        assert_eq!(std::fs::read_to_string(&precious).expect("reads"), "precious");
        assert_eq!(std::fs::read_to_string(&place).expect("reads"), "new");
        assert!(write(&place, b"newer", false, false).is_err(), "what lies there is not replaced");
        assert_eq!(std::fs::read_dir(folder.path()).expect("reads").count(), 3, "nothing half-written stays");
    }
}
