//! Copying what a mesh knows.

use glam::Vec4;

use super::super::LightMesh;
use super::super::direct::{DirectField, Field};
use super::super::indirect::IndirectField;
use super::values::rgb;
use super::{Contents, Counts, DirectContents, DirectValues, IndirectContents, PointCounts};

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
    /// memory as [`MeshStats::bytes`](crate::MeshStats::bytes).
    pub fn contents_since(&self, counts: &Counts) -> Contents {
        Contents {
            direct: self.direct.contents_since(counts.direct),
            indirect: self.indirect.as_ref().map(|field| field.contents_since(counts)),
        }
    }
}

impl DirectField {
    fn contents_since(&self, counts: PointCounts) -> DirectContents {
        let points = self.points.contents_since(counts);
        let first = self.points.len() - points.addresses.len();
        let values = match (self.field, &self.bits, &self.runs) {
            (Field::SixAxis { .. }, ..) => DirectValues::SixAxis(rgb(&self.values[first * self.field.stride()..])),
            (Field::Scalar { .. }, ..) => DirectValues::Scalar(rgb(&self.values[first * self.field.stride()..])),
            (Field::ByLight { .. }, Some(bits), _) => {
                DirectValues::Lights { words: bits.words() as u32, bits: bits.since(first).to_vec() }
            }
            (Field::ByLight { .. }, None, runs) => {
                let (mut ends, mut all) = (Vec::with_capacity(points.addresses.len()), Vec::new());
                for point in runs.iter().flat_map(|runs| (first..self.points.len()).map(|i| runs.of(i as u32))) {
                    all.extend_from_slice(point);
                    ends.push(all.len() as u64);
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
        let sides = self.sides.count();
        let first = (self.points.len() - points.addresses.len()) * sides;
        let mut values = Vec::with_capacity(self.levels.len() * points.addresses.len() * sides * 3);
        for level in &self.levels {
            values.extend(level[first..].iter().flat_map(|v: &Vec4| v.truncate().to_array()));
        }
        let (sum, count) = self.hit_irradiance;
        let (sum_before, count_before) = counts.hit_irradiance;
        IndirectContents {
            points,
            bounces: self.levels.len() as u32 - 1,
            sides: sides as u32,
            values,
            hit_irradiance: (sum - sum_before).max(0.0),
            hit_count: count.saturating_sub(count_before),
        }
    }
}
