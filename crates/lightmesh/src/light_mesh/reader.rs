//! Reading the mesh: which points a surface point asks for, and formula (3g) over them.

use glam::{UVec3, Vec3, Vec4};

use super::bricks::Slot;
use super::neighbourhood::{Neighbourhood, corner, nearest, sphere, trilinear};
use super::{Coordinate, Field, LightMesh, Marks};
use crate::integrator::Vertex;

/// Reads a mesh vertex by vertex. It keeps the slots of the last cell: neighbouring pixels mostly share it.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    mesh: &'a LightMesh,
    cell: Coordinate,
    slots: [Slot; 8],
    /// Which of the slots are empty, a bit each, and which of those have been marked.
    empty: u8,
    marked: u8,
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
        Self { mesh, cell: UVec3::MAX, slots: [Slot::Empty; 8], empty: 0, marked: 0 }
    }

    /// Ĩ(y), formula (3g), if every point that the vertex reads has been evaluated. Those that are still empty are marked
    /// instead: marks are bits that are only ever set, so neither the order nor the thread matters.
    pub(crate) fn read(&mut self, vertex: &Vertex, marks: &Marks) -> Reading {
        let mesh = self.mesh;
        let axes = Axes::facing(vertex.n);
        if mesh.neighbourhood == Neighbourhood::Trilinear {
            return self.read_cell(vertex, &axes, marks);
        }
        let (mut sums, mut empty) = (Sums::default(), false);
        let visit = |coordinate: Coordinate| {
            let slot = mesh.slot(coordinate);
            match slot {
                Slot::Filled(index) => sums.add(mesh, index, &axes, 1.0),
                Slot::Invalid => {}
                Slot::Empty => {
                    mesh.mark(coordinate, marks);
                    empty = true;
                }
            }
            slot
        };
        match mesh.neighbourhood {
            Neighbourhood::Sphere { radius } => sphere(&mesh.lattice, vertex, radius, visit),
            Neighbourhood::Nearest | Neighbourhood::Trilinear => nearest(&mesh.lattice, vertex, visit),
        }
        if empty { Reading::Empty } else { sums.reading() }
    }

    /// [`Self::read`] for the corners of the vertex' cell.
    #[inline]
    fn read_cell(&mut self, vertex: &Vertex, axes: &Axes, marks: &Marks) -> Reading {
        let stencil = trilinear(&self.mesh.lattice, vertex);
        if stencil.cell != self.cell {
            self.enter(stencil.cell);
        }
        let empty = stencil.read & self.empty;
        if empty != 0 {
            for k in bits(empty & !self.marked) {
                self.mesh.mark(corner(self.cell, k), marks);
            }
            self.marked |= empty;
            return Reading::Empty;
        }
        let mut sums = Sums::default();
        for k in bits(stencil.read) {
            if let Slot::Filled(index) = self.slots[k] {
                sums.add(self.mesh, index, axes, stencil.weights[k]);
            }
        }
        sums.reading()
    }

    /// Looks up the corners of another cell.
    fn enter(&mut self, cell: Coordinate) {
        self.cell = cell;
        self.slots = std::array::from_fn(|k| self.mesh.slot(corner(cell, k)));
        let is_empty = |k: usize| u8::from(self.slots[k] == Slot::Empty) << k;
        (self.empty, self.marked) = ((0..8).map(is_empty).sum(), 0);
    }
}

/// The places of the set bits, ascending.
#[inline(always)]
fn bits(mut mask: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let k = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (k < 8).then_some(k)
    })
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

    fn reading(self) -> Reading {
        let (visible, all) = (self.visible.truncate(), self.all.truncate());
        let sum = all.element_sum();
        if sum <= 0.0 {
            return Reading::Nothing;
        }
        // A channel without light takes what the others say.
        let otherwise = Vec3::splat(visible.element_sum() / sum);
        let ratio = visible / all.max(Vec3::splat(f32::MIN_POSITIVE));
        Reading::Visibility(Vec3::select(all.cmpgt(Vec3::ZERO), ratio, otherwise))
    }
}
