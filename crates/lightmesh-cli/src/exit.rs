//! Errors said once, and exit codes.
//!
//! 0 done; 1 failed while working, or pixels are no numbers; 2 bad input or usage; 3 done, but not within the error asked for (`--strict`); 130
//! interrupted.

use std::io::ErrorKind;

use clap::error::ErrorKind as Usage;

use crate::terminal;

/// Why the program stops early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input or an argument cannot be used: exit code 2.
    Input(anyhow::Error),
    /// The input was good and the work failed: exit code 1.
    Work(anyhow::Error),
    /// The picture is written and its error is more than was asked for: exit code 3.
    TooInexact(String),
    /// Ctrl-C: exit code 130, as shells count it (128 + SIGINT).
    Interrupted,
}

/// Exit code after Ctrl-C.
pub(crate) const INTERRUPTED: u8 = 130;

impl Failure {
    /// Bad input, from any error.
    pub(crate) fn input(error: impl Into<anyhow::Error>) -> Self {
        Self::Input(error.into())
    }

    /// Failed work, from any error.
    pub(crate) fn work(error: impl Into<anyhow::Error>) -> Self {
        Self::Work(error.into())
    }

    /// Returns the message in one line, with its chain of causes.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Input(error) | Self::Work(error) => format!("{error:#}"),
            Self::TooInexact(message) => message.clone(),
            Self::Interrupted => "interrupted".to_owned(),
        }
    }

    /// Says it on stderr, in one line with its chain of causes, and gives the exit code.
    pub(crate) fn report(&self) -> u8 {
        let code = match self {
            Self::Input(_) => 2,
            Self::Work(_) => 1,
            Self::TooInexact(_) => 3,
            Self::Interrupted => return INTERRUPTED,
        };
        terminal::error(&self.message());
        code
    }
}

/// The user can change everything that the core refuses, so it counts as input; cancelling is the user's wish.
impl From<lightmesh::Error> for Failure {
    fn from(error: lightmesh::Error) -> Self {
        match error {
            lightmesh::Error::Cancelled => Self::Interrupted,
            other => Self::input(other),
        }
    }
}

/// Help and version on stdout; a usage error in one line on stderr.
pub(crate) fn usage(error: &clap::Error) -> u8 {
    match error.kind() {
        Usage::DisplayHelp | Usage::DisplayVersion | Usage::DisplayHelpOnMissingArgumentOrSubcommand => {
            match error.print() {
                // A closed pipe is no failure of ours.
                Err(cause) if cause.kind() != ErrorKind::BrokenPipe => {
                    terminal::error(&format!("standard output cannot be written: {cause}"));
                    1
                }
                _ => u8::from(error.use_stderr()) * 2,
            }
        }
        _ => {
            terminal::error(&one_line(&error.render().to_string()));
            2
        }
    }
}

/// clap's paragraphs without the usage and the pointer to `--help`, in one line.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with("For more information"));
    let joined = lines.collect::<Vec<_>>().join(" ");
    joined.strip_prefix("error: ").unwrap_or(&joined).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claps_paragraphs_become_one_line() {
        let message = "error: invalid value 'magic' for '--method <METHOD>'\n  [possible values: mesh, path]\n\n\
                       Usage: lightmesh render\n\nFor more information, try '--help'.\n";
        assert_eq!(one_line(message), "invalid value 'magic' for '--method <METHOD>' [possible values: mesh, path]");
    }

    #[test]
    fn cancelling_is_no_bad_input() {
        assert!(matches!(Failure::from(lightmesh::Error::Cancelled), Failure::Interrupted));
        assert!(matches!(Failure::from(lightmesh::Error::EmptyScene), Failure::Input(_)));
    }
}
