//! Whether the position of a point tells its normal, or its material: a net that reads p then has no use for
//! them.
//!
//! It tells the normal on planes, where they meet, and on smooth surfaces, but not on the two sides of a thin
//! wall, nor where normals change within the distance of neighbouring rows. It tells the material where
//! objects of one each meet, but not on a texture.

use crate::rows::order::OrderedRows;
use rrf_field::columns;
use std::ops::Range;

/// What the position may tell, as raw columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Redundant {
    Normal,
    Material,
}

type Row = [f32; columns::COUNT];

/// Rows looked at, the first in their random order, and how many of them are asked.
const ROWS: usize = 4096;
const ASKED: usize = 256;
/// Cosine of the angle within which two normals count as one.
const ALONE: f32 = 0.97;
/// Difference within which two materials count as one, in each number.
const ALIKE: f32 = 0.02;

impl Redundant {
    /// Raw columns that say it.
    pub fn columns(self) -> Range<usize> {
        match self {
            Redundant::Normal => columns::N..columns::V,
            Redundant::Material => columns::BASE..columns::COUNT,
        }
    }

    /// Share of the rows whose nearest neighbour may have another one. Where two planes meet those along the edge
    /// do, on the two sides of a wall every other row. A net follows an edge, but not the tiles of a texture,
    /// whose edges may be few rows as well.
    fn strays(self) -> f64 {
        match self {
            Redundant::Normal => 0.1,
            Redundant::Material => 0.02,
        }
    }

    fn same(self, a: &Row, b: &Row) -> bool {
        let mut pairs = a
            .iter()
            .zip(b)
            .take(self.columns().end)
            .skip(self.columns().start);
        match self {
            Redundant::Normal => pairs.map(|(a, b)| a * b).sum::<f32>() >= ALONE,
            Redundant::Material => pairs.all(|(a, b)| (a - b).abs() <= ALIKE),
        }
    }
}

/// Whether the nearest of a row's neighbours has what it has, but for a few strays.
pub(crate) fn is_redundant(what: Redundant, rows: &OrderedRows, train: Range<usize>) -> bool {
    let mut known: Vec<Row> = Vec::with_capacity(ROWS);
    let first = train.start..train.end.min(train.start + ROWS);
    rows.each(first, |chunk, rows| {
        known.extend(rows.map(|row| chunk.columns.row(row)));
    });
    let asked = ASKED.min(known.len());
    let strays = (0..asked).filter(|&row| strays(what, &known, row)).count();
    known.len() > 1 && strays as f64 <= what.strays() * asked as f64
}

/// Whether the row nearest to one has another.
fn strays(what: Redundant, known: &[Row], row: usize) -> bool {
    let Some(here) = known.get(row) else {
        return true;
    };
    let position = columns::P..columns::N;
    let distance = |there: &Row| -> f32 {
        let pairs = here
            .iter()
            .zip(there)
            .take(position.end)
            .skip(position.start);
        pairs.map(|(a, b)| (a - b).powi(2)).sum()
    };
    let others = known.iter().enumerate().filter(|(other, _)| *other != row);
    let nearest = others.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
    nearest.is_none_or(|(_, nearest)| !what.same(here, nearest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::synthetic::uniform;
    use crate::rows::chunk::Chunk;
    use rrf_field::columns::Columns;

    /// Rows of a surface that is given by two random numbers and a coin.
    fn tells_normal(count: usize, at: impl Fn([f64; 2], bool) -> [[f64; 3]; 2]) -> bool {
        let base = |p: [f64; 3]| p[0];
        redundant(Redundant::Normal, count, at, base)
    }

    fn redundant(
        what: Redundant,
        count: usize,
        at: impl Fn([f64; 2], bool) -> [[f64; 3]; 2],
        base: impl Fn([f64; 3]) -> f64,
    ) -> bool {
        let mut columns = Columns::default();
        for row in 0..count {
            let u = |d| uniform(3, row as u64, d);
            let [p, n] = at([u(0), u(1)], u(2) < 0.0);
            let mut values = [0.0; columns::COUNT];
            for c in 0..3 {
                values[columns::P + c] = p[c] as f32;
                values[columns::N + c] = n[c] as f32;
            }
            values[columns::BASE] = base(p) as f32;
            columns.push(values);
        }
        let halves = [(); 2].map(|()| vec![[1.0; 3]; count]);
        let rows = OrderedRows::Held(Box::new(Chunk { columns, halves }));
        is_redundant(what, &rows, 0..count)
    }

    #[test]
    fn where_planes_meet() {
        let edge = |[s, t]: [f64; 2], first: bool| match first {
            true => [[s + 1.0, t, 0.0], [0.0, 0.0, 1.0]],
            false => [[0.0, t, s + 1.0], [1.0, 0.0, 0.0]],
        };
        assert!(tells_normal(6000, edge));
        assert!(tells_normal(500, edge));
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
        assert!(tells_normal(4000, ball(0.3)));
        assert!(!tells_normal(40, ball(0.3)), "too few rows to tell");
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
        assert!(!tells_normal(4000, wall(0.0)));
        assert!(!tells_normal(4000, wall(0.01)));
        assert!(tells_normal(4000, wall(0.1)));
    }

    #[test]
    fn a_row_alone_tells_nothing() {
        let one = |_: [f64; 2], _: bool| [[0.0; 3], [0.0, 0.0, 1.0]];
        assert!(!tells_normal(0, one) && !tells_normal(1, one));
    }

    /// Two objects side by side, tiles, a gradient, and noise.
    #[test]
    fn materials() {
        let plane = |[s, t]: [f64; 2], _: bool| [[s, t, 0.0], [0.0, 0.0, 1.0]];
        let tells = |base: fn([f64; 3]) -> f64| redundant(Redundant::Material, 6000, plane, base);
        assert!(tells(|p| if p[0] < 0.3 { 0.2 } else { 0.8 }));
        assert!(tells(|p| 0.5 + 0.3 * p[1]));
        assert!(!tells(
            |p| ((8.0 * p[0]).floor() + (8.0 * p[1]).floor()).rem_euclid(2.0)
        ));
        assert!(!tells(|p| (1e4 * p[0]).fract().abs()));
    }
}
