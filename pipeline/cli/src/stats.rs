//! `--json-stats`: what frames cost, stage by stage.

use rrf_render::{FrameStage, FrameTimings, Lights, MOST_FOLLOWED, View};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// Times of frames, one after another.
#[derive(Default)]
pub struct Clock {
    started: Option<(Instant, Duration)>,
    wall: Vec<f64>,
    processor: Vec<f64>,
    timings: Vec<FrameTimings>,
}

impl Clock {
    /// A frame begins.
    pub fn start(&mut self) {
        self.started = Some((Instant::now(), processor_time()));
    }

    /// The frame is there.
    pub fn stop(&mut self, timings: FrameTimings) {
        if let Some((wall, processor)) = self.started.take() {
            self.wall.push(wall.elapsed().as_secs_f64());
            self.processor
                .push((processor_time() - processor).as_secs_f64());
            self.timings.push(timings);
        }
    }
}

/// Medians over the frames. FrameTimings are given in processor time: their share of the threads'
/// time, times the processor time of the frame, which stays true on a machine with other work.
pub fn report(clock: &Clock, view: &View, lights: &Lights) -> Value {
    let pixels = f64::from(view.width) * f64::from(view.height);
    let frames = clock.timings.iter().zip(&clock.processor);
    let shares: Vec<Vec<f64>> = frames.map(|(t, &seconds)| shares(t, seconds)).collect();
    let per_pixel = |seconds: f64| 1e9 * seconds / pixels;
    let stage = |(k, name): (usize, &str)| {
        let seconds = median(shares.iter().map(|s| s[k]).collect());
        json!({ "stage": name, "processor_ms": 1e3 * seconds, "ns_per_pixel": per_pixel(seconds) })
    };
    // nets that answer for lights have no coefficients, and rooms without mirrors no followed rays
    let optional = [
        FrameStage::Coefficients as usize,
        FrameStage::FollowedRays as usize,
    ];
    let took_time = |k: usize| shares.iter().any(|s| s[k] > 0.0);
    let stages = FrameStage::NAMES.into_iter().enumerate();
    let stages = stages.filter(|&(k, _)| !optional.contains(&k) || took_time(k));
    let stages = stages.map(stage);
    let of_nets = FrameStage::OF_NETS.map(|stage| stage as usize);
    let of_nets = shares.iter().map(|s| of_nets.iter().map(|&k| s[k]).sum());
    let wall = median(clock.wall.clone());
    json!({
        "size": [view.width, view.height],
        "point_lights": lights.points.len(),
        "area_lights": lights.area,
        "threads": rayon::current_num_threads(),
        "frames": clock.wall.len(),
        "frame_ms": 1e3 * wall,
        "frames_per_second": 1.0 / wall,
        "processor_ms": 1e3 * median(clock.processor.clone()),
        "indirect_ns_per_pixel_and_core": per_pixel(median(of_nets.collect())),
        "followed_rays": followed_rays(clock),
        "gathered_points": clock.timings.last().map_or(0, |t| t.2),
        "stages": stages.collect::<Vec<Value>>(),
    })
}

/// Rays that were followed from the first surface of a chain on, from the second and so on, in the last
/// frame; the longest chains end the list.
fn followed_rays(clock: &Clock) -> Vec<u64> {
    let counts = clock.timings.last().map_or([0; MOST_FOLLOWED], |t| t.1);
    let longest = counts
        .iter()
        .rposition(|&rays| rays > 0)
        .map_or(0, |k| k + 1);
    counts[..longest].to_vec()
}

/// A frame's processor time shared out over its stages by their thread time.
fn shares(timings: &FrameTimings, processor: f64) -> Vec<f64> {
    let times = timings.0.map(|time| time.as_secs_f64());
    let sum = times.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    times.iter().map(|time| processor * time / sum).collect()
}

/// Writes the report to a file, or to standard output for `-`.
pub fn write_report(target: &Path, report: &Value) -> anyhow::Result<()> {
    let text = format!("{report:#}\n");
    if target.as_os_str() == "-" {
        print!("{text}");
        return Ok(());
    }
    Ok(rrf_store::atomic::atomic_write(target, text.as_bytes())?)
}

fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Processor time of this process so far, on all threads.
#[cfg(unix)]
pub fn processor_time() -> Duration {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: writes one timespec, which `time` is.
    let failed = unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
    if failed != 0 {
        return Duration::ZERO;
    }
    Duration::new(
        time.tv_sec.unsigned_abs(),
        time.tv_nsec.unsigned_abs() as u32,
    )
}

#[cfg(not(unix))]
pub fn processor_time() -> Duration {
    Duration::ZERO
}
