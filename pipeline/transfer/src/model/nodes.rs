//! Local fits kept at nodes, blended between them.

use super::packed::PackedRows;
use crate::query::TransferQuery;
use glam::Vec3;

/// Nodes that a point is blended from.
pub(super) const BLENDED: usize = 6;
/// Cosine between geometric normals from which on one point says nothing of another.
pub(super) const ALIKE: f32 = 0.5;
/// Numbers of a node's place: position, shading normal, mirrored viewer.
pub(super) const PLACE_NUMBERS: usize = 9;

/// Values and slopes of local fits at a few points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferNodes {
    /// Metres that a turn of the normal by 1 is worth, and of the mirrored viewer.
    pub turns: [f32; 2],
    /// Shape [nodes, 9]: position, shading normal, mirrored viewer.
    pub places: Vec<f32>,
    /// Shape [nodes, 3]: the geometric normal, whose tangents the slopes are along.
    pub normals: Vec<f32>,
    /// Shape [3 nodes, 3 rank]: each node's value and two slopes [1/m].
    pub values: PackedRows,
}

impl TransferNodes {
    /// How many nodes.
    pub fn len(&self) -> usize {
        self.places.len() / PLACE_NUMBERS
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Bytes of its numbers.
    pub fn bytes(&self) -> usize {
        4 * (2 + self.places.len() + self.normals.len()) + self.values.bytes()
    }

    /// Value and slopes of every node for a light, a channel each.
    pub fn contract(&self, coefficients: &[Vec3]) -> Vec<Vec3> {
        super::sums::contract(&self.values, coefficients)
    }

    /// The blend of the nearest nodes at a point: each says its value and where that goes with the
    /// way from it (Ward and Heckbert 1992); nearer ones count for more (Shepard 1968, with the
    /// compact weights of Franke and Nielson 1980, so that a node fades before it is left out).
    pub fn evaluate(&self, query: &TransferQuery, contracted: &[Vec3]) -> Vec3 {
        let mut near = [(f32::INFINITY, 0usize); BLENDED + 1];
        let [turn, view] = self.turns;
        let (p, n, r) = (query.position, query.shading, query.reflected());
        let nodes = self
            .places
            .chunks_exact(PLACE_NUMBERS)
            .zip(self.normals.chunks_exact(3));
        for (i, (place, normal)) in nodes.enumerate() {
            if Vec3::from_slice(normal).dot(query.geometric) < ALIKE {
                continue;
            }
            let (a, b) = (Vec3::from_slice(place), Vec3::from_slice(&place[3..]));
            let mut squared = p.distance_squared(a) + turn * turn * n.distance_squared(b);
            if view > 0.0 {
                squared += view * view * r.distance_squared(Vec3::from_slice(&place[6..]));
            }
            if squared < near[BLENDED].0 {
                let at = near.partition_point(|other| other.0 <= squared);
                near[at..].rotate_right(1);
                near[at] = (squared, i);
            }
        }
        blend(self, p, &near, contracted)
    }
}

/// Blends the nearest nodes of a place; the last says how far they reach and takes no part.
#[inline]
pub(super) fn blend(
    nodes: &TransferNodes,
    place: Vec3,
    near: &[(f32, usize); BLENDED + 1],
    contracted: &[Vec3],
) -> Vec3 {
    let reach = match near[BLENDED].0 {
        squared if squared.is_finite() => squared.sqrt(),
        _ => f32::INFINITY,
    };
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for &(squared, i) in &near[..BLENDED] {
        if !squared.is_finite() {
            break;
        }
        let distance = squared.sqrt().max(1e-6);
        let fall = (1.0 / distance - 1.0 / reach).max(0.0);
        let weight = fall * fall + f32::MIN_POSITIVE;
        let normal = Vec3::from_slice(&nodes.normals[3 * i..]);
        let (x, y) = normal.any_orthonormal_pair();
        let way = place - Vec3::from_slice(&nodes.places[PLACE_NUMBERS * i..]);
        let own = &contracted[3 * i..3 * i + 3];
        sum += (own[0] + own[1] * way.dot(x) + own[2] * way.dot(y)) * weight;
        total += weight;
    }
    if total > 0.0 { sum / total } else { Vec3::ZERO }
}
