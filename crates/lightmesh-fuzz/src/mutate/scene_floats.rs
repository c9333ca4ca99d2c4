//! All numbers of a scene.

use glam::{Affine3A, Mat2, Vec2, Vec3, Vec4};
use lightmesh::{AlphaMode, Light, Material, Projection, SceneData};

/// Those in single precision.
pub(super) fn floats(scene: &mut SceneData) -> Vec<&mut f32> {
    let mut all = Floats::default();
    for mesh in &mut scene.meshes {
        mesh.positions.iter_mut().chain(&mut mesh.normals).for_each(|v| all.vec3(v));
        mesh.tangents.iter_mut().chain(&mut mesh.colors).for_each(|v| all.vec4(v));
        mesh.uvs.iter_mut().flatten().for_each(|v| all.vec2(v));
    }
    for instance in &mut scene.instances {
        all.affine(&mut instance.world_from_object);
    }
    for sphere in &mut scene.spheres {
        all.vec3(&mut sphere.center);
        all.0.push(&mut sphere.radius);
    }
    for material in &mut scene.materials {
        all.material(material);
    }
    for light in &mut scene.lights {
        all.light(light);
    }
    if let Some(environment) = &mut scene.environment {
        all.vec3(&mut environment.radiance);
    }
    for camera in &mut scene.cameras {
        match &mut camera.projection {
            Projection::Perspective { yfov, aspect } => {
                all.0.push(yfov);
                all.0.extend(aspect);
            }
            Projection::Orthographic { xmag, ymag } => all.0.extend([xmag, ymag]),
        }
    }
    all.0
}

/// Those in double precision.
pub(super) fn doubles(scene: &mut SceneData) -> Vec<&mut f64> {
    let mut all: Vec<&mut f64> = Vec::new();
    all.extend(scene.origin.as_mut());
    for camera in &mut scene.cameras {
        let world = &mut camera.world_from_camera;
        all.extend(world.translation.as_mut());
        let m = &mut world.matrix3;
        all.extend(m.x_axis.as_mut());
        all.extend(m.y_axis.as_mut());
        all.extend(m.z_axis.as_mut());
    }
    all
}

#[derive(Default)]
struct Floats<'a>(Vec<&'a mut f32>);

impl<'a> Floats<'a> {
    fn vec2(&mut self, v: &'a mut Vec2) {
        self.0.extend(v.as_mut());
    }

    fn vec3(&mut self, v: &'a mut Vec3) {
        self.0.extend(v.as_mut());
    }

    fn vec4(&mut self, v: &'a mut Vec4) {
        self.0.extend(v.as_mut());
    }

    fn mat2(&mut self, m: &'a mut Mat2) {
        self.0.extend(m.as_mut());
    }

    fn affine(&mut self, a: &'a mut Affine3A) {
        self.0.extend(a.translation.as_mut());
        self.0.extend(a.matrix3.x_axis.as_mut());
        self.0.extend(a.matrix3.y_axis.as_mut());
        self.0.extend(a.matrix3.z_axis.as_mut());
    }

    fn material(&mut self, m: &'a mut Material) {
        [&mut m.base_color, &mut m.emission, &mut m.specular_color].into_iter().for_each(|v| self.vec3(v));
        let factors =
            [&mut m.alpha, &mut m.metallic, &mut m.roughness, &mut m.normal_scale, &mut m.specular, &mut m.ior];
        self.0.extend(factors);
        self.0.push(&mut m.transmission);
        if let AlphaMode::Mask { cutoff } = &mut m.alpha_mode {
            self.0.push(cutoff);
        }
        let textures = [&mut m.base_color_texture, &mut m.emission_texture, &mut m.normal_texture];
        for texture in textures.into_iter().flatten() {
            self.mat2(&mut texture.transform.matrix);
            self.vec2(&mut texture.transform.offset);
        }
    }

    fn light(&mut self, light: &'a mut Light) {
        match light {
            Light::Point { position, intensity_cd, range } => {
                [position, intensity_cd].into_iter().for_each(|v| self.vec3(v));
                self.0.extend(range);
            }
            Light::Spot { position, direction, intensity_cd, range, inner_cone_angle, outer_cone_angle } => {
                [position, direction, intensity_cd].into_iter().for_each(|v| self.vec3(v));
                self.0.extend(range);
                self.0.extend([inner_cone_angle, outer_cone_angle]);
            }
            Light::Directional { direction, illuminance_lux } => {
                [direction, illuminance_lux].into_iter().for_each(|v| self.vec3(v));
            }
        }
    }
}
