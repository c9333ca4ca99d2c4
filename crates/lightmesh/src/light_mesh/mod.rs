//! The light mesh: illumination at points of a lattice in space, computed when a surface first asks for it.
//!
//! A frame uses it in three steps, each a plain parallel loop: [`demand`](LightMesh::demand) marks the points that hits
//! read and that are still empty, [`fill`](LightMesh::fill) evaluates them in brick order, and
//! [`visibility`](LightMesh::visibility) interpolates. A point's value depends on the scene, the settings and the point
//! alone, so it does not matter who asked first.

mod bricks;
mod evaluate;
mod lattice;
mod marks;
mod neighbourhood;

use glam::{UVec3, Vec3, Vec4};
use rayon::prelude::*;

use crate::integrator::Vertex;
use crate::{Error, Falloff, MeshStats, Method, PaperScale, RenderOptions, Scene, Spacing};
use bricks::{Bricks, Slot};
use evaluate::Evaluator;
use lattice::Lattice;
pub(crate) use marks::Marks;
use neighbourhood::Neighbourhood;

/// What one mesh point keeps per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Field {
    /// Visible over unshadowed irradiance for each of ±x, ±y, ±z (an ambient cube).
    SixAxis {
        /// φ3: the weights of the lights are those of the sum that the ratio multiplies.
        falloff: Falloff,
    },
    /// One value: DirectLight(x) of formula (1).
    Scalar {
        /// φ1.
        falloff: Falloff,
        /// How it is scaled.
        scale: PaperScale,
    },
}

impl Field {
    fn of(options: &RenderOptions) -> Self {
        match options.method {
            Method::Paper => Self::Scalar { falloff: options.field_falloff, scale: options.paper_scale },
            Method::Mesh | Method::Standard | Method::Path => Self::SixAxis { falloff: options.falloff },
        }
    }

    /// Values per point.
    fn stride(self) -> usize {
        match self {
            Self::SixAxis { .. } => 6,
            Self::Scalar { .. } => 1,
        }
    }
}

/// A lazily filled mesh of direct light. It belongs to one scene and one choice of method, spacing, falloff and
/// neighbourhood; cameras, picture sizes and samples may change from frame to frame.
#[derive(Debug)]
pub struct LightMesh {
    lattice: Lattice,
    field: Field,
    neighbourhood: Neighbourhood,
    bricks: Bricks,
    values: Vec<Vec4>,
    /// What an interpolated value is multiplied by.
    scale: f32,
    invalid: u64,
    max_memory: u64,
}

/// The work of evaluating points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FillStats {
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Rays that tested whether points are inside solids.
    pub probe_rays: u64,
}

impl LightMesh {
    /// An empty mesh over the scene's box.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for a spacing out of range, [`Error::OutOfMemory`] if the table of bricks alone would not
    /// fit into `options.max_memory`.
    pub fn new(scene: &Scene, options: &RenderOptions) -> Result<Self, Error> {
        options.validate()?;
        let neighbourhood = Neighbourhood::new(options.method, options.interpolation);
        let bounds = scene.bounds();
        let longest = bounds.size().max_element();
        let spacing = match options.spacing {
            Spacing::Auto => longest / 40.0,
            Spacing::Fraction(k) => longest / k,
            Spacing::Metres(h) => h,
        };
        let lattice = Lattice::new(&bounds, spacing, neighbourhood.reach(), options.max_memory)?;
        let bricks = Bricks::new(lattice.bricks());
        let field = Field::of(options);
        let scale = match field {
            Field::Scalar { falloff, scale: PaperScale::Constant } => evaluate::papers_constant(scene, falloff),
            _ => 1.0,
        };
        Ok(Self {
            lattice,
            field,
            neighbourhood,
            bricks,
            values: Vec::new(),
            scale,
            invalid: 0,
            max_memory: options.max_memory,
        })
    }

    /// Whether frames with these options can use this mesh.
    pub fn serves(&self, options: &RenderOptions) -> bool {
        self.field == Field::of(options)
            && self.neighbourhood == Neighbourhood::new(options.method, options.interpolation)
    }

    /// Points evaluated so far, and their memory.
    pub fn stats(&self) -> MeshStats {
        MeshStats {
            spacing_m: f64::from(self.lattice.spacing()),
            points_used: (self.values.len() / self.field.stride()) as u64 + self.invalid,
            points_total: self.lattice.point_count(),
            points_invalid: self.invalid,
            bytes: self.bricks.bytes() + (self.values.len() * size_of::<Vec4>()) as u64,
        }
    }

    /// Marks every point that the vertices read and that is still empty. Runs from many threads at once: marks are bits
    /// that are only ever set, so their order does not matter. Returns whether anything was marked.
    pub(crate) fn demand(&self, vertices: &[Vertex], marks: &Marks) -> bool {
        let mut any = false;
        for vertex in vertices {
            self.neighbourhood.for_each(&self.lattice, vertex, |coordinate, _| {
                let (brick, local) = lattice::split(coordinate);
                let slot = self.bricks.slot(self.lattice.brick_index(brick), local);
                if slot == Slot::Empty {
                    marks.set(self.lattice.brick_index(brick), local);
                    any = true;
                }
                slot
            });
        }
        any
    }

    /// Empty marks for this mesh.
    pub(crate) fn marks(&self) -> Marks {
        Marks::new(self.lattice.brick_count())
    }

    /// Evaluates the marked points in parallel, in brick order, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(crate) fn fill(&mut self, scene: &Scene, marks: &mut Marks) -> Result<FillStats, Error> {
        let (wanted, new_bricks) = marks.take(&self.bricks);
        self.check_memory(wanted.len() as u64, new_bricks)?;

        // Evaluate: the only expensive step. Chunks are large enough to share a worker's buffers.
        let (lattice, field) = (&self.lattice, self.field);
        let evaluated: Vec<_> = wanted
            .par_chunks(64)
            .map(|chunk| {
                let mut evaluator = Evaluator::new(scene, field);
                let points: Vec<_> = chunk
                    .iter()
                    .map(|&(brick, local)| evaluator.evaluate(lattice.point(lattice.coordinate(brick, local))))
                    .collect();
                (points, evaluator.stats())
            })
            .collect();

        // Store, in the order of the list: slots do not depend on the number of threads.
        let stride = field.stride();
        let mut stats = FillStats::default();
        let mut places = wanted.iter();
        for (points, work) in evaluated {
            stats.shadow_rays += work.shadow_rays;
            stats.probe_rays += work.probe_rays;
            for (point, &(brick, local)) in points.iter().zip(places.by_ref()) {
                let slot = match point {
                    Some(values) => {
                        let index = (self.values.len() / stride) as u32;
                        self.values.extend_from_slice(&values[..stride]);
                        Slot::Filled(index)
                    }
                    None => {
                        self.invalid += 1;
                        Slot::Invalid
                    }
                };
                self.bricks.set(brick, local, slot);
            }
        }
        Ok(stats)
    }

    fn check_memory(&self, points: u64, new_bricks: u64) -> Result<(), Error> {
        // A growing vector may hold twice its contents for a moment.
        let values = self.values.len() as u64 + points * self.field.stride() as u64;
        let needed = self.bricks.bytes() + new_bricks * Bricks::BYTES_PER_BRICK + 2 * values * size_of::<Vec4>() as u64;
        let too_many = values / self.field.stride() as u64 >= u64::from(Slot::MAX_INDEX);
        if needed > self.max_memory || too_many {
            return Err(Error::OutOfMemory {
                what: "the light mesh",
                needed_bytes: needed,
                limit_bytes: self.max_memory,
                advice: "choose a larger --spacing",
            });
        }
        Ok(())
    }

    /// Ĩ(y), formula (3g): for [`Method::Mesh`] the fraction of the unshadowed irradiance that arrives at the vertex, per
    /// channel; `None` if no point of its neighbourhood can be used.
    #[inline]
    pub(crate) fn visibility(&self, vertex: &Vertex) -> Option<Vec3> {
        let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
        match self.field {
            Field::SixAxis { .. } => {
                // The ambient cube: the three axes that the normal faces, weighted by its squared components.
                let n = vertex.n;
                let squares = n * n;
                let axes = [usize::from(n.x < 0.0), 2 + usize::from(n.y < 0.0), 4 + usize::from(n.z < 0.0)];
                self.for_each_value(vertex, |values, weight| {
                    let value = values[axes[0]] * squares.x + values[axes[1]] * squares.y + values[axes[2]] * squares.z;
                    sum += value * weight;
                    weights += weight;
                });
            }
            Field::Scalar { .. } => self.for_each_value(vertex, |values, weight| {
                sum += values[0] * weight;
                weights += weight;
            }),
        }
        (weights > 0.0).then(|| sum.truncate() * (self.scale / weights))
    }

    #[inline(always)]
    fn for_each_value(&self, vertex: &Vertex, mut visit: impl FnMut(&[Vec4], f32)) {
        let stride = self.field.stride();
        self.neighbourhood.for_each(&self.lattice, vertex, |coordinate, weight| {
            let (brick, local) = lattice::split(coordinate);
            let slot = self.bricks.slot(self.lattice.brick_index(brick), local);
            if let Slot::Filled(index) = slot {
                let first = index as usize * stride;
                visit(&self.values[first..first + stride], weight);
            }
            slot
        });
    }
}

/// A lattice coordinate: every component below 2²⁹.
pub(crate) type Coordinate = UVec3;
