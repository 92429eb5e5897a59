//! A basis keeps what its lights put in and its rows take out.

use crate::scenes::{MIDDLE, cornell, points};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::Tracer;
use rrf_transfer::{
    Basis, CellBasis, Ensemble, PatchConfig, Patches, PointSource, Receivers, RowConfig, trace_rows,
};

const EVEN: fn(Vec3) -> f32 = |_| 1.0;

/// Lights spread over the upper half of the room.
fn lights(count: u64, seed: u64) -> Vec<Vec3> {
    let stream = Stream::new(seed, Stage::Test, 0);
    (0..count)
        .map(|i| {
            let u = stream.units(i, 0, 0);
            Vec3::new(1.4 * u[0] - 0.7, 1.3 + 0.5 * u[1], 1.4 * u[2] - 0.7)
        })
        .collect()
}

/// Relative error of projected rows under lights that the basis has not seen, against the rows
/// themselves: falls with the rank, and a full rank leaves nothing of the ensemble's own lights out.
#[test]
fn projections_approach_the_rows() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let config = PatchConfig {
        count: 1_000,
        ..PatchConfig::default()
    };
    let patches = Patches::new(&scene, &config, &EVEN).unwrap();
    let points = points(&tracer, MIDDLE, 150, 6);
    let stream = Stream::new(9, Stage::Test, 0);
    let config = RowConfig {
        paths: 256,
        ..RowConfig::default()
    };
    let rows = trace_rows(&tracer, &patches, &points, &config, stream, 0).unwrap();
    let colours: Vec<Vec3> = points
        .iter()
        .map(|p| tracer.material_at(&p.point).base_color)
        .collect();
    let used = rows.used();
    let receivers = Receivers::new(&tracer, &patches, 8, Some(&used), stream.part(1));
    let shine = |position: &Vec3| {
        receivers.irradiance(&PointSource {
            position: *position,
            intensity: Vec3::ONE,
        })
    };
    let trained: Vec<_> = lights(100, 1).iter().map(shine).collect();
    let held: Vec<_> = lights(20, 2).iter().map(shine).collect();
    let ensemble = Ensemble::new(&trained);
    let error = |basis: &Basis, lights: &[Vec<Vec3>]| {
        let (mut off, mut all) = (0.0f64, 0.0f64);
        for irradiance in lights {
            let c = basis.coefficients(irradiance).unwrap();
            for (row, &colour) in colours.iter().enumerate() {
                let projected: Vec3 = (basis.project(&rows, row, 0).iter().zip(&c))
                    .map(|(t, c)| t.coloured(colour) * *c)
                    .sum();
                let whole = rows.apply(row, 0, irradiance).coloured(colour);
                off += f64::from((projected - whole).length_squared());
                all += f64::from(whole.length_squared());
            }
        }
        (off / all).sqrt()
    };
    let make = |rank| Basis::new(&rows, &colours, &ensemble, rank, 0.05, stream).unwrap();
    let [few, some, full] = [4, 16, 100].map(make);
    let errors = [&few, &some, &full].map(|b| error(b, &held));
    assert!(
        errors[0] > 1.5 * errors[1] && errors[1] > errors[2],
        "{errors:?}"
    );
    assert!(errors[1] < 0.1 && errors[2] < 0.04, "{errors:?}");
    assert!(few.values.is_sorted_by(|a, b| a >= b));
    // of one half: noise of the other half is in the basis too, so not to rounding
    assert!(error(&full, &trained) < 5e-3, "{}", error(&full, &trained));
    // what it leaves out is told: little of its own kind, most of a light next to the floor
    let usual = held
        .iter()
        .map(|e| some.residual(e).unwrap())
        .fold(0.0, f32::max);
    let strange = some.residual(&shine(&Vec3::new(-0.8, 0.02, 0.8))).unwrap();
    assert!(usual < 0.2 && strange > 3.0 * usual, "{usual} {strange}");
    let dark = vec![Vec3::ZERO; patches.columns()];
    assert_eq!(some.residual(&dark).unwrap(), 0.0);
    assert!(some.coefficients(&dark[1..]).is_err());
    // linear: twice the light, twice the coefficients, channel by channel
    let twice: Vec<Vec3> = held[0]
        .iter()
        .map(|e| *e * Vec3::new(2.0, 1.0, 0.0))
        .collect();
    let (one, two) = (
        some.coefficients(&held[0]).unwrap(),
        some.coefficients(&twice).unwrap(),
    );
    for (one, two) in one.iter().zip(two) {
        assert!((*one * Vec3::new(2.0, 1.0, 0.0) - two).abs().max_element() < 1e-5);
    }
}

/// A cell takes as few directions as its target asks for.
#[test]
fn cells_take_the_directions_that_they_need() {
    let stream = Stream::new(5, Stage::Test, 0);
    let draw = |part: u32, shape: (usize, usize)| {
        let stream = stream.part(part);
        ndarray::Array2::from_shape_fn(shape, |(i, j)| {
            f64::from(stream.units(i as u64, j as u32, 0)[0]) - 0.5
        })
    };
    // rows of rank 5 with falling weight, and noise of their own in each half
    let scale = ndarray::Array1::from_vec(vec![1.0, 0.5, 0.2, 0.05, 0.01]);
    let clean = (&draw(1, (120, 5)) * &scale).dot(&draw(2, (5, 30)));
    let [a, b] = [3, 4].map(|part| &clean + &(draw(part, (120, 30)) * 1e-3));
    let lights = draw(5, (30, 60));
    let rank = |target| {
        let cell = CellBasis::new([&a, &b], &lights, target, 20, stream).unwrap();
        assert!(cell.error <= target && cell.read.len() == 30 * cell.rank);
        cell.rank
    };
    let found = [0.5, 0.1, 0.04, 0.01].map(rank);
    assert!(
        found.is_sorted() && found[0] <= 2 && found[3] <= 5,
        "{found:?}"
    );
    let cell = CellBasis::new([&a, &b], &lights, 0.0, 5, stream).unwrap();
    let light: Vec<Vec3> = lights
        .column(7)
        .iter()
        .map(|&x| Vec3::splat(x as f32))
        .collect();
    let coefficients = cell.coefficients(&light);
    for row in clean.rows() {
        let whole: f64 = row.iter().zip(lights.column(7)).map(|(t, c)| t * c).sum();
        let made: f64 = (0..cell.rank)
            .map(|k| {
                let t: f64 = (0..30)
                    .map(|d| row[d] * f64::from(cell.make[d * cell.rank + k]))
                    .sum();
                t * f64::from(coefficients[k].x)
            })
            .sum();
        assert!((whole - made).abs() < 5e-3, "{whole} {made}");
    }
}
