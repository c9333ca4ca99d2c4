//! The indirect field: formula (4) at the points of its own, coarser mesh, bounce by bounce, and formula (6) over them.
//!
//! T_k is the light that arrives after k diffuse reflections or fewer, without direct light and other light that light
//! samples stand for: T_0 is the emission that gather rays find, and
//!
//! > T_k(x) = gather(Le + a/π (E + T_{k−1})), k = 1 … N,
//!
//! with E the direct irradiance at the surfaces that the rays hit, a their albedo. T_k of a point depends on T_{k−1}
//! of all points that its rays read, never on the order in which points were filled; every bounce is kept, so that
//! points that are marked later can be computed from those that are there.

use glam::{Vec3, Vec4};

use super::spots::BrightSpots;
use crate::geometry::Aabb;
use crate::interaction::ShadingPoint;
use crate::mesh::{AmbientCube, CachedReader, CornerVisibility, Interpolator, Levels, Marks, Points, ReadResult};
use crate::world::FieldMemory;
use crate::{MeshStats, RenderOptions, Scene};

/// Indirect light at points of its mesh.
#[derive(Debug)]
pub(crate) struct IndirectField {
    pub(crate) points: Points,
    pub(crate) faces: CubeFaces,
    pub(crate) gather_rays: u32,
    /// How far gather rays follow mirrors and glass.
    pub(crate) depth: u32,
    pub(crate) seed: u64,
    /// T_k by bounce, [`CubeFaces::count`] values a point.
    pub(crate) bounce_values: Vec<Vec<Vec4>>,
    /// Sum and number of the direct irradiances at gather hits (mean over channels).
    pub(crate) gather_hit_irradiance: (f64, u64),
    pub(crate) memory: FieldMemory,
    /// Where gather rays look for light beside the even ones.
    pub(crate) spots: BrightSpots,
}

/// What a point keeps of a bounce.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CubeFaces {
    /// Irradiance on planes that face ±x, ±y, ±z.
    Six,
    /// The paper's IndirectLight(x) = ∫ L dω: a quarter of it is the irradiance on any plane, were the light even.
    One,
}

impl CubeFaces {
    pub(crate) fn of(options: &RenderOptions) -> Self {
        if options.method.is_paper() { Self::One } else { Self::Six }
    }

    /// Values per point and bounce.
    pub(crate) fn count(self) -> usize {
        match self {
            Self::Six => 6,
            Self::One => 1,
        }
    }
}

/// What a surface point reads from the indirect mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum IndirectReading {
    /// Irradiance, lux.
    Irradiance(Vec3),
    /// No mesh point around it can serve.
    Unavailable,
    /// Mesh points are missing; they have been marked.
    Pending,
}

impl IndirectField {
    pub(crate) fn new(
        scene: &Scene,
        levels: Levels,
        interpolator: Interpolator,
        gather_rays: u32,
        options: &RenderOptions,
        memory: FieldMemory,
    ) -> Self {
        // The paper's rays are even.
        let faces = CubeFaces::of(options);
        let bounds = levels.focus.map_or(scene.bounds(), |focus| Aabb { min: focus.min.into(), max: focus.max.into() });
        let spots = if faces == CubeFaces::Six { BrightSpots::find(scene, &bounds) } else { BrightSpots::default() };
        Self {
            spots,
            points: Points::new(levels, interpolator),
            faces,
            gather_rays,
            depth: options.transport.depth,
            seed: options.seed,
            bounce_values: vec![Vec::new(); options.transport.bounces as usize + 1],
            gather_hit_irradiance: (0.0, 0),
            memory,
        }
    }

    /// Where its points are, to be refined.
    pub(crate) fn points_mut(&mut self) -> &mut Points {
        &mut self.points
    }

    /// Where its points are.
    pub(crate) fn points(&self) -> &Points {
        &self.points
    }

    pub(crate) fn stats(&self) -> MeshStats {
        let values: usize = self.bounce_values.iter().map(|values| size_of_val(values.as_slice())).sum();
        self.points.stats(values as u64)
    }

    /// T_k of a point, of the `values` of all points, as irradiance on a plane with the normal of `cube`.
    #[inline(always)]
    pub(super) fn irradiance(&self, values: &[Vec4], index: u32, cube: &AmbientCube) -> Vec4 {
        match self.faces {
            CubeFaces::Six => {
                let values = &values[index as usize * 6..][..6];
                let [x, y, z] = cube.faces;
                values[x] * cube.squares.x + values[y] * cube.squares.y + values[z] * cube.squares.z
            }
            CubeFaces::One => values[index as usize] * 0.25,
        }
    }

    /// A reader, for one thread, of the light of `bounces` reflections or fewer.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, bounces: u32, sight: CornerVisibility) -> IndirectReader<'a> {
        IndirectReader {
            field: self,
            values: &self.bounce_values[bounces as usize],
            cached: CachedReader::new(self.points.reader(scene, sight)),
        }
    }

    /// Estimates what bounces after the last one would add, as a part of all light that arrives, their own included:
    /// as if the last bounces' ratio went on for ever. Returns 0 where there is no indirect light, `None` where the
    /// ratio is 1 or more.
    pub(crate) fn truncated_light(&self, bounces: u32) -> Option<f64> {
        let mean = |bounce: usize| {
            let values = &self.bounce_values[bounce];
            let sum: f64 = values.iter().map(|v| f64::from(v.truncate().element_sum())).sum();
            sum / 3.0 / values.len().max(1) as f64 / if self.faces == CubeFaces::One { 4.0 } else { 1.0 }
        };
        let n = bounces as usize;
        let direct = self.gather_hit_irradiance.0 / self.gather_hit_irradiance.1.max(1) as f64;
        let total = direct + mean(n);
        if n == 0 || total <= 0.0 {
            return Some(0.0);
        }
        let last = mean(n) - mean(n - 1);
        let before = if n == 1 { direct + mean(0) } else { mean(n - 1) - mean(n - 2) };
        further_bounces(total, last, before)
    }
}

/// Returns what bounces after the last one would add, as a part of all light with it, if the ratio of the last two, `last` and
/// `before`, went on for ever: rest = last · q / (1 − q), q = last / before. `None` where q is 1 or more.
pub(crate) fn further_bounces(total: f64, last: f64, before: f64) -> Option<f64> {
    if last <= 0.0 {
        return Some(0.0);
    }
    let ratio = last / before;
    let rest = last * ratio / (1.0 - ratio);
    (before > 0.0 && ratio < 1.0).then(|| rest / (total + rest))
}

/// Reads the field vertex by vertex. Neighbouring vertices mostly share cell and normal: what the corners know about
/// surfaces of that normal is kept.
pub(crate) struct IndirectReader<'a> {
    field: &'a IndirectField,
    values: &'a [Vec4],
    cached: CachedReader<'a, Vec4>,
}

impl IndirectReader<'_> {
    /// Returns Ĩ_d(y), formula (6); points that are still empty are marked.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, marks: &Marks) -> IndirectReading {
        let Self { field, values, cached } = self;
        let sum = cached.fold(
            vertex,
            marks,
            (Vec4::ZERO, 0.0),
            |index| field.irradiance(values, index, &AmbientCube::facing(vertex.n)),
            |(sum, total), irradiance, weight| (sum + irradiance * weight, total + weight),
        );
        match sum {
            Ok((sum, total)) => IndirectReading::Irradiance(sum.truncate() / total),
            Err(ReadResult::Pending) => IndirectReading::Pending,
            Err(_) => IndirectReading::Unavailable,
        }
    }

    /// Returns the irradiance at the vertex on planes that face ±x, ±y, ±z, by what it reads for its own normal; `None` where
    /// [`Self::read`] has none, and of a mesh without directions.
    pub(super) fn read_cube(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Option<[Vec4; 6]> {
        if self.field.faces == CubeFaces::One {
            return None;
        }
        let (values, mut sums, mut total) = (self.values, [Vec4::ZERO; 6], 0.0);
        let read = self.cached.reader.read(vertex, marks, |index, weight| {
            let faces = &values[index as usize * 6..][..6];
            sums.iter_mut().zip(faces).for_each(|(sum, &face)| *sum += face * weight);
            total += weight;
        });
        (read == ReadResult::Value).then(|| sums.map(|sum| sum / total))
    }

    /// Returns how many rays have been traced so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        self.cached.reader.visibility_rays()
    }
}
