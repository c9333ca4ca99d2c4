//! Bright spots: surfaces close to a lamp, whose light few of evenly spread rays find. A lamp 3 cm below a ceiling lights
//! a disk of a hand's breadth on it as strongly as a lamp of its own.
//!
//! Probe rays from each lamp find what is near. Surfaces in one plane that get a good part of the lamp's light are one
//! spot, whose directions are sampled in proportion to its light; what else is near, as the walls of a can, is a ball
//! around the lamp. Both have a density in closed form for every direction, whatever the rays really meet. So have the
//! ball around the image of a shining surface in a plane mirror, and the rectangle around a patch of sunlight.

use std::f32::consts::PI;

use glam::Vec3;

use super::directions::{EvenCone, SpotDirections, cone_of_ball};
use super::rectangle::Rectangle;
use crate::geometry::Ray;
use crate::light::PlaneMirror;

/// The bright spots of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct BrightSpots {
    pub(in crate::indirect) spots: Vec<BrightSpot>,
}

/// Surfaces near a lamp.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) struct BrightSpot {
    pub shape: SpotShape,
    /// Luminous flux that the surfaces reflect, lumen; the largest channel.
    pub flux: f32,
    /// How many times as bright as the mean its brightest part may be, of what is sampled evenly.
    pub contrast: f32,
    /// The mirror behind which it is seen.
    pub mirror: Option<PlaneMirror>,
}

/// Where the surfaces of a spot are.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) enum SpotShape {
    /// In the plane through `foot` with normal `n`, which faces the lamp; lit by rays that are even in a cone.
    Plane { lamp: Vec3, foot: Vec3, n: Vec3, cone: EvenCone },
    /// Within a distance of the lamp.
    Ball { center: Vec3, radius: f32 },
    /// In a rectangle, lit from its front.
    Patch(Rectangle),
}

/// How a spot looks from a point.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) struct SpotView {
    /// Irradiance on a surface that faces it, lux, if nothing stands between.
    pub irradiance: f32,
    /// Its solid angle, steradian: of a disk as wide as the lamp is high.
    pub solid_angle: f32,
}

impl BrightSpot {
    /// Returns how the spot looks from `x`, `None` from behind and from within.
    pub(in crate::indirect) fn seen_from(&self, x: Vec3) -> Option<SpotView> {
        match self.shape {
            SpotShape::Plane { lamp, foot, n, .. } => {
                let d = x - foot;
                let (r2, height2) = (d.length_squared(), lamp.distance_squared(foot));
                let cos = n.dot(d) / r2.sqrt();
                (cos > 0.0).then(|| SpotView {
                    irradiance: self.flux * cos / (PI * (r2 + height2)),
                    solid_angle: PI * height2 * cos / r2,
                })
            }
            SpotShape::Ball { center, radius } => {
                if self.mirror.is_some_and(|mirror| mirror.height(x) * mirror.height(center) >= 0.0) {
                    return None;
                }
                let r2 = x.distance_squared(center);
                (r2 > 4.0 * radius * radius).then(|| SpotView {
                    irradiance: self.flux / (4.0 * PI * r2),
                    solid_angle: PI * radius * radius / r2,
                })
            }
            SpotShape::Patch(rectangle) => {
                let d = x - rectangle.center;
                let cos = rectangle.n.dot(d) / d.length();
                let r2 = d.length_squared() + rectangle.area() / PI;
                (cos > 0.0).then(|| SpotView {
                    irradiance: self.flux * cos / (PI * r2),
                    solid_angle: rectangle.area() * cos / r2,
                })
            }
        }
    }

    /// Returns rays from `x` to places of the spot, which end before it; none where the way is by a mirror. Of a plane,
    /// the second goes to the far side: through the opening of a can, a lid is seen at a slant.
    pub(in crate::indirect) fn rays_from(&self, x: Vec3) -> impl Iterator<Item = Ray> {
        let to = |place: Vec3, before: f32| Ray { t_max: (1.0 - before).max(0.0), ..Ray::segment(x, place) };
        let rays = match self.shape {
            SpotShape::Plane { lamp, foot, n, .. } => {
                let away = (foot - x).reject_from_normalized(n).normalize_or_zero();
                [Some(to(foot, 0.01)), Some(to(foot + away * lamp.distance(foot), 0.01))]
            }
            SpotShape::Ball { center, radius } => [Some(to(center, 1.01 * radius / x.distance(center))), None],
            SpotShape::Patch(Rectangle { center, half, .. }) => {
                [0.5, -0.5].map(|s| Some(to(center + s * half[0], 0.01)))
            }
        };
        rays.into_iter().flatten().filter(|_| self.mirror.is_none())
    }

    /// Returns the directions from `x` to the spot.
    pub(in crate::indirect) fn directions_from(&self, x: Vec3) -> SpotDirections {
        match self.shape {
            SpotShape::Plane { lamp, foot, n, cone } => SpotDirections::Plane { x, lamp, foot, n, cone },
            SpotShape::Ball { center, radius } => {
                let cone = cone_of_ball(x, center, radius);
                SpotDirections::Cone { cone, pdf: 1.0 / cone.solid_angle() }
            }
            SpotShape::Patch(rectangle) => SpotDirections::Rectangle { x, rectangle },
        }
    }
}

impl BrightSpots {
    /// The spots.
    pub(in crate::indirect) fn iter(&self) -> impl Iterator<Item = &BrightSpot> {
        self.spots.iter()
    }

    /// Whether there are none.
    pub(in crate::indirect) fn is_empty(&self) -> bool {
        self.spots.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::Vec2;

    use super::*;
    use crate::sampling::{hash, unit_f32};

    const LAMP: Vec3 = Vec3::new(0.3, 2.9, -0.2);
    const X: Vec3 = Vec3::new(-1.0, 1.0, 0.5);

    fn plane() -> BrightSpot {
        let cone = EvenCone { axis: Vec3::Y, cos: 0.05 };
        let shape = SpotShape::Plane { lamp: LAMP, foot: LAMP.with_y(3.0), n: Vec3::NEG_Y, cone };
        BrightSpot { shape, flux: 1.0, contrast: 1.0, mirror: None }
    }

    fn ball() -> BrightSpot {
        BrightSpot { shape: SpotShape::Ball { center: LAMP, radius: 0.4 }, flux: 1.0, contrast: 1.0, mirror: None }
    }

    /// The mean of f / pdf over samples is the integral of f: of 1 over a region of known solid angle, and of a plane's
    /// irradiance from a point lamp over the disk of radius a, 2π (1 − h / √(h² + a²)) for unit intensity.
    #[test]
    fn samples_over_their_density_integrate() {
        let n = 20_000;
        let u = |i: u32| Vec2::new((i as f32 + 0.5) / n as f32, unit_f32(hash(i)));
        let mut inside = 0.0;
        for i in 0..n {
            let w = plane().directions_from(X).sample(u(i)).expect("a direction");
            let q = X + w * ((3.0 - X.y) / w.y);
            let (r2, cos) = ((q - LAMP).length_squared(), 0.1 / (q - LAMP).length());
            let (radius2, d2) = ((q - LAMP.with_y(3.0)).length_squared(), (q - X).length_squared());
            if radius2 < 0.25 {
                // Irradiance times the area that a steradian sees, over the density.
                inside += cos / r2 * d2 / w.y / plane().directions_from(X).pdf(w) / n as f32;
            }
        }
        let disk = TAU * (1.0 - 0.1 / 0.26_f32.sqrt());
        assert!((inside / disk - 1.0).abs() < 0.01, "{inside} {disk}");

        let ball = ball().directions_from(X);
        let solid: f32 = (0..n).map(|i| 1.0 / ball.pdf(ball.sample(u(i)).expect("a direction"))).sum();
        let sin2 = 0.16 / X.distance_squared(LAMP);
        let cap = TAU * (1.0 - (1.0 - sin2).sqrt());
        assert!((solid / n as f32 / cap - 1.0).abs() < 0.01);
    }

    /// No light from behind, and none in directions away from it.
    #[test]
    fn directions_away_have_no_density() {
        let pdf = |spot: BrightSpot| spot.directions_from(X).pdf(Vec3::NEG_Y);
        assert_eq!((pdf(plane()), pdf(ball())), (0.0, 0.0));
        assert!(plane().seen_from(Vec3::new(0.0, 3.5, 0.0)).is_none() && ball().seen_from(LAMP).is_none());
    }
}
