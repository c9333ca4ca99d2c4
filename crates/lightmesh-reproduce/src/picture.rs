//! Pictures for the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use lightmesh::{Camera, Image};
use lightmesh_io::output::{Metadata, exposure_of, write_png};

use crate::error::Error;
use crate::report::{Figure, Panel};

/// Encodes bytes as a data URI.
pub(crate) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// Makes a figure of pictures beside each other, all with the exposure that suits the last one.
pub(crate) fn figure(caption: &str, pictures: &[(&str, &Image)]) -> Result<Figure, Error> {
    let ev = pictures.last().map_or(0.0, |(_, image)| exposure_of(image));
    let panels = pictures.iter().map(|(label, image)| panel(label, image, ev)).collect::<Result<_, _>>()?;
    Ok(Figure { caption: caption.to_owned(), panels })
}

/// Makes a panel of a picture at an exposure, in EV.
fn panel(label: &str, image: &Image, ev: f32) -> Result<Panel, Error> {
    let metadata = Metadata {
        software: format!("lightmesh {}", env!("CARGO_PKG_VERSION")),
        method: String::new(),
        scene: label.to_owned(),
        settings: String::new(),
        seconds: 0.0,
        estimated_error: None,
        spp: 1,
        denoised: None,
        camera: Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0),
    };
    let mut png = Vec::new();
    write_png(&mut png, image, ev, &metadata).map_err(|cause| Error::Io { path: label.into(), cause })?;
    Ok(Panel { label: label.to_owned(), image: data_uri("image/png", &png) })
}

/// A rectangle of pixels, or of fractions of the picture's size.
#[derive(Clone, Copy)]
pub(crate) struct Rect<T> {
    pub(crate) left: T,
    pub(crate) top: T,
    pub(crate) width: T,
    pub(crate) height: T,
}

impl Rect<f32> {
    /// Converts fractions of a picture's size, (width, height), to pixels.
    pub(crate) fn to_pixels(self, size: (u32, u32)) -> Rect<u32> {
        let pixels = |fraction: f32, all: u32| (fraction * all as f32) as u32;
        Rect {
            left: pixels(self.left, size.0),
            top: pixels(self.top, size.1),
            width: pixels(self.width, size.0),
            height: pixels(self.height, size.1),
        }
    }
}

/// Cuts out a part of a picture, as far as it lies in the picture, and makes each of its pixels `times` as large.
pub(crate) fn enlarged(image: &Image, part: Rect<u32>, times: u32) -> Image {
    let left = part.left.min(image.width.saturating_sub(1));
    let top = part.top.min(image.height.saturating_sub(1));
    let (width, height) = (part.width.clamp(1, image.width - left), part.height.clamp(1, image.height - top));
    let pixel = |i: u32| {
        let (x, y) = (left + i % (width * times) / times, top + i / (width * times) / times);
        image.pixels[(y * image.width + x) as usize]
    };
    let (width_out, height_out) = (width * times, height * times);
    Image::new(width_out, height_out, (0..width_out * height_out).map(pixel).collect())
}

/// Returns the luminance (Rec. 709), cd/m².
pub(crate) fn luminance(color: Vec3) -> f64 {
    f64::from(color.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enlarging_repeats_pixels() {
        let pixels = (0..6).map(|i| Vec3::splat(i as f32)).collect();
        let image = Image::new(3, 2, pixels);
        let part = enlarged(&image, Rect { left: 1, top: 1, width: 5, height: 5 }, 2);
        assert_eq!((part.width, part.height), (4, 2));
        assert_eq!(part.pixels.iter().map(|p| p.x).collect::<Vec<_>>(), [4.0, 4.0, 5.0, 5.0, 4.0, 4.0, 5.0, 5.0]);
    }
}
