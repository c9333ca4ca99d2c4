//! The options of `render` by name and value, as programs give them: parsed, with their ranges and defaults, as on the
//! command line.

use std::error::Error as _;
use std::ffi::OsString;
use std::fmt;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use lightmesh::{Camera, RenderOptions};
use lightmesh_io::LoadOptions;

use crate::args::{Cli, Command, EmitterArgs, RenderArgs};
use crate::camera_choice::height_for;

/// Options that only the command line has: its files and its messages.
const FILES: [&str; 9] = ["output", "exposure", "half", "preview", "stats", "mesh", "save-mesh", "quiet", "help"];

/// An option that programs may choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keyword {
    /// Its name, with underscores.
    pub name: String,
    /// Its value where none is given, as the command line spells it; `None` where that depends on others, or is
    /// nothing.
    pub default: Option<String>,
}

/// Every option that programs may choose, in the order of `--help`.
pub fn keywords() -> Vec<Keyword> {
    let command = Cli::command();
    let render = command.find_subcommand("render").map(clap::Command::get_arguments);
    let named = render.into_iter().flatten().filter_map(|arg| Some((arg, arg.get_long()?)));
    let chosen = named.filter(|(_, name)| !FILES.contains(name));
    chosen
        .map(|(arg, name)| {
            let default = arg.get_default_values().first().filter(|_| arg.get_action().takes_values());
            Keyword { name: underscored(name), default: default.map(|value| value.to_string_lossy().into_owned()) }
        })
        .collect()
}

/// Options that a program has chosen; the others have their defaults.
#[derive(Debug)]
pub struct Keywords(Box<RenderArgs>);

impl Keywords {
    /// Parses values as the command line does, by the names of [`keywords`]. A flag has the value `true`.
    ///
    /// # Errors
    /// For the first option that does not exist or whose value is none of its own.
    pub fn parse<'a>(pairs: impl IntoIterator<Item = (&'a str, OsString)>) -> Result<Self, KeywordError> {
        let flags = pairs.into_iter().map(|(name, value)| {
            let mut flag = OsString::from(format!("--{}", name.replace('_', "-")));
            if value != "true" {
                flag.push("=");
                flag.push(value);
            }
            flag
        });
        let line = ["lightmesh", "render", "scene", "-o", "picture"].into_iter().map(OsString::from);
        match Cli::try_parse_from(line.chain(flags)) {
            Ok(Cli { command: Command::Render(args) }) => Ok(Self(args)),
            Ok(_) => Err(KeywordError { name: String::new(), what: "is another command".to_owned() }),
            Err(error) => Err(KeywordError::from(error)),
        }
    }

    /// The library's options for a picture by this camera, whose aspect makes the height where no size is given.
    pub fn options(&self, camera: &Camera) -> RenderOptions {
        let options = self.0.options();
        let height = if self.0.size.is_none() { height_for(camera, options.width) } else { options.height };
        RenderOptions { height, ..options }
    }

    /// The library's options for all that does not depend on a picture's size.
    pub fn mesh_options(&self) -> RenderOptions {
        self.0.options()
    }

    /// Light with a size.
    pub fn emitters(&self) -> &EmitterArgs {
        &self.0.emitters
    }

    /// The camera's name or index, where one is given.
    pub fn camera(&self) -> Option<&str> {
        self.0.camera.as_deref()
    }

    /// Returns the number of threads, if it was given.
    pub fn threads(&self) -> Option<usize> {
        self.0.threads.map(|threads| threads as usize)
    }

    /// Returns the options of reading a scene file.
    pub fn load_options(&self) -> LoadOptions {
        self.0.load_options()
    }
}

/// An option that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeywordError {
    /// Its name, with underscores.
    pub name: String,
    /// The problem, with the value that was given.
    pub what: String,
}

impl fmt::Display for KeywordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.what)
    }
}

impl std::error::Error for KeywordError {}

impl From<clap::Error> for KeywordError {
    fn from(error: clap::Error) -> Self {
        let text = |kind| match error.get(kind) {
            Some(ContextValue::String(text)) => text.clone(),
            Some(ContextValue::Strings(texts)) => texts.join(", "),
            _ => String::new(),
        };
        // `--spacing <METRES>`
        let flag = text(ContextKind::InvalidArg);
        let name = flag.trim_start_matches('-').split([' ', '=']).next().unwrap_or_default();
        let value = text(ContextKind::InvalidValue);
        let what = match (error.kind(), error.source()) {
            (ErrorKind::UnknownArgument, _) => "there is no such option".to_owned(),
            (ErrorKind::InvalidValue, _) => format!("{value:?} is none of {}", text(ContextKind::ValidValue)),
            (_, Some(why)) => format!("{value:?} cannot be used: {why}"),
            (kind, None) => format!("{value:?} cannot be used: {kind}"),
        };
        Self { name: underscored(name), what }
    }
}

/// An option's name as programs write it.
fn underscored(name: &str) -> String {
    name.replace('-', "_")
}

#[cfg(test)]
mod tests {
    use lightmesh::Spacing;

    use super::*;

    fn parse(pairs: &[(&str, &str)]) -> Result<Keywords, KeywordError> {
        Keywords::parse(pairs.iter().map(|&(name, value)| (name, value.into())))
    }

    #[test]
    fn nothing_said_is_the_librarys_default() {
        assert_eq!(parse(&[]).unwrap().mesh_options(), RenderOptions::default());
        assert_eq!(parse(&[]).unwrap().load_options().max_memory, LoadOptions::default().max_memory);
    }

    #[test]
    fn names_have_underscores_and_values_may_begin_with_a_minus() {
        let chosen = parse(&[("indirect_spacing", "1/80"), ("environment_rotation", "-90"), ("allow_outside", "true")]);
        let chosen = chosen.unwrap();
        assert_eq!(chosen.mesh_options().indirect_spacing, Spacing::Fraction(80.0));
        assert!(chosen.load_options().allow_outside);
    }

    #[test]
    fn what_is_wrong_is_said_of_the_keyword() {
        let message = |name, value| parse(&[(name, value)]).unwrap_err().to_string();
        assert!(
            message("indirect_spacing", "2/80")
                .starts_with("indirect_spacing: \"2/80\" cannot be used: the spacing is")
        );
        assert!(message("method", "magic").starts_with("method: \"magic\" is none of mesh, paper"));
        assert!(message("spp", "0").starts_with("spp: \"0\""), "{}", message("spp", "0"));
        assert_eq!(message("speed", "1"), "speed: there is no such option");
    }

    #[test]
    fn files_are_the_command_lines_alone() {
        let all = keywords();
        let default = |name| all.iter().find(|keyword| keyword.name == name).map(|keyword| keyword.default.as_deref());
        assert_eq!((default("bounces"), default("spp"), default("output")), (Some(Some("3")), Some(None), None));
        assert_eq!((default("light_error"), default("allow_outside")), (Some(Some("0.01")), Some(None)));
        assert_eq!((default("mesh"), default("save_mesh")), (None, None));
    }
}
