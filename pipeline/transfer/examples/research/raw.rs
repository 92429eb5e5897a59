//! TransferRows at the points that are judged: what patches and paths cost.

use crate::clock::cpu;
use crate::setup::one_watt;
use crate::truth::Truth;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{FlatMirrors, PatchConfig, Patches, Receivers, RowConfig, trace_rows};

/// One line for each number of patches and paths.
pub fn run(scene: &Scene, tracer: &Tracer, truth: &Truth, settings: &[(usize, u32, u32, u32)]) {
    for &(count, paths, samples, directions) in settings {
        let config = PatchConfig {
            count,
            directions,
            ..PatchConfig::default()
        };
        let start = cpu();
        let patches = Patches::new(scene, &config, &|_: Vec3| 1.0).expect("patches");
        let cut = cpu();
        let row_config = RowConfig {
            paths,
            ..RowConfig::default()
        };
        let stream = Stream::new(5, Stage::Test, 904);
        let rows = trace_rows(tracer, &patches, &truth.points, &row_config, stream, 0);
        let rows = rows.expect("rows");
        let traced = cpu();
        let used = rows.used();
        let receivers = Receivers::new(tracer, &patches, samples, Some(&used), stream.part(1));
        let mirrors = FlatMirrors::new(tracer);
        let placed = cpu();
        let irradiances: Vec<Vec<Vec3>> = (truth.lights.iter())
            .map(|&l| receivers.irradiance(&mirrors.of(one_watt(l))))
            .collect();
        let lit = cpu();
        let lights = truth.lights.len();
        let own: Vec<Vec<Vec3>> = (truth.lights.iter())
            .map(|&l| mirrors.at_rows(&one_watt(l), &truth.points, 0))
            .collect();
        let mut halves = [Vec::new(), Vec::new()];
        for (row, at) in truth.points.iter().enumerate() {
            let colour = tracer.material_at(&at.point).base_color;
            for (l, irradiance) in irradiances.iter().enumerate() {
                let own = own[l][row];
                for (h, half) in halves.iter_mut().enumerate() {
                    half.push(rows.apply(row, h, irradiance).coloured(colour) + own);
                }
            }
        }
        let mean: Vec<Vec3> = (halves[0].iter().zip(&halves[1]))
            .map(|(a, b)| (*a + *b) * 0.5)
            .collect();
        println!(
            "patches {} ({} columns, {} sides in use), {paths} paths, {samples} points a patch, {directions}^2 directions",
            patches.len(),
            patches.columns(),
            receivers.sides(),
        );
        println!(
            "   rows      {}",
            truth.summary(&truth.squares(&mean, &mean))
        );
        println!(
            "   no noise  {}",
            truth.summary(&truth.squares(&halves[0], &halves[1]))
        );
        println!(
            "   CPU s: patches {:.2}, rows {:.2} ({:.0} entries a half), receivers {:.2}, a light {:.4}",
            cut - start,
            traced - cut,
            rows.columns.len() as f64 / (2 * rows.len()) as f64,
            placed - traced,
            (lit - placed) / lights as f64
        );
    }
}
