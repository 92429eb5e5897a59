//! A baked run, opened for frames and queries.

use crate::run_location::{RunLocation, expect_run};
use crate::trust::{distrust, spans};
use glam::Vec3;
use rrf_bake::{Run, RunMethod, TransferRun};
use rrf_extract::VisibilityQueries;
use rrf_field::columns::Columns;
use rrf_field::{Borders, Field};
use rrf_render::{AreaLights, Lights, Renderer};
use rrf_scene::Scene;
use rrf_store::manifest::RunManifest;
use rrf_store::model::{self, ModelTree};
use rrf_trace::Tracer;
use rrf_transfer::{LightBook, TransferModel};
use std::path::Path;

/// A baked run: everything that frames of it need but the tracer, which borrows the scene.
pub struct Baked {
    /// `run.json`.
    pub manifest: RunManifest,
    /// Its scene as baked, without its own lights.
    pub unlit: Scene,
    /// Its scene with them.
    pub scene: Scene,
    /// What answers for its indirect light.
    pub model: BakedModel,
    eye_box: Option<[Vec3; 2]>,
    /// Keeps the run's files for as long as it is open.
    _location: RunLocation,
}

/// What answers for the indirect light of a run.
pub enum BakedModel {
    /// Nets that see point lights.
    Nets(Box<BakedNets>),
    /// A transfer.
    Transfer(Box<TransferModel>),
}

/// The nets of a run.
pub struct BakedNets {
    /// The nets.
    pub field: Field,
    /// Borders of its cells.
    pub borders: Borders,
    traces_narrow: bool,
    tree: ModelTree,
}

/// A model that is ready for lights.
pub enum ReadyModel<'a> {
    /// Nets.
    Nets(&'a BakedNets),
    /// A transfer and the lights that it knows.
    Transfer(Box<LightBook<'a>>),
}

impl Baked {
    /// Reads the run, its scene and its model.
    /// Cells of a larger error than `trust_error` are not trusted.
    pub fn open(folder: &Path, trust_error: f32) -> anyhow::Result<Baked> {
        expect_run(folder)?;
        let location = RunLocation::model(folder)?;
        match RunMethod::of(location.folder())? {
            RunMethod::Nets => Baked::of_nets(location, trust_error),
            RunMethod::Transfer => Baked::of_transfer(location, trust_error),
        }
    }

    fn of_nets(location: RunLocation, trust_error: f32) -> anyhow::Result<Baked> {
        let run = Run::open(location.folder())?;
        let scene = run.load_scene()?;
        let mut model = model::read_model(&run.folder, &run.facts())?;
        let metrics = model::read_metrics(&run.folder, &run.facts())?;
        let spans = spans(&model.tree);
        distrust(&mut model.tree, &metrics, f64::from(trust_error));
        let field = Field::new(model.tree.tree.clone(), model.cells)?;
        let (eye_box, narrow) = (run.config.extract.eye_box, run.config.extract.narrow);
        Ok(Baked {
            unlit: scene.clone().unlit(),
            scene,
            manifest: run.manifest,
            eye_box: eye_box.map(|b| [b.minimum, b.maximum].map(Vec3::from)),
            model: BakedModel::Nets(Box::new(BakedNets {
                borders: Borders::new(&field, spans),
                field,
                traces_narrow: !narrow.is_learned(),
                tree: model.tree,
            })),
            _location: location,
        })
    }

    fn of_transfer(location: RunLocation, trust_error: f32) -> anyhow::Result<Baked> {
        let run = TransferRun::open(location.folder())?;
        let scene = run.load_scene()?;
        let unlit = scene.unlit();
        let (mut model, _) = run.model(&unlit)?;
        model.trust = trust_error;
        let eye_box = run.config.eye_box;
        Ok(Baked {
            unlit,
            scene,
            manifest: run.manifest,
            eye_box: eye_box.map(|b| [b.minimum, b.maximum].map(Vec3::from)),
            model: BakedModel::Transfer(Box::new(model)),
            _location: location,
        })
    }

    /// Least and greatest corner of the baked light box.
    pub fn light_box(&self) -> [Vec3; 2] {
        let [x0, y0, z0, x1, y1, z1] = self.manifest.light_box;
        [Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1)]
    }

    /// Least and greatest corner of the box that eyes were expected in.
    pub fn eye_box(&self) -> Option<[Vec3; 2]> {
        self.eye_box
    }

    /// The nets, where the run has some.
    pub fn nets(&self) -> Option<&BakedNets> {
        match &self.model {
            BakedModel::Nets(nets) => Some(nets),
            BakedModel::Transfer(_) => None,
        }
    }

    /// The model ready for lights; `unlit` is the tracer of the scene as baked.
    pub fn ready<'a>(&'a self, unlit: &'a Tracer<'a>) -> anyhow::Result<ReadyModel<'a>> {
        Ok(match &self.model {
            BakedModel::Nets(nets) => ReadyModel::Nets(nets),
            BakedModel::Transfer(model) => {
                ReadyModel::Transfer(Box::new(LightBook::new(model, unlit)?))
            }
        })
    }

    /// The area lights, where they shine; how well their proxies light the nets is said on
    /// standard error.
    pub fn area_lights(&self, lights: &Lights) -> anyhow::Result<Option<AreaLights>> {
        if !self.has_area_lights(lights) {
            return Ok(None);
        }
        let Some(nets) = self.nets() else {
            return Ok(Some(AreaLights::without_proxies(&self.scene)));
        };
        let tracer = Tracer::new(&self.unlit)?;
        let visibility = VisibilityQueries::new(&self.unlit, &tracer);
        let free = |p: Vec3| !visibility.inside_solid(p);
        let area_lights = AreaLights::new(&self.scene, &nets.field, self.light_box(), free)?;
        for (k, proxy) in area_lights.proxies.iter().enumerate() {
            eprintln!(
                "area light {k}: the nets light it as {} points; the error of its indirect light is {:.1} %",
                proxy.points.len(),
                100.0 * proxy.error
            );
        }
        Ok(Some(area_lights))
    }

    /// Whether lamps shine, so that frames are traced in the scene that has them.
    pub fn has_area_lights(&self, lights: &Lights) -> bool {
        lights.area && !self.scene.area_lights.is_empty()
    }

    /// Whether the light of narrow parts is traced, since the model was made without it.
    pub fn traces_narrow(&self) -> bool {
        match &self.model {
            BakedModel::Nets(nets) => nets.traces_narrow,
            BakedModel::Transfer(model) => model.broad,
        }
    }

    /// Whether the nets were trained for each of the rows, and well enough. A transfer says so of
    /// itself, with each answer.
    pub fn trusted(&self, rows: &Columns) -> Vec<bool> {
        self.nets()
            .map_or_else(Vec::new, |nets| nets.tree.trusted(rows))
    }
}

impl<'a> ReadyModel<'a> {
    /// A renderer of frames of `tracer`'s scene.
    pub fn renderer(&'a self, tracer: &'a Tracer<'a>) -> Renderer<'a> {
        match self {
            ReadyModel::Nets(nets) => {
                Renderer::new(tracer, &nets.field).tracing_narrow(nets.traces_narrow)
            }
            ReadyModel::Transfer(book) => Renderer::of_transfer(tracer, book),
        }
    }
}
