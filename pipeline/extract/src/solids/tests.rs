//! Shells of boxes.

use super::*;

fn shells(scene: &Scene) -> Vec<Shell> {
    solids(scene).shell
}

/// The twelve triangles of a box, wound outward.
fn box_triangles(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high } else { low }[axis];
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    let ids = quads.into_iter().flat_map(halves);
    ids.map(|t| t.map(corner)).collect()
}

fn scene(boxes: &[(DVec3, DVec3, bool)]) -> Scene {
    let mut scene = Scene::default();
    for &(low, high, inward) in boxes {
        for mut triangle in box_triangles(low, high) {
            if inward {
                triangle.swap(1, 2);
            }
            let first = scene.positions.len() as u32;
            scene.positions.extend(triangle.map(|p| p.as_vec3()));
            scene.triangles.push([first, first + 1, first + 2]);
        }
    }
    scene
}

/// A box seen from its middle takes up the whole sphere, from outside nothing; a face of a
/// cube a sixth of it.
#[test]
fn solid_angles_sum_to_the_sphere() {
    let cube = box_triangles(DVec3::NEG_ONE, DVec3::ONE);
    let sum = |p: DVec3| cube.iter().map(|&t| solid_angle(t, p)).sum::<f64>();
    assert!((sum(DVec3::ZERO) - 2.0 * TAU).abs() < 1e-12);
    assert!((sum(DVec3::new(0.3, -0.9, 0.5)) - 2.0 * TAU).abs() < 1e-12);
    assert!(sum(DVec3::new(0.0, 3.0, 0.2)).abs() < 1e-12);
    let face: f64 = cube[..2].iter().map(|&t| solid_angle(t, DVec3::ZERO)).sum();
    assert!((face - TAU / 3.0).abs() < 1e-12);
}

/// A sliver that welding makes a line of leaves its cube closed.
#[test]
fn a_line_opens_nothing() {
    for (inward, kind) in [(false, Shell::Outward), (true, Shell::Inward)] {
        let far = (DVec3::splat(9.0), DVec3::splat(10.0), false);
        let mut scene = scene(&[(DVec3::ZERO, DVec3::splat(2.0), inward), far]);
        assert_eq!(shells(&scene)[0], kind);
        // along an edge, its third corner a millionth of a millionth off the first
        let [a, b, _] = scene.triangles[0];
        let beside = scene.positions[a as usize] + glam::Vec3::splat(1e-12);
        scene.positions.push(beside);
        let last = scene.positions.len() as u32 - 1;
        scene.triangles.push([a, b, last]);
        assert_eq!(shells(&scene)[0], kind);
    }
}

/// Two slabs of a room's corner that overlap and share an edge are one component with an edge of
/// four triangles; as objects they are solids.
#[test]
fn objects_that_share_an_edge_are_solids() {
    let slabs = [
        (DVec3::ZERO, DVec3::new(4.0, 3.0, 0.1), false),
        (DVec3::ZERO, DVec3::new(0.1, 3.0, 4.0), false),
    ];
    let mut scene = scene(&slabs);
    assert!(shells(&scene).iter().all(|&shell| shell == Shell::Open));
    scene.triangle_object = (0..24).map(|t| t / 12).collect();
    let found = solids(&scene);
    assert!(found.shell.iter().all(|&shell| shell == Shell::Outward));
    assert_ne!(found.component[0], found.component[12]);
}

/// Of a building's inward shells, the one with a table in it is a room, the empty one a
/// solid with its faces the wrong way round; the table is a solid, either way round.
#[test]
fn a_furnished_shell_is_a_room() {
    let at = |x: f64| DVec3::new(x, 0.0, 0.0);
    let room = (DVec3::ZERO, DVec3::splat(4.0), true);
    let empty = (at(6.0), at(6.0) + DVec3::splat(2.0), true);
    let far = (at(20.0), at(20.0) + DVec3::ONE, false);
    for inward in [false, true] {
        let table = (DVec3::splat(1.0), DVec3::splat(2.0), inward);
        let of = shells(&scene(&[room, table, empty, far]));
        assert_eq!(of[0], Shell::Open);
        let kind = if inward {
            Shell::Inward
        } else {
            Shell::Outward
        };
        assert_eq!(of[12], kind);
        assert_eq!(of[24], Shell::Inward);
        assert_eq!(of[36], Shell::Outward);
    }
}

/// A knob that pokes into a solid with its faces the wrong way round does not make a room of it.
#[test]
fn a_knob_is_no_furniture() {
    let solid = (DVec3::ZERO, DVec3::splat(2.0), true);
    let knob = (DVec3::new(0.9, 0.9, 1.6), DVec3::new(1.1, 1.1, 2.2), false);
    let far = (DVec3::splat(9.0), DVec3::splat(10.0), false);
    assert_eq!(shells(&scene(&[solid, knob, far]))[0], Shell::Inward);
}
