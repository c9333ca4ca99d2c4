//! PNG files: 8-bit sRGB.

use std::io::{self, Write};

use lightmesh::Image;
use rayon::prelude::*;

use super::{Metadata, display, dither};

/// Writes the picture, exposed by `ev` ([`expose`](super::expose)), tone mapped ([`tone_map`](super::tone_map)),
/// sRGB-encoded and dithered. Unlit surfaces keep their colour.
///
/// # Errors
/// What `out` answers; also if the picture is larger than a PNG can be (2³¹ − 1 pixels a side).
pub fn write_png(out: impl Write, image: &Image, ev: f32, metadata: &Metadata) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let texts = [
        ("Software", metadata.software.clone()),
        ("Source", metadata.scene.clone()),
        ("Method", metadata.method.clone()),
        ("Settings", metadata.settings.clone()),
        ("Exposure", format!("{ev} EV")),
    ];
    let denoiser = metadata.denoised.iter().map(|denoised| ("Denoiser", denoised.by.clone()));
    for (keyword, text) in texts.into_iter().chain(denoiser) {
        encoder.add_itxt_chunk(keyword.to_owned(), text)?;
    }

    let width = image.width.max(1) as usize;
    let byte_rgb = |i: usize| {
        let color = display::color(image, i, ev);
        match display::is_unlit(image, i) {
            true => dither::nearest_bytes(color),
            false => dither::bytes(color, (i % width) as u32, (i / width) as u32),
        }
    };
    let bytes: Vec<[u8; 3]> = (0..image.pixels.len()).into_par_iter().map(byte_rgb).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes.as_flattened())?;
    writer.finish()?;
    Ok(())
}
