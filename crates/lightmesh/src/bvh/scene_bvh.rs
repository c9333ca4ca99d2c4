//! The two levels: the flattened world, and above it the tree over instances, spheres and shapes.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::flatten::{ObjectFromWorld, corners, flattened_meshes};
use super::hit::{Hit, Target};
use super::top_level::{Object, TopLevel};
use super::traverse::Stacks;
use super::triangle_block::TriangleHit;
use super::triangle_bvh::{Closest, TriangleBvh};
use crate::geometry::{Aabb, Ray, TriangleMesh};
use crate::scene::SceneData;

/// The acceleration structure of a scene.
///
/// Meshes that are placed once lie in one tree in world space. A mesh with several instances keeps one tree in object
/// space; instances, spheres and user-defined shapes stand in a tree above, which scenes without them do not have.
///
/// A ray's `t_min` must be ≥ 0 and its direction not zero. A ray that is not finite meets nothing, and a hit lies at a
/// finite t.
#[derive(Clone, Debug)]
pub struct SceneBvh {
    pub(super) level: Level,
    world: TriangleBvh,
    /// The instance of each triangle of the world. (A search among the instances' first triangles instead of 4 B per
    /// triangle costs mispredicted branches at every hit.)
    owners: Vec<u32>,
    /// Where in the world's numbering the triangles of an instance begin; 0 for those that are not in it.
    firsts: Vec<u32>,
    /// Object-space trees; `None` for meshes that are flattened.
    meshes: Vec<Option<TriangleBvh>>,
    top: Option<TopLevel>,
}

impl SceneBvh {
    /// Builds the structure. `data` has been validated: indices in range, positions finite. Triangles without area and
    /// instances whose transform has no inverse may be there; they are never hit. The result is the same for any number
    /// of threads.
    pub fn build(data: &SceneData) -> Self {
        // Copy what is placed once into world space.
        let flat = flattened_meshes(data);
        let (mut triangles, mut owners, mut objects) = (Vec::new(), Vec::new(), Vec::new());
        let mut firsts = vec![0; data.instances.len()];
        for (placed, instance) in data.instances.iter().zip(0..) {
            let Some(object_from_world) = ObjectFromWorld::new(placed) else { continue };
            let mesh = &data.meshes[placed.mesh];
            if flat[placed.mesh] {
                firsts[instance as usize] = triangles.len() as u32;
                triangles.extend(corners(mesh, |p| placed.world_from_object.transform_point3(p)));
                owners.resize(triangles.len(), instance);
            } else {
                let bounds = mesh.bounds().transformed(&placed.world_from_object);
                objects.push(Object::instance(bounds, instance, placed.mesh, object_from_world));
            }
        }
        owners.shrink_to_fit();
        let world = TriangleBvh::build(&triangles);
        drop(triangles);

        // One tree per mesh that is placed several times.
        let build_mesh = |(mesh, &flat): (&TriangleMesh, &bool)| {
            (!flat).then(|| TriangleBvh::build(&corners(mesh, |p| p).collect::<Vec<_>>()))
        };
        let meshes = data.meshes.par_iter().zip(&flat).map(build_mesh).collect();

        // The level above.
        objects.extend(data.spheres.iter().zip(0..).map(|(sphere, i)| Object::sphere(*sphere, i)));
        objects.extend(data.shapes.iter().zip(0..).map(|(entry, i)| Object::shape(entry.shape.clone(), i)));
        let top = TopLevel::build(objects);
        Self { level: Level::new(), world, owners, firsts, meshes, top }
    }

    /// The box around everything that can be hit, metres in world space; [`Aabb::EMPTY`] if there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.top.as_ref().map_or(Aabb::EMPTY, TopLevel::bounds).union(self.world.bounds())
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> u64 {
        let meshes: u64 = self.meshes.iter().flatten().map(TriangleBvh::bytes).sum();
        let owners = (self.owners.len() + self.firsts.len()) * size_of::<u32>();
        self.world.bytes() + meshes + owners as u64 + self.top.as_ref().map_or(0, TopLevel::bytes)
    }

    /// The first surface that the ray meets in (t_min, t_max); of several at the same t the lowest [`Target`].
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = [None];
        self.closest_batch(std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// Whether the ray meets anything in (t_min, t_max).
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut occluded = [false];
        self.occluded_batch(std::slice::from_ref(ray), &mut occluded);
        occluded[0]
    }

    /// Offers the surfaces that the ray meets in (t_min, t_max) to `accept`, each at most once (a sphere or a shape
    /// once per crossing), in any order, until it returns true; returns whether it did.
    pub fn any_hit(&self, ray: &Ray, mut accept: impl FnMut(&Hit) -> bool) -> bool {
        self.any_hit_dyn(ray, &mut accept)
    }

    /// [`Self::closest`] of each ray; the SIMD level is chosen once for all. `hits` must be as long as `rays`.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        debug_assert_eq!(rays.len(), hits.len());
        let mut stacks = Stacks::take();
        dispatch!(self.level, simd => {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.closest_with(simd, ray, &mut stacks);
            }
        });
        stacks.give_back();
    }

    /// [`Self::occluded`] of each ray; the SIMD level is chosen once for all. `occluded` must be as long as `rays`.
    pub fn occluded_batch(&self, rays: &[Ray], occluded: &mut [bool]) {
        debug_assert_eq!(rays.len(), occluded.len());
        let mut stacks = Stacks::take();
        dispatch!(self.level, simd => {
            for (ray, occluded) in rays.iter().zip(occluded) {
                *occluded = self.occluded_with(simd, ray, &mut stacks);
            }
        });
        stacks.give_back();
    }

    /// The target of a triangle of the flattened world.
    fn world_target(&self, id: u32) -> Target {
        let instance = self.owners[id as usize];
        Target::Triangle { instance, triangle: id - self.firsts[instance as usize] }
    }

    #[inline(always)]
    fn closest_with<S: Simd>(&self, simd: S, ray: &Ray, stacks: &mut Stacks) -> Option<Hit> {
        let ray = &within_numbers(ray);
        let mut closest = Closest::before(ray.t_max, 0);
        self.world.closest(simd, ray, &mut stacks.mesh, &mut closest);
        let TriangleHit { t, u, v, id } = closest.hit;
        let hit = closest.found.then(|| Hit { t, u, v, target: self.world_target(id) });
        match &self.top {
            None => hit,
            Some(top) => top.closest(simd, ray, &self.meshes, stacks, hit),
        }
    }

    #[inline(always)]
    fn occluded_with<S: Simd>(&self, simd: S, ray: &Ray, stacks: &mut Stacks) -> bool {
        self.world.occluded(simd, ray, &mut stacks.mesh)
            || self.top.as_ref().is_some_and(|top| top.occluded(simd, ray, &self.meshes, stacks))
    }

    fn any_hit_dyn(&self, ray: &Ray, accept: &mut dyn FnMut(&Hit) -> bool) -> bool {
        let ray = &within_numbers(ray);
        let mut stacks = Stacks::take();
        let stopped = dispatch!(self.level, simd => {
            let mut world = |TriangleHit { t, u, v, id }| accept(&Hit { t, u, v, target: self.world_target(id) });
            self.world.any_hit(simd, ray, &mut stacks.mesh, &mut world)
                || self.top.as_ref().is_some_and(|top| top.any_hit(simd, ray, &self.meshes, &mut stacks, accept))
        });
        stacks.give_back();
        stopped
    }
}

/// The ray without its end at infinity: where a distance overflows, nothing is met.
#[inline(always)]
fn within_numbers(ray: &Ray) -> Ray {
    Ray { t_max: ray.t_max.min(f32::MAX), ..*ray }
}
