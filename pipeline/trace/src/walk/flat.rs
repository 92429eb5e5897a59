//! Small scenes without a hierarchy: sixteen rays at once against every triangle.
//!
//! Below some sixty triangles a walk down a tree costs more in mispredicted branches than it
//! saves in tests; this has none. Distances and weights are those of the tree, bit by bit.

use super::edges::{Edges, Line, barycentrics};
use super::ray::{Found, Ray};
use glam::{DVec3, Vec3};
use rrf_scene::INVALID;

/// Most triangles for which this is the faster way (measured).
pub const MOST: usize = 64;
/// Rays at once: one AVX-512 register, two AVX ones.
const RAYS: usize = 16;

/// All triangles of a small scene.
#[derive(Clone, Debug)]
pub struct Flat {
    triangles: Vec<(Edges, u32)>,
    /// Middle of the scene, as in [`super::Wide`].
    centre: Vec3,
}

/// Sixteen rays as columns.
struct Packet {
    origin: [[f32; RAYS]; 3],
    direction: [[f32; RAYS]; 3],
    moment: [[f32; RAYS]; 3],
    t_max: [f32; RAYS],
}

impl Packet {
    #[inline(always)]
    fn new(rays: &[Ray], centre: Vec3) -> Packet {
        let mut packet = Packet {
            origin: [[0.0; RAYS]; 3],
            direction: [[0.0; RAYS]; 3],
            moment: [[0.0; RAYS]; 3],
            t_max: [0.0; RAYS],
        };
        for (i, ray) in rays.iter().take(RAYS).enumerate() {
            let line = Line::new(ray.origin - centre, ray.direction);
            for axis in 0..3 {
                packet.origin[axis][i] = line.origin[axis];
                packet.direction[axis][i] = line.direction[axis];
                packet.moment[axis][i] = line.moment[axis];
            }
            packet.t_max[i] = ray.t_max;
        }
        packet
    }

    #[inline(always)]
    fn line(&self, i: usize) -> Line {
        let at = |rows: &[[f32; RAYS]; 3]| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
        Line {
            origin: at(&self.origin),
            direction: at(&self.direction),
            moment: at(&self.moment),
        }
    }
}

impl Flat {
    /// Triangles `corners` with scene ids `ids`.
    pub fn new(corners: &[[Vec3; 3]], ids: &[u32], centre: Vec3) -> Flat {
        let place: DVec3 = centre.as_dvec3();
        let edges = corners.iter().map(|&c| Edges::new(c, place));
        Flat {
            triangles: edges.zip(ids.iter().copied()).collect(),
            centre,
        }
    }

    /// The closest triangle with 0 < t < t_max of every ray, appended to `hits`.
    ///
    /// Distances are compared as integers (the order of positive floats is that of their bits)
    /// and places taken by bitwise arithmetic: selections would become masked stores, which
    /// are slow to read back.
    #[inline(always)]
    pub fn closest(&self, rays: &[Ray], hits: &mut Vec<Found>) {
        for rays in rays.chunks(RAYS) {
            let packet = Packet::new(rays, self.centre);
            let mut nearest = packet.t_max.map(|t| if t > 0.0 { t.to_bits() } else { 0 });
            let mut places = [u32::MAX; RAYS];
            for (place, (edges, _)) in (0u32..).zip(&self.triangles) {
                for i in 0..RAYS {
                    let met = edges.meet(&packet.line(i));
                    let hit = met.inside & (met.t > 0.0);
                    let bits = if hit { met.t.to_bits() } else { u32::MAX };
                    let nearer = u32::from(bits < nearest[i]).wrapping_neg();
                    nearest[i] = nearest[i].min(bits);
                    places[i] ^= (places[i] ^ place) & nearer;
                }
            }
            for (i, (ray, place)) in rays.iter().zip(places).enumerate() {
                hits.push(self.found(&packet.line(i), place, ray));
            }
        }
    }

    /// The end of a ray, from the triangle's place; computed once more for that one triangle.
    #[inline(always)]
    fn found(&self, line: &Line, place: u32, ray: &Ray) -> Found {
        match self.triangles.get(place as usize) {
            Some((edges, id)) => {
                let met = edges.meet(line);
                Found {
                    triangle: *id,
                    t: met.t,
                    barycentrics: barycentrics(met.weights),
                }
            }
            None => Found {
                triangle: INVALID,
                t: ray.t_max,
                barycentrics: [0.0; 2],
            },
        }
    }

    /// Whether any triangle has 0 < t < t_max, for every ray, appended to `blocked`.
    #[inline(always)]
    pub fn occluded(&self, rays: &[Ray], blocked: &mut Vec<bool>) {
        for rays in rays.chunks(RAYS) {
            let packet = Packet::new(rays, self.centre);
            let mut any = [0u32; RAYS];
            for (edges, _) in &self.triangles {
                for (i, any) in any.iter_mut().enumerate() {
                    let met = edges.meet(&packet.line(i));
                    let hit = met.inside & (met.t > 0.0) & (met.t < packet.t_max[i]);
                    *any |= u32::from(hit);
                }
            }
            for &any in any.iter().take(rays.len()) {
                blocked.push(any != 0);
            }
        }
    }
}
