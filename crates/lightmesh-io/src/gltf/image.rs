//! Decoding of images: once each, in parallel.
//!
//! Eight bits per channel stay as they are. Sixteen bits become 32-bit floats, which the renderer takes as linear:
//! where such an image is used as colour its sRGB curve is undone here, and an image that is used both ways is kept
//! twice.
//!
//! An image that is missing or cannot be decoded is left out with a warning: a scene without one of its textures is
//! still worth a picture. What the file must not ask for (paths out of its folder, more memory than allowed) stays an
//! error, and so does an index that refers to nothing.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::Arc;

use glam::Vec3;
use image::error::{ParameterError, ParameterErrorKind};
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageResult};
use lightmesh::{ImageData, Texels, Texture};
use rayon::prelude::*;

use super::buffer::Buffers;
use super::context::{Context, Place, place};
use super::texture::{Encoding, Textures};
use super::uri;
use crate::error::{Error, one_line};
use crate::srgb::linear_from_srgb;
use crate::texture_image;

/// An image of the file with its compressed bytes.
#[derive(Debug)]
struct Source<'a> {
    index: usize,
    name: &'a str,
    bytes: Cow<'a, [u8]>,
    /// Whether it is used as colour, or else as numbers.
    srgb: bool,
    linear: bool,
}

/// Decoded texels by use; 8-bit texels are the same for both.
#[derive(Debug)]
struct Decoded {
    width: u32,
    height: u32,
    srgb: Option<Texels>,
    linear: Option<Texels>,
}

/// The used textures whose images could be read.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) textures: Vec<Texture>,
    pub(super) images: Vec<ImageData>,
    /// For each used texture its index in `textures`; `None` where its image could not be read.
    pub(super) index_of: Vec<Option<usize>>,
}

/// The used textures and their images.
pub(super) fn decode(context: &mut Context<'_>, buffers: &Buffers<'_>, textures: Textures) -> Result<Shown, Error> {
    let pending = textures.pending(context, buffers.document)?;

    // Collect each image once, in the file's order.
    let mut uses: BTreeMap<usize, (bool, bool)> = BTreeMap::new();
    for texture in &pending {
        let (srgb, linear) = uses.entry(texture.image).or_default();
        *srgb |= texture.encoding == Encoding::Srgb;
        *linear |= texture.encoding == Encoding::Linear;
    }
    let mut sources = Vec::with_capacity(uses.len());
    for (index, (srgb, linear)) in uses {
        if let Some((name, bytes)) = fetch(context, buffers, index, "textures")? {
            sources.push(Source { index, name, bytes, srgb, linear });
        }
    }

    // Pay for all of them before the first is decoded.
    let mut largest_transient = 0;
    let mut readable = Vec::with_capacity(sources.len());
    for source in sources {
        match Size::of(context, &source) {
            Ok(size) => {
                context.spend(image_place(&source), size.kept, 1)?;
                context.spend(image_place(&source), size.smaller, 1)?;
                largest_transient = largest_transient.max(size.transient);
                readable.push(source);
            }
            Err(why) => undecodable(context, &source, &why)?,
        }
    }
    let sources = readable;
    let at_once = rayon::current_num_threads().min(sources.len()) as u64;
    context.spend("decoding of images", at_once, largest_transient)?;

    // What happens is told in the file's order, whichever thread was first.
    let limit = context.budget.left().saturating_add(largest_transient);
    let decoded: Vec<_> = sources.par_iter().map(|source| decode_one(source, limit)).collect();

    // One entry per image and, for 16 bits, per use.
    let mut images = Vec::new();
    let mut image_of = BTreeMap::new();
    for (source, decoded) in sources.iter().zip(decoded) {
        let Decoded { width, height, srgb, linear } = match decoded {
            Ok(decoded) => decoded,
            Err(why) => {
                undecodable(context, source, &why)?;
                continue;
            }
        };
        for (encoding, texels) in [(Encoding::Srgb, srgb), (Encoding::Linear, linear)] {
            if let Some(texels) = texels {
                image_of.insert((source.index, encoding), images.len());
                images.push(ImageData { name: one_line(source.name), width, height, texels });
            }
        }
        // 8-bit texels come once, as sRGB, and serve both.
        if let (true, Some(&image)) = (source.linear, image_of.get(&(source.index, Encoding::Srgb))) {
            image_of.entry((source.index, Encoding::Linear)).or_insert(image);
        }
    }
    // Textures whose image is there, and where they have gone.
    let mut textures = Vec::with_capacity(pending.len());
    let index_of = pending.iter().map(|texture| {
        let image = *image_of.get(&(texture.image, texture.encoding))?;
        textures.push(Texture { image, ..texture.texture });
        Some(textures.len() - 1)
    });
    let index_of = index_of.collect();
    Ok(Shown { textures, images, index_of })
}

/// An image of light rather than of a surface: linear, and with values above 1 where its alpha says so.
#[derive(Debug)]
pub(super) struct RadianceImage {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Row by row from the upper left corner.
    pub(super) texels: Vec<Vec3>,
}

/// Decodes an image of EXT_lights_image_based: with alpha RGBD, else sRGB. `None`, and a warning, where it
/// cannot be read.
pub(super) fn decode_radiance(
    context: &mut Context<'_>,
    buffers: &Buffers<'_>,
    index: usize,
    referrer: impl Display,
) -> Result<Option<RadianceImage>, Error> {
    let Some((name, bytes)) = fetch(context, buffers, index, referrer)? else { return Ok(None) };
    let source = Source { index, name, bytes, srgb: true, linear: false };
    // Pay for the decoder's output, for all channels as floats and for what stays; then decode.
    let decoded = match Size::of(context, &source) {
        Ok(size) => {
            let bytes_per_texel = (size_of::<[f32; 4]>() + size_of::<Vec3>()) as u64;
            context.spend(image_place(&source), size.texels, bytes_per_texel)?;
            context.spend(image_place(&source), size.decoded, 1)?;
            let limit = context.budget.left().saturating_add(size.decoded);
            decoder(&source, limit).and_then(DynamicImage::from_decoder)
        }
        Err(why) => Err(why),
    };
    let image = match decoded {
        Ok(image) => image,
        Err(why) => return undecodable(context, &source, &why).map(|()| None),
    };
    let linear: fn([f32; 4]) -> Vec3 = if image.color().has_alpha() { linear_from_rgbd } else { linear_from_rgb };
    let (width, height) = (image.width(), image.height());
    let texels = image.into_rgba32f().pixels().map(|pixel| linear(pixel.0)).collect();
    Ok(Some(RadianceImage { width, height, texels }))
}

/// RGBD: colours divided by alpha, which is at least 1/255. The specification leaves open how the colours are encoded;
/// they are raised to 2.2 before the division, an assumption that no file of others has been held against.
fn linear_from_rgbd([r, g, b, d]: [f32; 4]) -> Vec3 {
    Vec3::new(r, g, b).map(|c| libm::powf(c, 2.2)) / d.max(1.0 / 255.0)
}

/// An sRGB colour.
fn linear_from_rgb([r, g, b, _]: [f32; 4]) -> Vec3 {
    Vec3::new(r, g, b).map(linear_from_srgb)
}

/// An image's name and its bytes in the file.
type Compressed<'a> = (&'a str, Cow<'a, [u8]>);

/// An image's name and bytes; `None`, and a warning, where there are none.
fn fetch<'a>(
    context: &mut Context<'_>,
    buffers: &'a Buffers<'_>,
    index: usize,
    referrer: impl Display,
) -> Result<Option<Compressed<'a>>, Error> {
    let image = context.get(&buffers.document.images, "image", index, referrer)?;
    let uri_name = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let name = image.name.as_deref().or(uri_name).unwrap_or_default();
    let at = place("image", index, Some(name));
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => match uri::fetch(context, at, uri) {
            Ok(bytes) => Cow::Owned(bytes),
            Err(Error::MissingFile { target, cause, .. }) => {
                let at = format_args!("{at}, {target} ({cause})");
                context.warnings.add(at, "the image file cannot be read: its textures are left out");
                return Ok(None);
            }
            Err(Error::DataUri { what, .. }) => {
                let at = format_args!("{at} ({what})");
                context.warnings.add(at, "the image's data cannot be read: its textures are left out");
                return Ok(None);
            }
            Err(refused) => return Err(refused),
        },
        (None, Some(view)) => Cow::Borrowed(buffers.view(context, view, at)?.0),
        (None, None) => {
            context.warnings.add(at, "the image has neither a uri nor a bufferView: its textures are left out");
            return Ok(None);
        }
    };
    Ok(Some((name, bytes)))
}

fn image_place<'a>(source: &Source<'a>) -> Place<'a> {
    place("image", source.index, Some(source.name))
}

/// Warns that the image is left out; an error where it may be sound but the memory ends.
fn undecodable(context: &mut Context<'_>, source: &Source<'_>, why: &ImageError) -> Result<(), Error> {
    let (at, why_line) = (image_place(source), one_line(why));
    if let ImageError::Limits(_) = why {
        return Err(Error::Image { file: one_line(context.file), place: one_line(at), what: why_line });
    }
    // What the decoder says differs from image to image; the message must not.
    let message = "the image cannot be decoded: its textures are left out; PNG, JPEG and WebP are read";
    context.warnings.add(format_args!("{at} ({why_line})"), message);
    Ok(())
}

/// A decoder that has read the image's header and nothing else.
fn decoder<'a>(source: &'a Source<'_>, limit: u64) -> ImageResult<impl ImageDecoder + 'a> {
    texture_image::reader(&source.bytes, limit)?.into_decoder()
}

/// Bytes that decoding takes.
#[derive(Clone, Copy, Debug)]
struct Size {
    texels: u64,
    /// Bytes of the decoder's output.
    decoded: u64,
    /// Bytes of the texels that stay.
    kept: u64,
    /// Bytes of the smaller copies that the built scene has of colours.
    smaller: u64,
    /// Bytes of the decoder's output and our conversion, on top while it works.
    transient: u64,
}

impl Size {
    fn of(context: &Context<'_>, source: &Source<'_>) -> ImageResult<Self> {
        let decoder = decoder(source, context.budget.left())?;
        let (width, height) = decoder.dimensions();
        if width == 0 || height == 0 {
            let no_texels = ParameterError::from_kind(ParameterErrorKind::DimensionMismatch);
            return Err(ImageError::Parameter(no_texels));
        }
        let texels = u64::from(width) * u64::from(height);
        let uses = u64::from(source.srgb) + u64::from(source.linear);
        let (kept, converted) = match is_deep(decoder.color_type()) {
            true => (texels.saturating_mul(16 * uses), texels.saturating_mul(8 + 16)),
            false => (texels.saturating_mul(4), texels.saturating_mul(4)),
        };
        let texel = if is_deep(decoder.color_type()) { 16 } else { 4 };
        let smaller = if source.srgb { ImageData::mipmap_texels(width, height).saturating_mul(texel) } else { 0 };
        let decoded = decoder.total_bytes();
        Ok(Self { texels, decoded, kept, smaller, transient: decoded.saturating_add(converted) })
    }
}

/// Returns whether the channels have more than eight bits.
fn is_deep(color: ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}

/// Decodes one image for its uses; at most `limit` bytes are allocated by the decoder.
fn decode_one(source: &Source<'_>, limit: u64) -> ImageResult<Decoded> {
    let image = DynamicImage::from_decoder(decoder(source, limit)?)?;
    let (width, height) = (image.width(), image.height());
    if !is_deep(image.color()) {
        let raw = image.into_rgba8().into_raw();
        let texels = Texels::Rgba8(Arc::from(raw.as_chunks::<4>().0));
        return Ok(Decoded { width, height, srgb: Some(texels), linear: None });
    }
    let raw = image.into_rgba16().into_raw();
    let texels = raw.as_chunks::<4>().0;
    let linear = |value: u16| f32::from(value) / 65535.0;
    let as_numbers = || texels.iter().map(|texel| texel.map(linear)).collect();
    let as_colors = || {
        // A table of the curve pays where it has fewer entries than the image has values.
        let table: Option<Vec<f32>> = (3 * texels.len() > usize::from(u16::MAX))
            .then(|| (0..=u16::MAX).map(|value| linear_from_srgb(linear(value))).collect());
        let curve = |value: u16| match &table {
            Some(table) => table[usize::from(value)],
            None => linear_from_srgb(linear(value)),
        };
        texels.iter().map(|&[r, g, b, a]| [curve(r), curve(g), curve(b), linear(a)]).collect()
    };
    Ok(Decoded {
        width,
        height,
        srgb: source.srgb.then(|| Texels::Rgba32F(as_colors())),
        linear: source.linear.then(|| Texels::Rgba32F(as_numbers())),
    })
}
