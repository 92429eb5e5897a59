//! Polygons to triangles.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::DVec3;

/// Divides a polygon into triangles of its corners' places, 0 to n - 1, wound as it is.
///
/// A polygon that its first corner sees whole becomes a fan; any other is divided by ear
/// clipping in the plane of its greatest extent (earcut: Held, "FIST", 2001).
pub(crate) fn triangulate(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let fan = || (1..corners.len().saturating_sub(1) as u32).map(|i| [0, i, i + 1]);
    let is_finite = corners.iter().all(|corner| corner.is_finite());
    if corners.len() <= 3 || !is_finite || is_seen_from_first(corners) {
        return fan().collect();
    }
    let vertices: Vec<[f64; 3]> = corners.iter().map(|corner| corner.to_array()).collect();
    let mut flat = Vec::new();
    let mut ids: Vec<u32> = Vec::new();
    if project3d_to_2d(&vertices, vertices.len(), &mut flat) {
        Earcut::new().earcut(flat.iter().copied(), &[], &mut ids);
    }
    let (ears, _) = ids.as_chunks::<3>();
    if ears.is_empty() {
        // Without an area there is nothing to clip.
        return fan().collect();
    }
    let normal = normal(corners);
    ears.iter()
        .map(|&[a, b, c]| {
            let p = |i: u32| corners.get(i as usize).copied().unwrap_or_default();
            let along = (p(b) - p(a)).cross(p(c) - p(a)).dot(normal);
            if along < 0.0 { [a, c, b] } else { [a, b, c] }
        })
        .collect()
}

/// Twice the polygon's area along its normal (Newell).
fn normal(corners: &[DVec3]) -> DVec3 {
    let first = corners.first().copied().unwrap_or_default();
    corners
        .windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum()
}

/// Whether no triangle of the fan from the first corner turns against the polygon.
fn is_seen_from_first(corners: &[DVec3]) -> bool {
    let normal = normal(corners);
    let Some((&first, rest)) = corners.split_first() else {
        return true;
    };
    rest.windows(2)
        .all(|pair| (pair[0] - first).cross(pair[1] - first).dot(normal) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream, unit};

    fn area(corners: &[DVec3], triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|i| corners[i as usize]);
        (b - a).cross(c - a) / 2.0
    }

    fn lifted(flat: &[[f64; 2]]) -> Vec<DVec3> {
        // Any plane will do: this one is steep to all axes.
        let (u, v) = (DVec3::new(2.0, -1.0, 0.5), DVec3::new(0.3, 1.0, 1.4));
        flat.iter()
            .map(|&[x, y]| u * x + v * y + DVec3::ONE)
            .collect()
    }

    fn is_whole(flat: &[[f64; 2]]) {
        for flat in [flat.to_vec(), flat.iter().rev().copied().collect()] {
            let corners = lifted(&flat);
            for start in 0..corners.len() {
                let mut corners = corners.clone();
                corners.rotate_left(start);
                let triangles = triangulate(&corners);
                let normal = normal(&corners);
                let total: f64 = triangles.iter().map(|&t| area(&corners, t).length()).sum();
                let want = normal.length() / 2.0;
                assert!((total - want).abs() < 1e-12 * want, "{total} for {want}");
                for &t in &triangles {
                    assert!(area(&corners, t).dot(normal) >= 0.0);
                }
            }
        }
    }

    #[test]
    fn areas_of_concave_polygons_are_kept() {
        is_whole(&[[0.0, 0.0], [1.0, 0.2], [2.0, 0.0], [1.0, 2.0]]);
        // A comb, an L and a ring that is cut open.
        is_whole(&[
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 1.0],
            [3.0, 3.0],
            [2.0, 1.0],
            [1.0, 3.0],
        ]);
        is_whole(&[
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ]);
        is_whole(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]);
    }

    #[test]
    fn convex_polygons_stay_fans() {
        let square = lifted(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangulate(&square), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangulate(&square[..3]), [[0, 1, 2]]);
        assert!(triangulate(&square[..2]).is_empty());
    }

    #[test]
    fn polygons_without_area_are_fans() {
        let line = lifted(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.5, 0.0]]);
        assert_eq!(triangulate(&line).len(), 3);
        assert_eq!(triangulate(&[DVec3::NAN; 5]).len(), 3);
        assert_eq!(triangulate(&[DVec3::INFINITY; 4]).len(), 2);
    }

    /// Star-shaped polygons with radii of any size, against their areas by Newell.
    #[test]
    fn stars_of_many_corners() {
        let stream = Stream::new(1, Stage::Test, 0);
        for corners in 4..40 {
            let star: Vec<[f64; 2]> = (0..corners)
                .map(|i| {
                    let angle = std::f64::consts::TAU * f64::from(i) / f64::from(corners);
                    let [word, ..] = stream.at([i, corners, 0, 0]);
                    let radius = 0.05 + f64::from(unit(word));
                    [radius * angle.cos(), radius * angle.sin()]
                })
                .collect();
            is_whole(&star);
        }
    }
}
