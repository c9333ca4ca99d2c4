//! How emitters become light samples.

use crate::Error;
use crate::options::schema::{About, Entry, Group, Kind, Range, Value};

/// How emitters become light samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterOptions {
    /// Samples per area light (all triangles of an emissive mesh together), per spherical light and per environment; 1
    /// to 65536.
    pub light_samples: u32,
    /// Punctual lights become spheres of this radius (metres) and equal power; 0 leaves them points.
    pub light_radius: f32,
}

impl Default for EmitterOptions {
    fn default() -> Self {
        Self { light_samples: 64, light_radius: 0.0 }
    }
}

impl EmitterOptions {
    /// Every field, as [`crate::schema::RENDER`] has those of a render.
    pub const TABLE: [Entry<Self>; 2] = [
        Entry {
            about: About {
                name: "light-samples",
                kind: Kind::Whole(1, 1 << 16),
                value_name: "N",
                group: Group::Emitters,
                help: "Light samples of a usual lamp with a size and of a sky, 1 to 65536; small lamps get fewer, \
                       those close to surfaces more",
                ..About::PLAIN
            },
            get: |o| Some(Value::Whole(o.light_samples.into())),
            set: |o, value| o.light_samples = value.whole() as u32,
        },
        Entry {
            about: About {
                name: "light-radius",
                kind: Kind::Real(Range::NotNegative),
                value_name: "METRES",
                group: Group::Emitters,
                help: "Make the file's punctual lights spheres of this radius, in metres, and equal power; 0: points",
                ..About::PLAIN
            },
            get: |o| Some(Value::single(o.light_radius)),
            set: |o, value| o.light_radius = value.real(),
        },
    ];

    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] names the first field outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        Self::TABLE.iter().try_for_each(|entry| entry.check(self))
    }
}
