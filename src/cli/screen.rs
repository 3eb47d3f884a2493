//! What reaches a terminal. Names of robots, joints, files and columns come from strangers' files: on their way out
//! everything that would steer the terminal is escaped, here and nowhere else.

use std::io::{IsTerminal, Write};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use lacuna::text::{harmless, harmless_json};
use lacuna::{Error, Result};

/// Prints text to stdout; a reader that has gone away is no error of ours.
pub(super) fn print(text: &str) -> Result<()> {
    put(&harmless(text))
}

/// Prints one JSON document.
pub(super) fn print_json<T: serde::Serialize>(value: &T) -> Result<()> {
    put(&(harmless_json(&json(value)?).into_owned() + "\n"))
}

/// Prints a document that other programs read: as it is, unless it goes to a screen.
pub(super) fn print_document(text: &str) -> Result<()> {
    if std::io::stdout().is_terminal() { print(text) } else { put(text) }
}

/// Says something on stderr. That nobody listens is no reason to end.
pub(super) fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", harmless(text));
}

fn put(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("cannot write to stdout: {e}")))
        }
        _ => Ok(()),
    }
}

pub(super) fn json<T: serde::Serialize>(value: &T) -> Result<String> {
    serde_json::to_string_pretty(value).map_err(|e| Error::new(format!("cannot write JSON: {e}")))
}

/// Ends the process with what the reader of the arguments has to say: help, or what is wrong with them.
pub(super) fn leave(mut said: clap::Error) -> ! {
    if matches!(said.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        said.exit();
    }
    let odd = |text: &str| text.chars().count() > LONGEST || harmless(text) != text || text.contains('\n');
    if std::env::args_os().skip(1).any(|argument| odd(&argument.to_string_lossy())) {
        // It quotes what it was given, colours and all.
        let kinds = [ContextKind::InvalidArg, ContextKind::InvalidValue, ContextKind::InvalidSubcommand];
        for kind in kinds {
            if let Some(ContextValue::String(given)) = said.get(kind) {
                let short = ContextValue::String(shortened(given));
                said.insert(kind, short);
            }
        }
        // A tip would quote it once more.
        said.remove(ContextKind::Suggested);
        say(said.render().to_string().trim_end());
        std::process::exit(said.exit_code());
    }
    said.exit()
}

/// Longest argument that is repeated whole, in characters.
const LONGEST: usize = 60;

fn shortened(given: &str) -> String {
    let mut short: String = given.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if given.chars().nth(LONGEST).is_some() {
        short += "...";
    }
    short
}
