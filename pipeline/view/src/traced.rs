//! The socket of path tracing: the current view's truth, pass by pass.

use crate::ask::Ask;
use crate::frames::{exposure, options};
use crate::lamps::{DimmedLamps, MovedLamps};
use crate::pixels;
use crate::show::Show;
use crate::socket::{Ended, Socket};
use glam::Vec3;
use rayon::ThreadPool;
use rrf_metrics::{MetricsError, Picture, compare_noisy};
use rrf_render::{Frame, Lights, Part, PathOptions, RenderOptions, trace_frame};
use serde::Deserialize;
use serde_json::{Value, json};
use std::time::Instant;

/// Paths a pixel and pass: the least, so that a page that leaves does not leave work behind.
const PASS: u32 = 2;
/// Seed of the first pass; pass k has this plus k.
const SEED: u64 = 1;

/// A page's question.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Question {
    /// Begin with this view.
    Begin(Box<serde_json::value::RawValue>),
    /// Another pass, shown with this exposure in stops; none to have it chosen.
    Next(Option<f32>),
}

/// A view's picture by the nets, and the sum of its traced passes.
struct Work {
    ask: Ask,
    lights: Lights,
    moved: MovedLamps,
    nets: Frame,
    /// Sums of every fourth pass: four independent pictures.
    sums: [Vec<Vec3>; 4],
    passes: u32,
    seconds: f64,
}

/// Answers until the page goes. Paths are traced on `pool`: frames do not wait for them.
pub fn serve(show: &Show, pool: &ThreadPool, socket: &mut Socket) -> Result<(), Ended> {
    let mut work: Option<Work> = None;
    loop {
        let question = socket.ask()?;
        let begun = match serde_json::from_str(&question) {
            Ok(Question::Begin(ask)) => begin(show, ask.get()).map(|begun| work = Some(begun)),
            Ok(Question::Next(ev)) if ev.is_none_or(f32::is_finite) => {
                work.iter_mut().for_each(|work| work.ask.exposure = ev);
                Ok(())
            }
            Ok(Question::Next(_)) => Err("the exposure is not finite".into()),
            Err(error) => Err(error.to_string()),
        };
        let told = begun.and_then(|()| {
            let work = work.as_mut().ok_or("nothing was begun")?;
            pool.install(|| work.pass(show))?;
            work.tell().map_err(|e| e.to_string())
        });
        match told {
            Ok((facts, pictures)) => {
                socket.tell(&facts)?;
                for bytes in pictures {
                    socket.send(bytes)?;
                }
            }
            Err(reason) => socket.tell(&json!({ "error": reason }))?,
        }
    }
}

/// The view's picture by the nets; no pass yet.
fn begin(show: &Show, ask: &str) -> Result<Work, String> {
    let ask = Ask::parse(ask, &show.view)?;
    let (mut nets, mut moved) = (Frame::default(), MovedLamps::default());
    let lights = show.own.lights(&ask)?;
    let rendered = moved.show(show, &ask, |show| {
        let [dark, lit] = show.renderers();
        let renderer = if lights.area { lit } else { dark };
        let mut lamps = DimmedLamps::default();
        let options = RenderOptions {
            area_lights: lamps.under(&show.own, &lights),
            ..options(show, &ask)
        };
        renderer.render(&ask.view(&show.view), &lights, &options, &mut nets)
    });
    rendered?.map_err(|e| e.to_string())?;
    Ok(Work {
        sums: [0; 4].map(|_| vec![Vec3::ZERO; nets.full.len()]),
        ask,
        lights,
        moved,
        nets,
        passes: 0,
        seconds: 0.0,
    })
}

impl Work {
    fn pass(&mut self, show: &Show) -> Result<(), String> {
        let start = Instant::now();
        let (view, lights) = (self.ask.view(&show.view), &self.lights);
        let paths = PathOptions {
            spp: PASS,
            aa: 1,
            seed: SEED + u64::from(self.passes),
        };
        let traced = self.moved.show(show, &self.ask, |show| {
            trace_frame(show.tracer(lights.area), &view, lights, paths, &|_| {})
        });
        let frame = traced?.map_err(|e| e.to_string())?;
        let part = match options(show, &self.ask).part {
            Part::Full => Some(&frame.full),
            Part::Direct => frame.direct.as_ref(),
            Part::Indirect => frame.indirect.as_ref(),
        };
        let sums = &mut self.sums[self.passes as usize % 4];
        for (sum, value) in sums.iter_mut().zip(part.into_iter().flatten()) {
            *sum += *value;
        }
        self.passes += 1;
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// The means of the four sums, which have as many passes each.
    fn parts(&self) -> [Picture; 4] {
        let mean = 4.0 / self.passes.max(4) as f32;
        self.sums.each_ref().map(|sum| Picture {
            pixels: sum.iter().map(|&sum| mean * sum).collect(),
            ..self.nets.picture()
        })
    }

    /// The traced picture and the difference, and how far apart they are; the perceptual
    /// measures take long, and so only after 4, 8, 16 ... passes.
    fn tell(&self) -> Result<(Value, [Vec<u8>; 2]), MetricsError> {
        let nets = self.nets.picture();
        let mean = 1.0 / self.passes.max(1) as f32;
        let [a, b, c, d] = &self.sums;
        let pixels = (0..a.len()).map(|i| mean * (a[i] + b[i] + c[i] + d[i]));
        let truth = Picture {
            pixels: pixels.collect(),
            ..nets
        };
        let exposure = exposure(&self.ask, &self.nets);
        let measures = match self.passes >= 4 && self.passes.is_power_of_two() {
            true => Some(compare_noisy(&self.parts(), &nets, exposure)?),
            false => None,
        };
        let facts = json!({
            "id": self.ask.id,
            "size": [truth.width, truth.height],
            "paths": PASS * self.passes,
            "seconds": self.seconds,
            "full_difference": pixels::FULL_DIFFERENCE,
            "measures": measures,
        });
        let difference = pixels::difference(&truth, &nets);
        Ok((
            facts,
            [pixels::exposed(&truth.pixels, exposure), difference],
        ))
    }
}
