//! `rrf render`: a frame by the baked nets.

use crate::args::{Part, RenderArgs};
use crate::{pictures, view};
use glam::Vec3;
use rrf_bake::Run;
use rrf_extract::Lookout;
use rrf_field::Field;
use rrf_render::{RenderOptions, notices};
use rrf_store::model;
use rrf_trace::Tracer;

/// Renders the view and writes it.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    pictures::check_endings(&args.output)?;
    let run = Run::open(&args.run)?;
    let scene = run.load_scene()?;
    let frame_view = view::view(&args.view, &scene)?;
    let lights = view::lights(&args.view, &scene)?;
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene)?;
    let model = model::read_model(&run.folder, &run.facts())?;
    let tree = model.tree;
    let field = Field::new(tree.tree.clone(), model.cells)?;

    let [x0, y0, z0, x1, y1, z1] = run.manifest.light_box;
    let lookout = Lookout::new(&scene, &tracer);
    let positions = lights.points.iter().map(|light| light.position);
    let light_box = Some([Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1)]);
    for notice in notices(frame_view.eye, positions, light_box, |p| {
        lookout.inside_solid(p)
    }) {
        eprintln!("warning: {notice}");
    }

    let trusted = |rows: &rrf_field::columns::Columns| tree.trusted(rows);
    let options = RenderOptions {
        part: match args.view.part {
            Part::Full => rrf_render::Part::Full,
            Part::Direct => rrf_render::Part::Direct,
            Part::Indirect => rrf_render::Part::Indirect,
        },
        aa: args.view.aa,
        trusted: Some(&trusted),
        ..RenderOptions::default()
    };
    let frame = rrf_render::render(&tracer, &field, &frame_view, &lights, &options)?;
    pictures::write(frame, &args.view, &args.output)
}
