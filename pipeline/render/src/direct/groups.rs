//! Lights to be sampled, in groups, and which of them blocks of pixels have found to be hidden.

use super::emitter::Emitter;
use super::light_tree::LightTree;
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_materials::Bsdf;
use rrf_metrics::color::luminance;

/// Side of a block in pixels.
const BLOCK: u32 = 8;
/// The least that a group counts which a block has not seen: light that is missed so far is still
/// found, and no ray weighs more than ten times what it would without learning.
const LEAST_SEEN: f32 = 0.1;
/// Roughness from which on a lobe counts as even.
const BROAD: f32 = 0.7;
/// Base level of surfaces, for lobes beside it.
const LEAST_BASE: f32 = 0.05;
/// Shadow rays that a row is taken to have.
const USUAL_RAYS: f32 = 16.0;

/// Lights to be sampled: those with a place, and those from afar.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampledLights<'f> {
    pub(crate) emitters: Vec<Emitter>,
    pub(crate) tree: LightTree,
    pub(crate) far: Vec<&'f LightSource>,
    /// Irradiance of each light from afar, by luminance.
    far_level: Vec<f32>,
}

impl<'f> SampledLights<'f> {
    pub(crate) fn new(emitters: Vec<Emitter>, far: Vec<&'f LightSource>) -> SampledLights<'f> {
        // through a sphere of cross section 1; a surface gets a quarter of what comes from all around
        let radius = (1.0 / std::f32::consts::PI).sqrt();
        let level = |source: &&LightSource| match source {
            LightSource::Environment(_) => 0.25 * luminance(source.power(radius)),
            _ => luminance(source.power(radius)),
        };
        SampledLights {
            tree: LightTree::new(&emitters),
            emitters,
            far_level: far.iter().map(level).collect(),
            far,
        }
    }

    /// How much light could arrive at a point whose surface faces `side`: what the choice among
    /// lights is made by, material left out.
    pub(crate) fn level_at(&self, at: Vec3, side: Vec3) -> f32 {
        let groups = (0..self.tree.groups()).map(|group| self.tree.reach(group, at, side).0);
        groups.chain(self.far_level.iter().copied()).sum()
    }

    /// About the density [1/sr] of a row's shadow rays to a lamp of some level, where lights of
    /// [`SampledLights::level_at`] arrive. The weights of shadow rays and of the rays that meet lamps
    /// by themselves follow from it; an approximation does no harm, since they sum to one.
    pub(crate) fn shadow_density(level: f32, all: f32) -> f32 {
        USUAL_RAYS * level / all.max(f32::MIN_POSITIVE)
    }

    /// Radiance that a ray brings from afar; `rival` as in [`crate::follow::Carried`].
    pub(crate) fn far_beside_shadow_rays(&self, at: Vec3, toward: Vec3, rival: f32) -> Vec3 {
        let lights = self.far.iter().zip(&self.far_level);
        let weighted = lights.map(|(light, level)| {
            let density = level * light.density(at, toward).max(f32::MIN_POSITIVE);
            light.radiance(toward) / (1.0 + rival * density)
        });
        weighted.sum()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.emitters.is_empty() && self.far.is_empty()
    }

    /// Lights, each by itself.
    pub(crate) fn count(&self) -> usize {
        self.emitters.len() + self.far.len()
    }

    /// Groups of lights: those of the tree, then each light from afar.
    pub(crate) fn groups(&self) -> usize {
        self.tree.groups() + self.far.len()
    }

    /// How much of each group's light could leave a visible point by `material`, in proportion,
    /// appended.
    pub(crate) fn reach(
        &self,
        seen: &VisiblePoints,
        row: usize,
        material: &Bsdf,
        reach: &mut Vec<f32>,
    ) {
        if !seen.is_asked(row) {
            reach.extend(std::iter::repeat_n(0.0, self.groups()));
            return;
        }
        let (point, v, normal) = (&seen.points[row], seen.viewers[row], seen.normals[row]);
        let side = seen.side(row);
        let base = luminance(material.base_color).max(LEAST_BASE) / std::f32::consts::PI;
        // beside an even lobe, the light of the group's middle alone where the lobe is another
        let lobe = |l: Vec3| {
            let cosine = normal.dot(l);
            match material.roughness >= BROAD || cosine <= 0.0 {
                true => 0.0,
                false => luminance(material.eval(normal, v, l)) / cosine,
            }
        };
        for group in 0..self.tree.groups() {
            let (bound, middle) = self.tree.reach(group, point.position, side);
            let factor = match bound > 0.0 {
                true => base + lobe((middle - point.position).normalize_or_zero()),
                false => 0.0,
            };
            reach.push(bound * factor);
        }
        reach.extend(self.far_level.iter().map(|level| level * base));
    }
}

/// A point of a light that a shadow ray goes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// Unit direction to it.
    pub(crate) toward: Vec3,
    /// Where the ray ends; light from afar has no place.
    pub(crate) place: Option<Vec3>,
    /// Unoccluded irradiance on a surface square to it [W/m²].
    pub(crate) irradiance: Vec3,
    /// Level of the lamp, times its own density if it is afar; `None` for points, which rays do not
    /// meet.
    pub(crate) level: Option<f32>,
}

impl SampledLights<'_> {
    /// A point of a light, counted over all of them.
    pub(crate) fn end_of(
        &self,
        seen: &VisiblePoints,
        row: usize,
        light: u32,
        u: [f32; 2],
    ) -> Option<End> {
        let x = seen.points[row].position;
        let Some(emitter) = self.emitters.get(light as usize) else {
            let far = (light as usize).checked_sub(self.emitters.len())?;
            let arrival = self.far.get(far)?.sample(x, u)?;
            return Some(End {
                toward: arrival.toward,
                place: None,
                irradiance: arrival.irradiance,
                level: arrival.density.map(|density| density * self.far_level[far]),
            });
        };
        let place = emitter.place(u);
        Some(End {
            toward: (place - x).normalize_or_zero(),
            place: Some(emitter.before(place, x)),
            irradiance: emitter.arriving(place, x),
            level: (emitter.level > 0.0).then_some(emitter.level),
        })
    }

    /// A point of a light of a group, and the light's probability in it.
    pub(crate) fn end_in_group(
        &self,
        seen: &VisiblePoints,
        row: usize,
        (group, left): (u32, f32),
        u: [f32; 2],
    ) -> Option<(End, f32)> {
        let Some(far) = (group as usize).checked_sub(self.tree.groups()) else {
            let (point, side) = (&seen.points[row], seen.side(row));
            let (light, share) = self
                .tree
                .choose(group as usize, point.position, side, left)?;
            return Some((self.end_of(seen, row, light, u)?, share));
        };
        let end = self.end_of(seen, row, (self.emitters.len() + far) as u32, u)?;
        Some((end, 1.0))
    }
}

/// Which groups the rays of a block have found to be hidden.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockVisibility {
    groups: usize,
    /// Block of each row.
    block: Vec<u32>,
    /// Rays of each block to each group, and those of them that nothing blocked.
    looked: Vec<u32>,
    lit: Vec<u32>,
    /// Rows of each block, and the sum of their variances.
    rows: Vec<u32>,
    variance: Vec<f64>,
}

impl BlockVisibility {
    /// Forgets everything; sorts the rows into blocks.
    pub(crate) fn begin(&mut self, seen: &VisiblePoints, groups: usize, width: u32) {
        let across = width.div_ceil(BLOCK);
        let blocks = seen.pixel.iter().map(|&pixel| {
            let (x, y) = (pixel % width, pixel / width);
            y / BLOCK * across + x / BLOCK
        });
        self.block.clear();
        self.block.extend(blocks);
        // numbered from 0 within the tile
        let mut names: Vec<u32> = self.block.clone();
        names.sort_unstable();
        names.dedup();
        for block in &mut self.block {
            *block = names.partition_point(|name| name < block) as u32;
        }
        self.groups = groups;
        for counts in [&mut self.looked, &mut self.lit] {
            counts.clear();
            counts.resize(names.len() * groups, 0);
        }
        self.rows.clear();
        self.rows.resize(names.len(), 0);
        self.variance.clear();
        self.variance.resize(names.len(), 0.0);
    }

    fn block(&self, row: usize) -> usize {
        self.block[row] as usize
    }

    /// Learns from a ray to a group.
    pub(crate) fn note(&mut self, row: usize, group: usize, is_lit: bool) {
        let place = self.block(row) * self.groups + group;
        self.looked[place] += 1;
        self.lit[place] += u32::from(is_lit);
    }

    /// Learns the variance of a row's rays.
    pub(crate) fn note_variance(&mut self, row: usize, variance: f32) {
        let block = self.block(row);
        self.rows[block] += 1;
        self.variance[block] += f64::from(variance);
    }

    /// Share of a group that the block of a row sees, at least [`LEAST_SEEN`]; 1 where it has not
    /// looked.
    pub(crate) fn share(&self, row: usize, group: usize) -> f32 {
        let place = self.block(row) * self.groups + group;
        let (looked, lit) = (self.looked[place], self.lit[place]);
        ((lit + 1) as f32 / (looked + 1) as f32).max(LEAST_SEEN)
    }

    /// Mean variance of the rays of a row's block.
    pub(crate) fn variance(&self, row: usize) -> f32 {
        let block = self.block(row);
        (self.variance[block] / f64::from(self.rows[block].max(1))) as f32
    }
}
