//! Writes the sound inputs of every target into `fuzz/corpus/`, where cargo fuzz looks for them.

use std::path::Path;
use std::{fs, io};

use lightmesh_fuzz::{Seed, Target};

#[expect(clippy::print_stdout, reason = "a program says what it did")]
fn main() -> io::Result<()> {
    for target in Target::ALL {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target.name());
        fs::create_dir_all(&folder)?;
        let seeds = target.seeds();
        let bytes: usize = seeds.iter().map(|seed| seed.bytes.len()).sum();
        for Seed { name, bytes } in &seeds {
            fs::write(folder.join(name), bytes)?;
        }
        println!("{} ({} inputs, {bytes} bytes)", folder.display(), seeds.len());
    }
    Ok(())
}
