//! `lightmesh reproduce` from the outside.

use serde_json::Value;

use crate::place::Place;

#[test]
fn an_experiment_makes_a_page_and_its_numbers() {
    let place = Place::new();
    let run = place.run("reproduce -o paper --quick --only colour").exits(0);
    assert!(run.stderr().contains("1 experiments; of 1 claims"), "{}", run.stderr());
    let numbers: Value =
        serde_json::from_str(&std::fs::read_to_string(place.path("paper/report.json")).unwrap()).unwrap();
    assert_eq!(numbers["sections"][0]["id"], "colour");
    assert!(place.path("paper/index.html").exists() && place.path("paper/experiments/colour.json").exists());
}

#[test]
fn experiments_that_do_not_exist_and_folders_that_cannot_are_bad_input() {
    let place = Place::new();
    let run = place.run("reproduce -o paper --only alchemy").exits(2);
    assert!(run.stderr().contains("alchemy") && run.stderr().contains("neighbourhoods"), "{}", run.stderr());
    let run = place.run("reproduce -o scene.gltf --quick").exits(2);
    assert!(run.stderr().contains("scene.gltf") && run.stderr().lines().count() == 1, "{}", run.stderr());
}
