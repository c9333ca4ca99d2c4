//! Environment maps from files.

use std::path::Path;

use glam::Vec3;
use lightmesh::{Image, ImageData, Texels};

use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::picture_file::PictureFile;
use crate::warnings::Warnings;
use crate::{exr_file, radiance_file};

/// The largest value of a 16-bit float: what an infinite texel once was at least.
const LARGEST_HALF: f32 = 65504.0;

/// A latitude-longitude map as [`Environment::map`](lightmesh::Environment::map) takes it.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    /// Linear RGB, finite and not negative; alpha is 1.
    pub map: ImageData,
    /// What was mended or looks odd, one sentence each.
    pub warnings: Vec<String>,
}

/// Reads a latitude-longitude map: Radiance (`.hdr`) or OpenEXR (`.exr`, channels R G B or Y), by its extension. Its
/// middle is +X, its top +Y. Texels that are negative or no number become 0, infinite ones 65504, with a warning.
///
/// At most about `max_memory` bytes are allocated, after the header was held against the file's length.
///
/// # Errors
/// If the extension is another; if the file is missing, damaged or cut off, has no colour, more than 2²⁸ pixels, or
/// needs more memory than that.
pub fn read_environment(path: &Path, max_memory: u64) -> Result<EnvironmentMap, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let read = match extension.as_str() {
        "hdr" => radiance_file::read,
        "exr" => exr_file::read,
        _ => return Err(Error::EnvironmentFormat { file: one_line(path.display()) }),
    };
    let mut budget = Budget::new(max_memory);
    let (file, reader) = PictureFile::open(path)?;
    let image = read(&file, reader, &mut budget)?;
    // The texels, and their copy behind a shared pointer.
    budget.take(&file.name, "the environment map", image.pixels.len() as u64, 2 * size_of::<[f32; 4]>() as u64)?;
    Ok(mend(file.name, image))
}

/// Makes every texel a radiance.
fn mend(name: String, image: Image) -> EnvironmentMap {
    let Image { width, height, pixels, .. } = image;
    // Replace values that are no radiance.
    let (mut dark, mut infinite) = (Mended::default(), Mended::default());
    let mut texels = Vec::with_capacity(pixels.len());
    for (i, pixel) in pixels.into_iter().enumerate() {
        let is_dark = |c: f32| c.is_nan() || c < 0.0;
        if pixel.to_array().into_iter().any(is_dark) {
            dark.add(i);
        } else if !pixel.is_finite() {
            infinite.add(i);
        }
        let c = Vec3::from_array(pixel.to_array().map(|c| if is_dark(c) { 0.0 } else { c }));
        let [r, g, b] = c.to_array().map(|c| if c == f32::INFINITY { LARGEST_HALF } else { c });
        texels.push([r, g, b, 1.0]);
    }

    // Warn of what was replaced, and of what looks odd.
    let mut warnings = Warnings::default();
    let mut warn = |mended: Mended, message: &str| {
        if let Some(first) = mended.first {
            let place = format_args!("{name}, texel ({}, {})", first % width as usize, first / width as usize);
            warnings.add_many(place, message, mended.count);
        }
    };
    warn(dark, "a value is negative or no number: it is taken as 0");
    warn(infinite, "a value is infinite: it is taken as 65504, the largest 16-bit float");
    if width != 2 * height {
        let what = "a latitude-longitude map is twice as wide as high; is it another projection?";
        warnings.add(format_args!("{name}, {width}x{height}"), what);
    }
    let map = ImageData { name, width, height, texels: Texels::Rgba32F(texels.into()) };
    EnvironmentMap { map, warnings: warnings.into_sentences() }
}

/// The number of texels that were mended, and the first of them.
#[derive(Clone, Copy, Debug, Default)]
struct Mended {
    first: Option<usize>,
    count: u64,
}

impl Mended {
    fn add(&mut self, texel: usize) {
        self.first = self.first.or(Some(texel));
        self.count += 1;
    }
}
