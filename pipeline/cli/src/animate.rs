//! `rrf render --path`: a frame for each row of a camera's path, and a sheet of all.

use crate::args::{FrameFormat, RenderArgs};
use crate::baked::Baked;
use crate::failure::BadInput;
use crate::render::{part, shadow_rays};
use crate::stats::{self, Clock};
use crate::view;
use anyhow::Context;
use rrf_metrics::tone::Exposure;
use rrf_render::path::{self, Shot};
use rrf_render::{Frame, Lights, RenderOptions, Renderer, exr, png};
use rrf_trace::Tracer;
use std::path::Path;

/// Size of the frames where --size is not given.
const SIZE: [u32; 2] = [512, 512];
/// Longest side of a picture on the contact sheet.
const THUMBNAIL: u32 = 192;

/// Renders every frame into a new folder.
pub fn run(args: &RenderArgs, camera: &Path) -> anyhow::Result<()> {
    let [folder] = args.output.as_slice() else {
        return Err(BadInput("--path writes one folder: give -o once".into()).into());
    };
    let shots = path::read(camera, args.view.camera.size.unwrap_or(SIZE))?;
    let baked = Baked::open(&args.run, args.trust.trust_error)?;
    let lights = lights(args, &baked, &shots)?;
    let first = lights.first().cloned().unwrap_or_default();
    let tracer = Tracer::new(baked.shown(&first))?;
    let lamps = baked.lamps(&first)?;
    let mut told = Vec::new();
    for (number, (shot, lights)) in shots.iter().zip(&lights).enumerate() {
        let notices = baked.check(&tracer, &shot.view, lights, args.anyway);
        let notices = notices.map_err(|error| {
            BadInput(format!("{}: row {}: {error}", camera.display(), number + 1))
        })?;
        told.extend(notices.iter().map(|notice| (number, notice.to_string())));
    }
    warn(&told);
    new_folder(folder)?;
    let options = RenderOptions {
        part: part(args.view.part),
        aa: args.view.aa,
        lamps: lamps.as_ref(),
        shadow_rays: shadow_rays(args),
        borders: args.blend.then_some(&baked.borders),
        ..RenderOptions::default()
    };
    let renderer = Renderer::new(&tracer, &baked.field);
    let mut frame = Frame::default();
    let (mut clock, mut sheet) = (Clock::default(), Vec::new());
    let mut exposure = args.view.exposure.map(|ev| Exposure { ev });
    for (number, (shot, lights)) in shots.iter().zip(&lights).enumerate() {
        clock.start();
        let stages = renderer.render(&shot.view, lights, &options, &mut frame)?;
        clock.stop(stages);
        // one exposure for all: an automatic one a frame would flicker
        let picture = frame.picture();
        let exposure = *exposure.get_or_insert_with(|| Exposure::automatic(&picture));
        let shown = png::tone_mapped(&picture, exposure);
        for format in &args.formats {
            let file = |ending: &str| folder.join(format!("frame-{number:05}.{ending}"));
            match format {
                FrameFormat::Exr => exr::write(&file("exr"), &frame)?,
                FrameFormat::Png => png::write(&file("png"), &shown)?,
            }
        }
        sheet.push(png::thumbnail(&shown, THUMBNAIL));
    }
    let columns = (sheet.len() as f64).sqrt().ceil() as u32;
    png::write(
        &folder.join("contact-sheet.png"),
        &png::contact_sheet(&sheet, columns),
    )?;
    if let Some(target) = &args.json_stats {
        let first = shots.first().zip(lights.first());
        let report = first.map(|(shot, lights)| stats::report(&clock, &shot.view, lights));
        stats::write(target, &report.unwrap_or_default())?;
    }
    let ev = exposure.unwrap_or_default().ev;
    println!(
        "{}: {} frames, exposure {ev:+.2} stops, sRGB",
        folder.display(),
        shots.len()
    );
    Ok(())
}

/// Each frame's lights: its row's, or the ones typed, or the scene's.
fn lights(args: &RenderArgs, baked: &Baked, shots: &[Shot]) -> Result<Vec<Lights>, BadInput> {
    if shots.iter().all(|shot| shot.lights.is_empty()) {
        let lights = view::lights(&args.view.camera, &baked.scene)?;
        return Ok(vec![lights; shots.len()]);
    }
    if !args.view.camera.light.is_empty() {
        return Err(BadInput(
            "the path has light columns: leave --light out".into(),
        ));
    }
    let own = |shot: &Shot| Lights {
        points: shot.lights.clone(),
        area: false,
    };
    Ok(shots.iter().map(own).collect())
}

/// Frames of another path must not stay among these.
fn new_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: cannot be made", folder.display()))?;
    let mut entries =
        std::fs::read_dir(folder).with_context(|| format!("{}: not read", folder.display()))?;
    match entries.next() {
        None => Ok(()),
        Some(_) => Err(BadInput(format!(
            "{}: is not empty; give a new folder for the frames",
            folder.display()
        ))
        .into()),
    }
}

/// Each different notice once, with the frames that it concerns counted.
fn warn(told: &[(usize, String)]) {
    let mut seen: Vec<&str> = Vec::new();
    for (number, notice) in told {
        if seen.len() < 10 && !seen.contains(&notice.as_str()) {
            seen.push(notice);
            eprintln!("warning: frame {number}: {notice}");
        }
    }
    if told.len() > seen.len() {
        eprintln!("warning: {} more like these", told.len() - seen.len());
    }
}
