//! Reading the mesh: which points a surface point asks for, and formula (3g) over them.

use glam::{UVec3, Vec3, Vec4};

use super::bricks::Slot;
use super::neighbourhood::{Neighbourhood, Stencil, corner, nearest, sphere, trilinear};
use super::{Coordinate, Field, LightMesh, Marks, lattice};
use crate::integrator::Vertex;

/// Reads a mesh vertex by vertex. It keeps the slots of the last cell: neighbouring pixels mostly share it.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    mesh: &'a LightMesh,
    cell: Coordinate,
    slots: [Slot; 8],
}

/// What a vertex finds in the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// The fraction of the unshadowed irradiance that arrives, per channel.
    Visibility(Vec3),
    /// No point of the neighbourhood can be used, or none knows of any light.
    Nothing,
    /// Points are missing; they have been marked.
    Empty,
}

/// Sums of visible and unshadowed light along the way.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    visible: Vec4,
    all: Vec4,
}

/// The three axes of the ambient cube that a normal faces, by the place of their pair of values, and their weights.
struct Axes {
    pairs: [usize; 3],
    squares: Vec3,
}

impl Axes {
    fn facing(n: Vec3) -> Self {
        let pairs = [usize::from(n.x < 0.0), 2 + usize::from(n.y < 0.0), 4 + usize::from(n.z < 0.0)];
        Self { pairs: pairs.map(|side| 2 * side), squares: n * n }
    }
}

impl<'a> Reader<'a> {
    pub(super) fn new(mesh: &'a LightMesh) -> Self {
        Self { mesh, cell: UVec3::MAX, slots: [Slot::Empty; 8] }
    }

    /// Ĩ(y), formula (3g), if every point that the vertex reads has been evaluated. Those that are still empty are marked
    /// instead: marks are bits that are only ever set, so neither the order nor the thread matters.
    pub(crate) fn read(&mut self, vertex: &Vertex, marks: &Marks) -> Reading {
        let mesh = self.mesh;
        let axes = Axes::facing(vertex.n);
        let (mut sums, mut empty) = (Sums::default(), false);
        let mut visit = |coordinate: Coordinate, slot: Slot, weight: f32| match slot {
            Slot::Filled(index) => sums.add(mesh, index, &axes, weight),
            Slot::Invalid => {}
            Slot::Empty => {
                let (brick, local) = lattice::split(coordinate);
                marks.set(mesh.lattice.brick_index(brick), local);
                empty = true;
            }
        };
        match mesh.neighbourhood {
            Neighbourhood::Trilinear => {
                let stencil = self.enter(vertex);
                for k in 0..8 {
                    if stencil.weights[k] > 0.0 {
                        visit(corner(stencil.cell, k), self.slots[k], stencil.weights[k]);
                    }
                }
            }
            Neighbourhood::Sphere { radius } => sphere(&mesh.lattice, vertex, radius, |coordinate| {
                visit(coordinate, mesh.slot(coordinate), 1.0);
            }),
            Neighbourhood::Nearest => nearest(&mesh.lattice, vertex, |coordinate| {
                let slot = mesh.slot(coordinate);
                visit(coordinate, slot, 1.0);
                slot
            }),
        }
        if empty { Reading::Empty } else { sums.ratio().map_or(Reading::Nothing, Reading::Visibility) }
    }

    /// The stencil of a vertex, with its cell's slots at hand.
    #[inline(always)]
    fn enter(&mut self, vertex: &Vertex) -> Stencil {
        let stencil = trilinear(&self.mesh.lattice, vertex);
        if stencil.cell != self.cell {
            self.cell = stencil.cell;
            self.slots = std::array::from_fn(|k| self.mesh.slot(corner(stencil.cell, k)));
        }
        stencil
    }
}

impl Sums {
    /// Adds what a mesh point knows, weighted by φ4 = `weight` and, with six axes, by the squared components of the normal.
    #[inline(always)]
    fn add(&mut self, mesh: &LightMesh, index: u32, axes: &Axes, weight: f32) {
        let values = mesh.values(index);
        match mesh.field {
            Field::SixAxis { .. } => {
                let [x, y, z] = axes.pairs;
                let w = axes.squares * weight;
                self.visible += values[x] * w.x + values[y] * w.y + values[z] * w.z;
                self.all += values[x + 1] * w.x + values[y + 1] * w.y + values[z + 1] * w.z;
            }
            Field::Scalar { .. } => {
                self.visible += values[0] * weight;
                self.all += values[1] * weight;
            }
        }
    }

    fn ratio(self) -> Option<Vec3> {
        let (visible, all) = (self.visible.truncate(), self.all.truncate());
        let sum = all.element_sum();
        // A channel without light takes what the others say.
        let otherwise = Vec3::splat(visible.element_sum() / sum);
        let ratio = Vec3::select(all.cmpgt(Vec3::ZERO), visible / all.max(Vec3::splat(f32::MIN_POSITIVE)), otherwise);
        (sum > 0.0).then_some(ratio)
    }
}
