//! The channels of an EXR, taken from a picture and its layers as they lie in memory.

use exr::{
    block::{BlockIndex, UncompressedBlock},
    image::write::channels::{ChannelsWriter, WritableChannels},
    math::RoundingMode,
    meta::{
        attribute::{ChannelDescription, ChannelList, LevelMode, SampleType},
        header::Header,
    },
    prelude::{Text, f16},
};
use glam::Vec3;
use lightmesh::{Aov, Image, Layer};

use super::Precision;

/// Every channel, in the order that OpenEXR wants: by name.
#[derive(Clone, Debug)]
pub(super) struct Channels<'a> {
    width: usize,
    list: Vec<(String, Precision, Values<'a>)>,
}

/// The values of a channel.
#[derive(Clone, Copy, Debug)]
enum Values<'a> {
    /// A component of each pixel.
    Pixels(&'a [Vec3], usize),
    /// Every `stride`-th value from the `first` on.
    Strided { values: &'a [f32], first: usize, stride: usize },
}

impl Values<'_> {
    /// The value of the i-th pixel.
    fn at(self, i: usize) -> f32 {
        match self {
            Self::Pixels(pixels, component) => pixels[i][component],
            Self::Strided { values, first, stride } => values[i * stride + first],
        }
    }
}

impl<'a> Channels<'a> {
    pub(super) fn new(image: &'a Image, layers: &'a [Layer], precision: Precision) -> Self {
        let mut list = Vec::new();
        for (component, name) in ["R", "G", "B"].into_iter().enumerate() {
            list.push((name.to_owned(), precision, Values::Pixels(&image.pixels, component)));
        }
        for Layer { aov, values } in layers {
            let names = aov.channels();
            let precision = if *aov == Aov::Depth { Precision::Single } else { precision };
            for (first, name) in names.iter().enumerate() {
                let values = Values::Strided { values, first, stride: names.len() };
                list.push((format!("{}.{name}", aov.name()), precision, values));
            }
        }
        list.sort_by(|a, b| a.0.cmp(&b.0));
        Self { width: image.width as usize, list }
    }
}

impl WritableChannels<'_> for Channels<'_> {
    type Writer = Self;

    fn infer_channel_list(&self) -> ChannelList {
        let describe = |(name, precision, _): &(String, Precision, Values<'_>)| {
            let sample_type = match precision {
                Precision::Single => SampleType::F32,
                Precision::Half => SampleType::F16,
            };
            ChannelDescription::named(Text::from(name.as_str()), sample_type)
        };
        ChannelList::new(self.list.iter().map(describe).collect())
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&self, _: &Header) -> Self {
        self.clone()
    }
}

impl ChannelsWriter for Channels<'_> {
    fn extract_uncompressed_block(&self, header: &Header, block: BlockIndex) -> Vec<u8> {
        UncompressedBlock::collect_block_data_from_lines(&header.channels, block, |line| {
            let location = line.location;
            let (_, precision, values) = &self.list[location.channel];
            let start = location.position.y() * self.width + location.position.x();
            let values = (start..start + location.sample_count).map(|i| values.at(i));
            // Native byte order, as the encoder expects of uncompressed blocks.
            match precision {
                Precision::Single => {
                    for (bytes, value) in line.value.chunks_exact_mut(4).zip(values) {
                        bytes.copy_from_slice(&value.to_ne_bytes());
                    }
                }
                Precision::Half => {
                    for (bytes, value) in line.value.chunks_exact_mut(2).zip(values) {
                        bytes.copy_from_slice(&f16::from_f32(value.min(f16::MAX.to_f32())).to_ne_bytes());
                    }
                }
            }
        })
    }
}
