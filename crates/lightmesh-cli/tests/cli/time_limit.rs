//! `--time-limit` from the outside.

use crate::place::Place;
use serde_json::Value;

fn stats(place: &Place) -> Value {
    serde_json::from_str(&std::fs::read_to_string(place.path("s.json")).unwrap()).unwrap()
}

#[test]
fn samples_are_those_that_there_was_time_for() {
    let place = Place::new();
    for method in ["mesh", "standard", "path"] {
        let line = format!("render scene.gltf -o a.png --stats s.json --size 40x24 --method {method}");
        let run = place.run(&format!("{line} --time-limit 0.3")).exits(0);
        let stats = stats(&place);
        assert_eq!(stats["time_limit_reached"], true, "{method}");
        let spp = stats["image"]["spp"].as_u64().unwrap();
        assert!((1..65536).contains(&spp), "{method}: {spp}");
        assert!(stats["seconds"]["render"].as_f64().unwrap() >= 0.3, "{method}");
        let said = format!("{spp} sample(s) per pixel in the limit of 0.3 s");
        assert!(run.stderr().contains(&said), "{}", run.stderr());
    }
}

#[test]
fn no_time_is_enough_for_one_sample() {
    let place = Place::new();
    place.run("render scene.gltf -o a.png --stats s.json --size 40x24 --time-limit 1e-9").exits(0);
    assert_eq!((&stats(&place)["image"]["spp"], &stats(&place)["time_limit_reached"]), (&1.into(), &true.into()));
}

#[test]
fn with_spp_the_limit_may_not_be_reached() {
    let place = Place::new();
    let run = place.run("render scene.gltf -o a.png --stats s.json --size 40x24 --spp 3 --time-limit 600").exits(0);
    assert_eq!((&stats(&place)["image"]["spp"], &stats(&place)["time_limit_reached"]), (&3.into(), &false.into()));
    assert!(run.stderr().contains("all 3 sample(s) per pixel, before the limit of 600 s"), "{}", run.stderr());

    // Without a limit nothing is said of it, and the key is there.
    let run = place.run("render scene.gltf -o a.png --stats s.json --size 40x24").exits(0);
    assert_eq!(stats(&place)["time_limit_reached"], false);
    assert!(!run.stderr().contains("limit"), "{}", run.stderr());
}

#[test]
fn limits_that_are_no_time_are_refused() {
    let place = Place::new();
    for limit in ["0", "-1", "soon", "1m", "inf"] {
        place.run(&format!("render scene.gltf -o a.png --time-limit {limit}")).exits(2).says(&["--time-limit"]);
        assert_eq!(place.files(), ["scene.gltf"], "{limit}");
    }
}
