//! Indirect light by the path tracer that knows the lights, and errors against it.

use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Queries, Tracer, indirect};
use rrf_transfer::RowPoint;
use std::path::Path;

/// Two independent estimates of every point under every light.
pub struct Truth {
    pub points: Vec<RowPoint>,
    pub lights: Vec<Vec3>,
    /// Shape [points, lights].
    pub halves: [Vec<Vec3>; 2],
    /// 1 / max(channel mean, 5 % of the mean of all), shape [points, lights].
    pub weights: Vec<f32>,
}

impl Truth {
    /// Traces, or reads what an earlier run traced.
    pub fn new(
        tracer: &Tracer,
        points: Vec<RowPoint>,
        lights: Vec<Vec3>,
        paths: u32,
        file: &Path,
    ) -> Truth {
        let count = points.len() * lights.len();
        let halves = read(file, count).unwrap_or_else(|| {
            let columns: Vec<_> = (points.iter())
                .flat_map(|p| lights.iter().map(move |l| (p.point, p.viewer, *l)))
                .collect();
            let queries = Queries {
                points: &columns.iter().map(|c| c.0).collect::<Vec<_>>(),
                viewers: &columns.iter().map(|c| c.1).collect::<Vec<_>>(),
                lights: &columns.iter().map(|c| c.2).collect::<Vec<_>>(),
            };
            let stream = Stream::new(3, Stage::Test, 903);
            let found = indirect(tracer, queries, paths, 2, stream, 0).expect("paths");
            let halves = [0, 1].map(|h| (0..count).map(|q| found.halves(q)[h]).collect());
            write(file, &halves);
            halves
        });
        let means = halves[0].iter().zip(&halves[1]);
        let means: Vec<f32> = means.map(|(a, b)| (*a + *b).element_sum() / 6.0).collect();
        let least = 0.05 * means.iter().sum::<f32>() / count as f32;
        Truth {
            points,
            lights,
            halves,
            weights: means.iter().map(|m| 1.0 / m.max(least)).collect(),
        }
    }

    /// Squared relative error of each point and light, the truth's noise taken out; where two
    /// independent predictions are given, theirs too.
    pub fn squares(&self, first: &[Vec3], second: &[Vec3]) -> Vec<f32> {
        (0..self.weights.len())
            .map(|i| {
                let (a, b) = (first[i] - self.halves[0][i], second[i] - self.halves[1][i]);
                (a * b).element_sum() / 3.0 * self.weights[i].powi(2)
            })
            .collect()
    }

    /// Noise of the mean of the two estimates.
    pub fn noise(&self) -> f64 {
        let squares = (0..self.weights.len()).map(|i| {
            let d = (self.halves[0][i] - self.halves[1][i]) * self.weights[i];
            f64::from(d.length_squared()) / 12.0
        });
        (squares.sum::<f64>() / self.weights.len() as f64).sqrt()
    }

    /// One line: the error, the median row, and what the worst rows and points make of it.
    pub fn summary(&self, squares: &[f32]) -> String {
        let lights = self.lights.len();
        let total: f64 = squares.iter().map(|&s| f64::from(s)).sum();
        let error = (total / squares.len() as f64).max(0.0).sqrt();
        let mut sorted = squares.to_vec();
        sorted.sort_by(f32::total_cmp);
        let median = sorted[sorted.len() / 2].max(0.0).sqrt();
        let worst: f64 = sorted
            .iter()
            .rev()
            .take(sorted.len() / 100)
            .map(|&s| f64::from(s))
            .sum();
        let mut by_point: Vec<f64> = squares
            .chunks(lights)
            .map(|c| c.iter().map(|&s| f64::from(s)).sum::<f64>() / lights as f64)
            .collect();
        by_point.sort_by(f64::total_cmp);
        let kept = by_point.len() - by_point.len() / 50;
        let without = (by_point[..kept].iter().sum::<f64>() / kept as f64)
            .max(0.0)
            .sqrt();
        let mean = total / squares.len() as f64;
        let spread = by_point.iter().map(|s| (s - mean).powi(2)).sum::<f64>();
        let points = by_point.len() as f64;
        let deviation = (spread / points / points).sqrt() / (2.0 * error).max(1e-9);
        format!(
            "error {:5.2} % ± {:.2} %, median {:.2} %, worst 1 % of rows {:.0} %, without the worst 2 % of points {:.2} %",
            100.0 * error,
            100.0 * deviation,
            100.0 * median,
            100.0 * worst / total,
            100.0 * without
        )
    }
}

fn read(file: &Path, count: usize) -> Option<[Vec<Vec3>; 2]> {
    let bytes = std::fs::read(file).ok()?;
    let numbers: Vec<f32> = bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    if numbers.len() != 6 * count {
        return None;
    }
    let half = |h: usize| {
        let part = &numbers[3 * count * h..3 * count * (h + 1)];
        part.chunks_exact(3).map(Vec3::from_slice).collect()
    };
    Some([half(0), half(1)])
}

fn write(file: &Path, halves: &[Vec<Vec3>; 2]) {
    let numbers = halves.iter().flatten().flat_map(|v| v.to_array());
    let bytes: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
    std::fs::write(file, bytes).expect("a file that can be written");
}
