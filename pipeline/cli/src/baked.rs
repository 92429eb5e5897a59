//! A run opened for looking at: its scene, its nets, and what a user should know.

use crate::failure::BadInput;
use crate::place::Place;
use crate::trust::{distrust, spans};
use glam::Vec3;
use rrf_bake::Run;
use rrf_extract::VisibilityQueries;
use rrf_field::columns::Columns;
use rrf_field::{Borders, Field};
use rrf_render::{Lamps, Lights, Notice, View, notices, on_surface};
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
    /// Where its cells meet.
    pub borders: Borders,
    tree: ModelTree,
    /// Where the run's files are for as long as it is open.
    _place: Place,
}

impl Baked {
    /// Reads the run, its scene and its model.
    /// Cells of a larger error than `trust_error` are not trusted.
    pub fn open(folder: &Path, trust_error: f32) -> anyhow::Result<Baked> {
        let place = Place::model(folder)?;
        let run = Run::open(place.folder())?;
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
            _place: place,
        })
    }

    /// Least and greatest corner of the baked light box.
    pub fn light_box(&self) -> [Vec3; 2] {
        let [x0, y0, z0, x1, y1, z1] = self.run.manifest.light_box;
        [Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1)]
    }

    /// The same of the box that eyes were expected in.
    pub fn eye_box(&self) -> Option<[Vec3; 2]> {
        let eye_box = self.run.config.extract.eye_box?;
        Some([eye_box.minimum, eye_box.maximum].map(Vec3::from))
    }

    /// The scene that frames are traced in: with its lamps where they shine.
    pub fn shown(&self, lights: &Lights) -> &Scene {
        if self.has_lamps(lights) {
            &self.scene
        } else {
            &self.unlit
        }
    }

    /// The lamps, where they shine; what stands for them in the nets' light, and how well, is
    /// said on standard error.
    pub fn lamps(&self, lights: &Lights) -> anyhow::Result<Option<Lamps>> {
        if !self.has_lamps(lights) {
            return Ok(None);
        }
        let tracer = Tracer::new(&self.unlit)?;
        let visibility = VisibilityQueries::new(&self.unlit, &tracer);
        let free = |p: Vec3| !visibility.inside_solid(p);
        let lamps = Lamps::new(&self.scene, &self.field, self.light_box(), free)?;
        for (k, stand_in) in lamps.stand_ins.iter().enumerate() {
            eprintln!(
                "area light {k}: the nets light it as {} points, indirect light within {:.1} %",
                stand_in.points.len(),
                100.0 * stand_in.error
            );
        }
        Ok(Some(lamps))
    }

    fn has_lamps(&self, lights: &Lights) -> bool {
        lights.area && !self.scene.area_lights.is_empty()
    }

    /// Whether the nets were trained for each of the rows, and well enough.
    pub fn trusted(&self, rows: &Columns) -> Vec<bool> {
        self.tree.trusted(rows)
    }

    /// What a user should know of a view and its lights is said; where the picture would show
    /// nothing that was meant, it is refused, unless `anyway`.
    pub fn check(
        &self,
        tracer: &Tracer,
        view: &View,
        lights: &Lights,
        anyway: bool,
    ) -> Result<Vec<Notice>, BadInput> {
        let visibility = VisibilityQueries::new(&self.unlit, tracer);
        let positions = lights.points.iter().map(|light| light.position);
        let notices = notices(
            view.eye,
            positions,
            Some(self.light_box()),
            self.eye_box(),
            |place| visibility.inside_solid(place),
            |place| on_surface(tracer, place),
            |place, reach| tracer.distance(place, reach),
        );
        match notices.iter().find(|notice| notice.is_fatal()) {
            Some(fatal) if !anyway => Err(BadInput(format!("{fatal} (--anyway renders it)"))),
            _ => Ok(notices),
        }
    }
}
