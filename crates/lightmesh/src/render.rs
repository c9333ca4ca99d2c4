//! STUB, replaced on main.
use crate::{Camera, Error, Image, Progress, RenderOptions, RenderStats, Scene};
/// The light mesh; outlives frames.
#[derive(Debug, Default)]
pub struct LightMesh;
impl LightMesh {
    /// An empty mesh for the scene.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the spacing is too fine.
    pub fn new(scene: &Scene, options: &RenderOptions) -> Result<Self, Error> { let _ = (scene, options); Ok(Self) }
}
/// A finished frame.
#[derive(Clone, Debug)]
pub struct Frame { /// linear
    pub image: Image, /// stats
    pub stats: RenderStats }
/// Renders one picture.
///
/// # Errors
/// Bad options, too little memory, or cancelled.
pub fn render(scene: &Scene, camera: &Camera, options: &RenderOptions, mesh: &mut LightMesh, progress: &dyn Progress) -> Result<Frame, Error> {
    let _ = (scene, camera, mesh, progress); options.validate()?;
    Ok(Frame { image: Image { width: options.width, height: options.height, pixels: vec![glam::Vec3::ONE; options.width as usize * options.height as usize] }, stats: RenderStats::default() })
}
