//! The options that both faces have: the core's table of them, and the few that only a program needs.

use clap::{ArgMatches, Args, FromArgMatches, builder::PossibleValue, parser::ValueSource};
use lightmesh::schema::{About, Entry, Group, Kind, RENDER, Range, Value};
use lightmesh::{EmitterOptions, Error, Method, RenderOptions};

use super::environment::{self, EnvironmentArg};
use crate::machine;

/// Light with a size: the environment, lamps with a radius, and how many samples stand for each.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterArgs {
    /// Light from all sides, in place of the file's own.
    pub environment: Option<EnvironmentArg>,
    /// What multiplies the environment.
    pub environment_strength: f32,
    /// What turns the environment about +Y, degrees.
    pub environment_rotation: f32,
    /// How emitters become light samples.
    pub options: EmitterOptions,
}

impl Default for EmitterArgs {
    fn default() -> Self {
        Self {
            environment: None,
            environment_strength: 1.0,
            environment_rotation: 0.0,
            options: EmitterOptions::default(),
        }
    }
}

/// What a program may choose beside the options of the core.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Light with a size.
    pub emitters: EmitterArgs,
    /// The number of threads; `None`: one for each core.
    pub threads: Option<u32>,
}

const EMITTER: About = About { group: Group::Emitters, ..About::PLAIN };

/// The rows of the core's own table of emitters.
const EMITTER_TABLE: &[Entry<EmitterOptions>; 2] = &EmitterOptions::TABLE;

/// Every option of [`Surroundings`], in the order of `--help`.
pub const SURROUNDINGS: [Entry<Surroundings>; 6] = [
    Entry {
        about: About {
            name: "environment",
            kind: Kind::Syntax {
                normal: |text| EnvironmentArg::parse(text).map(|_| text.to_owned()),
                expected: environment::EXPECTED,
                numbers: false,
            },
            value_name: "FILE|COLOUR",
            help: "Light from all sides, in place of the file's own: a latitude-longitude map (.hdr or .exr; its \
                   middle is +X, its top +Y), or one colour as R,G,B (linear), #rrggbb (sRGB) or black; without it, a picture \
                   that would be black gets the light of a studio, or in closed rooms a lamp at the camera",
            ..EMITTER
        },
        get: |o| o.emitters.environment.as_ref().map(Value::text),
        set: |o, value| o.emitters.environment = EnvironmentArg::parse(value.as_text()),
    },
    Entry {
        about: About {
            name: "environment-strength",
            kind: Kind::Real(Range::NotNegative),
            value_name: "S",
            help: "Multiply the environment, also the file's own: cd/m² per unit of the map or colour",
            ..EMITTER
        },
        get: |o| Some(Value::single(o.emitters.environment_strength)),
        set: |o, value| o.emitters.environment_strength = value.real(),
    },
    Entry {
        about: About {
            name: "environment-rotation",
            kind: Kind::Real(Range::Any),
            value_name: "DEGREES",
            help: "Turn the environment about +Y, also the file's own; counter-clockwise seen from above",
            ..EMITTER
        },
        get: |o| Some(Value::single(o.emitters.environment_rotation)),
        set: |o, value| o.emitters.environment_rotation = value.real(),
    },
    Entry {
        about: EMITTER_TABLE[0].about,
        get: |o| (EMITTER_TABLE[0].get)(&o.emitters.options),
        set: |o, value| (EMITTER_TABLE[0].set)(&mut o.emitters.options, value),
    },
    Entry {
        about: EMITTER_TABLE[1].about,
        get: |o| (EMITTER_TABLE[1].get)(&o.emitters.options),
        set: |o, value| (EMITTER_TABLE[1].set)(&mut o.emitters.options, value),
    },
    Entry {
        about: About {
            name: "threads",
            kind: Kind::Whole(1, 4096),
            value_name: "N",
            group: Group::Machine,
            help: "Threads; at most 4 for each core, or 64 where that is more",
            default_note: Some("one per core"),
            ..EMITTER
        },
        get: |o| o.threads.map(|threads| Value::Whole(threads.into())),
        set: |o, value| o.threads = Some(value.whole() as u32),
    },
];

/// An option that both faces have: what users are told of it, and its default.
#[derive(Clone, Debug)]
pub struct Choice {
    /// What users are told of it.
    pub about: About,
    /// Its default; `None` where it depends on others, or is nothing.
    pub default: Option<Value>,
}

/// Returns every option that both faces have, in the order of `--help`.
pub fn choices() -> Vec<Choice> {
    // What depends on the machine is told in words.
    let known = |entry: &Entry<RenderOptions>| entry.default().filter(|_| entry.about.default_note.is_none());
    let render = RENDER.iter().map(|entry| Choice { about: entry.about, default: known(entry) });
    let others = SURROUNDINGS.iter().map(|entry| Choice { about: entry.about, default: entry.default() });
    let mut all: Vec<Choice> = render.chain(others).collect();
    // Threads before memory; the order within the tables stays otherwise.
    all.sort_by_key(|choice| (choice.about.group as usize, choice.about.name == "max-memory"));
    all
}

/// Returns the option with this name, in either spelling, or that had it before.
pub fn choice(name: &str) -> Option<About> {
    let name = name.replace('_', "-");
    let is_it = |about: &About| about.name == name || about.old_name == Some(&name);
    RENDER.iter().map(|entry| entry.about).chain(SURROUNDINGS.iter().map(|entry| entry.about)).find(is_it)
}

/// Options that were chosen, by name; the others have their defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chosen {
    values: Vec<(&'static str, Value)>,
}

impl Chosen {
    /// Chooses an option, in place of what was chosen before.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a value outside its range, or of another type.
    pub fn choose(&mut self, about: &About, value: &Value) -> Result<(), Error> {
        let value = about.read(value)?;
        self.put(about.name, value);
        Ok(())
    }

    fn put(&mut self, name: &'static str, value: Value) {
        self.values.retain(|(other, _)| *other != name);
        self.values.push((name, value));
    }

    /// Chooses a method where nothing chosen says one: neither itself, nor an error or a quality.
    pub fn prefer_method(&mut self, method: Method) {
        if ["method", "error", "quality"].iter().all(|name| self.get(name).is_none()) {
            self.put("method", Value::text(method));
        }
    }

    /// Returns what was chosen, by the option's own name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.iter().find(|(own, _)| *own == name).map(|(_, value)| value)
    }

    /// Returns these, with the others in place of what both choose.
    pub fn over(&self, others: &Self) -> Self {
        let mut all = self.clone();
        // An error and a quality are one choice, and go with the method.
        if ["method", "error", "quality"].iter().any(|name| others.get(name).is_some()) {
            all.values.retain(|(name, _)| !["error", "quality"].contains(name));
        }
        others.values.iter().for_each(|(name, value)| all.put(name, value.clone()));
        all
    }

    /// Returns the library's options, but for a size that depends on the camera.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for options that do not go together.
    pub fn render_options(&self) -> Result<RenderOptions, Error> {
        let mut options = RenderOptions::chosen(|name| self.get(name))?;
        if self.get("max-memory").is_none() {
            options.limits.max_memory = machine::default_limit();
        }
        options.validate()?;
        Ok(options)
    }

    /// Returns what there is beside the library's options.
    pub fn surroundings(&self) -> Surroundings {
        let mut surroundings = Surroundings::default();
        for entry in &SURROUNDINGS {
            if let Some(value) = self.get(entry.about.name) {
                (entry.set)(&mut surroundings, value);
            }
        }
        surroundings
    }
}

/// Makes an argument of an option.
fn argument(Choice { about, default }: Choice) -> clap::Arg {
    let note = about.default_note.map_or(String::new(), |note| format!(" [default: {note}]"));
    let argument = clap::Arg::new(about.name)
        .long(about.name)
        .value_name(about.value_name)
        .help(format!("{}{note}", about.help))
        .help_heading(about.group.heading());
    let argument = about.old_name.into_iter().fold(argument, |argument, old| argument.alias(old));
    let argument = match default {
        Some(default) => argument.default_value(default.to_string()),
        None => argument,
    };
    let read = move |text: &str| about.kind.read(&Value::text(text));
    match about.kind {
        Kind::Word { words, aliases } => {
            let possible = words.iter().map(move |(word, help)| {
                let own = aliases.iter().filter(move |(_, own)| own == word).map(|(alias, _)| *alias);
                PossibleValue::new(*word).help(*help).aliases(own)
            });
            let parser = clap::builder::PossibleValuesParser::new(possible);
            argument.value_parser(clap::builder::TypedValueParser::try_map(parser, move |text: String| read(&text)))
        }
        Kind::Words(words) => {
            let possible = words.iter().map(|(word, help)| PossibleValue::new(*word).help(*help));
            let parser = clap::builder::PossibleValuesParser::new(possible);
            argument
                .action(clap::ArgAction::Append)
                .value_delimiter(',')
                .value_parser(clap::builder::TypedValueParser::map(parser, Value::Text))
        }
        Kind::Whole(..) => argument.value_parser(read).allow_negative_numbers(true),
        Kind::Real(_) | Kind::Size | Kind::Syntax { .. } => argument.value_parser(read).allow_hyphen_values(true),
    }
}

impl Args for Chosen {
    fn augment_args(command: clap::Command) -> clap::Command {
        command.args(choices().into_iter().map(argument))
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Chosen {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut chosen = Self::default();
        chosen.update_from_arg_matches(matches)?;
        Ok(chosen)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for Choice { about, .. } in choices() {
            if matches.value_source(about.name) != Some(ValueSource::CommandLine) {
                continue;
            }
            let values: Vec<&Value> = matches.get_many::<Value>(about.name).into_iter().flatten().collect();
            match (about.kind, values.as_slice()) {
                (Kind::Words(_), list) => {
                    let words: Vec<&str> = list.iter().map(|value| value.as_text()).collect();
                    self.put(about.name, Value::Text(words.join(",")));
                }
                (_, [.., value]) => self.put(about.name, (*value).clone()),
                (_, []) => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use lightmesh::Limits;

    use super::*;

    #[test]
    fn nothing_chosen_is_the_default() {
        let limits = Limits { max_memory: machine::default_limit() };
        // Beside the library's, the method *auto*, and samples that follow the noise.
        let options = RenderOptions { limits, method: Method::AUTO, ..RenderOptions::default() };
        let options = options.with(|o| o.picture.most_spp = Some(64));
        assert_eq!(Chosen::default().render_options().expect("options"), options);
        assert_eq!(Chosen::default().surroundings(), Surroundings::default());
    }

    /// A later error takes the place of an earlier quality, and a later method of both.
    #[test]
    fn an_error_and_a_quality_are_one_choice() {
        let said = |name: &str, text: &str| {
            let mut chosen = Chosen::default();
            chosen.choose(&choice(name).expect("an option"), &Value::text(text)).expect("a value");
            chosen
        };
        let method = |chosen: Chosen| chosen.render_options().expect("options").method;
        assert_eq!(method(said("quality", "final").over(&said("error", "0.3"))), Method::with_error(0.3));
        assert_eq!(method(said("error", "0.3").over(&said("quality", "final"))), Method::with_error(0.02));
        assert_eq!(method(said("error", "0.3").over(&said("method", "hybrid"))), Method::Hybrid);
        let mut preferred = said("error", "0.3");
        preferred.prefer_method(Method::MESH);
        assert_eq!(method(preferred), Method::with_error(0.3));
    }

    #[test]
    fn names_are_found_in_either_spelling_and_by_the_old_name() {
        let name = |text| choice(text).map(|about| about.name);
        assert_eq!(name("indirect_spacing"), Some("indirect-spacing"));
        assert_eq!(name("light-radius"), Some("light-radius"));
        assert_eq!(name("graded"), Some("lod-distance"));
        assert_eq!(name("speed"), None);
        assert_eq!(choices().len(), RENDER.len() + SURROUNDINGS.len());
    }

    #[test]
    fn a_later_choice_counts() {
        let choose = |pairs: &[(&str, Value)]| {
            let mut chosen = Chosen::default();
            for (name, value) in pairs {
                chosen.choose(&choice(name).expect("an option"), value).expect("a value");
            }
            chosen
        };
        let base = choose(&[("seed", Value::Whole(1)), ("light_radius", Value::single(0.1))]);
        let all = base.over(&choose(&[("seed", Value::Whole(2)), ("threads", Value::Whole(3))]));
        assert_eq!(all.render_options().expect("options").seed, 2);
        assert_eq!((all.surroundings().threads, all.surroundings().emitters.options.light_radius), (Some(3), 0.1));
    }
}
