//! Validation of scene descriptions. A checked one has every index in range, and every number so far inside the range of
//! 32-bit floats that what is made of it stays there: squares and volumes of distances, light times area.

mod cameras;
mod duplicates;
mod images;
mod lights;
mod surfaces;

pub(crate) use cameras::check_camera;

use super::data::SceneData;
use crate::Error;

/// Checks all of `data`, and repairs what can be repaired. Returns one sentence for each repair.
pub(crate) fn check(data: &mut SceneData) -> Result<Vec<String>, Error> {
    let mut warnings = Vec::new();
    images::check_images(data)?;
    for (index, material) in data.materials.iter().enumerate() {
        images::check_material(index, material, data.textures.len())?;
    }
    surfaces::check_meshes(data)?;
    surfaces::check_placements(data, &mut warnings)?;
    for (index, light) in data.lights.iter().enumerate() {
        lights::check_light(index, light)?;
    }
    data.environment.as_ref().map_or(Ok(()), lights::check_environment)?;
    for (index, camera) in data.cameras.iter().enumerate() {
        check_camera(camera, data.origin, || format!("camera {index} \"{}\"", camera.name))?;
    }
    repair_normals(data, &mut warnings);
    duplicates::remove(data, &mut warnings);
    Ok(warnings)
}

fn invalid<T>(place: String, what: impl Into<String>) -> Result<T, Error> {
    Err(Error::InvalidScene { place, what: what.into() })
}

/// Replaces the normals of a mesh by geometric ones if any of them is zero or not finite.
fn repair_normals(data: &mut SceneData, warnings: &mut Vec<String>) {
    for (index, mesh) in data.meshes.iter_mut().enumerate() {
        if mesh.normals.iter().any(|n| n.try_normalize().is_none()) {
            mesh.normals = Vec::new();
            warnings
                .push(format!("mesh {index} \"{}\": a normal has no direction; geometric normals are used", mesh.name));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, DVec3, Mat3, Vec3};

    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::{Camera, Environment, ImageData, Instance, Light, Material, Projection, Texels, Texture};

    fn triangle() -> SceneData {
        SceneData {
            meshes: vec![TriangleMesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                triangles: vec![[0, 1, 2]],
                ..TriangleMesh::default()
            }],
            instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
            materials: vec![Material::default()],
            ..SceneData::default()
        }
    }

    fn message(mut data: SceneData) -> String {
        check(&mut data).expect_err("must be refused").to_string()
    }

    #[test]
    fn a_plain_triangle_passes() {
        assert_eq!(check(&mut triangle()).expect("valid"), Vec::<String>::new());
    }

    #[test]
    fn errors_name_the_value() {
        let mut data = triangle();
        data.meshes[0].triangles[0][1] = 77;
        assert!(message(data).contains("index 77"));

        let mut data = triangle();
        data.meshes[0].positions[2].z = f32::NAN;
        assert!(message(data).contains("position 2"));

        let mut data = triangle();
        data.lights.push(Light::Point { position: Vec3::ZERO, intensity_cd: Vec3::NEG_ONE, range: None });
        assert!(message(data).contains("intensity"));

        let mut data = triangle();
        data.textures.push(Texture {
            image: 3,
            wrap_s: Default::default(),
            wrap_t: Default::default(),
            filter: Default::default(),
        });
        assert!(message(data).contains("image 3"));

        let mut data = triangle();
        data.materials[0].ior = 0.5;
        assert!(message(data).contains("refraction"));
    }

    /// A map that would be read past its end, and light that would turn sums into infinities and NaN.
    #[test]
    fn environments_are_checked() {
        let with = |map_texels: &[[f32; 4]], radiance: f32, world_from_map: glam::Quat| {
            let texels = Texels::Rgba32F(map_texels.into());
            let map = ImageData { name: String::new(), width: 2, height: 1, texels };
            let environment = Environment { map: Some(map), radiance: Vec3::splat(radiance), world_from_map };
            SceneData { environment: Some(environment), ..triangle() }
        };
        let (grey, none) = ([1.0; 4], glam::Quat::IDENTITY);
        assert!(check(&mut with(&[grey, grey], 1.0, none)).is_ok());
        assert!(message(with(&[grey], 1.0, none)).contains("environment: 2 × 1 texels announced, 1 given"));
        for bad in [-1.0, f32::NAN, f32::INFINITY, 1e19] {
            assert!(message(with(&[grey, grey], bad, none)).contains("its radiance"), "{bad}");
            assert!(message(with(&[grey, [0.0, bad, 0.0, 1.0]], 1.0, none)).contains("texel (1, 0)"), "{bad}");
        }
        assert!(message(with(&[grey, [1e10; 4]], 1e10, none)).contains("texel (1, 0)"));
        for bad in [glam::Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), glam::Quat::NAN] {
            assert!(message(with(&[grey, grey], 1.0, bad)).contains("its rotation"));
        }
    }

    /// What would leave the range of 32-bit floats once it is squared or summed.
    #[test]
    fn sizes_and_lights_have_bounds() {
        let with = |change: &dyn Fn(&mut SceneData)| {
            let mut data = triangle();
            change(&mut data);
            message(data)
        };
        assert!(with(&|d| d.meshes[0].positions[1].x = 1e19).contains("position 1 reaches 1e19; 1e18 is the most"));
        let far = with(&|d| d.instances[0].world_from_object = Affine3A::from_scale(Vec3::splat(1e10)));
        assert!(far.contains("instance 0 of mesh 0") && far.contains("1e10 m; 1e9 m is the most"), "{far}");
        let point = |x: f32, cd: f32| Light::Point {
            position: Vec3::new(x, 0.0, 0.0),
            intensity_cd: Vec3::splat(cd),
            range: None,
        };
        assert!(with(&|d| d.lights.push(point(1e10, 1.0))).contains("light 0: its position"));
        assert!(with(&|d| d.lights.push(point(0.0, 1e31))).contains("light 0: intensity"));
        assert!(with(&|d| d.materials[0].emission = Vec3::splat(2e38)).contains("emission"));
        assert!(with(&|d| d.materials[0].normal_scale = -1e7).contains("normal map"));
        let sphere = crate::geometry::Sphere { center: Vec3::ZERO, radius: 1e10, material: 0 };
        assert!(with(&|d| d.spheres.push(sphere)).contains("sphere 0: it reaches beyond"));
        let camera = |ymag: f32, x: f64| Camera {
            name: "wide".to_owned(),
            world_from_camera: glam::DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
            projection: Projection::Orthographic { xmag: 1.0, ymag },
        };
        assert!(with(&|d| d.cameras.push(camera(3e38, 0.0))).contains("half its view, 1e0 × 3e38 m"));
        assert!(with(&|d| d.cameras.push(camera(1.0, 1e13))).contains("its place"));
        assert!(with(&|d| d.cameras.push(camera(1.0, f64::NAN))).contains("its place"));
    }

    #[test]
    fn repairs_come_with_a_warning() {
        let mut data = triangle();
        data.meshes[0].normals = vec![Vec3::Z, Vec3::ZERO, Vec3::Z];
        data.instances.push(Instance { mesh: 0, world_from_object: Affine3A::from_mat3(Mat3::ZERO) });
        let warnings = check(&mut data).expect("mended");
        assert_eq!((warnings.len(), data.instances.len(), data.meshes[0].normals.len()), (2, 1, 0));
    }
}
