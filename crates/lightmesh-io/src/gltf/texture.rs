//! Textures: which are used, by whom and as what.

use glam::Vec2;
use lightmesh::{Filter, Texture, TextureRef, UvTransform, Wrap};

use super::Used;
use super::context::{Context, Place, place};
use super::json::{Document, Sampler, TextureInfo};
use crate::error::Error;

/// The meaning of an image's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Encoding {
    /// Colours behind the sRGB curve.
    Srgb,
    /// Plain numbers.
    Linear,
}

/// The textures that materials use. An image that is used both as colour and as numbers makes two textures.
#[derive(Debug, Default)]
pub(super) struct Textures {
    used: Used<(usize, Encoding)>,
}

/// A used texture before its image is decoded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    /// Index into the file's images.
    pub(super) image: usize,
    pub(super) encoding: Encoding,
    /// Complete but for its image.
    pub(super) texture: Texture,
}

impl Textures {
    /// A material's reference to a texture; `None`, with a warning, where the texture cannot be shown.
    pub(super) fn refer(
        &mut self,
        context: &mut Context<'_>,
        document: &Document,
        referrer: Place<'_>,
        info: Option<&TextureInfo>,
        encoding: Encoding,
    ) -> Result<Option<TextureRef>, Error> {
        let Some(info) = info else { return Ok(None) };
        let texture = context.get(&document.textures, "texture", info.index, referrer)?;
        let texture_place = place("texture", info.index, texture.name.as_deref());
        if source(document, info.index).is_none() {
            context.warnings.add(texture_place, "it has no PNG, JPEG or WebP image: the texture is left out");
            return Ok(None);
        }

        // KHR_texture_transform may choose another coordinate set.
        let transform = info.extensions.transform.as_ref();
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        if uv_set > 1 {
            context.warnings.add(referrer, "a texture uses a coordinate set above TEXCOORD_1: the texture is left out");
            return Ok(None);
        }
        let transform = match transform {
            None => UvTransform::default(),
            Some(t) => {
                let (offset, scale) = (Vec2::from_array(t.offset), Vec2::from_array(t.scale));
                if !(offset.is_finite() && scale.is_finite() && t.rotation.is_finite()) {
                    return Err(context.invalid(referrer, "its KHR_texture_transform is not finite"));
                }
                UvTransform::new(offset, t.rotation, scale)
            }
        };
        let texture = self.used.number((info.index, encoding));
        Ok(Some(TextureRef { texture, uv_set: uv_set as usize, transform }))
    }

    /// The used textures in the order of their numbers.
    pub(super) fn pending(&self, context: &mut Context<'_>, document: &Document) -> Result<Vec<Pending>, Error> {
        let mut pending = Vec::with_capacity(self.used.order.len());
        for &(index, encoding) in &self.used.order {
            let texture = context.get(&document.textures, "texture", index, "materials")?;
            let texture_place = place("texture", index, texture.name.as_deref());
            let sampler = match texture.sampler {
                Some(sampler) => Some(context.get(&document.samplers, "sampler", sampler, texture_place)?),
                None => None,
            };
            let Some(image) = source(document, index) else {
                return Err(context.invalid(texture_place, "it has no image"));
            };
            context.get(&document.images, "image", image, texture_place)?;
            pending.push(Pending { image, encoding, texture: sampled(context, texture_place, sampler) });
        }
        Ok(pending)
    }
}

/// The image of a texture: the plain one, else EXT_texture_webp's.
fn source(document: &Document, texture: usize) -> Option<usize> {
    let texture = document.textures.get(texture)?;
    texture.source.or(texture.extensions.webp.as_ref().and_then(|webp| webp.source))
}

/// Wrap modes and filter; glTF's default is repeat, and bilinear is ours.
fn sampled(context: &mut Context<'_>, texture: Place<'_>, sampler: Option<&Sampler>) -> Texture {
    let mut wrap = |mode: Option<u32>| match mode.unwrap_or(10497) {
        10497 => Wrap::Repeat,
        33071 => Wrap::ClampToEdge,
        33648 => Wrap::MirroredRepeat,
        _ => {
            context.warnings.add(texture, "its sampler has an unknown wrap mode: it repeats");
            Wrap::Repeat
        }
    };
    let wrap_s = wrap(sampler.and_then(|s| s.wrap_s));
    let wrap_t = wrap(sampler.and_then(|s| s.wrap_t));
    let filter = match sampler.and_then(|s| s.mag_filter) {
        Some(9728) => Filter::Nearest,
        _ => Filter::Bilinear,
    };
    Texture { image: 0, wrap_s, wrap_t, filter }
}
