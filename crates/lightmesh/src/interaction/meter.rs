//! Meters: points at which irradiance is measured without a camera.

use glam::{DVec3, Vec3};

use super::surface::{ShadingPoint, evaluate};
use crate::geometry::{Ray, self_distance};
use crate::{Error, Scene};

/// A point at which irradiance is measured: on a surface, or in free space as on a work plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meter {
    /// World space, metres.
    pub position: Vec3,
    /// Which way it faces, world space; any length above 0.
    pub normal: Vec3,
}

impl Meter {
    /// Bytes of a meter's results.
    pub(crate) const BYTES: u64 = 2 * size_of::<Vec3>() as u64;

    /// The unit normal.
    pub(crate) fn direction(&self) -> Vec3 {
        // In double precision, short normals do not vanish when they are squared.
        self.normal.as_dvec3().normalize_or(DVec3::Y).as_vec3()
    }

    /// Says what is wrong with the `index`-th of a list.
    pub(crate) fn check(&self, index: usize) -> Result<(), Error> {
        let Self { position, normal } = self;
        let what = if !position.is_finite() {
            format!("the position {position} is not finite")
        } else if !normal.is_finite() {
            format!("the normal {normal} is not finite")
        } else if *normal == Vec3::ZERO {
            "the normal is zero: it must say which way the meter faces".into()
        } else {
            return Ok(());
        };
        Err(Error::InvalidMeter { index, what })
    }

    /// The meter as a point to be lit, with its number. Its rays start off the surface that it may lie on, as far as the rays of that
    /// surface do.
    pub(crate) fn shading_point(&self, scene: &Scene, id: u32) -> ShadingPoint {
        let n = self.direction();
        let coordinate = self.position.abs().max_element();
        // Look for the surface as far as a triangle may be off: small ones first, so that nothing far away counts, then
        // as large as the scene could have.
        let longest = scene.bounds().size().max_element();
        let sizes = std::iter::successors(Some(coordinate.max(1e-4)), |&size| (size < longest).then_some(4.0 * size));
        let find = |size: f32| {
            let reach = n * self_distance(coordinate, size);
            let ray = Ray { t_max: 1.0, ..Ray::new(self.position + reach, -2.0 * reach) };
            scene.bvh().closest(&ray).map(|hit| evaluate(scene, &ray, &hit).offset)
        };
        let surface = sizes.into_iter().find_map(find).unwrap_or(0.0);
        let offset = self_distance(coordinate, 0.0).max(2.0 * surface);
        ShadingPoint { position: self.position, n, ng: n, offset, bulge: Vec3::ZERO, weight: Vec3::ONE, id }
    }
}
