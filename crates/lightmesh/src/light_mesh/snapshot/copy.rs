//! Copying what a mesh knows.

use glam::Vec4;

use super::super::LightMesh;
use super::check::rgb;
use super::{Cursor, DirectSnapshot, DirectValues, IndirectSnapshot, PointCursor, PointSnapshot, Snapshot};
use crate::Error;
use crate::direct::{DirectEncoding, DirectField};
use crate::indirect::IndirectField;
use crate::mesh::PointRequests;

impl LightMesh {
    /// How much it knows now.
    pub fn cursor(&self) -> Cursor {
        let (indirect, hit_irradiance) = match &self.indirect {
            Some(field) => (field.points.cursor(), field.gather_hit_irradiance),
            None => Default::default(),
        };
        Cursor { direct: self.direct.points.cursor(), indirect, hit_irradiance }
    }

    /// A copy of what it learned since `counts` was taken from it; with `Cursor::default()`, of all that it knows. It takes about as much
    /// memory as [`MeshStats::bytes`](crate::image::MeshStats::bytes).
    pub fn snapshot_since(&self, counts: &Cursor) -> Snapshot {
        Snapshot {
            direct: self.direct.contents_since(counts.direct),
            indirect: self.indirect.as_ref().map(|field| field.contents_since(counts)),
        }
    }

    /// A copy of what it knows of some points; those that are empty are left out.
    ///
    /// # Errors
    /// [`Error::InvalidBricks`] for bricks that the mesh does not have.
    pub fn snapshot_of(&self, wanted: &PointRequests) -> Result<Snapshot, Error> {
        let (points, indices) = self.direct.points.snapshot_of(&wanted.direct)?;
        let direct = self.direct.contents(points, indices.into_iter());
        let indirect = match &self.indirect {
            Some(field) => {
                let (points, indices) = field.points.snapshot_of(&wanted.indirect)?;
                Some(field.contents(points, &indices))
            }
            None => None,
        };
        Ok(Snapshot { direct, indirect })
    }
}

impl DirectField {
    fn contents_since(&self, counts: PointCursor) -> DirectSnapshot {
        let points = self.points.snapshot_since(counts);
        let first = (self.points.len() - points.addresses.len()) as u32;
        self.contents(points, first..self.points.len() as u32)
    }

    /// What the points with these indices know.
    pub(crate) fn contents(&self, points: PointSnapshot, indices: impl Iterator<Item = u32>) -> DirectSnapshot {
        let stride = self.encoding.stride();
        let numbers = |indices: &mut dyn Iterator<Item = u32>| {
            indices.flat_map(|i| rgb(&self.values[i as usize * stride..][..stride])).collect()
        };
        let mut indices = indices;
        let values = match (self.encoding, &self.bits, &self.runs) {
            (DirectEncoding::SixAxis { .. }, ..) => DirectValues::SixAxis(numbers(&mut indices)),
            (DirectEncoding::Scalar { .. }, ..) => DirectValues::Scalar(numbers(&mut indices)),
            (DirectEncoding::PerLight { .. }, Some(bits), _) => {
                let bits_of = |i| bits.of(i).iter().copied();
                DirectValues::Lights { words: bits.words() as u32, bits: indices.flat_map(bits_of).collect() }
            }
            (DirectEncoding::PerLight { .. }, None, runs) => {
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
        DirectSnapshot { points, values }
    }
}

impl IndirectField {
    fn contents_since(&self, counts: &Cursor) -> IndirectSnapshot {
        let points = self.points.snapshot_since(counts.indirect);
        let first = self.points.len() - points.addresses.len();
        let indices: Vec<u32> = (first as u32..self.points.len() as u32).collect();
        let (sum, count) = self.gather_hit_irradiance;
        let (sum_before, count_before) = counts.hit_irradiance;
        IndirectSnapshot {
            hit_irradiance: (sum - sum_before).max(0.0),
            hit_count: count.saturating_sub(count_before),
            ..self.contents(points, &indices)
        }
    }

    /// What the points with these indices know; of gather hits nothing.
    pub(crate) fn contents(&self, points: PointSnapshot, indices: &[u32]) -> IndirectSnapshot {
        let sides = self.faces.count();
        let mut values = Vec::with_capacity(self.bounce_values.len() * indices.len() * sides * 3);
        for level in &self.bounce_values {
            let of_point = |&i: &u32| level[i as usize * sides..][..sides].iter();
            values.extend(indices.iter().flat_map(of_point).flat_map(|v: &Vec4| v.truncate().to_array()));
        }
        let (bounces, sides) = (self.bounce_values.len() as u32 - 1, sides as u32);
        IndirectSnapshot { points, bounces, faces: sides, values, hit_irradiance: 0.0, hit_count: 0 }
    }
}
