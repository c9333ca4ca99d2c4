//! Cameras.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

use super::far_view::FarView;
use crate::geometry::{Aabb, Cone, Ray};

/// How a camera maps directions to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view, radians, in (0, π).
        yfov: f32,
        /// Width over height that the author meant; `None`: any.
        aspect: Option<f32>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the view, metres.
        xmag: f32,
        /// Half its height, metres.
        ymag: f32,
    },
}

/// A camera; it looks along its own −Z, +Y is up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Camera {
    /// Name in the file; may be empty.
    pub name: String,
    /// The file's coordinates ([`SceneData::origin`](crate::SceneData::origin)) from camera space; scale is ignored. In
    /// double precision, for what is far away.
    pub world_from_camera: DAffine3,
    /// Lens.
    pub projection: Projection,
}

impl Camera {
    /// A camera at `eye` that looks at `target`; `yfov` in radians.
    pub fn look_at(eye: Vec3, target: Vec3, yfov: f32) -> Self {
        let back = (eye - target).normalize_or(Vec3::Z);
        // Straight down, the top of the picture is −Z; straight up, +Z.
        let up = if back.y.abs() > 0.999 { -Vec3::Z * back.y.signum() } else { Vec3::Y };
        let right = up.cross(back).normalize();
        let matrix = DMat3::from_cols(right.as_dvec3(), back.cross(right).as_dvec3(), back.as_dvec3());
        Self {
            name: String::new(),
            world_from_camera: DAffine3 { matrix3: matrix, translation: eye.as_dvec3() },
            projection: Projection::Perspective { yfov, aspect: None },
        }
    }

    /// A camera that has the whole box in view, from a little above and to the right of its +Z side.
    pub fn framing(bounds: &Aabb) -> Self {
        let yfov = 0.8_f32;
        let radius = (0.5 * bounds.size().length()).max(1e-6);
        let direction = Vec3::new(0.45, 0.35, 1.0).normalize();
        let center = bounds.center();
        Self::look_at(center + direction * (radius / libm::sinf(0.5 * yfov)), center, yfov)
    }

    /// Width over height that the author meant; 1.5 if it is not given.
    pub fn aspect(&self) -> f32 {
        match self.projection {
            Projection::Perspective { aspect, .. } => aspect.unwrap_or(1.5),
            Projection::Orthographic { xmag, ymag } => (xmag / ymag).abs(),
        }
    }

    /// Returns the map from film positions of a `width` × `height` picture to rays. A perspective camera keeps its
    /// vertical field of view whatever the picture's aspect, as glTF's viewers do; an orthographic one keeps `ymag`.
    pub fn film(&self, width: u32, height: u32) -> FilmRays {
        let m = &self.world_from_camera.matrix3;
        let (right, up) = (m.x_axis.as_vec3().normalize_or(Vec3::X), m.y_axis.as_vec3().normalize_or(Vec3::Y));
        let forward = -m.z_axis.as_vec3().normalize_or(Vec3::Z);
        let eye = self.world_from_camera.translation.as_vec3();
        let half_height = match self.projection {
            Projection::Perspective { yfov, .. } => libm::tanf(0.5 * yfov),
            Projection::Orthographic { ymag, .. } => ymag,
        };
        let pixel = 2.0 * half_height / height as f32;
        FilmRays {
            eye,
            forward,
            dx: right * pixel,
            dy: up * -pixel,
            pixel,
            center_x: 0.5 * width as f32,
            center_y: 0.5 * height as f32,
            parallel: matches!(self.projection, Projection::Orthographic { .. }),
            far: None,
        }
    }

    /// Returns [`Camera::film`] in a scene's coordinates: its origin and the box around its surfaces. Rays of a camera
    /// far outside the box start next to it.
    pub(crate) fn film_in(&self, origin: DVec3, bounds: &Aabb, width: u32, height: u32) -> FilmRays {
        let mut placed = self.clone();
        placed.world_from_camera.translation -= origin;
        let mut film = placed.film(width, height);
        film.far = FarView::new(&placed.world_from_camera, film.pixel.into(), film.parallel, bounds);
        film
    }
}

/// The rays of one camera and film size.
#[derive(Clone, Copy, Debug)]
pub struct FilmRays {
    eye: Vec3,
    forward: Vec3,
    dx: Vec3,
    dy: Vec3,
    /// The length of `dx` and `dy`.
    pixel: f32,
    center_x: f32,
    center_y: f32,
    parallel: bool,
    /// Where the camera is so far from the scene that single precision does not do.
    far: Option<FarView>,
}

impl FilmRays {
    /// The ray through film position (x, y) in pixels, (0, 0) the upper left corner of the picture; unit direction.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        if let Some(far) = &self.far {
            return far.ray(x - self.center_x, y - self.center_y);
        }
        let offset = self.dx * (x - self.center_x) + self.dy * (y - self.center_y);
        if self.parallel {
            Ray::new(self.eye + offset, self.forward)
        } else {
            Ray::new(self.eye, (self.forward + offset).normalize())
        }
    }

    /// The camera's position, metres; rays of a perspective camera start there, or before the scene's box.
    pub(crate) fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Returns the cone of which `ray`, one of the film's, is a sample: that of a square `width` pixels wide whose
    /// middle is `offset` pixels from the ray. It is as wide as the root of its solid angle, cos³θ times that of a
    /// square on the axis, θ the angle to it.
    pub(crate) fn cone(&self, ray: &Ray, width: f32, offset: Vec2) -> Cone {
        let pixel = self.pixel;
        let cos = ray.direction.dot(self.forward).max(0.0);
        let offset = self.dx * offset.x + self.dy * offset.y;
        if self.parallel {
            return Cone { width: width * pixel, spread: 0.0, offset: offset / (width * pixel) };
        }
        let spread = width * pixel * cos * cos.sqrt();
        // The derivative of the unit direction.
        let offset = (offset - ray.direction * offset.dot(ray.direction)) * cos;
        let travelled = self.far.as_ref().map_or(0.0, |far| far.distance(ray.origin));
        Cone { width: spread * travelled, spread, offset: offset / spread }
    }

    /// Returns the distance of `p` along the camera's axis, metres.
    pub(crate) fn depth(&self, p: Vec3) -> f32 {
        if let Some(far) = &self.far {
            return far.depth(p);
        }
        (p - self.eye).dot(self.forward)
    }

    /// Returns the film position of a point whose depth is above 0, and the size in pixels of a metre there.
    pub(crate) fn project(&self, p: Vec3) -> (Vec2, f32) {
        if let Some(far) = &self.far {
            let (offset, pixels_per_metre) = far.project(p);
            return (offset + Vec2::new(self.center_x, self.center_y), pixels_per_metre);
        }
        let offset = p - self.eye;
        let scale = if self.parallel { 1.0 } else { 1.0 / self.depth(p) };
        let along = |axis: Vec3| offset.dot(axis) / axis.length_squared() * scale;
        (Vec2::new(along(self.dx) + self.center_x, along(self.dy) + self.center_y), scale / self.dx.length())
    }

    /// The film position of a perspective camera's ray: the inverse of [`FilmRays::ray`].
    #[cfg(test)]
    pub(crate) fn position(&self, ray: &Ray) -> Vec2 {
        let offset = ray.direction / ray.direction.dot(self.forward) - self.forward;
        let along = |axis: Vec3| offset.dot(axis) / axis.length_squared();
        Vec2::new(along(self.dx) + self.center_x, along(self.dy) + self.center_y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_the_film_looks_at_the_target_and_up_is_up() {
        let camera = Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::new(0.0, 1.0, 0.0), 0.7);
        let film = camera.film(200, 100);
        let ray = film.ray(100.0, 50.0);
        assert!((ray.direction - Vec3::new(-3.0, -1.0, -5.0).normalize()).length() < 1e-6);
        assert!(film.ray(100.0, 10.0).direction.y > ray.direction.y);
    }

    /// A point on a film position's ray is projected to that position, at the depth it has along the camera's axis.
    #[test]
    fn projecting_inverts_rays() {
        let pinhole = Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::new(0.0, 1.0, 0.5), 0.7);
        let parallel = Camera { projection: Projection::Orthographic { xmag: 2.0, ymag: 1.0 }, ..pinhole.clone() };
        for camera in [pinhole, parallel] {
            let film = camera.film(300, 200);
            for (x, y) in [(0.0, 0.0), (150.0, 100.0), (30.0, 170.0)] {
                let ray = film.ray(x, y);
                let t = 4.0 / ray.direction.dot(film.forward);
                let (position, pixels_per_metre) = film.project(ray.at(t));
                assert!((position - Vec2::new(x, y)).length() < 1e-3, "{position}");
                assert!((film.depth(ray.at(t)) - 4.0).abs() < 1e-5);
                // A metre to the right.
                let right = film.dx.normalize();
                let (beside, _) = film.project(ray.at(t) + right);
                assert!((beside.x - position.x - pixels_per_metre).abs() < 1e-2);
            }
        }
    }

    /// The root of a pixel's solid angle, from the directions of its corners: across half a pixel each way.
    #[test]
    fn cones_are_as_wide_as_pixels() {
        let pinhole = Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::new(0.0, 1.0, 0.5), 1.2);
        let film = pinhole.film(300, 200);
        for (x, y) in [(150.0, 100.0), (10.0, 20.0), (299.0, 199.0)] {
            let at = |x: f32, y: f32| film.ray(x, y).direction;
            let (dx, dy) = (at(x + 0.5, y) - at(x - 0.5, y), at(x, y + 0.5) - at(x, y - 0.5));
            let cone = film.cone(&film.ray(x, y), 0.5, Vec2::ZERO);
            assert!((cone.width_at(2.0) / dx.cross(dy).length().sqrt() - 1.0).abs() < 1e-3);
        }
        let parallel = Camera { projection: Projection::Orthographic { xmag: 2.0, ymag: 1.0 }, ..pinhole };
        let film = parallel.film(400, 200);
        assert!((film.cone(&film.ray(3.0, 5.0), 0.5, Vec2::ZERO).width_at(7.0) - 0.005).abs() < 1e-7);
    }

    /// The vertical field of view spans the height: the angle between the top and bottom rays is `yfov`.
    #[test]
    fn the_field_of_view_is_vertical() {
        let film = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 0.9).film(300, 100);
        let (top, bottom) = (film.ray(150.0, 0.0), film.ray(150.0, 100.0));
        assert!((top.direction.angle_between(bottom.direction) - 0.9).abs() < 1e-5);
    }

    #[test]
    fn framing_sees_every_corner_of_the_box() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 4.0), max: Vec3::new(9.0, 3.0, 6.0) };
        let camera = Camera::framing(&bounds);
        let camera_from_world = camera.world_from_camera.inverse();
        for i in 0..8 {
            let p = Vec3::new(
                [bounds.min.x, bounds.max.x][i & 1],
                [bounds.min.y, bounds.max.y][i >> 1 & 1],
                [bounds.min.z, bounds.max.z][i >> 2],
            );
            let c = camera_from_world.transform_point3(p.as_dvec3());
            assert!(c.z < 0.0 && (c.y / c.z).abs() < libm::tan(0.4));
        }
    }

    /// From 700 km, with an angle of a metre there, every pixel's ray passes within a hundredth of a millimetre of
    /// where the one from 700 m does, and starts next to the box; cones are as wide there.
    #[test]
    fn a_far_camera_sees_what_a_near_one_does() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        let target = DVec3::new(0.1, 0.2, -0.1);
        let camera = |distance: f64| {
            // A direction whose multiples are no floats.
            let back = DVec3::new(0.3, 0.5, 0.7).normalize();
            let right = DVec3::Y.cross(back).normalize();
            let matrix3 = DMat3::from_cols(right, back.cross(right), back);
            Camera {
                name: String::new(),
                world_from_camera: DAffine3 { matrix3, translation: target + back * distance },
                projection: Projection::Perspective { yfov: (1.0 / distance) as f32, aspect: None },
            }
        };
        let (near, far) = (camera(7e2), camera(7e5));
        let film = |camera: &Camera| camera.film_in(DVec3::ZERO, &bounds, 100, 100);
        let (near, far) = (film(&near), film(&far));
        for (x, y) in [(50.0, 50.0), (20.0, 70.0), (90.0, 10.0)] {
            let (a, b) = (near.ray(x, y), far.ray(x, y));
            assert!(b.origin.length() < 4.0, "{}", b.origin);
            // Where both are nearest to the target.
            let at = |ray: &Ray| {
                let to = target - ray.origin.as_dvec3();
                let d = ray.direction.as_dvec3().normalize();
                ray.origin.as_dvec3() + d * to.dot(d)
            };
            // Lines of sight from 700 m and 700 km differ by half a thousandth of the distance from the axis.
            assert!((at(&a) - at(&b)).length() < 1e-3, "{} {}", at(&a), at(&b));
            let (position, pixels_per_metre) = far.project(b.origin);
            assert!((position - Vec2::new(x, y)).length() < 1e-3 && (pixels_per_metre - 100.0).abs() < 0.1);
            assert!((far.cone(&b, 1.0, Vec2::ZERO).width - 0.01).abs() < 1e-5);
        }
    }

    /// A camera outside but not far keeps its rays, bit for bit.
    #[test]
    fn ordinary_cameras_keep_their_rays() {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        let camera = Camera::framing(&bounds);
        let (film, plain) = (camera.film_in(DVec3::ZERO, &bounds, 30, 20), camera.film(30, 20));
        assert_eq!(film.ray(3.5, 7.5), plain.ray(3.5, 7.5));
    }
}
