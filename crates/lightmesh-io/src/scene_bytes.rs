//! Scenes as bytes, for other processes: everything that a [`SceneData`] holds, whatever file or program it came from.
//!
//! Sixteen bytes of magic and version, the length of what follows, and the scene in the postcard format. It is for
//! processes of one version of this library and no format for keeping scenes.

use lightmesh::SceneData;

use crate::error::Error;

/// The first bytes: a name and the version of this library.
const MAGIC: [u8; 16] = *b"lightmesh scene\x01";

/// Writes a scene as bytes.
///
/// # Errors
/// [`Error::Invalid`] where it has shapes of the user's own: they are code.
pub fn scene_to_bytes(scene: &SceneData) -> Result<Vec<u8>, Error> {
    let fail = |what: String| Error::Invalid { file: NAME.into(), place: "shapes".into(), what };
    if !scene.shapes.is_empty() {
        return Err(fail("surfaces of the user's own cannot be sent to other processes; make meshes of them".into()));
    }
    let mut bytes = [MAGIC.as_slice(), &[0; 8]].concat();
    bytes = postcard::to_extend(scene, bytes).map_err(|error| fail(error.to_string()))?;
    let length = (bytes.len() - HEADER) as u64;
    bytes[MAGIC.len()..HEADER].copy_from_slice(&length.to_le_bytes());
    Ok(bytes)
}

/// The scene that [`scene_to_bytes`] made bytes of; [`lightmesh::Scene::new`] checks it.
///
/// # Errors
/// [`Error::Syntax`] for bytes of something else, of another version, or incomplete ones.
pub fn scene_from_bytes(bytes: &[u8]) -> Result<SceneData, Error> {
    let fail = |place: String, what: String| Err(Error::Syntax { file: NAME.into(), place, what });
    let Some(rest) = bytes.strip_prefix(&MAGIC) else {
        return fail("byte 0".into(), "these are no bytes of a scene, or of another version of lightmesh".into());
    };
    let Some((length, body)) = rest.split_first_chunk() else {
        return fail(format!("byte {}", bytes.len()), "the bytes end in the header".into());
    };
    let length = u64::from_le_bytes(*length);
    if length != body.len() as u64 {
        return fail("header".into(), format!("says {length} bytes, but {} follow; they are incomplete", body.len()));
    }
    match postcard::take_from_bytes(body) {
        Ok((scene, [])) => Ok(scene),
        Ok((_, rest)) => fail(format!("byte {}", bytes.len() - rest.len()), "more follows than a scene".into()),
        Err(error) => fail("scene".into(), format!("{error}; the bytes are damaged")),
    }
}

const HEADER: usize = MAGIC.len() + 8;

/// The name of the bytes in messages.
const NAME: &str = "scene bytes";

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::load_options::LoadOptions;
    use crate::scene_file::load;

    fn sample() -> SceneData {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        load(&path.join("cornell.glb"), &LoadOptions::default()).expect("our own scene").data
    }

    /// Numbers, names and textures come back bit for bit.
    #[test]
    fn a_scene_comes_back() {
        let scene = sample();
        let bytes = scene_to_bytes(&scene).expect("bytes");
        let back = scene_from_bytes(&bytes).expect("scene");
        assert_eq!(format!("{scene:?}"), format!("{back:?}"));
        assert_eq!(scene_to_bytes(&back).expect("bytes"), bytes);
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let bytes = scene_to_bytes(&sample()).expect("bytes");
        for end in (0..bytes.len()).step_by(97) {
            assert!(scene_from_bytes(&bytes[..end]).is_err(), "{end}");
        }
        assert!(scene_from_bytes(&[bytes.as_slice(), &[0]].concat()).is_err());
        // Whatever byte changes: an error or another scene, never a panic.
        for at in (0..bytes.len()).step_by(13) {
            let mut changed = bytes.clone();
            changed[at] ^= 0xff;
            if let Ok(scene) = scene_from_bytes(&changed) {
                let _ = lightmesh::Scene::new(scene);
            }
        }
    }
}
