//! The cells of a plane: a grid, each of whose cells may be quartered again and again.

use super::clip::{Polygon, Rect, area, clip, fan, triangle_area};
use super::element::{Element, Piece, SizeField};
use super::planes::{Group, PlaneFrame, corners};
use glam::Vec3;
use rrf_scene::Scene;

/// No cell has been given this slot.
pub(super) const EMPTY: u32 = u32::MAX;
/// Slots that a plane may have at most: cells are no longer quartered where more would be needed.
const MOST_SLOTS: usize = 1 << 22;
/// How often a cell can be quartered.
pub(super) const MOST_LEVELS: u32 = 6;

/// Where the cells of a plane lie: dense slots as large as its smallest cells.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    frame: PlaneFrame,
    low: [f64; 2],
    /// Slots a metre.
    density: [f64; 2],
    count: [usize; 2],
    /// Element of each slot while the grid is made, then its patch.
    pub(super) slots: Vec<u32>,
}

impl Grid {
    /// What the slot of a place in the plane holds.
    #[inline]
    pub(super) fn at(&self, place: Vec3) -> u32 {
        let at = self.frame.flat(place);
        let slot = |axis: usize| {
            let x = ((at[axis] - self.low[axis]) * self.density[axis]).max(0.0) as usize;
            x.min(self.count[axis] - 1)
        };
        self.slots[slot(1) * self.count[0] + slot(0)]
    }

    /// Gives each empty slot what a neighbour of it holds, until none is left: a place that
    /// rounding puts beside its cell finds that cell all the same.
    fn fill(&mut self) {
        let [nx, ny] = self.count;
        let mut open: Vec<usize> = (0..nx * ny).filter(|&i| self.slots[i] == EMPTY).collect();
        while !open.is_empty() && open.len() < nx * ny {
            let before = self.slots.clone();
            open.retain(|&i| {
                let (x, y) = (i % nx, i / nx);
                let near = [
                    (x > 0).then(|| i - 1),
                    (x + 1 < nx).then_some(i + 1),
                    (y > 0).then(|| i - nx),
                    (y + 1 < ny).then_some(i + nx),
                ];
                let found = near.into_iter().flatten().find(|&j| before[j] != EMPTY);
                if let Some(j) = found {
                    self.slots[i] = before[j];
                }
                found.is_none()
            });
        }
    }
}

/// How a plane is cut.
pub(super) struct Cutter<'a> {
    pub(super) scene: &'a Scene,
    pub(super) group: &'a Group,
    /// Edge of a cell where the size field is 1, metres.
    pub(super) edge: f64,
    pub(super) size: SizeField<'a>,
}

/// A cell on its way to becoming an element.
struct Cell {
    rect: Rect,
    level: u32,
    /// First slot along both axes, and how many it covers.
    slot: [usize; 2],
    span: usize,
}

impl Cutter<'_> {
    /// The plane's elements, appended to `elements`, and where they lie.
    pub(super) fn cut(&self, elements: &mut Vec<Element>) -> Grid {
        let Group { span, frame, .. } = self.group;
        let extent = [0, 1].map(|axis| (span.high[axis] - span.low[axis]).max(f64::MIN_POSITIVE));
        let cells = extent.map(|e| (e / self.edge).ceil().max(1.0) as usize);
        let step = [0, 1].map(|axis| extent[axis] / cells[axis] as f64);
        let levels = self.levels(cells, step);
        let count = cells.map(|n| n << levels);
        let mut grid = Grid {
            frame: *frame,
            low: span.low,
            density: [0, 1].map(|axis| count[axis] as f64 / extent[axis]),
            count,
            slots: vec![EMPTY; count[0] * count[1]],
        };
        let all: Vec<(u32, Polygon)> = (self.group.triangles.iter())
            .map(|&t| {
                let flat = corners(self.scene, t).map(|p| frame.flat(p));
                (t, flat.to_vec())
            })
            .collect();
        let part = |axis: usize, i: usize| span.low[axis] + i as f64 * step[axis];
        for j in 0..cells[1] {
            let strip = Rect {
                low: [span.low[0], part(1, j)],
                high: [span.high[0], part(1, j + 1)],
            };
            let here = clip_all(&all, &strip);
            for i in 0..cells[0] {
                let cell = Cell {
                    rect: Rect {
                        low: [part(0, i), part(1, j)],
                        high: [part(0, i + 1), part(1, j + 1)],
                    },
                    level: 0,
                    slot: [i << levels, j << levels],
                    span: 1 << levels,
                };
                self.quarter(&cell, &here, &mut grid, elements);
            }
        }
        grid.fill();
        grid
    }

    /// How often the smallest cells have to be quartered.
    fn levels(&self, cells: [usize; 2], step: [f64; 2]) -> u32 {
        let mut least = 1.0f32;
        for j in 0..2 * cells[1] {
            for i in 0..2 * cells[0] {
                let at = [i, j].map(|k| 0.5 * k as f64 + 0.25);
                let low = self.group.span.low;
                let flat = [0, 1].map(|axis| low[axis] + at[axis] * step[axis]);
                least = least.min((self.size)(self.group.frame.place(flat)));
            }
        }
        let fits = |level: u32| (cells[0] << level) * (cells[1] << level) <= MOST_SLOTS;
        (0..=level(least)).rev().find(|&l| fits(l)).unwrap_or(0)
    }

    /// Makes an element of a cell, or quarters it where the size field asks for that.
    fn quarter(
        &self,
        cell: &Cell,
        polygons: &[(u32, Polygon)],
        grid: &mut Grid,
        elements: &mut Vec<Element>,
    ) {
        let inside = clip_all(polygons, &cell.rect);
        if inside.is_empty() {
            return;
        }
        let frame = &self.group.frame;
        let size = (self.size)(frame.place(cell.rect.middle()));
        if cell.span > 1 && level(size) > cell.level {
            for k in 0..4 {
                let span = cell.span / 2;
                let part = Cell {
                    rect: cell.rect.quarter(k),
                    level: cell.level + 1,
                    slot: [0, 1].map(|axis| cell.slot[axis] + span * (k >> axis & 1)),
                    span,
                };
                self.quarter(&part, &inside, grid, elements);
            }
            return;
        }
        let id = elements.len() as u32;
        elements.push(self.element(&inside, cell.level));
        for y in cell.slot[1]..cell.slot[1] + cell.span {
            let first = y * grid.count[0] + cell.slot[0];
            grid.slots[first..first + cell.span].fill(id);
        }
    }

    fn element(&self, inside: &[(u32, Polygon)], level: u32) -> Element {
        let frame = &self.group.frame;
        let mut element = Element {
            normal: frame.normal,
            edge: self.edge / f64::from(1u32 << level),
            ..Element::default()
        };
        for (triangle, polygon) in inside {
            let local = Weights::new(corners(self.scene, *triangle).map(|p| frame.flat(p)));
            for part in fan(polygon) {
                let area = triangle_area(&part);
                let middle = [0, 1].map(|k| part.iter().map(|p| p[k]).sum::<f64>() / 3.0);
                let place = frame.place(middle).as_dvec3();
                element.add(place, area);
                element.pieces.push(Piece {
                    triangle: *triangle,
                    corners: part.map(|p| local.at(p)),
                    area: area as f32,
                });
            }
        }
        element.finish();
        element
    }
}

/// How often a cell is quartered for a size of `size` of the largest.
pub(super) fn level(size: f32) -> u32 {
    let wanted = -size.clamp(1e-6, 1.0).log2();
    ((wanted - 1e-3).ceil().max(0.0) as u32).min(MOST_LEVELS)
}

/// What of the polygons lies in a rectangle.
fn clip_all(polygons: &[(u32, Polygon)], rect: &Rect) -> Vec<(u32, Polygon)> {
    let least = 1e-12 * (rect.high[0] - rect.low[0]) * (rect.high[1] - rect.low[1]);
    (polygons.iter())
        .map(|(t, p)| (*t, clip(p, rect)))
        .filter(|(_, p)| area(p) > least)
        .collect()
}

/// Turns a plane's coordinates into weights of a triangle's second and third corner.
struct Weights {
    corner: [f64; 2],
    rows: [[f64; 2]; 2],
}

impl Weights {
    fn new([a, b, c]: [[f64; 2]; 3]) -> Weights {
        let (e, f) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let det = e[0] * f[1] - e[1] * f[0];
        let inverse = if det == 0.0 { 0.0 } else { 1.0 / det };
        Weights {
            corner: a,
            rows: [
                [f[1] * inverse, -f[0] * inverse],
                [-e[1] * inverse, e[0] * inverse],
            ],
        }
    }

    fn at(&self, p: [f64; 2]) -> [f32; 2] {
        let from = [p[0] - self.corner[0], p[1] - self.corner[1]];
        self.rows
            .map(|row| (row[0] * from[0] + row[1] * from[1]).clamp(0.0, 1.0) as f32)
    }
}
