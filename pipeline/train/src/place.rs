//! Whether the place of a point tells its normal: a net that reads p then has no use for n.
//!
//! It does on planes, where they meet, and on smooth surfaces. It does not on the two sides of a thin
//! wall, nor where normals change within the distance of neighbouring rows.

use crate::ordered::Ordered;
use rrf_field::columns;
use std::ops::Range;

/// Rows looked at, the first in their random order, and how many of them are asked.
const ROWS: usize = 4096;
const ASKED: usize = 256;
/// Cosine of the angle within which two normals count as one.
const ALONE: f32 = 0.97;
/// Share of the rows whose nearest neighbour may have another normal: on two planes that meet those along the
/// edge do, on the two sides of a wall every other one.
const STRAY: f64 = 0.1;

/// Whether the nearest of a row's neighbours has its normal, in nine of ten rows.
pub(crate) fn tells_normal(rows: &Ordered, train: Range<usize>) -> bool {
    let mut known = Vec::with_capacity(ROWS);
    rows.each(
        train.start..train.end.min(train.start + ROWS),
        |chunk, rows| {
            let vec3 = |first, row| chunk.columns.vec3(first, row);
            known.extend(rows.map(|row| [vec3(columns::P, row), vec3(columns::N, row)]));
        },
    );
    let asked = ASKED.min(known.len());
    let strays = (0..asked).filter(|&row| strays(&known, row)).count();
    known.len() > 1 && strays as f64 <= STRAY * asked as f64
}

/// Whether the row nearest to one has another normal.
fn strays(known: &[[[f32; 3]; 2]], row: usize) -> bool {
    let Some([p, n]) = known.get(row) else {
        return true;
    };
    let distance = |q: &[f32; 3]| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f32>();
    let others = known.iter().enumerate().filter(|(other, _)| *other != row);
    let nearest = others.min_by(|(_, [a, _]), (_, [b, _])| distance(a).total_cmp(&distance(b)));
    let cosine = |m: &[f32; 3]| (0..3).map(|c| n[c] * m[c]).sum::<f32>();
    nearest.is_none_or(|(_, [_, m])| cosine(m) < ALONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chunk::Chunk;
    use crate::made_up::uniform;
    use rrf_field::columns::Columns;

    /// Rows of a surface that is given by two random numbers and a coin.
    fn tells(count: usize, at: impl Fn([f64; 2], bool) -> [[f64; 3]; 2]) -> bool {
        let mut columns = Columns::default();
        for row in 0..count {
            let u = |d| uniform(3, row as u64, d);
            let [p, n] = at([u(0), u(1)], u(2) < 0.0);
            let mut values = [0.0; columns::COUNT];
            for c in 0..3 {
                values[columns::P + c] = p[c] as f32;
                values[columns::N + c] = n[c] as f32;
            }
            columns.push(values);
        }
        let halves = [(); 2].map(|()| vec![[1.0; 3]; count]);
        let rows = Ordered::Held(Box::new(Chunk { columns, halves }));
        tells_normal(&rows, 0..count)
    }

    #[test]
    fn where_planes_meet() {
        let edge = |[s, t]: [f64; 2], first: bool| match first {
            true => [[s + 1.0, t, 0.0], [0.0, 0.0, 1.0]],
            false => [[0.0, t, s + 1.0], [1.0, 0.0, 0.0]],
        };
        assert!(tells(6000, edge));
        assert!(tells(500, edge));
    }

    #[test]
    fn on_a_ball() {
        let ball = |radius: f64| {
            move |[s, t]: [f64; 2], _: bool| {
                let (r, angle) = ((1.0 - s * s).sqrt(), std::f64::consts::PI * t);
                let n = [r * angle.cos(), r * angle.sin(), s];
                [n.map(|n| radius * n), n]
            }
        };
        assert!(tells(4000, ball(0.3)));
        assert!(!tells(40, ball(0.3)), "too few rows to tell");
    }

    /// Thinner than the distance of neighbours, and thicker.
    #[test]
    fn on_the_sides_of_a_wall() {
        let wall = |thickness: f64| {
            move |[s, t]: [f64; 2], first: bool| match first {
                true => [[s, t, thickness], [0.0, 0.0, 1.0]],
                false => [[s, t, 0.0], [0.0, 0.0, -1.0]],
            }
        };
        assert!(!tells(4000, wall(0.0)));
        assert!(!tells(4000, wall(0.01)));
        assert!(tells(4000, wall(0.1)));
    }

    #[test]
    fn a_row_alone_tells_nothing() {
        let one = |_: [f64; 2], _: bool| [[0.0; 3], [0.0, 0.0, 1.0]];
        assert!(!tells(0, one) && !tells(1, one));
    }
}
