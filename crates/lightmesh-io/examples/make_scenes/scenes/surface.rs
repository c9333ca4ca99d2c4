//! A triangle mesh while it is being built.

/// A point or direction, computed in f64 and rounded to f32 once.
pub(crate) type Vec3 = [f64; 3];

/// `a − b`.
pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s b`.
pub(crate) fn add_scaled(a: Vec3, b: Vec3, s: f64) -> Vec3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// The cross product.
pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `v / |v|`.
pub(crate) fn normalize(v: Vec3) -> Vec3 {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

/// Positions, unit normals and triangles, counter-clockwise from the front.
#[derive(Clone, Default)]
pub(crate) struct Surface {
    /// Metres.
    pub(crate) positions: Vec<[f32; 3]>,
    /// One per position.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Indices into both.
    pub(crate) triangles: Vec<[u16; 3]>,
}

impl Surface {
    /// Adds a vertex and returns its index.
    ///
    /// # Panics
    /// At the 65,536th vertex: split the surface.
    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3) -> u16 {
        let index = u16::try_from(self.positions.len()).expect("a surface has at most 65,535 vertices");
        self.positions.push(position.map(|x| x as f32));
        self.normals.push(normal.map(|x| x as f32));
        index
    }

    /// Adds the quadrilateral `a b c d`, given as vertices.
    pub(crate) fn quad(&mut self, a: u16, b: u16, c: u16, d: u16) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Adds a flat convex polygon as a fan from its first corner; that corner may lie on a line with no two others.
    pub(crate) fn polygon(&mut self, corners: &[Vec3]) {
        let last = corners.len() - 1;
        let normal = normalize(cross(sub(corners[1], corners[0]), sub(corners[last], corners[0])));
        let indices: Vec<u16> = corners.iter().map(|&p| self.vertex(p, normal)).collect();
        self.triangles.extend(indices[1..].windows(2).map(|pair| [indices[0], pair[0], pair[1]]));
    }

    /// Adds another surface's triangles.
    pub(crate) fn append(&mut self, other: &Self) {
        let base = u16::try_from(self.positions.len() + other.positions.len())
            .map(|_| self.positions.len() as u16)
            .expect("a surface has at most 65,535 vertices");
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }
}
