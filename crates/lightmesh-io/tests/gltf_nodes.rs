//! Nodes, scenes, instances, lights and cameras of glTF files built in memory.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

use crate::common::{Gltf, assert_says, assert_warns};
use glam::{DVec3, Vec3};
use lightmesh::{Light, Projection};
use lightmesh_io::{LoadOptions, Units};
use serde_json::json;

/// Where the instance puts the triangle's second corner, (1, 0, 0).
fn corner(gltf: &Gltf, instance: usize) -> Vec3 {
    gltf.load().unwrap().data.instances[instance].world_from_object.transform_point3(Vec3::X)
}

fn light(gltf: &Gltf) -> Light {
    gltf.load().unwrap().data.lights[0]
}

#[test]
fn translation_rotation_scale_and_their_matrix_are_the_same() {
    let mut gltf = Gltf::triangle();
    // Scale by 2, a quarter turn about +Y (x to −z), then move.
    gltf.json["nodes"][0] = json!({
        "mesh": 0, "scale": [2, 1, 1], "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2], "translation": [10, 20, 30],
    });
    assert!((corner(&gltf, 0) - Vec3::new(10.0, 20.0, 28.0)).length() < 1e-5);
    gltf.json["nodes"][0] = json!({"mesh": 0, "matrix": [0, 0, -2, 0, 0, 1, 0, 0, 1, 0, 0, 0, 10, 20, 30, 1]});
    assert_eq!(corner(&gltf, 0), Vec3::new(10.0, 20.0, 28.0));
    // A quaternion is a direction in four dimensions: its length does not count.
    gltf.json["nodes"][0] = json!({"mesh": 0, "rotation": [0, 5, 0, 5]});
    assert!((corner(&gltf, 0) - Vec3::NEG_Z).length() < 1e-6);
}

#[test]
fn parents_move_their_children_and_a_shared_mesh_is_stored_once() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0] = json!({"translation": [1, 0, 0], "children": [1, 2]});
    gltf.push("nodes", json!({"mesh": 0, "scale": [3, 3, 3]}));
    gltf.push("nodes", json!({"mesh": 0, "translation": [0, 5, 0], "children": [3]}));
    gltf.push("nodes", json!({"mesh": 0, "scale": [-1, 1, 1]}));
    let data = gltf.load().unwrap().data;
    assert_eq!((data.meshes.len(), data.instances.len()), (1, 3));
    assert_eq!(corner(&gltf, 0), Vec3::new(4.0, 0.0, 0.0));
    assert_eq!(corner(&gltf, 1), Vec3::new(2.0, 5.0, 0.0));
    assert_eq!(corner(&gltf, 2), Vec3::new(0.0, 5.0, 0.0));
    assert!(data.instances[2].world_from_object.matrix3.determinant() < 0.0, "a mirror stays one");
}

#[test]
fn a_mesh_of_two_primitives_makes_two_meshes_per_node() {
    let mut gltf = Gltf::triangle();
    let primitive = gltf.primitive().clone();
    gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    gltf.node(json!({"mesh": 0}));
    let data = gltf.load().unwrap().data;
    assert_eq!(data.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(), [0, 1, 0, 1]);
}

#[test]
fn a_hundred_thousand_levels_do_not_overflow_the_stack() {
    let mut gltf = Gltf::triangle();
    let depth = 100_000;
    gltf.json["nodes"] = (0..depth).map(|i| json!({"translation": [0.5, 0, 0], "children": [i + 1]})).collect();
    gltf.push("nodes", json!({"mesh": 0}));
    let origin = gltf.load().unwrap().data.origin;
    assert_eq!(corner(&gltf, 0).as_dvec3() + origin, DVec3::new(50_001.0, 0.0, 0.0));
}

/// Survey coordinates of a parent node: what hangs on it comes out as next to the origin, lights too, and cameras keep
/// the file's coordinates in double precision.
#[test]
fn scenes_far_away_are_recentred_in_double_precision() {
    let mut gltf = Gltf::triangle();
    let far = [4_500_000.1, 0.3, -5_999_999.7];
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    gltf.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}));
    gltf.json["nodes"] = json!([
        {"translation": far, "children": [1, 2, 3]},
        {"mesh": 0, "translation": [0.001, 0, 0]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.002, 0, 0]},
        {"camera": 0, "translation": [0.003, 0, 0]},
    ]);
    gltf.json["scenes"] = json!([{"nodes": [0]}]);
    let data = gltf.load().unwrap().data;
    assert_eq!(data.origin, (DVec3::from_array(far) / 1024.0).round() * 1024.0);
    let off = |place: DVec3, x: f64| (place - DVec3::from_array(far) - DVec3::X * x).length();
    let mesh = Vec3::from(data.instances[0].world_from_object.translation).as_dvec3() + data.origin;
    let Light::Point { position, .. } = data.lights[0] else { panic!("{:?}", data.lights) };
    assert!(off(mesh, 0.001) < 1e-4 && off(position.as_dvec3() + data.origin, 0.002) < 1e-4);
    assert!(off(data.cameras[0].world_from_camera.translation, 0.003) < 1e-9);
}

#[test]
fn cycles_and_second_parents_are_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"name": "loop", "children": [0]}]);
    assert_says(&gltf.refusal(), &["node 0", "cycle"]);
    gltf.json["nodes"] =
        json!([{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0, "name": "twice"}]);
    assert_says(&gltf.refusal(), &["node 3 \"twice\"", "two parents"]);
    gltf.json["nodes"] = json!([{"mesh": 0, "name": "self", "children": [0]}]);
    assert_says(&gltf.refusal(), &["node 0 \"self\""]);
    gltf.json["nodes"] = json!([{"mesh": 0, "name": "odd", "children": [7]}]);
    assert_says(&gltf.refusal(), &["node 0 \"odd\"", "node 7"]);
}

#[test]
fn nodes_that_are_scaled_to_nothing_are_left_out() {
    let mut gltf = Gltf::triangle();
    gltf.node(json!({"mesh": 0, "name": "flat", "scale": [1, 0, 1]}));
    let loaded = gltf.load().unwrap();
    assert_eq!(loaded.data.instances.len(), 1);
    assert_warns(&loaded, &["node 1 \"flat\"", "scale"]);
    gltf.json["nodes"][0]["scale"] = json!([0, 0, 0]);
    assert_says(&gltf.refusal(), &["nothing to render"]);
}

#[test]
fn transforms_that_f32_cannot_hold_are_refused() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0] = json!({"mesh": 0, "scale": [1e30, 1, 1], "translation": [1e39, 0, 0]});
    assert_says(&gltf.refusal(), &["node 0", "transform"]);
    gltf.json["nodes"] = json!([{"scale": [1e30, 1, 1], "children": [1]}, {"mesh": 0, "scale": [1e30, 1, 1]}]);
    assert_says(&gltf.refusal(), &["node 1", "transform"]);
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    assert_says(&gltf.refusal(), &["node 0", "matrix"]);
}

#[test]
fn scenes_are_chosen_by_name_index_or_default() {
    let mut gltf = Gltf::triangle();
    gltf.push("nodes", json!({"mesh": 0, "translation": [5, 0, 0]}));
    gltf.json["scenes"] = json!([{"name": "day", "nodes": [0]}, {"name": "night", "nodes": [1]}]);
    let x = |scene: Option<&str>| {
        let options = LoadOptions { scene: scene.map(str::to_owned), ..LoadOptions::default() };
        gltf.load_with(&options).map(|loaded| loaded.data.instances[0].world_from_object.translation.x)
    };
    assert_eq!(x(None).unwrap(), 0.0);
    assert_eq!(x(Some("night")).unwrap(), 5.0);
    assert_eq!(x(Some("1")).unwrap(), 5.0);
    assert_says(&x(Some("dusk")).unwrap_err().to_string(), &["dusk", "\"day\"", "\"night\""]);
    gltf.json["scene"] = json!(1);
    assert_eq!(corner(&gltf, 0).x, 6.0);
    gltf.json["scene"] = json!(2);
    assert_says(&gltf.refusal(), &["scene 2"]);
}

#[test]
fn what_the_scene_does_not_use_is_not_read() {
    let mut gltf = Gltf::triangle();
    gltf.mesh(json!({"attributes": {"POSITION": 99}}));
    gltf.push("materials", json!({"emissiveTexture": {"index": 99}}));
    gltf.push("images", json!({"uri": "nowhere.png"}));
    let data = gltf.load().unwrap().data;
    assert_eq!((data.meshes.len(), data.materials.len(), data.images.len()), (1, 1, 0));
}

#[test]
fn a_file_without_scenes_shows_its_root_nodes() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"] = json!([{"mesh": 0}, {"translation": [2, 0, 0], "children": [0]}]);
    gltf.json.as_object_mut().unwrap().remove("scenes");
    gltf.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(corner(&gltf, 0), Vec3::new(3.0, 0.0, 0.0));
    assert_warns(&gltf.load().unwrap(), &["no scene"]);
}

#[test]
fn point_lights_have_colour_times_intensity() {
    let mut gltf = Gltf::triangle();
    let lamp = json!({"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 8.0, "range": 4.0});
    gltf.light(lamp, json!({"translation": [1, 2, 3], "scale": [7, 7, 7]}));
    let expected =
        Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity_cd: Vec3::new(8.0, 4.0, 2.0), range: Some(4.0) };
    assert_eq!(light(&gltf), expected);
    // The defaults: white, one candela, no range.
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({"type": "point"});
    let expected = Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity_cd: Vec3::ONE, range: None };
    assert_eq!(light(&gltf), expected);
}

#[test]
fn blender_units_divide_by_683_but_leave_emission() {
    let mut gltf = Gltf::triangle();
    gltf.material(json!({"emissiveFactor": [1, 1, 1]}));
    gltf.light(json!({"type": "directional", "intensity": 2049.0}), json!({}));
    let data = gltf.load_with(&LoadOptions { units: Units::Blender, ..LoadOptions::default() }).unwrap().data;
    assert_eq!(data.lights[0], Light::Directional { direction: Vec3::NEG_Z, illuminance_lux: Vec3::splat(3.0) });
    assert_eq!(data.materials[0].emission, Vec3::ONE);
}

/// A light shines along −Z of its node: turned a quarter about +X, that is +Y.
#[test]
fn spots_and_suns_shine_along_minus_z() {
    let turned = json!({"rotation": [FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "scale": [2, 3, 4]});
    let mut gltf = Gltf::triangle();
    gltf.light(json!({"type": "directional", "intensity": 2}), turned.clone());
    let Light::Directional { direction, illuminance_lux } = light(&gltf) else { panic!("a sun") };
    assert!((direction - Vec3::Y).length() < 1e-6 && illuminance_lux == Vec3::splat(2.0));

    let mut gltf = Gltf::triangle();
    gltf.light(json!({"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}), turned.clone());
    let Light::Spot { direction, inner_cone_angle, outer_cone_angle, .. } = light(&gltf) else { panic!("a spot") };
    assert!((direction - Vec3::Y).length() < 1e-6);
    assert_eq!((inner_cone_angle, outer_cone_angle), (0.25, 0.5));

    gltf.json["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({"type": "spot", "spot": {}});
    let Light::Spot { inner_cone_angle, outer_cone_angle, .. } = light(&gltf) else { panic!("a spot") };
    assert_eq!((inner_cone_angle, outer_cone_angle), (0.0, FRAC_PI_4));

    // Mended: too wide, and inner beyond outer.
    let wide = json!({"type": "spot", "spot": {"innerConeAngle": 3.0, "outerConeAngle": 2.0}});
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"][0] = wide;
    let Light::Spot { inner_cone_angle, outer_cone_angle, .. } = light(&gltf) else { panic!("a spot") };
    assert!(inner_cone_angle < outer_cone_angle && outer_cone_angle == FRAC_PI_2);
    assert_warns(&gltf.load().unwrap(), &["light 0", "cone"]);
}

#[test]
fn lights_that_cannot_be_are_refused() {
    for (lamp, word) in [
        (json!({"type": "point", "name": "sad", "intensity": -5}), "intensity -5"),
        (json!({"type": "point", "name": "sad", "intensity": 1e39}), "intensity"),
        (json!({"type": "point", "name": "sad", "color": [1, -1, 1]}), "color"),
    ] {
        let mut gltf = Gltf::triangle();
        gltf.light(lamp, json!({}));
        assert_says(&gltf.refusal(), &["light 0 \"sad\"", word]);
    }
    let mut gltf = Gltf::triangle();
    gltf.node(json!({"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 3}}}));
    assert_says(&gltf.refusal(), &["node 1 \"lamp\"", "light 3"]);
    let mut gltf = Gltf::triangle();
    gltf.light(json!({"type": "neon"}), json!({}));
    assert_says(&gltf.refusal(), &["lights", "neon"]);
}

#[test]
fn cameras_have_their_nodes_names_and_the_files_order() {
    let mut gltf = Gltf::triangle();
    let lens = json!({"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1}});
    gltf.push("cameras", lens);
    let flat =
        json!({"type": "orthographic", "name": "plan", "orthographic": {"xmag": 4, "ymag": -3, "znear": 0, "zfar": 9}});
    gltf.push("cameras", flat);
    gltf.node(json!({"camera": 1}));
    gltf.node(json!({"camera": 0, "name": "front", "translation": [0, 1, 2]}));
    let cameras = gltf.load().unwrap().data.cameras;
    assert_eq!(cameras.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["front", "plan"]);
    assert_eq!(cameras[0].projection, Projection::Perspective { yfov: 0.5, aspect: Some(1.5) });
    assert_eq!(cameras[0].world_from_camera.translation.as_vec3(), Vec3::new(0.0, 1.0, 2.0));
    assert_eq!(cameras[1].projection, Projection::Orthographic { xmag: 4.0, ymag: 3.0 });

    for broken in [
        json!({"perspective": {"yfov": 0}}),
        json!({"perspective": {"yfov": 3.2}}),
        json!({"orthographic": {"xmag": 0, "ymag": 1}}),
        json!({}),
    ] {
        gltf.json["cameras"][0] = broken;
        assert_says(&gltf.refusal(), &["camera 0"]);
    }
}
