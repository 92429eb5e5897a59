//! The socket of live frames: a question, a frame.

use crate::ask::{Ask, ShownLayer};
use crate::lamps::{DimmedLamps, MovedLamps};
use crate::pixels;
use crate::show::Show;
use crate::socket::{Ended, Socket};
use glam::Vec3;
use rrf_metrics::tone::Exposure;
use rrf_render::{Frame, FrameStage, Part, RenderError, RenderOptions, Renderer};
use rrf_trace::{Hits, Rays, TraceError};
use serde_json::{Value, json};
use std::time::Instant;

/// Answers until the page goes.
pub fn serve(show: &Show, socket: &mut Socket) -> Result<(), Ended> {
    socket.tell(&json!({ "hello": show.hello() }))?;
    let (mut frame, mut moved) = (Frame::default(), MovedLamps::default());
    let mut ask = next(show, socket)?;
    loop {
        let still = moved.show(show, &ask, |show| {
            while_lamps_stand(show, socket, &mut frame, ask.clone())
        });
        ask = match still {
            Ok(next) => next?,
            Err(error) => {
                socket.tell(&json!({ "id": ask.id, "error": error }))?;
                next(show, socket)?
            }
        };
    }
}

/// The next question that can be answered.
fn next(show: &Show, socket: &mut Socket) -> Result<Ask, Ended> {
    loop {
        match Ask::parse(&socket.ask()?, &show.view) {
            Ok(ask) => return Ok(ask),
            Err(reason) => socket.tell(&json!({ "error": reason }))?,
        }
    }
}

/// Answers a question, and all that follow until one has moved a lamp, which it returns; `show` has the
/// lamps where the question has them.
fn while_lamps_stand(
    show: &Show,
    socket: &mut Socket,
    frame: &mut Frame,
    mut ask: Ask,
) -> Result<Ask, Ended> {
    let (renderers, mut lamps) = (show.renderers(), DimmedLamps::default());
    loop {
        if let Some(at) = ask.pick {
            socket.tell(&json!({ "id": ask.id, "picked": pick(show, &ask, at) }))?;
        } else {
            // a picture at rest may take seconds: a question that comes meanwhile is more urgent
            let waits = || ask.aa > 1 && socket.has_question();
            match answer(show, &renderers, &ask, &waits, (frame, &mut lamps)) {
                Ok(Some((facts, bytes))) => {
                    socket.tell(&facts)?;
                    socket.send(bytes)?;
                }
                Ok(None) => socket.tell(&json!({ "id": ask.id, "dropped": true }))?,
                Err(error) => socket.tell(&json!({ "id": ask.id, "error": error }))?,
            }
        }
        let following = next(show, socket)?;
        if show.own.moved_lamps(&following) != show.own.moved_lamps(&ask) {
            return Ok(following);
        }
        ask = following;
    }
}

/// The frame asked for, as facts and as bytes; none if it was given up because `halt` said so.
fn answer(
    show: &Show,
    [dark, lit]: &[Renderer; 2],
    ask: &Ask,
    halt: &(dyn Fn() -> bool + Sync),
    (frame, lamps): (&mut Frame, &mut DimmedLamps),
) -> Result<Option<(Value, Vec<u8>)>, String> {
    let start = Instant::now();
    let lights = show.own.lights(ask)?;
    let options = RenderOptions {
        area_lights: lamps.under(&show.own, &lights),
        halt: Some(halt),
        ..options(show, ask)
    };
    let renderer = if lights.area { lit } else { dark };
    let timings = match renderer.render(&ask.view(&show.view), &lights, &options, frame) {
        Ok(timings) => timings,
        Err(RenderError::Trace(TraceError::Halted)) => return Ok(None),
        Err(error) => return Err(error.to_string()),
    };
    let rendered = start.elapsed();
    let exposure = exposure(ask, frame);
    let bytes = pixels::shown(frame, ask.mode, exposure);
    let times = timings.0.map(|time| 1e3 * time.as_secs_f64());
    let thread_ms: Vec<(&str, f64)> = FrameStage::NAMES.into_iter().zip(times).collect();
    let facts = json!({
        "id": ask.id,
        "size": [frame.width, frame.height],
        "aa": ask.aa,
        "noise": ask.noise_share(),
        "render_ms": 1e3 * rendered.as_secs_f64(),
        "frame_ms": 1e3 * start.elapsed().as_secs_f64(),
        "thread_ms": thread_ms,
        "exposure": exposure.ev,
        "warnings": show.warnings(ask, &lights),
    });
    Ok(Some((facts, bytes)))
}

/// Options of a layer's frame.
pub fn options<'a>(show: &Show<'a>, ask: &Ask) -> RenderOptions<'a> {
    RenderOptions {
        part: match ask.mode {
            ShownLayer::Full => Part::Full,
            ShownLayer::Direct => Part::Direct,
            _ => Part::Indirect,
        },
        aa: ask.aa,
        noise: ask.noise(),
        trusted: (ask.mode == ShownLayer::Trust).then_some(show.trusted),
        borders: show.borders.filter(|_| ask.blend),
        ..RenderOptions::default()
    }
}

/// The exposure asked for, or one chosen from the picture.
pub fn exposure(ask: &Ask, frame: &Frame) -> Exposure {
    let chosen = || Exposure::automatic(&frame.picture());
    ask.exposure.map_or_else(chosen, |ev| Exposure { ev })
}

/// The surface point at a place of the picture, if any.
fn pick(show: &Show, ask: &Ask, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
    let view = ask.view(&show.view);
    let direction = view.direction(x, y);
    if !direction.is_finite() {
        return None;
    }
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    rays.push(view.eye, direction, f32::INFINITY);
    show.tracer(false).closest(&rays, &mut hits);
    let t = hits.t.first().filter(|t| t.is_finite())?;
    Some(Vec3::to_array(&(view.eye + *t * direction)))
}
