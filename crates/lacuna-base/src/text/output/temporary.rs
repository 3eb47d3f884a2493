//! What lies in a folder for a while.

use std::path::{Path, PathBuf};

/// A file or folder that goes with this value, unless it was moved away before.
#[derive(Debug)]
pub struct Temporary(PathBuf);

impl Temporary {
    pub(super) fn new(path: PathBuf) -> Self {
        Self(path)
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Links in it are removed, not followed. What cannot be removed is cleared at the next start.
        let _ = match self.0.symlink_metadata() {
            Ok(m) if m.is_dir() => std::fs::remove_dir_all(&self.0),
            Ok(_) => std::fs::remove_file(&self.0),
            Err(_) => Ok(()),
        };
    }
}
