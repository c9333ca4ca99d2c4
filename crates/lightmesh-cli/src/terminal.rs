//! The only place that writes to stdout and stderr.

use std::io::{self, Write};

/// A result, on stdout.
///
/// # Errors
/// What stdout answers; a closed pipe (`lightmesh info scene.glb | head -1`) counts as done.
pub(crate) fn print(text: &str) -> io::Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(io::Error::new(error.kind(), format!("standard output cannot be written: {error}"))),
        Ok(()) => Ok(()),
    }
}

/// An error, in one line on stderr.
pub(crate) fn error(message: &str) {
    line("error", message);
}

/// A warning, in one line on stderr.
pub(crate) fn warning(message: &str) {
    line("warning", message);
}

/// Prints one line about what was done to stderr.
pub(crate) fn note(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", flat(message));
}

fn line(kind: &str, message: &str) {
    // Where stderr is gone, nobody is left to tell.
    let _ = writeln!(io::stderr().lock(), "{kind}: {}", flat(message));
}

/// The message without line breaks and other control characters, which a file's names may hold.
fn flat(message: &str) -> String {
    message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
