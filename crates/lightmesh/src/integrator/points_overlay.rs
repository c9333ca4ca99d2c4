//! A picture of mesh points as the camera sees them: small balls over the dimmed albedo.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::film::View;
use crate::geometry::Ray;
use crate::options::{Aov, Layer};
use crate::scene::FilmRays;
use crate::world::Scene;

/// What points look like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dots {
    /// Linear RGB.
    color: Vec3,
    /// In spacings of the mesh.
    radius: f32,
    /// Up to which distance behind a surface they shine through it, in spacings: those inside solids are never visible.
    shines_through: f32,
}

impl Dots {
    /// Green: points of the direct mesh that have their light.
    pub(crate) const DIRECT: Self = Self { color: Vec3::new(0.07, 0.78, 0.16), radius: 0.09, shines_through: 0.0 };
    /// Red: points of the direct mesh inside solids.
    pub(crate) const DIRECT_INVALID: Self =
        Self { color: Vec3::new(0.95, 0.03, 0.02), radius: 0.09, shines_through: 1.8 };
    /// Blue: the indirect mesh.
    pub(crate) const INDIRECT: Self = Self { color: Vec3::new(0.06, 0.24, 0.95), radius: 0.06, shines_through: 0.0 };
    /// Orange: points of the indirect mesh inside solids.
    pub(crate) const INDIRECT_INVALID: Self =
        Self { color: Vec3::new(0.95, 0.3, 0.02), radius: 0.06, shines_through: 1.8 };
}

/// Points of a mesh, to be painted.
#[derive(Clone, Debug)]
pub(crate) struct PointCloud {
    pub(crate) dots: Dots,
    /// The mesh's, metres.
    pub(crate) spacing: f32,
    pub(crate) positions: Vec<Vec3>,
}

/// Radius in pixels: a ball is at least a dot, and one beside the camera does not hide the picture.
const MIN_RADIUS: f32 = 1.3;
const MAX_RADIUS: f32 = 9.0;

/// How much of the picture a ball that shines through a surface hides.
const HIDDEN_ALPHA: f32 = 0.45;

/// A point that is drawn.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vec2,
    radius: f32,
    depth: f32,
    color: Vec3,
    alpha: f32,
    /// Where a surface is nearer than this, it hides the ball.
    near: f32,
}

/// Paints the points over the scene, on the layer [`Aov::Points`]; the layers of albedo, normal and depth must be
/// there as well. Returns how many rays found out which points are visible.
pub(crate) fn paint_points(scene: &Scene, view: &View, layers: &mut [Layer], points: &[PointCloud]) -> u64 {
    let Some(canvas) = layers.iter_mut().find(|layer| layer.aov == Aov::Points) else { return 0 };
    let mut picture = std::mem::take(&mut canvas.values);
    let layer = |aov| layers.iter().find(|layer| layer.aov == aov).map_or(&[][..], |layer| &layer.values);
    let (albedo, normal, depth) = (layer(Aov::Albedo), layer(Aov::Normal), layer(Aov::Depth));

    // Paint the scene, grey, as if its only light were at the camera.
    for (i, pixel) in picture.chunks_exact_mut(3).enumerate() {
        let value = |values: &[f32]| Vec3::from_slice(&values[3 * i..]);
        let direction = view.pixel_ray(i as u32).direction;
        let grey = value(albedo).dot(Vec3::new(0.2126, 0.7152, 0.0722));
        pixel.fill(0.25 * grey * (0.25 + 0.75 * value(normal).dot(direction).abs()));
    }

    // Find the visible points.
    let mut balls: Vec<Ball> = Vec::new();
    let mut shot = 0;
    for PointCloud { dots, spacing, positions } in points {
        let on_film: Vec<Vec3> = positions.iter().copied().filter(|&p| is_on_film(view, p)).collect();
        shot += on_film.len() as u64;
        balls.par_extend(on_film.into_par_iter().filter_map(|p| ball(scene, &view.rays, dots, *spacing, p)));
    }

    // Draw them, the farthest first; a stable order, so that equal depths do not depend on threads.
    balls.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    balls.iter().for_each(|ball| ball.draw(&mut picture, depth, view));
    let canvas = layers.iter_mut().filter(|layer| layer.aov == Aov::Points);
    canvas.for_each(|layer| layer.values = std::mem::take(&mut picture));
    shot
}

/// Whether a point is in front of the camera and inside the picture.
fn is_on_film(view: &View, p: Vec3) -> bool {
    if view.rays.depth(p) <= 0.0 {
        return false;
    }
    let (center, _) = view.rays.project(p);
    let size = Vec2::new(view.width as f32, view.height as f32);
    (center.cmpge(Vec2::splat(-MAX_RADIUS)) & center.cmple(size + MAX_RADIUS)).all()
}

/// The ball of a point; `None` where a surface hides it.
fn ball(scene: &Scene, rays: &FilmRays, dots: &Dots, spacing: f32, p: Vec3) -> Option<Ball> {
    let depth = rays.depth(p);
    let (center, pixels_per_metre) = rays.project(p);
    let eye = rays.ray(center.x, center.y).origin;
    let ray = Ray::segment(eye, p);
    let hit = scene.bvh().closest(&ray);
    if let Some(hit) = hit
        && (1.0 - hit.t) * ray.direction.length() > dots.shines_through * spacing
    {
        return None;
    }
    Some(Ball {
        center,
        radius: (dots.radius * spacing * pixels_per_metre).clamp(MIN_RADIUS, MAX_RADIUS),
        depth,
        color: dots.color,
        alpha: if hit.is_some() { HIDDEN_ALPHA } else { 1.0 },
        near: depth - spacing * if hit.is_some() { 2.0 } else { 0.5 },
    })
}

impl Ball {
    /// Draws it over the picture, shaded as by a light at the camera, with a smooth rim.
    fn draw(&self, picture: &mut [f32], depth: &[f32], view: &View) {
        let reach = self.radius + 0.5;
        let range = |center: f32, size: u32| {
            let first = (center - reach).floor().clamp(0.0, size as f32) as u32;
            first..((center + reach).ceil().clamp(0.0, size as f32) as u32)
        };
        for y in range(self.center.y, view.height) {
            for x in range(self.center.x, view.width) {
                let i = y as usize * view.width as usize + x as usize;
                let d = Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(self.center);
                let alpha = self.alpha * (reach - d).clamp(0.0, 1.0);
                if alpha > 0.0 && depth[i] >= self.near {
                    let facing = (1.0 - (d / reach).min(1.0).powi(2)).sqrt();
                    let pixel = &mut picture[3 * i..][..3];
                    let color = self.color * (0.25 + 0.75 * facing);
                    Vec3::from_slice(pixel).lerp(color, alpha).write_to_slice(pixel);
                }
            }
        }
    }
}
