//! `--denoise`: takes the noise out of finished pictures.

use std::time::Instant;

use lightmesh::{Aovs, Frame, Method, Progress, RenderOptions, Scene};
use lightmesh_denoise::{
    Denoiser, DenoisingBytes, Error, Places, Resources, denoise_picture, layers_to_denoise, noisy_layers,
};
use lightmesh_io::output::Denoised;

/// A denoiser that is ready, and the layers that a picture keeps.
#[derive(Debug)]
pub struct Denoise {
    denoiser: Denoiser,
    kept: Aovs,
}

impl Denoise {
    /// Loads the library, and adds the layers that it needs to those of the picture; `None`, and nothing is done, where
    /// pictures by the method never have noise.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::Named`].
    pub fn prepare(places: &Places, options: &mut RenderOptions) -> Result<Option<Self>, Error> {
        let needed = layers_to_denoise(noisy_layers(options.method, true));
        if needed.is_empty() {
            return Ok(None);
        }
        let denoiser = Denoiser::load_from(places)?;
        let kept = options.picture.aovs;
        options.picture.aovs = kept.iter().chain(needed.iter()).collect();
        Ok(Some(Self { denoiser, kept }))
    }

    /// Returns the layers that the picture keeps.
    pub fn kept(&self) -> Aovs {
        self.kept
    }

    /// Refuses a picture that memory does not hold while it is denoised, beside the `scene_bytes` of its scene.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn check_memory(&self, options: &RenderOptions, scene_bytes: u64) -> Result<(), Error> {
        let DenoisingBytes { picture, library } = bytes(options);
        let needed_bytes = picture.saturating_add(library).saturating_add(scene_bytes);
        let limit_bytes = options.limits.max_memory;
        if needed_bytes > limit_bytes { Err(Error::OutOfMemory { needed_bytes, limit_bytes }) } else { Ok(()) }
    }

    /// Takes the noise out of a frame in the current thread pool, and then the layers that were only needed for that;
    /// `None` if the picture has no noise.
    ///
    /// # Errors
    /// [`Error::Library`], [`Error::Cancelled`].
    pub fn apply(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        options: &RenderOptions,
        progress: &dyn Progress,
    ) -> Result<Option<Denoised>, Error> {
        let started = Instant::now();
        let noisy = noisy_layers(options.method, scene.has_lights_with_size());
        if !noisy.is_empty() {
            let meshes = frame.stats.direct.bytes + frame.stats.indirect.bytes;
            let held = bytes(options).picture.saturating_add(scene.bytes()).saturating_add(meshes);
            let max_memory = options.limits.max_memory.saturating_sub(held);
            let resources = Resources::for_method(options.method, max_memory);
            denoise_picture(&self.denoiser, &mut frame.image, &frame.layers, noisy, resources, progress)?;
        }
        frame.layers.retain(|layer| self.kept.contains(layer.aov));
        let seconds = started.elapsed().as_secs_f64();
        Ok((!noisy.is_empty()).then(|| Denoised { by: self.denoiser.name(), seconds }))
    }
}

/// Memory of the picture, its layers and the denoiser.
fn bytes(options: &RenderOptions) -> DenoisingBytes {
    let picture = &options.picture;
    DenoisingBytes::of(picture.width, picture.height, picture.aovs)
}

/// Says that a picture has no noise, and so is left as it is.
pub fn no_noise_message(method: Method) -> String {
    let why = if method.is_paper() { "" } else { " of lights without a size" };
    format!("denoise: pictures by the method {method}{why} have no noise: this one is left as it is")
}

#[cfg(test)]
mod tests {
    use lightmesh::Aov;

    use super::*;

    /// Without noise nothing is looked for and nothing is added.
    #[test]
    fn a_method_without_noise_needs_no_library() {
        let nowhere = Places { named: Some("/nonexistent".into()), ..Places::default() };
        let mut options = RenderOptions { method: Method::PAPER, ..RenderOptions::default() };
        assert!(Denoise::prepare(&nowhere, &mut options).expect("nothing to load").is_none());
        assert!(options.picture.aovs.is_empty());
        options.method = Method::MESH;
        assert!(matches!(Denoise::prepare(&nowhere, &mut options), Err(Error::Named { .. })));
    }

    /// The picture's own layers are kept, and those that denoising reads are added.
    #[test]
    fn layers_are_added_for_the_time_of_the_render() {
        let mut options = RenderOptions { method: Method::Path, ..RenderOptions::default() };
        options.picture.aovs = [Aov::Depth, Aov::Normal].into_iter().collect();
        // Where there is no library, there is nothing to try.
        let Ok(denoise) = Denoise::prepare(&Places::of_process(), &mut options) else { return };
        let denoise = denoise.expect("noise");
        assert!(denoise.kept().iter().eq([Aov::Normal, Aov::Depth]));
        let all = [Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Direct, Aov::Indirect];
        assert!(options.picture.aovs.iter().eq(all));
        let DenoisingBytes { picture, library } = bytes(&options);
        options.limits.max_memory = picture + library + 999;
        denoise.check_memory(&options, 999).expect("enough");
        assert!(matches!(denoise.check_memory(&options, 1000), Err(Error::OutOfMemory { .. })));
    }
}
