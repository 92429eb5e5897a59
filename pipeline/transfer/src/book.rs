//! Lights as a model knows them, kept light by light: what stands still is asked for once.
//!
//! Lights are kept in white. A light that changes its colour or is turned off costs a sum over
//! coefficients; one that moves costs its shadow rays.

use crate::TransferError;
use crate::bright::{BrightPatches, powers};
use crate::irradiance::Receivers;
use crate::lights::DirectLight;
use crate::model::{LightCoefficients, TransferAnswer, TransferModel};
use crate::patches::Patches;
use crate::query::TransferQuery;
use crate::rows::RowPoint;
use crate::sources::{
    FlatMirrors, Lamp, SourceLight, WhiteLamp, fingerprint, in_white, white_lamps,
};
use crate::tracing::{Bsdf, Stream, SurfacePoint, Tracer};
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_sampling::Stage;
use rrf_scene::Scene;
use std::f32::consts::FRAC_1_PI;
use std::sync::{Arc, Mutex, MutexGuard};

/// Share of a light that cells may leave out, by its residual, for answers under it to be trusted.
pub const MOST_RESIDUAL: f32 = 0.1;

/// Lights that are kept at the most: moving ones leave one a frame.
const KEPT: usize = 64;

/// A light in white as a model knows it.
#[derive(Clone, Debug)]
struct KnownLight {
    coefficients: LightCoefficients,
    /// [`TransferModel::residual`].
    residual: f32,
    /// Irradiance of every column [W/m²].
    irradiance: Vec<Vec3>,
}

/// A model's lights.
pub struct LightBook<'a> {
    model: &'a TransferModel,
    receivers: Receivers<'a>,
    mirrors: FlatMirrors<'a>,
    stream: Stream,
    /// No light at all.
    dark: LightCoefficients,
    /// By fingerprint, the least recently used first.
    kept: Mutex<Vec<(u64, Arc<KnownLight>)>>,
}

/// One light of a frame: white, and its colour.
enum Shining {
    Source(LightSource),
    Lamp(Lamp),
}

/// All lights of a frame as a model knows them.
pub struct LitTransfer<'a> {
    book: &'a LightBook<'a>,
    /// Their sum.
    pub coefficients: LightCoefficients,
    /// Largest residual of any of them.
    pub residual: f32,
    shining: Vec<(Shining, Vec3)>,
    /// Irradiance of every column [W/m²].
    irradiance: Vec<Vec3>,
}

impl<'a> LightBook<'a> {
    /// The lights of a model in its scene; `tracer` is that of the bake.
    ///
    /// # Errors
    /// Those of [`TransferModel::coefficients`].
    pub fn new(
        model: &'a TransferModel,
        tracer: &'a Tracer<'a>,
    ) -> Result<LightBook<'a>, TransferError> {
        Ok(LightBook {
            dark: model.coefficients(&vec![Vec3::ZERO; model.patches.columns()])?,
            model,
            receivers: model.receivers(tracer),
            mirrors: FlatMirrors::new(tracer),
            stream: Stream::new(model.seed, Stage::Transfer, 1),
            kept: Mutex::default(),
        })
    }

    /// The model.
    pub fn model(&self) -> &'a TransferModel {
        self.model
    }

    /// The sum of lights: sources, and the lamps of a scene where it is given.
    ///
    /// # Errors
    /// Those of [`TransferModel::coefficients`].
    pub fn under(
        &'a self,
        sources: &[LightSource],
        lamps: Option<&Scene>,
    ) -> Result<LitTransfer<'a>, TransferError> {
        let mut lit = LitTransfer {
            book: self,
            coefficients: self.dark.clone(),
            residual: 0.0,
            shining: Vec::new(),
            irradiance: vec![Vec3::ZERO; self.model.patches.columns()],
        };
        for source in sources {
            let (white, colour) = in_white(source);
            let key = fingerprint(&white);
            let known = self.known(key, || Box::new(SourceLight::new(&white, self.stream)))?;
            lit.add(Shining::Source(white), colour, &known);
        }
        for WhiteLamp { lamp, colour, key } in
            lamps.map_or_else(Vec::new, |s| white_lamps(s, self.stream))
        {
            let known = self.known(key, || Box::new(&lamp))?;
            lit.add(Shining::Lamp(lamp), colour, &known);
        }
        Ok(lit)
    }

    /// A light that is kept, or asked for now.
    fn known<'l>(
        &self,
        key: u64,
        light: impl FnOnce() -> Box<dyn DirectLight + 'l>,
    ) -> Result<Arc<KnownLight>, TransferError> {
        let found = {
            let mut kept = self.kept();
            let place = kept.iter().position(|(of, _)| *of == key);
            place.map(|place| {
                let entry = kept.remove(place);
                kept.push(entry.clone());
                entry.1
            })
        };
        if let Some(found) = found {
            return Ok(found);
        }
        let irradiance = self.receivers.irradiance(&self.mirrors.of(light()));
        let (coefficients, residual) = self.model.known(&irradiance)?;
        let known = Arc::new(KnownLight {
            irradiance,
            coefficients,
            residual,
        });
        let mut kept = self.kept();
        if kept.len() >= KEPT {
            kept.remove(0);
        }
        kept.push((key, known.clone()));
        Ok(known)
    }

    /// A thread that panicked may leave the list poisoned, but never half changed.
    fn kept(&self) -> MutexGuard<'_, Vec<(u64, Arc<KnownLight>)>> {
        self.kept.lock().unwrap_or_else(|p| p.into_inner())
    }
}

impl<'a> LitTransfer<'a> {
    fn add(&mut self, light: Shining, colour: Vec3, known: &KnownLight) {
        if colour == Vec3::ZERO {
            return;
        }
        self.coefficients.add_scaled(&known.coefficients, colour);
        self.residual = self.residual.max(known.residual);
        let columns = self.irradiance.iter_mut().zip(&known.irradiance);
        columns.for_each(|(sum, own)| *sum += *own * colour);
        self.shining.push((light, colour));
    }

    /// Radiance [W/(sr m²)] that a point sends to its viewer of the light that reaches its patch straight or
    /// by way of a flat mirror, taken as even over the patch, as rows take it; `bsdf` is its material. None where
    /// no row has seen the patch, so that its light was not asked for.
    pub fn sent(&self, point: &SurfacePoint, query: &TransferQuery, bsdf: &Bsdf) -> Option<Vec3> {
        let model = self.book.model;
        let (patch, n) = (model.patches.patch(point)?, query.shading);
        let first = model.patches.first_column(patch, query.surface.back) as usize;
        let count = model.patches.directions(patch);
        let columns = first..first + (count * count) as usize;
        if !model.used.get(columns.clone())?.contains(&true) {
            return None;
        }
        if count == 1 {
            let facing = query.facing();
            let [base, constant] = model.reflectances.at(query.surface.material, facing);
            let albedo = query.base_color * base + constant;
            return Some(albedo * self.irradiance[first] * FRAC_1_PI);
        }
        let cells = (0..).zip(&self.irradiance[columns]);
        let lit = cells.filter(|(_, e)| **e != Vec3::ZERO).map(|(cell, &e)| {
            let l = model.patches.middle_direction(patch, n, cell);
            bsdf.eval(n, query.viewer, l) * e / n.dot(l).max(f32::MIN_POSITIVE)
        });
        Some(lit.sum())
    }

    /// Irradiance of every column [W/m²].
    pub fn irradiance(&self) -> &[Vec3] {
        &self.irradiance
    }

    /// The model's patches.
    pub fn patches(&self) -> &'a Patches {
        &self.book.model.patches
    }

    /// Patches by the light that reaches them; none where all is dark.
    pub fn bright(&self) -> Option<BrightPatches<'a>> {
        let patches = &self.book.model.patches;
        BrightPatches::new(patches, &powers(patches, &self.irradiance))
    }

    /// Indirect radiance of points by the model, without what flat mirrors add.
    pub fn evaluate(&self, queries: &[TransferQuery]) -> Vec<TransferAnswer> {
        self.book.model.evaluate(&self.coefficients, queries)
    }

    /// Whether a place on a surface of that normal lies on a flat mirror: what it throws straight on
    /// others is in [`LitTransfer::by_mirrors`].
    pub fn is_on_mirror(&self, position: Vec3, normal: Vec3) -> bool {
        self.book.mirrors.has(position, normal)
    }

    /// Radiance [W/(sr m²)] that rows send by way of a flat mirror and their own surface, which no
    /// model holds ([`FlatMirrors::at_rows`]). Row i, of `tracer`'s scene, has the name `first + i`.
    pub fn by_mirrors(&self, tracer: &Tracer, rows: &[RowPoint], first: u64) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; rows.len()];
        if self.book.mirrors.is_empty() {
            return sum;
        }
        for (light, colour) in &self.shining {
            let light: Box<dyn DirectLight> = match light {
                Shining::Source(source) => Box::new(SourceLight::new(source, self.book.stream)),
                Shining::Lamp(lamp) => Box::new(lamp),
            };
            let own =
                self.book
                    .mirrors
                    .at_rows_in(tracer, self.book.model.broad, &light, rows, first);
            sum.iter_mut()
                .zip(own)
                .for_each(|(sum, own)| *sum += own * *colour);
        }
        sum
    }
}
