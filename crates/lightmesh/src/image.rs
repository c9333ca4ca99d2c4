//! The finished picture, and statistics of its rendering.

use glam::{Vec3, Vec4};

/// A linear picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB, cd/m², row by row from the upper left.
    pub pixels: Vec<Vec3>,
    /// What a display needs to know of the pixels; empty for a picture that was not rendered.
    pub display: DisplayData,
}

impl Image {
    /// Returns a picture of pixels of which nothing else is known.
    pub fn new(width: u32, height: u32, pixels: Vec<Vec3>) -> Self {
        Self { width, height, pixels, display: DisplayData::default() }
    }
}

/// What a picture for a display needs beside the light: which part of a pixel has a colour that no exposure changes, and
/// how bright it is where the camera stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplayData {
    /// By pixel, the colour that unlit surfaces show there, linear, times the part of the pixel that they cover, and
    /// this part. The colour is a part of the pixel's light, 1 as 1 cd/m². Empty where no surface is unlit.
    pub unlit: Vec<Vec4>,
    /// Luminance of a white surface in the light about the camera, cd/m², a mean over what is seen from there; `None` where
    /// that is not known.
    pub white_cd_m2: Option<f32>,
}

/// Wall-clock seconds of the steps of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Seconds {
    /// Tracing camera rays.
    pub primary: f64,
    /// Finding the mesh points that the picture reads.
    pub demand: f64,
    /// Evaluating direct mesh points.
    pub fill_direct: f64,
    /// Evaluating indirect mesh points.
    pub fill_indirect: f64,
    /// Interpolation, light sums, shadow rays at pixels, mirrored and refracted rays.
    pub shade: f64,
    /// Everything between the built scene and the finished linear picture.
    pub render: f64,
}

/// Rays traced, by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RayCounts {
    /// Through the camera's film.
    pub primary: u64,
    /// From a hit or a mesh point to a light.
    pub shadow: u64,
    /// From indirect mesh points, or a path's diffuse bounces.
    pub gather: u64,
    /// Reflected, refracted and transmitted rays, rays between mesh points and the surfaces that read them, and the short
    /// rays of [`MeshOptions::near_rays`](crate::MeshOptions::near_rays).
    pub secondary: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.gather += other.gather;
        self.secondary += other.secondary;
    }
}

impl RayCounts {
    /// The sum of all purposes.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.gather + self.secondary
    }
}

/// Statistics of the direct or the indirect mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshStats {
    /// Distance between neighbouring points, metres.
    pub spacing_m: f64,
    /// How many points have been evaluated, so far and on all levels.
    pub points_used: u64,
    /// How many of these are on levels that a picture has refined.
    pub points_refined: u64,
    /// How many points the scene's whole box would have, where nothing is refined.
    pub points_total: u64,
    /// How many evaluated points are invalid, inside a closed object.
    pub points_invalid: u64,
    /// Memory held, bytes.
    pub bytes: u64,
}

impl std::ops::AddAssign for Seconds {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.demand += other.demand;
        self.fill_direct += other.fill_direct;
        self.fill_indirect += other.fill_indirect;
        self.shade += other.shade;
        self.render += other.render;
    }
}

/// What verification by paths found out about a picture whose error is bounded. Errors are root mean squares over the
/// verified pixels, relative to the mean of their light, at the picture's own samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ErrorEstimate {
    /// Of all light.
    pub all: f64,
    /// Of direct light and emission alone.
    pub direct: f64,
    /// How far `all` may be off, because the paths have noise: one standard deviation.
    pub uncertainty: f64,
    /// Mean of the picture's light over that of the paths, less 1.
    pub bias: f64,
    /// The part of all light that diffuse surfaces receive by way of mirrors and glass (caustics), by paths.
    pub caustics: f64,
    /// Samples per pixel with which [`Method::Path`](crate::Method::Path) would keep the bound, by the noise of the
    /// paths; 0 where they had none.
    pub path_spp: u64,
}

/// Statistics of one frame: time, rays, and the state of the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RenderStats {
    /// Samples that every pixel has; fewer than [`PictureOptions::spp`](crate::PictureOptions::spp) if the time
    /// limit was reached: some pixels may then have an eighth more, or one more. Pixels on emitter edges have more
    /// (64).
    pub spp: u32,
    /// Whether the time limit ended the rendering before all samples were taken.
    pub time_limit_reached: bool,
    /// Time by step.
    pub seconds: Seconds,
    /// Rays by purpose.
    pub rays: RayCounts,
    /// The direct mesh after the frame.
    pub direct: MeshStats,
    /// The indirect mesh after the frame.
    pub indirect: MeshStats,
    /// Surface points at which no point of the direct mesh was usable, so that shadow rays were traced.
    pub exact_fallbacks: u64,
    /// Surface points at which no point of the indirect mesh was usable, so that gather rays were traced.
    pub gather_fallbacks: u64,
    /// The picture's error by the noise of its pixels, relative to its mean, where samples follow it
    /// ([`PictureOptions::most_spp`](crate::PictureOptions::most_spp)).
    pub sampling_error: Option<f64>,
    /// How many of the shadow rays were traced from mesh points.
    pub fill_shadow_rays: u64,
    /// The estimated error of the picture, RMS relative to its mean, if
    /// the error of [`Method::Mesh`](crate::Method::Mesh) is set; 0: its light is exact.
    pub estimated_error: Option<f64>,
    /// How that error was found, and what it is made of.
    pub error_estimate: Option<ErrorEstimate>,
    /// The estimated light of bounces after the last one, as a part of all light; `None` without an estimate.
    pub truncated_light: Option<f64>,
    /// Pixels whose light or layers were infinite or not a number, and are black.
    #[cfg_attr(feature = "serde", serde(default))]
    pub non_finite_pixels: u64,
}

impl RenderStats {
    /// Adds the statistics of a part of the same frame: seconds, rays and counts.
    pub(crate) fn add(&mut self, part: &Self) {
        self.seconds += part.seconds;
        self.rays += part.rays;
        self.exact_fallbacks += part.exact_fallbacks;
        self.gather_fallbacks += part.gather_fallbacks;
        self.fill_shadow_rays += part.fill_shadow_rays;
        self.estimated_error = self.estimated_error.or(part.estimated_error);
        self.error_estimate = self.error_estimate.or(part.error_estimate);
    }
}
