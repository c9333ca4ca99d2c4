//! Pictures of every format and kind of colour that textures have.

use std::io::Cursor;

use image::{DynamicImage, ImageBuffer, ImageFormat};

use super::Seed;

pub(crate) fn seeds() -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (kind, picture) in kinds() {
        seeds.push(Seed::new(format!("{kind}.png"), encoded(&picture, ImageFormat::Png)));
        if matches!(kind, "rgb8" | "rgba8") {
            seeds.push(Seed::new(format!("{kind}.webp"), encoded(&picture, ImageFormat::WebP)));
        }
        if matches!(kind, "rgb8" | "l8") {
            seeds.push(Seed::new(format!("{kind}.jpg"), encoded(&picture, ImageFormat::Jpeg)));
        }
    }
    seeds
}

/// A picture of 8 × 5 pixels, PNG.
pub(crate) fn small_png() -> Vec<u8> {
    encoded(&rgba(8, 5), ImageFormat::Png)
}

fn rgba(width: u32, height: u32) -> DynamicImage {
    let texels = (0..width * height * 4).map(|i| (i * 37 % 251) as u8).collect();
    DynamicImage::ImageRgba8(ImageBuffer::from_raw(width, height, texels).expect("as many texels"))
}

fn kinds() -> [(&'static str, DynamicImage); 6] {
    let picture = rgba(9, 5);
    [
        ("l8", DynamicImage::ImageLuma8(picture.to_luma8())),
        ("la8", DynamicImage::ImageLumaA8(picture.to_luma_alpha8())),
        ("rgb8", DynamicImage::ImageRgb8(picture.to_rgb8())),
        ("rgba8", picture.clone()),
        ("rgb16", DynamicImage::ImageRgb16(picture.to_rgb16())),
        ("rgba16", DynamicImage::ImageRgba16(picture.to_rgba16())),
    ]
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("a picture in memory");
    bytes.into_inner()
}
