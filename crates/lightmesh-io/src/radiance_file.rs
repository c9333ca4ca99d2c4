//! Radiance pictures (`.hdr`, RGBE).

use std::fs::File;
use std::io::{BufReader, Read, Seek};

use glam::Vec3;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use lightmesh::Image;

use crate::budget::Budget;
use crate::error::Error;
use crate::picture_file::PictureFile;

/// The longest header, bytes. Programs write a few lines; the decoder keeps them all.
const LONGEST_HEADER: u64 = 1 << 16;

/// Reads a picture whose rows go from left to right and down, run-length encoded or not. EXPOSURE and COLORCORR of the
/// header are undone, as the format says. What is allocated is paid from `budget` first.
pub(crate) fn read(file: &PictureFile, mut reader: BufReader<File>, budget: &mut Budget) -> Result<Image, Error> {
    let damaged = |error: image::ImageError| file.invalid(format_args!("not a readable Radiance picture: {error}"));

    // Read the header: "#?" and a program's name, lines of settings, an empty line, the size.
    let mut start = Vec::new();
    reader.by_ref().take(LONGEST_HEADER).read_to_end(&mut start).map_err(|cause| file.unreadable(cause))?;
    if !start.starts_with(b"#?") {
        return Err(file.invalid("is no Radiance picture: it does not begin with #?"));
    }
    let size_line = start.windows(2).position(|pair| pair == b"\n\n").map(|at| &start[at + 2..]);
    if !size_line.is_some_and(|rest| rest.contains(&b'\n')) {
        return Err(file.invalid(format_args!(
            "is no readable Radiance picture: its header does not end within {LONGEST_HEADER} bytes; is it cut off?"
        )));
    }

    // Read the size, refuse more than is allowed or than the file can hold, and pay for it.
    reader.rewind().map_err(|cause| file.unreadable(cause))?;
    let decoder = HdrDecoder::new_nonstrict(reader).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(file.invalid(format_args!("its header says {width}x{height}: there is no pixel")));
    }
    file.check_size(width.into(), height.into())?;
    // Runs of runs may hold a row in little, but its first pixel takes four bytes.
    let least = 4 * u64::from(height);
    if least > file.length {
        let length = file.length;
        let what = format_args!("its header announces {height} rows, which its {length} bytes cannot hold");
        return Err(file.invalid(what));
    }
    let pixels = u64::from(width) * u64::from(height);
    budget.take(&file.name, "the picture's samples", pixels, 12)?;
    budget.take(&file.name, "the picture", pixels, size_of::<Vec3>() as u64)?;

    // What the header's factors multiplied is divided by them; one without a meaning is left out.
    let settings = decoder.metadata();
    let sane = |factor: f32| if factor > 0.0 && factor.is_finite() { factor } else { 1.0 };
    let (r, g, b) = settings.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let factor = Vec3::new(sane(r), sane(g), sane(b)) * sane(settings.exposure.unwrap_or(1.0));
    let mut samples = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut samples).map_err(damaged)?;
    let value = |bytes: &[u8; 4]| f32::from_ne_bytes(*bytes);
    let (samples, _) = samples.as_chunks::<4>();
    let (triples, _) = samples.as_chunks::<3>();
    let pixels = triples.iter().map(|[r, g, b]| Vec3::new(value(r), value(g), value(b)) / factor).collect();
    Ok(Image::new(width, height, pixels))
}
