//! Points of one cell, answered several at a time.
//!
//! Every operation is done lane by lane and none is fused, so that a point's bits depend neither
//! on its neighbours nor on the processor.

use super::net::TransferNet;
use super::nodes::{ALIKE, BLENDED, PLACE_NUMBERS, TransferNodes, blend};
use super::part::PartFit;
use crate::query::{INPUTS, TransferQuery};
use glam::Vec3;
use multiversion::multiversion;
use rrf_field::rational_tanh;

/// Points that are answered at a time.
pub(crate) const LANES: usize = 16;

/// One number of each of them.
type Lane = [f32; LANES];

/// What the parts of a cell make of its points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PartAnswer {
    /// Each part over its directional albedo.
    pub(crate) parts: [Vec3; 2],
    /// How far the point lies outside of what the parts were fitted to, in deviations.
    pub(crate) beyond: f32,
}

/// Answers points of one cell under a contracted light, in their order.
#[multiversion(targets(
    "x86_64+avx+avx2+fma+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx+avx2+fma"
))]
pub(crate) fn answer_block(
    parts: &[PartFit; 2],
    contracted: [&[Vec3]; 2],
    queries: &[&TransferQuery],
    out: &mut Vec<PartAnswer>,
) {
    let mut inputs = [[0.0f32; LANES]; INPUTS];
    for queries in queries.chunks(LANES) {
        for (lane, query) in queries.iter().enumerate() {
            for (column, x) in inputs.iter_mut().zip(query.inputs()) {
                column[lane] = x;
            }
        }
        let mut answers = [PartAnswer::default(); LANES];
        for (k, (part, contracted)) in parts.iter().zip(contracted).enumerate() {
            let mut sums = [[0.0f32; LANES]; 3];
            match part {
                PartFit::Nothing => continue,
                PartFit::Net(net) => {
                    let beyond = of_net(net, contracted, &inputs, &mut sums);
                    for (answer, beyond) in answers.iter_mut().zip(beyond) {
                        answer.beyond = answer.beyond.max(beyond);
                    }
                }
                PartFit::Nodes(nodes) => {
                    of_nodes(nodes, contracted, queries, &inputs, &mut sums);
                }
            }
            for (lane, answer) in answers.iter_mut().enumerate() {
                answer.parts[k] = Vec3::new(sums[0][lane], sums[1][lane], sums[2][lane]);
            }
        }
        out.extend_from_slice(&answers[..queries.len()]);
    }
}

/// A net's outputs, and how far points lie beyond what it was fitted to.
#[inline(always)]
fn of_net(
    net: &TransferNet,
    contracted: &[Vec3],
    inputs: &[Lane; INPUTS],
    sums: &mut [Lane; 3],
) -> Lane {
    let mut x = [[0.0f32; LANES]; INPUTS];
    let mut beyond = [0.0f32; LANES];
    let d = net.inputs.len().min(INPUTS);
    for j in 0..d {
        let column = &inputs[usize::from(net.inputs[j]).min(INPUTS - 1)];
        let (mean, scale) = (net.mean[j], net.scale[j]);
        let (low, high) = (net.low[j], net.high[j]);
        for i in 0..LANES {
            let scaled = (column[i] - mean) * scale;
            beyond[i] = beyond[i].max(low - scaled).max(scaled - high);
            x[j][i] = scaled.max(low).min(high);
        }
    }
    let (first, units) = contracted.split_at((1 + d).min(contracted.len()));
    let mut own = [[0.0f32; LANES]; 3];
    for (j, w) in first.iter().enumerate() {
        for (own, w) in own.iter_mut().zip(w.to_array()) {
            for i in 0..LANES {
                own[i] += if j == 0 { w } else { w * x[j - 1][i] };
            }
        }
    }
    for (w, hidden) in units.iter().zip(net.hidden.chunks_exact(d + 1)) {
        let mut z = [hidden[d]; LANES];
        for (h, x) in hidden[..d].iter().zip(&x) {
            for i in 0..LANES {
                z[i] += h * x[i];
            }
        }
        for z in &mut z {
            *z = rational_tanh::<false>(*z);
        }
        for (own, w) in own.iter_mut().zip(w.to_array()) {
            for i in 0..LANES {
                own[i] += w * z[i];
            }
        }
    }
    *sums = own;
    beyond
}

/// Blends of the nearest nodes, as [`TransferNodes::evaluate`] makes them.
#[inline(always)]
fn of_nodes(
    nodes: &TransferNodes,
    contracted: &[Vec3],
    queries: &[&TransferQuery],
    inputs: &[Lane; INPUTS],
    sums: &mut [Lane; 3],
) {
    let mut geometric = [[0.0f32; LANES]; 3];
    for (lane, query) in queries.iter().enumerate() {
        for (column, x) in geometric.iter_mut().zip(query.geometric.to_array()) {
            column[lane] = x;
        }
    }
    let [turn, view] = nodes.turns.map(|t| t * t);
    let by = [1.0, 1.0, 1.0, turn, turn, turn, view, view, view];
    let mut nearest = [[f32::INFINITY; LANES]; BLENDED + 1];
    let mut which = [[0u32; LANES]; BLENDED + 1];
    let places = nodes.places.chunks_exact(PLACE_NUMBERS);
    for (id, (place, normal)) in (0..).zip(places.zip(nodes.normals.chunks_exact(3))) {
        let (mut squared, mut cosine) = ([0.0f32; LANES], [0.0f32; LANES]);
        for ((column, at), by) in inputs.iter().zip(place).zip(by) {
            for i in 0..LANES {
                let way = column[i] - at;
                squared[i] += by * (way * way);
            }
        }
        for (column, n) in geometric.iter().zip(normal) {
            for i in 0..LANES {
                cosine[i] += column[i] * n;
            }
        }
        let mut nearer = false;
        for i in 0..LANES {
            squared[i] = if cosine[i] < ALIKE {
                f32::INFINITY
            } else {
                squared[i]
            };
            nearer |= squared[i] < nearest[BLENDED][i];
        }
        if !nearer {
            continue;
        }
        // an insertion that keeps each lane sorted; what is equal stays in its order
        let mut ids = [id; LANES];
        for (nearest, which) in nearest.iter_mut().zip(&mut which) {
            for i in 0..LANES {
                let swap = squared[i] < nearest[i];
                let (near, of) = (nearest[i], which[i]);
                nearest[i] = if swap { squared[i] } else { near };
                which[i] = if swap { ids[i] } else { of };
                squared[i] = if swap { near } else { squared[i] };
                ids[i] = if swap { of } else { ids[i] };
            }
        }
    }
    for (lane, query) in queries.iter().enumerate() {
        let near: [(f32, usize); BLENDED + 1] =
            std::array::from_fn(|k| (nearest[k][lane], which[k][lane] as usize));
        let value = blend(nodes, query.position, &near, contracted);
        for (sum, x) in sums.iter_mut().zip(value.to_array()) {
            sum[lane] = x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::PackedRows;
    use rrf_sampling::{Stage, Stream};

    fn numbers(seed: u64, count: usize) -> Vec<f32> {
        let stream = Stream::new(seed, Stage::Test, 0);
        let four = |i: usize| stream.units(i as u64, 0, 0);
        (0..count).map(|i| 2.0 * four(i / 4)[i % 4] - 1.0).collect()
    }

    fn queries() -> Vec<TransferQuery> {
        let unit = |x: &[f32]| Vec3::from_slice(x).normalize();
        (numbers(1, 100 * 12).chunks(12))
            .map(|x| TransferQuery {
                position: Vec3::from_slice(x),
                geometric: (unit(&x[3..]) + Vec3::Z).normalize(),
                shading: unit(&x[6..]),
                viewer: unit(&x[9..]),
                base_color: Vec3::ONE,
                surface: Default::default(),
            })
            .collect()
    }

    fn parts() -> [PartFit; 2] {
        let (d, units, outputs) = (5, 11, 6);
        let net = TransferNet {
            inputs: vec![0, 2, 3, 5, 8],
            mean: numbers(2, d),
            scale: vec![1.3; d],
            low: vec![-1.0; d],
            high: vec![0.9; d],
            hidden: numbers(3, units * (d + 1)),
            output: PackedRows::pack(&numbers(4, (1 + d + units) * outputs), outputs),
        };
        let count = 40;
        let normals = numbers(6, 3 * count);
        let normals = normals.chunks(3).map(|n| Vec3::from_slice(n).normalize());
        let nodes = TransferNodes {
            turns: [0.2, 0.1],
            places: numbers(5, PLACE_NUMBERS * count),
            normals: normals.flat_map(|n| n.to_array()).collect(),
            values: PackedRows::pack(&numbers(7, count * 3 * outputs), outputs),
        };
        [PartFit::Net(net), PartFit::Nodes(nodes)]
    }

    /// Blocks give what points give one by one, but for tanh's own rounding; a point's bits do not
    /// depend on those beside it.
    #[test]
    fn blocks_answer_as_single_points() {
        let (queries, parts) = (queries(), parts());
        let light = [Vec3::new(1.0, 0.5, 2.0), Vec3::new(-0.3, 0.8, 1.0)];
        let contracted = [0, 1].map(|k: usize| parts[k].contract(&light));
        let contracted = [0, 1].map(|k: usize| contracted[k].as_slice());
        let all: Vec<&TransferQuery> = queries.iter().collect();
        let mut found = Vec::new();
        answer_block(&parts, contracted, &all, &mut found);
        assert_eq!(found.len(), all.len());
        for (query, found) in all.iter().zip(&found) {
            let mut alone = Vec::new();
            answer_block(&parts, contracted, &[query], &mut alone);
            assert_eq!(alone[0].parts, found.parts);
            assert_eq!(alone[0].beyond, found.beyond);
            for k in 0..2 {
                let expected = parts[k].evaluate(query, contracted[k]);
                let off = (expected - found.parts[k]).abs().max_element();
                assert!(off < 2e-5, "{k}: {expected} {}", found.parts[k]);
            }
            assert_eq!(parts[0].is_inside(query, 0.5), found.beyond <= 0.5);
        }
    }
}
