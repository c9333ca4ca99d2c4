//! Cube maps resampled to latitude and longitude.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::image::RadianceImage;

/// Columns of the smallest and the largest map.
const WIDTHS: (u32, u32) = (64, 8192);

/// Directions that a texel of the map averages, in each of its two directions.
const SUBSAMPLES: u32 = 2;

/// Six square faces of equal size: +X, −X, +Y, −Y, +Z, −Z.
#[derive(Debug)]
pub(super) struct CubeMap {
    faces: [RadianceImage; 6],
    size: u32,
}

impl CubeMap {
    /// `None` unless all are square and of one size.
    pub(super) fn new(faces: [RadianceImage; 6]) -> Option<Self> {
        let size = faces[0].width;
        faces.iter().all(|face| (face.width, face.height) == (size, size)).then_some(Self { faces, size })
    }

    /// Columns of the map that keeps what it shows; it has half as many rows. A face is a quarter of the horizon.
    pub(super) fn width(&self) -> u32 {
        self.size.saturating_mul(4).clamp(WIDTHS.0, WIDTHS.1)
    }

    /// The latitude-longitude map, row by row, laid out as [`lightmesh::Environment::map`] says.
    pub(super) fn to_latitude_longitude(&self) -> Vec<[f32; 4]> {
        sample_map(self.width(), SUBSAMPLES, |direction| self.radiance(direction))
    }

    /// Returns the radiance along a direction: bilinear within a face, whose border texels are repeated.
    fn radiance(&self, direction: Vec3) -> Vec3 {
        let (face, uv) = place_of(direction);
        let face = &self.faces[face];
        let last = self.size - 1;
        // Texel centres lie at half numbers.
        let at = (uv * self.size as f32 - 0.5).clamp(Vec2::ZERO, Vec2::splat(last as f32));
        let (x, y) = (at.x as u32, at.y as u32);
        let f = at - at.floor();
        let texel = |x: u32, y: u32| face.texels[(y.min(last) * self.size + x.min(last)) as usize];
        let row = |y: u32| texel(x, y).lerp(texel(x + 1, y), f.x);
        row(y).lerp(row(y + 1), f.y)
    }
}

/// The face that a direction meets and where, (0, 0) in the face's upper left corner.
///
/// The extension takes OpenGL's cube map (OpenGL 4.6, table 8.19) and has "each saved image flipped about its vertical
/// axis": so each image is what a camera in the middle sees of that side, upright, in glTF's right-handed space: facing
/// +X, +Z is on the right.
fn place_of(d: Vec3) -> (usize, Vec2) {
    let a = d.abs();
    // OpenGL's s_c and t_c over the major axis.
    let (face, s, t, major) = if a.x >= a.y && a.x >= a.z {
        if d.x > 0.0 { (0, -d.z, -d.y, a.x) } else { (1, d.z, -d.y, a.x) }
    } else if a.y >= a.z {
        if d.y > 0.0 { (2, d.x, d.z, a.y) } else { (3, d.x, -d.z, a.y) }
    } else if d.z > 0.0 {
        (4, d.x, -d.y, a.z)
    } else {
        (5, -d.x, -d.y, a.z)
    };
    // Flipped: s runs to the left.
    (face, Vec2::new(0.5 - 0.5 * s / major, 0.5 + 0.5 * t / major))
}

/// A latitude-longitude map of a function of the direction, each texel the mean of `subsamples`² of its directions.
pub(super) fn sample_map(width: u32, subsamples: u32, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Vec<[f32; 4]> {
    let height = width / 2;
    let angle = |i: u32, k: u32, n: u32| (i as f32 + (k as f32 + 0.5) / subsamples as f32) / n as f32;
    let texel = |column: u32, row: u32| {
        let mut sum = Vec3::ZERO;
        for k in 0..subsamples * subsamples {
            let phi = TAU * angle(column, k % subsamples, width);
            let theta = PI * angle(row, k / subsamples, height);
            let sin = libm::sinf(theta);
            sum += radiance(Vec3::new(-libm::cosf(phi) * sin, libm::cosf(theta), -libm::sinf(phi) * sin));
        }
        (sum / (subsamples * subsamples) as f32).extend(1.0).to_array()
    };
    (0..width * height).map(|i| texel(i % width, i / width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a camera in the middle sees: on the right and above of each face.
    #[test]
    fn faces_are_upright_and_not_mirrored() {
        let faces = [
            (Vec3::X, Vec3::Z, Vec3::Y),
            (Vec3::NEG_X, Vec3::NEG_Z, Vec3::Y),
            (Vec3::Y, Vec3::NEG_X, Vec3::NEG_Z),
            (Vec3::NEG_Y, Vec3::NEG_X, Vec3::Z),
            (Vec3::Z, Vec3::NEG_X, Vec3::Y),
            (Vec3::NEG_Z, Vec3::X, Vec3::Y),
        ];
        for (face, (ahead, right, up)) in faces.into_iter().enumerate() {
            assert_eq!(ahead.cross(up), right, "right-handed");
            for (d, uv) in [
                (ahead, Vec2::new(0.5, 0.5)),
                (ahead + 0.5 * right, Vec2::new(0.75, 0.5)),
                (ahead + 0.8 * up, Vec2::new(0.5, 0.1)),
            ] {
                assert_eq!(place_of(d).0, face, "{d}");
                assert!((place_of(d).1 - uv).length() < 1e-6, "{d}: {:?}", place_of(d));
            }
        }
    }

    /// The mean over the sphere of a cube whose faces shine 1 to 6 is 3.5: each is a sixth of it.
    #[test]
    fn the_light_of_all_faces_is_kept() {
        let face = |i: usize| RadianceImage { width: 4, height: 4, texels: vec![Vec3::splat(1.0 + i as f32); 16] };
        let map = CubeMap::new(std::array::from_fn(face)).unwrap();
        let (texels, height) = (map.to_latitude_longitude(), map.width() as usize / 2);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, texel) in texels.iter().enumerate() {
            let sin = libm::sinf(PI * ((i / (2 * height)) as f32 + 0.5) / height as f32);
            sum += texel[0] * sin;
            weights += sin;
        }
        assert!((sum / weights - 3.5).abs() < 0.01, "{}", sum / weights);
    }
}
