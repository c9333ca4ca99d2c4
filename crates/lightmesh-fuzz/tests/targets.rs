//! Every target: its sound inputs are accepted as far as a picture, and damaged ones are the same each time.

use std::sync::Mutex;

use lightmesh_fuzz::{Depth, Seed, Target};

/// The memory that a reader takes is counted for the whole program: one test at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// Damage that begins with a refused file tries nothing behind the first check.
#[test]
fn sound_inputs_are_accepted() {
    let _alone = ALONE.lock();
    for target in Target::ALL {
        for Seed { name, bytes } in target.seeds() {
            let outcome = target.run(&bytes, Depth::Render);
            let is_read = ["scene", "map", "merged mesh"].iter().any(|start| outcome.starts_with(start));
            assert!(is_read, "{} {name}: {outcome}", target.name());
        }
    }
}

/// The same seed damages an input in the same way, others in others; and most damage is found only behind the first
/// checks: at least an eighth of the damaged inputs is still read.
#[test]
fn damage_is_repeatable_and_goes_deep() {
    let _alone = ALONE.lock();
    for target in Target::ALL {
        let (mut read, mut changed, mut tried) = (0, 0, 0);
        for Seed { bytes, .. } in target.seeds() {
            for seed in 0..200 {
                let damaged = target.mutate(&bytes, seed);
                assert_eq!(damaged, target.mutate(&bytes, seed), "{} {seed}", target.name());
                tried += 1;
                changed += usize::from(damaged != bytes);
                let outcome = target.run(&damaged, Depth::Read);
                read += usize::from(["scene,", "map", "mesh of"].iter().any(|start| outcome.starts_with(start)));
            }
        }
        assert!(4 * changed > 3 * tried, "{}: {changed} of {tried} are damaged", target.name());
        assert!(8 * read > tried, "{}: {read} of {tried} are still read", target.name());
    }
}
