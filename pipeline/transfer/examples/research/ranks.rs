//! What a basis leaves out at the judged points, by its rank.

use crate::setup::{Places, one_watt};
use crate::truth::Truth;
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::Tracer;
use rrf_transfer::{
    Basis, Ensemble, FlatMirrors, PatchConfig, Patches, Receivers, RowConfig, trace_rows,
};

/// One line for each rank, the rows being traced at the judged points themselves.
pub fn run(
    tracer: &Tracer,
    places: &Places,
    truth: &Truth,
    patches: usize,
    lights: usize,
    rows: usize,
) {
    let config = PatchConfig {
        count: patches,
        ..PatchConfig::default()
    };
    let patches = Patches::new(tracer.scene(), &config, &|_: Vec3| 1.0).expect("patches");
    let stream = Stream::new(5, Stage::Test, 904);
    let few = places.candidates(rows, 2);
    let config = |paths| RowConfig {
        paths,
        ..RowConfig::default()
    };
    let trace = |points: &[_], paths, part| {
        trace_rows(
            tracer,
            &patches,
            points,
            &config(paths),
            stream.part(part),
            0,
        )
        .expect("rows")
    };
    let few_rows = trace(&few, 256, 1);
    let rows = trace(&truth.points, 4_096, 2);
    let mut used = few_rows.used();
    used.iter_mut()
        .zip(rows.used())
        .for_each(|(u, more)| *u |= more);
    let receivers = Receivers::new(tracer, &patches, 8, Some(&used), stream.part(3));
    let mirrors = FlatMirrors::new(tracer);
    let shine = |l: &Vec3| receivers.irradiance(&mirrors.of(one_watt(*l)));
    let ensemble = Ensemble::new(
        &places
            .lights(lights, 77)
            .iter()
            .map(shine)
            .collect::<Vec<_>>(),
    );
    let colour = |p: &rrf_transfer::RowPoint| tracer.material_at(&p.point).base_color;
    let colours: Vec<Vec3> = few.iter().map(colour).collect();
    let most = lights / 2;
    let basis =
        Basis::new(&few_rows, &colours, &ensemble, most, 0.05, stream.part(4)).expect("basis");
    let shone: Vec<Vec<Vec3>> = truth.lights.iter().map(shine).collect();
    let count = truth.lights.len();
    let own = crate::model::own_light(&mirrors, truth);
    let mut halves = [own.clone(), own.clone()];
    for (p, point) in truth.points.iter().enumerate() {
        for (l, e) in shone.iter().enumerate() {
            for h in 0..2 {
                halves[h][p * count + l] += rows.apply(p, h, e).coloured(colour(point));
            }
        }
    }
    println!(
        "all columns {}",
        truth.summary(&truth.squares(&halves[0], &halves[1]))
    );
    let coefficients: Vec<_> = shone
        .iter()
        .map(|e| basis.coefficients(e).expect("columns"))
        .collect();
    let mut rank = 16;
    while rank <= basis.rank {
        let mut halves = [own.clone(), own.clone()];
        for (p, point) in truth.points.iter().enumerate() {
            for h in 0..2 {
                let made = basis.project(&rows, p, h);
                for (l, c) in coefficients.iter().enumerate() {
                    let sum: Vec3 = (0..rank)
                        .map(|k| made[k].coloured(colour(point)) * c[k])
                        .sum();
                    halves[h][p * count + l] += sum;
                }
            }
        }
        println!(
            "rank {rank:4} {}",
            truth.summary(&truth.squares(&halves[0], &halves[1]))
        );
        rank *= 2;
    }
}
