//! Dividing area lights into strata, and the patches that represent these.

use std::ops::Range;

use glam::Vec3;

use super::super::sample::{LightSample, Patch};
use super::super::stratum::{LaneStratum, Reach, Stratum};
use super::area::{AreaLight, AreaLights};
use super::bulb::bulb;
use super::strata::{Count, Item, stratify};
use crate::sampling::{hash, seed_of_position};
use crate::scene::{Light, SceneData};

/// How a light is to be divided into strata.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrangement {
    /// Strata of what is not weak, and of what is.
    pub strata: [u32; 2],
    /// Pieces up to this luminance are weak, cd/m².
    pub weak_below: f32,
    /// Whether the light is small for what it lights, so that a point may stand for it if it shines every way.
    pub is_small: bool,
}

/// The strata of one light, and patches that represent them.
#[derive(Debug, Default)]
pub(super) struct LightStrata {
    pub sampled: Vec<(LightSample, LaneStratum)>,
    pub weak: Vec<(LightSample, LaneStratum)>,
}

/// In a stratum whose mean normal is shorter than this, no side is the front.
const ONE_FRONT: f32 = 0.35;

/// The strata of a light whose pieces face in different directions are at most so many times as many as wanted.
const MOST_STRATA: u32 = 4;

impl AreaLights {
    /// Divides each light into strata; what is sampled comes first. Returns them light by light.
    pub(super) fn arrange(&mut self, data: &SceneData, arrangements: &[Arrangement]) -> Vec<LightStrata> {
        self.strata.clear();
        self.bulbs.clear();
        let mut all = Vec::with_capacity(self.lights.len());
        for (index, &Arrangement { strata: [sampled, weak], weak_below, is_small }) in arrangements.iter().enumerate() {
            self.lights[index].weak_below = weak_below;
            let Range { start, end } = self.lights[index].pieces;
            let is_weak = |piece: u32| self.pieces.luminance[piece as usize] <= weak_below;
            let shines = |piece: u32| self.pieces.luminance[piece as usize] > 0.0;
            let lists = [
                (start..end).filter(|&p| shines(p) && !is_weak(p)).collect::<Vec<_>>(),
                (start..end).filter(|&p| shines(p) && is_weak(p)).collect(),
                (start..end).filter(|&p| !shines(p)).collect(),
            ];
            let [bright, faint, dark] = lists;
            let mut place = start;
            let sampled = self.stratify(data, index, bright, sampled, is_small, &mut place);
            let weak = self.stratify(data, index, faint, weak, false, &mut place);
            for piece in dark {
                self.order[place as usize] = piece;
                place += 1;
            }
            all.push(LightStrata { sampled, weak });
        }
        self.sum();
        all
    }

    /// Puts pieces of a light into the order, stratum by stratum, and returns these.
    fn stratify(
        &mut self,
        data: &SceneData,
        index: usize,
        pieces: Vec<u32>,
        wanted: u32,
        is_small: bool,
        place: &mut u32,
    ) -> Vec<(LightSample, LaneStratum)> {
        if pieces.is_empty() || wanted == 0 {
            for piece in pieces {
                self.order[*place as usize] = piece;
                *place += 1;
            }
            return Vec::new();
        }
        // Sort them.
        let light = self.lights[index].clone();
        let two_sided = self.material(data, &light).double_sided;
        let middle = |&piece: &u32| {
            let point = self.primitive(data, &light, piece).middle(self.pieces.cells[piece as usize]);
            (piece, point.position, point.normal)
        };
        let middles: Vec<_> = pieces.iter().map(middle).collect();
        let min = middles.iter().fold(Vec3::INFINITY, |min, (_, p, _)| min.min(*p));
        let max = middles.iter().fold(Vec3::NEG_INFINITY, |max, (_, p, _)| max.max(*p));
        let facing = (0.5 * (max - min).length()).max(f32::MIN_POSITIVE);
        let item = |(piece, position, normal): (u32, Vec3, Vec3)| {
            let normal = if two_sided { upper(normal) } else { normal };
            let weight = self.pieces.areas[piece as usize] * self.pieces.luminance[piece as usize];
            Item::of_surface(position, normal, facing, weight, piece)
        };
        let mut items: Vec<Item> = middles.into_iter().map(item).collect();
        let runs = stratify(&mut items, Count { wanted, most: MOST_STRATA * wanted, facing });
        // Represent the whole by a point, or each run by a patch.
        let bulb = if is_small { bulb(&items, facing, &self.pieces) } else { None };
        let mut strata = Vec::with_capacity(runs.len());
        if let Some(bulb) = &bulb {
            let whole =
                items.iter().map(|item| self.emission(data, &light, item.index) * self.area_of(item)).sum::<Vec3>();
            let sample = Light::Point { position: bulb.middle, intensity_cd: 0.25 * whole, range: None };
            let reach = Reach { radius: bulb.reach, spread: 0.0 };
            let stratum = Stratum::Bulb(self.bulbs.len() as u32);
            strata.push((LightSample::Punctual(sample), LaneStratum { stratum, reach }));
            self.bulbs.push(*bulb);
        }
        for run in runs.into_iter().filter(|_| bulb.is_none()) {
            let items = &items[run.start as usize..run.end as usize];
            if let Some((patch, reach)) = self.represent(data, &light, items, facing) {
                let stratum = Stratum::Area(self.strata.len() as u32);
                strata.push((LightSample::Patch(patch), LaneStratum { stratum, reach }));
                self.strata.push(*place + run.start..*place + run.end);
            }
        }
        for item in items {
            self.order[*place as usize] = item.index;
            *place += 1;
        }
        strata
    }

    /// Returns a flat patch with the light of some pieces of a light, and how far they reach.
    fn represent(&self, data: &SceneData, light: &AreaLight, items: &[Item], facing: f32) -> Option<(Patch, Reach)> {
        let material = self.material(data, light);
        // Average place, normal and emission.
        let (mut position, mut normal, mut weight) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        let (mut intensity_cd, mut area) = (Vec3::ZERO, 0.0);
        let origin = Vec3::from_slice(&items[0].at[..3]);
        for item in items {
            position += (Vec3::from_slice(&item.at[..3]) - origin) * item.weight;
            normal += Vec3::from_slice(&item.at[3..]) * item.weight;
            weight += item.weight;
            let (piece_area, emission) = (self.area_of(item), self.emission(data, light, item.index));
            intensity_cd += emission * piece_area;
            area += piece_area;
        }
        if weight <= 0.0 || intensity_cd == Vec3::ZERO {
            return None;
        }
        let (mut position, mut normal) = (origin + position / weight, normal / (weight * facing));
        let has_front = normal.length() >= ONE_FRONT;
        // Stay on a surface that is not flat: at any of its pieces, for those in the middle of each stratum would give
        // too little light from the side.
        let off = |item: &Item| (Vec3::from_slice(&item.at[..3]) - position).dot(normal).abs();
        let is_flat = normal.length() > 0.9999 && items.iter().all(|item| off(item) < 1e-4 * facing);
        if !is_flat {
            let number = |item: &&Item| hash(seed_of_position(Vec3::from_slice(&item.at[..3])));
            let any = items.iter().min_by_key(number)?;
            (position, normal) = (Vec3::from_slice(&any.at[..3]), Vec3::from_slice(&any.at[3..]) / facing);
        }
        // What faces every way shines from both sides, each with half of the light.
        let half = if has_front || material.double_sided { 1.0 } else { 0.5 };
        let normal = normal.normalize_or(Vec3::Y);
        let mut reach = Reach::default();
        for item in items {
            let (p, n) = (Vec3::from_slice(&item.at[..3]), Vec3::from_slice(&item.at[3..]) / facing);
            reach.radius = reach.radius.max((p - position).length());
            reach.spread = reach.spread.max((n - normal).length());
        }
        // The furthest piece is no point.
        reach.radius += (2.0 * area / items.len() as f32).sqrt();
        let patch = Patch {
            position,
            normal,
            intensity_cd: intensity_cd * half,
            area: area * half,
            two_sided: material.double_sided || !has_front,
        };
        Some((patch, reach))
    }
}

/// Returns n or −n, so that both sides of a surface have one normal.
fn upper(n: Vec3) -> Vec3 {
    let first = n.to_array().into_iter().find(|c| c.abs() > 1e-3).unwrap_or(1.0);
    if first < 0.0 { -n } else { n }
}
