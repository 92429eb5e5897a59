//! `rrf query`: the model at the rows of a points table.

use super::render::NO_BLEND;
use crate::args::{Fallback, GatherArgs, TrustArgs};
use crate::baked::{Baked, BakedModel, BakedNets, ReadyModel};
use crate::failure::BadInput;
use crate::point_rows::{self, RowAnswers};
use crate::points;
use arrow::array::{ArrayRef, BooleanArray, Float32Array, RecordBatch, UInt32Array};
use clap::Args;
use rrf_extract::{PointClass, VisibilityQueries};
use rrf_field::columns::{self, Columns};
use rrf_render::RenderOptions;
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
    /// Rays in place of the model's answers.
    #[command(flatten)]
    pub gather: GatherArgs,
    /// Rays of a row of --fallback gather.
    #[arg(long, value_name = "N", default_value_t = FALLBACK_RAYS, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub fallback_spp: u32,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
}

/// Rays of a row where the model is not trusted.
const FALLBACK_RAYS: u32 = 1024;

/// How a table is answered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asking {
    /// Blend neighbouring nets.
    pub blend: bool,
    /// Rays of a row by final gather; 0 for none.
    pub gather: u32,
    /// Rays of a row that is not trusted, or none; by default what is usual for the method.
    pub fallback: Option<u32>,
}

/// Reads the table, evaluates the model, writes the table with `r g b cell_id trusted` appended.
pub fn run(args: &QueryArgs) -> anyhow::Result<()> {
    check_ending(&args.output)?;
    let baked = Baked::open(&args.run, args.trust.trust_error)?;
    let table = read_points(&args.points, Limits::default())?;
    let Answered { batch, untrusted } =
        answer(&baked, &table, &args.points, &asking(args, &baked)?)?;
    write_batch(&args.output, Table::Answers, &batch)?;
    println!(
        "{} rows, {untrusted} of them not trusted: outside what the model was trained on, or in a cell with an \
         error above {:.1} %",
        table.len(),
        100.0 * args.trust.trust_error
    );
    Ok(())
}

fn asking(args: &QueryArgs, baked: &Baked) -> Result<Asking, BadInput> {
    let usual = match baked.model {
        BakedModel::Nets(_) => Fallback::None,
        BakedModel::Transfer(_) => Fallback::Gather,
    };
    let fallback = match args.gather.fallback.unwrap_or(usual) {
        Fallback::None => 0,
        Fallback::Gather => args.fallback_spp,
        Fallback::Trace => {
            let told =
                "--fallback trace: a query gathers; `rrf trace --points` path-traces a table";
            return Err(BadInput(told.into()));
        }
    };
    Ok(Asking {
        blend: args.blend,
        gather: args.gather.gather,
        fallback: Some(fallback),
    })
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
    asking: &Asking,
) -> anyhow::Result<Answered> {
    let scene = &baked.unlit;
    let tracer = Tracer::new(scene)?;
    let located = points::locate(&tracer, table, place)?;
    let usual = match baked.model {
        BakedModel::Nets(_) => 0,
        BakedModel::Transfer(_) => FALLBACK_RAYS,
    };
    let fallback = asking.fallback.unwrap_or(usual);
    let RowAnswers {
        mut radiance,
        cells,
        trusted,
    } = match baked.ready(&tracer)? {
        ReadyModel::Nets(nets) if fallback + asking.gather == 0 && !baked.traces_narrow() => {
            let rows = points::rows(&tracer, table, &located);
            by_nets(asking.blend, baked, nets, &rows)?
        }
        ReadyModel::Transfer(_) if asking.blend => return Err(BadInput(NO_BLEND.into()).into()),
        model => {
            let nets = baked.nets().filter(|_| asking.blend);
            let options = RenderOptions {
                gather: asking.gather,
                fallback,
                borders: nets.map(|nets| &nets.borders),
                ..RenderOptions::default()
            };
            point_rows::answer(&model, baked, &tracer, (table, &located), place, &options)?
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
