//! A baked run, opened for frames and queries.

use crate::run_location::RunLocation;
use crate::trust::{distrust, spans};
use glam::Vec3;
use rrf_bake::Run;
use rrf_extract::VisibilityQueries;
use rrf_field::columns::Columns;
use rrf_field::{Borders, Field};
use rrf_render::{AreaLights, Lights};
use rrf_scene::Scene;
use rrf_store::model::{self, ModelTree};
use rrf_trace::Tracer;
use std::path::Path;

/// A baked run: everything that frames of it need but the tracer, which borrows the scene.
pub struct Baked {
    /// The run.
    pub run: Run,
    /// Its scene as baked, without its own lights.
    pub unlit: Scene,
    /// Its scene with them.
    pub scene: Scene,
    /// The nets.
    pub field: Field,
    /// Borders of its cells.
    pub borders: Borders,
    tree: ModelTree,
    /// Keeps the run's files for as long as it is open.
    _location: RunLocation,
}

impl Baked {
    /// Reads the run, its scene and its model.
    /// Cells of a larger error than `trust_error` are not trusted.
    pub fn open(folder: &Path, trust_error: f32) -> anyhow::Result<Baked> {
        let location = RunLocation::model(folder)?;
        let run = Run::open(location.folder())?;
        let scene = run.load_scene()?;
        let mut model = model::read_model(&run.folder, &run.facts())?;
        let metrics = model::read_metrics(&run.folder, &run.facts())?;
        let spans = spans(&model.tree);
        distrust(&mut model.tree, &metrics, f64::from(trust_error));
        let field = Field::new(model.tree.tree.clone(), model.cells)?;
        Ok(Baked {
            unlit: scene.clone().unlit(),
            scene,
            run,
            borders: Borders::new(&field, spans),
            field,
            tree: model.tree,
            _location: location,
        })
    }

    /// Least and greatest corner of the baked light box.
    pub fn light_box(&self) -> [Vec3; 2] {
        let [x0, y0, z0, x1, y1, z1] = self.run.manifest.light_box;
        [Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1)]
    }

    /// Least and greatest corner of the box that eyes were expected in.
    pub fn eye_box(&self) -> Option<[Vec3; 2]> {
        let eye_box = self.run.config.extract.eye_box?;
        Some([eye_box.minimum, eye_box.maximum].map(Vec3::from))
    }

    /// The scene that frames are traced in: with its area lights where they shine.
    pub fn shown(&self, lights: &Lights) -> &Scene {
        if self.has_area_lights(lights) {
            &self.scene
        } else {
            &self.unlit
        }
    }

    /// The area lights, where they shine; how well their proxies light the nets is said on
    /// standard error.
    pub fn area_lights(&self, lights: &Lights) -> anyhow::Result<Option<AreaLights>> {
        if !self.has_area_lights(lights) {
            return Ok(None);
        }
        let tracer = Tracer::new(&self.unlit)?;
        let visibility = VisibilityQueries::new(&self.unlit, &tracer);
        let free = |p: Vec3| !visibility.inside_solid(p);
        let area_lights = AreaLights::new(&self.scene, &self.field, self.light_box(), free)?;
        for (k, proxy) in area_lights.proxies.iter().enumerate() {
            eprintln!(
                "area light {k}: the nets light it as {} points; the error of its indirect light is {:.1} %",
                proxy.points.len(),
                100.0 * proxy.error
            );
        }
        Ok(Some(area_lights))
    }

    fn has_area_lights(&self, lights: &Lights) -> bool {
        lights.area && !self.scene.area_lights.is_empty()
    }

    /// Whether the nets were trained for each of the rows, and well enough.
    pub fn trusted(&self, rows: &Columns) -> Vec<bool> {
        self.tree.trusted(rows)
    }
}
