//! The socket of live frames: a question, a frame.

use crate::ask::{Ask, ShownLayer};
use crate::own::DimmedLamps;
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
    let renderers = show.renderers();
    let (mut frame, mut lamps) = (Frame::default(), DimmedLamps::default());
    loop {
        let ask = match Ask::parse(&socket.ask()?) {
            Ok(ask) => ask,
            Err(reason) => {
                socket.tell(&json!({ "error": reason }))?;
                continue;
            }
        };
        if let Some(at) = ask.pick {
            socket.tell(&json!({ "id": ask.id, "picked": pick(show, &ask, at) }))?;
            continue;
        }
        // a picture at rest may take seconds: a question that comes meanwhile is more urgent
        let waits = || ask.aa > 1 && socket.has_question();
        match answer(show, &renderers, &ask, &waits, (&mut frame, &mut lamps)) {
            Ok(Some((facts, bytes))) => {
                socket.tell(&facts)?;
                socket.send(bytes)?;
            }
            Ok(None) => socket.tell(&json!({ "id": ask.id, "dropped": true }))?,
            Err(error) => socket.tell(&json!({ "id": ask.id, "error": error }))?,
        }
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
    let timings = match renderer.render(&ask.view(), &lights, &options, frame) {
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
    let view = ask.view();
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
