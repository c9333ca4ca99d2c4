//! The chunks of an EXR: bands of lines, or tiles.

use exr::meta::BlockDescription;
use exr::meta::header::Header;

/// The largest chunk of a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LargestChunk {
    pub(crate) width: u64,
    pub(crate) height: u64,
    /// Samples of a pixel.
    pub(crate) channels: u64,
    /// Bytes of its samples.
    pub(crate) bytes: u64,
}

impl LargestChunk {
    pub(crate) fn new(header: &Header) -> Self {
        let size = header.max_block_pixel_size();
        let (width, mut height) = (size.x() as u64, size.y() as u64);
        if matches!(header.blocks, BlockDescription::ScanLines) {
            height = height.min(header.layer_size.y() as u64);
        }
        let channels = &header.channels.list;
        let bytes_per_pixel: usize = channels.iter().map(|c| c.sample_type.bytes_per_sample()).sum();
        let bytes = width.saturating_mul(height).saturating_mul(bytes_per_pixel as u64);
        Self { width, height, channels: channels.len() as u64, bytes }
    }
}
