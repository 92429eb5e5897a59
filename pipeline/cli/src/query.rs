//! `rrf query`: the model at the rows of a points table.

use crate::args::QueryArgs;
use crate::place::Place;
use crate::points;
use crate::trust::{distrust, spans};
use arrow::array::{ArrayRef, BooleanArray, Float32Array, UInt32Array};
use rrf_bake::Run;
use rrf_extract::{PointClass, VisibilityQueries};
use rrf_field::{Borders, Field, columns};
use rrf_scene::Scene;
use rrf_store::Limits;
use rrf_store::model;
use rrf_store::points::{PointsTable, check_ending, read_points, write_points};
use rrf_store::schema::Table;
use rrf_trace::{SurfacePoint, Tracer};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Reads the table, evaluates the nets, writes the table with `r g b cell_id trusted` appended.
pub fn run(args: &QueryArgs) -> anyhow::Result<()> {
    check_ending(&args.output)?;
    let place = Place::model(&args.run)?;
    let run = Run::open(place.folder())?;
    let scene = run.load_scene()?.unlit();
    let tracer = Tracer::new(&scene)?;
    let mut model = model::read_model(&run.folder, &run.facts())?;
    let metrics = model::read_metrics(&run.folder, &run.facts())?;
    let spans = spans(&model.tree);
    distrust(&mut model.tree, &metrics, f64::from(args.trust.trust_error));
    let table = read_points(&args.points, Limits::default())?;
    let located = points::locate(&tracer, &table, &args.points)?;
    let rows = points::rows(&tracer, &table, &located);
    let trusted = model.tree.trusted(&rows);
    let field = Field::new(model.tree.tree, model.cells)?;
    let mut radiance: [Vec<f32>; 3] = Default::default();
    let mut cells = Vec::new();
    if args.blend {
        Borders::new(&field, spans).evaluate(&field, &rows, &mut radiance, &mut cells)?;
    } else {
        field.evaluate(&rows, &mut radiance, &mut cells)?;
    }
    darken_sealed(&scene, &tracer, &located, &table, &mut radiance);
    let [r, g, b] = radiance.map(|channel| Arc::new(Float32Array::from(channel)) as ArrayRef);
    let untrusted = trusted.iter().filter(|&&t| !t).count();
    let added: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", r),
        ("g", g),
        ("b", b),
        ("cell_id", Arc::new(UInt32Array::from(cells)) as ArrayRef),
        ("trusted", Arc::new(BooleanArray::from(trusted)) as ArrayRef),
    ]);
    let facts = points::facts(&run.manifest.scene_hash, run.manifest.seed);
    write_points(&args.output, &table.batch, Table::Answers, added, &facts)?;
    println!(
        "{} rows, {untrusted} of them not trusted: outside what the model was trained on, or in a cell with an \
         error above {:.1} %",
        rows.len(),
        100.0 * args.trust.trust_error
    );
    Ok(())
}

/// A point sealed inside a solid, or with an empty hemisphere, receives no light from outside:
/// exactly zero, which no net was trained on.
fn darken_sealed(
    scene: &Scene,
    tracer: &Tracer,
    located: &[SurfacePoint],
    table: &PointsTable,
    radiance: &mut [Vec<f32>; 3],
) {
    let visibility = VisibilityQueries::new(scene, tracer);
    let viewers = points::vectors(table, columns::V);
    for (row, (point, &v)) in located.iter().zip(&viewers).enumerate() {
        let side = if point.normal.dot(v) < 0.0 {
            -point.normal
        } else {
            point.normal
        };
        if visibility.from_surface(point, side) != PointClass::Open {
            radiance.iter_mut().for_each(|channel| channel[row] = 0.0);
        }
    }
}
