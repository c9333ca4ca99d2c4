//! The colour of an EXR.

use std::fs::File;
use std::io::{BufReader, Seek};
use std::panic::AssertUnwindSafe;

use exr::meta::header::Header;
use exr::prelude::{AnyChannels, FlatSamples, MetaData, ReadChannels, ReadLayers};
use glam::Vec3;
use lightmesh::Image;

use crate::budget::Budget;
use crate::error::Error;
use crate::exr_chunk::LargestChunk;
use crate::exr_dwa;
use crate::picture_file::PictureFile;

/// The most channels, in all layers.
const MAX_CHANNELS: usize = 1024;
/// The most bytes of samples that an EXR can hold per byte of its length. Its densest compression, PXR24, deflates
/// (1032 to 1) three of four bytes: 1376, rounded up.
const EXPANSION: u64 = 2048;

/// More threads than this are not made for a file.
const MOST_THREADS: usize = 1024;

/// Reads the first layer that has colour (R, G, B), else the first that has luminance (Y); alpha is left out. What is
/// allocated is paid from `budget` first.
pub(crate) fn read(file: &PictureFile, mut reader: BufReader<File>, budget: &mut Budget) -> Result<Image, Error> {
    let unreadable = |error: exr::error::Error| file.invalid(format_args!("not a readable EXR: {error}"));

    // Read the headers alone first.
    let meta = MetaData::read_from_buffered(&mut reader, false).map_err(unreadable)?;
    let announced = check(file, &meta)?;
    budget.take(&file.name, "the picture's samples", announced.sample_bytes, 1)?;
    budget.take(&file.name, "the picture", announced.largest_layer, size_of::<Vec3>() as u64)?;
    budget.take(&file.name, "the decoder", announced.decoder_bytes, 1)?;
    reader.rewind().map_err(|cause| file.unreadable(cause))?;
    if meta.headers.iter().any(|header| exr_dwa::is_dwa(header.compression)) {
        std::panic::catch_unwind(AssertUnwindSafe(|| exr_dwa::check_chunks(file, &mut reader)))
            .map_err(|_| contradicts(file))??;
        reader.rewind().map_err(|cause| file.unreadable(cause))?;
    }

    // Take the first layer that has colour, else the first that has luminance. The library's own threads would be beside
    // those that the user allows, and a panic of one of them ends the process.
    let decode = || {
        exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .non_parallel()
            .from_buffered(reader)
    };
    // The library's slices take chunks at their word, and one may name a place outside the picture.
    let image =
        std::panic::catch_unwind(AssertUnwindSafe(decode)).map_err(|_| contradicts(file))?.map_err(unreadable)?;
    let layer_with = |names: [&str; 3]| {
        image.layer_data.iter().find_map(|layer| {
            let [r, g, b] = names.map(|name| full_channel(&layer.channel_data, name));
            Some((layer.size, [r?, g?, b?]))
        })
    };
    let (size, [r, g, b]) = layer_with(["R", "G", "B"]).or_else(|| layer_with(["Y", "Y", "Y"])).ok_or_else(|| {
        let names: Vec<String> =
            image.layer_data.iter().flat_map(|l| &l.channel_data.list).map(|c| c.name.to_string()).collect();
        file.invalid(format_args!("has neither channels R, G, B nor Y, but {}", names.join(", ")))
    })?;

    // Convert its samples to 32-bit floats.
    let pixels =
        r.values_as_f32().zip(g.values_as_f32().zip(b.values_as_f32())).map(|(r, (g, b))| Vec3::new(r, g, b)).collect();
    Ok(Image::new(size.x() as u32, size.y() as u32, pixels))
}

fn contradicts(file: &PictureFile) -> Error {
    file.invalid("not a readable EXR: its chunks contradict its header")
}

/// Returns whether the library for EXR files may make threads of its own: as many as RAYON_NUM_THREADS says, or one for
/// each core.
pub(crate) fn may_make_threads() -> bool {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.trim().parse::<usize>().ok());
    rayon::current_num_threads() > 1 && asked.is_none_or(|count| count <= MOST_THREADS)
}

/// The sizes that headers announce.
#[derive(Clone, Copy, Debug)]
struct Announced {
    /// Bytes of the samples of all layers and channels.
    sample_bytes: u64,
    /// Pixels of the largest layer.
    largest_layer: u64,
    /// The most bytes that decoding a chunk takes: tiles may be larger than the picture.
    decoder_bytes: u64,
}

/// Refuses headers that announce more than is read, or than the file can hold.
fn check(file: &PictureFile, meta: &MetaData) -> Result<Announced, Error> {
    let mut announced = Announced { sample_bytes: 0, largest_layer: 0, decoder_bytes: 0 };
    let (mut channels, mut chunks) = (0_usize, 0_u64);
    for header in &meta.headers {
        let (width, height) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
        file.check_size(width, height)?;
        let bytes_per_pixel: usize = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample()).sum();
        channels += header.channels.list.len();
        chunks = chunks.saturating_add(header.chunk_count as u64);
        let bytes = (width * height).saturating_mul(bytes_per_pixel as u64);
        announced.sample_bytes = announced.sample_bytes.saturating_add(bytes);
        announced.largest_layer = announced.largest_layer.max(width * height);
        announced.decoder_bytes = announced.decoder_bytes.max(decoder_bytes(header));
    }
    if channels > MAX_CHANNELS {
        return Err(file.invalid(format_args!("has {channels} channels; at most {MAX_CHANNELS} are read")));
    }
    // Each chunk has its place in the offset table, 8 bytes, and begins with its coordinate and size, 8 more.
    let length = file.length;
    if chunks.saturating_mul(16) > length {
        let what = format_args!("its header announces {chunks} chunks, which its {length} bytes cannot hold");
        return Err(file.invalid(what));
    }
    file.check_samples(announced.sample_bytes, EXPANSION)?;
    Ok(announced)
}

/// The most bytes that decoding a chunk of a layer takes.
fn decoder_bytes(header: &Header) -> u64 {
    let chunk = LargestChunk::new(header);
    if exr_dwa::is_dwa(header.compression) {
        exr_dwa::decoder_bytes(&chunk)
    } else {
        // As it is stored, unpacked, put in order, and a buffer for that.
        chunk.bytes.saturating_mul(4)
    }
}

/// Returns the samples of a channel; `None` if it has not one per pixel.
fn full_channel<'a>(channels: &'a AnyChannels<FlatSamples>, name: &str) -> Option<&'a FlatSamples> {
    channels.list.iter().find(|c| c.name == *name && c.sampling == exr::prelude::Vec2(1, 1)).map(|c| &c.sample_data)
}
