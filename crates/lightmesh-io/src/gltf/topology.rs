//! Triangles of index lists.

/// The primitive modes that make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    List,
    Strip,
    Fan,
}

impl Topology {
    /// Returns how many triangles `indices` indices make.
    pub(super) fn triangle_count(self, indices: usize) -> usize {
        match self {
            Self::List => indices / 3,
            Self::Strip | Self::Fan => indices.saturating_sub(2),
        }
    }

    /// The triangles, all with the same front side (glTF 2.0, 3.7.2.1 "Topology types"). Strips and fans leave out
    /// triangles that repeat an index, which are how strips are stitched together; an incomplete last triangle is left
    /// out.
    pub(super) fn triangles(self, indices: &[u32]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.triangle_count(indices.len()));
        match self {
            Self::List => triangles.extend_from_slice(indices.as_chunks::<3>().0),
            // pᵢ = (vᵢ, vᵢ₊₁₊ₒ, vᵢ₊₂₋ₒ), o = i mod 2.
            Self::Strip => triangles.extend(indices.windows(3).enumerate().map(|(i, v)| match i % 2 {
                0 => [v[0], v[1], v[2]],
                _ => [v[0], v[2], v[1]],
            })),
            // pᵢ = (vᵢ₊₁, vᵢ₊₂, v₀).
            Self::Fan => {
                if let Some((&center, rim)) = indices.split_first() {
                    triangles.extend(rim.windows(2).map(|v| [v[0], v[1], center]));
                }
            }
        }
        if self != Self::List {
            triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        }
        triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_alternate_and_fans_turn() {
        assert_eq!(Topology::Strip.triangles(&[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(Topology::Fan.triangles(&[9, 1, 2, 3]), [[1, 2, 9], [2, 3, 9]]);
        assert_eq!(Topology::List.triangles(&[0, 1, 2, 3]), [[0, 1, 2]]);
    }

    #[test]
    fn stitches_vanish_and_too_few_indices_make_nothing() {
        assert_eq!(Topology::Strip.triangles(&[0, 1, 2, 2, 3, 3, 4, 5]), [[0, 1, 2], [3, 5, 4]]);
        for topology in [Topology::List, Topology::Strip, Topology::Fan] {
            for n in 0..3 {
                assert!(topology.triangles(&[0, 1][..n.min(2)]).is_empty());
            }
        }
    }
}
