//! The paper's scalar: one pair per point, without directions.
//!
//! Point p has the values `2 p` and `2 p + 1`, each RGB: DirectLight(x) = Σ V_i E_i / φ1 of formula (1), and what
//! readers divide it by. Example: point 3 has values 6 and 7. What it is divided by depends on [`PaperScale`]: the same
//! sum without V_i, or one constant for the whole scene.

use glam::{Vec3, Vec4};

use super::super::point_lights::PointLights;
use super::plain_arrays::{check_finite, check_length, rgb, values};
use super::{ArrivingLight, DirectValues};
use crate::light::Directions;
use crate::{Error, Falloff, PaperScale, Scene};

/// Values of a point.
const STRIDE: usize = 2;

/// The values of all points.
#[derive(Debug)]
pub(crate) struct Scalar {
    /// φ1.
    pub(super) falloff: Falloff,
    scale: PaperScale,
    /// The mean unshadowed field, for [`PaperScale::Constant`].
    constant: f32,
    values: Vec<Vec4>,
}

impl Scalar {
    /// What the encoding keeps, for messages.
    pub(super) const NAME: &str = "the paper's scalar";
    /// Memory of a point, bytes.
    pub(super) const BYTES_PER_POINT: u64 = (STRIDE * size_of::<Vec4>()) as u64;

    /// No points.
    pub(super) fn new(scene: &Scene, falloff: Falloff, scale: PaperScale) -> Self {
        let constant = match scale {
            PaperScale::Constant => mean_unshadowed(scene, falloff),
            PaperScale::Visibility => 1.0,
        };
        Self { falloff, scale, constant, values: Vec::new() }
    }

    /// Returns whether points inside solids are to be found and left out. The paper's mesh as printed ignores geometry:
    /// every point counts.
    pub(super) fn needs_probes(&self) -> bool {
        self.scale != PaperScale::Constant
    }

    /// Returns the values of a point: formula (1), and what it is divided by.
    pub(super) fn evaluate(&self, lights: &PointLights<'_>) -> [Vec4; STRIDE] {
        let (mut visible, mut unshadowed) = (Vec3::ZERO, Vec3::ZERO);
        for light in lights.iter() {
            let e = light.intensity * (light.f * light.direction.length());
            unshadowed += e;
            visible += e * light.visible;
        }
        let divisor = match self.scale {
            PaperScale::Visibility => unshadowed,
            PaperScale::Constant => Vec3::splat(self.constant),
        };
        [visible.extend(0.0), divisor.extend(0.0)]
    }

    /// Stores the values of the next point.
    pub(super) fn push(&mut self, values: &[Vec4; STRIDE]) {
        self.values.extend_from_slice(values);
    }

    /// Returns the light of a point, the same for every surface.
    #[inline(always)]
    pub(super) fn project(&self, index: u32) -> ArrivingLight {
        let values = &self.values[index as usize * STRIDE..][..STRIDE];
        ArrivingLight { visible: values[0], unshadowed: values[1] }
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.values.as_slice()) as u64
    }

    /// Copies some points: shape (N, 2, 3).
    pub(super) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        DirectValues::Scalar(indices.flat_map(|i| rgb(&self.values[i as usize * STRIDE..][..STRIDE])).collect())
    }

    /// Refuses what cannot be the values of this number of points.
    pub(super) fn check(numbers: &[f32], points: usize) -> Result<(), Error> {
        check_length("direct values", numbers.len(), &[points, 2, 3])?;
        check_finite("direct values", numbers)
    }

    /// Stores point i of a snapshot as the next one.
    pub(super) fn push_snapshot(&mut self, numbers: &[f32], i: usize) {
        self.values.extend(values(&numbers[i * STRIDE * 3..][..STRIDE * 3]));
    }
}

/// Returns the constant of [`PaperScale::Constant`]: the mean of Σ E_i / φ1, without V_i, over the channels and a grid
/// of 8³ positions in the scene's box; 1 for a scene without light.
fn mean_unshadowed(scene: &Scene, falloff: Falloff) -> f32 {
    const SIDE: u32 = 8;
    let (bounds, lights) = (scene.bounds(), scene.lights());
    // Sum over the lights at the middle of each cell of the grid.
    let (mut d, mut sum) = (Directions::default(), 0.0_f64);
    for i in 0..SIDE.pow(3) {
        let cell = Vec3::new((i % SIDE) as f32, (i / SIDE % SIDE) as f32, (i / SIDE / SIDE) as f32) + 0.5;
        lights.directions(scene.simd_level(), falloff, bounds.min + bounds.size() * (cell / SIDE as f32), &mut d);
        for lane in 0..lights.lanes() {
            let r = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]).length();
            sum += f64::from(lights.intensity(lane).element_sum() / 3.0 * d.f[lane] * r);
        }
    }
    if sum > 0.0 { (sum / f64::from(SIDE.pow(3))) as f32 } else { 1.0 }
}
