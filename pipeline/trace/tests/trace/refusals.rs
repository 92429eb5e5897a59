//! What cannot be traced is refused with its place.

use crate::scenes::{Builder, lambert};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Queries, Rays, TraceError, Tracer, indirect};

fn scene() -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    builder.quad(Vec3::ZERO, Vec3::X, Vec3::Y, material, INVALID);
    builder.scene
}

fn refused(change: impl FnOnce(&mut Scene)) -> TraceError {
    let mut scene = scene();
    change(&mut scene);
    let Err(error) = Tracer::new(&scene) else {
        panic!("accepted");
    };
    error
}

#[test]
fn broken_scenes() {
    assert!(Tracer::new(&scene()).is_ok());
    assert_eq!(refused(|s| *s = Scene::default()), TraceError::NoTriangles);
    assert_eq!(
        refused(|s| s.triangles = vec![[0, 0, 1], [2, 2, 2]]),
        TraceError::NoTriangles
    );
    let error = refused(|s| s.positions[2].y = f32::NAN);
    assert_eq!(error, TraceError::NotFinite { vertex: 2 });
    let error = refused(|s| s.positions[3].x = f32::INFINITY);
    assert_eq!(error, TraceError::NotFinite { vertex: 3 });
    let column = |error: TraceError| match error {
        TraceError::Id {
            column, triangle, ..
        } => (column, triangle),
        other => panic!("{other}"),
    };
    assert_eq!(column(refused(|s| s.triangles[1][2] = 9)), ("vertex", 1));
    assert_eq!(
        column(refused(|s| s.triangle_material[0] = 7)),
        ("material", 0)
    );
    assert_eq!(
        column(refused(|s| s.triangle_light[1] = 0)),
        ("area light", 1)
    );
    let error = refused(|s| s.materials[0].normal_texture = 3);
    assert!(
        matches!(
            error,
            TraceError::TextureId {
                id: 3,
                count: 0,
                ..
            }
        ),
        "{error}"
    );
    for change in [
        (|s: &mut Scene| s.normals.truncate(1)) as fn(&mut Scene),
        |s| s.uvs.truncate(1),
        |s| s.triangle_material.truncate(1),
        |s| s.triangle_light.truncate(1),
    ] {
        assert!(matches!(refused(change), TraceError::Length { .. }));
    }
}

#[test]
fn broken_questions() {
    let scene = scene();
    let tracer = Tracer::new(&scene).unwrap();
    let point = tracer.point(0, [0.2, 0.2]);
    let queries = Queries {
        points: &[point],
        viewers: &[Vec3::Z],
        lights: &[],
    };
    let stream = Stream::new(1, Stage::Test, 0);
    let error = indirect(&tracer, queries, 2, 2, stream, 0).unwrap_err();
    assert!(
        matches!(
            error,
            TraceError::Queries {
                column: "lights",
                ..
            }
        ),
        "{error}"
    );
    let queries = Queries {
        lights: &[Vec3::Z],
        ..queries
    };
    for (paths, replicates) in [(0, 2), (3, 2), (2, 0), (1, 2)] {
        let error = indirect(&tracer, queries, paths, replicates, stream, 0).unwrap_err();
        assert_eq!(error, TraceError::Paths { paths, replicates });
    }
}

/// Numbers that mean nothing give some answer and no panic.
#[test]
fn senseless_numbers() {
    let scene = scene();
    let tracer = Tracer::new(&scene).unwrap();
    let (mut hits, mut blocked, mut rays) = Default::default();
    for bad in [
        Vec3::splat(f32::NAN),
        Vec3::splat(f32::INFINITY),
        Vec3::ZERO,
        Vec3::splat(1e38),
    ] {
        rays = Rays::default();
        rays.push(bad, Vec3::Z, f32::INFINITY);
        rays.push(Vec3::NEG_Z, bad, f32::INFINITY);
        rays.push(Vec3::NEG_Z, Vec3::Z, f32::NAN);
        tracer.closest(&rays, &mut hits);
        tracer.occluded(&rays, &mut blocked);
        let point = tracer.point(0, [0.2, 0.2]);
        let queries = Queries {
            points: &[point, point],
            viewers: &[bad, Vec3::Z],
            lights: &[Vec3::Z, bad],
        };
        assert!(indirect(&tracer, queries, 8, 2, Stream::new(1, Stage::Test, 0), 0).is_ok());
    }
    assert_eq!(rays.len(), 3);
    // A light on the surface, at the very point.
    let point = tracer.point(0, [0.2, 0.2]);
    let queries = Queries {
        points: &[point],
        viewers: &[Vec3::Z],
        lights: &[point.position],
    };
    let found = indirect(&tracer, queries, 64, 2, Stream::new(1, Stage::Test, 0), 0).unwrap();
    assert!(found.mean(0).is_finite());
}
