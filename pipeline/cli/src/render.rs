//! `rrf render`: a frame by the baked nets.

use crate::args::{Fallback, LightSampling, Part, RenderArgs};
use crate::baked::Baked;
use crate::stats::{self, Clock};
use crate::{animate, pictures, view};
use glam::Vec3;
use rrf_metrics::color::luminance;
use rrf_render::{Frame, RenderOptions, Renderer, ShadowRays, trace_untrusted};
use rrf_trace::Tracer;

/// Renders the view and writes it; with `--frames` again and again, to measure.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    if let Some(path) = &args.path {
        return animate::run(args, path);
    }
    pictures::check_endings(&args.output)?;
    let baked = Baked::open(&args.run, args.trust.trust_error)?;
    let frame_view = view::view(&args.view.camera, &baked.scene)?;
    let lights = view::lights(&args.view.camera, &baked.scene)?;
    let tracer = Tracer::new(baked.shown(&lights))?;
    let lamps = baked.lamps(&lights)?;
    for notice in baked.check(&tracer, &frame_view, &lights, args.anyway)? {
        eprintln!("warning: {notice}");
    }
    let trusted = |rows: &rrf_field::columns::Columns| baked.trusted(rows);
    let options = RenderOptions {
        part: part(args.view.part),
        aa: args.view.aa,
        lamps: lamps.as_ref(),
        shadow_rays: shadow_rays(args),
        // A second look at every row: not where time is measured.
        trusted: args.json_stats.is_none().then_some(&trusted),
        borders: args.blend.then_some(&baked.borders),
        ..RenderOptions::default()
    };
    let renderer = Renderer::new(&tracer, &baked.field);
    let mut frame = Frame::default();
    let mut clock = Clock::default();
    for _ in 0..args.frames {
        clock.start();
        let stages = renderer.render(&frame_view, &lights, &options, &mut frame)?;
        clock.stop(stages);
    }
    if let Some(target) = &args.json_stats {
        stats::write(target, &stats::report(&clock, &frame_view, &lights))?;
    }
    if args.fallback == Fallback::Trace {
        let (spp, aa, seed) = (args.fallback_spp, args.view.aa, baked.run.manifest.seed);
        let traced = trace_untrusted(&tracer, &frame_view, &lights, &mut frame, spp, aa, seed)?;
        println!(
            "{traced} pixels path-traced: the nets were not trained for them, or not well enough"
        );
    }
    if args.show_trust {
        show_trust(&mut frame);
    }
    pictures::write(frame, &args.view, &args.output)
}

/// Sampled lights, where a number of shadow rays is given or only one way is left.
pub fn shadow_rays(args: &RenderArgs) -> Option<ShadowRays> {
    let adaptive = args.light_sampling == LightSampling::Adaptive;
    let standard = ShadowRays::default();
    match args.shadow_rays {
        None if adaptive => None,
        count => Some(ShadowRays {
            count: count.unwrap_or(standard.count),
            adaptive,
            seed: args.seed,
        }),
    }
}

/// Mixes red, as bright as the frame is on average, into pixels that are not trusted.
fn show_trust(frame: &mut Frame) {
    let count = frame.full.len().max(1) as f32;
    let red = Vec3::X * (3.0 * frame.full.iter().map(|&p| luminance(p)).sum::<f32>() / count);
    let cells = frame.cell.iter().flatten();
    for ((pixel, &trust), &cell) in frame
        .full
        .iter_mut()
        .zip(frame.trust.iter().flatten())
        .zip(cells)
    {
        // a pixel that shows no surface has no cell, and nothing to trust or not
        if cell != u32::MAX {
            *pixel = pixel.lerp(red, 1.0 - trust.clamp(0.0, 1.0));
        }
    }
}

/// The part asked for, as the renderer names it.
pub fn part(part: Part) -> rrf_render::Part {
    match part {
        Part::Full => rrf_render::Part::Full,
        Part::Direct => rrf_render::Part::Direct,
        Part::Indirect => rrf_render::Part::Indirect,
    }
}
