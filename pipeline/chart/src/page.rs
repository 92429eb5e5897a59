//! `rrf report`: all about one run on one page.

use crate::{ChartError, Program, draw, html, rounds};
use base64::Engine;
use rrf_bake::Run;
use rrf_metrics::{FrameMetric, Pair, Picture, compare};
use rrf_render::png::Shown;
use rrf_render::{exr, png};
use rrf_scene::Scene;
use rrf_store::model::{self, CellMetrics};
use std::ffi::OsString;
use std::io::Cursor;
use std::path::{Path, PathBuf};

mod curves;
mod lights;
mod tables;

/// What a page is made of.
pub struct Page<'a> {
    /// The program that renders the frames.
    pub program: Program,
    /// The run folder.
    pub run: &'a Path,
    /// View and light options of `rrf render`, as typed.
    pub view: Vec<OsString>,
    /// Paths a pixel of the path-traced frame.
    pub spp: u32,
    /// The page.
    pub output: &'a Path,
}

/// Renders and traces the frame, and writes the page.
///
/// # Errors
/// [`ChartError`].
pub fn write(page: &Page) -> Result<(), ChartError> {
    let run = Run::open(page.run)?;
    let scene = run.load_scene()?;
    let metrics = model::read_metrics(page.run, &run.facts())?;
    let mut body = tables::run(&run, &metrics);
    body += &untrusted(&run, &scene, &metrics);
    body += &frames(page, &run)?;
    body += &course(&run)?;
    body += &curves::training(&run, &metrics)?;
    body += &tables::cells(&metrics);
    body += &lights::by_position(&run)?;
    body += &tables::scene(&scene);
    let name = page.run.file_name().unwrap_or(page.run.as_os_str());
    let title = format!("Run {}", name.to_string_lossy());
    html::write(page.output, &title, "", &body)
}

/// Errors and timings, round by round.
fn course(run: &Run) -> Result<String, ChartError> {
    let done = rounds::of(run)?;
    let mut out = format!("<h2>Rounds</h2>\n{}", rounds::table(&done));
    let target = 100.0 * f64::from(run.config.target);
    if done.len() > 1 {
        let panels = rounds::panels(&[("this run".into(), done)], Some(target));
        out += &format!(
            "<figure>{}<figcaption>Error on test rows after each round, one standard error; \
             dashed, the target.</figcaption></figure>\n",
            draw::svg_panels(&panels)?
        );
    }
    Ok(out)
}

/// The model's frame beside the path-traced one, error maps and cells.
fn frames(page: &Page, run: &Run) -> Result<String, ChartError> {
    let scratch = Scratch::new(page.output)?;
    let (model, traced) = (scratch.0.join("model.exr"), scratch.0.join("traced.exr"));
    let mut view = page.view.clone();
    let lit = view.iter().any(|word| word == "--light");
    if !lit {
        let [x0, y0, z0, x1, y1, z1] = run.manifest.light_box;
        let middle = [x0 + x1, y0 + y1, z0 + z1].map(|x| (0.5 * x).to_string());
        view.extend(["--light".into(), middle.join(",").into()]);
    }
    let words = |first: [OsString; 4]| first.into_iter().chain(view.clone()).collect::<Vec<_>>();
    let render = words([
        "render".into(),
        page.run.into(),
        "-o".into(),
        model.clone().into(),
    ]);
    let seconds = page.program.run(&render)?.seconds;
    let scene: OsString = run.manifest.scene.clone().into();
    let mut trace = words(["trace".into(), scene, "-o".into(), traced.clone().into()]);
    trace.extend(["--spp".into(), page.spp.to_string().into()]);
    let traced_seconds = page.program.run(&trace)?.seconds;
    let (frame, reference) = (exr::read_frame(&model)?, exr::read(&traced)?);
    let test = frame.picture();
    let comparison = compare(&reference, &test, None)?;
    let exposure = comparison.exposure;
    let pair = Pair::new(&reference, &test, exposure);
    let maps = ["flip", "delta_e_2000"].map(|name| error_map(name, &pair));
    let mut out = String::from("<h2>Frames</h2>\n");
    for (shown, caption) in [
        (
            png::tone_mapped(&test, exposure),
            format!("nets, {seconds:.2} s"),
        ),
        (
            png::tone_mapped(&reference, exposure),
            format!(
                "path traced, {} paths a pixel, {traced_seconds:.2} s",
                page.spp
            ),
        ),
        (
            heat(&maps[0], &reference, 1.0),
            "FLIP, black 0 to white 1".into(),
        ),
        (
            heat(&maps[1], &reference, 20.0),
            "ΔE2000, black 0 to white 20".into(),
        ),
        (
            png::cell_map(&frame),
            "cells of the nets that lit it".into(),
        ),
    ] {
        out += &figure(&shown, &caption)?;
    }
    let rows: Vec<Vec<String>> = (comparison.measures.iter())
        .map(|m| {
            vec![
                m.name.into(),
                format!("{:.5}", m.value),
                m.definition.into(),
            ]
        })
        .collect();
    out += &html::table(&["measure", "value", "definition"], &rows);
    Ok(out)
}

/// The values of a frame metric, pixel by pixel.
fn error_map(name: &str, pair: &Pair) -> Vec<f64> {
    FrameMetric::named(name).map_or_else(Vec::new, |metric| (metric.pixels)(pair))
}

/// Values as colours, black over red and yellow to white at `top` and above.
fn heat(values: &[f64], like: &Picture, top: f64) -> Shown {
    Shown::from_fn(like.width, like.height, |x, y| {
        let at = y as usize * like.width as usize + x as usize;
        let t = 3.0 * (values.get(at).copied().unwrap_or(0.0) / top).clamp(0.0, 1.0);
        let channel = |from: f64| (255.0 * (t - from).clamp(0.0, 1.0)).round() as u8;
        image::Rgb([channel(0.0), channel(1.0), channel(2.0)])
    })
}

fn figure(shown: &Shown, caption: &str) -> Result<String, ChartError> {
    let mut bytes = Cursor::new(Vec::new());
    shown
        .write_to(&mut bytes, image::ImageFormat::Png)
        .map_err(|e| ChartError::file(Path::new("picture"), "be encoded", e))?;
    let text = base64::engine::general_purpose::STANDARD.encode(bytes.into_inner());
    let caption = html::escape(caption);
    Ok(format!(
        "<figure><img src=\"data:image/png;base64,{text}\" alt=\"{caption}\">\
         <figcaption>{caption}</figcaption></figure>\n"
    ))
}

/// What a reader should not take for granted.
fn untrusted(run: &Run, scene: &Scene, metrics: &[CellMetrics]) -> String {
    let target = f64::from(run.config.target);
    let missed = |cell: &&CellMetrics| cell.validation.is_none_or(|e| e.relative().0 > target);
    let missed = metrics.iter().filter(missed).count();
    let quarantined: u64 = metrics.iter().map(|cell| cell.quarantined_rows).sum();
    let mut notes = vec![
        format!(
            "{missed} of {} cells miss the target of {:.1} %, or have no rows held out.",
            metrics.len(),
            100.0 * target
        ),
        "Lights outside the light box, and points outside the box that a cell's training rows \
         span (`trusted` in `rrf query`, the layer `trust` of a frame): the nets extrapolate."
            .into(),
        "Lights inside solids, and points sealed under one: left out of training; `rrf query` \
         says exactly zero there."
            .into(),
    ];
    if quarantined > 0 {
        notes.push(format!("{quarantined} rows were left out as impossible."));
    }
    if !scene.area_lights.is_empty() {
        let count = scene.area_lights.len();
        notes.push(format!(
            "The scene's {count} area lights are not baked: the nets are for point lights."
        ));
    }
    let items = notes
        .iter()
        .map(|n| format!("<li>{}</li>\n", html::escape(n)));
    format!(
        "<h2>What is not trusted</h2>\n<ul>\n{}</ul>\n",
        items.collect::<String>()
    )
}

/// A folder for the frames, removed when the page is done.
struct Scratch(PathBuf);

impl Scratch {
    fn new(beside: &Path) -> Result<Scratch, ChartError> {
        let name = beside.file_name().unwrap_or_default().to_string_lossy();
        let folder = beside.with_file_name(format!(".{name}.{}", std::process::id()));
        std::fs::create_dir_all(&folder).map_err(|e| ChartError::file(&folder, "be made", e))?;
        Ok(Scratch(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // what stays behind is only ever rendered again
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
