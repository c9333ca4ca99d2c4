//! The parts of a scene that its light depends on. Every field is named, so that a new field does not compile until it
//! is added here.

use std::fmt::Write;

use glam::{Affine3A, Vec2, Vec3, Vec4};

use super::Fingerprint;
use super::digest::Digest;
use crate::geometry::{Aabb, Sphere, TriangleMesh};
use crate::scene::{EmitterOptions, Filter, Texels, UvTransform, Wrap};
use crate::{
    AlphaMode, Environment, ImageData, Instance, Light, Material, Scene, SceneData, ShapeEntry, Texture, TextureRef,
};

pub(super) fn fingerprint(scene: &Scene) -> Fingerprint {
    let mut digest = Digest::new("lightmesh scene");
    let SceneData {
        meshes,
        instances,
        spheres,
        shapes,
        materials,
        textures,
        images,
        lights,
        environment,
        cameras: _,
        origin: _,
    } = scene.data();
    let d = &mut digest;
    add_all(d, meshes, add_mesh);
    add_all(d, instances, add_instance);
    add_all(d, spheres, add_sphere);
    add_all(d, shapes, add_shape);
    add_all(d, materials, add_material);
    add_all(d, textures, add_texture);
    add_all(d, images, add_image);
    add_all(d, lights, add_light);
    add_option(d, environment.as_ref(), self::add_environment);
    let EmitterOptions { light_samples, light_radius } = *scene.emitter_options();
    d.number(u64::from(light_samples));
    d.floats([light_radius]);
    digest.finish()
}

fn add_all<T>(d: &mut Digest, things: &[T], add: impl Fn(&mut Digest, &T)) {
    d.number(things.len() as u64);
    things.iter().for_each(|thing| add(d, thing));
}

fn add_option<T>(d: &mut Digest, thing: Option<T>, add: impl Fn(&mut Digest, T)) {
    d.number(u64::from(thing.is_some()));
    if let Some(thing) = thing {
        add(d, thing);
    }
}

fn add_mesh(d: &mut Digest, mesh: &TriangleMesh) {
    let TriangleMesh { name: _, positions, triangles, normals, tangents, uvs, colors, material } = mesh;
    d.list(positions.iter().map(Vec3::to_array));
    d.number(triangles.len() as u64);
    d.halves(triangles.iter().flatten().copied());
    d.list(normals.iter().map(Vec3::to_array));
    d.list(tangents.iter().map(Vec4::to_array));
    uvs.iter().for_each(|uvs| d.list(uvs.iter().map(Vec2::to_array)));
    d.list(colors.iter().map(Vec4::to_array));
    d.number(*material as u64);
}

fn add_instance(d: &mut Digest, &Instance { mesh, world_from_object }: &Instance) {
    d.number(mesh as u64);
    d.floats(Affine3A::to_cols_array(&world_from_object));
}

fn add_sphere(d: &mut Digest, &Sphere { center, radius, material }: &Sphere) {
    d.floats(center.extend(radius).to_array());
    d.number(material as u64);
}

pub(crate) fn add_shape(d: &mut Digest, ShapeEntry { shape, material }: &ShapeEntry) {
    let Aabb { min, max } = shape.bounds();
    d.floats(min.to_array());
    d.floats(max.to_array());
    // Writing into a digest cannot fail; a `Debug` that does is cut short there.
    let _ = write!(d, "{shape:?}");
    d.number(*material as u64);
}

fn add_material(d: &mut Digest, material: &Material) {
    let Material {
        name: _,
        base_color,
        alpha,
        base_color_texture,
        alpha_mode,
        metallic,
        roughness,
        metallic_roughness_texture,
        emission,
        emission_texture,
        normal_texture,
        normal_scale,
        specular,
        specular_texture,
        specular_color,
        specular_color_texture,
        ior,
        transmission,
        transmission_texture,
        double_sided,
        unlit,
    } = material;
    for color in [base_color, emission, specular_color] {
        d.floats(color.to_array());
    }
    d.floats([*alpha, *metallic, *roughness, *normal_scale, *specular, *ior, *transmission]);
    match *alpha_mode {
        AlphaMode::Opaque => d.number(0),
        AlphaMode::Mask { cutoff } => {
            d.number(1);
            d.floats([cutoff]);
        }
        AlphaMode::Blend => d.number(2),
    }
    for texture in [
        base_color_texture,
        metallic_roughness_texture,
        emission_texture,
        normal_texture,
        specular_texture,
        specular_color_texture,
        transmission_texture,
    ] {
        add_option(d, texture.as_ref(), add_texture_ref);
    }
    d.number(u64::from(*double_sided) | u64::from(*unlit) << 1);
}

fn add_texture_ref(d: &mut Digest, &TextureRef { texture, uv_set, transform }: &TextureRef) {
    let UvTransform { matrix, offset } = transform;
    d.number(texture as u64);
    d.number(uv_set as u64);
    d.floats(matrix.to_cols_array());
    d.floats(offset.to_array());
}

fn add_texture(d: &mut Digest, &Texture { image, wrap_s, wrap_t, filter }: &Texture) {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    };
    d.number(image as u64);
    d.number(wrap(wrap_s));
    d.number(wrap(wrap_t));
    d.number(match filter {
        Filter::Bilinear => 0,
        Filter::Nearest => 1,
    });
}

fn add_image(d: &mut Digest, ImageData { name: _, width, height, texels }: &ImageData) {
    d.halves([*width, *height]);
    match texels {
        Texels::Rgba8(texels) => {
            d.number(0);
            d.number(texels.len() as u64);
            d.halves(texels.iter().map(|&texel| u32::from_le_bytes(texel)));
        }
        Texels::Rgba32F(texels) => {
            d.number(1);
            d.list(texels.iter().copied());
        }
    }
}

pub(crate) fn add_light(d: &mut Digest, light: &Light) {
    let range = |d: &mut Digest, range: Option<f32>| add_option(d, range, |d, range| d.floats([range]));
    match *light {
        Light::Point { position, intensity_cd, range: reach } => {
            d.number(0);
            d.floats(position.to_array());
            d.floats(intensity_cd.to_array());
            range(d, reach);
        }
        Light::Spot { position, direction, intensity_cd, range: reach, inner_cone_angle, outer_cone_angle } => {
            d.number(1);
            d.floats(position.to_array());
            d.floats(direction.to_array());
            d.floats(intensity_cd.to_array());
            range(d, reach);
            d.floats([inner_cone_angle, outer_cone_angle]);
        }
        Light::Directional { direction, illuminance_lux } => {
            d.number(2);
            d.floats(direction.to_array());
            d.floats(illuminance_lux.to_array());
        }
    }
}

fn add_environment(d: &mut Digest, Environment { map, radiance, world_from_map }: &Environment) {
    add_option(d, map.as_ref(), add_image);
    d.floats(radiance.to_array());
    d.floats(world_from_map.to_array());
}
