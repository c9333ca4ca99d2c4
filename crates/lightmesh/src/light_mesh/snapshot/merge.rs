//! Taking in what another mesh knows.

use super::super::LightMesh;
use super::check::{check_finite, check_length, refuse, values};
use super::{DirectSnapshot, DirectValues, IndirectSnapshot, Snapshot};
use crate::Error;
use crate::direct::{DirectEncoding, DirectField, LightRuns};
use crate::indirect::IndirectField;

impl LightMesh {
    /// Adds the points of another mesh of the same scene and settings that this one does not have; others are left as they are. What is
    /// rendered with it afterwards is bit for bit what it would have been: absorbed points are not evaluated again.
    ///
    /// That the scene and the settings are the same cannot be seen in contents: compare [`Fingerprint`](crate::Fingerprint)s.
    ///
    /// # Errors
    /// [`Error::InvalidContents`] for contents of a mesh of another kind, lattice or number of bounces, and for such that cannot be true;
    /// [`Error::OutOfMemory`] if its points would not fit into the memory that the mesh was allowed when it was made. The mesh has not
    /// changed then.
    pub fn merge(&mut self, contents: &Snapshot) -> Result<(), Error> {
        // Check everything, then change.
        self.direct.check(&contents.direct)?;
        match (&self.indirect, &contents.indirect) {
            (Some(field), Some(contents)) => field.check(contents)?,
            (Some(_), None) => return refuse("indirect", "is missing; the mesh has indirect light"),
            (None, Some(_)) => return refuse("indirect", "is given; the mesh has no indirect light"),
            (None, None) => {}
        }
        self.direct.absorb(&contents.direct);
        if let (Some(field), Some(contents)) = (&mut self.indirect, &contents.indirect) {
            field.absorb(contents);
        }
        Ok(())
    }
}

impl DirectField {
    fn check(&self, contents: &DirectSnapshot) -> Result<(), Error> {
        let DirectSnapshot { points, values } = contents;
        self.points.check(points, "direct")?;
        let n = points.addresses.len();
        match (self.encoding, &self.bits, &self.runs, values) {
            (DirectEncoding::SixAxis { .. }, _, _, DirectValues::SixAxis(numbers)) => {
                check_length("direct values", numbers.len(), &[n, 6, 2, 3])?;
                check_finite("direct values", numbers)?;
            }
            (DirectEncoding::Scalar { .. }, _, _, DirectValues::Scalar(numbers)) => {
                check_length("direct values", numbers.len(), &[n, 2, 3])?;
                check_finite("direct values", numbers)?;
            }
            (_, Some(own), _, DirectValues::Lights { words, bits }) => {
                if *words as usize != own.words() {
                    let what = format!("have {words} words of bits for the lights; this scene has {}", own.words());
                    return refuse("direct values", what);
                }
                check_length("direct values", bits.len(), &[n, 2, own.words()])?;
                self.check_bits(bits, own.words())?;
            }
            (_, _, Some(own), DirectValues::Runs { ends, runs }) => return self.check_runs(contents, own, ends, runs),
            (_, bits, runs, _) => {
                let own = match self.encoding {
                    DirectEncoding::SixAxis { .. } => "six axes",
                    DirectEncoding::Scalar { .. } => "the paper's scalar",
                    DirectEncoding::PerLight { .. } if bits.is_some() => "single lights",
                    DirectEncoding::PerLight { .. } if runs.is_some() => "clusters of lights",
                    DirectEncoding::PerLight { .. } => "lights",
                };
                return refuse("direct values", format!("are of another method; this mesh keeps {own}"));
            }
        }
        let (new, bricks) = self.points.news(points);
        self.points.check_memory(new, bricks, self.costs(), self.max_memory())
    }

    /// Refuses rows that say of a light that all of it arrives and nothing does, or that a lane shines which pads.
    fn check_bits(&self, bits: &[u64], words: usize) -> Result<(), Error> {
        // Without lights there are no words.
        for (point, rows) in bits.chunks_exact(2 * words.max(1)).enumerate() {
            let (seen, open) = rows.split_at(words);
            let unsound = |i: usize| seen[i] & !open[i] != 0 || open[i] & self.padding.get(i).unwrap_or(&0) != 0;
            if (0..words).any(unsound) {
                return refuse(format!("direct values, point {point}"), "its bits contradict each other");
            }
        }
        Ok(())
    }

    fn check_runs(&self, contents: &DirectSnapshot, own: &LightRuns, ends: &[u64], runs: &[u32]) -> Result<(), Error> {
        check_length("direct values' ends", ends.len(), &[contents.points.addresses.len()])?;
        let all = split(ends, runs);
        let Some(all) = all else {
            return refuse("direct values' ends", format!("do not ascend to {}, the number of runs", runs.len()));
        };
        let leaves = self.lights().leaf_count();
        for (point, runs) in all.iter().enumerate() {
            if !LightRuns::are_sound(runs, leaves) {
                return refuse(format!("direct values, point {point}"), "its runs are not ascending states of lights");
            }
        }
        let (new, bricks) = self.points.news(&contents.points);
        self.points.check_memory(new, bricks, self.costs(), self.max_memory())?;
        // A growing vector may hold twice its contents for a moment.
        let needed_bytes = self.points.stats(2 * own.bytes_with(all.into_iter()) + self.lights().bytes()).bytes;
        let limit_bytes = self.max_memory();
        if needed_bytes > limit_bytes {
            let advice = "choose a larger --spacing or --light-error";
            return Err(Error::OutOfMemory { what: "the light mesh", needed_bytes, limit_bytes, advice });
        }
        Ok(())
    }

    /// Adds what is not known; it has been checked.
    fn absorb(&mut self, contents: &DirectSnapshot) {
        let Self { points, values: own, bits, runs, encoding: field, .. } = self;
        let stride = field.stride();
        points.merge(&contents.points, |i| match &contents.values {
            DirectValues::SixAxis(numbers) | DirectValues::Scalar(numbers) => {
                own.extend(values(&numbers[i * stride * 3..][..stride * 3]));
            }
            DirectValues::Lights { words, bits: rows } => {
                let words = 2 * *words as usize;
                bits.iter_mut().for_each(|bits| bits.push(&rows[i * words..][..words]));
            }
            DirectValues::Runs { ends, runs: all } => {
                let begin = if i > 0 { ends[i - 1] as usize } else { 0 };
                runs.iter_mut().for_each(|runs| runs.push(&all[begin..ends[i] as usize]));
            }
        });
    }
}

/// The runs of each point; `None` if the ends do not ascend to their number.
fn split<'a>(ends: &[u64], runs: &'a [u32]) -> Option<Vec<&'a [u32]>> {
    let mut begin = 0;
    let all = ends.iter().map(|&end| {
        let end = usize::try_from(end).ok()?;
        let point = runs.get(begin..end)?;
        begin = end;
        Some(point)
    });
    let all: Option<Vec<_>> = all.collect();
    all.filter(|_| begin == runs.len())
}

impl IndirectField {
    fn check(&self, contents: &IndirectSnapshot) -> Result<(), Error> {
        let (sides, bounces) = (self.faces.count(), self.bounce_values.len() - 1);
        if contents.faces as usize != sides {
            let what = format!("have {} sides; this mesh keeps {sides}: it is of another method", contents.faces);
            return refuse("indirect values", what);
        }
        if contents.bounces as usize != bounces {
            let what = format!("go up to {} bounces; this mesh was made for {bounces}", contents.bounces);
            return refuse("indirect values", what);
        }
        self.points.check(&contents.points, "indirect")?;
        let shape = [self.bounce_values.len(), contents.points.addresses.len(), sides, 3];
        check_length("indirect values", contents.values.len(), &shape)?;
        check_finite("indirect values", &contents.values)?;
        if !(contents.hit_irradiance.is_finite() && contents.hit_irradiance >= 0.0) {
            return refuse("indirect", format!("the sum at gather hits is {}", contents.hit_irradiance));
        }
        let (new, bricks) = self.points.news(&contents.points);
        self.points.check_memory(new, bricks, self.costs(), self.max_memory)
    }

    /// Adds what is not known; it has been checked.
    fn absorb(&mut self, contents: &IndirectSnapshot) {
        let (count, one) = (contents.points.addresses.len(), 3 * self.faces.count());
        let Self { points, bounce_values: levels, .. } = self;
        let before = points.len();
        points.merge(&contents.points, |i| {
            for (k, level) in levels.iter_mut().enumerate() {
                level.extend(values(&contents.values[(k * count + i) * one..][..one]));
            }
        });
        // Of all that was gathered, the part of the points that are new: enough for an estimate.
        let part = (self.points.len() - before) as f64 / count.max(1) as f64;
        self.gather_hit_irradiance.0 += part * contents.hit_irradiance;
        self.gather_hit_irradiance.1 =
            self.gather_hit_irradiance.1.saturating_add((part * contents.hit_count as f64) as u64);
    }
}
