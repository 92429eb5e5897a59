//! Where a frame's time goes.

use rrf_field::EvaluationTimings;
use std::time::{Duration, Instant};

/// Time of each stage of a frame, summed over the threads that worked on it; the wall time of a
/// frame is about their sum divided by the threads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    /// Camera rays made and traced.
    pub primary_rays: Duration,
    /// Surface points, normals and materials of the hits, as columns.
    pub points: Duration,
    /// The nets: rows and lights taken to their cells, inputs, evaluation.
    pub nets: EvaluationTimings,
    /// Lights' unoccluded radiance and their shadow rays made.
    pub direct: Duration,
    /// Shadow rays traced.
    pub shadow_rays: Duration,
    /// Parts added into the picture.
    pub resolve: Duration,
}

impl Stages {
    /// Each stage's name and time, in the order of work.
    pub fn table(&self) -> [(&'static str, Duration); 8] {
        [
            ("primary_rays", self.primary_rays),
            ("points", self.points),
            ("direct", self.direct),
            ("shadow_rays", self.shadow_rays),
            ("cell_lookup", self.nets.lookup),
            ("inputs", self.nets.inputs),
            ("nets", self.nets.nets),
            ("resolve", self.resolve),
        ]
    }

    /// Adds another thread's times.
    pub fn add(&mut self, other: &Stages) {
        self.primary_rays += other.primary_rays;
        self.points += other.points;
        self.nets.add(&other.nets);
        self.direct += other.direct;
        self.shadow_rays += other.shadow_rays;
        self.resolve += other.resolve;
    }
}

/// A stop watch that is read at the end of each stage.
#[derive(Clone, Copy, Debug)]
pub struct Lap(Instant);

impl Lap {
    /// Starts.
    pub fn start() -> Lap {
        Lap(Instant::now())
    }

    /// Adds the time since the last reading to `stage`.
    pub fn end(&mut self, stage: &mut Duration) {
        let now = Instant::now();
        *stage += now - self.0;
        self.0 = now;
    }
}
