//! Pictures: views, primary hits, direct light, path-traced rows.

use crate::TraceError;
use crate::rays::{Hits, Rays};
use crate::rng::Stream;
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::view::View;
use crate::wave::{Part, Row, Source, estimate};
use glam::Vec3;
use rrf_scene::PointLight;
use std::ops::Range;

/// What lights a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// Isotropic point lights.
    pub points: Vec<PointLight>,
    /// Whether the scene's own emitting triangles shine.
    pub area: bool,
}

/// The surface points that the pixels of some rows see: parallel columns, one row for every
/// ray that met something.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrimaryHits {
    /// Pixel of the picture, row-major from the upper left.
    pub pixel: Vec<u32>,
    /// Surface points.
    pub points: Vec<SurfacePoint>,
    /// Unit shading normals on the viewer's side.
    pub normals: Vec<Vec3>,
    /// Unit directions to the eye.
    pub viewers: Vec<Vec3>,
}

/// Two independent estimates of the radiance of each pixel [W/(sr m^2)], row-major.
pub type Halves = [Vec<Vec3>; 2];

/// Path-traced rows of a picture. Pixels that see nothing are black.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// All light: direct plus indirect.
    pub full: Halves,
    /// Light that was emitted by what the pixel sees, or reflected once.
    pub direct: Halves,
    /// Light that was reflected at least twice.
    pub indirect: Halves,
}

/// The first hits of rays through the pixel centres of `rows`.
pub fn primary_hits(tracer: &Tracer, view: &View, rows: Range<u32>) -> PrimaryHits {
    subpixel_hits(tracer, view, rows, 1, 0)
}

/// The first hits of rays through cell `part` of an `aa` x `aa` grid on every pixel.
fn subpixel_hits(
    tracer: &Tracer,
    view: &View,
    rows: Range<u32>,
    aa: u32,
    part: u32,
) -> PrimaryHits {
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    let inside = |i: u32| (i as f32 + 0.5) / aa as f32;
    for y in rows.clone() {
        for x in 0..view.width {
            let (x, y) = (x as f32 + inside(part % aa), y as f32 + inside(part / aa));
            rays.push(view.eye, view.direction(x, y), f32::INFINITY);
        }
    }
    tracer.closest_batch(&rays, &mut hits);
    let mut found = PrimaryHits::default();
    let first = rows.start * view.width;
    for (i, direction) in rays.direction.iter().enumerate() {
        let hit = hits.get(i);
        if hit.is_hit() {
            let point = tracer.point(hit.triangle, hit.barycentrics);
            found.pixel.push(first + i as u32);
            found.points.push(point);
            found.normals.push(tracer.normal_at(&point, -*direction));
            found.viewers.push(-*direction);
        }
    }
    found
}

/// Two independent estimates of the light that points send to their viewers after one
/// reflection, and of what they emit. Point lights are exact (the two are equal); lamps are
/// sampled with `samples` paths each, by lamp point and by direction (balance heuristic).
/// Point i draws its numbers at index `indices[i]` of `stream`.
pub fn direct_light(
    tracer: &Tracer,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    lights: &Lights,
    samples: u32,
    stream: Stream,
    indices: &[u64],
) -> Result<Vec<[Vec3; 2]>, TraceError> {
    for (column, found) in [("viewers", viewers.len()), ("indices", indices.len())] {
        same_length(column, found, points.len())?;
    }
    let mut values = vec![[Vec3::ZERO; 2]; points.len()];
    for light in &lights.points {
        for (value, add) in values
            .iter_mut()
            .zip(from_point(tracer, points, viewers, light))
        {
            *value = value.map(|v| v + add);
        }
    }
    if lights.area && !tracer.lamps.is_empty() {
        let part = Part {
            tracer,
            source: Source::Lamps,
            direct: true,
            stream,
        };
        let rows = halves_of(points, viewers, Vec3::ZERO, indices);
        let sampled = estimate(&part, &rows, samples.max(1) as usize);
        for (i, (value, pair)) in values.iter_mut().zip(sampled.chunks_exact(2)).enumerate() {
            let emitted = tracer.emission(&points[i], viewers[i]);
            *value = [value[0] + pair[0] + emitted, value[1] + pair[1] + emitted];
        }
    }
    Ok(values)
}

/// What each point reflects of a point light toward its viewer.
fn from_point(
    tracer: &Tracer,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    light: &PointLight,
) -> Vec<Vec3> {
    let (mut rays, mut blocked) = (Rays::default(), Vec::new());
    let mut values = Vec::with_capacity(points.len());
    for (point, &v) in points.iter().zip(viewers) {
        let vertex = tracer.vertex(point.triangle, point.barycentrics, v);
        let to = light.position - vertex.position;
        let l = to.normalize_or_zero();
        let origin = vertex.position + vertex.geometric * vertex.lift;
        rays.push(origin, light.position - origin, 1.0);
        let reflected = vertex.bsdf.eval(vertex.shading, v, l);
        values.push(if vertex.geometric.dot(l) > 0.0 {
            reflected * light.intensity / to.length_squared()
        } else {
            Vec3::ZERO
        });
    }
    tracer.occluded_batch(&rays, &mut blocked);
    let lit = values.into_iter().zip(blocked);
    lit.map(|(value, blocked)| if blocked { Vec3::ZERO } else { value })
        .collect()
}

/// Path-traces rows of a picture: `spp` paths a pixel for each point light and for the lamps
/// together, through `aa` x `aa` fixed positions on each pixel (`aa` = 1: its centre).
///
/// `spp` has to be a multiple of 2 aa^2. A pixel's bits do not depend on the rows asked for.
pub fn trace_rows(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    rows: Range<u32>,
    spp: u32,
    aa: u32,
    stream: Stream,
) -> Result<Layers, TraceError> {
    let positions = aa.saturating_mul(aa);
    let replicates = positions.saturating_mul(2);
    if spp == 0 || replicates == 0 || !spp.is_multiple_of(replicates) {
        return Err(TraceError::Paths {
            paths: spp,
            replicates,
        });
    }
    let each = spp / replicates;
    let rows = rows.start.min(view.height)..rows.end.min(view.height);
    let pixels = rows.len() * view.width as usize;
    let first = rows.start as usize * view.width as usize;
    let black = || [vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]];
    let (mut direct, mut indirect) = (black(), black());
    let share = 1.0 / positions as f32;
    for part in 0..positions {
        let hits = subpixel_hits(tracer, view, rows.clone(), aa, part);
        let index = |&p: &u32| u64::from(p) * u64::from(positions) + u64::from(part);
        let indices: Vec<u64> = hits.pixel.iter().map(index).collect();
        let (points, viewers) = (&hits.points, &hits.viewers);
        let (one, more) = (stream.part(0), stream.part(1));
        let once = direct_light(tracer, points, viewers, lights, each, one, &indices)?;
        let twice = indirect_light(tracer, points, viewers, lights, each, more, &indices);
        for (i, &pixel) in hits.pixel.iter().enumerate() {
            let at = pixel as usize - first;
            for half in 0..2 {
                direct[half][at] += once[i][half] * share;
                indirect[half][at] += twice[i][half] * share;
            }
        }
    }
    let sum = |half: usize| {
        let both = direct[half].iter().zip(&indirect[half]);
        both.map(|(&d, &i)| d + i).collect()
    };
    Ok(Layers {
        full: [sum(0), sum(1)],
        direct,
        indirect,
    })
}

/// Two independent estimates of the light that points send to their viewers after two or more
/// reflections, `each` paths a light and estimate.
fn indirect_light(
    tracer: &Tracer,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    lights: &Lights,
    each: u32,
    stream: Stream,
    indices: &[u64],
) -> Vec<[Vec3; 2]> {
    let mut values = vec![[Vec3::ZERO; 2]; points.len()];
    let mut add = |source: Source, position: Vec3, color: Vec3, part: u32| {
        let part = Part {
            tracer,
            source,
            direct: false,
            stream: stream.part(part),
        };
        let rows = halves_of(points, viewers, position, indices);
        let sampled = estimate(&part, &rows, each as usize);
        for (value, pair) in values.iter_mut().zip(sampled.chunks_exact(2)) {
            *value = [value[0] + pair[0] * color, value[1] + pair[1] * color];
        }
    };
    if lights.area && !tracer.lamps.is_empty() {
        add(Source::Lamps, Vec3::ZERO, Vec3::ONE, 0);
    }
    for (light, part) in lights.points.iter().zip(1..) {
        let source = Source::Point { connect: true };
        add(source, light.position, light.intensity, part);
    }
    values
}

/// Two rows for every point.
fn halves_of(points: &[SurfacePoint], viewers: &[Vec3], light: Vec3, indices: &[u64]) -> Vec<Row> {
    let columns = points.iter().zip(viewers).zip(indices);
    columns
        .flat_map(|((&point, &viewer), &index)| {
            [0, 1].map(|replicate| Row {
                point,
                viewer,
                light,
                index,
                replicate,
            })
        })
        .collect()
}

fn same_length(column: &'static str, found: usize, expected: usize) -> Result<(), TraceError> {
    if found == expected {
        return Ok(());
    }
    Err(TraceError::Queries {
        column,
        found,
        reference: "points",
        expected,
    })
}
