//! What a ray meets.

/// Which surface was hit. Indices are those of [`SceneData`](crate::SceneData).
///
/// The order decides between surfaces at exactly the same distance: the lowest is the hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// A triangle of a placed mesh.
    Triangle {
        /// Index into [`SceneData::instances`](crate::scene::SceneData::instances).
        instance: u32,
        /// Index into the [`triangles`](crate::geometry::TriangleMesh::triangles) of that instance's mesh.
        triangle: u32,
    },
    /// Index into [`SceneData::spheres`](crate::scene::SceneData::spheres).
    Sphere(u32),
    /// Index into [`SceneData::shapes`](crate::scene::SceneData::shapes).
    Shape(u32),
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the triangle's corner 1, in [0, 1]; 0 for spheres and shapes.
    pub u: f32,
    /// Barycentric weight of corner 2.
    pub v: f32,
    /// The surface.
    pub target: Target,
}
