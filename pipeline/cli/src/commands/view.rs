//! `rrf view`: the baked scene as a live picture in a browser.

use crate::args::{CameraArgs, TrustArgs};
use crate::baked::{Baked, ReadyModel};
use anyhow::Context;
use clap::Args;
use glam::Vec3;
use rrf_extract::VisibilityQueries;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, Lights, Renderer, Surroundings, View};
use rrf_scene::PointLight;
use rrf_trace::Tracer;
use rrf_view::{OwnLights, Server, Show, ShownModel};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::path::PathBuf;

/// Look through a baked scene in a browser: move, drag lights, compare with the truth.
#[derive(Args, Clone, Debug)]
pub struct ViewPageArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Port on 127.0.0.1; 0 for a free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the desktop's browser; otherwise its URL is printed, and that is all.
    #[arg(long)]
    pub open: bool,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
    /// View and lights that the page starts with.
    #[command(flatten)]
    pub camera: CameraArgs,
}

/// Serves the page until a signal ends it.
pub fn run(args: &ViewPageArgs) -> anyhow::Result<()> {
    let mut baked = Baked::open(&args.run, args.trust.trust_error)?;
    baked.scene = args.camera.relit(&baked.scene)?.into_owned();
    let server = Server::bind(args.port)?;
    let stopper = server.stopper();
    // a pass of paths at the page's full size takes minutes
    let halt = || stopper.is_stopped();
    let tracer = Tracer::new(&baked.unlit)?.until(&halt);
    let lit = Tracer::new(&baked.scene)?.until(&halt);
    let ready = baked.ready(&tracer)?;
    let mut start = args.camera.view(&baked.scene)?;
    if args.camera.size.is_none() {
        fit(&mut start);
    }
    let visibility = VisibilityQueries::new(&baked.unlit, &tracer);
    let known = matches!(ready, ReadyModel::Transfer(_));
    // nets know points: lamps, sky and sun shine from the start only if asked for
    let on = args.camera.shows_own_lights()
        && baked.scene.has_own_lights()
        && (known || args.camera.scene_lights);
    let lamps = baked.area_lights(&Lights {
        area: true,
        ..Lights::default()
    })?;
    let typed = !(args.camera.light.is_empty() && args.camera.sun.is_empty());
    let lights = match typed || on {
        true => args.camera.typed().collect(),
        false => vec![first_light(&baked, &ready.renderer(&tracer), &start)?],
    };
    let show = Show {
        surroundings: Surroundings {
            tracer: &tracer,
            inside_solid: &|p| visibility.inside_solid(p),
            light_box: baked.light_box(),
            eye_box: baked.eye_box(),
        },
        model: match &ready {
            ReadyModel::Nets(nets) => ShownModel::Nets(&nets.field),
            ReadyModel::Transfer(book) => ShownModel::Transfer(book),
        },
        traces_narrow: baked.traces_narrow(),
        borders: baked.nets().map(|nets| &nets.borders),
        trusted: &|rows| baked.trusted(rows),
        view: start,
        view_is_typed: args.camera.eye.is_some(),
        lights,
        suns: args.camera.typed_suns().collect(),
        own: OwnLights {
            tracer: &lit,
            lamps: &lamps.unwrap_or_default(),
            on,
            known,
        },
        run: args.run.display().to_string(),
        halt: &halt,
    };
    ignore_broken_pipes();
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).context("signals")?;
    let (handle, waited) = (signals.handle(), server.stopper());
    println!("{}", server.url());
    println!("open it in a browser on this machine; Ctrl-C ends");
    if args.open {
        open(&server.url());
    }
    let waiting = std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            waited.stop();
        }
    });
    let served = server.run(&show);
    handle.close();
    // it only waits for signals, and has been told to end
    let _ = waiting.join();
    Ok(served?)
}

/// A page that is closed while a frame is on its way ends that connection, not the program.
fn ignore_broken_pipes() {
    #[cfg(unix)]
    // SAFETY: sets a signal's disposition; no handler is involved.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_IGN);
    }
}

/// A picture of a size that two cores keep moving: at most 512 on its shorter side.
fn fit(view: &mut View) {
    let shorter = view.width.min(view.height).max(1);
    if shorter > 512 {
        let scaled = |side: u32| (u64::from(side) * 512 / u64::from(shorter)).max(1) as u32;
        (view.width, view.height) = (scaled(view.width), scaled(view.height));
    }
}

/// A white light in the middle of the baked box, as strong as shows the view at 0 stops.
fn first_light(baked: &Baked, renderer: &Renderer, view: &View) -> anyhow::Result<PointLight> {
    let [low, high] = baked.light_box();
    let mut light = PointLight {
        position: 0.5 * (low + high),
        intensity: Vec3::ONE,
    };
    let small = View {
        width: 64,
        height: 64,
        ..view.clone()
    };
    let lights = Lights {
        points: vec![light],
        area: false,
        ..Lights::default()
    };
    let options = rrf_render::RenderOptions::default();
    let mut frame = Frame::default();
    renderer.render(&small, &lights, &options, &mut frame)?;
    light.intensity *= Exposure::automatic(&frame.picture()).ev.exp2();
    Ok(light)
}

/// Asks the desktop to open the page; without one the printed URL serves.
fn open(url: &str) {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let started = std::process::Command::new(opener)
        .arg(url)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn();
    if let Err(error) = started {
        eprintln!("{opener}: {error}; open the URL yourself");
    }
}
