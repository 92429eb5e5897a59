//! The model's frame beside the path-traced one, error maps and cells.

use crate::html::table;
use crate::program::Call;
use crate::{Program, ReportError};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};
use rrf_metrics::{FrameMetric, Pair, Picture, compare};
use rrf_render::png::Shown;
use rrf_render::{exr, png};
use rrf_scene::{LoadOptions, SkySource};
use rrf_store::manifest::RunManifest;
use std::io::Cursor;
use std::path::Path;

/// The frame that the page shows; `rrf render` checks the options.
#[derive(clap::Args, Debug)]
pub(super) struct FrameOptions {
    /// Paths a pixel of the path-traced frame.
    #[arg(long, value_name = "N", default_value_t = 256)]
    spp: u32,
    /// Eye position; by default the scene's first camera.
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    eye: Option<String>,
    /// Point that the camera looks at.
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    look_at: Option<String>,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG")]
    fov: Option<String>,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", default_value = "320x320")]
    size: String,
    /// A point light (again for more); by default the scene's own lights in runs of transfers, and where there
    /// are none, and for nets, one of 1 W/sr in the middle of the light box.
    #[arg(long, value_name = "x,y,z[,r,g,b]", allow_hyphen_values = true)]
    light: Vec<String>,
}

/// A run whose frame is shown.
pub(super) struct Pictured<'a> {
    /// Its folder.
    pub(super) run: &'a Path,
    /// `run.json`.
    pub(super) manifest: &'a RunManifest,
    /// How its scene was read.
    pub(super) read_by: LoadOptions,
    /// Whether the scene has lights of its own that the model knows.
    pub(super) shows_own_lights: bool,
    /// The model in a word.
    pub(super) model: &'a str,
}

/// The model's frame, the path-traced one, and how far apart they are.
pub(super) fn frames(
    args: &FrameOptions,
    program: &Program,
    pictured: &Pictured,
) -> Result<Markup, ReportError> {
    let scratch = tempfile::tempdir().map_err(|e| ReportError::Draw(e.to_string()))?;
    let [model, traced] = ["model.exr", "traced.exr"].map(|name| scratch.path().join(name));
    let mut lights = args.light.clone();
    if lights.is_empty() && !pictured.shows_own_lights {
        let [x0, y0, z0, x1, y1, z1] = pictured.manifest.light_box;
        let middle = [x0 + x1, y0 + y1, z0 + z1].map(|x| (0.5 * x).to_string());
        lights.push(middle.join(","));
    }
    let view = |call: Call| {
        call.option("--size", &args.size)
            .options("--eye", &args.eye)
            .options("--look-at", &args.look_at)
            .options("--fov", &args.fov)
            .options("--light", &lights)
            .run()
    };
    let render = program.call("render", pictured.run);
    let seconds = view(render.option("-o", &model))?.seconds;
    let trace = program.call("trace", &pictured.manifest.scene);
    let trace = read_by(trace, &pictured.read_by);
    let trace = trace.option("--spp", args.spp.to_string());
    let traced_seconds = view(trace.option("-o", &traced))?.seconds;
    let (frame, reference) = (exr::read_exr_frame(&model)?, exr::read_exr(&traced)?);
    let test = frame.picture();
    let comparison = compare(&reference, &test, None)?;
    let exposure = comparison.exposure;
    let pair = Pair::new(&reference, &test, exposure);
    let [flip, delta] = ["flip", "delta_e_2000"].map(|name| error_map(name, &pair));
    let traced_caption = format!(
        "path traced, {} paths a pixel, {traced_seconds:.2} s",
        args.spp
    );
    let rows = comparison.measures.iter().map(|m| {
        let value = format!("{:.5}", m.value);
        vec![m.name.into(), value, m.definition.into()]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    Ok(html! {
        h2 { "Frames" }
        (figure(&png::tone_mapped(&test, exposure), &format!("{}, {seconds:.2} s", pictured.model))?)
        (figure(&png::tone_mapped(&reference, exposure), &traced_caption)?)
        (figure(&heat(&flip, &reference, 1.0), "FLIP, black 0 to white 1")?)
        (figure(&heat(&delta, &reference, 20.0), "ΔE2000, black 0 to white 20")?)
        (figure(&png::cell_map(&frame), "cells that lit it")?)
        (table(&["measure", "value", "definition"], &rows))
    })
}

/// A command that reads a scene file as the run did.
fn read_by<'c>(call: Call<'c>, options: &LoadOptions) -> Call<'c> {
    let call = call
        .option("--default-albedo", options.default_albedo.to_string())
        .option("--light-units", options.light_units.name());
    let Some(sky) = &options.sky else {
        return call;
    };
    let source = match &sky.source {
        SkySource::Constant(radiance) => radiance.map(|x| x.to_string()).join(",").into(),
        SkySource::Picture(path) => path.as_os_str().to_owned(),
    };
    call.option("--sky", source)
        .option("--sky-rotate", sky.rotate.to_string())
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

fn figure(shown: &Shown, caption: &str) -> Result<Markup, ReportError> {
    let mut bytes = Cursor::new(Vec::new());
    shown
        .write_to(&mut bytes, image::ImageFormat::Png)
        .map_err(|e| ReportError::Draw(e.to_string()))?;
    let data = format!(
        "data:image/png;base64,{}",
        STANDARD.encode(bytes.into_inner())
    );
    Ok(html! {
        figure { img src=(data) alt=(caption); figcaption { (caption) } }
    })
}
