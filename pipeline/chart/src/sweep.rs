//! `rrf sweep`: bakes every setting of a grid with every seed and measures each run.
//!
//! A finished run leaves `rows/NAME.json` in the sweep's folder, so that a sweep that was cut off
//! goes on after its last finished run; the run that was cut off is baked again from its start,
//! because half of its time is not known. `results.parquet` is written after every run.

use crate::frames::{FrameErrors, Reference};
use crate::grid::{Grid, Setting};
use crate::results::{self, CELLS, PATH_TRACING, Row};
use crate::{ChartError, Done, Program};
use arrow::array::AsArray;
use arrow::datatypes::Float32Type;
use rrf_bake::Run;
use rrf_metrics::estimate::{ErrorEstimate, SquareError, less_variance};
use rrf_metrics::relative::{channel_mean, epsilon_of, inverse_level};
use rrf_store::Limits;
use rrf_store::{atomic, layout, model, points};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Seeds of the reference's two halves: far from any that people type.
const REFERENCE_SEEDS: [u64; 2] = [0x5eed_0001, 0x5eed_0002];
/// Renderings of a frame whose median time counts.
const RENDERINGS: usize = 3;

/// A sweep's folder and what it is of.
pub struct Sweep<'a> {
    /// The program.
    pub program: Program,
    /// Scene file.
    pub scene: &'a Path,
    /// The grid.
    pub grid: &'a Grid,
    /// The sweep's folder.
    pub folder: &'a Path,
}

/// What one run is.
enum Job<'a> {
    Bake(&'a Setting),
    Trace(u32),
}

/// Runs what is not done yet; returns all rows. `progress` is told each run's name and place.
///
/// # Errors
/// [`ChartError`]; what is finished stays.
pub fn run(sweep: &Sweep, progress: &dyn Fn(&str, usize, usize)) -> Result<Vec<Row>, ChartError> {
    for name in ["rows", "runs"] {
        atomic::create_folder(&sweep.folder.join(name))?;
    }
    let reference = sweep.reference()?;
    let settings = sweep.grid.settings();
    let traces = sweep.grid.trace.iter().flat_map(|t| &t.spp);
    let jobs: Vec<Job> = (settings.iter().map(Job::Bake))
        .chain(traces.map(|&spp| Job::Trace(spp)))
        .collect();
    let total = jobs.len() * sweep.grid.seeds.len();
    let mut rows: Vec<Row> = Vec::new();
    // seed by seed: a sweep cut off early has the whole front, without error bars
    for &seed in &sweep.grid.seeds {
        for job in &jobs {
            let name = format!("{},seed={seed}", job.name());
            progress(&name, rows.len() + 1, total);
            rows.push(sweep.one(job, seed, &name, &reference)?);
            results::write(&sweep.folder.join("results.parquet"), &rows)?;
        }
    }
    Ok(rows)
}

impl Job<'_> {
    fn name(&self) -> String {
        match self {
            Job::Bake(setting) => setting.name(),
            Job::Trace(spp) => format!("trace,spp={spp}"),
        }
    }
}

impl Sweep<'_> {
    /// A finished run's row, or the run and its row.
    fn one(
        &self,
        job: &Job,
        seed: u64,
        name: &str,
        reference: &Reference,
    ) -> Result<Row, ChartError> {
        let path = self.folder.join("rows").join(format!("{name}.json"));
        if path.exists() {
            let text = std::fs::read(&path).map_err(|e| ChartError::file(&path, "be read", e))?;
            let row = serde_json::from_slice(&text);
            return row.map_err(|e| ChartError::file(&path, "be understood", e));
        }
        let row = match job {
            Job::Bake(setting) => self.bake(setting, seed, name, reference)?,
            Job::Trace(spp) => self.trace(*spp, seed, reference)?,
        };
        let text = serde_json::to_vec_pretty(&row)
            .map_err(|e| ChartError::file(&path, "be written", e))?;
        atomic::atomic_write(&path, &text)?;
        Ok(row)
    }

    fn bake(
        &self,
        setting: &Setting,
        seed: u64,
        name: &str,
        reference: &Reference,
    ) -> Result<Row, ChartError> {
        let run = self.folder.join("runs").join(name);
        if run.exists() {
            std::fs::remove_dir_all(&run).map_err(|e| ChartError::file(&run, "be removed", e))?;
        }
        let mut words = words(["bake"]);
        words.extend([self.scene.into(), "-o".into(), run.clone().into()]);
        words.extend(["--seed".into(), seed.to_string().into()]);
        if let Some(b) = self.grid.light_box {
            words.push("--light-box".into());
            words.push(b.map(|x| x.to_string()).join(",").into());
        }
        for (option, value) in &setting.0 {
            words.extend([format!("--{option}").into(), value.into()]);
        }
        let bake = self.program.run(&words)?;
        let (frame, errors) = self.render(&run, reference)?;
        let mut row = model_row(&run)?;
        row.method = setting.0.get("method").map_or(CELLS, String::as_str).into();
        row.setting = setting.name();
        row.seed = seed;
        row.bake_seconds = Some(bake.seconds);
        row.bake_cpu_seconds = Some(bake.cpu_seconds);
        (row.frame_seconds, row.frame_cpu_seconds) = frame;
        if let Some(table) = &self.grid.points {
            let (error, se) = self.points_error(&run, table)?;
            (row.points_error, row.points_error_se) = (Some(error), Some(se));
        }
        Ok(with_errors(row, errors))
    }

    /// Median wall and CPU seconds of a frame by the nets, and its errors.
    fn render(
        &self,
        run: &Path,
        reference: &Reference,
    ) -> Result<((f64, f64), FrameErrors), ChartError> {
        let frame = run.join("frame.exr");
        let mut words = words(["render"]);
        words.extend([run.into(), "-o".into(), frame.clone().into()]);
        words.extend(self.view());
        let (mut wall, mut cpu) = ([0.0; RENDERINGS], [0.0; RENDERINGS]);
        for (wall, cpu) in wall.iter_mut().zip(&mut cpu) {
            let done = self.program.run(&words)?;
            (*wall, *cpu) = (done.seconds, done.cpu_seconds);
        }
        let [wall, cpu] = [wall, cpu].map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[RENDERINGS / 2]
        });
        Ok(((wall, cpu), reference.judge(&frame)?))
    }

    fn trace(&self, spp: u32, seed: u64, reference: &Reference) -> Result<Row, ChartError> {
        let frame = self
            .folder
            .join("runs")
            .join(format!("trace-{spp}-{seed}.exr"));
        let done = self.trace_frame(&frame, spp, seed)?;
        let row = Row {
            method: PATH_TRACING.into(),
            setting: format!("spp={spp}"),
            seed,
            paths: Some(spp.into()),
            frame_seconds: done.seconds,
            frame_cpu_seconds: done.cpu_seconds,
            ..Row::default()
        };
        Ok(with_errors(row, reference.judge(&frame)?))
    }

    fn trace_frame(&self, frame: &Path, spp: u32, seed: u64) -> Result<Done, ChartError> {
        let mut words = words(["trace"]);
        words.extend([self.scene.into(), "-o".into(), frame.into()]);
        words.extend(["--spp".into(), spp.to_string().into()]);
        words.extend(["--seed".into(), seed.to_string().into()]);
        words.extend(self.view());
        self.program.run(&words)
    }

    /// The reference's halves, traced where they are missing.
    fn reference(&self) -> Result<Reference, ChartError> {
        let halves = [0, 1].map(|half| self.folder.join(format!("reference-{half}.exr")));
        for (half, seed) in halves.iter().zip(REFERENCE_SEEDS) {
            if !half.exists() {
                self.trace_frame(half, self.grid.frame.reference_spp / 2, seed)?;
            }
        }
        Reference::read(&halves)
    }

    fn view(&self) -> Vec<OsString> {
        let frame = &self.grid.frame;
        let mut words = words(["--light", &frame.light, "--size", &frame.size]);
        for (option, value) in [("--eye", &frame.eye), ("--look-at", &frame.look_at)] {
            if let Some(value) = value {
                words.extend([option.into(), value.into()]);
            }
        }
        if let Some(fov) = frame.fov {
            words.extend(["--fov".into(), fov.to_string().into()]);
        }
        words
    }

    /// Relative error at the rows of a reference table, its noise taken out.
    fn points_error(&self, run: &Path, table: &Path) -> Result<(f64, f64), ChartError> {
        let answers = run.join("answers.parquet");
        let mut words = words(["query"]);
        words.extend([run.into(), "--points".into(), table.into()]);
        words.extend(["-o".into(), answers.clone().into()]);
        self.program.run(&words)?;
        let p = columns(&answers, ["r", "g", "b"])?;
        let m = columns(table, ["r", "g", "b"])?;
        let se = columns(table, ["r_se", "g_se", "b_se"])?;
        Ok(relative_error(&p, &m, &se))
    }
}

fn words<const N: usize>(words: [&str; N]) -> Vec<OsString> {
    words.map(OsString::from).to_vec()
}

fn with_errors(row: Row, errors: FrameErrors) -> Row {
    let figure = |metric: &str| errors.whole.get(metric).copied().unwrap_or(f64::NAN);
    Row {
        frame_error: errors.indirect,
        flip: figure("flip"),
        delta_e_2000: figure("delta_e_2000"),
        ..row
    }
}

/// What a run folder says of its model.
fn model_row(folder: &Path) -> Result<Row, ChartError> {
    let run = Run::open(folder)?;
    let metrics = model::read_metrics(folder, &run.facts())?;
    let (mut count, mut square, mut variance) = (0.0, 0.0, 0.0);
    for cell in &metrics {
        if let Some(error) = cell.validation {
            let n = cell.validation_rows as f64;
            count += n;
            square += n * error.mean;
            variance += (n * error.se).powi(2);
        }
    }
    let whole = (count > 0.0).then(|| {
        let (mean, se) = (square / count, variance.sqrt() / count);
        SquareError { mean, se }.relative()
    });
    let size = |name: &str| {
        let path: PathBuf = layout::model_folder(folder).join(name);
        let meta = std::fs::metadata(&path).map_err(|e| ChartError::file(&path, "be read", e));
        meta.map(|meta| meta.len())
    };
    let config = &run.manifest.config;
    Ok(Row {
        preset: config["preset"].as_str().map(str::to_string),
        rows: Some(metrics.iter().map(|cell| cell.rows).sum()),
        paths: config["extract"]["paths"].as_u64(),
        cells: Some(metrics.len() as u64),
        weights: Some(metrics.iter().map(|cell| u64::from(cell.weights)).sum()),
        target: config["target"].as_f64(),
        model_bytes: Some(size("tree.arrow")? + size("weights.arrow")?),
        held_out_error: whole.map(|whole| whole.0),
        held_out_error_se: whole.map(|whole| whole.1),
        ..Row::default()
    })
}

/// Three columns of a points table.
fn columns(path: &Path, names: [&str; 3]) -> Result<[Vec<f64>; 3], ChartError> {
    let table = points::read_points(path, Limits::default())?;
    let mut out = [Vec::new(), Vec::new(), Vec::new()];
    for (out, name) in out.iter_mut().zip(names) {
        let array = table.batch.column_by_name(name);
        let numbers = array.and_then(|array| array.as_primitive_opt::<Float32Type>());
        let numbers = numbers.ok_or_else(|| ChartError::Table {
            path: path.to_path_buf(),
            reason: format!("no float32 column {name}: not a table of reference radiance"),
        })?;
        out.extend(numbers.values().iter().map(|&x| f64::from(x)));
    }
    Ok(out)
}

/// The relative error over rows and its standard error, the reference's noise taken out.
fn relative_error(p: &[Vec<f64>; 3], m: &[Vec<f64>; 3], se: &[Vec<f64>; 3]) -> (f64, f64) {
    let row = |columns: &[Vec<f64>; 3], i: usize| [0, 1, 2].map(|c| columns[c][i]);
    let rows = 0..m[0].len();
    let floor = epsilon_of(rows.clone().map(|i| row(m, i)));
    let square = |i| {
        let level = channel_mean(row(m, i));
        less_variance(
            row(p, i),
            row(m, i),
            row(se, i),
            inverse_level(level, floor),
        )
    };
    let squares: Vec<f64> = rows.map(square).collect();
    SquareError::from(ErrorEstimate::of(&squares)).relative()
}
