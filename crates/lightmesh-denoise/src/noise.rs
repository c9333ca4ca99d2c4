//! Which part of a picture has noise.

use lightmesh::{Aov, Aovs, Method};

/// Returns the layers of a picture by this method that have noise: the rest of its light is left as it is. None: the
/// picture has no noise.
///
/// - A mesh has none at a pixel: what there is comes from gather rays and short rays, in the indirect light. `hybrid` and `auto`
///   also choose some shadow rays by chance. The paper's method reads its mesh for everything.
/// - `standard` shoots a ray to every light sample: to random points of lights that have a size, to the only point of
///   those that have none.
/// - `unbiased` and `path` take random directions for all light.
pub fn noisy_layers(method: Method, lights_have_size: bool) -> Aovs {
    let noisy: &[Aov] = match method {
        Method::Mesh { .. } => &[Aov::Indirect],
        Method::Auto { .. } | Method::Hybrid => &[Aov::Direct, Aov::Indirect],
        Method::Standard if lights_have_size => &[Aov::Direct],
        Method::Standard | Method::Paper { .. } => &[],
        Method::Unbiased { .. } | Method::Path => &[Aov::Direct, Aov::Indirect],
    };
    noisy.iter().copied().collect()
}

/// Returns the layers that denoising these reads: they, the albedo and the normals; none if these are none.
pub fn layers_to_denoise(noisy: Aovs) -> Aovs {
    let guides: &[Aov] = if noisy.is_empty() { &[] } else { &[Aov::Albedo, Aov::Normal] };
    noisy.iter().chain(guides.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_noise_needs_no_layers() {
        assert!(noisy_layers(Method::PAPER, true).is_empty());
        assert!(layers_to_denoise(noisy_layers(Method::Standard, false)).is_empty());
        let standard = layers_to_denoise(noisy_layers(Method::Standard, true));
        assert!(standard.iter().eq([Aov::Albedo, Aov::Normal, Aov::Direct]));
        let path = layers_to_denoise(noisy_layers(Method::Path, false));
        assert!(path.iter().eq([Aov::Albedo, Aov::Normal, Aov::Direct, Aov::Indirect]));
    }
}
