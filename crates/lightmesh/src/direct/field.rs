//! The direct field: formula (1) at mesh points and formula (3g) over them.

use glam::{Vec3, Vec4};

use super::region_cuts::RegionCuts;
use super::visibility_bits::LightBits;
use super::visibility_runs::LightRuns;
use crate::interaction::ShadingPoint;
use crate::light::Directions;
use crate::mesh::{AmbientCube, Costs, Interpolator, Lattice, Marks, Points};
use crate::options::PointKind;
use crate::{Error, Falloff, MeshKey, MeshStats, PaperScale, RenderOptions, Scene};

/// What one mesh point keeps: per channel and axis a pair, light that arrives and light that would arrive if nothing were
/// in the way. Readers sum both over their neighbourhood and divide last, so that a point close to a lamp, which knows most
/// of the light, weighs most. (Dividing at each point instead costs half the memory; measured on the room of 15 / 100
/// lights at 1/80 of its length: error 6.0 / 3.5% instead of 5.0 / 2.9%.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DirectEncoding {
    /// A pair for each of ±x, ±y, ±z (an ambient cube).
    SixAxis {
        /// φ3: the weights of the lights are those of the sum that the ratio multiplies.
        falloff: Falloff,
    },
    /// None: readers ask for each light by itself.
    PerLight {
        /// φ3: which lights shine on a point at all.
        falloff: Falloff,
    },
    /// One pair: DirectLight(x) of formula (1), and what it is scaled by.
    Scalar {
        /// φ1.
        falloff: Falloff,
        /// How it is scaled.
        scale: PaperScale,
    },
}

impl DirectEncoding {
    pub(crate) fn of(options: &RenderOptions) -> Self {
        let falloff = options.transport.falloff;
        match MeshKey::of(options).kind {
            PointKind::ByLight => Self::PerLight { falloff },
            PointKind::Scalar { field_falloff, scale } => Self::Scalar { falloff: field_falloff, scale },
            PointKind::SixAxis => Self::SixAxis { falloff },
        }
    }

    /// Values per point.
    pub(crate) fn stride(self) -> usize {
        match self {
            Self::SixAxis { .. } => 12,
            Self::PerLight { .. } => 0,
            Self::Scalar { .. } => 2,
        }
    }
}

/// The constant of [`PaperScale::Constant`]: the mean of Σ E_i / φ1, without V_i, over the channels and a grid of 8³ places
/// in the scene's box. 1 where it is not needed.
pub(super) fn papers_constant(scene: &Scene, field: DirectEncoding) -> f32 {
    const SIDE: u32 = 8;
    let DirectEncoding::Scalar { falloff, scale: PaperScale::Constant } = field else { return 1.0 };
    let (bounds, lights) = (scene.bounds(), scene.lights());
    let (mut d, mut sum) = (Directions::default(), 0.0_f64);
    for i in 0..SIDE.pow(3) {
        let place = Vec3::new((i % SIDE) as f32, (i / SIDE % SIDE) as f32, (i / SIDE / SIDE) as f32) + 0.5;
        lights.directions(scene.simd_level(), falloff, bounds.min + bounds.size() * (place / SIDE as f32), &mut d);
        for lane in 0..lights.lanes() {
            let r = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]).length();
            sum += f64::from(lights.intensity(lane).element_sum() / 3.0 * d.f[lane] * r);
        }
    }
    if sum > 0.0 { (sum / f64::from(SIDE.pow(3))) as f32 } else { 1.0 }
}

/// Direct light at points of its mesh.
#[derive(Debug)]
pub(crate) struct DirectField {
    pub(crate) points: Points,
    pub(crate) encoding: DirectEncoding,
    pub(crate) values: Vec<Vec4>,
    pub(super) lights: RegionCuts,
    /// What points know of each light, where the method wants it.
    pub(crate) bits: Option<LightBits>,
    /// The same where lights are clusters: then there are no bits.
    pub(crate) runs: Option<LightRuns>,
    /// The lanes that pad blocks of lights, a bit each.
    pub(crate) padding: Vec<u64>,
    /// The mean unshadowed field, for [`PaperScale::Constant`].
    pub(super) constant: f32,
    pub(crate) max_memory: u64,
}

impl DirectField {
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(crate) fn new(
        scene: &Scene,
        lattices: Vec<Lattice>,
        neighbourhood: Interpolator,
        options: &RenderOptions,
    ) -> Result<Self, Error> {
        let lights = RegionCuts::new(scene, options)?;
        let field = DirectEncoding::of(options);
        let constant = papers_constant(scene, field);
        let points = Points::new(lattices, neighbourhood);
        let samples = scene.lights();
        let knows_clusters = options.method.knows_lights() && lights.has_clusters();
        let runs = knows_clusters.then(LightRuns::default);
        let bits = (options.method.knows_lights() && !knows_clusters).then(|| LightBits::new(samples.lanes()));
        let mut padding = vec![0; samples.lanes().div_ceil(64)];
        for lane in (0..64 * padding.len()).filter(|&i| i >= samples.lanes() || samples.intensity(i) == Vec3::ZERO) {
            padding[lane / 64] |= 1 << (lane % 64);
        }
        let max_memory = options.limits.max_memory;
        Ok(Self { points, encoding: field, values: Vec::new(), lights, bits, runs, padding, constant, max_memory })
    }

    pub(crate) fn marks(&self) -> Marks {
        self.points.marks()
    }

    pub(crate) fn stats(&self) -> MeshStats {
        let bits = self.bits.as_ref().map_or(0, LightBits::bytes);
        let runs = self.runs.as_ref().map_or(0, LightRuns::bytes);
        self.points.stats((size_of_val(self.values.as_slice()) + bits) as u64 + runs + self.lights.bytes())
    }

    /// Memory of a point's values, but for runs, which differ from point to point.
    fn value_bytes(&self) -> u64 {
        (self.encoding.stride() * size_of::<Vec4>()) as u64 + self.bits.as_ref().map_or(0, LightBits::bytes_per_point)
    }

    /// What filling points takes.
    pub(crate) fn costs(&self) -> Costs {
        Costs::kept(self.value_bytes())
    }

    /// The most memory that it may take, bytes.
    pub(crate) fn max_memory(&self) -> u64 {
        self.max_memory
    }

    /// Memory of a point; a guess where they differ.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        let runs = self.runs.as_ref().map_or(0, |_| LightRuns::BYTES_PER_POINT);
        self.value_bytes() + runs + Points::BYTES_PER_POINT
    }

    /// Its points, to be refined.
    pub(crate) fn points_mut(&mut self) -> &mut Points {
        &mut self.points
    }

    /// The lights of its scene.
    pub(crate) fn lights(&self) -> &RegionCuts {
        &self.lights
    }

    /// [`DirectField::lights`], to ask for what is not known yet.
    pub(crate) fn lights_mut(&mut self) -> &mut RegionCuts {
        &mut self.lights
    }

    /// Its points.
    pub(crate) fn points(&self) -> &Points {
        &self.points
    }

    /// How often the cell that a vertex reads has been refined.
    pub(crate) fn level_at(&self, vertex: &ShadingPoint) -> u32 {
        self.points.cell(vertex).0
    }

    /// Visible and unshadowed light of a point, as a surface of normal `n` counts it.
    #[inline(always)]
    pub(crate) fn project(&self, index: u32, n: Vec3) -> (Vec4, Vec4) {
        match self.encoding {
            DirectEncoding::SixAxis { .. } => {
                let values = &self.values[index as usize * 12..][..12];
                let AmbientCube { faces: sides, squares } = AmbientCube::facing(n);
                let [x, y, z] = sides.map(|side| 2 * side);
                let visible = values[x] * squares.x + values[y] * squares.y + values[z] * squares.z;
                let all = values[x + 1] * squares.x + values[y + 1] * squares.y + values[z + 1] * squares.z;
                (visible, all)
            }
            DirectEncoding::PerLight { .. } => (Vec4::ZERO, Vec4::ZERO),
            DirectEncoding::Scalar { .. } => {
                let values = &self.values[index as usize * 2..][..2];
                (values[0], values[1])
            }
        }
    }
}
