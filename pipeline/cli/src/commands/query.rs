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
use rrf_render::{Passes, RenderOptions};
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
    /// Rays of a row of --fallback gather. By default 1,024 in a run of nets, and in a run of a transfer as many
    /// as a row needs for a standard error of 5 %, from 1,024 up to 4,096.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub fallback_spp: Option<u32>,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
}

/// Rays of a row of nets where they are not trusted.
const FALLBACK_RAYS: u32 = 1024;
/// Rays of a pass over the rows of a transfer.
const PASS_RAYS: u32 = 256;
/// How many passes rows of a transfer get: 1,024 rays, and more where those differ too much.
const PASSES: Passes = Passes {
    least: 4,
    most: 16,
    noise: 0.05,
};

/// How a table is answered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asking {
    /// Blend neighbouring nets.
    pub blend: bool,
    /// Rays of a row by final gather, 0 for none; by default rows of a transfer gather if they may fall back on it.
    pub gather: Option<u32>,
    /// Treatment of answers that are not trusted; by default as is usual for the method.
    pub fallback: Option<Fallback>,
    /// Rays of a row that falls back; by default as many as is usual for the method.
    pub fallback_rays: Option<u32>,
}

/// Rays of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rays {
    gather: u32,
    fallback: u32,
    passes: Passes,
}

/// Reads the table, evaluates the model, writes the table with `r g b cell_id trusted` appended.
pub fn run(args: &QueryArgs) -> anyhow::Result<()> {
    check_ending(&args.output)?;
    let baked = Baked::open(&args.run, args.trust.trust_error)?;
    let table = read_points(&args.points, Limits::default())?;
    let Answered { batch, untrusted } = answer(&baked, &table, &args.points, &asking(args)?)?;
    write_batch(&args.output, Table::Answers, &batch)?;
    println!(
        "{} rows, {untrusted} of them not trusted: outside what the model was trained on, or in a cell with an \
         error above {:.1} %",
        table.len(),
        100.0 * args.trust.trust_error
    );
    Ok(())
}

fn asking(args: &QueryArgs) -> Result<Asking, BadInput> {
    if args.gather.fallback == Some(Fallback::Trace) {
        let told = "--fallback trace: a query gathers; `rrf trace --points` path-traces a table";
        return Err(BadInput(told.into()));
    }
    Ok(Asking {
        blend: args.blend,
        gather: args.gather.gather,
        fallback: args.gather.fallback,
        fallback_rays: args.fallback_spp,
    })
}

impl Asking {
    /// Rays of a table. Every row of a transfer gathers, whatever its cell states: errors of many cells average
    /// out, and the worst rows lie in cells that state little.
    fn rays(&self, is_transfer: bool) -> Rays {
        let falls_back = match self.fallback {
            None => is_transfer,
            Some(fallback) => fallback == Fallback::Gather,
        };
        let all_gather = is_transfer && falls_back;
        let fixed = self.gather.or(self.fallback_rays.filter(|_| all_gather));
        let (gather, passes) = match fixed {
            None if all_gather => (PASS_RAYS, PASSES),
            fixed => (fixed.unwrap_or(0), Passes::ONE),
        };
        Rays {
            gather,
            fallback: match falls_back {
                true => self.fallback_rays.unwrap_or(FALLBACK_RAYS),
                false => 0,
            },
            passes,
        }
    }
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
    let rays = asking.rays(matches!(baked.model, BakedModel::Transfer(_)));
    let RowAnswers {
        mut radiance,
        cells,
        trusted,
    } = match baked.ready(&tracer)? {
        ReadyModel::Nets(nets) if rays.fallback + rays.gather == 0 && !baked.traces_narrow() => {
            let rows = points::rows(&tracer, table, &located);
            by_nets(asking.blend, baked, nets, &rows)?
        }
        ReadyModel::Transfer(_) if asking.blend => return Err(BadInput(NO_BLEND.into()).into()),
        model => {
            let nets = baked.nets().filter(|_| asking.blend);
            let options = RenderOptions {
                gather: rays.gather,
                fallback: rays.fallback,
                borders: nets.map(|nets| &nets.borders),
                ..RenderOptions::default()
            };
            let ways = (&options, &rays.passes);
            point_rows::answer(&model, baked, &tracer, (table, &located), place, ways)?
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

#[cfg(test)]
mod tests {
    use super::*;

    fn rays(gather: Option<u32>, fallback: Option<Fallback>, fallback_rays: Option<u32>) -> Asking {
        Asking {
            gather,
            fallback,
            fallback_rays,
            ..Asking::default()
        }
    }

    /// Rows of a transfer gather in passes unless their rays are told or it may not fall back; of nets, those alone
    /// that are not trusted, if asked to.
    #[test]
    fn options_choose_rays() {
        let one = |gather, fallback| Rays {
            gather,
            fallback,
            passes: Passes::ONE,
        };
        let passes = Rays {
            gather: PASS_RAYS,
            fallback: FALLBACK_RAYS,
            passes: PASSES,
        };
        let (none, falls) = (Some(Fallback::None), Some(Fallback::Gather));
        for (asking, of_transfer, of_nets) in [
            (rays(None, None, None), passes, one(0, 0)),
            (rays(None, falls, None), passes, one(0, 1024)),
            (rays(None, none, None), one(0, 0), one(0, 0)),
            (rays(None, none, Some(64)), one(0, 0), one(0, 0)),
            (rays(None, falls, Some(64)), one(64, 64), one(0, 64)),
            (rays(Some(0), None, None), one(0, 1024), one(0, 0)),
            (rays(Some(8), None, None), one(8, 1024), one(8, 0)),
            (rays(Some(8), none, None), one(8, 0), one(8, 0)),
        ] {
            assert_eq!(asking.rays(true), of_transfer, "{asking:?}");
            assert_eq!(asking.rays(false), of_nets, "{asking:?}");
        }
    }
}
