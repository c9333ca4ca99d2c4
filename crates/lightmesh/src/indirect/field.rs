//! The indirect field: formula (4) at the points of its own, coarser mesh, bounce by bounce, and formula (6) over them.
//!
//! Level k is the light that arrives after k diffuse reflections or fewer, direct light and light that is sampled from lamps
//! left out: T_0 is the emission that gather rays find, and
//!
//! > T_k(x) = gather(Le + a/π (E + T_{k−1})), k = 1 … N,
//!
//! with E the direct irradiance at the surfaces that the rays hit, a their albedo. A point's levels depend on the whole level
//! below, never on the order in which points were asked for; all of them are kept, so that points that are asked for later
//! can be computed from those that are there.

use glam::{Vec3, Vec4};

use crate::interaction::ShadingPoint;
use crate::mesh::{
    AmbientCube, CornerValues, CornerVisibility, Interpolator, Lattice, Marks, Points, ReadResult, Reader, set_bits,
};
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
    /// T_k by level, [`CubeFaces::count`] values a point.
    pub(crate) bounce_values: Vec<Vec<Vec4>>,
    /// Sum and number of the direct irradiances at gather hits (mean over channels).
    pub(crate) gather_hit_irradiance: (f64, u64),
    pub(crate) max_memory: u64,
}

/// What a point keeps of a level.
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

    /// Values per point and level.
    pub(crate) fn count(self) -> usize {
        match self {
            Self::Six => 6,
            Self::One => 1,
        }
    }
}

/// What a vertex finds in the indirect mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum IndirectReading {
    /// Irradiance, lux.
    Irradiance(Vec3),
    /// No point of the neighbourhood can be used.
    Unavailable,
    /// Points are missing; they have been marked.
    Pending,
}

impl IndirectField {
    pub(crate) fn new(lattices: Vec<Lattice>, neighbourhood: Interpolator, options: &RenderOptions) -> Self {
        Self {
            points: Points::new(lattices, neighbourhood),
            faces: CubeFaces::of(options),
            gather_rays: options.mesh.gather_rays,
            depth: options.transport.depth,
            seed: options.seed,
            bounce_values: vec![Vec::new(); options.transport.bounces as usize + 1],
            gather_hit_irradiance: (0.0, 0),
            max_memory: options.limits.max_memory,
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
        let values: usize = self.bounce_values.iter().map(|level| size_of_val(level.as_slice())).sum();
        self.points.stats(values as u64)
    }

    /// T_level of a point as irradiance on a plane whose normal the axes describe.
    #[inline(always)]
    pub(super) fn irradiance(&self, level: &[Vec4], index: u32, axes: &AmbientCube) -> Vec4 {
        match self.faces {
            CubeFaces::Six => {
                let values = &level[index as usize * 6..][..6];
                let [x, y, z] = axes.faces;
                values[x] * axes.squares.x + values[y] * axes.squares.y + values[z] * axes.squares.z
            }
            CubeFaces::One => level[index as usize] * 0.25,
        }
    }

    /// A reader for one thread of what `bounces` reflections bring.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, bounces: u32, sight: CornerVisibility) -> IndirectReader<'a> {
        IndirectReader {
            field: self,
            values: &self.bounce_values[bounces as usize],
            reader: self.points.reader(scene, sight),
            known: CornerValues::default(),
            corners: [Vec4::ZERO; 8],
        }
    }

    /// An estimate of what bounces after the last one would add, as a part of all light that arrives, their own included: the
    /// last bounces' ratio goes on for ever. 0 where there is no indirect light; `None` where the ratio says nothing (1 or more).
    pub(crate) fn truncated_light(&self, bounces: u32) -> Option<f64> {
        let mean = |level: usize| {
            let values = &self.bounce_values[level];
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
        let ratio = last / before;
        if last <= 0.0 {
            return Some(0.0);
        }
        let rest = last * ratio / (1.0 - ratio);
        (ratio < 1.0).then(|| rest / (total + rest))
    }
}

/// Reads the field vertex by vertex. Neighbouring vertices mostly share cell and normal: what the corners know about surfaces of
/// that normal is kept.
pub(crate) struct IndirectReader<'a> {
    field: &'a IndirectField,
    values: &'a [Vec4],
    reader: Reader<'a>,
    known: CornerValues,
    /// Their irradiance; 0 where it is not known.
    corners: [Vec4; 8],
}

impl IndirectReader<'_> {
    /// Ĩ_d(y), formula (6); points that are still empty are marked.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, marks: &Marks) -> IndirectReading {
        let (mut sum, mut total) = (Vec4::ZERO, 0.0);
        if !self.reader.reads_cells() {
            return self.read_points(vertex, marks);
        }
        let seen = match self.reader.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(ReadResult::Pending) => return IndirectReading::Pending,
            Err(_) => return IndirectReading::Unavailable,
        };
        if seen.refined > 0.0 {
            return self.read_points(vertex, marks);
        }
        if !self.known.continues(vertex.n, self.reader.visits()) {
            // A curved surface: the next vertex has another normal.
            let axes = AmbientCube::facing(vertex.n);
            for k in set_bits(seen.mask) {
                let weight = seen.weights[k / 4][k % 4];
                sum += self.field.irradiance(self.values, self.reader.index(k), &axes) * weight;
                total += weight;
            }
            return IndirectReading::Irradiance(sum.truncate() / total);
        }
        self.know(seen.mask, vertex.n);
        // All eight: a corner that is not seen has no weight.
        for (z, weights) in seen.weights.iter().enumerate() {
            for (corner, weight) in self.corners[4 * z..].iter().zip(weights.to_array()) {
                sum += corner * weight;
                total += weight;
            }
        }
        IndirectReading::Irradiance(sum.truncate() / total)
    }

    /// The same, point by point.
    fn read_points(&mut self, vertex: &ShadingPoint, marks: &Marks) -> IndirectReading {
        let (mut sum, mut total) = (Vec4::ZERO, 0.0);
        let axes = AmbientCube::facing(vertex.n);
        let outcome = self.reader.read(vertex, marks, |index, weight| {
            sum += self.field.irradiance(self.values, index, &axes) * weight;
            total += weight;
        });
        match outcome {
            ReadResult::Value => IndirectReading::Irradiance(sum.truncate() / total),
            ReadResult::Unavailable => IndirectReading::Unavailable,
            ReadResult::Pending => IndirectReading::Pending,
        }
    }

    /// Sums up the corners of `mask` for the normal, those that are not known yet.
    #[inline(always)]
    fn know(&mut self, mask: u8, n: Vec3) {
        if self.known.is_empty() {
            self.corners = [Vec4::ZERO; 8];
        }
        let axes = AmbientCube::facing(n);
        for k in self.known.add(mask) {
            self.corners[k] = self.field.irradiance(self.values, self.reader.index(k), &axes);
        }
    }

    /// Rays shot so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        self.reader.visibility_rays()
    }
}
