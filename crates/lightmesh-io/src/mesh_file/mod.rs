//! Mesh files: the contents of a light mesh, to continue in another run or on another machine, or to study in Python.
//!
//! A file is [safetensors](https://huggingface.co/docs/safetensors): eight bytes with the length of a header, the
//! header as JSON, and arrays of numbers, little-endian and row by row. Any reader of that format opens it.
//!
//! | array, of `direct` and `indirect` | type, shape | |
//! |---|---|---|
//! | `direct.lattice_origin`, `_spacing`, `_size` | F32 (L, 3), F32 (L), U32 (L, 3) | by level: point (i, j, k) lies at origin + spacing · (i, j, k) |
//! | `direct.focus`, `direct.focus_scale` | F32 (2, 3), F32 (1) | corners of the box in which the mesh is fine, and the length of which its spacing is a part, metres; missing if it is so everywhere |
//! | `direct.addresses` | I32 (N, 4) | level, i, j, k of each point that gives light |
//! | `direct.positions` | F32 (N, 3) | where that is, metres |
//! | `direct.clearances` | U8 (N, 6) | room towards ±x, ±y, ±z, in 1/255 of the spacing |
//! | `direct.invalid`, `direct.invalid_positions` | I32 (M, 4), F32 (M, 3) | points inside solids |
//! | `direct.six_axis` | F32 (N, 6, 2, 3) | lux on planes that face ±x, ±y, ±z: arriving, and if nothing were in the way |
//! | `direct.six_axis_parts` | F32 (N, 3, 6, 2, 3) | the same of lights at finite distances, of the sky and of suns, where there are suns or both others |
//! | or `direct.scalar` | F32 (N, 2, 3) | the paper's DirectLight, and what it is divided by |
//! | or `direct.light_bits` | U64 (N, 2, W) | what is known of each light |
//! | or `direct.run_ends`, `direct.runs` | U64 (N), U32 (R) | the same of clusters of lights |
//! | `indirect.values` | F32 (B + 1, N, S, 3) | lux after 0 to B reflections, on planes that face ±x, ±y, ±z; each lies on the surface behind it, if there is one within the spacing |
//! | `indirect.hit_irradiance`, `indirect.hit_count` | F64 (1), U64 (1) | for the estimate of what more bounces would add |
//!
//! [`lightmesh::Snapshot`] says more about each. Positions are for who looks at the file: they follow from the
//! addresses.
//!
//! The header's `__metadata__` has `format` ("lightmesh mesh"), `version` ("2"), `software`, `method`, `settings`
//! (JSON), `units`, `scene` and `settings_fingerprint` ([`lightmesh::Fingerprint`]) and `crc32`: a JSON object with a
//! checksum for each array. Equal meshes are equal files.

mod arrays;
mod read;
mod settings;
mod tensor;
mod write;

use std::path::Path;

use lightmesh::{Cursor, Fingerprint, LightMesh, MeshKey, RenderOptions, Scene, Snapshot};

use crate::error::{Error, one_line};

pub use read::{mesh_from_bytes, read_mesh};
pub use settings::setting;
pub use write::{mesh_to_bytes, write_mesh, write_mesh_to};

/// The contents of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// Fingerprint of the scene that the mesh belongs to.
    pub scene: Fingerprint,
    /// Fingerprint of the settings that its points depend on.
    pub settings_fingerprint: Fingerprint,
    /// Program and version, as in `lightmesh 0.1.0`.
    pub software: String,
    /// How light was computed, as `--method` spells it.
    pub method: String,
    /// Every setting, as a JSON object.
    pub settings: String,
    /// Points and values of the mesh.
    pub contents: Snapshot,
}

/// Who made a mesh file, and how: for people and programs that look at the file. [`MeshFile::check`] ignores it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Provenance<'a> {
    /// Program and version, as in `lightmesh 0.1.0`.
    pub software: &'a str,
    /// How light was computed, as `--method` spells it.
    pub method: &'a str,
    /// Every setting, as a JSON object.
    pub settings: &'a str,
}

impl MeshFile {
    /// Copies everything that `mesh` knows, which belongs to this scene and these options.
    pub fn new(scene: &Scene, options: &RenderOptions, mesh: &LightMesh, provenance: Provenance<'_>) -> Self {
        let Provenance { software, method, settings } = provenance;
        Self {
            scene: Fingerprint::of_scene(scene),
            settings_fingerprint: Fingerprint::of_settings(options),
            software: software.into(),
            method: method.into(),
            settings: settings.into(),
            contents: mesh.snapshot_since(&Cursor::default()),
        }
    }

    /// Returns the number of bounces that the mesh was made for; 0 if it has no indirect light.
    pub fn bounces(&self) -> u32 {
        self.contents.indirect.as_ref().map_or(0, |indirect| indirect.bounces)
    }

    /// Refuses a mesh that was made for another scene or with other settings. `file` names it in messages.
    ///
    /// # Errors
    /// [`Error::OtherScene`], [`Error::OtherSettings`].
    pub fn check(&self, file: &Path, scene: Fingerprint, options: &RenderOptions) -> Result<(), Error> {
        let name = || one_line(file.display());
        if self.scene != scene {
            return Err(Error::OtherScene { file: name() });
        }
        let other = |what: String| Err(Error::OtherSettings { file: name(), what });
        let asked = MeshKey::of(options);
        if self.settings_fingerprint != Fingerprint::of_key(&asked) {
            let difference = self.key().and_then(|key| key.difference(&asked));
            return other(difference.map_or_else(
                || {
                    format!(
                        "was made with other settings, which it names itself; its method is {}",
                        one_line(&self.method)
                    )
                },
                |difference| difference.to_string(),
            ));
        }
        // A mesh without bounces may have indirect light, if it is only emission.
        let (own, bounces) = (self.bounces(), options.transport.bounces);
        if own < bounces {
            return other(format!("was made with bounces {own}, and the options ask for {bounces}"));
        }
        Ok(())
    }

    /// Returns the key of the mesh, from the settings that it names; `None` where those are not the ones of its
    /// fingerprint.
    fn key(&self) -> Option<MeshKey> {
        let key = MeshKey::of(&settings::render_options(&self.settings)?);
        Some(key).filter(|key| Fingerprint::of_key(key) == self.settings_fingerprint)
    }

    /// Makes a mesh for renders with these options, with the points of the file. The file may be for more bounces.
    /// `file` names it in messages.
    ///
    /// # Errors
    /// As [`MeshFile::check`]; [`Error::Mesh`] for contents that do not fit, and for want of memory.
    pub fn into_mesh(self, file: &Path, scene: &Scene, options: &RenderOptions) -> Result<LightMesh, Error> {
        self.check(file, Fingerprint::of_scene(scene), options)?;
        let failed = |cause| Error::Mesh { file: one_line(file.display()), cause };
        let options = options.clone().with(|o| o.transport.bounces = self.bounces());
        let mut mesh = LightMesh::with_focus(scene, &options, self.contents.focus()).map_err(failed)?;
        mesh.merge(&self.contents).map_err(failed)?;
        Ok(mesh)
    }
}
