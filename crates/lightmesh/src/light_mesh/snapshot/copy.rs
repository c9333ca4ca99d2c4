//! Copying points of a mesh into a snapshot.

use glam::Vec4;

use super::super::LightMesh;
use super::{Cursor, DirectSnapshot, IndirectSnapshot, PointCursor, PointSnapshot, Snapshot};
use crate::Error;
use crate::direct::DirectField;
use crate::indirect::IndirectField;
use crate::mesh::PointRequests;

impl LightMesh {
    /// Returns the present state, for [`LightMesh::snapshot_since`].
    pub fn cursor(&self) -> Cursor {
        let (indirect, hit_irradiance) = match &self.indirect {
            Some(field) => (field.points.cursor(), field.gather_hit_irradiance),
            None => Default::default(),
        };
        Cursor { direct: self.direct.points.cursor(), indirect, hit_irradiance }
    }

    /// Copies the points that the mesh has gained since `cursor` was taken from it; with `Cursor::default()`, all of
    /// them. The copy takes about as much memory as [`MeshStats::bytes`](crate::image::MeshStats::bytes).
    pub fn snapshot_since(&self, cursor: &Cursor) -> Snapshot {
        Snapshot {
            direct: self.direct.snapshot_since(cursor.direct),
            indirect: self.indirect.as_ref().map(|field| field.snapshot_since(cursor)),
        }
    }

    /// Copies the requested points; those that are empty are left out.
    ///
    /// # Errors
    /// [`Error::InvalidBricks`] for bricks that the mesh does not have.
    pub fn snapshot_of(&self, requests: &PointRequests) -> Result<Snapshot, Error> {
        let (points, indices) = self.direct.points.snapshot_of(&requests.direct)?;
        let direct = self.direct.snapshot(points, indices.into_iter());
        let indirect = match &self.indirect {
            Some(field) => {
                let (points, indices) = field.points.snapshot_of(&requests.indirect)?;
                Some(field.snapshot(points, &indices))
            }
            None => None,
        };
        Ok(Snapshot { direct, indirect })
    }
}

impl DirectField {
    /// Copies the points since `cursor`.
    fn snapshot_since(&self, cursor: PointCursor) -> DirectSnapshot {
        let points = self.points.snapshot_since(cursor);
        let first = (self.points.len() - points.addresses.len()) as u32;
        self.snapshot(points, first..self.points.len() as u32)
    }

    /// Copies the values of the points with these indices.
    pub(crate) fn snapshot(&self, points: PointSnapshot, indices: impl Iterator<Item = u32>) -> DirectSnapshot {
        let values = self.encoding.snapshot(indices);
        DirectSnapshot { points, values }
    }
}

impl IndirectField {
    /// Copies the points since `cursor`, and what has been added to the sums at gather hits.
    fn snapshot_since(&self, cursor: &Cursor) -> IndirectSnapshot {
        let points = self.points.snapshot_since(cursor.indirect);
        let first = self.points.len() - points.addresses.len();
        let indices: Vec<u32> = (first as u32..self.points.len() as u32).collect();
        let (sum, count) = self.gather_hit_irradiance;
        let (sum_before, count_before) = cursor.hit_irradiance;
        IndirectSnapshot {
            hit_irradiance: (sum - sum_before).max(0.0),
            hit_count: count.saturating_sub(count_before),
            ..self.snapshot(points, &indices)
        }
    }

    /// Copies the values of the points with these indices; the sums at gather hits are 0.
    pub(crate) fn snapshot(&self, points: PointSnapshot, indices: &[u32]) -> IndirectSnapshot {
        let faces = self.faces.count();
        let mut values = Vec::with_capacity(self.bounce_values.len() * indices.len() * faces * 3);
        for level in &self.bounce_values {
            let values_of = |&i: &u32| level[i as usize * faces..][..faces].iter();
            values.extend(indices.iter().flat_map(values_of).flat_map(|v: &Vec4| v.truncate().to_array()));
        }
        let (bounces, sides) = (self.bounce_values.len() as u32 - 1, faces as u32);
        IndirectSnapshot { points, bounces, faces: sides, values, hit_irradiance: 0.0, hit_count: 0 }
    }
}
