//! What becomes of a ray at a surface: a part of it goes straight through, and one of the reflection model's lobes
//! sends the rest on.
//!
//! | who | passes through | goes on by |
//! |---|---|---|
//! | waves | a second ray of weight 1 − opacity | a ray for each specular lobe, weak ones by chance; a diffuse lobe is lit |
//! | path tracer | with probability 1 − opacity | one lobe by chance |
//! | gather rays | with probability 1 − opacity | one lobe by chance, and end where it is the diffuse one |
//!
//! The random numbers are the caller's. Another BSDF has other lobes here; the loops that follow rays stay as they are.

use glam::Vec3;

use super::surface::ShadedHit;
use crate::bvh::Hit;
use crate::geometry::{Cone, Ray};

/// BLEND and MASK surfaces that a ray may pass in a row.
const MAX_TRANSPARENT_HITS: u8 = 64;

/// A part of a surface's reflection that scatters light in its own way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    /// Lambert's: into all directions above the surface.
    Diffuse,
    /// Into a single direction.
    Specular(SpecularLobe),
}

/// A lobe with a single direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpecularLobe {
    /// The mirror direction.
    Reflection,
    /// The refracted direction.
    Transmission,
}

/// The albedo of each lobe: radiance that leaves per radiance that arrives, evenly from everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobes {
    pub diffuse: Vec3,
    pub reflection: Vec3,
    pub transmission: Vec3,
}

/// A sample of a surface's BSDF: a lobe that was chosen by chance, and its weight. The direction follows from the lobe:
/// specular ones have one, and for the diffuse one the caller draws it in proportion to the cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BsdfSample {
    pub lobe: Lobe,
    /// The lobe's albedo.
    pub albedo: Vec3,
    /// 1 / the probability of the choice: a factor, as a division would round otherwise.
    pub inverse_pdf: f32,
}

impl Lobes {
    /// Without the lobes that have a single direction.
    pub(crate) fn without_specular(self) -> Self {
        Self { reflection: Vec3::ZERO, transmission: Vec3::ZERO, ..self }
    }

    /// The specular lobes that reflect anything, with their albedos.
    pub(crate) fn specular(self) -> impl Iterator<Item = (SpecularLobe, Vec3)> {
        let lobes = [(SpecularLobe::Reflection, self.reflection), (SpecularLobe::Transmission, self.transmission)];
        lobes.into_iter().filter(|(_, albedo)| *albedo != Vec3::ZERO)
    }

    /// Chooses a lobe with a random number in [0, 1), in proportion to the largest channel of its albedo; `None` where
    /// the surface reflects nothing.
    pub(crate) fn sample(self, u: f32) -> Option<BsdfSample> {
        let lobes = [
            (Lobe::Diffuse, self.diffuse),
            (Lobe::Specular(SpecularLobe::Reflection), self.reflection),
            (Lobe::Specular(SpecularLobe::Transmission), self.transmission),
        ];
        let total: f32 = lobes.iter().map(|(_, albedo)| albedo.max_element()).sum();
        if total <= 0.0 {
            return None;
        }
        let (u, mut sum, mut chosen) = (u * total, 0.0, None);
        for (lobe, albedo) in lobes {
            let share = albedo.max_element();
            // Where u is rounded up to the total, the last lobe that reflects anything.
            if share > 0.0 && u >= sum {
                chosen = Some(BsdfSample { lobe, albedo, inverse_pdf: total / share });
            }
            sum += share;
        }
        chosen
    }
}

impl BsdfSample {
    /// What the throughput of a path is multiplied with that goes on by this lobe.
    pub(crate) fn throughput(&self) -> Vec3 {
        self.albedo * self.inverse_pdf
    }
}

impl ShadedHit {
    /// The lobes of the reflection model.
    pub(crate) fn lobes(&self) -> Lobes {
        Lobes { diffuse: self.diffuse, reflection: self.mirror, transmission: self.refraction }
    }

    /// Whether a ray goes straight through, with probability 1 − opacity. The random number is drawn only where the
    /// surface is partly transparent.
    pub(crate) fn lets_through(&self, u: impl FnOnce() -> f32) -> bool {
        self.opacity < 1.0 && u() >= self.opacity
    }
}

/// A ray on its way through mirrors, glass and partly transparent surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathRay {
    pub ray: Ray,
    /// What it stands for: the part of textures that is averaged.
    pub cone: Cone,
    /// Mirror and refraction events so far.
    pub depth: u32,
    /// Partly transparent surfaces passed since the last event.
    transparent_hits: u8,
}

impl PathRay {
    /// A ray that has met nothing yet.
    pub(crate) fn new(ray: Ray, cone: Cone) -> Self {
        Self { ray, cone, depth: 0, transparent_hits: 0 }
    }

    /// Whether it has met nothing yet.
    pub(crate) fn is_first(&self) -> bool {
        self.depth == 0 && self.transparent_hits == 0
    }

    /// The ray that goes straight on behind a hit; `None` where it has passed too many surfaces.
    pub(crate) fn pass_through(&self, hit: &Hit) -> Option<Self> {
        let passes = self.transparent_hits < MAX_TRANSPARENT_HITS;
        let ray = Ray { t_min: hit.t, ..self.ray };
        passes.then(|| Self { ray, transparent_hits: self.transparent_hits + 1, ..*self })
    }

    /// The ray that a specular lobe sends on.
    pub(crate) fn spawn(&self, hit: &Hit, surface: &ShadedHit, lobe: SpecularLobe) -> Self {
        let cone = self.cone.after(hit.t);
        let (direction, cone) = match lobe {
            SpecularLobe::Reflection => {
                let mirrored = surface.reflect(self.ray.direction);
                (mirrored, cone.mirrored(self.ray.direction, mirrored))
            }
            SpecularLobe::Transmission => (surface.refracted, cone),
        };
        Self { ray: surface.spawn_ray(direction), cone, depth: self.depth + 1, transparent_hits: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFLECTION: Lobe = Lobe::Specular(SpecularLobe::Reflection);
    const TRANSMISSION: Lobe = Lobe::Specular(SpecularLobe::Transmission);

    /// Shares 0.25 : 0.5 : 0.25 of [0, 1), and a lobe's albedo times 1 / its probability.
    #[test]
    fn lobes_are_chosen_in_proportion_to_their_albedo() {
        let lobes = Lobes {
            diffuse: Vec3::new(0.1, 0.2, 0.0),
            reflection: Vec3::splat(0.4),
            transmission: Vec3::new(0.0, 0.1, 0.2),
        };
        for (u, lobe, throughput) in [
            (0.0, Lobe::Diffuse, Vec3::new(0.4, 0.8, 0.0)),
            (0.24, Lobe::Diffuse, Vec3::new(0.4, 0.8, 0.0)),
            (0.26, REFLECTION, Vec3::splat(0.8)),
            (0.74, REFLECTION, Vec3::splat(0.8)),
            (0.76, TRANSMISSION, Vec3::new(0.0, 0.4, 0.8)),
            (1.0, TRANSMISSION, Vec3::new(0.0, 0.4, 0.8)),
        ] {
            let sample = lobes.sample(u).expect("a lobe");
            assert_eq!(sample.lobe, lobe, "{u}");
            assert!((sample.throughput() - throughput).length() < 1e-6, "{u}");
        }
    }

    /// A lobe that reflects nothing is never chosen, not even where u is rounded up to 1.
    #[test]
    fn black_lobes_are_never_chosen() {
        let (black, white) = (Vec3::ZERO, Vec3::ONE);
        let lobes = |diffuse, reflection, transmission| Lobes { diffuse, reflection, transmission };
        for (lobes, only) in [
            (lobes(white, black, black), Lobe::Diffuse),
            (lobes(black, white, black), REFLECTION),
            (lobes(black, black, white), TRANSMISSION),
        ] {
            for u in [0.0, 0.5, 1.0] {
                assert_eq!(lobes.sample(u).map(|sample| sample.lobe), Some(only));
            }
        }
        assert_eq!(lobes(black, black, black).sample(0.5), None);
        assert_eq!(lobes(white, white, white).without_specular().sample(1.0).map(|s| s.lobe), Some(Lobe::Diffuse));
    }

    /// At most 64 surfaces in a row let a ray through; a mirror starts the count anew.
    #[test]
    fn rays_pass_a_bounded_number_of_surfaces() {
        let hit = |t| Hit { t, u: 0.0, v: 0.0, target: crate::bvh::Target::Sphere(0) };
        let mut ray = PathRay::new(Ray::new(Vec3::ZERO, Vec3::X), Cone::POINT);
        assert!(ray.is_first());
        for i in 0..MAX_TRANSPARENT_HITS {
            ray = ray.pass_through(&hit(f32::from(i))).expect("a ray");
            assert!(!ray.is_first() && ray.ray.t_min == f32::from(i));
        }
        assert!(ray.pass_through(&hit(1e3)).is_none());
    }
}
