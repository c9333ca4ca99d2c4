//! EXR's lossy compression DWAA and DWAB, whose chunks say how much is to be unpacked.

use std::fs::File;
use std::io::BufReader;

use exr::block::chunk::CompressedBlock;
use exr::prelude::Compression;

use crate::error::Error;
use crate::exr_chunk::LargestChunk;
use crate::picture_file::PictureFile;

/// The edge of the squares that are transformed, pixels.
const SQUARE: u64 = 8;

/// Whether a layer is compressed so.
pub(crate) fn is_dwa(compression: Compression) -> bool {
    matches!(compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// The most bytes that decoding such a chunk takes.
pub(crate) fn decoder_bytes(chunk: &LargestChunk) -> u64 {
    let pixels = squares(chunk).saturating_mul(SQUARE * SQUARE);
    // Of the squares: three 32-bit floats for each pixel, flags, and coefficients as bytes and as 16-bit floats. Of the
    // samples: packed, unpacked by kind, by channel and by bytes, by line, in order, and what grows beside its copy.
    let floats = pixels.saturating_mul(13);
    let coefficients = pixels.saturating_mul(chunk.channels).saturating_mul(4);
    floats.saturating_add(coefficients).saturating_add(chunk.bytes.saturating_mul(8))
}

/// Refuses chunks that announce more than their place in the picture holds: the library allocates what they say.
pub(crate) fn check_chunks(file: &PictureFile, reader: &mut BufReader<File>) -> Result<(), Error> {
    let unreadable = |error: exr::error::Error| file.invalid(format_args!("not a readable EXR: {error}"));
    let chunks = exr::block::read(reader, false).map_err(unreadable)?;
    let headers = chunks.meta_data().headers.clone();
    for chunk in chunks.all_chunks(false).map_err(unreadable)? {
        let chunk = chunk.map_err(unreadable)?;
        let Some(header) = headers.get(chunk.layer_index).filter(|header| is_dwa(header.compression)) else {
            continue;
        };
        let stored = match &chunk.compressed_block {
            CompressedBlock::ScanLine(lines) => &lines.compressed_pixels_le,
            CompressedBlock::Tile(tile) => &tile.compressed_pixels_le,
            CompressedBlock::DeepScanLine(_) | CompressedBlock::DeepTile(_) => continue,
        };
        // What would not become shorter is stored as it is.
        let raw = header
            .get_block_data_indices(&chunk.compressed_block)
            .and_then(|tile| header.get_absolute_block_pixel_coordinates(tile))
            .map(|place| place.size.area().saturating_mul(header.channels.bytes_per_pixel));
        if raw.is_ok_and(|bytes| bytes == stored.len()) {
            continue;
        }
        let most = Counters::most(&LargestChunk::new(header));
        if Counters::read(stored).is_some_and(|counters| counters.exceed(&most)) {
            return Err(file.invalid("not a readable EXR: a chunk announces more than its place in the picture holds"));
        }
    }
    Ok(())
}

/// What a chunk announces before its data: of eleven 64-bit numbers, those that say how much is to be unpacked.
#[derive(Clone, Copy, Debug)]
struct Counters {
    /// Bytes of samples that are only deflated.
    deflated: u64,
    /// Bytes of run-length encoded samples, inflated.
    runs: u64,
    /// The same, unpacked.
    run_samples: u64,
    /// Coefficients of the squares without the first of each.
    others: u64,
    /// First coefficients of the squares.
    firsts: u64,
}

impl Counters {
    /// Reads them; `None` where the chunk is too short to have them.
    fn read(chunk: &[u8]) -> Option<Self> {
        let (numbers, _) = chunk.as_chunks::<8>();
        let &[_, deflated, _, _, _, _, runs, run_samples, others, firsts, _] = numbers.first_chunk::<11>()?;
        let [deflated, runs, run_samples, others, firsts] =
            [deflated, runs, run_samples, others, firsts].map(u64::from_le_bytes);
        Some(Self { deflated, runs, run_samples, others, firsts })
    }

    /// The most that a chunk has a use for. Packed in runs, no byte takes more than two.
    fn most(chunk: &LargestChunk) -> Self {
        let bytes = chunk.bytes;
        let squares = squares(chunk).saturating_mul(chunk.channels);
        Self {
            deflated: bytes,
            runs: bytes.saturating_mul(2),
            run_samples: bytes,
            others: squares.saturating_mul(SQUARE * SQUARE),
            firsts: squares,
        }
    }

    fn exceed(&self, most: &Self) -> bool {
        self.deflated > most.deflated
            || self.runs > most.runs
            || self.run_samples > most.run_samples
            || self.others > most.others
            || self.firsts > most.firsts
    }
}

/// The squares that cover a chunk.
fn squares(chunk: &LargestChunk) -> u64 {
    chunk.width.div_ceil(SQUARE).saturating_mul(chunk.height.div_ceil(SQUARE))
}
