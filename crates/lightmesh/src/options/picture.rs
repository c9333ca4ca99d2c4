//! The picture's size, samples and layers, and the memory that they take.

use std::time::Duration;

use super::{Aovs, Method, RenderOptions};
use crate::Error;

/// The picture's size, samples and layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Samples per pixel, box filter of one pixel, 1 to 65536; 1 samples the pixel's centre. With a time limit, the
    /// most.
    pub spp: u32,
    /// The most samples of a pixel, up to 65536: those with most noise get four and sixteen times as many as
    /// [`Self::spp`], and so on, until the noise of the picture is about half of its error bound, or 2.5% of its mean. `None`:
    /// every pixel has the same number, as always with the methods [`Path`](super::Method::Path) and
    /// [`Unbiased`](super::Method::Unbiased), with a time limit, and in the parts of a distributed picture.
    pub most_spp: Option<u32>,
    /// Render time, from the built scene, after which no more samples are taken, above 0; `None`: all are. Every pixel
    /// gets one sample however long that takes. How many there are in time depends on the machine and what else it
    /// does, and so does the picture; where the limit is not reached, last bits may differ from the picture without a
    /// limit, as sums are rounded in another order.
    pub time_limit: Option<Duration>,
    /// Layers that the picture gets beside its light.
    pub aovs: Aovs,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { width: 1280, height: 720, spp: 4, most_spp: None, time_limit: None, aovs: Aovs::default() }
    }
}

impl PictureOptions {
    /// The most samples that a pixel can have, and what a time limit allows where no number is said.
    pub const MOST_SPP: u32 = 1 << 16;

    pub(super) const EXPECTED_SIZE: &'static str = "WIDTHxHEIGHT, whole pixels above 0, as in 1280x720";
    pub(super) const EXPECTED_SECONDS: &'static str = "seconds above 0, as in 10 or 0.5";

    /// Returns width and height of a text as `640x360`.
    pub fn parse_size(text: &str) -> Option<(u32, u32)> {
        let side = |text: &str| text.parse().ok().filter(|&n: &u32| n > 0);
        text.split_once(['x', 'X']).and_then(|(w, h)| Some((side(w)?, side(h)?)))
    }

    /// Returns a time above 0 of a text that is a number of seconds; a nanosecond is the least.
    pub fn parse_seconds(text: &str) -> Option<Duration> {
        let seconds = text.parse().ok().filter(|s: &f64| *s > 0.0);
        seconds.and_then(|s| Duration::try_from_secs_f64(s).ok()).filter(|limit| !limit.is_zero())
    }
}

impl RenderOptions {
    /// Returns the most samples of a pixel, where some get more than others.
    pub(crate) fn most_spp(&self) -> Option<u32> {
        let PictureOptions { spp, most_spp, time_limit, .. } = self.picture;
        let follows_noise = !matches!(self.method, Method::Path | Method::Unbiased { .. });
        // Noise shows in how two parts of a pixel's samples differ.
        most_spp.filter(|&most| most > spp && spp >= 2 && follows_noise && time_limit.is_none())
    }

    /// For the film, the finished picture and its 8-bit copy.
    const BYTES_PER_PIXEL: u64 = 12 + 4 + 1 + 12 + 3;
    /// For the first part of the samples, their noise, and the choice of pixels that get more.
    const NOISE_BYTES_PER_PIXEL: u64 = 12 + 4 + 4 + 4 + 4 + 1;
    /// For the colours of unlit surfaces, on the film, and in a picture that is shown meanwhile.
    const UNLIT_BYTES_PER_PIXEL: u64 = 16;

    /// Refuses a picture that the memory limit does not hold: 32 bytes a pixel for the film, the finished picture and
    /// its 8-bit copy, 29 where samples follow the noise, and what its layers take. Waves of rays take some 20 MiB beside it, whatever the size; the mesh
    /// and the scene are checked where they grow.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; nothing has been allocated.
    pub fn check_picture_memory(&self) -> Result<(), Error> {
        self.check_memory(Self::BYTES_PER_PIXEL, 0)
    }

    /// The same for a picture that a [`Viewer`](crate::Viewer) looks at: 19 bytes a pixel more, for the sketch, the
    /// picture that is shown and its 8-bit copy.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; nothing has been allocated.
    pub fn check_viewed_picture_memory(&self) -> Result<(), Error> {
        self.check_memory(Self::BYTES_PER_PIXEL + 4 + 12 + 3, 0)
    }

    /// [`RenderOptions::check_picture_memory`], or [`RenderOptions::check_viewed_picture_memory`], with what unlit
    /// surfaces take, if the scene has any; beside the `scene_bytes` of the scene.
    pub(crate) fn check_film_memory(&self, is_viewed: bool, has_unlit: bool, scene_bytes: u64) -> Result<(), Error> {
        let (viewed, copies) = if is_viewed { (4 + 12 + 3, 2) } else { (0, 1) };
        let unlit = if has_unlit { copies * Self::UNLIT_BYTES_PER_PIXEL } else { 0 };
        self.check_memory(Self::BYTES_PER_PIXEL + viewed + unlit, scene_bytes)
    }

    /// Memory of the picture, bytes.
    pub(crate) fn picture_bytes(&self, has_unlit: bool) -> u64 {
        let unlit = if has_unlit { Self::UNLIT_BYTES_PER_PIXEL } else { 0 };
        self.bytes_of_pixels(Self::BYTES_PER_PIXEL + unlit)
    }

    fn bytes_of_pixels(&self, bytes_per_pixel: u64) -> u64 {
        let PictureOptions { width, height, aovs, .. } = self.picture;
        let noise = if self.most_spp().is_some() { Self::NOISE_BYTES_PER_PIXEL } else { 0 };
        (u64::from(width) * u64::from(height)).saturating_mul(bytes_per_pixel + noise + aovs.bytes_per_pixel())
    }

    fn check_memory(&self, bytes_per_pixel: u64, scene_bytes: u64) -> Result<(), Error> {
        let PictureOptions { width, height, aovs, .. } = self.picture;
        let pixels = u64::from(width) * u64::from(height);
        let needed_bytes = self.bytes_of_pixels(bytes_per_pixel).saturating_add(scene_bytes);
        // Pixels are counted in 32 bits.
        if needed_bytes <= self.limits.max_memory && pixels <= u64::from(u32::MAX) {
            return Ok(());
        }
        Err(Error::OutOfMemory {
            what: if scene_bytes > 0 { "the scene and a picture of this size" } else { "a picture of this size" },
            needed_bytes,
            limit_bytes: self.limits.max_memory,
            advice: if aovs.is_empty() { "choose a smaller --size" } else { "choose a smaller --size or fewer --aov" },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_above_zero() {
        assert_eq!(PictureOptions::parse_size("640x360"), Some((640, 360)));
        assert_eq!(PictureOptions::parse_size("1X1"), Some((1, 1)));
        for bad in ["", "640", "0x10", "10x0", "-4x4", "4x4x4", "x", "1.5x2", "5000000000x1"] {
            assert_eq!(PictureOptions::parse_size(bad), None, "{bad}");
        }
    }

    #[test]
    fn time_limits_are_seconds_above_zero() {
        assert_eq!(PictureOptions::parse_seconds("10"), Some(Duration::from_secs(10)));
        assert_eq!(PictureOptions::parse_seconds("0.25"), Some(Duration::from_millis(250)));
        for bad in ["", "0", "-1", "1e-20", "nan", "inf", "1e30", "10s"] {
            assert_eq!(PictureOptions::parse_seconds(bad), None, "{bad}");
        }
    }
}
