//! Quadrics as triangles: surfaces of revolution around z.
//!
//! Vertices lie on the surface, so that area and volume are below the smooth ones: by 0.2 %
//! for a sphere's area. Under a mirroring transform a quadric's outside stays outside, as
//! pbrt samples its lights (its intersections turn the normal there).

use super::mesh::Local;
use glam::{DVec2, DVec3};

/// Steps around a full or partial turn, and along a meridian of a sphere or paraboloid.
pub(super) const AROUND: u32 = 64;
pub(super) const ALONG: u32 = 32;

/// A point of the profile, in the half plane (r, z), with the normal there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    pub r: f64,
    pub z: f64,
    pub normal_r: f64,
    pub normal_z: f64,
}

/// A sphere's profile from the height `zmin` to `zmax`, both within the radius.
pub(super) fn sphere(radius: f64, zmin: f64, zmax: f64) -> Vec<Profile> {
    let angle = |z: f64| (z / radius).clamp(-1.0, 1.0).acos();
    let (low, high) = (angle(zmin), angle(zmax));
    (0..=ALONG)
        .map(|j| {
            let t = f64::from(j) / f64::from(ALONG);
            let theta = low + (high - low) * t;
            let pole = theta == 0.0 || theta == std::f64::consts::PI;
            let (normal_r, normal_z) = (if pole { 0.0 } else { theta.sin() }, theta.cos());
            Profile {
                r: radius * normal_r,
                z: radius * normal_z,
                normal_r,
                normal_z,
            }
        })
        .collect()
}

/// A cylinder's profile.
pub(super) fn cylinder(radius: f64, zmin: f64, zmax: f64) -> Vec<Profile> {
    [zmin, zmax]
        .map(|z| Profile {
            r: radius,
            z,
            normal_r: 1.0,
            normal_z: 0.0,
        })
        .to_vec()
}

/// A disk's profile, from its rim inwards; its normal is +z.
pub(super) fn disk(radius: f64, inner: f64, z: f64) -> Vec<Profile> {
    [radius, inner]
        .map(|r| Profile {
            r,
            z,
            normal_r: 0.0,
            normal_z: 1.0,
        })
        .to_vec()
}

/// A cone's profile from its base at z = 0 to its tip.
pub(super) fn cone(radius: f64, height: f64) -> Vec<Profile> {
    let slant = radius.hypot(height);
    let (normal_r, normal_z) = (height / slant, radius / slant);
    [(radius, 0.0), (0.0, height)]
        .map(|(r, z)| Profile {
            r,
            z,
            normal_r,
            normal_z,
        })
        .to_vec()
}

/// A paraboloid's profile z = zmax (r / radius)^2 from `zmin`; its normal points outwards,
/// away from the axis.
pub(super) fn paraboloid(radius: f64, zmin: f64, zmax: f64) -> Vec<Profile> {
    (0..=ALONG)
        .map(|j| {
            // Even steps in r, since z grows as its square.
            let t = f64::from(j) / f64::from(ALONG);
            let low = (zmin / zmax).max(0.0).sqrt();
            let r = radius * (low + (1.0 - low) * t);
            let z = zmax * (r / radius).powi(2);
            let n = DVec2::new(2.0 * zmax * r / (radius * radius), -1.0).normalize();
            Profile {
                r,
                z,
                normal_r: n.x,
                normal_z: n.y,
            }
        })
        .collect()
}

/// Turns a profile by `turn` radians around z. u grows with the angle and v along the
/// profile; triangles are wound so that their normal is dp/du x dp/dv, as pbrt's.
pub(super) fn revolve(profile: &[Profile], turn: f64) -> Local {
    let full = turn >= std::f64::consts::TAU;
    let rows = profile.len().saturating_sub(1).max(1) as f64;
    let mut local = Local {
        reverse_normals: true,
        ..Local::default()
    };
    for (j, point) in profile.iter().enumerate() {
        for i in 0..=AROUND {
            let u = f64::from(i) / f64::from(AROUND);
            // The seam's two sides coincide exactly.
            let angle = if full && i == AROUND { 0.0 } else { u * turn };
            let (sin, cos) = angle.sin_cos();
            local
                .positions
                .push(DVec3::new(point.r * cos, point.r * sin, point.z));
            local.normals.push(DVec3::new(
                point.normal_r * cos,
                point.normal_r * sin,
                point.normal_z,
            ));
            local.uvs.push(DVec2::new(u, j as f64 / rows));
        }
    }
    for (j, pair) in profile.windows(2).enumerate() {
        for i in 0..AROUND {
            let a = j as u32 * (AROUND + 1) + i;
            let (b, d) = (a + 1, a + AROUND + 1);
            let c = d + 1;
            // A row on the axis is a point: its triangles have no area.
            if pair.first().is_some_and(|point| point.r > 0.0) {
                local.triangles.push([a, b, c]);
            }
            if pair.last().is_some_and(|point| point.r > 0.0) {
                local.triangles.push([a, c, d]);
            }
        }
    }
    local
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn area(mesh: &Local) -> f64 {
        corners(mesh)
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum()
    }

    /// Signed volume by the divergence theorem: positive where normals point outwards.
    fn volume(mesh: &Local) -> f64 {
        corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    fn corners(mesh: &Local) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        mesh.triangles
            .iter()
            .map(|t| t.map(|i| mesh.positions[i as usize]))
    }

    /// The solid is a stack of frusta of regular 64-gons: with A = (n/2) r^2 sin(2 pi/n) for
    /// the n-gon of circumradius r, a frustum has the volume h/3 (A1 + A2 + sqrt(A1 A2)).
    #[test]
    fn sphere_has_the_volume_of_its_frusta() {
        let (radius, n) = (1.7, f64::from(AROUND));
        let exact: f64 = (0..ALONG)
            .map(|j| {
                let theta = |j: u32| PI * (1.0 - f64::from(j) / f64::from(ALONG));
                let gon = |t: f64| n / 2.0 * (radius * t.sin()).powi(2) * (TAU / n).sin();
                let (a, b) = (gon(theta(j)), gon(theta(j + 1)));
                let h = radius * (theta(j + 1).cos() - theta(j).cos());
                h / 3.0 * (a + b + (a * b).sqrt())
            })
            .sum();
        let found = volume(&revolve(&sphere(radius, -radius, radius), TAU));
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
    }

    /// Inscribed: below the sphere's area and volume, by about (step)^2 / 6 and less.
    #[test]
    fn sphere_is_near_its_closed_form() {
        let radius = 2.5;
        let mesh = revolve(&sphere(radius, -radius, radius), TAU);
        let (a, v) = (4.0 * PI * radius.powi(2), 4.0 / 3.0 * PI * radius.powi(3));
        let step = PI / f64::from(ALONG);
        for (found, exact) in [(area(&mesh), a), (volume(&mesh), v)] {
            let short = 1.0 - found / exact;
            assert!(short > 0.0 && short < step * step, "{short}");
        }
    }

    #[test]
    fn partial_sphere_disk_cylinder_cone_and_paraboloid_by_area() {
        let (sin, n) = ((TAU / f64::from(AROUND)).sin(), f64::from(AROUND));
        let gon = |r: f64| n / 2.0 * r * r * sin;
        let disk_area = area(&revolve(&disk(2.0, 0.5, 1.0), TAU));
        assert!((disk_area / (gon(2.0) - gon(0.5)) - 1.0).abs() < 1e-12);
        let side = 2.0 * 2.0 * (PI / n).sin();
        let tube = area(&revolve(&cylinder(2.0, -1.0, 3.0), TAU));
        assert!((tube / (n * side * 4.0) - 1.0).abs() < 1e-12);
        for (mesh, smooth) in [
            (revolve(&cone(1.0, 2.0), TAU), PI * 5f64.sqrt()),
            (revolve(&sphere(1.0, -0.5, 0.75), PI), PI * 1.25),
            // z = r^2 to r = 1: pi/6 (5^1.5 - 1).
            (
                revolve(&paraboloid(1.0, 0.0, 1.0), TAU),
                PI / 6.0 * (5f64.powf(1.5) - 1.0),
            ),
        ] {
            let short = 1.0 - area(&mesh) / smooth;
            assert!(short > 0.0 && short < 0.01, "{short}");
        }
    }

    /// Every profile's normals agree with its winding.
    #[test]
    fn normals_agree_with_winding() {
        for profile in [
            sphere(1.0, -1.0, 0.3),
            cylinder(1.0, -1.0, 1.0),
            disk(1.0, 0.0, 0.0),
            cone(1.0, 1.0),
            paraboloid(1.0, 0.2, 1.0),
        ] {
            let mesh = revolve(&profile, 4.0);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let n: DVec3 = t.iter().map(|&i| mesh.normals[i as usize]).sum();
                assert!((b - a).cross(c - a).dot(n) > 0.0);
            }
        }
    }
}
