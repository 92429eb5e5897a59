//! Times of a frame's stages.

use crate::follow::MOST_FOLLOWED;
use rrf_field::EvaluationTimings;
use std::time::{Duration, Instant};

/// A stage of a frame, in the order of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameStage {
    /// Camera rays made and traced.
    PrimaryRays,
    /// Surface points, normals and materials of the hits, as columns.
    Points,
    /// Lights' unoccluded radiance, and their shadow rays made.
    Direct,
    /// Shadow rays traced.
    ShadowRays,
    /// Rows and lights taken to their cells.
    CellLookup,
    /// Inputs of the nets gathered and scaled.
    Inputs,
    /// Nets evaluated and summed over lights.
    Nets,
    /// Parts added into the picture.
    Resolve,
    /// Coefficients of the lights in a transfer, once a frame.
    Coefficients,
    /// Rays made and traced that go on from a surface: mirrors, glass, final gather.
    FollowedRays,
}

impl FrameStage {
    /// Name of each stage, in the order of work.
    pub const NAMES: [&str; 10] = [
        "primary_rays",
        "points",
        "direct",
        "shadow_rays",
        "cell_lookup",
        "inputs",
        "nets",
        "resolve",
        "coefficients",
        "followed_rays",
    ];

    /// The stages of the nets.
    pub const OF_NETS: [FrameStage; 3] = [Self::CellLookup, Self::Inputs, Self::Nets];
}

/// Time of each stage of a frame, summed over the threads that worked on it; the wall time of a
/// frame is about their sum divided by the threads. Beside it the rays that were followed from the
/// first surface on, from the second and so on, and the surface points that a fallback gathered over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimings(
    pub [Duration; FrameStage::NAMES.len()],
    pub [u64; MOST_FOLLOWED],
    pub u64,
);

impl FrameTimings {
    /// Adds another thread's times.
    pub fn add(&mut self, other: &FrameTimings) {
        for (sum, time) in self.0.iter_mut().zip(other.0) {
            *sum += time;
        }
        for (sum, rays) in self.1.iter_mut().zip(other.1) {
            *sum += rays;
        }
        self.2 += other.2;
    }
}

/// A thread's stopwatch, which is read at the end of each stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopwatch {
    last: Instant,
    pub(crate) timings: FrameTimings,
}

impl Default for Stopwatch {
    fn default() -> Stopwatch {
        Stopwatch {
            last: Instant::now(),
            timings: FrameTimings::default(),
        }
    }
}

impl Stopwatch {
    /// Begins a stage; the time since the last reading is nobody's.
    pub(crate) fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Adds the time since the last reading to `stage`.
    pub(crate) fn end(&mut self, stage: FrameStage) {
        let now = Instant::now();
        self.timings.0[stage as usize] += now - self.last;
        self.last = now;
    }

    /// Adds the stages of the nets, which timed themselves.
    pub(crate) fn end_nets(&mut self, nets: &EvaluationTimings) {
        self.timings.0[FrameStage::CellLookup as usize] += nets.lookup;
        self.timings.0[FrameStage::Inputs as usize] += nets.inputs;
        self.timings.0[FrameStage::Nets as usize] += nets.nets;
        self.restart();
    }
}
