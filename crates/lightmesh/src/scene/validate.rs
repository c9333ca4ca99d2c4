//! Validation of scene descriptions. A checked one has every index in range and every number finite.

use glam::{Vec2, Vec3, Vec4};

use super::camera::Projection;
use super::data::SceneData;
use super::environment::Environment;
use super::light::Light;
use super::material::Material;
use super::texture::{ImageData, Texels};
use crate::Error;

/// Checks all of `data`, and repairs what can be repaired. Returns one sentence for each repair.
pub(crate) fn check(data: &mut SceneData) -> Result<Vec<String>, Error> {
    let mut warnings = Vec::new();
    check_images(data)?;
    for (index, material) in data.materials.iter().enumerate() {
        check_material(index, material, data.textures.len())?;
    }
    check_meshes(data)?;
    check_placements(data, &mut warnings)?;
    for (index, light) in data.lights.iter().enumerate() {
        check_light(index, light)?;
    }
    data.environment.as_ref().map_or(Ok(()), check_environment)?;
    check_cameras(data)?;
    repair_normals(data, &mut warnings);
    Ok(warnings)
}

fn invalid<T>(place: String, what: impl Into<String>) -> Result<T, Error> {
    Err(Error::InvalidScene { place, what: what.into() })
}

fn check_images(data: &SceneData) -> Result<(), Error> {
    for (index, image) in data.images.iter().enumerate() {
        check_texel_count(image, || format!("image {index} \"{}\"", image.name))?;
    }
    for (index, texture) in data.textures.iter().enumerate() {
        if texture.image >= data.images.len() {
            return invalid(format!("texture {index}"), format!("image {} does not exist", texture.image));
        }
    }
    Ok(())
}

fn check_texel_count(image: &ImageData, object: impl Fn() -> String) -> Result<(), Error> {
    let texels = match &image.texels {
        Texels::Rgba8(t) => t.len(),
        Texels::Rgba32F(t) => t.len(),
    };
    if texels == 0 || texels as u64 != u64::from(image.width) * u64::from(image.height) {
        let what = format!("{} × {} texels announced, {texels} given", image.width, image.height);
        return invalid(object(), what);
    }
    Ok(())
}

fn check_material(index: usize, m: &Material, textures: usize) -> Result<(), Error> {
    let object = || format!("material {index} \"{}\"", m.name);
    for texture in m.textures().into_iter().flatten() {
        if texture.texture >= textures || texture.uv_set > 1 {
            let what = format!("texture {} or its uv set {} does not exist", texture.texture, texture.uv_set);
            return invalid(object(), what);
        }
    }
    // Check the factors' ranges.
    let factors = [m.alpha, m.metallic, m.roughness, m.specular, m.transmission];
    if !factors.iter().chain(&m.base_color.to_array()).all(|x| (0.0..=1.0).contains(x)) {
        return invalid(object(), "a factor is outside [0, 1]");
    }
    let positive = |v: Vec3| v.is_finite() && v.min_element() >= 0.0;
    if !positive(m.emission) || !positive(m.specular_color) || !m.normal_scale.is_finite() {
        return invalid(object(), "emission, specular colour or normal scale is negative or not finite");
    }
    if !(m.ior >= 1.0 && m.ior.is_finite()) {
        return invalid(object(), format!("index of refraction {} is below 1", m.ior));
    }
    Ok(())
}

fn check_meshes(data: &SceneData) -> Result<(), Error> {
    for (index, mesh) in data.meshes.iter().enumerate() {
        let object = || format!("mesh {index} \"{}\"", mesh.name);
        // Indices into the mesh and the scene.
        let n = mesh.positions.len();
        if mesh.material >= data.materials.len() {
            return invalid(object(), format!("material {} does not exist", mesh.material));
        }
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            return invalid(object(), format!("position {i} is not finite"));
        }
        if let Some(&i) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= n) {
            return invalid(object(), format!("index {i} is out of range: the mesh has {n} positions"));
        }
        // Attributes: as many as positions, and finite.
        let lengths =
            [mesh.normals.len(), mesh.tangents.len(), mesh.uvs[0].len(), mesh.uvs[1].len(), mesh.colors.len()];
        if lengths.iter().any(|&len| len != 0 && len != n) {
            return invalid(object(), format!("an attribute's length is neither 0 nor the {n} of the positions"));
        }
        let finite = mesh.uvs.iter().flatten().all(|v: &Vec2| v.is_finite())
            && mesh.colors.iter().chain(&mesh.tangents).all(|v: &Vec4| v.is_finite());
        if !finite {
            return invalid(object(), "a texture coordinate, colour or tangent is not finite");
        }
    }
    Ok(())
}

/// Checks everything that is placed in the world: instances, spheres and shapes.
fn check_placements(data: &mut SceneData, warnings: &mut Vec<String>) -> Result<(), Error> {
    // Check the instances' transforms.
    for (index, instance) in data.instances.iter().enumerate() {
        if instance.mesh >= data.meshes.len() {
            return invalid(format!("instance {index}"), format!("mesh {} does not exist", instance.mesh));
        }
        let world = &instance.world_from_object;
        let bounds = data.meshes[instance.mesh].bounds();
        if !world.is_finite() || !(bounds.is_empty() || bounds.transformed(world).size().is_finite()) {
            return invalid(format!("instance {index}"), "its transform is not finite, or sends the mesh beyond f32");
        }
    }
    // Leave out instances that are scaled to nothing: they have no surface.
    let before = data.instances.len();
    let flat = |i: &super::data::Instance| i.world_from_object.matrix3.determinant() == 0.0;
    data.instances.retain(|i| !flat(i));
    if data.instances.len() < before {
        warnings.push(format!("{} instance(s) are scaled to nothing and left out", before - data.instances.len()));
    }
    // Check spheres and user-defined shapes.
    let materials = data.materials.len();
    for (index, sphere) in data.spheres.iter().enumerate() {
        if !(sphere.radius > 0.0 && sphere.radius.is_finite() && sphere.center.is_finite()) {
            return invalid(format!("sphere {index}"), format!("its radius {} must be above 0", sphere.radius));
        }
        if sphere.material >= materials {
            return invalid(format!("sphere {index}"), format!("material {} does not exist", sphere.material));
        }
    }
    for (index, entry) in data.shapes.iter().enumerate() {
        let bounds = entry.shape.bounds();
        if bounds.is_empty() || !bounds.size().is_finite() {
            return invalid(format!("shape {index}"), "its bounds are empty or not finite");
        }
        if entry.material >= materials {
            return invalid(format!("shape {index}"), format!("material {} does not exist", entry.material));
        }
    }
    Ok(())
}

fn check_light(index: usize, light: &Light) -> Result<(), Error> {
    let object = || format!("light {index}");
    let color = light.color();
    if !(color.is_finite() && color.min_element() >= 0.0) {
        return invalid(object(), format!("intensity {color} is negative or not finite"));
    }
    // Check position, direction, range and cone.
    let (position, direction, range) = match *light {
        Light::Point { position, range, .. } => (position, Vec3::X, range),
        Light::Spot { position, direction, range, .. } => (position, direction, range),
        Light::Directional { direction, .. } => (Vec3::ZERO, direction, None),
    };
    let unit = (direction.length() - 1.0).abs() < 1e-3;
    if !position.is_finite() || !unit {
        return invalid(object(), "its position is not finite or its direction is not of unit length");
    }
    if range.is_some_and(|r| r.is_nan() || r <= 0.0) {
        return invalid(object(), "its range must be above 0");
    }
    if let Light::Spot { inner_cone_angle, outer_cone_angle, .. } = *light
        && !(inner_cone_angle >= 0.0
            && inner_cone_angle < outer_cone_angle
            && outer_cone_angle <= std::f32::consts::FRAC_PI_2 + 1e-4)
    {
        let what =
            format!("cone angles {inner_cone_angle} and {outer_cone_angle} must satisfy 0 ≤ inner < outer ≤ π/2");
        return invalid(object(), what);
    }
    Ok(())
}

fn check_environment(environment: &Environment) -> Result<(), Error> {
    // Sums over the largest map, 2²⁸ texels, and squares stay in the range of f32; the sun has 1.6·10⁹ cd/m².
    const BRIGHTEST: f32 = 1e18;
    let object = || "environment".to_owned();
    let Environment { map, radiance, world_from_map } = environment;
    if !(radiance.min_element() >= 0.0 && radiance.max_element() <= BRIGHTEST) {
        return invalid(
            object(),
            format!("its radiance {radiance} is negative, not finite or above {BRIGHTEST:e} cd/m²"),
        );
    }
    // Check the rotation, then the map's texels.
    let is_rotation = (world_from_map.length_squared() - 1.0).abs() < 1e-3;
    if !is_rotation {
        return invalid(object(), "its rotation is not a quaternion of unit length");
    }
    let Some(map) = map else { return Ok(()) };
    check_texel_count(map, object)?;
    if let Texels::Rgba32F(texels) = &map.texels {
        let fits = |&c: &f32| (0.0..=BRIGHTEST).contains(&c) && c * radiance.max_element() <= BRIGHTEST;
        if let Some(i) = texels.iter().position(|texel| !texel[..3].iter().all(fits)) {
            let (column, row, texel) = (i % map.width as usize, i / map.width as usize, texels[i]);
            let what = format!(
                "texel ({column}, {row}) of its map, {:?}, is negative, not finite or above {BRIGHTEST:e} cd/m²",
                &texel[..3]
            );
            return invalid(object(), what);
        }
    }
    Ok(())
}

fn check_cameras(data: &SceneData) -> Result<(), Error> {
    for (index, camera) in data.cameras.iter().enumerate() {
        let sane = match camera.projection {
            Projection::Perspective { yfov, aspect } => {
                yfov > 0.0 && yfov < std::f32::consts::PI && aspect.is_none_or(|a| a > 0.0 && a.is_finite())
            }
            Projection::Orthographic { xmag, ymag } => xmag.is_normal() && ymag.is_normal(),
        };
        if !sane || !camera.world_from_camera.is_finite() {
            return invalid(
                format!("camera {index} \"{}\"", camera.name),
                "its lens or its place is not finite or in range",
            );
        }
    }
    Ok(())
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
    use glam::{Affine3A, Mat3};

    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::{Instance, Texture};

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

    #[test]
    fn repairs_come_with_a_warning() {
        let mut data = triangle();
        data.meshes[0].normals = vec![Vec3::Z, Vec3::ZERO, Vec3::Z];
        data.instances.push(Instance { mesh: 0, world_from_object: Affine3A::from_mat3(Mat3::ZERO) });
        let warnings = check(&mut data).expect("mended");
        assert_eq!((warnings.len(), data.instances.len(), data.meshes[0].normals.len()), (2, 1, 0));
    }
}
