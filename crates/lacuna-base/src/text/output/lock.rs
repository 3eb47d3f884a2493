//! One process at a time in a folder. The system gives the lock back when the process ends, however it ends; the
//! file that carries it says which process has it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use super::super::{cannot_write, partial};
use crate::error::{Error, Result};

/// The file that is locked.
pub(super) const FILE: &str = ".lacuna.lock";
/// Longest content of it [bytes]: a number.
const LONGEST: u64 = 32;

/// A held lock; given back with the value, its file removed.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    file: Option<File>,
}

impl Lock {
    /// No lock.
    pub fn none() -> Self {
        Self { path: PathBuf::new(), file: None }
    }

    pub fn is_held(&self) -> bool {
        self.file.is_some()
    }

    /// Takes the lock of a folder.
    pub fn take(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        // Whoever gave the lock back a moment ago may have removed the file that was opened here.
        for _ in 0..100 {
            let Some(mut file) = open(folder, &path)? else { continue };
            match file.try_lock() {
                Ok(()) if !is_at(&file, &path) => continue,
                // Where the file system knows no locks, the file still says who was here.
                Ok(()) => {}
                Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {}
                Err(TryLockError::Error(e)) => {
                    return Err(Error::new(format!("cannot lock the folder: {e}")).in_file(folder));
                }
                Err(TryLockError::WouldBlock) => return Err(held(folder, file)),
            }
            let written =
                file.set_len(0).and_then(|()| file.write_all(std::process::id().to_string().as_bytes()));
            // Given back, and its file removed, where the disk is full.
            let lock = Self { path, file: Some(file) };
            return written.map(|()| lock).map_err(|e| cannot_write(folder, &e));
        }
        Err(Error::new("the folder is being opened and closed all the time").in_file(folder))
    }

    /// Gives it back.
    pub fn give_back(&mut self) {
        if let Some(file) = self.file.take() {
            if is_at(&file, &self.path) {
                // While it is still held: a file that another process has locked is never removed.
                let _ = std::fs::remove_file(&self.path);
            }
            drop(file);
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        self.give_back();
    }
}

/// The file, made where it is not there; `None` where it went away meanwhile.
fn open(folder: &Path, path: &Path) -> Result<Option<File>> {
    match partial::create_new(path, true) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
        made => return made.map(Some).map_err(|e| cannot_write(folder, &e)),
    }
    match path.symlink_metadata() {
        Ok(m) if m.is_file() && m.len() <= LONGEST => {}
        Ok(_) => return Err(Error::new("this is no lock file of lacuna, but has its name").in_file(path)),
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(cannot_write(folder, &e)),
    }
    match OpenOptions::new().read(true).write(true).open(path) {
        Ok(file) => Ok(Some(file)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(cannot_write(folder, &e)),
    }
}

/// Whether an open file is the one that lies at a place, and no link leads there.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(open), Ok(there)) = (file.metadata(), path.symlink_metadata()) else { return false };
    there.is_file() && (open.dev(), open.ino()) == (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|m| m.is_file())
}

fn held(folder: &Path, mut file: File) -> Error {
    let mut text = String::new();
    // Its holder may not have written its number yet, and some systems do not let others read it.
    let read = Read::take(&mut file, LONGEST).read_to_string(&mut text);
    let id = text.trim().parse::<u32>().ok().filter(|_| read.is_ok());
    let who = id.map_or_else(|| "another process".to_string(), |id| format!("process {id}"));
    Error::new(format!("{who} has this folder open"))
        .in_file(folder)
        .help("end that process first, or give another folder")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_holder_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let lock = Lock::take(folder.path()).expect("it is free");
        let refused = Lock::take(folder.path()).expect_err("it is taken");
        assert!(refused.message().contains(&format!("process {}", std::process::id())), "{refused}");
        drop(lock);
        assert!(!folder.path().join(FILE).exists(), "nothing stays");
        // What a process left behind that was killed is no lock.
        std::fs::write(folder.path().join(FILE), "123").expect("writes");
        assert!(Lock::take(folder.path()).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn what_only_has_the_name_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let precious = folder.path().join("precious");
        std::fs::write(&precious, "precious").expect("writes");
        std::os::unix::fs::symlink(&precious, folder.path().join(FILE)).expect("links");
        assert!(Lock::take(folder.path()).is_err());
        assert_eq!(std::fs::read_to_string(&precious).expect("reads"), "precious");
    }
}
