//! Fresnel's equations for clear dielectrics: one interface, and a pane with two parallel ones.

/// Reflectances of an interface for light that is polarised perpendicular (s) and parallel (p) to the plane of
/// incidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectances {
    s: f32,
    p: f32,
}

impl Reflectances {
    /// Fresnel's equations for the cosine on the thinner side, in [0, 1], and the ratio of the indices, 1 or more
    /// (Born and Wolf, *Principles of Optics*, section 1.5.2). They are the same from both sides, so a ray that leaves
    /// takes the cosine that it has outside.
    pub(super) fn new(cos: f32, ior: f32) -> Self {
        let inside = ((ior * ior - 1.0) + cos * cos).sqrt() / ior;
        let square = |a: f32, b: f32| if a + b > 0.0 { ((a - b) / (a + b)).powi(2) } else { 1.0 };
        Self { s: square(cos, ior * inside), p: square(inside, ior * cos) }
    }

    /// The reflectance for unpolarised light.
    pub(super) fn mean(self) -> f32 {
        0.5 * (self.s + self.p)
    }

    /// What passes two parallel interfaces with all reflections between them, Σ (1 − R)² R²ᵏ = (1 − R) / (1 + R) for
    /// each polarisation, where both reflectances are multiplied by `scale`.
    pub(super) fn pane_transmittance(self, scale: f32) -> f32 {
        let passed = |r: f32| {
            let r = (r * scale).min(1.0);
            (1.0 - r) / (1.0 + r)
        };
        0.5 * (passed(self.s) + passed(self.p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pane of index 1.5 passes 0.923, 0.848 and 0.618 at 0, 60 and 75°; an interface reflects 4% straight on, all
    /// of it at a grazing angle, and nothing that is polarised in the plane of incidence at Brewster's, tan θ = 1.5.
    #[test]
    fn a_pane_passes_what_the_textbook_says() {
        let at = |degrees: f32| Reflectances::new(degrees.to_radians().cos(), 1.5);
        for (degrees, expected) in [(0.0, 0.923), (30.0, 0.921), (45.0, 0.907), (60.0, 0.848), (75.0, 0.618)] {
            let found = at(degrees).pane_transmittance(1.0);
            assert!((found - expected).abs() < 1e-3, "{degrees}: {found}");
        }
        assert!((at(0.0).mean() - 0.04).abs() < 1e-6 && (Reflectances::new(0.0, 1.5).mean() - 1.0).abs() < 1e-6);
        assert!(at(1.5_f32.atan().to_degrees()).p < 1e-6);
    }

    /// Without a step of the index there is no interface, and without reflection everything passes.
    #[test]
    fn equal_indices_reflect_nothing() {
        for cos in [1.0, 0.5, 1e-3] {
            assert!(Reflectances::new(cos, 1.0).mean() < 1e-6);
            assert_eq!(Reflectances::new(cos, 1.5).pane_transmittance(0.0), 1.0);
        }
    }
}
