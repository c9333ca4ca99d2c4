//! What the user may choose; the command line and Python take their defaults from here.

mod aov;

use std::time::Duration;

pub use aov::{Aov, Aovs, Layer};

use crate::Error;

/// How light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The light mesh, six-axis directional.
    #[default]
    Mesh,
    /// The light mesh as the paper writes it: one scalar per channel, formulas (1)-(3g).
    Paper,
    /// A shadow ray to every light sample at every hit: the paper's "standard tracing".
    Standard,
    /// What the mesh points know of each single light, and shadow rays to those about which they disagree.
    Hybrid,
    /// The mesh as control variate of light sampling, [`RenderOptions::rays`] shadow rays at each hit, and the indirect mesh as that of as
    /// many gather rays: converges to the exact picture.
    Unbiased,
    /// Unidirectional path tracing with next-event estimation over all lights: the truth.
    Path,
}

impl Method {
    /// Whether it fills and reads a [`LightMesh`](crate::LightMesh).
    pub fn has_mesh(self) -> bool {
        match self {
            Self::Mesh | Self::Paper | Self::Hybrid | Self::Unbiased => true,
            Self::Standard | Self::Path => false,
        }
    }
}

/// Distance between neighbouring mesh points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Spacing {
    /// The longest edge of the scene's box / 64, for the indirect mesh / 30, with a bound on the error / 45.
    #[default]
    Auto,
    /// The longest edge of the scene's box divided by this; > 0.
    Fraction(f32),
    /// Metres, > 0.
    Metres(f32),
}

impl Spacing {
    /// Cells along the longest edge by default: of the direct and of the indirect mesh. Measured on the room of 15 lights, all of
    /// its light at 512 × 512, with 1/40, 1/56 and 1/80 of it in the direct mesh: error 5.0, 4.8 and 4.6%; what it takes goes
    /// to the indirect mesh for the most part.
    pub(crate) const AUTO: f32 = 64.0;
    pub(crate) const AUTO_INDIRECT: f32 = 30.0;
    /// Of the indirect mesh where there is a bound on the error: gather hits read its first level, whose light is half a cell off the
    /// wall. Measured on the staircase at 5%, two refinements: bias +3.0% with 1/30, +2.6% with this.
    pub(crate) const AUTO_INDIRECT_ERROR: f32 = 45.0;
}

/// The neighbourhood D_y of formula (3g).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Interpolation {
    /// Trilinear for [`Method::Mesh`]; for [`Method::Paper`] a sphere of 1.5 spacings.
    #[default]
    Auto,
    /// The eight corners of the cell half a spacing off the surface, trilinear weights; corners that are behind the surface, inside
    /// solids or hidden are left out, and the weights of the rest are normalised.
    Trilinear,
    /// The eight corners of the cell that the surface point itself is in, trilinear weights, and a rule for those that are missing
    /// (figs. 10-11 of the paper). What stands between a corner and the surface is not asked. It is for the direct light of
    /// [`Method::Mesh`] without [`RenderOptions::error`] and of [`Method::Paper`]; indirect light is read as by [`Self::Trilinear`].
    TrilinearWith(MissingCorners),
    /// Every mesh point within `radius` spacings, weighted as [`RenderOptions::weight`] says (figs. 7-9).
    Sphere {
        /// In spacings, > 0.
        radius: f32,
    },
    /// The nearest mesh point (figs. 4-6).
    Nearest,
}

/// What a corner counts as that is behind the surface's plane or, except with [`Method::Paper`], inside a solid: figs. 10-11 of
/// the paper. Ĩ is what the other corners say, s the part of the trilinear weight that they have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingCorners {
    /// Visibility 0: s Ĩ. Edges are dark.
    Zero,
    /// Its weight goes to the corner nearest to the surface point, among those that are there.
    Nearest,
    /// Its weight goes to the corner at the other end of the cell's edge along the axis in which the normal is longest; where that
    /// is missing, too, as with [`Self::Nearest`].
    Mirror,
    /// Visibility 1: s Ĩ + (1 − s). Edges are bright.
    One,
}

impl Interpolation {
    /// Radius of the sphere where none is said, in spacings.
    pub const DEFAULT_RADIUS: f32 = 1.5;
}

/// Weights of the mesh points in a sphere: φ4 of formula (3g) for direct light and φ5 of (6) for indirect light. Means are over weights:
/// Ĩ(y) = Σ φ(x_i, y) DirectLight(x_i) / Σ φ(x_i, y). The paper has 1; others are among its future work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointWeight {
    /// 1.
    #[default]
    Constant,
    /// exp(−d² / (2 (R/2)²)), d the distance of the point from the surface point and R the sphere's radius: e⁻² at its edge.
    Gaussian,
    /// 1 / max(d, 0.1), d in spacings.
    Inverse,
    /// n·(x − y) / |x − y|, n the geometric normal: points straight above count, those along the surface hardly.
    Cosine,
}

/// Attenuation with distance: φ1 and φ3 of the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Falloff {
    /// r², physical.
    #[default]
    InverseSquare,
    /// The paper's Const + r; `constant` in metres, ≥ 0.
    ConstantPlusDistance {
        /// Metres.
        constant: f32,
    },
}

/// How Ĩ of the paper's method is scaled (DESIGN: (2) × (3) is an energy squared).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PaperScale {
    /// Divide sum (1) by the same sum without V_i, both over the neighbourhood: Ĩ is a mean visibility in [0, 1]. Points inside solids are
    /// left out, and spheres stand 0.6 spacings off the surface: what is next to a point on a wall is mostly wall.
    #[default]
    Visibility,
    /// Formulas as printed, every point counting, in a sphere about the surface point itself, times one constant for the whole scene: one over the mean of Σ E_i / φ1, without V_i, over a
    /// regular grid of 8³ places in the scene's box and over the channels. Ĩ is then 1 on average where nothing is hidden.
    Constant,
}

/// Everything that decides what a picture looks like, apart from scene and camera.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// How light is computed.
    pub method: Method,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Samples per pixel, box filter of one pixel, 1 to 65536; 1 samples the pixel's centre. With a time limit, the most.
    pub spp: u32,
    /// Render time, from the built scene, after which no more samples are taken, above 0; `None`: all are. Every pixel gets one
    /// sample however long that takes. How many there are in time depends on the machine and what else it does, and so does
    /// the picture; where the limit is not reached, last bits may differ from the picture without a limit, as sums are
    /// rounded in another order.
    pub time_limit: Option<Duration>,
    /// Diffuse interreflections; 0 is direct light only, 1 the paper. At most 4096. [`Method::Standard`] computes none.
    pub bounces: u32,
    /// How many mirror and refraction events a ray may meet in a row.
    pub depth: u32,
    /// A mirrored or refracted ray that carries less than this fraction of the picture's light is dropped.
    pub cutoff: f32,
    /// Spacing of the direct mesh.
    pub spacing: Spacing,
    /// Spacing of the indirect mesh.
    pub indirect_spacing: Spacing,
    /// Rays that gather light at a point of the indirect mesh; 1 to 65536.
    pub gather_rays: u32,
    /// The error that the picture's light may have, root mean square relative to the picture's mean, against the same samples lit
    /// exactly; above 0. Of [`Method::Mesh`] alone: it then reads the mesh light by light, with as many shadow rays as it takes.
    /// `None`: whatever the mesh gives.
    pub error: Option<f32>,
    /// How often the meshes may halve their spacing where their light is not good enough; 0 to 4. `None`: not at all, or where
    /// there is a bound on the error twice.
    pub refine: Option<u32>,
    /// Density that falls with the distance from the eye: mesh points nearer to the camera's position than so many metres, above 0, have
    /// half the spacing, nearer than half of it a quarter, nearer than a quarter of it an eighth. The spacings that are asked for
    /// are those of what is farther away. Where points would not fit into half of `max_memory`, fewer of these steps are taken. It is
    /// for the methods with a mesh that are read trilinear, and what [`RenderOptions::refine`] does comes after it. `None`: one
    /// spacing everywhere.
    pub graded: Option<f32>,
    /// Shadow rays at each hit with [`Method::Unbiased`], and gather rays where there is indirect light; 1 to 65536.
    pub rays: u32,
    /// How mesh points are combined.
    pub interpolation: Interpolation,
    /// φ4 and φ5: how much each point of a sphere counts, where [`RenderOptions::interpolation`] is one.
    pub weight: PointWeight,
    /// φ1: attenuation inside the direct field of [`Method::Paper`].
    pub field_falloff: Falloff,
    /// φ3: attenuation of the unshadowed sum, for every method.
    pub falloff: Falloff,
    /// Scale of Ĩ in [`Method::Paper`].
    pub paper_scale: PaperScale,
    /// Error of the sum over more than 512 light samples, as a part of all light that arrives at a place: lights that are far away are
    /// taken together as far as it allows (docs/many-lights.md). At least 0 and below 1; 0: every light by itself. For the methods with a
    /// mesh; [`Method::Standard`] and [`Method::Path`] know every light.
    pub light_error: f32,
    /// Layers that the picture gets beside its light.
    pub aovs: Aovs,
    /// Seed of all randomness.
    pub seed: u64,
    /// Limit of what a render may hold in memory, bytes.
    pub max_memory: u64,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            method: Method::default(),
            width: 1280,
            height: 720,
            spp: 4,
            time_limit: None,
            bounces: 3,
            depth: 8,
            cutoff: 1e-3,
            spacing: Spacing::default(),
            indirect_spacing: Spacing::default(),
            gather_rays: 256,
            error: None,
            refine: None,
            graded: None,
            rays: 4,
            interpolation: Interpolation::default(),
            weight: PointWeight::default(),
            field_falloff: Falloff::default(),
            falloff: Falloff::default(),
            paper_scale: PaperScale::default(),
            light_error: 0.01,
            aovs: Aovs::default(),
            seed: 0,
            max_memory: 4 << 30,
        }
    }
}

impl RenderOptions {
    /// Levels beyond the first of meshes whose density falls with the distance: from near to far 8, 4, 2 and 1 points along an edge.
    const GRADED_LEVELS: u32 = 3;

    /// How often meshes may be refined where their light is not good enough.
    pub(crate) fn refinements(&self) -> u32 {
        self.refine.unwrap_or(if self.error.is_some() { 2 } else { 0 })
    }

    /// Levels of the meshes beyond the first.
    pub(crate) fn finer_levels(&self) -> u32 {
        self.refinements().max(if self.graded.is_some() { Self::GRADED_LEVELS } else { 0 })
    }

    /// Whether mesh points keep what they know of each light.
    pub(crate) fn knows_lights(&self) -> bool {
        matches!(self.method, Method::Hybrid | Method::Unbiased) || self.error.is_some()
    }

    /// Refuses a picture that `max_memory` does not hold: 28 bytes a pixel for the film, the finished picture and its
    /// 8-bit copy, and what its layers take. Waves of rays take some 20 MiB beside it, whatever the size; the mesh and
    /// the scene are checked where they grow.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; nothing has been allocated.
    pub fn check_picture_memory(&self) -> Result<(), Error> {
        self.check_memory(Self::BYTES_PER_PIXEL)
    }

    /// The same for a picture that a [`Viewer`](crate::Viewer) looks at: 19 bytes a pixel more, for the sketch, the picture
    /// that is shown and its 8-bit copy.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; nothing has been allocated.
    pub fn check_viewed_picture_memory(&self) -> Result<(), Error> {
        self.check_memory(Self::BYTES_PER_PIXEL + 4 + 12 + 3)
    }

    const BYTES_PER_PIXEL: u64 = 12 + 1 + 12 + 3;

    pub(crate) fn check_memory(&self, bytes_per_pixel: u64) -> Result<(), Error> {
        let pixels = u64::from(self.width) * u64::from(self.height);
        let needed_bytes = pixels.saturating_mul(bytes_per_pixel + self.aovs.bytes_per_pixel());
        // Pixels are counted in 32 bits.
        if needed_bytes <= self.max_memory && pixels <= u64::from(u32::MAX) {
            return Ok(());
        }
        Err(Error::OutOfMemory {
            what: "a picture of this size",
            needed_bytes,
            limit_bytes: self.max_memory,
            advice: if self.aovs.is_empty() {
                "choose a smaller --size"
            } else {
                "choose a smaller --size or fewer --aov"
            },
        })
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] names the first field outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |option, what: String| Err(Error::InvalidOption { option, what });
        if self.width == 0 || self.height == 0 {
            return bad("size", format!("width and height must be at least 1, not {}x{}", self.width, self.height));
        }
        if self.spp == 0 || self.spp > 1 << 16 {
            return bad("spp", format!("must be between 1 and 65536, not {}", self.spp));
        }
        if self.time_limit.is_some_and(|limit| limit.is_zero()) {
            return bad("time-limit", "must be above 0 seconds".into());
        }
        for (option, spacing) in [("spacing", self.spacing), ("indirect-spacing", self.indirect_spacing)] {
            if let Spacing::Metres(x) | Spacing::Fraction(x) = spacing
                && !(x > 0.0 && x.is_finite())
            {
                return bad(option, format!("must be above 0, not {x}"));
            }
        }
        for (option, rays) in [("gather-rays", self.gather_rays), ("rays", self.rays)] {
            if rays == 0 || rays > 1 << 16 {
                return bad(option, format!("must be between 1 and 65536, not {rays}"));
            }
        }
        if let Some(error) = self.error {
            if !(error > 0.0 && error.is_finite()) {
                return bad("error", format!("must be above 0, not {error}"));
            }
            if self.method != Method::Mesh {
                return bad("error", "is kept to by the method mesh alone".into());
            }
        }
        if let Some(metres) = self.graded
            && !(metres > 0.0 && metres.is_finite())
        {
            return bad("graded", format!("must be above 0 metres, not {metres}"));
        }
        if let Some(refine) = self.refine.filter(|&levels| levels > 4) {
            return bad("refine", format!("must be at most 4, not {refine}"));
        }
        let refined = self.refine.is_some_and(|levels| levels > 0).then_some("refine");
        if let Some(option) = refined.or(self.graded.map(|_| "graded")) {
            if !self.method.has_mesh() {
                return bad(option, "is for methods that have a mesh".into());
            }
            let trilinear = match self.interpolation {
                Interpolation::Auto => self.method != Method::Paper,
                other => other == Interpolation::Trilinear,
            };
            if !trilinear {
                return bad("interpolation", "must be trilinear, without a rule, where meshes are refined".into());
            }
        }
        if self.bounces > 4096 {
            return bad("bounces", format!("must be at most 4096, not {}", self.bounces));
        }
        if let Interpolation::Sphere { radius } = self.interpolation
            && !(radius > 0.0 && radius <= 16.0)
        {
            return bad(
                "interpolation",
                format!("the sphere's radius must be above 0 and at most 16 spacings, not {radius}"),
            );
        }
        let sphere = match self.interpolation {
            Interpolation::Auto => self.method == Method::Paper,
            other => matches!(other, Interpolation::Sphere { .. }),
        };
        if self.weight != PointWeight::Constant && !sphere {
            return bad("weight", "is for points in a sphere: choose the interpolation sphere:R".into());
        }
        let by_light = !matches!(self.interpolation, Interpolation::Sphere { .. } | Interpolation::TrilinearWith(_));
        if self.knows_lights() && !by_light {
            return bad(
                "interpolation",
                "single lights (the methods hybrid and unbiased, and an error bound) are read trilinear, without a rule, or \
                 nearest"
                    .into(),
            );
        }
        for (option, falloff) in [("falloff", self.falloff), ("field-falloff", self.field_falloff)] {
            if let Falloff::ConstantPlusDistance { constant } = falloff
                && !(constant >= 0.0 && constant.is_finite())
            {
                return bad(option, format!("the constant must be 0 metres or more, not {constant}"));
            }
        }
        if let Some(aov) = self.aovs.iter().find(|aov| !aov.is_known_to(self.method)) {
            return bad(
                "aov",
                format!("{} shows the light mesh, which the methods standard and path do not have", aov.name()),
            );
        }
        if !(self.light_error >= 0.0 && self.light_error < 1.0) {
            return bad("light-error", format!("must be at least 0 and below 1, not {}", self.light_error));
        }
        if !(self.cutoff >= 0.0 && self.cutoff < 1.0) {
            return bad("cutoff", format!("must be at least 0 and below 1, not {}", self.cutoff));
        }
        Ok(())
    }
}
