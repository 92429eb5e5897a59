//! Error by light position.

use crate::ReportError;
use crate::html::{percent_se, table};
use maud::{Markup, html};
use rrf_bake::{Run, is_held_out};
use rrf_field::{Field, columns};
use rrf_metrics::estimate::{SquareError, by_halves};
use rrf_metrics::relative::{channel_mean, epsilon_of, inverse_level};
use rrf_store::{layout, model, parts};

/// Bins along each axis of the light box.
const BINS: usize = 6;

#[derive(Clone, Copy, Default)]
struct Bin {
    rows: f64,
    square: f64,
    square_of_squares: f64,
}

/// A table an axis of the light box: the model's error on rows held out whose light is there.
pub(super) fn errors_by_position(run: &Run) -> Result<Markup, ReportError> {
    let facts = run.facts();
    let model = model::read_model(&run.folder, &facts)?;
    let field = Field::new(model.tree.tree, model.cells)?;
    let tables = (layout::list_cells(&run.folder)?.into_iter())
        .map(|cell| Ok(parts::read_cell(&run.folder, cell, &facts)?.table))
        .collect::<Result<Vec<_>, ReportError>>()?;
    let targets = tables
        .iter()
        .flat_map(|table| (0..table.len()).map(|row| table.mean(row).map(f64::from)));
    let floor = epsilon_of(targets);
    let b = run.manifest.light_box;
    let mut bins = [[Bin::default(); BINS]; 3];
    for table in &tables {
        let mut answers: [Vec<f32>; 3] = Default::default();
        field.evaluate(&table.columns, &mut answers, &mut Vec::new())?;
        let [r, g, blues] = &answers;
        for (row, ((&r, &g), &blue)) in r.iter().zip(g).zip(blues).enumerate() {
            let index = table.index.get(row).copied().unwrap_or_default();
            if !is_held_out(run.config.train.seed, index) {
                continue;
            }
            let p = [r, g, blue].map(f64::from);
            // the target's own level is noisy, and small where the noise says so
            let inverse = inverse_level(channel_mean(p), floor);
            let square = by_halves(p, table.halves[0][row], table.halves[1][row], inverse);
            let light = table.columns.vec3(columns::L, row);
            for axis in 0..3 {
                let width = f64::from(b[axis + 3] - b[axis]).max(f64::MIN_POSITIVE);
                let place = f64::from(light[axis] - b[axis]) / width * BINS as f64;
                let bin = &mut bins[axis][(place.max(0.0) as usize).min(BINS - 1)];
                bin.rows += 1.0;
                bin.square += square;
                bin.square_of_squares += square * square;
            }
        }
    }
    let tables = bins.iter().enumerate().map(|(axis, bins)| {
        let width = (b[axis + 3] - b[axis]) / BINS as f32;
        let rows = bins.iter().enumerate();
        let rows = rows.map(|(n, bin)| line(b[axis] + n as f32 * width, width, bin));
        let name = format!("light {} [m]", ["x", "y", "z"][axis]);
        table(&[&name, "rows", "error"], &rows.collect::<Vec<_>>())
    });
    Ok(html! {
        h2 { "Error by light position" }
        p.note {
            "Relative error on rows held out, Monte Carlo noise taken out, ± its standard error, \
             relative to the prediction itself, by the light's place along \
             each axis of the light box."
        }
        @for table in tables { figure { (table) } }
    })
}

fn line(from: f32, width: f32, bin: &Bin) -> Vec<String> {
    let error = if bin.rows < 2.0 {
        "–".into()
    } else {
        let mean = bin.square / bin.rows;
        let variance = (bin.square_of_squares / bin.rows - mean * mean).max(0.0);
        let se = (variance / (bin.rows - 1.0)).sqrt();
        percent_se(SquareError { mean, se }.relative())
    };
    vec![
        format!("{from:.3} to {:.3}", from + width),
        format!("{}", bin.rows),
        error,
    ]
}
