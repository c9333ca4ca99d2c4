//! The scenes and the broken files that lie beside the repository, where they do.

use std::path::{Path, PathBuf};
use std::time::Instant;

use lightmesh_io::{LoadOptions, Loaded, load};

/// `../shared` beside the repository, or `None` with a message.
fn shared() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    if folder.join("scenes").is_dir() {
        return Some(folder);
    }
    println!("skipped: {} is not there", folder.display());
    None
}

/// Triangles as they are rendered, instances counted.
fn triangles(loaded: &Loaded) -> usize {
    let data = &loaded.data;
    data.instances.iter().map(|instance| data.meshes[instance.mesh].triangles.len()).sum()
}

/// Triangles and lights that the scenes' README states.
#[test]
fn scenes_have_the_triangles_and_lights_of_their_readme() {
    let Some(shared) = shared() else { return };
    for (name, expected_triangles, expected_lights) in [
        ("cornell", 30, 1),
        ("cornell_area", 32, 0),
        ("triangle", 9, 1),
        ("paper5000_5", 4_996, 5),
        ("paper5000_10", 4_996, 10),
        ("paper5000_15", 4_996, 15),
        ("paper5000_100", 4_996, 100),
        ("paper5000_1000", 4_996, 1_000),
        ("paper5000_10000", 4_996, 10_000),
        ("paper5000_100000", 4_996, 100_000),
        ("livingroom", 131_997, 5),
        ("staircase_area", 249_943, 0),
        ("sponza_25", 66_445, 25),
    ] {
        let start = Instant::now();
        let loaded = load(&shared.join(format!("scenes/{name}.glb")), &LoadOptions::default()).unwrap();
        println!("{name}: {:.0} ms, {:?}", 1e3 * start.elapsed().as_secs_f64(), loaded.warnings);
        assert_eq!(triangles(&loaded), expected_triangles, "{name}");
        assert_eq!(loaded.data.lights.len(), expected_lights, "{name}");
        assert_eq!(loaded.data.cameras.len(), 1, "{name}");
        assert!(loaded.data.materials.iter().all(|m| m.specular == 0.0), "{name}: the scenes are Lambert");
        assert_eq!(loaded.data.materials.iter().any(|m| m.emission.x > 0.0), name.ends_with("_area"), "{name}");
    }
    let leak = load(&shared.join("scenes/leak.glb"), &LoadOptions::default()).unwrap();
    assert_eq!(leak.data.lights.len(), 2);
}

/// Loading the 100,000 lights must not be quadratic: a generous bound for an unoptimised build on a busy machine.
#[test]
fn a_hundred_thousand_light_nodes_load_in_linear_time() {
    let Some(shared) = shared() else { return };
    let start = Instant::now();
    let loaded = load(&shared.join("scenes/paper5000_100000.glb"), &LoadOptions::default()).unwrap();
    assert_eq!(loaded.data.lights.len(), 100_000);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn broken_files_are_refused_in_one_line_that_says_why() {
    let Some(shared) = shared() else { return };
    for (name, words) in [
        ("truncated.glb", &["truncated.glb"][..]),
        ("truncated_json.glb", &["truncated_json.glb"]),
        ("empty.glb", &["empty.glb"]),
        ("not_gltf.glb", &["not_gltf.glb"]),
        ("index_out_of_range.glb", &["index", "77"]),
        ("nan_position.glb", &["position"]),
        ("cyclic_nodes.glb", &["node"]),
        ("huge_accessor.glb", &["accessor"]),
        ("needs_draco.glb", &["KHR_draco_mesh_compression"]),
        ("missing_buffer.gltf", &["nowhere.bin"]),
        ("escaping_uri.gltf", &["uri"]),
        ("version1.glb", &["version"]),
        ("negative_light.glb", &["intensity"]),
        ("nothing_inside.glb", &["nothing_inside.glb"]),
        ("no_such_file.glb", &["no_such_file.glb"]),
    ] {
        let message = load(&shared.join("bad").join(name), &LoadOptions::default()).unwrap_err().to_string();
        println!("{message}");
        assert!(message.contains(name) && !message.contains('\n'), "{message}");
        // The path holds words too: look for them behind it.
        let (_, said) = message.split_once(name).unwrap();
        for word in words.iter().filter(|word| **word != name) {
            assert!(said.to_lowercase().contains(&word.to_lowercase()), "{name} must say {word}: {message}");
        }
    }
    let good = load(&shared.join("bad/good.glb"), &LoadOptions::default()).unwrap();
    assert_eq!((triangles(&good), good.data.lights.len()), (1, 1));
}
