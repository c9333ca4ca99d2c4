//! Direct light along six axes: an ambient cube of pairs.
//!
//! Point p has the values `12 p .. 12 (p + 1)`. Face s, one of +x, −x, +y, −y, +z, −z in this order, has two of them,
//! each RGB:
//!
//! - value `12 p + 2 s`: Σ V_i E_i · cos / φ3, the irradiance on a plane that faces this way,
//! - value `12 p + 2 s + 1`: the same sum without V_i, what would arrive if nothing were in the way.
//!
//! Example: the unshadowed light on the −y face (s = 3) of point 2 is value 12 · 2 + 2 · 3 + 1 = 31. A surface of
//! normal n sums the three faces that n points to, each times the square of its component of n.
//!
//! Where there are suns, or lamps and a sky, point p has three times as many values, `36 p .. 36 (p + 1)`: first those of
//! the lights at finite distances, then those of the sky, then those of suns. Each part is read by itself. In one sum,
//! daylight that does not come into a room would decide how the light of its lamps changes between a wall and the points
//! before it: a closed room with a sun outside had 26% error.
//!
//! Readers sum both over the points around them and divide last, so that a point close to a lamp, which receives most
//! of the light, weighs most. (Dividing at each point instead costs half the memory; measured on the room of 15 / 100
//! lights at 1/80 of its length: error 6.0 / 3.5% instead of 5.0 / 2.9%.)

use glam::{Vec3, Vec4};

use super::super::point_lights::PointLights;
use super::plain_arrays::{check_finite, check_length, rgb, values};
use super::{ArrivingLight, DirectValues};
use crate::light::PARTS;
use crate::mesh::AmbientCube;
use crate::{Error, Falloff};

/// Values of a part: six faces, visible and unshadowed.
const PART: usize = 12;

/// The values of one point, by part; of one part, the others are left out.
pub(in crate::direct) type SixAxisValues = [[Vec4; PART]; PARTS];

/// The values of all points.
#[derive(Debug)]
pub(crate) struct SixAxis {
    /// φ3: the weights of the lights are those of the sum that the ratio multiplies.
    pub(super) falloff: Falloff,
    /// 1, or all where lights fall into parts.
    parts: usize,
    values: Vec<Vec4>,
}

impl SixAxis {
    /// What the encoding keeps, for messages.
    pub(super) const NAME: &str = "six axes";

    /// No points; `has_parts`: parts of the lights are kept for themselves.
    pub(super) fn new(falloff: Falloff, has_parts: bool) -> Self {
        Self { falloff, parts: if has_parts { PARTS } else { 1 }, values: Vec::new() }
    }

    /// Whether parts of the lights are kept for themselves.
    pub(super) fn has_parts(&self) -> bool {
        self.parts == PARTS
    }

    /// Values of a point.
    fn stride(&self) -> usize {
        self.parts * PART
    }

    /// Memory of a point, bytes.
    pub(super) fn bytes_per_point(&self) -> u64 {
        (self.stride() * size_of::<Vec4>()) as u64
    }

    /// Returns the values of a point: formula (1) for each face, with and without V_i.
    pub(super) fn evaluate(&self, lights: &PointLights<'_>) -> SixAxisValues {
        let mut parts = [[Vec4::ZERO; PART]; PARTS];
        for light in lights.iter() {
            let values = &mut parts[if self.has_parts() { light.part } else { 0 }];
            let intensity = (light.intensity * light.f).extend(0.0);
            for (axis, component) in light.direction.to_array().into_iter().enumerate() {
                let face = 2 * axis + usize::from(component < 0.0);
                let e = intensity * component.abs();
                values[2 * face] += e * light.visible.extend(0.0);
                values[2 * face + 1] += e;
            }
        }
        parts
    }

    /// Stores the values of the next point.
    pub(super) fn push(&mut self, values: &SixAxisValues) {
        self.values.extend_from_slice(values[..self.parts].as_flattened());
    }

    /// Returns the light of a point on a surface of normal `n`, and a weight of 1 in the fourth component.
    #[inline(always)]
    pub(super) fn project(&self, index: u32, n: Vec3) -> ArrivingLight {
        self.project_part(index, 0, &AmbientCube::facing(n))
    }

    /// [`Self::project`] of each part.
    #[inline(always)]
    pub(super) fn project_parts(&self, index: u32, n: Vec3) -> [ArrivingLight; PARTS] {
        let cube = AmbientCube::facing(n);
        std::array::from_fn(|part| self.project_part(index, part, &cube))
    }

    #[inline(always)]
    fn project_part(&self, index: u32, part: usize, cube: &AmbientCube) -> ArrivingLight {
        let values = &self.values[index as usize * self.stride() + part * PART..][..PART];
        let AmbientCube { faces, squares } = *cube;
        let [x, y, z] = faces.map(|face| 2 * face);
        let visible = values[x] * squares.x + values[y] * squares.y + values[z] * squares.z;
        let unshadowed = values[x + 1] * squares.x + values[y + 1] * squares.y + values[z + 1] * squares.z;
        ArrivingLight { visible: visible + Vec4::W, unshadowed }
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.values.as_slice()) as u64
    }

    /// Copies some points: shape (N, 6, 2, 3), or (N, 3, 6, 2, 3) with parts.
    pub(super) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        let stride = self.stride();
        let numbers = indices.flat_map(|i| rgb(&self.values[i as usize * stride..][..stride])).collect();
        if self.has_parts() { DirectValues::SixAxisParts(numbers) } else { DirectValues::SixAxis(numbers) }
    }

    /// Refuses what cannot be the values of this number of points.
    pub(super) fn check(&self, numbers: &[f32], points: usize) -> Result<(), Error> {
        check_length("direct values", numbers.len(), &[points, self.parts, 6, 2, 3])?;
        check_finite("direct values", numbers)
    }

    /// Stores point i of a snapshot as the next one.
    pub(super) fn push_snapshot(&mut self, numbers: &[f32], i: usize) {
        let stride = self.stride() * 3;
        self.values.extend(values(&numbers[i * stride..][..stride]));
    }
}
