//! Nearest neighbours among points of a few dimensions: a kd-tree in an array.

/// Dimensions of a place: position, normal, mirrored viewer, each scaled.
pub(crate) const PLACE: usize = 9;

/// A point of the tree.
pub(crate) type PlaceVector = [f32; PLACE];

/// Below this many points a range is searched one by one.
const LEAF: usize = 8;

/// A balanced kd-tree: the middle of each range is its node.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaceTree {
    /// Points in the order of the tree, and the numbers that they were given.
    points: Vec<PlaceVector>,
    ids: Vec<u32>,
    /// Axis that each node cuts.
    axes: Vec<u8>,
}

/// A neighbour: squared distance, number.
pub(crate) type Near = (f32, u32);

impl PlaceTree {
    /// A tree over points with their numbers.
    pub(crate) fn new(points: &[(PlaceVector, u32)]) -> PlaceTree {
        let mut order: Vec<(PlaceVector, u32)> = points.to_vec();
        let mut axes = vec![0; order.len()];
        arrange(&mut order, &mut axes);
        PlaceTree {
            points: order.iter().map(|p| p.0).collect(),
            ids: order.iter().map(|p| p.1).collect(),
            axes,
        }
    }

    /// The `count` nearest points that `wanted` accepts, nearest first, into `found`.
    pub(crate) fn nearest(
        &self,
        of: &PlaceVector,
        count: usize,
        wanted: impl Fn(u32) -> bool,
        found: &mut Vec<Near>,
    ) {
        found.clear();
        if count > 0 {
            self.search(0, self.ids.len(), of, count, &wanted, found);
        }
    }

    fn search(
        &self,
        low: usize,
        high: usize,
        of: &PlaceVector,
        count: usize,
        wanted: &impl Fn(u32) -> bool,
        found: &mut Vec<Near>,
    ) {
        if high - low <= LEAF {
            for at in low..high {
                self.consider(at, of, count, wanted, found);
            }
            return;
        }
        let middle = low + (high - low) / 2;
        let axis = self.axes[middle] as usize;
        let ahead = of[axis] - self.points[middle][axis];
        let (near, far) = if ahead < 0.0 {
            ((low, middle), (middle + 1, high))
        } else {
            ((middle + 1, high), (low, middle))
        };
        self.search(near.0, near.1, of, count, wanted, found);
        self.consider(middle, of, count, wanted, found);
        let beyond = |near: &Near| ahead * ahead <= near.0;
        if found.len() < count || found.last().is_none_or(beyond) {
            self.search(far.0, far.1, of, count, wanted, found);
        }
    }

    fn consider(
        &self,
        at: usize,
        of: &PlaceVector,
        count: usize,
        wanted: &impl Fn(u32) -> bool,
        found: &mut Vec<Near>,
    ) {
        let pairs = self.points[at].iter().zip(of);
        let squared: f32 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
        let near = (squared, self.ids[at]);
        let is_before = |a: &Near| a.0 < near.0 || (a.0 == near.0 && a.1 < near.1);
        if found.len() == count && found.last().is_some_and(is_before) || !wanted(near.1) {
            return;
        }
        let place = found.partition_point(is_before);
        found.insert(place, near);
        found.truncate(count);
    }
}

/// Puts the median along the widest axis in the middle of each range.
fn arrange(points: &mut [(PlaceVector, u32)], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let spread = |axis: usize| {
        let values = points.iter().map(|p| p.0[axis]);
        let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        high - low
    };
    let mut axis = 0;
    for other in 1..PLACE {
        if spread(other) > spread(axis) {
            axis = other;
        }
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
    });
    axes[middle] = axis as u8;
    let (left, right) = points.split_at_mut(middle);
    let (left_axes, right_axes) = axes.split_at_mut(middle);
    arrange(left, left_axes);
    arrange(&mut right[1..], &mut right_axes[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracing::Stream;

    /// The tree finds what looking at every point finds.
    #[test]
    fn finds_what_brute_force_finds() {
        let stream = Stream::new(4, rrf_sampling::Stage::Test, 0);
        let place = |i: u64| {
            let (a, b) = (stream.units(i, 0, 0), stream.units(i, 0, 1));
            let flat = i.is_multiple_of(3);
            [
                a[0],
                if flat { 0.5 } else { a[1] },
                a[2],
                a[3],
                0.0,
                0.0,
                b[0],
                b[1],
                b[2],
            ]
        };
        let points: Vec<_> = (0..700).map(|i| (place(i), i as u32)).collect();
        let tree = PlaceTree::new(&points);
        let mut found = Vec::new();
        for i in 700..760 {
            let at = place(i);
            let odd = |id: u32| id % 2 == 1;
            tree.nearest(&at, 12, odd, &mut found);
            let mut all: Vec<Near> = (points.iter())
                .filter(|p| odd(p.1))
                .map(|p| {
                    (
                        p.0.iter().zip(&at).map(|(a, b)| (a - b) * (a - b)).sum(),
                        p.1,
                    )
                })
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(found, all[..12]);
        }
        tree.nearest(&place(0), 0, |_| true, &mut found);
        assert!(found.is_empty());
        PlaceTree::default().nearest(&place(0), 3, |_| true, &mut found);
        assert!(found.is_empty());
    }
}
