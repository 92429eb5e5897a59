//! `rrf sweep`: bakes every setting of a grid with every seed and measures each run.
//!
//! A finished run leaves `rows/NAME.json` in the sweep's folder, so that a sweep that was cut off
//! goes on after its last finished run; the run that was cut off is baked again from its start,
//! because half of its time is not known. `results.parquet` is written after every run.

mod frontier;
mod grid;
mod measure;
mod model;
mod results;

pub use frontier::{frontier_panels, write_frontier};
pub use grid::{Grid, GridFrame, GridTrace, Setting};
pub use results::{PATH_TRACING, SweepRow, read_results, write_results};

use crate::ReportError;
use crate::program::{Call, Finished, Program};
use measure::{FrameErrors, Reference, points_error};
use model::model_row;
use rrf_store::atomic;
use std::path::{Path, PathBuf};

/// Seeds of the reference's two halves: far from any that people type.
const REFERENCE_SEEDS: [u64; 2] = [0x5eed_0001, 0x5eed_0002];
/// Renderings of a frame whose median time counts.
const RENDERINGS: usize = 3;

/// Bake every setting of a grid and measure each run; goes on where it was cut off.
#[derive(clap::Args, Debug)]
pub struct SweepArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// The sweep's folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Settings to bake and the frame to measure: docs/science/report.md has an example.
    #[arg(long, value_name = "grid.toml")]
    pub grid: PathBuf,
}

/// Runs what is not done yet and says where the table is.
///
/// # Errors
/// [`ReportError`]; what is finished stays.
pub fn run(args: &SweepArgs, program: &Program, quiet: bool) -> Result<(), ReportError> {
    let sweep = Sweep {
        program,
        scene: &args.scene,
        grid: &Grid::read(&args.grid)?,
        folder: &args.output,
    };
    let rows = sweep.run(&|name, place, total| {
        if !quiet {
            eprintln!("{place} of {total}: {name}");
        }
    })?;
    let table = args.output.join("results.parquet");
    println!("{} runs: {}", rows.len(), table.display());
    Ok(())
}

/// A sweep's folder and what it is of.
pub struct Sweep<'a> {
    /// The program.
    pub program: &'a Program,
    /// Scene file.
    pub scene: &'a Path,
    /// The grid.
    pub grid: &'a Grid,
    /// The sweep's folder.
    pub folder: &'a Path,
}

/// One kind of run, for every seed.
enum Job<'a> {
    Bake(&'a Setting),
    Trace(u32),
}

impl Sweep<'_> {
    /// Runs what is not done yet; returns all rows. `progress` is told each run's name and place.
    ///
    /// # Errors
    /// [`ReportError`]; what is finished stays.
    pub fn run(&self, progress: &dyn Fn(&str, usize, usize)) -> Result<Vec<SweepRow>, ReportError> {
        for name in ["rows", "runs"] {
            atomic::create_folder(&self.folder.join(name))?;
        }
        let reference = self.reference()?;
        let settings = self.grid.settings();
        let traces = self.grid.trace.iter().flat_map(|t| &t.spp);
        let jobs: Vec<Job> = (settings.iter().map(Job::Bake))
            .chain(traces.map(|&spp| Job::Trace(spp)))
            .collect();
        let total = jobs.len() * self.grid.seeds.len();
        let mut rows: Vec<SweepRow> = Vec::new();
        // seed by seed: a sweep cut off early has the whole front, without error bars
        for &seed in &self.grid.seeds {
            for job in &jobs {
                let name = match job {
                    Job::Bake(setting) => format!("{},seed={seed}", setting.name()),
                    Job::Trace(spp) => format!("trace,spp={spp},seed={seed}"),
                };
                progress(&name, rows.len() + 1, total);
                rows.push(self.row(job, seed, &name, &reference)?);
                write_results(&self.folder.join("results.parquet"), &rows)?;
            }
        }
        Ok(rows)
    }

    /// A finished run's row, or the run and its row.
    fn row(
        &self,
        job: &Job,
        seed: u64,
        name: &str,
        reference: &Reference,
    ) -> Result<SweepRow, ReportError> {
        let path = self.folder.join("rows").join(format!("{name}.json"));
        if path.exists() {
            let text = std::fs::read(&path).map_err(|e| ReportError::file(&path, "be read", e))?;
            let row = serde_json::from_slice(&text);
            return row.map_err(|e| ReportError::file(&path, "be understood", e));
        }
        let row = match job {
            Job::Bake(setting) => self.bake(setting, seed, name, reference)?,
            Job::Trace(spp) => self.trace(*spp, seed, reference)?,
        };
        let text = serde_json::to_vec_pretty(&row)
            .map_err(|e| ReportError::file(&path, "be written", e))?;
        atomic::atomic_write(&path, &text)?;
        Ok(row)
    }

    fn bake(
        &self,
        setting: &Setting,
        seed: u64,
        name: &str,
        reference: &Reference,
    ) -> Result<SweepRow, ReportError> {
        let run = self.folder.join("runs").join(name);
        if run.exists() {
            std::fs::remove_dir_all(&run).map_err(|e| ReportError::file(&run, "be removed", e))?;
        }
        let mut call = self.program.call("bake", self.scene).option("-o", &run);
        call = call.option("--seed", seed.to_string());
        let light_box = self
            .grid
            .light_box
            .map(|b| b.map(|x| x.to_string()).join(","));
        call = call.options("--light-box", light_box);
        for (option, value) in &setting.0 {
            call = call.option(&format!("--{option}"), value);
        }
        let bake = call.run()?;
        let (frame, errors) = self.render(&run, reference)?;
        let points = self.grid.points.as_deref();
        let points = points
            .map(|table| self.points_error(&run, table))
            .transpose()?;
        Ok(errors.with(SweepRow {
            setting: setting.name(),
            seed,
            bake_seconds: Some(bake.seconds),
            bake_cpu_seconds: Some(bake.cpu_seconds),
            frame_seconds: frame.seconds,
            frame_cpu_seconds: frame.cpu_seconds,
            points_error: points.map(|(error, _)| error),
            points_error_se: points.map(|(_, se)| se),
            ..model_row(&run, setting)?
        }))
    }

    /// Median wall and CPU seconds of a frame by the nets, and its errors.
    fn render(
        &self,
        run: &Path,
        reference: &Reference,
    ) -> Result<(Finished, FrameErrors), ReportError> {
        let frame = run.join("frame.exr");
        let call = self.view(self.program.call("render", run).option("-o", &frame));
        let times = (0..RENDERINGS).map(|_| call.clone().run());
        let times = times.collect::<Result<Vec<Finished>, _>>()?;
        let median = |of: fn(&Finished) -> f64| {
            let mut values: Vec<f64> = times.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values[RENDERINGS / 2]
        };
        let frame_time = Finished {
            seconds: median(|f| f.seconds),
            cpu_seconds: median(|f| f.cpu_seconds),
        };
        Ok((frame_time, reference.errors(&frame)?))
    }

    fn trace(&self, spp: u32, seed: u64, reference: &Reference) -> Result<SweepRow, ReportError> {
        let runs = self.folder.join("runs");
        let frame = runs.join(format!("trace-{spp}-{seed}.exr"));
        let done = self.trace_frame(&frame, spp, seed)?;
        Ok(reference.errors(&frame)?.with(SweepRow {
            method: PATH_TRACING.into(),
            setting: format!("spp={spp}"),
            seed,
            paths: Some(spp.into()),
            frame_seconds: done.seconds,
            frame_cpu_seconds: done.cpu_seconds,
            ..SweepRow::default()
        }))
    }

    fn trace_frame(&self, frame: &Path, spp: u32, seed: u64) -> Result<Finished, ReportError> {
        let call = self.program.call("trace", self.scene).option("-o", frame);
        let call = call.option("--spp", spp.to_string());
        self.view(call.option("--seed", seed.to_string())).run()
    }

    /// The reference's halves, traced where they are missing.
    fn reference(&self) -> Result<Reference, ReportError> {
        let halves = [0, 1].map(|half| self.folder.join(format!("reference-{half}.exr")));
        for (half, seed) in halves.iter().zip(REFERENCE_SEEDS) {
            if !half.exists() {
                self.trace_frame(half, self.grid.frame.reference_spp / 2, seed)?;
            }
        }
        Reference::read(&halves)
    }

    /// Adds the view of the grid's frame.
    fn view<'c>(&self, call: Call<'c>) -> Call<'c> {
        let frame = &self.grid.frame;
        call.option("--light", &frame.light)
            .option("--size", &frame.size)
            .options("--eye", &frame.eye)
            .options("--look-at", &frame.look_at)
            .options("--fov", frame.fov.map(|fov| fov.to_string()))
    }

    /// Relative error at the rows of a reference table and its standard error, the table's noise
    /// taken out.
    fn points_error(&self, run: &Path, table: &Path) -> Result<(f64, f64), ReportError> {
        let answers = run.join("answers.parquet");
        let call = self.program.call("query", run).option("--points", table);
        call.option("-o", &answers).run()?;
        points_error(&answers, table)
    }
}
