//! Rays against all triangles one by one, in f64.

use crate::scenes::{Builder, cornell, lambert};
use glam::{DVec3, Vec3};
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, Tracer};

/// What all triangles say about one ray.
#[derive(Default)]
struct Truth {
    /// Distances and ids of the triangles that are hit well inside, nearest first.
    clear: Vec<(f64, u32)>,
    /// Whether the ray passes so near to an edge of some triangle that rounding decides.
    doubtful: bool,
}

/// Moeller and Trumbore in f64. `margin` is the distance from an edge, relative to the triangle,
/// within which rounding of f32 coordinates decides.
fn brute_force(scene: &Scene, origin: DVec3, direction: DVec3, margin: f64) -> Truth {
    let mut truth = Truth::default();
    for (id, triangle) in scene.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| scene.positions[v as usize].as_dvec3());
        let (e1, e2, to) = (b - a, c - a, origin - a);
        let p = direction.cross(e2);
        let det = e1.dot(p);
        if e1.cross(e2) == DVec3::ZERO {
            continue;
        }
        let scale = e1.length() * e2.length() * direction.length();
        if det.abs() <= 1e-5 * scale {
            // Seen from the side: in or out is a matter of rounding.
            let normal = e1.cross(e2).normalize_or_zero();
            truth.doubtful |= normal.dot(to).abs() <= 1e-3 * (e1.length() + e2.length());
            continue;
        }
        let u = to.dot(p) / det;
        let q = to.cross(e1);
        let v = direction.dot(q) / det;
        let t = e2.dot(q) / det;
        let inside = u.min(v).min(1.0 - u - v);
        if t.abs() < margin * e1.length() && inside > -margin {
            truth.doubtful = true;
        } else if t > 0.0 && inside > margin {
            truth.clear.push((t, id as u32));
        } else if t > 0.0 && inside > -margin {
            truth.doubtful = true;
        }
    }
    truth.clear.sort_by(|a, b| a.0.total_cmp(&b.0));
    truth
}

/// Triangles of mixed sizes in a cube of edge 2 about `centre`, times `scale`.
fn soup(count: u64, centre: Vec3, scale: f32) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    let stream = Stream::new(21, Stage::Test, count as u32);
    for i in 0..count {
        let u: Vec<f32> = (0..4).flat_map(|b| stream.units(i, 0, b)).collect();
        let at = Vec3::new(u[0], u[1], u[2]) * 2.0 - 1.0;
        let size = 0.05 + 0.6 * u[12] * u[12];
        let corner =
            |k: usize| centre + (at + (Vec3::from_slice(&u[k..k + 3]) - 0.5) * size) * scale;
        builder.mesh(
            &[corner(3), corner(6), corner(9)],
            &[[0, 1, 2]],
            material,
            INVALID,
        );
    }
    builder.scene
}

/// Rays from the cube's surroundings into it, and from inside it.
fn rays(count: u64, centre: Vec3, scale: f32) -> Rays {
    let stream = Stream::new(22, Stage::Test, 0);
    let mut rays = Rays::default();
    for i in 0..count {
        let (a, b) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
        let reach = if i % 2 == 0 { 4.0 } else { 1.0 };
        let from = (Vec3::new(a[0], a[1], a[2]) * 2.0 - 1.0) * reach;
        let to = Vec3::new(b[0], b[1], b[2]) * 2.0 - 1.0;
        let direction = (to - from).normalize();
        rays.push(centre + from * scale, direction, f32::INFINITY);
    }
    rays
}

fn assert_agrees(name: &str, scene: &Scene, rays: &Rays, margin: f64) {
    let tracer = Tracer::new(scene).unwrap();
    let (mut hits, mut blocked) = (Hits::default(), Vec::new());
    tracer.closest(rays, &mut hits);
    tracer.occluded(rays, &mut blocked);
    let mut decided = 0;
    assert_eq!(blocked.len(), rays.len(), "{name}");
    for (i, &blocked) in blocked.iter().enumerate() {
        let (o, d) = (rays.origin[i].as_dvec3(), rays.direction[i].as_dvec3());
        let truth = brute_force(scene, o, d, margin);
        assert_eq!(hits.triangle[i] != INVALID, blocked, "{name}: ray {i}");
        if truth.doubtful {
            continue;
        }
        decided += 1;
        let Some(&(t, _)) = truth.clear.first() else {
            assert_eq!(hits.triangle[i], INVALID, "{name}: ray {i} hits nothing");
            continue;
        };
        // Rounding of a plane's distance, relative to the coordinates that take part.
        let size = rays.origin[i].abs().max_element() + t as f32;
        let slack = f64::from(size) * 1e-5;
        assert!(
            (f64::from(hits.t[i]) - t).abs() <= slack,
            "{name}: ray {i}: {} {t}",
            hits.t[i]
        );
        let near = truth
            .clear
            .iter()
            .take_while(|(other, _)| other - t <= 2.0 * slack);
        let ids: Vec<u32> = near.map(|&(_, id)| id).collect();
        assert!(ids.contains(&hits.triangle[i]), "{name}: ray {i}: {ids:?}");
    }
    assert!(
        decided * 10 >= rays.len() * 7,
        "{name}: only {decided} rays decide"
    );
}

#[test]
fn rays_meet_what_brute_force_meets() {
    for count in [1, 2, 7, 8, 9, 65, 1_000] {
        let scene = soup(count, Vec3::ZERO, 1.0);
        assert_agrees(
            &format!("{count}"),
            &scene,
            &rays(4_000, Vec3::ZERO, 1.0),
            1e-4,
        );
    }
}

#[test]
fn huge_tiny_and_far_scenes() {
    for (name, centre, scale, margin) in [
        ("huge", Vec3::ZERO, 1e6, 1e-4),
        ("tiny", Vec3::ZERO, 1e-6, 1e-4),
        // Coordinates of 1,000 are rounded to 6e-5; the smallest triangles measure 0.02.
        ("far", Vec3::new(1_000.0, -500.0, 300.0), 1.0, 0.02),
    ] {
        let scene = soup(200, centre, scale);
        assert_agrees(name, &scene, &rays(4_000, centre, scale), margin);
    }
}

#[test]
fn coincident_and_degenerate_triangles() {
    let mut scene = soup(50, Vec3::ZERO, 1.0);
    let (triangles, materials) = (scene.triangles.clone(), scene.triangle_material.clone());
    for _ in 0..20 {
        scene.triangles.extend(&triangles);
        scene.triangle_material.extend(&materials);
    }
    // Points, needles and slivers without an area.
    for i in 0..40u32 {
        scene.triangles.push([i, i, i]);
        scene.triangles.push([i, i + 1, i + 1]);
        scene.triangle_material.extend([0, 0]);
    }
    scene.triangle_light = vec![INVALID; scene.triangles.len()];
    scene.triangle_object = vec![0; scene.triangles.len()];
    assert_agrees("coincident", &scene, &rays(4_000, Vec3::ZERO, 1.0), 1e-4);
}

#[test]
fn axis_parallel_rays_meet_axis_parallel_walls() {
    let scene = cornell();
    let tracer = Tracer::new(&scene).unwrap();
    let mut rays = Rays::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for sign in [1.0, -1.0] {
            for zero in [0.0, -0.0] {
                let direction = (axis * sign)
                    .to_array()
                    .map(|c| if c == 0.0 { zero } else { c });
                rays.push(Vec3::new(0.6, 1.6, 0.3), direction.into(), f32::INFINITY);
            }
        }
    }
    let mut hits = Hits::default();
    tracer.closest(&rays, &mut hits);
    let expected = [0.4, 1.6, 0.4, 1.0, f32::INFINITY, 1.3];
    for (i, t) in hits.t.iter().enumerate() {
        let truth = expected[i / 2];
        assert!(
            *t == truth || (t - truth).abs() < 1e-6,
            "ray {i}: {t} for {truth}"
        );
    }
}

/// Rays from inside a closed mesh straight at its edges: neighbours decide by the same
/// numbers, so none slips through.
#[test]
fn closed_meshes_are_tight() {
    let mut builder = Builder::default();
    let material = builder.material(lambert(Vec3::ONE));
    builder.sphere(Vec3::new(0.3, -0.2, 0.1), 1.0, 24, material, INVALID);
    let scene = builder.scene;
    let tracer = Tracer::new(&scene).unwrap();
    let stream = Stream::new(23, Stage::Test, 0);
    let mut rays = Rays::default();
    for i in 0..100_000u64 {
        let u = stream.units(i, 0, 0);
        let triangle = scene.triangles[(u[0] * scene.triangles.len() as f32) as usize];
        let [a, b, _] = triangle.map(|v| scene.positions[v as usize]);
        let target = a.lerp(b, 0.01 + 0.98 * u[1]);
        let w = stream.units(i, 0, 1);
        let origin = Vec3::new(0.3, -0.2, 0.1) + (Vec3::new(w[0], w[1], w[2]) - 0.5) * 0.9;
        rays.push(origin, target - origin, f32::INFINITY);
    }
    let mut hits = Hits::default();
    tracer.closest(&rays, &mut hits);
    let escaped = hits.triangle.iter().filter(|&&t| t == INVALID).count();
    assert_eq!(escaped, 0, "of {} rays at edges", rays.len());
}

/// Rays that leave a convex surface outwards meet nothing, inwards meet another triangle, at
/// every size and place: the lift off the triangle is enough and not too much.
#[test]
fn rays_do_not_meet_where_they_start() {
    let places = [Vec3::ZERO, Vec3::new(50.0, -80.0, 20.0)];
    for (size, place) in [1e-3, 1.0, 1e3, 1e6]
        .iter()
        .flat_map(|&s| places.map(|p| (s, p)))
    {
        let mut builder = Builder::default();
        let material = builder.material(lambert(Vec3::ONE));
        let centre = place * size;
        builder.sphere(centre, size, 16, material, INVALID);
        builder.cuboid(
            centre - 3.0 * size,
            centre + 3.0 * size,
            false,
            material,
            INVALID,
        );
        let scene = builder.scene;
        let box_from = scene.triangles.len() as u32 - 12;
        let tracer = Tracer::new(&scene).unwrap();
        let (mut rays, mut starts) = (Rays::default(), Vec::new());
        let stream = Stream::new(24, Stage::Test, 0);
        for i in 0..40_000u64 {
            let (u, w) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
            let point = tracer.sample_area([u[0], u[1], u[2]]);
            let aside = (Vec3::new(w[0], w[1], w[2]) - 0.5).normalize();
            // Grazing as often as not.
            let steep = if i % 2 == 0 { 0.01 } else { 1.0 };
            let tangent = aside.reject_from_normalized(point.normal).normalize();
            let side = if w[3] < 0.5 { 1.0 } else { -1.0 };
            let direction = (tangent + point.normal * (side * steep)).normalize();
            rays.push(
                tracer.lift(point.triangle, point.position, direction),
                direction,
                f32::INFINITY,
            );
            starts.push((point.triangle, side));
        }
        let mut hits = Hits::default();
        tracer.closest(&rays, &mut hits);
        for (i, &(start, side)) in starts.iter().enumerate() {
            let met = hits.triangle[i];
            assert_ne!(
                met, start,
                "size {size} at {place}: ray {i} meets its own triangle"
            );
            let on_box = start >= box_from;
            if on_box && side > 0.0 {
                assert_eq!(
                    met, INVALID,
                    "size {size} at {place}: ray {i} leaves the box"
                );
            } else if !on_box && side > 0.0 {
                assert!(
                    met >= box_from,
                    "size {size} at {place}: ray {i} leaves the sphere"
                );
            } else {
                assert_ne!(met, INVALID, "size {size} at {place}: ray {i} stays inside");
            }
        }
    }
}
