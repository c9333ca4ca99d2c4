//! The extensions that are read, and messages about the others.

use super::context::Context;
use super::json::{Document, MaterialExtensions};
use crate::error::{Error, one_line};

/// Extensions that are read.
const READ: [&str; 10] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "EXT_lights_image_based",
    "EXT_texture_webp",
];

/// Extensions that do not touch a still picture, or whose fallback is the picture: no word about them, and requiring
/// them is odd but harmless.
const HARMLESS: [&str; 7] = [
    "EXT_structural_metadata",
    "EXT_mesh_features",
    "KHR_animation_pointer",
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
];

/// Advises how to get rid of an extension. The commands are those of glTF Transform's command line, which writes plain
/// geometry where it reads compressed.
fn advice(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "decompress the file with `gltf-transform copy in.glb out.glb`, or export it again without compression"
        }
        "KHR_texture_basisu" => {
            "decompress its textures with `gltf-transform ktxdecompress in.glb out.glb`, \
             or export it again with PNG or JPEG"
        }
        "KHR_materials_pbrSpecularGlossiness" => {
            "convert its materials with `gltf-transform metalrough in.glb out.glb`"
        }
        // Their surfaces are sound without them.
        name if is_of_materials(name) => {
            "take its name out of the file's extensionsRequired: its surfaces are then rendered without it"
        }
        "EXT_texture_avif" | "MSFT_texture_dds" => "convert its textures with `gltf-transform png in.glb out.glb`",
        _ => "import the file into Blender and export it again as glTF, which leaves the extension out",
    }
}

/// Returns whether it is an extension of materials, which every material reports by itself.
fn is_of_materials(extension: &str) -> bool {
    MaterialExtensions::default().unread().iter().any(|(name, _)| *name == extension)
}

/// The warning about an extension that is not read.
pub(super) fn not_read(extension: &str) -> String {
    match extension {
        "KHR_materials_pbrSpecularGlossiness" => {
            format!("{extension} is not read: its surfaces look different; {}", advice(extension))
        }
        _ => format!("{} is not read: the picture may differ from the author's", one_line(extension)),
    }
}

/// Refuses a file that requires what we do not read; warns about optional extensions that may change the picture. Those
/// of materials are left to the materials that the scene uses.
pub(super) fn check(context: &mut Context<'_>, document: &Document) -> Result<(), Error> {
    let unread = |name: &&String| !READ.contains(&name.as_str()) && !HARMLESS.contains(&name.as_str());
    if let Some(name) = document.extensions_required.iter().find(unread) {
        return Err(Error::RequiredExtension {
            file: one_line(context.file),
            extension: one_line(name),
            advice: advice(name).to_owned(),
        });
    }
    // A file may list any number of names: a few are enough.
    let optional = document.extensions_used.iter().filter(unread).filter(|name| !is_of_materials(name));
    for name in optional.take(20) {
        context.warnings.add("extensionsUsed", &not_read(name));
    }
    Ok(())
}
