//! Closed solids with outward winding: boxes, bodies of revolution, spheres and knots.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::surface::{Surface, Vec3, add_scaled, cross, normalize, sub};

/// A box standing on height `bottom`, `size` = width, height, depth, turned about the vertical by `yaw` radians.
pub(crate) fn cuboid(center_xz: [f64; 2], bottom: f64, size: Vec3, yaw: f64) -> Surface {
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    let corner = |i: usize| -> Vec3 {
        let (x, z) = (size[0] * ((i & 1) as f64 - 0.5), size[2] * ((i >> 2) as f64 - 0.5));
        let y = bottom + size[1] * (i >> 1 & 1) as f64;
        [center_xz[0] + cos * x + sin * z, y, center_xz[1] - sin * x + cos * z]
    };
    // Corner i has bit 0 for +x, bit 1 for +y, bit 2 for +z.
    const FACES: [[usize; 4]; 6] = [[1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4], [4, 5, 7, 6], [0, 2, 3, 1]];
    let mut surface = Surface::default();
    for face in FACES {
        surface.polygon(&face.map(corner));
    }
    surface
}

/// A vertical prism on height `bottom` whose top is the convex polygon `outline` (x, z), counter-clockwise from above.
pub(crate) fn prism(outline: &[[f64; 2]], bottom: f64, top: f64) -> Surface {
    let at = |[x, z]: [f64; 2], y| [x, y, z];
    let mut surface = Surface::default();
    surface.polygon(&outline.iter().map(|&p| at(p, top)).collect::<Vec<_>>());
    surface.polygon(&outline.iter().rev().map(|&p| at(p, bottom)).collect::<Vec<_>>());
    for (i, &p) in outline.iter().enumerate() {
        let q = outline[(i + 1) % outline.len()];
        surface.polygon(&[at(p, bottom), at(q, bottom), at(q, top), at(p, top)]);
    }
    surface
}

/// A body of revolution about the vertical through the origin. `profile` holds (radius, height) from the lowest point
/// of the axis to its highest; both ends have radius 0. Edges of the profile sharper than 40° stay sharp.
pub(crate) fn lathe(profile: &[[f64; 2]], segments: usize) -> Surface {
    let ring: Vec<[f64; 2]> = (0..segments)
        .map(|j| {
            let angle = TAU * j as f64 / segments as f64;
            [libm::cos(angle), libm::sin(angle)]
        })
        .collect();
    // The outward normal of each profile segment, in the (radius, height) plane.
    let flat: Vec<[f64; 2]> = profile
        .windows(2)
        .map(|s| {
            let [dr, dy] = [s[1][0] - s[0][0], s[1][1] - s[0][1]];
            let length = (dr * dr + dy * dy).sqrt();
            [dy / length, -dr / length]
        })
        .collect();
    let joint = |own: usize, other: Option<usize>| -> [f64; 2] {
        const COS_40_DEGREES: f64 = 0.766;
        let a = flat[own];
        match other.and_then(|k| flat.get(k)) {
            Some(b) if a[0] * b[0] + a[1] * b[1] > COS_40_DEGREES => {
                let sum = [a[0] + b[0], a[1] + b[1]];
                let length = (sum[0] * sum[0] + sum[1] * sum[1]).sqrt();
                [sum[0] / length, sum[1] / length]
            }
            _ => a,
        }
    };

    let mut surface = Surface::default();
    for (i, ends) in profile.windows(2).enumerate() {
        let normals = [joint(i, i.checked_sub(1)), joint(i, Some(i + 1))];
        // Two rings of vertices; a point on the axis still has one vertex per segment, each with its own normal.
        let rows = [0, 1].map(|end: usize| -> Vec<u16> {
            let ([r, y], [nr, ny]) = (ends[end], normals[end]);
            ring.iter().map(|&[c, s]| surface.vertex([r * c, y, r * s], [nr * c, ny, nr * s])).collect()
        });
        for j in 0..segments {
            let k = (j + 1) % segments;
            let (a, b, c, d) = (rows[0][j], rows[0][k], rows[1][k], rows[1][j]);
            if ends[0][0] == 0.0 {
                surface.triangles.push([a, d, c]);
            } else if ends[1][0] == 0.0 {
                surface.triangles.push([a, d, b]);
            } else {
                surface.quad(a, d, c, b);
            }
        }
    }
    surface
}

/// A sphere of 20 `frequency`² nearly equal triangles: the icosahedron's faces, divided and blown up.
pub(crate) fn sphere(center: Vec3, radius: f64, frequency: u16) -> Surface {
    // Corners of the icosahedron: the even permutations of (0, ±1, ±golden ratio).
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let corner = |i: usize| -> Vec3 {
        let (axis, a, b) = (i / 4, if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
        let mut p = [0.0; 3];
        p[(axis + 1) % 3] = a;
        p[(axis + 2) % 3] = b;
        p
    };
    // Its faces are the triples of corners at the edge length, which is 2.
    let near = |a: Vec3, b: Vec3| {
        let d = sub(a, b);
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 4.0).abs() < 1e-9
    };
    let mut surface = Surface::default();
    let mut index_of: BTreeMap<[i64; 3], u16> = BTreeMap::new();
    for (i, j, k) in (0..12).flat_map(|i| (i + 1..12).flat_map(move |j| (j + 1..12).map(move |k| (i, j, k)))) {
        let (a, mut b, mut c) = (corner(i), corner(j), corner(k));
        if !(near(a, b) && near(b, c) && near(c, a)) {
            continue;
        }
        // Wind outward.
        let n = cross(sub(b, a), sub(c, a));
        if n[0] * a[0] + n[1] * a[1] + n[2] * a[2] < 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        // Neighbouring faces share the vertices of their edge, found by their direction rounded to 2⁻⁴⁰.
        let mut vertex = |u: u16, v: u16| {
            let (u, v) = (f64::from(u) / f64::from(frequency), f64::from(v) / f64::from(frequency));
            let p = add_scaled(add_scaled(a, sub(b, a), u), sub(c, a), v);
            let n = normalize(p);
            let key = n.map(|x| libm::round(x * (1u64 << 40) as f64) as i64);
            *index_of.entry(key).or_insert_with(|| surface.vertex(add_scaled(center, n, radius), n))
        };
        let mut triangles = Vec::new();
        for u in 0..frequency {
            for v in 0..frequency - u {
                triangles.push([vertex(u, v), vertex(u + 1, v), vertex(u, v + 1)]);
                if u + v + 1 < frequency {
                    triangles.push([vertex(u + 1, v), vertex(u + 1, v + 1), vertex(u, v + 1)]);
                }
            }
        }
        surface.triangles.extend(triangles);
    }
    surface
}

/// A tube along the (p, q) torus knot, p times about the vertical axis and q times through the hole.
pub(crate) struct TorusKnot {
    /// Of the torus, which lies flat; the knot is then set upright.
    pub(crate) center: Vec3,
    /// From the torus' centre to its core circle.
    pub(crate) major_radius: f64,
    /// From the core circle to the tube's middle.
    pub(crate) minor_radius: f64,
    /// Of the tube.
    pub(crate) tube_radius: f64,
    /// Turns about the axis and through the hole.
    pub(crate) turns: [f64; 2],
    /// Steps along the tube and around it.
    pub(crate) steps: [u16; 2],
}

impl TorusKnot {
    /// The tube's surface, the torus' axis along Z.
    pub(crate) fn surface(&self) -> Surface {
        let [along, around] = self.steps;
        let [p, q] = self.turns;
        let mut surface = Surface::default();
        for i in 0..along {
            let t = TAU * f64::from(i) / f64::from(along);
            let (sin_phi, cos_phi) = (libm::sin(p * t), libm::cos(p * t));
            let (sin_theta, cos_theta) = (libm::sin(q * t), libm::cos(q * t));
            let ring_radius = self.major_radius + self.minor_radius * cos_theta;
            // The middle of the tube, and the torus' own normal there: at a right angle to the curve, which lies on the
            // torus.
            let middle = [ring_radius * cos_phi, ring_radius * sin_phi, self.minor_radius * sin_theta];
            let outward = [cos_theta * cos_phi, cos_theta * sin_phi, sin_theta];
            // The derivative of `middle` by t.
            let shrink = -q * self.minor_radius * sin_theta;
            let tangent = normalize([
                shrink * cos_phi - p * ring_radius * sin_phi,
                shrink * sin_phi + p * ring_radius * cos_phi,
                q * self.minor_radius * cos_theta,
            ]);
            let side = cross(outward, tangent);
            for j in 0..around {
                let angle = TAU * f64::from(j) / f64::from(around);
                let n = add_scaled(outward.map(|x| x * libm::cos(angle)), side, libm::sin(angle));
                let point = add_scaled(middle, n, self.tube_radius);
                surface.vertex(add_scaled(point, self.center, 1.0), n);
            }
        }
        for i in 0..along {
            for j in 0..around {
                let at = |i: u16, j: u16| (i % along) * around + j % around;
                surface.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
        }
        surface
    }
}
