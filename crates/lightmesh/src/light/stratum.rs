//! Which part of an emitter a light sample stands for.
//!
//! A light sample is a point or a direction in the middle of its *stratum*. Where light is to be exact, a shadow ray goes
//! to a random point of the stratum instead, with that point's own light: the expectation is the integral over the
//! emitter, whatever its triangles, its picture or the sky.

/// The part of an emitter that a light sample stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Stratum {
    /// A point or a direction: itself.
    #[default]
    Point,
    /// A part of the ball of a sphere light.
    Ball {
        /// Index of the punctual light.
        light: u32,
        part: u32,
    },
    /// A part of an emissive mesh or sphere.
    Area(u32),
    /// A whole small lamp that is a ball: its light sample is a point in its middle.
    Bulb(u32),
    /// A part of the sky.
    Sky(u32),
}

/// How far a stratum reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reach {
    /// Distance of its points from the light sample: metres, or of unit directions.
    pub radius: f32,
    /// Largest difference of its unit normals from that of the light sample.
    pub spread: f32,
}

/// The stratum of a light sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LaneStratum {
    pub stratum: Stratum,
    pub reach: Reach,
}
