//! The text of an MTL file.

use glam::{Vec2, Vec3};

/// A reference to an image file with its options.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The path as the file has it.
    pub(super) path: String,
    /// `-s`: scale of u and v.
    pub(super) scale: Vec2,
    /// `-o`: offset of u and v, after the scale.
    pub(super) offset: Vec2,
    /// `-clamp on`.
    pub(super) clamp: bool,
    /// `-bm`: strength of a normal map.
    pub(super) strength: f32,
}

/// A material as MTL describes it; `None` and empty: not given.
#[derive(Clone, Debug, Default)]
pub(super) struct Mtl {
    pub(super) name: String,
    pub(super) diffuse: Option<Vec3>,
    pub(super) specular: Option<Vec3>,
    pub(super) emission: Option<Vec3>,
    /// `Tf`: what glass lets through.
    pub(super) filter: Option<Vec3>,
    /// `d`, or 1 − `Tr`.
    pub(super) alpha: Option<f32>,
    pub(super) ior: Option<f32>,
    pub(super) illumination: u32,
    pub(super) diffuse_map: Option<Map>,
    pub(super) emission_map: Option<Map>,
    pub(super) alpha_map: Option<Map>,
    pub(super) normal_map: Option<Map>,
    /// The paths of maps that are not read.
    pub(super) other_maps: Vec<String>,
}

/// Parses the text. A line that cannot be understood is told to `warn` with its number and passed over.
pub(super) fn parse(bytes: &[u8], mut warn: impl FnMut(usize, &str)) -> Vec<Mtl> {
    let mut materials: Vec<Mtl> = Vec::new();
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        // Split the line into a keyword and the rest.
        let (key, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
        let rest = rest.trim();
        if key == "newmtl" {
            materials.push(Mtl { name: rest.to_owned(), illumination: 2, ..Mtl::default() });
            continue;
        }
        // Set the property of the newest material.
        let Some(material) = materials.last_mut() else { continue };
        let understood = match key.to_ascii_lowercase().as_str() {
            "kd" => set(&mut material.diffuse, color(rest)),
            "ks" => set(&mut material.specular, color(rest)),
            "ke" => set(&mut material.emission, color(rest)),
            "tf" => set(&mut material.filter, color(rest)),
            "d" => set(&mut material.alpha, number_at_end(rest)),
            // Exporters that write both do not agree about Tr: d has the last word.
            "tr" if material.alpha.is_some() => true,
            "tr" => set(&mut material.alpha, number_at_end(rest).map(|t| 1.0 - t)),
            "ni" => set(&mut material.ior, number_at_end(rest)),
            "illum" => rest.parse().map(|n| material.illumination = n).is_ok(),
            "map_kd" => set(&mut material.diffuse_map, map(rest)),
            "map_ke" => set(&mut material.emission_map, map(rest)),
            "map_d" => set(&mut material.alpha_map, map(rest)),
            "norm" | "map_kn" => set(&mut material.normal_map, map(rest)),
            "bump" | "map_bump" => {
                warn(number + 1, "bump maps hold heights and are not read; a normal map is named by norm");
                material.other_maps.extend(map(rest).map(|map| map.path));
                true
            }
            key => {
                if key.starts_with("map_") || ["disp", "decal", "refl"].contains(&key) {
                    material.other_maps.extend(map(rest).map(|map| map.path));
                }
                true
            }
        };
        if !understood {
            warn(number + 1, "a line of a material library cannot be understood and is left out");
        }
    }
    materials
}

/// Stores a value that could be parsed, and says whether it could.
fn set<T>(slot: &mut Option<T>, value: Option<T>) -> bool {
    let understood = value.is_some();
    if understood {
        *slot = value;
    }
    understood
}

/// A finite number.
fn finite(word: &str) -> Option<f32> {
    word.parse().ok().filter(|value: &f32| value.is_finite())
}

/// `r g b`, or `r` for grey; at least 0. Spectra and CIE XYZ are not read.
fn color(rest: &str) -> Option<Vec3> {
    let mut words = rest.split_ascii_whitespace();
    let r = finite(words.next()?)?;
    let (g, b) = match (words.next(), words.next()) {
        (None, _) => (r, r),
        (Some(g), Some(b)) => (finite(g)?, finite(b)?),
        (Some(_), None) => return None,
    };
    Some(Vec3::new(r, g, b).max(Vec3::ZERO))
}

/// The last word, a number: `d -halo 0.5` has an option before it.
fn number_at_end(rest: &str) -> Option<f32> {
    finite(rest.split_ascii_whitespace().last()?)
}

/// `[-option arguments]... path with spaces`.
fn map(rest: &str) -> Option<Map> {
    let mut map = Map { path: String::new(), scale: Vec2::ONE, offset: Vec2::ZERO, clamp: false, strength: 1.0 };
    let mut rest = rest;

    // Read options, each with as many words as it takes.
    while let Some(option) = rest.strip_prefix('-') {
        let (name, after) = option.split_once(|c: char| c.is_ascii_whitespace())?;
        rest = after.trim_start();
        // Words that this option may take; numbers end where a word is none.
        let (most, numeric) = match name {
            "o" | "s" | "t" => (3, true),
            "mm" => (2, true),
            "bm" | "boost" | "texres" => (1, true),
            "clamp" | "blendu" | "blendv" | "cc" | "imfchan" | "type" => (1, false),
            _ => return None,
        };
        let (mut values, mut word) = (Vec::new(), "");
        for _ in 0..most {
            let (next, after) = rest.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((rest, ""));
            let value = finite(next);
            if numeric && value.is_none() {
                break;
            }
            values.extend(value);
            word = next;
            rest = after.trim_start();
        }
        let pair = |default: f32| {
            let first = values.first().copied().unwrap_or(default);
            Vec2::new(first, values.get(1).copied().unwrap_or(default))
        };
        match name {
            "o" => map.offset = pair(0.0),
            "s" => map.scale = pair(1.0),
            "bm" => map.strength = pair(1.0).x,
            "clamp" => map.clamp = word == "on",
            _ => {}
        }
    }

    // Take the rest of the line as the path.
    map.path = rest.to_owned();
    (!rest.is_empty()).then_some(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_options_and_spaces() {
        let parsed = map("-s 2 3 1 -o 0.5 -clamp on -bm 0.25 my wood.png").unwrap();
        assert_eq!(parsed.path, "my wood.png");
        assert_eq!((parsed.scale, parsed.offset), (Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0)));
        assert!(parsed.clamp && parsed.strength == 0.25);
        assert_eq!(map("-s 2"), None);
        assert_eq!(map("-unknown 2 a.png"), None);
    }

    /// They are files of the scene all the same.
    #[test]
    fn maps_that_are_not_read_are_known() {
        let text = b"newmtl a\nbump -bm 2 hills.png\nmap_Ks a b.png\nrefl -type sphere sky.png\nmap_Kd wood.png\n";
        let materials = parse(text, |_, _| {});
        assert_eq!(materials[0].other_maps, ["hills.png", "a b.png", "sky.png"]);
    }

    #[test]
    fn lines_that_are_no_colour_are_told_and_passed_over() {
        let mut lines = Vec::new();
        let text = b"Kd 1 1 1\nnewmtl a\nKd 0.5\nKs 1 2\nKe spectral x.rfl\nTr 0.25\nNi nan\nillum 7\n";
        let materials = parse(text, |line, _| lines.push(line));
        assert_eq!(lines, [4, 5, 7]);
        assert_eq!(materials.len(), 1);
        assert_eq!((materials[0].diffuse, materials[0].alpha), (Some(Vec3::splat(0.5)), Some(0.75)));
        assert_eq!((materials[0].specular, materials[0].ior, materials[0].illumination), (None, None, 7));
    }
}
