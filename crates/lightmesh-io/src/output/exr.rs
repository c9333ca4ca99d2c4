//! OpenEXR files: linear floating point with the camera's matrices.

use std::io::{self, Seek, Write};

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AttributeValue, Encoding, Image as ExrImage, IntegerBounds, Layer as ExrLayer, LayerAttributes, Text, Vec2,
    WritableImage,
};
use glam::{DMat4, DVec3};
use lightmesh::{Camera, Image, Layer, Projection};

use super::{Metadata, exr_channels::Channels};
use crate::exr_file::may_make_threads;

/// Bits of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit float.
    #[default]
    Single,
    /// 16-bit float: 11 bits of precision; values above 65,504 cd/m² are clamped to it.
    Half,
}

/// Writes the picture as channels R, G, B and `layers` as channels with their names before them (`normal.X`), all in
/// one part, ZIP-compressed scan lines. The depth is 32-bit float whatever the precision: 11 bits are too few to
/// compute with, and half cannot hold [`lightmesh::Aov::FAR_M`].
///
/// Beside the standard attributes (`chromaticities` Rec. 709 with D65, `whiteLuminance` 1 because the values are cd/m²,
/// `software`, `worldToCamera`, `worldToNDC`, `screenWindowWidth`) it carries `method`, `scene`, `settings` (JSON),
/// `renderSeconds` and `samplesPerPixel`; and `denoiser` and `denoiseSeconds` where its noise was taken out.
///
/// # Errors
/// What `out` answers.
pub fn write_exr(
    out: impl Write + Seek,
    image: &Image,
    layers: &[Layer],
    precision: Precision,
    metadata: &Metadata,
) -> io::Result<()> {
    let size = Vec2(image.width as usize, image.height as usize);
    let channels = Channels::new(image, layers, precision);
    let layer = ExrLayer::new(size, attributes(image, metadata), Encoding::SMALL_LOSSLESS, channels);
    let mut file = ExrImage::from_layer(layer);
    file.attributes.display_window = IntegerBounds::from_dimensions(size);
    file.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    // The encoder makes threads of its own: leave them out where one thread was asked for.
    let writer = file.write();
    let writer = if may_make_threads() { writer } else { writer.non_parallel() };
    writer.to_buffered(out).map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// Every attribute of the layer.
fn attributes(image: &Image, metadata: &Metadata) -> LayerAttributes {
    let aspect = f64::from(image.width) / f64::from(image.height);
    let (camera_from_world, ndc_from_world) = matrices(&metadata.camera, aspect);
    let mut attributes = LayerAttributes {
        software_name: Some(text(&metadata.software)),
        white_luminance: Some(1.0),
        world_to_camera: Some(row_vector_layout(camera_from_world)),
        world_to_normalized_device: Some(row_vector_layout(ndc_from_world)),
        screen_window_width: (2.0 * half_height(&metadata.camera) * aspect) as f32,
        ..LayerAttributes::default()
    };
    let own = [
        ("method", AttributeValue::Text(text(&metadata.method))),
        ("scene", AttributeValue::Text(text(&metadata.scene))),
        ("settings", AttributeValue::Text(text(&metadata.settings))),
        ("renderSeconds", AttributeValue::F64(metadata.seconds)),
        ("samplesPerPixel", AttributeValue::I32(i32::try_from(metadata.spp).unwrap_or(i32::MAX))),
    ];
    attributes.other.extend(own.map(|(name, value)| (text(name), value)));
    if let Some(error) = metadata.estimated_error {
        attributes.other.insert(text("estimatedError"), AttributeValue::F64(error));
    }
    if let Some(denoised) = &metadata.denoised {
        attributes.other.insert(text("denoiser"), AttributeValue::Text(text(&denoised.by)));
        attributes.other.insert(text("denoiseSeconds"), AttributeValue::F64(denoised.seconds));
    }
    attributes
}

/// A string attribute; EXR's readers expect Latin-1, so other characters become `?`.
fn text(string: &str) -> Text {
    let latin: String = string.chars().map(|c| if u32::from(c) < 256 { c } else { '?' }).collect();
    Text::new_or_none(latin).unwrap_or_default()
}

/// `worldToCamera` and `worldToNDC` as OpenEXR defines them (ImfStandardAttributes.h): camera space is left-handed with
/// +x to the right, +y up and +z ahead; NDC has (0, 0) in the upper left and (1, 1) in the lower right corner of the
/// picture, after division by w.
fn matrices(camera: &Camera, aspect: f64) -> (DMat4, DMat4) {
    // The camera's frame without its scale, as the renderer uses it.
    let m = camera.world_from_camera;
    let axis = |v: DVec3, fallback: DVec3| v.normalize_or(fallback);
    let world_from_frame = DMat4::from_cols(
        axis(m.matrix3.x_axis, DVec3::X).extend(0.0),
        axis(m.matrix3.y_axis, DVec3::Y).extend(0.0),
        axis(m.matrix3.z_axis, DVec3::Z).extend(0.0),
        m.translation.extend(1.0),
    );
    let camera_from_world = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * world_from_frame.inverse();

    // Half the window's size: at distance 1 for a pinhole, anywhere for parallel rays.
    let (y, x) = (half_height(camera), half_height(camera) * aspect);
    let ndc_from_camera = match camera.projection {
        // (½ + X / (2 x Z), ½ − Y / (2 y Z)) with w = Z.
        Projection::Perspective { .. } => DMat4::from_cols_array_2d(&[
            [0.5 / x, 0.0, 0.0, 0.0],
            [0.0, -0.5 / y, 0.0, 0.0],
            [0.5, 0.5, 1.0, 1.0],
            [0.0, 0.0, 0.0, 0.0],
        ]),
        Projection::Orthographic { .. } => DMat4::from_cols_array_2d(&[
            [0.5 / x, 0.0, 0.0, 0.0],
            [0.0, -0.5 / y, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.5, 0.5, 0.0, 1.0],
        ]),
    };
    (camera_from_world, ndc_from_camera * camera_from_world)
}

/// Half the picture's height: at distance 1 for a pinhole, in metres for parallel rays.
fn half_height(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Perspective { yfov, .. } => libm::tan(0.5 * f64::from(yfov)),
        Projection::Orthographic { ymag, .. } => f64::from(ymag),
    }
}

/// OpenEXR stores matrices for row vectors, row by row: the same sixteen numbers as ours, which are for column vectors,
/// column by column.
fn row_vector_layout(m: DMat4) -> [f32; 16] {
    m.to_cols_array().map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A film position, turned into a ray by the renderer's camera, comes back through worldToNDC.
    #[test]
    fn world_to_ndc_inverts_the_cameras_rays() {
        let pinhole = Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::new(0.0, 1.0, 0.5), 0.7);
        let parallel = Camera { projection: Projection::Orthographic { xmag: 2.0, ymag: 1.0 }, ..pinhole.clone() };
        for camera in [pinhole, parallel] {
            let film = camera.film(300, 200);
            let (camera_from_world, ndc_from_world) = matrices(&camera, 1.5);
            for (x, y) in [(0.0, 0.0), (300.0, 200.0), (30.0, 170.0)] {
                let ray = film.ray(x, y);
                let p = (ray.origin + 4.0 * ray.direction).as_dvec3();
                let ndc = ndc_from_world * p.extend(1.0);
                let (u, v) = (ndc.x / ndc.w, ndc.y / ndc.w);
                assert!((u - f64::from(x) / 300.0).abs() < 1e-5 && (v - f64::from(y) / 200.0).abs() < 1e-5);
                assert!((camera_from_world * p.extend(1.0)).z > 0.0);
            }
        }
    }

    #[test]
    fn names_outside_latin_1_do_not_stop_a_picture() {
        assert_eq!(text("Küche 厨房").to_string(), "Küche ??");
    }
}
