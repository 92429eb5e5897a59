//! What answers for each visible point of a tile, and where light is looked for further on.

use super::job::{Job, PixelNames, Work};
use super::layers::Band;
use crate::error::RenderError;
use crate::follow::{Following, Launch, Lit, MOST_FOLLOWED, RayQueue, least};
use crate::tile::VisiblePoints;
use crate::timings::FrameStage;
use glam::Vec3;
use rrf_materials::Bsdf;
use rrf_metrics::color::luminance;
use rrf_sampling::{Stage, Stream};
use rrf_scene::INVALID;

impl Job<'_> {
    /// Chooses the part of each row that sends rays on.
    pub(super) fn choose_followed(&self, work: &mut Work, depth: u32) {
        let Work { seen, followed, .. } = work;
        followed.clear();
        let following = Following {
            // emission that a first surface shows is direct light
            lamps: self.following.lamps && (depth > 0 || self.options.part.has_direct()),
            ..self.following
        };
        if !following.narrow && !following.lamps {
            return;
        }
        let camera_rays = (depth == 0).then_some(self.side * self.side);
        let surfaces = seen.normals.iter().zip(&seen.viewers).zip(&seen.materials);
        followed.extend(surfaces.zip(&seen.carried).map(
            |(((&normal, &viewer), material), carried)| {
                let throughput = luminance(carried.throughput);
                let part = following.part(material, (normal, viewer), throughput, camera_rays)?;
                match carried.lit {
                    Lit::Whole => Some(part),
                    _ => part.without_emission(),
                }
            },
        ));
    }

    /// Adds the model's light at the visible points, and which cells gave it. Where it is not believed,
    /// chooses how many rays gather the light.
    pub(super) fn add_indirect(
        &self,
        work: &mut Work,
        names: PixelNames,
        band: &mut Band,
        depth: u32,
    ) -> Result<(), RenderError> {
        let Work {
            seen,
            answers,
            watch,
            trust,
            ..
        } = &mut *work;
        let first = names.corner + (u64::from(depth) << 40);
        (self.lit).evaluate(self.tracer, seen, self.options, first, answers, watch)?;
        let asks = self.options.trusted.is_some() || self.options.fallback > 0;
        if asks && let Some(found) = self.lit.trust(self.options.trusted, seen, answers) {
            let materials = found.into_iter().zip(&seen.materials);
            // where nothing is asked for nothing is wrong
            trust.extend(materials.map(|(found, material)| found || !self.answers_for(material)));
            self.distrust_narrow(work, names, depth);
        }
        self.choose_gathered(work, depth);
        let Work {
            seen,
            answers,
            gathered,
            ..
        } = work;
        let radiance = (0..seen.points.len()).map(|row| {
            let is_gathered = gathered.get(row).is_some_and(|&rays| rays > 0);
            match (self.answers_for(&seen.materials[row]), is_gathered) {
                (false, _) => Vec3::ZERO,
                (true, false) => answers.radiance(row),
                (true, true) => answers.by_mirrors(row),
            }
        });
        self.add(band.indirect, seen, radiance);
        // Of the pixel's first row, which comes last here; of mirrors, what they show.
        let cells = seen.pixel.iter().zip(&answers.cells).zip(&seen.materials);
        for ((&pixel, &cell), material) in cells.rev() {
            let known = &mut band.cell[pixel as usize];
            let is_told = match depth {
                0 => !self.following.narrow || material.is_black() || self.answers_for(material),
                _ => *known == u32::MAX && self.answers_for(material),
            };
            if is_told {
                *known = cell;
            }
        }
        Ok(())
    }

    /// How many rays the broad part of each row sends in place of the model's answer: by final gather at
    /// first surfaces, as a fallback where the answer is not believed.
    fn choose_gathered(&self, work: &mut Work, depth: u32) {
        let Work {
            seen,
            trust,
            gathered,
            watch,
            ..
        } = work;
        let rows = 0..seen.points.len();
        if depth == 0 && self.options.gather > 0 {
            gathered.extend(
                rows.map(|row| match self.answers_for(&seen.materials[row]) {
                    true => self.options.gather,
                    false => 0,
                }),
            );
            return;
        }
        // the last surfaces of chains send no rays: the model's is the best guess
        if self.options.fallback == 0 || trust.is_empty() || depth + 1 >= MOST_FOLLOWED as u32 {
            return;
        }
        let each = self.options.fallback.div_ceil(self.side * self.side) as f32;
        gathered.extend(rows.map(|row| {
            if trust[row] || !self.answers_for(&seen.materials[row]) {
                return 0;
            }
            match seen.carried.get(row) {
                Some(carried) if carried.lit == Lit::Whole => (each
                    * luminance(carried.throughput).min(1.0))
                .ceil()
                .max(1.0) as u32,
                _ => 1,
            }
        }));
        watch.timings.2 += gathered.iter().filter(|&&rays| rays > 0).count() as u64;
    }

    /// Whether the model answers for a part of a material: no net was trained on what sends no light,
    /// such as a lamp, or on what is traced.
    pub(super) fn answers_for(&self, material: &Bsdf) -> bool {
        match self.following.narrow {
            true => material.broad().is_some_and(|broad| !broad.is_black()),
            false => !material.is_black(),
        }
    }

    /// Sends rays on from the visible points and adds the emission that they meet. The surfaces that
    /// they meet are the next visible points; `false` where there are none.
    pub(super) fn follow(
        &self,
        work: &mut Work,
        names: PixelNames,
        band: &mut Band,
        depth: u32,
    ) -> bool {
        let sends =
            work.followed.iter().any(Option::is_some) || work.gathered.iter().any(|&rays| rays > 0);
        let counted = work.watch.timings.1.get_mut(depth as usize);
        let Some(counted) = counted.filter(|_| sends) else {
            work.queue.clear();
            self.add_trust(work, band);
            return false;
        };
        work.queue.clear();
        let launch = Launch {
            tracer: self.tracer,
            lights: &self.sampled,
            stream: Stream::new(self.options.seed, Stage::Followed, depth),
            first: names.first,
            bright: self.patches.as_ref(),
            least: least(self.options.gather.max(self.options.fallback)),
        };
        (work.queue).launch(&launch, &mut work.seen, &work.followed, &work.gathered);
        *counted += work.queue.carried.len() as u64;
        work.queue.trace(self.tracer);
        self.add_trust(work, band);
        self.add_met_emission(&work.queue, band, depth);
        let queue = &work.queue;
        let rays = (&queue.rays, queue.carried.as_slice());
        work.seen.read_followed(self.tracer, rays, &queue.hits);
        self.light_gathered(&mut work.seen, band);
        work.watch.end(FrameStage::FollowedRays);
        depth + 1 < MOST_FOLLOWED as u32 && !work.seen.points.is_empty()
    }

    /// Weighs what was gathered by where it was looked for, and under a sky lights it by its patches where they are
    /// seen from afar.
    fn light_gathered(&self, seen: &mut VisiblePoints, band: &mut Band) {
        let Some(patches) = &self.patches else { return };
        // one shadow ray to a sky says little, to other lights more than their mean over a patch
        let has_sky = self.sampled.far.iter().any(|source| source.is_sky());
        for row in 0..seen.points.len() {
            let carried = seen.carried[row];
            if carried.lit != Lit::Widened {
                continue;
            }
            let (point, viewer) = (seen.points[row], seen.viewers[row]);
            if carried.guide > 0.0 {
                let rival = carried.guide * patches.density(&point, viewer);
                seen.carried[row].throughput /= 1.0 + rival;
            }
            if self.lit.is_on_mirror(point.position, seen.side(row)) {
                seen.carried[row].lit = Lit::Not;
                continue;
            }
            let baked = patches.baked(&point);
            let baked = baked.filter(|_| has_sky && carried.length >= patches.width(&point));
            let scene = self.tracer.scene();
            if let Some(sent) = baked.and_then(|at| self.lit.sent(scene, seen, row, &at)) {
                seen.carried[row].lit = Lit::Even;
                let throughput = seen.carried[row].throughput;
                band.indirect[carried.pixel as usize] += self.weight * throughput * sent;
            }
        }
    }

    /// Adds the trust of rows that the model answers for, but for what hangs on rays that they sent on, and
    /// of rows to which nothing comes.
    fn add_trust(&self, work: &Work, band: &mut Band) {
        let seen = &work.seen;
        for (row, (&pixel, &trust)) in seen.pixel.iter().zip(&work.trust).enumerate() {
            let share = seen.carried.get(row).map_or(1.0, |carried| carried.share);
            if trust {
                band.trust[pixel as usize] += self.weight * share;
            }
        }
        for &(pixel, share) in &work.queue.settled {
            band.trust[pixel as usize] += self.weight * share;
        }
    }

    /// Adds the emission that rays met which had met `depth` surfaces before their last one.
    fn add_met_emission(&self, queue: &RayQueue, band: &mut Band, depth: u32) {
        let part = self.options.part;
        let (layer, wanted) = match depth {
            0 => (&mut *band.direct, part.has_direct()),
            _ => (&mut *band.indirect, part.has_indirect()),
        };
        let met = queue.hits.triangle.iter().zip(&queue.hits.barycentrics);
        let rays = queue
            .rays
            .direction
            .iter()
            .zip(&queue.carried)
            .zip(&queue.hits.t);
        let lights = &self.tracer.scene().triangle_light;
        for (((&direction, carried), &distance), (&triangle, &at)) in rays.zip(met) {
            let pixel = carried.pixel as usize;
            if triangle == INVALID || !carried.is_meant_for(distance) {
                if wanted {
                    layer[pixel] += self.weight * carried.throughput * carried.far;
                }
                // no net is asked
                band.trust[pixel] += self.weight * carried.share;
                continue;
            }
            let light = lights[triangle as usize];
            if !wanted || !self.emission || light == INVALID {
                continue;
            }
            let point = self.tracer.point(triangle, at);
            let radiance =
                self.tracer.scene().area_lights[light as usize].radiance * self.dim(light);
            let weight = carried.lamp_weight(luminance(radiance));
            let emitted = self.emitted(&point, -direction);
            layer[pixel] += self.weight * weight * carried.throughput * emitted;
        }
    }
}
