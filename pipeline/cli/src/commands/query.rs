//! `rrf query`: the model at the rows of a points table.

use super::render::NO_BLEND;
use crate::args::TrustArgs;
use crate::baked::{Baked, BakedNets, ReadyModel};
use crate::failure::BadInput;
use crate::transfer_rows::{self, RowAnswers};
use crate::{narrow, points};
use arrow::array::{ArrayRef, BooleanArray, Float32Array, RecordBatch, UInt32Array};
use clap::Args;
use rrf_extract::{PointClass, VisibilityQueries};
use rrf_field::columns::{self, Columns};
use rrf_scene::Scene;
use rrf_store::Limits;
use rrf_store::points::{PointsTable, check_ending, read_points, with_columns, write_batch};
use rrf_store::schema::Table;
use rrf_trace::{SurfacePoint, Tracer};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Compute the model's indirect radiance at the points of a table. What mirrors, glass and other narrow
/// lobes show is traced.
#[derive(Args, Clone, Debug)]
pub struct QueryArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Points table.
    #[arg(long, value_name = "IN.parquet")]
    pub points: PathBuf,
    /// Table to write.
    #[arg(short, long, value_name = "OUT.parquet")]
    pub output: PathBuf,
    /// Blend the nets of neighbouring cells within a tenth of a cell where they meet and agree, so that
    /// their borders do not show.
    #[arg(long)]
    pub blend: bool,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
}

/// Reads the table, evaluates the model, writes the table with `r g b cell_id trusted` appended.
pub fn run(args: &QueryArgs) -> anyhow::Result<()> {
    check_ending(&args.output)?;
    let baked = Baked::open(&args.run, args.trust.trust_error)?;
    let table = read_points(&args.points, Limits::default())?;
    let Answered { batch, untrusted } = answer(&baked, &table, &args.points, args.blend)?;
    write_batch(&args.output, Table::Answers, &batch)?;
    println!(
        "{} rows, {untrusted} of them not trusted: outside what the model was trained on, or in a cell with an \
         error above {:.1} %",
        table.len(),
        100.0 * args.trust.trust_error
    );
    Ok(())
}

/// A table with the model's answers.
pub struct Answered {
    /// The table's rows with `r g b cell_id trusted` appended.
    pub batch: RecordBatch,
    /// Rows that are not trusted.
    pub untrusted: usize,
}

/// The model at the rows of a table; `place` is what errors call it.
pub fn answer(
    baked: &Baked,
    table: &PointsTable,
    place: &Path,
    blend: bool,
) -> anyhow::Result<Answered> {
    let scene = &baked.unlit;
    let tracer = Tracer::new(scene)?;
    let located = points::locate(&tracer, table, place)?;
    let RowAnswers {
        mut radiance,
        cells,
        trusted,
    } = match baked.ready(&tracer)? {
        ReadyModel::Nets(nets) => {
            let rows = points::rows(&tracer, table, &located);
            let mut answers = by_nets(blend, baked, nets, &rows)?;
            if baked.traces_narrow() {
                narrow::complete(baked, nets, &tracer, (table, &located), &mut answers)?;
            }
            answers
        }
        ReadyModel::Transfer(_) if blend => return Err(BadInput(NO_BLEND.into()).into()),
        ReadyModel::Transfer(book) => {
            transfer_rows::answer(&book, baked, &tracer, (table, &located), place)?
        }
    };
    darken_sealed(scene, &tracer, &located, table, &mut radiance);
    let [r, g, b] = radiance.map(|channel| Arc::new(Float32Array::from(channel)) as ArrayRef);
    let untrusted = trusted.iter().filter(|&&t| !t).count();
    let added: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", r),
        ("g", g),
        ("b", b),
        ("cell_id", Arc::new(UInt32Array::from(cells)) as ArrayRef),
        ("trusted", Arc::new(BooleanArray::from(trusted)) as ArrayRef),
    ]);
    let manifest = &baked.manifest;
    let facts = points::facts(&manifest.scene_hash, manifest.seed);
    let batch = with_columns(&table.batch, Table::Answers, added, &facts)?;
    Ok(Answered { batch, untrusted })
}

/// Answers of nets, for points of 1 W/sr.
fn by_nets(
    blend: bool,
    baked: &Baked,
    nets: &BakedNets,
    rows: &Columns,
) -> anyhow::Result<RowAnswers> {
    let mut radiance: [Vec<f32>; 3] = Default::default();
    let mut cells = Vec::new();
    if blend {
        (nets.borders).evaluate(&nets.field, rows, &mut radiance, &mut cells)?;
    } else {
        nets.field.evaluate(rows, &mut radiance, &mut cells)?;
    }
    Ok(RowAnswers {
        radiance,
        cells,
        trusted: baked.trusted(rows),
    })
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
