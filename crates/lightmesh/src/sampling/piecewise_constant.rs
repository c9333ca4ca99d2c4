//! Sampling the cells of a picture in proportion to their brightness, row first, then column.

use glam::Vec2;

/// Piecewise-constant density over [0, 1)² (pbrt-v4, section A.5: PiecewiseConstant2D).
#[derive(Clone, Debug)]
pub(crate) struct Table {
    width: usize,
    height: usize,
    /// Sums along each row up to and with each cell, in units of the row's; then the same of the rows.
    columns: Vec<f32>,
    rows: Vec<f32>,
}

impl Table {
    /// Makes the table of `width · height` weights of 0 or more, not all of them 0.
    pub(crate) fn new(width: usize, weights: &[f32]) -> Self {
        let height = weights.len() / width;
        let mut columns = Vec::with_capacity(weights.len());
        let mut sums = Vec::with_capacity(height);
        for row in weights.chunks_exact(width) {
            sums.push(accumulate(row.iter().copied(), &mut columns));
        }
        let mut rows = Vec::with_capacity(height);
        accumulate(sums.into_iter(), &mut rows);
        Self { width, height, columns, rows }
    }

    /// Samples a (u, v) in [0, 1)² by u in [0, 1)²: uniform inside a cell.
    pub(crate) fn sample(&self, u: Vec2) -> Vec2 {
        let (row, y) = find(&self.rows, u.y);
        let (column, x) = find(&self.columns[row * self.width..][..self.width], u.x);
        Vec2::new((column as f32 + x) / self.width as f32, (row as f32 + y) / self.height as f32)
    }

    /// Returns the density at (u, v); its mean over [0, 1)² is 1.
    pub(crate) fn pdf(&self, uv: Vec2) -> f32 {
        let (column, row) = self.cell(uv);
        let share = |cdf: &[f32], i: usize| cdf[i] - if i > 0 { cdf[i - 1] } else { 0.0 };
        let columns = &self.columns[row * self.width..][..self.width];
        share(columns, column) * share(&self.rows, row) * (self.width * self.height) as f32
    }

    /// Returns the cell of (u, v): column and row.
    pub(crate) fn cell(&self, uv: Vec2) -> (usize, usize) {
        let at = |x: f32, n: usize| ((x * n as f32) as usize).min(n - 1);
        (at(uv.x, self.width), at(uv.y, self.height))
    }
}

/// Appends the running sums of `weights`, in units of their sum, and returns that; a row without weight is uniform.
fn accumulate(weights: impl ExactSizeIterator<Item = f32>, out: &mut Vec<f32>) -> f32 {
    let (first, n) = (out.len(), weights.len());
    let mut sum = 0.0_f64;
    let mut sums = Vec::with_capacity(n);
    for weight in weights {
        sum += f64::from(weight);
        sums.push(sum);
    }
    out.extend(sums.iter().enumerate().map(
        |(i, s)| {
            if sum > 0.0 { (s / sum) as f32 } else { (i + 1) as f32 / n as f32 }
        },
    ));
    out[first + n - 1] = 1.0;
    sum as f32
}

/// Returns the entry in which the running sums reach `u`, and how far into it.
fn find(cdf: &[f32], u: f32) -> (usize, f32) {
    let i = cdf.partition_point(|&c| c <= u).min(cdf.len() - 1);
    let before = if i > 0 { cdf[i - 1] } else { 0.0 };
    (i, ((u - before) / (cdf[i] - before)).clamp(0.0, 1.0 - f32::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::assert_follows;
    use crate::sampling::{hash, unit_f32};

    fn table() -> (Table, Vec<f32>) {
        let weights: Vec<f32> = (0..24).map(|i| if i / 6 == 2 { 0.0 } else { (i * 7 % 11) as f32 }).collect();
        (Table::new(6, &weights), weights)
    }

    fn invert(table: &Table, uv: Vec2) -> Vec2 {
        let (column, row) = table.cell(uv);
        let at = |cdf: &[f32], i: usize, x: f32| {
            let before = if i > 0 { cdf[i - 1] } else { 0.0 };
            before + (cdf[i] - before) * (x - x.floor())
        };
        let columns = &table.columns[row * table.width..][..table.width];
        Vec2::new(at(columns, column, uv.x * table.width as f32), at(&table.rows, row, uv.y * table.height as f32))
    }

    #[test]
    fn inverting_a_thousand_places_gives_their_numbers_back() {
        let (table, _) = table();
        for i in 0..1000 {
            let u = Vec2::new(sobol_burley::sample(i, 0, 4), sobol_burley::sample(i, 1, 4));
            let back = invert(&table, table.sample(u));
            assert!((back - u).abs().max_element() < 1e-4, "{u} {back}");
        }
    }

    #[test]
    fn cells_come_in_proportion_to_their_weights() {
        let (table, weights) = table();
        let mut counts = vec![0_u32; weights.len()];
        for i in 0..20_000 {
            let unit = |k: u32| unit_f32(hash(2 * i + k));
            let (column, row) = table.cell(table.sample(Vec2::new(unit(0), unit(1))));
            counts[row * 6 + column] += 1;
        }
        assert_follows(&counts, &weights.iter().copied().map(f64::from).collect::<Vec<_>>());
    }

    /// The density is the weight over the mean weight.
    #[test]
    fn the_pdf_is_the_weight_in_units_of_the_mean() {
        let (table, weights) = table();
        let mean = weights.iter().sum::<f32>() / 24.0;
        for (i, weight) in weights.iter().enumerate() {
            let centre = Vec2::new((i % 6) as f32 + 0.5, (i / 6) as f32 + 0.5) / Vec2::new(6.0, 4.0);
            assert!((table.pdf(centre) - weight / mean).abs() < 1e-4);
        }
    }
}
