//! The tree over instances, spheres and shapes.

use std::sync::Arc;

use fearless_simd::Simd;
use glam::Vec3;

use super::binary_tree::{self, BinaryNode, Item};
use super::collapse::{LeafRule, WideTree, collapse};
use super::flatten::ObjectFromWorld;
use super::hit::{Hit, Target};
use super::node::Node;
use super::traverse::{AsTheyCome, BoxRay, FrontToBack, MAX_DEPTH, Stacks, traverse};
use super::triangle_block::TriangleHit;
use super::triangle_bvh::{Closest, TriangleBvh};
use crate::geometry::{Aabb, Ray, Shape, Sphere};

/// The cost of entering an instance, in nodes. Empirical.
const OBJECT_COST: f32 = 4.0;

/// Largest coordinate of an object's box, metres: boxes of unbounded shapes are cut there, so that surfaces stay
/// finite.
const FAR: f32 = 1e18;

/// The most crossings of one sphere or shape that `any_hit` offers.
const MAX_CROSSINGS: usize = 64;

/// Something in the top level.
#[derive(Clone, Debug)]
pub(super) struct Object {
    bounds: Aabb,
    surface: Surface,
}

#[derive(Clone, Debug)]
enum Surface {
    Instance { instance: u32, mesh: usize, object_from_world: ObjectFromWorld },
    Sphere { index: u32, sphere: Sphere },
    Shape { index: u32, shape: Arc<dyn Shape> },
}

impl Object {
    /// `bounds`: the transformed box of the mesh. It is widened by 2⁻²⁰ of its largest coordinate, for the rounding of
    /// the transformed corners (three products and sums, 2⁻²⁴ each) and of the ray in object space.
    pub(super) fn instance(bounds: Aabb, instance: u32, mesh: usize, object_from_world: ObjectFromWorld) -> Self {
        let margin = bounds.min.abs().max(bounds.max.abs()).max_element() * (1.0 / (1 << 20) as f32);
        let bounds = Aabb { min: bounds.min - margin, max: bounds.max + margin };
        Self { bounds, surface: Surface::Instance { instance, mesh, object_from_world } }
    }

    pub(super) fn sphere(sphere: Sphere, index: u32) -> Self {
        Self { bounds: sphere.bounds(), surface: Surface::Sphere { index, sphere } }
    }

    pub(super) fn shape(shape: Arc<dyn Shape>, index: u32) -> Self {
        Self { bounds: shape.bounds(), surface: Surface::Shape { index, shape } }
    }
}

/// An 8-wide tree over objects.
#[derive(Clone, Debug)]
pub(super) struct TopLevel {
    tree: WideTree,
    /// In the order of the leaves.
    objects: Vec<Object>,
    bounds: Aabb,
}

impl TopLevel {
    /// Builds the tree; `None` if no object has a box.
    pub(super) fn build(mut objects: Vec<Object>) -> Option<Self> {
        // Leave out empty objects, and cut unbounded ones.
        objects.retain(|o| !o.bounds.is_empty());
        for Object { bounds, .. } in &mut objects {
            *bounds = Aabb { min: bounds.min.max(Vec3::splat(-FAR)), max: bounds.max.min(Vec3::splat(FAR)) };
        }
        let items: Vec<Item> =
            objects.iter().zip(0..).map(|(o, primitive)| Item { bounds: o.bounds, primitive }).collect();
        // Build a binary tree and collapse it; a balanced one where that is too deep for the stacks.
        let make = |binary: &[BinaryNode]| {
            let rule = LeafRule { primitives_per_item: 1, max_items: 1, item_cost: OBJECT_COST };
            let mut order = Vec::with_capacity(items.len());
            let tree = collapse(binary, rule, &mut |under| {
                let first = order.len();
                order.extend_from_slice(under);
                first..order.len()
            });
            (tree, order)
        };
        let (mut tree, mut order) = make(&binary_tree::build(&items));
        if tree.depth > MAX_DEPTH {
            (tree, order) = make(&binary_tree::median_tree(&items));
        }
        let bounds = items.iter().fold(Aabb::EMPTY, |b, i| b.union(i.bounds));
        let objects = order.iter().map(|&i| objects[i as usize].clone()).collect();
        tree.root.is_some().then_some(Self { tree, objects, bounds })
    }

    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    pub(crate) fn bytes(&self) -> u64 {
        (self.tree.nodes.len() * size_of::<Node>() + self.objects.len() * size_of::<Object>()) as u64
    }

    /// Returns the closest of `closest` and the hits of this tree.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        meshes: &[Option<TriangleBvh>],
        stacks: &mut Stacks,
        mut closest: Option<Hit>,
    ) -> Option<Hit> {
        let Some(root) = self.tree.root else { return closest };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        // Begin at the hit that is there already.
        let mut t_max = closest.map_or(ray.t_max, |hit| hit.t);
        traverse::<S, FrontToBack>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut t_max,
            &mut stacks.top,
            #[inline(always)]
            |leaf, t_max| {
                // Intersect each object of the leaf, instances in their own space.
                for object in &self.objects[leaf.items()] {
                    let hit = match &object.surface {
                        Surface::Instance { instance, mesh, object_from_world } => {
                            let Some(bvh) = &meshes[*mesh] else { continue };
                            // A lower instance wins a tie, a higher one does not.
                            let tie = closest
                                .is_some_and(|c| c.target > Target::Triangle { instance: *instance, triangle: 0 });
                            let mut inner = Closest::before(*t_max, if tie { u32::MAX } else { 0 });
                            let ray = object_from_world.ray(ray);
                            simd.vectorize(
                                #[inline(always)]
                                || bvh.closest(simd, &ray, &mut stacks.mesh, &mut inner),
                            );
                            let TriangleHit { t, u, v, id } = inner.hit;
                            let target = Target::Triangle { instance: *instance, triangle: id };
                            inner.found.then_some(Hit { t, u, v, target })
                        }
                        Surface::Sphere { index, sphere } => {
                            sphere.intersect(ray).map(|t| hit_at(t, Target::Sphere(*index)))
                        }
                        Surface::Shape { index, shape } => {
                            shape.intersect(ray).map(|t| hit_at(t, Target::Shape(*index)))
                        }
                    };
                    // Keep the closer hit, of equal ones that of the lower target.
                    if let Some(hit) = hit
                        && (hit.t < *t_max || closest.is_some_and(|c| hit.t == c.t && hit.target < c.target))
                    {
                        closest = Some(hit);
                        *t_max = hit.t;
                    }
                }
                false
            },
        );
        closest
    }

    /// Whether the ray meets any object.
    #[inline(always)]
    pub(super) fn occluded<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        meshes: &[Option<TriangleBvh>],
        stacks: &mut Stacks,
    ) -> bool {
        let Some(root) = self.tree.root else { return false };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        traverse::<S, AsTheyCome>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut { ray.t_max },
            &mut stacks.top,
            #[inline(always)]
            |leaf, _| {
                // Stop at the first object of the leaf that is met.
                for object in &self.objects[leaf.items()] {
                    let met = match &object.surface {
                        Surface::Instance { mesh, object_from_world, .. } => {
                            let Some(bvh) = &meshes[*mesh] else { continue };
                            let ray = object_from_world.ray(ray);
                            simd.vectorize(
                                #[inline(always)]
                                || bvh.occluded(simd, &ray, &mut stacks.mesh),
                            )
                        }
                        Surface::Sphere { sphere, .. } => sphere.intersect(ray).is_some(),
                        Surface::Shape { shape, .. } => shape.intersect(ray).is_some(),
                    };
                    if met {
                        return true;
                    }
                }
                false
            },
        )
    }

    /// Offers all hits to `accept`, in any order, until it returns true; returns whether it did.
    #[inline(always)]
    pub(super) fn any_hit<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        meshes: &[Option<TriangleBvh>],
        stacks: &mut Stacks,
        accept: &mut dyn FnMut(&Hit) -> bool,
    ) -> bool {
        let Some(root) = self.tree.root else { return false };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        traverse::<S, AsTheyCome>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut { ray.t_max },
            &mut stacks.top,
            #[inline(always)]
            |leaf, _| {
                // Offer the hits of each object of the leaf: all triangles, all crossings.
                for object in &self.objects[leaf.items()] {
                    let stop = match &object.surface {
                        Surface::Instance { instance, mesh, object_from_world } => {
                            let Some(bvh) = &meshes[*mesh] else { continue };
                            let ray = object_from_world.ray(ray);
                            // Traverse the mesh in object space, where t stays the same.
                            let mut offer = |TriangleHit { t, u, v, id }| {
                                let target = Target::Triangle { instance: *instance, triangle: id };
                                accept(&Hit { t, u, v, target })
                            };
                            simd.vectorize(
                                #[inline(always)]
                                || bvh.any_hit(simd, &ray, &mut stacks.mesh, &mut offer),
                            )
                        }
                        Surface::Sphere { index, sphere } => {
                            crossings(ray, |ray| sphere.intersect(ray), |t| accept(&hit_at(t, Target::Sphere(*index))))
                        }
                        Surface::Shape { index, shape } => {
                            crossings(ray, |ray| shape.intersect(ray), |t| accept(&hit_at(t, Target::Shape(*index))))
                        }
                    };
                    if stop {
                        return true;
                    }
                }
                false
            },
        )
    }
}

/// Makes the hit of a surface that has no barycentric coordinates.
fn hit_at(t: f32, target: Target) -> Hit {
    Hit { t, u: 0.0, v: 0.0, target }
}

/// Offers each crossing of one surface, nearest first, until `accept` returns true.
fn crossings(ray: &Ray, intersect: impl Fn(&Ray) -> Option<f32>, mut accept: impl FnMut(f32) -> bool) -> bool {
    let mut rest = *ray;
    for _ in 0..MAX_CROSSINGS {
        match intersect(&rest) {
            Some(t) if t > rest.t_min && t < rest.t_max => {
                if accept(t) {
                    return true;
                }
                rest.t_min = t;
            }
            _ => return false,
        }
    }
    false
}
