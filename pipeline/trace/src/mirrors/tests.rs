use super::*;
use glam::Vec2;

fn mirror() -> Mirror {
    Mirror {
        normal: Vec3::Y,
        offset: 0.5,
        axes: [Vec3::X, Vec3::NEG_Z],
        low: Vec2::splat(-1.0),
        high: Vec2::splat(1.0),
        alpha: 0.04,
        reflectance: 0.9,
    }
}

/// The image is where angles of incidence and reflection agree, and the slope's derivative is
/// that of the half vector, by central differences.
#[test]
fn images_are_mirror_points_with_the_half_vectors_slope() {
    let mirror = mirror();
    for (x, l) in [
        (Vec3::new(0.3, 1.5, -0.2), Vec3::new(-0.5, 0.9, 0.4)),
        (Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.2, 0.3, -0.4)),
        (Vec3::new(0.1, 1.2, 0.3), Vec3::new(0.1, 0.8, 0.3)),
    ] {
        let image = mirror.image(x, Shown::point(l));
        let slope = |y: Vec2| {
            let y = mirror.at(y).as_dvec3();
            let (dx, dl) = (x.as_dvec3() - y, l.as_dvec3() - y);
            let h = dx / dx.length() + dl / dl.length();
            let h = h / h.y.abs();
            glam::DVec2::new(
                mirror.axes[0].as_dvec3().dot(h),
                mirror.axes[1].as_dvec3().dot(h),
            )
        };
        assert!(slope(image.center).length() < 1e-5);
        for (axis, expected) in [
            (image.along, image.slopes.x),
            (image.along.perp(), image.slopes.y),
        ] {
            let step = 1e-3 * axis;
            let change = slope(image.center + step) - slope(image.center - step);
            let found = -change.dot(axis.as_dvec2()) / 2e-3;
            let error = found / f64::from(expected) - 1.0;
            assert!(error.abs() < 1e-3, "{found} for {expected}");
        }
    }
    let frames = Frames::new(&[mirror]);
    let shown = |x, l| sum(&weights(&frames, x, Shown::point(l)));
    let above = Vec3::new(0.2, 1.0, 0.0);
    assert_eq!(shown(above, Vec3::ZERO), 0.0, "on different sides");
    assert_eq!(
        shown(above, Vec3::new(2.5, 0.9, 0.0)),
        0.0,
        "image beside the mirror"
    );
    assert!(shown(above, Vec3::new(-0.3, 0.8, 0.1)) > 0.0);
}

/// Points are as dense as `density` says: chi-square over a grid of 6 x 6 and the outside; the
/// 99.9999 % point for 36 degrees of freedom is 92.9.
#[test]
fn points_have_their_density() {
    let mirrors = Mirrors {
        frames: Frames::new(&[mirror()]),
        mirrors: vec![mirror()],
        of_triangle: vec![0],
        ..Mirrors::default()
    };
    let x = Vec3::new(0.3, 1.5, -0.2);
    let l = Shown::point(Vec3::new(-0.5, 0.9, 0.4));
    let image = mirrors.mirrors[0].image(x, l);
    let (count, cells, half) = (200_000u64, 6, 0.09f32);
    let width = 2.0 * half / cells as f32;
    let cell = |y: Vec2| {
        let at = (y - image.center + half) / width;
        let inside = at.min_element() >= 0.0 && at.max_element() < cells as f32;
        inside.then(|| at.y as usize * cells + at.x as usize)
    };
    let mut found = vec![0.0; cells * cells + 1];
    for i in 0..count {
        let u = rrf_sampling::Stream::new(5, rrf_sampling::Stage::Test, 0).units(i, 0, 0);
        let proposal = mirrors.propose(x, l, [u[0], u[1], u[2]]).unwrap();
        assert!((proposal.position.y - 0.5).abs() < 1e-6);
        let y = mirrors.mirrors[0].coordinates(proposal.position);
        found[cell(y).unwrap_or(cells * cells)] += 1.0;
    }
    let fine = 40;
    let mut expected = vec![0.0; cells * cells + 1];
    for iy in 0..cells * fine {
        for ix in 0..cells * fine {
            let offset = Vec2::new(ix as f32 + 0.5, iy as f32 + 0.5) * (width / fine as f32);
            let y = image.center - half + offset;
            let density = mirrors.density(0, x, l, mirrors.mirrors[0].at(y));
            let area = f64::from(width / fine as f32).powi(2);
            expected[(iy / fine) * cells + ix / fine] += f64::from(density) * area * count as f64;
        }
    }
    expected[cells * cells] = count as f64 - expected.iter().sum::<f64>();
    let square = |(f, e): (&f64, &f64)| (f - e).powi(2) / e;
    let chi2: f64 = found.iter().zip(&expected).map(square).sum();
    assert!(chi2 < 92.9, "{chi2}");
}

/// Light from afar is a point that is far away.
#[test]
fn directions_are_points_far_away() {
    let mirror = mirror();
    let x = Vec3::new(0.3, 1.5, -0.2);
    let toward = Vec3::new(-0.3, 0.6, 0.4).normalize();
    let far = mirror.image(x, Shown::far_end(toward));
    let near = mirror.image(x, Shown::point(x + toward * 1e5));
    assert!((far.center - near.center).length() < 1e-4);
    assert!((far.along - near.along).length() < 1e-4);
    assert!((far.slopes / near.slopes - 1.0).abs().max_element() < 1e-4);
    let frames = Frames::new(&[mirror]);
    assert!(sum(&weights(&frames, x, Shown::far_end(toward))) > 0.0);
    let below = Shown::far_end(-toward);
    assert_eq!(sum(&weights(&frames, x, below)), 0.0);
}

fn ball_in_mirrors() -> Mirrors {
    Mirrors {
        balls: vec![Ball::new(Vec3::new(0.2, 0.5, -0.1), 0.3, 0.02, 0.9)],
        ..Mirrors::default()
    }
}

/// On a ball angles of incidence and reflection agree, the slope's derivative is that of the half vector
/// against the normal, and the weight is the light's density there: all against rays.
#[test]
fn balls_show_lights_where_they_reflect_them() {
    let mirrors = ball_in_mirrors();
    let ball = &mirrors.balls[0];
    let center = Vec3::new(0.2, 0.5, -0.1).as_dvec3();
    let x = Vec3::new(0.9, 1.4, 0.8);
    for l in [
        Shown::point(Vec3::new(-0.4, 1.1, 0.9)),
        Shown::point(x + Vec3::splat(0.01)),
        Shown::far_end(Vec3::new(0.3, 0.9, -0.2).normalize()),
    ] {
        let image = ball.image(x, l).unwrap();
        let slope = |y: glam::DVec3| {
            let n = (y - center).normalize();
            let to_l = l.at.as_dvec3() - y * f64::from(l.w);
            let h = (x.as_dvec3() - y).normalize() + to_l.normalize();
            h / h.dot(n) - n
        };
        let y0 = image.center.as_dvec3();
        assert!(((y0 - center).length() - 0.3).abs() < 1e-5);
        assert!(slope(y0).length() < 1e-3, "{}", slope(y0).length());
        for (axis, expected) in image.axes.iter().zip(image.slopes.to_array()) {
            let step = 1e-4 * axis.as_dvec3();
            let on = |p: glam::DVec3| center + (p - center).normalize() * 0.3;
            let change = slope(on(y0 + step)) - slope(on(y0 - step));
            let found = -change.dot(axis.as_dvec3()) / 2e-4;
            let error = found / f64::from(expected) - 1.0;
            assert!(error.abs() < 2e-3, "{found} for {expected}");
        }
    }
    assert!(
        ball.image(Vec3::new(0.2, 0.5, -0.1), Shown::point(x))
            .is_none()
    );
    let behind = Shown::point(Vec3::new(-0.5, -0.5, -1.0));
    assert!(ball.image(x, behind).is_none(), "hidden by the ball");
}

/// Points about a ball's image have their density with respect to angle: chi-square as for flat ones,
/// over the tangent plane.
#[test]
fn points_on_balls_have_their_density() {
    let mirrors = ball_in_mirrors();
    let (x, l) = (
        Vec3::new(0.9, 1.4, 0.8),
        Shown::point(Vec3::new(-0.4, 1.1, 0.9)),
    );
    let image = mirrors.balls[0].image(x, l).unwrap();
    let (count, cells, half) = (200_000u64, 6usize, 0.01f32);
    let width = 2.0 * half / cells as f32;
    let cell = |y: Vec3| {
        let at = Vec2::new(
            (y - image.center).dot(image.axes[0]),
            (y - image.center).dot(image.axes[1]),
        );
        let at = (at + half) / width;
        let inside = at.min_element() >= 0.0 && at.max_element() < cells as f32;
        inside.then(|| at.y as usize * cells + at.x as usize)
    };
    let mut found = vec![0.0; cells * cells + 1];
    for i in 0..count {
        let u = rrf_sampling::Stream::new(6, rrf_sampling::Stage::Test, 0).units(i, 0, 0);
        let proposal = mirrors.propose_any(x, l, [u[0], u[1], u[2]]).unwrap();
        found[cell(proposal.position).unwrap_or(cells * cells)] += 1.0;
    }
    let fine = 20;
    let mut expected = vec![0.0; cells * cells + 1];
    let step = width / fine as f32;
    for iy in 0..cells * fine {
        for ix in 0..cells * fine {
            let at = Vec2::new(ix as f32 + 0.5, iy as f32 + 0.5) * step - half;
            let y = image.center + image.axes[0] * at.x + image.axes[1] * at.y;
            let density = mirrors.density_any(MOST as u8, x, l, (y, image.normal));
            let share = f64::from(density) * f64::from(step).powi(2) * count as f64;
            expected[(iy / fine) * cells + ix / fine] += share;
        }
    }
    expected[cells * cells] = count as f64 - expected.iter().sum::<f64>();
    let square = |(f, e): (&f64, &f64)| (f - e).powi(2) / e;
    let chi2: f64 = found.iter().zip(&expected).map(square).sum();
    assert!(chi2 < 92.9, "{chi2}");
}

/// A ray that goes on to a surface off the plane takes its solid angle with it.
#[test]
fn densities_follow_their_rays() {
    let mirrors = Mirrors {
        frames: Frames::new(&[mirror()]),
        mirrors: vec![mirror()],
        of_triangle: vec![0],
        ..Mirrors::default()
    };
    let x = Vec3::new(0.3, 1.5, -0.2);
    let l = Shown::point(Vec3::new(-0.5, 0.9, 0.4));
    let y = mirrors.propose(x, l, [0.5, 0.4, 0.7]).unwrap().position;
    let solid_angle = |y: Vec3| mirrors.density(0, x, l, y) * (y - x).length_squared();
    for t in [0.9, 0.999, 1.1] {
        let off = x + (y - x) * t;
        let error = solid_angle(off) / solid_angle(y) - 1.0;
        assert!(error.abs() < 1e-4, "{t}: {error}");
    }
}

/// In the glossy room the metals are mirrors, a plane each; the floor's lobe (0.04 / (4 π 0.25⁴) a
/// steradian) is too weak, and so are all the others. Its file has f32 corner normals that are the
/// planes' to rounding.
#[test]
fn flat_metals_are_found() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../scenes/cornell-glossy/cornell-glossy.glb");
    let scene = rrf_scene::load(&path, &rrf_scene::LoadOptions::default()).unwrap();
    let tracer = crate::Tracer::new(&scene).unwrap();
    for (id, &material) in scene.triangle_material.iter().enumerate() {
        let metal = scene.materials[material as usize].metallic == 1.0;
        let mirror = tracer.mirrors.of(id as u32);
        assert_eq!(mirror != NO_MIRROR, metal, "triangle {id}");
        for other in 0..id {
            let same = tracer.mirrors.of(other as u32) == mirror && metal;
            let [a, b] = [id, other].map(|id| tracer.facets[id]);
            let coplanar = (a.normal.dot(b.corner - a.corner)).abs() < 1e-5
                && a.normal.cross(b.normal).length() < 1e-5;
            assert!(!same || coplanar, "triangles {id} and {other}");
        }
    }
    assert_eq!(
        tracer.mirrors.mirrors.len(),
        7,
        "a wall and the six faces of a box"
    );
}
