//! Convex polygons in the plane, cut by lines along the axes.

/// A convex polygon: its corners in order.
pub(super) type Polygon = Vec<[f64; 2]>;

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl Rect {
    /// Quarter `k` of four; bit 0 is the upper half in x, bit 1 that in y.
    pub(super) fn quarter(&self, k: usize) -> Rect {
        let middle = self.middle();
        let side = |axis: usize| {
            if k >> axis & 1 == 1 {
                (middle[axis], self.high[axis])
            } else {
                (self.low[axis], middle[axis])
            }
        };
        let ((x0, x1), (y0, y1)) = (side(0), side(1));
        Rect {
            low: [x0, y0],
            high: [x1, y1],
        }
    }

    /// The middle.
    pub(super) fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }
}

/// The part of a polygon inside a rectangle (Sutherland and Hodgman 1974); empty where none is.
pub(super) fn clip(polygon: &[[f64; 2]], rect: &Rect) -> Polygon {
    let mut kept = polygon.to_vec();
    for axis in 0..2 {
        for (bound, sign) in [(rect.low[axis], 1.0), (rect.high[axis], -1.0)] {
            let height = |p: &[f64; 2]| sign * (p[axis] - bound);
            let before = std::mem::take(&mut kept);
            for (i, here) in before.iter().enumerate() {
                let next = &before[(i + 1) % before.len()];
                let (a, b) = (height(here), height(next));
                if a >= 0.0 {
                    kept.push(*here);
                }
                if (a >= 0.0) != (b >= 0.0) {
                    let t = a / (a - b);
                    kept.push([0, 1].map(|k| here[k] + t * (next[k] - here[k])));
                }
            }
        }
    }
    if kept.len() < 3 { Polygon::new() } else { kept }
}

/// Area of a convex polygon, whichever way its corners run.
pub(super) fn area(polygon: &[[f64; 2]]) -> f64 {
    fan(polygon).map(|t| triangle_area(&t)).sum()
}

/// The triangles that a convex polygon consists of.
pub(super) fn fan(polygon: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 3]> {
    (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]])
}

/// Area of a triangle.
pub(super) fn triangle_area([a, b, c]: &[[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle's parts in a grid of cells have its area, and lie in their cells.
    #[test]
    fn parts_make_the_whole() {
        let triangle = [[0.1, 0.2], [2.9, 0.4], [0.7, 3.3]];
        let mut sum = 0.0;
        for i in 0..4 {
            for j in 0..4 {
                let low = [f64::from(i), f64::from(j)];
                let rect = Rect {
                    low,
                    high: low.map(|x| x + 1.0),
                };
                let part = clip(&triangle, &rect);
                for p in &part {
                    let inside = |k: usize| p[k] > low[k] - 1e-12 && p[k] < low[k] + 1.0 + 1e-12;
                    assert!(inside(0) && inside(1), "{p:?}");
                }
                sum += area(&part);
                let quarters: f64 = (0..4).map(|k| area(&clip(&part, &rect.quarter(k)))).sum();
                assert!((quarters - area(&part)).abs() < 1e-12);
            }
        }
        assert!((sum - area(&triangle)).abs() < 1e-12);
    }
}
