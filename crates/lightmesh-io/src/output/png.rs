//! PNG files: 8-bit sRGB.

use std::io::{self, Write};

use lightmesh::Image;
use rayon::prelude::*;

use super::{Metadata, expose, srgb_from_linear, tone_map};

/// Writes the picture, exposed by `ev` ([`expose`]), tone mapped ([`tone_map`]) and sRGB-encoded.
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
    for (keyword, text) in texts {
        encoder.add_itxt_chunk(keyword.to_owned(), text)?;
    }

    let bytes: Vec<[u8; 3]> = image.pixels.par_iter().map(|&p| byte_rgb(tone_map(expose(p, ev)))).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes.as_flattened())?;
    writer.finish()?;
    Ok(())
}

/// The sRGB bytes of a display-linear colour, rounded to nearest.
fn byte_rgb(color: glam::Vec3) -> [u8; 3] {
    color.to_array().map(|c| (255.0 * srgb_from_linear(c) + 0.5) as u8)
}
