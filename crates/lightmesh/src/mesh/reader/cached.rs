//! Reading a field at one surface point after the other, with the corners' values kept for one normal.

use glam::Vec3;

use super::super::corners::corners_of;
use super::super::marks::Marks;
use super::super::read_result::ReadResult;
use super::Reader;
use crate::interaction::ShadingPoint;

/// Reads a field whose points give a surface a value of type `V` that depends on its normal. Neighbouring vertices
/// mostly share cell and normal: then each corner's value is computed once.
pub(crate) struct CachedReader<'a, V> {
    pub reader: Reader<'a>,
    /// The normal and the visit of a cell that `values` belong to.
    n: Vec3,
    visit: u64,
    /// The corners whose values have been computed, a bit each; those of others are 0.
    computed: u8,
    values: [V; 8],
}

impl<'a, V: Copy + Default> CachedReader<'a, V> {
    /// No values yet.
    pub(crate) fn new(reader: Reader<'a>) -> Self {
        Self { reader, n: Vec3::ZERO, visit: 0, computed: 0, values: [V::default(); 8] }
    }

    /// Sums the values of the points of D_y, from `sum` on: `value` of a point's index, which `add` adds with its
    /// weight φ4. Points that are still empty are marked instead.
    ///
    /// # Errors
    /// [`ReadResult::Unavailable`] or [`ReadResult::Pending`].
    #[inline(always)]
    pub(crate) fn fold<S>(
        &mut self,
        vertex: &ShadingPoint,
        marks: &Marks,
        mut sum: S,
        value: impl Fn(u32) -> V,
        add: impl Fn(S, V, f32) -> S,
    ) -> Result<S, ReadResult>
    where
        S: Copy,
    {
        if !self.reader.reads_cells() {
            return self.fold_points(vertex, marks, sum, value, add);
        }
        let corners = self.reader.corners(vertex, marks)?;
        if corners.refined > 0.0 {
            return self.fold_points(vertex, marks, sum, value, add);
        }

        // A curved surface: the next vertex has another normal, and it is not worth to keep the values.
        let visit = self.reader.visits();
        if (self.n, self.visit) != (vertex.n, visit) {
            (self.n, self.visit, self.computed) = (vertex.n, visit, 0);
            for k in corners_of(corners.mask) {
                sum = add(sum, value(self.reader.index(k)), corners.weights[k / 4][k % 4]);
            }
            return Ok(sum);
        }

        // Compute the values that are missing.
        if self.computed == 0 {
            self.values = [V::default(); 8];
        }
        for k in corners_of(corners.mask & !self.computed) {
            self.values[k] = value(self.reader.index(k));
        }
        self.computed |= corners.mask;

        // Sum all eight: a corner that is not visible has no weight.
        for (z, weights) in corners.weights.iter().enumerate() {
            for (corner, weight) in self.values[4 * z..].iter().zip(weights.to_array()) {
                sum = add(sum, *corner, weight);
            }
        }
        Ok(sum)
    }

    /// [`Self::fold`] point by point.
    fn fold_points<S: Copy>(
        &mut self,
        vertex: &ShadingPoint,
        marks: &Marks,
        mut sum: S,
        value: impl Fn(u32) -> V,
        add: impl Fn(S, V, f32) -> S,
    ) -> Result<S, ReadResult> {
        match self.reader.read(vertex, marks, |index, weight| sum = add(sum, value(index), weight)) {
            ReadResult::Value => Ok(sum),
            other => Err(other),
        }
    }
}
