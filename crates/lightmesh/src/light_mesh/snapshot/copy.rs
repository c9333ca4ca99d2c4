//! Copying what a mesh knows.

use glam::Vec4;

use super::super::LightMesh;
use super::check::rgb;
use super::{Contents, Counts, DirectContents, DirectValues, IndirectContents, PointContents, PointCounts};
use crate::Error;
use crate::direct::{DirectField, Field};
use crate::indirect::IndirectField;
use crate::mesh::Wanted;

impl LightMesh {
    /// How much it knows now.
    pub fn counts(&self) -> Counts {
        let (indirect, hit_irradiance) = match &self.indirect {
            Some(field) => (field.points.counts(), field.hit_irradiance),
            None => Default::default(),
        };
        Counts { direct: self.direct.points.counts(), indirect, hit_irradiance }
    }

    /// A copy of what it learned since `counts` was taken from it; with `Counts::default()`, of all that it knows. It takes about as much
    /// memory as [`MeshStats::bytes`](crate::image::MeshStats::bytes).
    pub fn contents_since(&self, counts: &Counts) -> Contents {
        Contents {
            direct: self.direct.contents_since(counts.direct),
            indirect: self.indirect.as_ref().map(|field| field.contents_since(counts)),
        }
    }

    /// A copy of what it knows of some points; those that are empty are left out.
    ///
    /// # Errors
    /// [`Error::InvalidBricks`] for bricks that the mesh does not have.
    pub fn contents_of(&self, wanted: &Wanted) -> Result<Contents, Error> {
        let (points, indices) = self.direct.points.contents_of(&wanted.direct)?;
        let direct = self.direct.contents(points, indices.into_iter());
        let indirect = match &self.indirect {
            Some(field) => {
                let (points, indices) = field.points.contents_of(&wanted.indirect)?;
                Some(field.contents(points, &indices))
            }
            None => None,
        };
        Ok(Contents { direct, indirect })
    }
}

impl DirectField {
    fn contents_since(&self, counts: PointCounts) -> DirectContents {
        let points = self.points.contents_since(counts);
        let first = (self.points.len() - points.addresses.len()) as u32;
        self.contents(points, first..self.points.len() as u32)
    }

    /// What the points with these indices know.
    pub(crate) fn contents(&self, points: PointContents, indices: impl Iterator<Item = u32>) -> DirectContents {
        let stride = self.field.stride();
        let numbers = |indices: &mut dyn Iterator<Item = u32>| {
            indices.flat_map(|i| rgb(&self.values[i as usize * stride..][..stride])).collect()
        };
        let mut indices = indices;
        let values = match (self.field, &self.bits, &self.runs) {
            (Field::SixAxis { .. }, ..) => DirectValues::SixAxis(numbers(&mut indices)),
            (Field::Scalar { .. }, ..) => DirectValues::Scalar(numbers(&mut indices)),
            (Field::ByLight { .. }, Some(bits), _) => {
                let bits_of = |i| bits.of(i).iter().copied();
                DirectValues::Lights { words: bits.words() as u32, bits: indices.flat_map(bits_of).collect() }
            }
            (Field::ByLight { .. }, None, runs) => {
                let (mut ends, mut all) = (Vec::with_capacity(points.addresses.len()), Vec::new());
                if let Some(runs) = runs {
                    for i in indices {
                        all.extend_from_slice(runs.of(i));
                        ends.push(all.len() as u64);
                    }
                }
                DirectValues::Runs { ends, runs: all }
            }
        };
        DirectContents { points, values }
    }
}

impl IndirectField {
    fn contents_since(&self, counts: &Counts) -> IndirectContents {
        let points = self.points.contents_since(counts.indirect);
        let first = self.points.len() - points.addresses.len();
        let indices: Vec<u32> = (first as u32..self.points.len() as u32).collect();
        let (sum, count) = self.hit_irradiance;
        let (sum_before, count_before) = counts.hit_irradiance;
        IndirectContents {
            hit_irradiance: (sum - sum_before).max(0.0),
            hit_count: count.saturating_sub(count_before),
            ..self.contents(points, &indices)
        }
    }

    /// What the points with these indices know; of gather hits nothing.
    pub(crate) fn contents(&self, points: PointContents, indices: &[u32]) -> IndirectContents {
        let sides = self.sides.count();
        let mut values = Vec::with_capacity(self.levels.len() * indices.len() * sides * 3);
        for level in &self.levels {
            let of_point = |&i: &u32| level[i as usize * sides..][..sides].iter();
            values.extend(indices.iter().flat_map(of_point).flat_map(|v: &Vec4| v.truncate().to_array()));
        }
        let (bounces, sides) = (self.levels.len() as u32 - 1, sides as u32);
        IndirectContents { points, bounces, sides, values, hit_irradiance: 0.0, hit_count: 0 }
    }
}
