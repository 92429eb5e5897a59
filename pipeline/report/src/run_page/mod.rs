//! `rrf report`: all about one run on one page.

mod frames;
mod lights;
mod tables;
mod training;
mod transfer;

use crate::chart::chart_svg;
use crate::html::write_page;
use crate::rounds::{read_rounds, round_panels, rounds_table};
use crate::{Program, ReportError};
use frames::{FrameOptions, Pictured};
use maud::{Markup, PreEscaped, html};
use rrf_bake::{Run, RunMethod};
use rrf_store::model;
use std::path::PathBuf;

/// Write all about one run on one HTML page.
#[derive(clap::Args, Debug)]
pub struct ReportArgs {
    /// The run folder, baked.
    run: PathBuf,
    /// The page.
    #[arg(short, long, value_name = "F.html")]
    output: PathBuf,
    /// The frame that it shows.
    #[command(flatten)]
    frame: FrameOptions,
}

/// Renders and traces the frame, and writes the page.
///
/// # Errors
/// [`ReportError`].
pub(crate) fn run(args: &ReportArgs, program: &Program) -> Result<(), ReportError> {
    let body = match RunMethod::of(&args.run)? {
        RunMethod::Nets => nets(args, program)?,
        RunMethod::Transfer => transfer::page(&args.run, &args.frame, program)?,
    };
    let name = args.run.file_name().unwrap_or(args.run.as_os_str());
    let title = format!("Run {}", name.to_string_lossy());
    write_page(&args.output, &title, html! {}, body)?;
    println!("{}", args.output.display());
    Ok(())
}

/// The page of a run of nets.
fn nets(args: &ReportArgs, program: &Program) -> Result<Markup, ReportError> {
    let run = Run::open(&args.run)?;
    let scene = run.load_scene()?;
    let metrics = model::read_metrics(&args.run, &run.facts())?;
    let pictured = Pictured {
        run: &args.run,
        manifest: &run.manifest,
        read_by: run.config.load_options(),
        // nets know points
        shows_own_lights: false,
        model: "nets",
    };
    Ok(html! {
        (tables::settings(&run.manifest, &tables::counts(&metrics)))
        (tables::caveats(&run, &scene, &metrics))
        (frames::frames(&args.frame, program, &pictured)?)
        (rounds(&run)?)
        (training::curves(&run, &metrics)?)
        (tables::cells(&metrics))
        (lights::errors_by_position(&run)?)
        (tables::scene(&scene))
    })
}

/// Errors and timings, round by round.
fn rounds(run: &Run) -> Result<Markup, ReportError> {
    let rounds = read_rounds(run)?;
    let table = rounds_table(&rounds);
    let target = 100.0 * f64::from(run.config.target);
    let chart = match rounds.len() {
        0 | 1 => String::new(),
        _ => chart_svg(&round_panels(&[("this run".into(), rounds)], Some(target)))?,
    };
    Ok(html! {
        h2 { "Rounds" }
        (table)
        @if !chart.is_empty() {
            figure {
                (PreEscaped(chart))
                figcaption { "Error on test rows after each round, and one standard error." }
            }
        }
    })
}
