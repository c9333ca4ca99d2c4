//! Metadata of picture files.

use lightmesh::Camera;

/// Written into picture files.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Program and version, as in `lightmesh 0.1.0`.
    pub software: String,
    /// How light was computed, as `--method` spells it.
    pub method: String,
    /// The scene file as the user named it.
    pub scene: String,
    /// Every setting, as a JSON object.
    pub settings: String,
    /// Seconds between the built scene and the finished picture.
    pub seconds: f64,
    /// The error that the light is estimated to have, relative to the picture's mean; `None` where nobody asked.
    pub estimated_error: Option<f64>,
    /// Samples per pixel.
    pub spp: u32,
    /// How its noise was taken out; `None`: it was not.
    pub denoised: Option<Denoised>,
    /// The camera that took the picture.
    pub camera: Camera,
}

/// How the noise of a picture was taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct Denoised {
    /// The library and its version, as in `Open Image Denoise 2.3.1`.
    pub by: String,
    /// How long it took.
    pub seconds: f64,
}
