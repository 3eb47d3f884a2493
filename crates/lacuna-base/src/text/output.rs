//! Folders that results are written to: what was made there is replaced or removed, nothing else ever is.
//!
//! A claimed folder was empty, or holds a list of what was made in it (`.lacuna.json`); files that are not on the list
//! are the user's. One process has it at a time. Links are never followed for writing.

mod leftovers;
mod list;
mod lock;
mod temporary;

pub use temporary::Temporary;

use std::fs::File;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{cannot_write, partial, read};
use crate::error::{Error, Result};
use list::{List, State, is_plain, state};
use lock::Lock;

/// A folder that this process has for writing; given back with the last clone.
#[derive(Debug, Clone)]
pub struct Output(Arc<Claimed>);

#[derive(Debug)]
struct Claimed {
    folder: PathBuf,
    /// Whether what is made there is for its owner only.
    private: bool,
    list: Mutex<List>,
    lock: Lock,
    /// Folders that were made for it, outermost first.
    made: Vec<PathBuf>,
}

impl Output {
    /// Takes a folder for the results of the command `by`, made where it is not there; a folder that was made goes
    /// again when nothing was written to it.
    ///
    /// # Errors
    /// When something lies in it that was not made by this program, a study lies in it, another process has it, or
    /// it cannot be written to.
    pub fn claim(folder: &Path, by: &str) -> Result<Self> {
        Self::take(folder, by, false)
    }

    /// The same for a study: folders and files that are made are closed to everybody else, and no other command
    /// writes there.
    ///
    /// # Errors
    /// As [`Output::claim`]; also when the folder holds results of another command.
    pub fn claim_study(folder: &Path) -> Result<Self> {
        Self::take(folder, list::STUDY, true)
    }

    fn take(folder: &Path, by: &str, private: bool) -> Result<Self> {
        assess(folder, private)?;
        let made = make(folder, private)?;
        // Made folders go again with this value also when the rest fails.
        let mut claimed = Claimed {
            folder: folder.to_path_buf(),
            private,
            list: Mutex::new(List::new()),
            lock: Lock::none(),
            made,
        };
        claimed.lock = Lock::take(folder)?;
        // Again, now that nobody else changes it.
        let mut list = assess(folder, private)?.unwrap_or_else(List::new);
        list.by.insert(by.to_string());
        leftovers::clear(folder, &list);
        claimed.list = Mutex::new(list);
        Ok(Self(Arc::new(claimed)))
    }

    /// The folder, as it was named.
    pub fn folder(&self) -> &Path {
        &self.0.folder
    }

    /// Finds out whether files can be written under these names later on, before work is spent on them.
    ///
    /// # Errors
    /// When a file that was not made here, a folder or a link lies in the way.
    pub fn check<S: AsRef<str>>(&self, names: &[S]) -> Result<()> {
        let list = self.list();
        names.iter().try_for_each(|name| self.free(&list, name.as_ref()))
    }

    /// Puts names on the list for others to write under.
    ///
    /// # Errors
    /// As [`Output::check`], or when the list cannot be written.
    pub fn reserve<S: AsRef<str>>(&self, names: &[S]) -> Result<()> {
        self.check(names)?;
        names.iter().try_for_each(|name| self.folders_of(name.as_ref()))?;
        self.enter(names.iter().map(|name| name.as_ref().to_string()))
    }

    /// Writes a file whole or not at all, with the folders that it is in.
    ///
    /// # Errors
    /// When something lies in the way that was not made here, or the folder cannot be written to.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<()> {
        self.check(&[name])?;
        let known = self.has(name);
        self.reserve(&[name])?;
        let path = self.0.folder.join(name);
        partial::write(&path, content, self.0.private, known).map_err(|e| self.trouble(&path, &e))
    }

    /// Moves a finished file of this folder to its place, in the place of one that was made there.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn keep(&self, file: &Path, name: &str) -> Result<()> {
        self.check(&[name])?;
        let known = self.has(name);
        self.reserve(&[name])?;
        let path = self.0.folder.join(name);
        partial::put(file, &path, known).map_err(|e| self.trouble(&path, &e))
    }

    /// Removes a file that was made here; answers whether there was one. Whatever else has that name stays.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn remove(&self, name: &str) -> Result<bool> {
        if !self.has(name) || !self.list().made.contains(name) {
            return Ok(false);
        }
        let path = self.0.folder.join(name);
        std::fs::remove_file(&path)
            .map_err(|e| Error::new(format!("cannot remove it: {e}")).in_file(&path))?;
        let mut list = self.list();
        list.made.remove(name);
        self.save(&list)?;
        Ok(true)
    }

    /// Whether a file lies under this name: itself, not a link to one.
    pub fn has(&self, name: &str) -> bool {
        let path = self.0.folder.join(name);
        let parents = Path::new(name).ancestors().skip(1).filter(|p| !p.as_os_str().is_empty());
        let mut parents = parents.map(|p| self.0.folder.join(p));
        is_plain(name)
            && parents.all(|p| p.symlink_metadata().is_ok_and(|m| m.is_dir()))
            && path.symlink_metadata().is_ok_and(|m| m.is_file())
    }

    /// The text of a file in the folder.
    ///
    /// # Errors
    /// When there is none, it is a link, or it is no text.
    pub fn read(&self, name: &str) -> Result<String> {
        let path = self.0.folder.join(name);
        if !self.has(name) && path.symlink_metadata().is_ok() {
            return Err(Error::new("this is a link or a folder, not a file of this folder").in_file(path));
        }
        read(&path)
    }

    /// The first of these names that a file can be written under: nothing lies there, or it was made here and is
    /// not among `used`.
    pub fn first_free(&self, names: impl Iterator<Item = String>, used: &[String]) -> String {
        let list = self.list();
        let mut names = names.filter(|name| !used.contains(name) && self.free(&list, name).is_ok());
        names.next().unwrap_or_default()
    }

    /// Whether anything lies under a name.
    pub fn is_taken(&self, name: &str) -> bool {
        self.0.folder.join(name).symlink_metadata().is_ok()
    }

    /// Notes files elsewhere that were given on the command line.
    ///
    /// # Errors
    /// When the list cannot be written.
    pub fn give(&self, files: impl IntoIterator<Item = String>) -> Result<()> {
        let mut list = self.list();
        list.given.get_or_insert_default().extend(files);
        self.save(&list)
    }

    /// Whether a file elsewhere was given on the command line; `None` where that was not noted.
    pub fn was_given(&self, file: &str) -> Option<bool> {
        self.list().given.as_ref().map(|given| given.contains(file))
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.0.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a name can be written under.
    fn free(&self, list: &List, name: &str) -> Result<()> {
        let path = self.0.folder.join(name);
        let bad = |text: &str| Err(Error::new(text).in_file(&path));
        if !is_plain(name) {
            return bad("this is no name of a file in the folder");
        }
        let parents = Path::new(name).ancestors().skip(1).filter(|p| !p.as_os_str().is_empty());
        for parent in parents {
            if self.0.folder.join(parent).symlink_metadata().is_ok_and(|m| !m.is_dir()) {
                return bad("no result can be written here: its folder is a file or a link");
            }
        }
        match path.symlink_metadata() {
            Err(_) => Ok(()),
            Ok(m) if m.is_symlink() => bad("a link lies where the result goes; it is not followed"),
            Ok(m) if !m.is_file() => bad("no result can be written here: a folder has its name"),
            Ok(_) if !list.made.contains(name) => {
                bad("a file lies where the result goes that lacuna did not make")
            }
            Ok(_) => Ok(()),
        }
    }

    /// Makes the folders below this one that a file is in.
    fn folders_of(&self, name: &str) -> Result<()> {
        let mut place = self.0.folder.clone();
        let parts: Vec<Component<'_>> = Path::new(name).components().collect();
        for part in parts.iter().take(parts.len().saturating_sub(1)) {
            place.push(part);
            match make_one(&place, self.0.private) {
                Err(e) if e.kind() != std::io::ErrorKind::AlreadyExists => {
                    return Err(cannot_write(&place, &e));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Puts names on the list, before anything is written under them: whatever ends the process, what lies there
    /// is known.
    fn enter(&self, names: impl Iterator<Item = String>) -> Result<()> {
        let mut list = self.list();
        let before = list.clone();
        list.made.extend(names);
        if *list == before && self.is_taken(list::FILE) {
            return Ok(());
        }
        self.save(&list).inspect_err(|_| *list = before)
    }

    fn save(&self, list: &List) -> Result<()> {
        self.0.save(list)
    }

    fn trouble(&self, path: &Path, error: &std::io::Error) -> Error {
        if error.kind() == std::io::ErrorKind::AlreadyExists {
            return Error::new("a file lies where the result goes that lacuna did not make").in_file(path);
        }
        cannot_write(path, error)
    }

    /// A new file for a while, `.<stem>-<number>` in the folder; gone with the second value.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn temporary(&self, stem: &str) -> Result<(File, Temporary)> {
        let named = |k: usize| self.0.folder.join(format!(".{stem}-{k}"));
        let made = partial::first_free(named, |path| partial::create_new(path, self.0.private));
        let (file, path) = made.map_err(|e| cannot_write(&self.0.folder, &e))?;
        Ok((file, Temporary::new(path)))
    }

    /// A new folder for a while, named alike; gone with the value, and the files in it.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn temporary_folder(&self, stem: &str) -> Result<Temporary> {
        let named = |k: usize| self.0.folder.join(format!(".{stem}-{k}"));
        let made = partial::first_free(named, |path| make_one(path, self.0.private));
        made.map(|((), path)| Temporary::new(path)).map_err(|e| cannot_write(&self.0.folder, &e))
    }
}

impl Claimed {
    fn save(&self, list: &List) -> Result<()> {
        let path = self.folder.join(list::FILE);
        let text = list.text()?;
        partial::write(&path, text.as_bytes(), self.private, true).map_err(|e| cannot_write(&path, &e))
    }
}

impl Drop for Claimed {
    fn drop(&mut self) {
        if self.lock.is_held() {
            let path = self.folder.join(list::FILE);
            let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let before = list.made.len();
            list.made.retain(|name| self.folder.join(name).symlink_metadata().is_ok());
            // A name that stays on the list without its file does no harm.
            if list.made.is_empty() && path.symlink_metadata().is_ok_and(|m| m.is_file()) {
                let _ = std::fs::remove_file(&path);
            } else if list.made.len() < before {
                let _ = self.save(&list);
            }
        }
        self.lock.give_back();
        // Only what is empty can be removed like that.
        self.made.iter().rev().for_each(|folder| {
            let _ = std::fs::remove_dir(folder);
        });
    }
}

/// The list of a folder that can be claimed; `None` where nothing lies there.
fn assess(folder: &Path, study: bool) -> Result<Option<List>> {
    match state(folder)? {
        State::Vacant => Ok(None),
        State::Foreign(name) => {
            let name: String = name.chars().filter(|c| !c.is_control()).take(80).collect();
            let what = format!("the folder is not empty, and lacuna did not make what lies in it (`{name}`)");
            Err(Error::new(what).in_file(folder))
        }
        State::Ours(list) if list.is_study() && !study => {
            Err(Error::new("a study of the workbench lies in this folder").in_file(folder))
        }
        State::Ours(list) if study && !list.is_study() => {
            let by = list.by.iter().map(|by| format!("`lacuna {by}`")).collect::<Vec<_>>().join(" and ");
            Err(Error::new(format!("the folder holds results of {by}")).in_file(folder))
        }
        State::Ours(list) => Ok(Some(list)),
    }
}

/// Whether nothing lies in a folder, or it is not there.
pub fn is_vacant(folder: &Path) -> bool {
    matches!(state(folder), Ok(State::Vacant))
}

/// Makes a folder and those it is in; answers those that were made, outermost first.
fn make(folder: &Path, private: bool) -> Result<Vec<PathBuf>> {
    let missing = |f: &&Path| !f.as_os_str().is_empty() && !f.is_dir();
    let mut missing: Vec<&Path> = folder.ancestors().take_while(missing).collect();
    missing.reverse();
    let mut made = Vec::new();
    for place in missing {
        match make_one(place, private && place == folder) {
            Ok(()) => made.push(place.to_path_buf()),
            // Another process was faster, or it is no folder: the lock says which.
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists && place.is_dir() => {}
            Err(e) => {
                made.iter().rev().for_each(|folder: &PathBuf| {
                    let _ = std::fs::remove_dir(folder);
                });
                return Err(cannot_write(folder, &e));
            }
        }
    }
    Ok(made)
}

fn make_one(folder: &Path, private: bool) -> std::io::Result<()> {
    #[cfg_attr(not(unix), expect(unused_mut))]
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    if private {
        use std::os::unix::fs::DirBuilderExt;
        builder.mode(0o700);
    }
    #[cfg(not(unix))]
    let _ = private;
    builder.create(folder)
}

#[cfg(test)]
mod tests;
