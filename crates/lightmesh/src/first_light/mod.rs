//! Light for the first picture of a scene that would be black: most files have no lamp.
//!
//! | what the camera sees is lit by | light that is added |
//! |---|---|
//! | its own lamps, emission or environment | none |
//! | nothing, and the sky can come in | a studio: soft light all round and a key light ([`studio`]) |
//! | nothing, and the sky cannot come in | a lamp at the camera ([`headlight`]) |
//!
//! What is decided is decided by light, not by presence ([`Survey`]): emission may be black or tiny, a lamp out of
//! range or turned away.

mod ground_shadow;
mod headlight;
mod studio;
mod survey;

pub use survey::{FirstLight, Survey};

use crate::{Error, Scene};

impl Scene {
    /// Adds the light that [`Survey::wanted`] says this view needs. The studio's light is `strength` times as strong
    /// and turned by `rotation` (radians, about +Y).
    ///
    /// The studio depends on the scene alone, its first camera included, so that all views of a scene have one light.
    ///
    /// # Errors
    /// As [`Scene::with_emitters`].
    pub fn with_first_light(self, survey: &Survey, strength: f32, rotation: f32) -> Result<Self, Error> {
        match survey.wanted {
            FirstLight::Own => Ok(self),
            FirstLight::Headlight => {
                let lamp = headlight::lamp(&self, survey);
                self.relit(|data| data.lights.push(lamp))
            }
            FirstLight::Studio => {
                let data = self.data();
                let view = data.cameras.first().cloned().unwrap_or_else(|| data.framing_camera());
                let white = studio::white(data) * strength;
                let environment = studio::environment(&view, white, rotation);
                let scene = self.relit(|data| data.environment = Some(environment))?;
                let background = studio::background(&scene, white);
                Ok(scene.with_background(background))
            }
        }
    }
}
