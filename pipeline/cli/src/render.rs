//! `rrf render`: a frame by the baked nets.

use crate::args::{LightSampling, Part, RenderArgs};
use crate::baked::Baked;
use crate::stats::{self, Clock};
use crate::{animate, pictures, view};
use rrf_render::{Frame, RenderOptions, Renderer, ShadowRays};
use rrf_trace::Tracer;

/// Renders the view and writes it; with `--frames` again and again, to measure.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    if let Some(path) = &args.path {
        return animate::run(args, path);
    }
    pictures::check_endings(&args.output)?;
    let baked = Baked::open(&args.run)?;
    let frame_view = view::view(&args.view, &baked.scene)?;
    let lights = view::lights(&args.view, &baked.scene)?;
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

/// The part asked for, as the renderer names it.
pub fn part(part: Part) -> rrf_render::Part {
    match part {
        Part::Full => rrf_render::Part::Full,
        Part::Direct => rrf_render::Part::Direct,
        Part::Indirect => rrf_render::Part::Indirect,
    }
}
