//! What became of an input, in words that many inputs share.

use lightmesh_io::{Error, LoadOptions, Loaded};

use super::MEMORY;
use crate::exercise::{Depth, exercise};
use crate::memory::within;

/// Loads a scene, checks what every scene and every message must be, and goes on as far as `depth` says.
pub(super) fn of_scene(depth: Depth, name: &str, load: impl FnOnce(&LoadOptions) -> Result<Loaded, Error>) -> String {
    let options = LoadOptions { max_memory: MEMORY, ..LoadOptions::default() };
    match within(MEMORY, || load(&options)) {
        Err(error) => of_error(name, &error),
        Ok(Loaded { data, warnings, .. }) => {
            for warning in &warnings {
                assert!(!warning.contains('\n'), "a warning of several lines: {warning}");
            }
            let textures: usize = data.materials.iter().map(|m| m.textures().iter().flatten().count()).sum();
            let mut words = format!(
                "scene, meshes {} lights {} textures {}",
                data.meshes.len().min(3),
                data.lights.len().min(3),
                textures.min(3)
            );
            words.extend(warnings.iter().map(|warning| format!("; {}", without_numbers(warning))));
            exercise(data, depth);
            words
        }
    }
}

/// Checks a message: one line, which names the file first.
pub(super) fn of_error(name: &str, error: &Error) -> String {
    let message = error.to_string();
    assert!(message.contains(name), "a message that does not name the file: {message}");
    assert!(!message.contains('\n'), "a message of several lines: {message}");
    without_numbers(&message)
}

/// A message without what differs from input to input: numbers, and texts in quotation marks.
pub(super) fn without_numbers(message: &str) -> String {
    let outside_quotes = message.split('"').step_by(2);
    let letters = outside_quotes.flat_map(str::chars).filter(|c| c.is_ascii_alphabetic() || " :,;_[].".contains(*c));
    letters.take(120).collect()
}
