//! The one table of options: the command line, Python, files and messages take names, ranges, defaults and help from
//! here.

pub use super::limits::{parse_bytes, spell_bytes};
pub use super::value::{Kind, Range, Value, Word, closest};
use super::{
    Aov, Expected, Falloff, Interpolation, Method, PaperScale, PictureOptions, PointWeight, Quality, RenderOptions,
    Spacing, limits, method,
};
use crate::Error;

/// Under which heading `--help` lists an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The picture and its files.
    Output,
    /// How light is computed.
    Light,
    /// Light with a size.
    Emitters,
    /// Where mesh points are, and how they are read.
    Mesh,
    /// Threads and memory.
    Machine,
}

impl Group {
    /// All of them, in the order of `--help`.
    pub const ALL: [Self; 5] = [Self::Output, Self::Light, Self::Emitters, Self::Mesh, Self::Machine];

    /// Returns the heading.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Output => "Output",
            Self::Light => "Light",
            Self::Emitters => "Emitters",
            Self::Mesh => "Light mesh",
            Self::Machine => "Machine",
        }
    }
}

/// What users are told of an option.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Its name as the command line spells it; Python has underscores for the dashes.
    pub name: &'static str,
    /// A name that it had before, which is still taken; and its key in the settings of files, which keeps that name.
    pub old_name: Option<&'static str>,
    /// Type and range.
    pub kind: Kind,
    /// What `--help` calls its value.
    pub value_name: &'static str,
    /// The heading in `--help`.
    pub group: Group,
    /// What it is, for the command line.
    pub help: &'static str,
    /// The default where it depends on other options or on the scene; that of the table then says nothing.
    pub default_note: Option<&'static str>,
    /// The methods that it is for; empty: all.
    pub methods: &'static [&'static str],
    /// The version that had it first.
    pub since: &'static str,
}

impl About {
    /// What an option is if nothing else is said: one of all methods, since the first version.
    pub const PLAIN: Self = Self {
        name: "",
        old_name: None,
        kind: Kind::Size,
        value_name: "",
        group: Group::Light,
        help: "",
        default_note: None,
        methods: &[],
        since: "0.1",
    };

    /// Returns its key in the settings of files.
    pub fn key(&self) -> &'static str {
        self.old_name.unwrap_or(self.name)
    }

    /// Returns its name as Python spells it.
    pub fn python_name(&self) -> String {
        self.name.replace('-', "_")
    }

    /// Returns the value as the option holds it.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a value outside its range, or of another type.
    pub fn read(&self, given: &Value) -> Result<Value, Error> {
        self.kind.read(given).map_err(|what| Error::InvalidOption { option: self.name, what })
    }
}

/// An option of some `T`: what users are told of it, and where it is kept.
#[derive(Debug)]
pub struct Entry<T> {
    /// What users are told of it.
    pub about: About,
    /// Returns the value; `None` where there is none.
    pub get: fn(&T) -> Option<Value>,
    /// Sets it to a value that [`About::read`] returned. An option that the chosen method does not have is left out.
    pub set: fn(&mut T, &Value),
}

impl<T> Entry<T> {
    /// Refuses a value outside the range.
    ///
    /// # Errors
    /// [`Error::InvalidOption`].
    pub fn check(&self, options: &T) -> Result<(), Error> {
        (self.get)(options).map_or(Ok(()), |value| self.about.read(&value).map(drop))
    }

    /// Returns the default: what [`Default`] has, unless it depends on other options.
    pub fn default(&self) -> Option<Value>
    where
        T: Default,
    {
        (self.get)(&T::default()).filter(|value| self.about.default_note.is_none() && *value != Value::text(""))
    }
}

/// The methods with a mesh.
const MESHES: &[&str] = &["auto", "mesh", "paper", "hybrid", "unbiased"];

/// The syntax of a type that reads and spells itself.
const fn syntax(normal: fn(&str) -> Option<String>, expected: &'static str, numbers: bool) -> Kind {
    Kind::Syntax { normal, expected, numbers }
}

fn normal<T: std::str::FromStr<Err = Expected> + std::fmt::Display>(text: &str) -> Option<String> {
    text.parse::<T>().ok().map(|value| value.to_string())
}

/// Reads a text back that was checked.
pub(super) fn parsed<T: std::str::FromStr + Default>(value: &Value) -> T {
    value.as_text().parse().unwrap_or_default()
}

const SPACING: Kind = syntax(normal::<Spacing>, Spacing::EXPECTED, true);
const FALLOFF: Kind = syntax(normal::<Falloff>, Falloff::EXPECTED, false);
const SECONDS: Kind = syntax(
    |text| PictureOptions::parse_seconds(text).map(|limit| limit.as_secs_f64().to_string()),
    PictureOptions::EXPECTED_SECONDS,
    true,
);
const BYTES: Kind = syntax(|text| limits::parse_bytes(text).map(limits::spell_bytes), limits::EXPECTED_BYTES, true);

/// Every field of [`RenderOptions`], in the order of `--help`.
pub const RENDER: [Entry<RenderOptions>; 26] = [
    Entry {
        about: About {
            name: "size",
            value_name: "WxH",
            group: Group::Output,
            help: "Width and height in pixels",
            default_note: Some("1280 wide, height from the camera's aspect"),
            ..About::PLAIN
        },
        get: |o| Some(Value::Text(format!("{}x{}", o.picture.width, o.picture.height))),
        set: |o, value| {
            if let Some((width, height)) = PictureOptions::parse_size(value.as_text()) {
                (o.picture.width, o.picture.height) = (width, height);
            }
        },
    },
    Entry {
        about: About {
            name: "aov",
            kind: Kind::Words(&Aov::NAMES),
            value_name: "LIST",
            group: Group::Output,
            help: "Layers that .exr files get beside the light (docs/aov.md), separated by commas",
            ..About::PLAIN
        },
        get: |o| {
            let names: Vec<&str> = o.picture.aovs.iter().map(Aov::name).collect();
            Some(Value::Text(names.join(",")))
        },
        set: |o, value| o.picture.aovs = value.as_text().split(',').filter_map(Aov::named).collect(),
    },
    Entry {
        about: About {
            name: "method",
            kind: Kind::Word { words: &method::NAMES, aliases: &method::ALIASES },
            value_name: "METHOD",
            help: "How light is computed",
            default_note: Some("auto; mesh with an --interpolation that single lights are not read by"),
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.method)),
        set: |o, value| {
            if let Some(method) = Method::named(value.as_text()) {
                o.method = method;
            }
        },
    },
    Entry {
        about: About {
            name: "quality",
            kind: Kind::Word { words: &Quality::NAMES, aliases: &[] },
            value_name: "QUALITY",
            help: "How good the picture is to be, with --method auto",
            default_note: Some("normal"),
            methods: &["auto"],
            since: "0.2",
            ..About::PLAIN
        },
        get: |o| Quality::of(o.method).map(|quality| Value::text(quality.name())),
        set: |o, value| {
            if let (Method::Auto { error }, Some(quality)) = (&mut o.method, Quality::named(value.as_text())) {
                *error = quality.error();
            }
        },
    },
    Entry {
        about: About {
            name: "error",
            kind: Kind::Real(Range::Positive),
            value_name: "E",
            help: "Keep the error of the picture, relative to its mean, at most so large (0.05 is 5%), in place of --quality",
            default_note: Some("that of --quality"),
            methods: &["auto", "mesh"],
            ..About::PLAIN
        },
        get: |o| o.method.error().map(Value::single),
        set: |o, value| match &mut o.method {
            Method::Auto { error } => *error = value.real(),
            Method::Mesh { error } => *error = Some(value.real()),
            _ => {}
        },
    },
    Entry {
        about: About {
            name: "spp",
            kind: Kind::Whole(1, PictureOptions::MOST_SPP as u64),
            value_name: "N",
            help: "Samples per pixel, 1 to 65536; box filter of one pixel; 1 samples the pixel's centre",
            default_note: Some(
                "4, and up to 64 where there is noise (--most-spp), with --quality preview 2 to 16; with --time-limit, which makes it the most, 65536",
            ),
            ..About::PLAIN
        },
        get: |o| Some(Value::Whole(o.picture.spp.into())),
        set: |o, value| o.picture.spp = value.whole() as u32,
    },
    Entry {
        about: About {
            name: "most-spp",
            kind: Kind::Whole(1, PictureOptions::MOST_SPP as u64),
            value_name: "N",
            help: "Most samples of a pixel: those with most noise, on outlines and where few rays are not enough, get more \
                   than --spp, until the noise of the picture is about half of the error, or 2.5% of its mean",
            default_note: Some("64; with --spp or --time-limit the same number for all"),
            methods: &["auto", "mesh", "paper", "hybrid", "standard"],
            since: "0.2",
            ..About::PLAIN
        },
        get: |o| o.picture.most_spp.map(|most| Value::Whole(most.into())),
        set: |o, value| o.picture.most_spp = Some(value.whole() as u32),
    },
    Entry {
        about: About {
            name: "time-limit",
            kind: SECONDS,
            value_name: "SECONDS",
            help: "Take samples until the render, from the built scene on, has taken this long; every pixel gets one, \
                   however long that takes. How many there are in time is never quite the same, and nor is the picture",
            ..About::PLAIN
        },
        get: |o| o.picture.time_limit.map(|limit| Value::text(limit.as_secs_f64())),
        set: |o, value| o.picture.time_limit = PictureOptions::parse_seconds(value.as_text()),
    },
    Entry {
        about: About {
            name: "bounces",
            kind: Kind::Whole(0, 4096),
            value_name: "N",
            help: "Diffuse interreflections, 0 to 4096; 0: direct light only; 1: the paper; --method standard \
                   computes none",
            methods: &["auto", "mesh", "paper", "hybrid", "unbiased", "path"],
            ..About::PLAIN
        },
        get: |o| Some(Value::Whole(o.transport.bounces.into())),
        set: |o, value| o.transport.bounces = value.whole() as u32,
    },
    Entry {
        about: About {
            name: "depth",
            kind: Kind::Whole(0, u32::MAX as u64),
            value_name: "N",
            help: "Mirror and refraction events that a ray may meet in a row",
            ..About::PLAIN
        },
        get: |o| Some(Value::Whole(o.transport.depth.into())),
        set: |o, value| o.transport.depth = value.whole() as u32,
    },
    Entry {
        about: About {
            name: "cutoff",
            kind: Kind::Real(Range::Fraction),
            value_name: "FRACTION",
            help: "Drop mirrored and refracted rays that carry less than this fraction of the light, 0 to below 1",
            ..About::PLAIN
        },
        get: |o| Some(Value::single(o.transport.cutoff)),
        set: |o, value| o.transport.cutoff = value.real(),
    },
    Entry {
        about: About {
            name: "falloff",
            kind: FALLOFF,
            value_name: "r2|C+r",
            help: "Attenuation of light with distance: r2 (physical) or C+r, C in metres (the paper's phi 3)",
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.transport.falloff)),
        set: |o, value| o.transport.falloff = parsed(value),
    },
    Entry {
        about: About {
            name: "light-error",
            kind: Kind::Real(Range::Fraction),
            value_name: "FRACTION",
            help: "Error of the sum over more than 512 lights or light samples, as a part of all light that arrives \
                   at a place, 0 to below 1; 0: every light by itself, as --method standard and path always do",
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| Some(Value::single(o.transport.light_error)),
        set: |o, value| o.transport.light_error = value.real(),
    },
    Entry {
        about: About {
            name: "seed",
            kind: Kind::Whole(0, u64::MAX),
            value_name: "N",
            help: "Seed of all randomness",
            ..About::PLAIN
        },
        get: |o| Some(Value::Whole(o.seed)),
        set: |o, value| o.seed = value.whole(),
    },
    Entry {
        about: About {
            name: "spacing",
            kind: SPACING,
            value_name: "METRES|1/K|auto",
            group: Group::Mesh,
            help: "Distance between mesh points: metres, 1/K of the longest edge of the scene's box, or auto: 1/64 of the room that the camera sees, up to 1/128 with fewer than 15 light samples (not with --method paper), and coarser away from it",
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.mesh.spacing)),
        set: |o, value| o.mesh.spacing = parsed(value),
    },
    Entry {
        about: About {
            name: "indirect-spacing",
            kind: SPACING,
            value_name: "METRES|1/K|auto",
            group: Group::Mesh,
            help: "Distance between points of the indirect mesh; auto is 1/30, with 64 lamps or more 1/45",
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.mesh.indirect_spacing)),
        set: |o, value| o.mesh.indirect_spacing = parsed(value),
    },
    Entry {
        about: About {
            name: "gather-rays",
            kind: Kind::Whole(1, 1 << 16),
            value_name: "N",
            group: Group::Mesh,
            help: "Rays that gather light at a point of the indirect mesh, 1 to 65536; half as many by default where auto \
                   spacing is 1/45",
            default_note: Some("256"),
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| o.mesh.gather_rays.map(|rays| Value::Whole(rays.into())),
        set: |o, value| o.mesh.gather_rays = Some(value.whole() as u32),
    },
    Entry {
        about: About {
            name: "near-rays",
            kind: Kind::Whole(0, 1 << 16),
            value_name: "N",
            group: Group::Mesh,
            help: "Short rays per pixel that find the indirect light and shade of what is nearer than 1.5 spacings of \
                   the indirect mesh, 0 to 65536; 0: what the mesh says",
            default_note: Some("16; with --quality preview 8"),
            methods: &["auto", "mesh", "hybrid"],
            since: "0.2",
            ..About::PLAIN
        },
        get: |o| Some(Value::Whole(o.mesh.near_rays.into())),
        set: |o, value| o.mesh.near_rays = value.whole() as u32,
    },
    Entry {
        about: About {
            name: "refine",
            kind: Kind::Whole(0, 4),
            value_name: "N",
            group: Group::Mesh,
            help: "How often the meshes may halve their spacing where their light is not good enough, 0 to 4",
            default_note: Some("0"),
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| o.mesh.refine.map(|times| Value::Whole(times.into())),
        set: |o, value| o.mesh.refine = Some(value.whole() as u32),
    },
    Entry {
        about: About {
            name: "lod-distance",
            old_name: Some("graded"),
            kind: Kind::Real(Range::Positive),
            value_name: "METRES",
            group: Group::Mesh,
            help: "Let the meshes' density fall with the distance from the camera: nearer than this half the spacing, \
                   nearer than half of it a quarter, nearer than a quarter of it an eighth",
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| o.mesh.lod_distance.map(Value::single),
        set: |o, value| o.mesh.lod_distance = Some(value.real()),
    },
    Entry {
        about: About {
            name: "rays",
            kind: Kind::Whole(1, 1 << 16),
            value_name: "N",
            group: Group::Mesh,
            help: "Shadow rays, and gather rays if there are bounces, at each hit with --method unbiased, 1 to 65536",
            methods: &["unbiased"],
            ..About::PLAIN
        },
        get: |o| match (o.method, Method::UNBIASED) {
            (Method::Unbiased { rays }, _) | (_, Method::Unbiased { rays }) => Some(Value::Whole(rays.into())),
            _ => None,
        },
        set: |o, value| {
            if let Method::Unbiased { rays } = &mut o.method {
                *rays = value.whole() as u32;
            }
        },
    },
    Entry {
        about: About {
            name: "interpolation",
            kind: syntax(normal::<Interpolation>, Interpolation::EXPECTED, false),
            value_name: "WHICH",
            group: Group::Mesh,
            help: "Mesh points that a surface reads: trilinear, nearest, or sphere[:R], R in spacings, at most 16 \
                   (sphere: 1.5); auto: trilinear, with --method paper sphere. trilinear:RULE is the paper's: corners \
                   behind the surface count as zero or one (no or all light), or as the nearest or the mirror corner \
                   does; with --method mesh and paper",
            methods: MESHES,
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.mesh.interpolation)),
        set: |o, value| o.mesh.interpolation = parsed(value),
    },
    Entry {
        about: About {
            name: "weight",
            kind: Kind::Word { words: &PointWeight::NAMES, aliases: &[] },
            value_name: "WEIGHT",
            group: Group::Mesh,
            help: "How much each point of the sphere counts (phi 4 and phi 5), with --interpolation sphere",
            methods: &["mesh", "paper"],
            ..About::PLAIN
        },
        get: |o| Some(Value::text(o.mesh.weight.name())),
        set: |o, value| o.mesh.weight = PointWeight::named(value.as_text()).unwrap_or_default(),
    },
    Entry {
        about: About {
            name: "field-falloff",
            kind: FALLOFF,
            value_name: "r2|C+r",
            group: Group::Mesh,
            help: "Attenuation inside the direct field of --method paper (phi 1)",
            methods: &["paper"],
            ..About::PLAIN
        },
        get: |o| match (o.method, Method::PAPER) {
            (Method::Paper { field_falloff, .. }, _) | (_, Method::Paper { field_falloff, .. }) => {
                Some(Value::text(field_falloff))
            }
            _ => None,
        },
        set: |o, value| {
            if let Method::Paper { field_falloff, .. } = &mut o.method {
                *field_falloff = parsed(value);
            }
        },
    },
    Entry {
        about: About {
            name: "paper-scale",
            kind: Kind::Word { words: &PaperScale::NAMES, aliases: &[] },
            value_name: "PAPER_SCALE",
            group: Group::Mesh,
            help: "Scale of the mean in --method paper",
            methods: &["paper"],
            ..About::PLAIN
        },
        get: |o| match (o.method, Method::PAPER) {
            (Method::Paper { scale, .. }, _) | (_, Method::Paper { scale, .. }) => Some(Value::text(scale.name())),
            _ => None,
        },
        set: |o, value| {
            if let Method::Paper { scale, .. } = &mut o.method {
                *scale = PaperScale::named(value.as_text()).unwrap_or_default();
            }
        },
    },
    Entry {
        about: About {
            name: "max-memory",
            kind: BYTES,
            value_name: "SIZE",
            group: Group::Machine,
            help: "Most memory that the scene, its picture and its mesh may take together, in B, KB, MB, GB, KiB, MiB or \
                   GiB; more is an error before allocation",
            default_note: Some("half of the machine's, or of its control group's"),
            ..About::PLAIN
        },
        get: |o| Some(Value::Text(limits::spell_bytes(o.limits.max_memory))),
        set: |o, value| o.limits.max_memory = limits::parse_bytes(value.as_text()).unwrap_or(o.limits.max_memory),
    },
];

/// Returns the option of [`RENDER`] with this name, or that had it before.
pub fn named(name: &str) -> Option<&'static Entry<RenderOptions>> {
    const TABLE: &[Entry<RenderOptions>] = &RENDER;
    TABLE.iter().find(|entry| entry.about.name == name || entry.about.old_name == Some(name))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// What a test may set each option to: something else than the default.
    fn other(about: &About) -> Value {
        match about.kind {
            Kind::Whole(min, _) => Value::Whole(min + 2),
            Kind::Real(_) => Value::single(0.5),
            Kind::Word { words, .. } => Value::text(words[words.len() - 1].0),
            Kind::Words(words) => Value::text(words[2].0),
            Kind::Size => Value::text("64x48"),
            Kind::Syntax { .. } => Value::text(match about.name {
                "time-limit" => "2.5",
                "spacing" | "indirect-spacing" => "1/80",
                "interpolation" => "sphere:2.5",
                "max-memory" => "1GiB",
                _ => "0.1+r",
            }),
        }
    }

    #[test]
    fn every_option_holds_what_it_is_set_to() {
        for entry in &RENDER {
            let method = entry.about.methods.first().copied().and_then(Method::named).unwrap_or_default();
            let mut options = RenderOptions { method, ..RenderOptions::default() };
            let value = entry.about.read(&other(&entry.about)).expect("in range");
            assert_ne!((entry.get)(&options), Some(value.clone()), "{}", entry.about.name);
            (entry.set)(&mut options, &value);
            assert_eq!((entry.get)(&options), Some(value), "{}", entry.about.name);
            // A quality is an error by name.
            let is_same = |name| name == entry.about.name || ["error", "quality"].contains(&name);
            let mut others = RENDER.iter().filter(|other| !is_same(other.about.name));
            let before = RenderOptions { method: options.method, ..RenderOptions::default() };
            assert!(others.all(|other| (other.get)(&options) == (other.get)(&before) || entry.about.name == "method"));
        }
    }

    #[test]
    fn names_are_unique_and_methods_exist() {
        let names: BTreeSet<&str> = RENDER.iter().map(|entry| entry.about.name).collect();
        assert_eq!(names.len(), RENDER.len());
        for About { help, methods, value_name, .. } in RENDER.iter().map(|entry| entry.about) {
            assert!(!help.is_empty() && !help.ends_with('.') && !value_name.is_empty(), "{help}");
            assert!(methods.iter().all(|method| Method::named(method).is_some()), "{help}");
        }
        assert_eq!(named("graded").map(|entry| entry.about.name), Some("lod-distance"));
    }

    /// Every option that the table has for fewer methods does nothing with the others.
    #[test]
    fn options_of_one_method_leave_the_others_alone() {
        for entry in RENDER.iter().filter(|entry| entry.about.methods.len() == 1) {
            for method in Method::ALL.into_iter().filter(|method| method.name() != entry.about.methods[0]) {
                let options = RenderOptions { method, ..RenderOptions::default() };
                let mut set = options.clone();
                (entry.set)(&mut set, &other(&entry.about));
                assert_eq!(set, options, "{}", entry.about.name);
            }
        }
    }
}
