//! The direct field: formula (1) at mesh points and formula (3g) over them.

mod read_lights;

pub(crate) use read_lights::LightsReading;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::agreement::Agreement;
use super::clearance::Clearance;
use super::evaluate::{Evaluator, papers_constant};
use super::lattice::Lattice;
use super::light_bits::LightBits;
use super::light_regions::LightRegions;
use super::light_runs::LightRuns;
use super::marks::Marks;
use super::neighbourhood::{Neighbourhood, bits as corners_of};
use super::points::{Address, Points};
use super::probe::{PROBE_RAYS, probe};
use super::reader::Reader;
use super::region_lights::RegionLights;
use super::seen::{Known, Outcome, Sight};
use super::usable::usable_part;
use crate::integrator::Vertex;
use crate::scene::LightSamples;
use crate::{Error, Falloff, MeshStats, Method, PaperScale, RayCounts, RenderOptions, Scene};

/// What one mesh point keeps: per channel and axis a pair, light that arrives and light that would arrive if nothing were
/// in the way. Readers sum both over their neighbourhood and divide last, so that a point close to a lamp, which knows most
/// of the light, weighs most. (Dividing at each point instead costs half the memory; measured on the room of 15 / 100
/// lights at 1/80 of its length: error 6.0 / 3.5% instead of 5.0 / 2.9%.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Field {
    /// A pair for each of ±x, ±y, ±z (an ambient cube).
    SixAxis {
        /// φ3: the weights of the lights are those of the sum that the ratio multiplies.
        falloff: Falloff,
    },
    /// None: readers ask for each light by itself.
    ByLight {
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

impl Field {
    pub(super) fn of(options: &RenderOptions) -> Self {
        match options.method {
            _ if options.knows_lights() => Self::ByLight { falloff: options.falloff },
            Method::Paper => Self::Scalar { falloff: options.field_falloff, scale: options.paper_scale },
            Method::Mesh | Method::Hybrid | Method::Unbiased | Method::Standard | Method::Path => {
                Self::SixAxis { falloff: options.falloff }
            }
        }
    }

    /// Values per point.
    fn stride(self) -> usize {
        match self {
            Self::SixAxis { .. } => 12,
            Self::ByLight { .. } => 0,
            Self::Scalar { .. } => 2,
        }
    }
}

/// Points with runs that are evaluated before their memory is checked: some 10 KiB each while they wait.
const POINTS_WITH_RUNS: usize = 1 << 13;

/// Direct light at points of its mesh.
#[derive(Debug)]
pub(crate) struct DirectField {
    points: Points,
    field: Field,
    values: Vec<Vec4>,
    lights: LightRegions,
    /// What points know of each light, where the method wants it.
    bits: Option<LightBits>,
    /// The same where lights are clusters: then there are no bits.
    runs: Option<LightRuns>,
    /// The lanes that pad blocks of lights, a bit each.
    padding: Vec<u64>,
    /// The mean unshadowed field, for [`PaperScale::Constant`].
    constant: f32,
    max_memory: u64,
}

/// What a vertex finds in the direct mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// The fraction of the unshadowed irradiance that arrives, per channel.
    Visibility(Vec3),
    /// No point of the neighbourhood can be used, or none knows of any light.
    Nothing,
    /// Points are missing; they have been marked.
    Empty,
}

impl DirectField {
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(super) fn new(
        scene: &Scene,
        lattices: Vec<Lattice>,
        neighbourhood: Neighbourhood,
        options: &RenderOptions,
    ) -> Result<Self, Error> {
        let lights = LightRegions::new(scene, options)?;
        let field = Field::of(options);
        let constant = papers_constant(scene, field);
        let points = Points::new(lattices, neighbourhood);
        let samples = scene.lights();
        let knows_clusters = options.knows_lights() && lights.has_clusters();
        let runs = knows_clusters.then(LightRuns::default);
        let bits = (options.knows_lights() && !knows_clusters).then(|| LightBits::new(samples.lanes()));
        let mut padding = vec![0; samples.lanes().div_ceil(64)];
        for lane in (0..64 * padding.len()).filter(|&i| i >= samples.lanes() || samples.intensity(i) == Vec3::ZERO) {
            padding[lane / 64] |= 1 << (lane % 64);
        }
        let max_memory = options.max_memory;
        Ok(Self { points, field, values: Vec::new(), lights, bits, runs, padding, constant, max_memory })
    }

    pub(super) fn serves(&self, options: &RenderOptions, neighbourhood: Neighbourhood) -> bool {
        self.field == Field::of(options)
            && self.lights.serves(options)
            && self.points.neighbourhood == neighbourhood
            && (self.bits.is_some() || self.runs.is_some()) == options.knows_lights()
    }

    pub(super) fn marks(&self) -> Marks {
        self.points.marks()
    }

    pub(crate) fn stats(&self) -> MeshStats {
        let bits = self.bits.as_ref().map_or(0, LightBits::bytes);
        let runs = self.runs.as_ref().map_or(0, LightRuns::bytes);
        self.points.stats((size_of_val(self.values.as_slice()) + bits) as u64 + runs + self.lights.bytes())
    }

    /// Memory of a point's values, but for runs, which differ from point to point.
    fn value_bytes(&self) -> u64 {
        (self.field.stride() * size_of::<Vec4>()) as u64 + self.bits.as_ref().map_or(0, LightBits::bytes_per_point)
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
    pub(crate) fn lights(&self) -> &LightRegions {
        &self.lights
    }

    /// [`DirectField::lights`], to ask for what is not known yet.
    pub(crate) fn lights_mut(&mut self) -> &mut LightRegions {
        &mut self.lights
    }

    /// Its points.
    pub(crate) fn points(&self) -> &Points {
        &self.points
    }

    /// How often the cell that a vertex reads has been refined.
    pub(crate) fn level_at(&self, vertex: &Vertex) -> u32 {
        self.points.cell(vertex).0
    }

    /// A reader for one thread.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, sight: Sight) -> DirectReader<'a> {
        DirectReader {
            field: self,
            reader: self.points.reader(scene, sight),
            known: Known::default(),
            visible: [Vec4::ZERO; 8],
            all: [Vec4::ZERO; 8],
            agreement: Agreement::new(if self.runs.is_some() { 0 } else { scene.lights().lanes() }),
            samples: scene.lights(),
            near: match self.field {
                Field::ByLight { falloff } => RegionLights::new(&self.lights, falloff),
                Field::SixAxis { .. } | Field::Scalar { .. } => None,
            },
            rows: [0; 8],
        }
    }

    /// Visible and unshadowed light of a point, as a surface of normal `n` counts it.
    #[inline(always)]
    fn fold(&self, index: u32, n: Vec3) -> (Vec4, Vec4) {
        match self.field {
            Field::SixAxis { .. } => {
                let values = &self.values[index as usize * 12..][..12];
                let Axes { sides, squares } = Axes::facing(n);
                let [x, y, z] = sides.map(|side| 2 * side);
                let visible = values[x] * squares.x + values[y] * squares.y + values[z] * squares.z;
                let all = values[x + 1] * squares.x + values[y + 1] * squares.y + values[z + 1] * squares.z;
                (visible, all)
            }
            Field::ByLight { .. } => (Vec4::ZERO, Vec4::ZERO),
            Field::Scalar { .. } => {
                let values = &self.values[index as usize * 2..][..2];
                (values[0], values[1])
            }
        }
    }

    /// Evaluates the marked points in parallel, in brick order, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(crate) fn fill(&mut self, scene: &Scene, marks: &mut Marks) -> Result<RayCounts, Error> {
        let wanted = self.points.take(marks, self.value_bytes(), self.max_memory)?;
        let mut rays = RayCounts::default();
        if !matches!(self.field, Field::Scalar { .. }) {
            rays.secondary = PROBE_RAYS * wanted.len() as u64;
        }
        // How many runs points have is known when they have been evaluated.
        let together = if self.runs.is_some() { POINTS_WITH_RUNS } else { wanted.len().max(1) };
        for wanted in wanted.chunks(together) {
            rays.shadow += self.evaluate(scene, wanted)?;
        }
        Ok(rays)
    }

    /// Evaluates some points that were wanted, and stores them; how many shadow rays it took.
    fn evaluate(&mut self, scene: &Scene, wanted: &[Address]) -> Result<u64, Error> {
        let stride = self.field.stride();
        // Evaluate: the only expensive step. Chunks are large enough to share a worker's buffers.
        let (grid, field, constant, lights) = (&self.points, self.field, self.constant, &self.lights);
        let (bits, runs, padding) = (self.bits.as_ref(), self.runs.as_ref(), self.padding.as_slice());
        let evaluated: Vec<_> = wanted
            .par_chunks(64)
            .map(|chunk| {
                let mut evaluator = Evaluator::new(scene, lights.at(scene), field, constant);
                let points: Vec<_> = chunk
                    .iter()
                    .map(|&address| {
                        let x = grid.place(address);
                        let clearance = match field {
                            // The paper's mesh knows no geometry: every point counts.
                            Field::Scalar { .. } => Some(Clearance::ALL_FREE),
                            _ => probe(scene, x, grid.level(address.level).lattice.spacing()),
                        };
                        let values = clearance.map(|_| {
                            let values = evaluator.evaluate(x);
                            let packed = bits.map(|bits| evaluator.pack(bits, padding));
                            (values, packed, runs.map(|_| evaluator.runs()))
                        });
                        ((address, clearance), values)
                    })
                    .collect();
                (points, evaluator.shadow_rays())
            })
            .collect();

        if let Some(runs) = runs {
            let new =
                evaluated.iter().flat_map(|(points, _)| points).filter_map(|(_, values)| values.as_ref()?.2.as_deref());
            // A growing vector may hold twice its contents for a moment.
            let needed_bytes = grid.stats(2 * runs.bytes_with(new) + lights.bytes()).bytes;
            if needed_bytes > self.max_memory {
                return Err(Error::OutOfMemory {
                    what: "the light mesh",
                    needed_bytes,
                    limit_bytes: self.max_memory,
                    advice: "choose a larger --spacing or --light-error",
                });
            }
        }

        // Store, in the order of the list: slots do not depend on the number of threads.
        let mut rays = 0;
        for (points, shadow_rays) in evaluated {
            rays += shadow_rays;
            for (probed, values) in points {
                self.points.insert(probed);
                let Some((values, packed, new)) = values else { continue };
                self.values.extend_from_slice(&values[..stride]);
                if let (Some(runs), Some(new)) = (&mut self.runs, new) {
                    runs.push(&new);
                }
                if let (Some(bits), Some(packed)) = (&mut self.bits, packed) {
                    bits.push(&packed);
                }
            }
        }
        Ok(rays)
    }
}

/// The three axes of the ambient cube that a normal faces, by their side (0 to 5: +x, −x, +y, −y, +z, −z), and their
/// weights.
pub(super) struct Axes {
    pub sides: [usize; 3],
    pub squares: Vec3,
}

impl Axes {
    pub(super) fn facing(n: Vec3) -> Self {
        let sides = [usize::from(n.x < 0.0), 2 + usize::from(n.y < 0.0), 4 + usize::from(n.z < 0.0)];
        Self { sides, squares: n * n }
    }
}

/// Reads the field vertex by vertex. Neighbouring vertices mostly share cell and normal: what the corners know about surfaces of
/// that normal is kept.
pub(crate) struct DirectReader<'a> {
    field: &'a DirectField,
    reader: Reader<'a>,
    known: Known,
    /// By corner, summed over the axes that the normal faces; 0 where it is not known.
    visible: [Vec4; 8],
    all: [Vec4; 8],
    /// What the points that were read last know of each light.
    agreement: Agreement,
    samples: &'a LightSamples,
    /// Where lights are clusters.
    near: Option<RegionLights<'a>>,
    /// By corner: where `near` has what it says.
    rows: [u32; 8],
}

impl DirectReader<'_> {
    /// Ĩ(y), formula (3g); points that are still empty are marked.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &Vertex, marks: &Marks) -> Reading {
        let (mut visible, mut all) = (Vec4::ZERO, Vec4::ZERO);
        if !self.reader.reads_cells() {
            return self.read_points(vertex, marks);
        }
        let seen = match self.reader.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(Outcome::Empty) => return Reading::Empty,
            Err(_) => return Reading::Nothing,
        };
        if seen.refined > 0.0 {
            return self.read_points(vertex, marks);
        }
        if !self.known.goes_on(vertex.n, self.reader.visits()) {
            // A curved surface: the next vertex has another normal.
            for k in corners_of(seen.mask) {
                let (v, a) = self.field.fold(self.reader.index(k), vertex.n);
                let weight = seen.weights[k / 4][k % 4];
                visible += v * weight;
                all += a * weight;
            }
            return ratio(visible.truncate(), all.truncate());
        }
        self.know(seen.mask, vertex.n);
        // All eight: a corner that is not seen has no weight.
        for (z, weights) in seen.weights.iter().enumerate() {
            let corners = self.visible[4 * z..].iter().zip(&self.all[4 * z..]);
            for ((v, a), weight) in corners.zip(weights.to_array()) {
                visible += v * weight;
                all += a * weight;
            }
        }
        ratio(visible.truncate(), all.truncate())
    }

    /// The same, point by point.
    fn read_points(&mut self, vertex: &Vertex, marks: &Marks) -> Reading {
        let (mut visible, mut all) = (Vec4::ZERO, Vec4::ZERO);
        let outcome = self.reader.read(vertex, marks, |index, weight| {
            let point = self.field.fold(index, vertex.n);
            visible += point.0 * weight;
            all += point.1 * weight;
        });
        match outcome {
            Outcome::Read => ratio(visible.truncate(), all.truncate()),
            Outcome::Nothing => Reading::Nothing,
            Outcome::Empty => Reading::Empty,
        }
    }

    /// The part, by weight, of the points of D_y that the vertex can use, in [0, 1]; all of them have been evaluated. 0
    /// where [`DirectReader::read`] finds nothing.
    pub(crate) fn usable_part(&mut self, vertex: &Vertex, marks: &Marks) -> f32 {
        let reads = match self.field.field {
            Field::ByLight { .. } => self.read_lights(vertex, marks) == LightsReading::Known,
            _ => matches!(self.read(vertex, marks), Reading::Visibility(_)),
        };
        if reads { usable_part(&mut self.reader, &self.field.points, vertex, marks) } else { 0.0 }
    }

    /// Sums up the corners of `mask` for the normal, those that are not known yet.
    #[inline(always)]
    fn know(&mut self, mask: u8, n: Vec3) {
        if self.known.is_empty() {
            (self.visible, self.all) = ([Vec4::ZERO; 8], [Vec4::ZERO; 8]);
        }
        for k in self.known.learn(mask) {
            (self.visible[k], self.all[k]) = self.field.fold(self.reader.index(k), n);
        }
    }

    /// Rays shot so far to find out which points vertices see.
    pub(crate) fn sight_rays(&self) -> u64 {
        self.reader.sight_rays()
    }
}

/// The part of the light that arrives.
fn ratio(visible: Vec3, all: Vec3) -> Reading {
    let sum = all.element_sum();
    if sum <= 0.0 {
        return Reading::Nothing;
    }
    // A channel without light takes what the others say.
    let otherwise = Vec3::splat(visible.element_sum() / sum);
    let ratio = visible / all.max(Vec3::splat(f32::MIN_POSITIVE));
    Reading::Visibility(Vec3::select(all.cmpgt(Vec3::ZERO), ratio, otherwise))
}
