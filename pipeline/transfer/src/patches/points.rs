//! Fixed points of a patch, at which its irradiance is asked for.

use super::Patches;
use crate::tracing::{DIMENSIONS, Scramble, Stream, Table, scramble};

/// A point of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    /// Scene id of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
}

impl Patches {
    /// A point of a patch, uniform by area, by three numbers in [0, 1).
    pub fn place(&self, patch: u32, [u, v, w]: [f32; 3]) -> Option<PatchPoint> {
        let id = patch as usize;
        let range = self.first_piece[id] as usize..self.first_piece[id + 1] as usize;
        let pieces = &self.pieces[range];
        let mut left = u * pieces.iter().map(|piece| piece.area).sum::<f32>();
        let mut chosen = pieces.first()?;
        for piece in pieces {
            chosen = piece;
            if left < piece.area {
                break;
            }
            left -= piece.area;
        }
        Some(PatchPoint {
            triangle: chosen.triangle,
            barycentrics: inside(&chosen.corners, v, w),
        })
    }

    /// `count` points of a patch, uniform by area and stratified; always the same.
    pub fn points(&self, patch: u32, count: u32, stream: Stream, table: &Table) -> Vec<PatchPoint> {
        let id = patch as usize;
        let range = self.first_piece[id] as usize..self.first_piece[id + 1] as usize;
        let pieces = &self.pieces[range];
        let total: f64 = pieces.iter().map(|p| f64::from(p.area)).sum();
        let by = scrambles(stream, patch);
        let (mut at, mut below) = (0, 0.0);
        (0..count)
            .filter_map(|k| {
                let point = table.reversed(k as usize);
                let [u, v, w] = [0, 1, 2].map(|d: usize| scramble(point[d], by[d]));
                // strata by area in the order of the pieces, points in a piece by two dimensions
                let target = (f64::from(k) + f64::from(u)) / f64::from(count) * total;
                while at + 1 < pieces.len() && below + f64::from(pieces[at].area) <= target {
                    below += f64::from(pieces[at].area);
                    at += 1;
                }
                let piece = pieces.get(at)?;
                Some(PatchPoint {
                    triangle: piece.triangle,
                    barycentrics: inside(&piece.corners, v, w),
                })
            })
            .collect()
    }
}

/// A point of a triangle from two numbers, uniform by area (Heitz 2019).
fn inside(corners: &[[f32; 2]; 3], a: f32, b: f32) -> [f32; 2] {
    let (first, second) = if b > a {
        (a * 0.5, b - a * 0.5)
    } else {
        (a - b * 0.5, b * 0.5)
    };
    let rest = 1.0 - first - second;
    [0, 1].map(|axis| {
        let [p, q, r] = corners.map(|c| c[axis]);
        rest * p + first * q + second * r
    })
}

fn scrambles(stream: Stream, patch: u32) -> [Scramble; DIMENSIONS] {
    let mut all = [[0; 2]; DIMENSIONS];
    for (block, pair) in all.chunks_mut(2).enumerate() {
        let words = stream.block(u64::from(patch), 0, block as u32);
        for (scramble, word) in pair.iter_mut().zip(words.chunks(2)) {
            scramble.copy_from_slice(word);
        }
    }
    all
}
