//! `rrf render`: frames by the baked nets.

use crate::args::{Fallback, GatherArgs, TrustArgs, ViewArgs};
use crate::baked::{Baked, ReadyModel};
use crate::failure::BadInput;
use crate::film::{Film, FrameFormat};
use crate::pictures;
use crate::residual;
use crate::stats::{self, Clock};
use clap::{Args, ValueEnum};
use glam::Vec3;
use rrf_bake::settings::SkyArgs;
use rrf_bake::settings::parse::positive;
use rrf_extract::VisibilityQueries;
use rrf_field::columns::Columns;
use rrf_metrics::color::luminance;
use rrf_metrics::tone::Exposure;
use rrf_render::camera_path::{Shot, read_camera_path};
use rrf_render::{
    Frame, PathOptions, RenderOptions, Renderer, ShadowRays, Surroundings, View, add_auxiliary,
    trace_untrusted,
};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Size of a path's frames where --size is not given.
const SIZE: [u32; 2] = [512, 512];
/// Longer side in pixels of the frame that tells the exposure.
const SMALL: u32 = 48;
/// Why a transfer's cells are not blended.
pub(super) const NO_BLEND: &str =
    "--blend: is for runs of nets; cells of a transfer are not blended";
/// Rays of a pixel that is not trusted, by gathering.
const FALLBACK_RAYS: u32 = 64;
/// Paths of a pixel and light that is not trusted, by path tracing.
const FALLBACK_PATHS: u32 = 256;
/// Different warnings that are said in full.
const MOST_WARNINGS: usize = 10;

/// Render frames by the baked nets, plus exact direct light.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Picture to write (.exr with layers, .png tone-mapped); again for more. With --path the
    /// new folder for frames.
    #[arg(short, long, value_name = "F", required = true)]
    pub output: Vec<PathBuf>,
    /// A frame for each row of a table with the columns eye_x eye_y eye_z target_x target_y
    /// target_z fov, optionally up_x up_y up_z and light0_x light0_y light0_z [light0_r light0_g
    /// light0_b], light1_x ...
    #[arg(long, value_name = "CAMERA.csv", conflicts_with_all = ["eye", "look_at", "up", "fov", "frames", "mirror"])]
    pub path: Option<PathBuf>,
    /// Formats of the frames of --path.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [FrameFormat::Exr, FrameFormat::Png])]
    pub formats: Vec<FrameFormat>,
    /// View and lights.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Another sky than the run's scene has, or one for a scene without.
    #[command(flatten)]
    pub sky: SkyArgs,
    /// Shadow rays of each camera ray, shared by all lights. By default point lights get one
    /// each, and lamps, sky and sun together as many as --noise needs; with `--light-sampling
    /// uniform` all lights 16 together.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub shadow_rays: Option<u32>,
    /// Standard error of the direct light of lamps, sky and sun that a pixel's shadow rays go on to, as
    /// a share of the exposure's white.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = positive, conflicts_with_all = ["shadow_rays"])]
    pub noise: f32,
    /// Choice of a light for each shadow ray.
    #[arg(long, value_enum, default_value_t = LightSampling::Adaptive)]
    pub light_sampling: LightSampling,
    /// Rays in place of the model's answers.
    #[command(flatten)]
    pub gather: GatherArgs,
    /// Rays of a pixel of --fallback gather, 64 unless given; paths of a pixel and light of --fallback
    /// trace, 256 unless given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub fallback_spp: Option<u32>,
    /// Render also what is refused otherwise: an eye or a light inside a solid, a light on a
    /// surface.
    #[arg(long)]
    pub anyway: bool,
    /// Seed of the shadow rays, and of the rays that rough mirrors and gathering send.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Blend the nets of neighbouring cells within a tenth of a cell where they meet and agree, so that
    /// their borders do not show.
    #[arg(long, conflicts_with = "json_stats")]
    pub blend: bool,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
    /// Paint pixels that are not trusted red, by the share of their samples.
    #[arg(long, conflicts_with_all = ["json_stats", "path"])]
    pub show_trust: bool,
    /// Write what the frame cost, stage by stage, as JSON (`-`: to standard output). Frames are
    /// then made without the layer of trust.
    #[arg(long, value_name = "FILE")]
    pub json_stats: Option<PathBuf>,
    /// Render the frame N times, for --json-stats in steady state.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "json_stats", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
}

/// Choice of a light for each shadow ray; both are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightSampling {
    /// By what earlier rays of the pixel and its neighbours found (Donikian et al. 2006).
    Adaptive,
    /// All alike.
    Uniform,
}

/// Renders the view and writes it, or every frame of a path; with `--frames` again and again, to
/// measure.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    match &args.path {
        None => pictures::check_endings(&args.output)?,
        Some(_) if args.output.len() == 1 => {}
        Some(_) => return Err(BadInput("--path writes one folder; give -o once".into()).into()),
    }
    let mut baked = Baked::open(&args.run, args.trust.trust_error)?;
    baked.scene = relit(args, &baked.scene)?;
    match frame(args, &baked)? {
        Some(frame) => pictures::write(frame, &args.view, &args.output),
        None => Ok(()),
    }
}

/// A run's scene with its lights and its sky as they are asked for.
pub fn relit(args: &RenderArgs, scene: &Scene) -> anyhow::Result<Scene> {
    let mut scene = scene.clone();
    if let Some(sky) = args.sky.option() {
        scene.replace_sky(&sky)?;
    }
    Ok(args.view.camera.relit(&scene)?.into_owned())
}

/// The frame of one view; none of a path, whose frames are written one by one.
pub fn frame(args: &RenderArgs, baked: &Baked) -> anyhow::Result<Option<Frame>> {
    if args.blend && baked.nets().is_none() {
        return Err(BadInput(NO_BLEND.into()).into());
    }
    let fallback = args.gather.fallback.unwrap_or(Fallback::None);
    if fallback == Fallback::Trace && (args.path.is_some() || args.json_stats.is_some()) {
        let told = "--fallback trace: is for single frames, without --path and --json-stats";
        return Err(BadInput(told.into()).into());
    }
    let shots = shots(args, baked)?;
    crate::memory::check_frame(shots[0].view.width, shots[0].view.height)?;
    let lights = &shots[0].lights;
    let unlit = Tracer::new(&baked.unlit)?;
    let whole = baked
        .has_area_lights(lights)
        .then(|| Tracer::new(&baked.scene));
    let whole = whole.transpose()?;
    let tracer = whole.as_ref().unwrap_or(&unlit);
    let area_lights = baked.area_lights(lights)?;
    warn(args, baked, tracer, &shots)?;
    let mut film = match &args.path {
        Some(_) => Some(Film::new(
            &args.output[0],
            &args.formats,
            args.view.exposure(),
        )?),
        None => None,
    };
    let trusted = |rows: &Columns| baked.trusted(rows);
    let mut options = RenderOptions {
        part: args.view.part(),
        aa: args.view.aa,
        area_lights: area_lights.as_ref(),
        shadow_rays: shadow_rays(args),
        noise: None,
        seed: args.seed,
        // nets are asked again for every row: not where time is measured
        trusted: (film.is_none() && args.json_stats.is_none() || fallback == Fallback::Gather)
            .then_some(&trusted),
        gather: args.gather.gather.unwrap_or(0),
        fallback: match fallback {
            Fallback::Gather => args.fallback_spp.unwrap_or(FALLBACK_RAYS),
            _ => 0,
        },
        narrow_rays: 0,
        borders: baked
            .nets()
            .filter(|_| args.blend)
            .map(|nets| &nets.borders),
        halt: None,
    };
    let model = baked.ready(&unlit)?;
    let renderer = model.renderer(tracer);
    if let (ReadyModel::Transfer(book), None, 1) = (&model, &args.path, args.frames) {
        residual::warn(book, &baked.scene, lights)?;
    }
    options.noise = noise(args, &renderer, &shots[0], &options)?;
    let (mut frame, mut clock) = (Frame::default(), Clock::default());
    for shot in &shots {
        for _ in 0..args.frames {
            clock.start();
            let timings = renderer.render(&shot.view, &shot.lights, &options, &mut frame)?;
            clock.stop(timings);
        }
        let (aa, layers) = (args.view.aa, args.view.auxiliary());
        add_auxiliary(tracer, &shot.view, aa, &layers, &mut frame);
        if let Some(film) = &mut film {
            film.add(&frame)?;
        }
    }
    if let Some(target) = &args.json_stats {
        stats::write_report(target, &stats::report(&clock, &shots[0].view, lights))?;
    }
    if let Some(film) = film {
        film.finish()?;
        return Ok(None);
    }
    if fallback == Fallback::Trace {
        let Shot { view, lights } = &shots[0];
        let options = PathOptions {
            spp: args.fallback_spp.unwrap_or(FALLBACK_PATHS),
            aa: args.view.aa,
            seed: baked.manifest.seed,
        };
        let traced = trace_untrusted(tracer, view, lights, &mut frame, options)?;
        println!("{traced} pixels were path-traced, because their nets are not trusted");
    }
    if args.show_trust {
        show_trust(&mut frame);
    }
    Ok(Some(frame))
}

/// The view and lights of each frame: the view typed, or the rows of a camera's path under their own lights,
/// the ones typed or the scene's.
fn shots(args: &RenderArgs, baked: &Baked) -> anyhow::Result<Vec<Shot>> {
    let camera = &args.view.camera;
    let Some(path) = &args.path else {
        let (view, lights) = (camera.view(&baked.scene)?, camera.lights(&baked.scene)?);
        return Ok(vec![Shot { view, lights }]);
    };
    let mut shots = read_camera_path(path, camera.size.unwrap_or(SIZE))?;
    if shots.iter().all(|shot| shot.lights.points.is_empty()) {
        let lights = camera.lights(&baked.scene)?;
        shots.iter_mut().for_each(|s| s.lights.clone_from(&lights));
    } else if !camera.light.is_empty() {
        let told = format!("{}: has light columns; leave --light out", path.display());
        return Err(BadInput(told).into());
    }
    Ok(shots)
}

/// Says each different warning once; where a picture would show nothing that was meant, it is
/// refused, unless `--anyway`.
fn warn(args: &RenderArgs, baked: &Baked, tracer: &Tracer, shots: &[Shot]) -> Result<(), BadInput> {
    let visibility = VisibilityQueries::new(&baked.unlit, tracer);
    let surroundings = Surroundings {
        tracer,
        inside_solid: &|place| visibility.inside_solid(place),
        light_box: baked.light_box(),
        eye_box: baked.eye_box(),
    };
    let (mut told, mut more) = (Vec::new(), 0);
    for (row, Shot { view, lights }) in (1..).zip(shots) {
        let positions = lights.points.iter().map(|light| light.position);
        let place = match &args.path {
            Some(path) => format!("{}: row {row}: ", path.display()),
            None => String::new(),
        };
        for warning in surroundings.warnings(view.eye, positions) {
            if warning.is_fatal && !args.anyway {
                return Err(BadInput(format!("{place}{warning} (--anyway renders it)")));
            }
            if told.len() < MOST_WARNINGS && !told.contains(&warning) {
                eprintln!("warning: {place}{warning}");
                told.push(warning);
            } else {
                more += 1;
            }
        }
    }
    if more > 0 {
        eprintln!("warning: {more} more warnings like these");
    }
    if baked.nets().is_none() {
        return Ok(());
    }
    let sources = shots.iter().flat_map(|shot| &shot.lights.sources);
    let names: BTreeSet<&str> = sources.map(|light| light.name.as_str()).collect();
    if !names.is_empty() {
        let names = names.into_iter().collect::<Vec<_>>().join(", ");
        eprintln!(
            "warning: {names}: nets know point lights, so that the indirect light of these is missing; \
             `rrf trace` has it"
        );
    }
    Ok(())
}

/// The bound on the noise of direct light: a share of the exposure's white, which a small frame
/// tells where it is not typed.
fn noise(
    args: &RenderArgs,
    renderer: &Renderer,
    shot: &Shot,
    options: &RenderOptions,
) -> anyhow::Result<Option<f32>> {
    let Shot { view, lights } = shot;
    let sampled = options.area_lights.is_some() || !lights.sources.is_empty();
    if options.shadow_rays.is_some() || !sampled {
        return Ok(None);
    }
    let exposure = match args.view.exposure() {
        Some(exposure) => exposure,
        None => {
            let scale = f64::from(SMALL) / f64::from(view.width.max(view.height).max(1));
            let side = |pixels: u32| ((f64::from(pixels) * scale) as u32).clamp(1, pixels.max(1));
            let small = View {
                width: side(view.width),
                height: side(view.height),
                ..view.clone()
            };
            let options = RenderOptions {
                trusted: None,
                ..*options
            };
            let mut frame = Frame::default();
            renderer.render(&small, lights, &options, &mut frame)?;
            Exposure::automatic(&frame.picture())
        }
    };
    Ok(Some(args.noise * (-exposure.ev).exp2()))
}

/// Sampled lights, where a number of shadow rays is given or only one way is left.
fn shadow_rays(args: &RenderArgs) -> Option<ShadowRays> {
    let adaptive = args.light_sampling == LightSampling::Adaptive;
    let standard = ShadowRays::default();
    match args.shadow_rays {
        None if adaptive => None,
        count => Some(ShadowRays {
            count: count.unwrap_or(standard.count),
            noise: None,
            adaptive,
        }),
    }
}

/// Mixes red, as bright as the frame is on average, into pixels that are not trusted.
fn show_trust(frame: &mut Frame) {
    let count = frame.full.len().max(1) as f32;
    let red = Vec3::X * (3.0 * frame.full.iter().map(|&p| luminance(p)).sum::<f32>() / count);
    let trust = frame.trust.iter().flatten();
    let trust = trust.zip(frame.cell.iter().flatten());
    for (pixel, (&trust, &cell)) in frame.full.iter_mut().zip(trust) {
        // a pixel that shows no surface has no cell, and nothing to trust or not
        if cell != u32::MAX {
            *pixel = pixel.lerp(red, 1.0 - trust.clamp(0.0, 1.0));
        }
    }
}
