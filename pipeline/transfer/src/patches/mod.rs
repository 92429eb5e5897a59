//! The scene's surface in patches: the places that direct light is told of.
//!
//! Flat parts that are large beside a patch are cut by a grid in their own plane, each of whose
//! cells may be quartered where a size field asks for it; triangles that are small beside a
//! patch stay whole. Both kinds of *elements* are then joined with neighbours of the same
//! object and material that face alike, until they are about as large as a patch should be.
//!
//! Front and back of a surface are told apart, and a patch that does not reflect alike in all
//! directions tells the light of several directions apart: each of these is a *column* of the
//! transfer. [`Patches::column`] finds the column of a path's vertex in constant time.

mod clip;
mod element;
mod grid;
mod merge;
mod planes;
mod points;
mod size;

use crate::TransferError;
use crate::tracing::{Bsdf, SurfacePoint, is_lambert};
use element::{Element, Piece};
use glam::{DVec3, Vec3};
use grid::{Cutter, Grid, level};
use rrf_scene::Scene;

pub use element::SizeField;
pub use points::PatchPoint;
pub use size::PatchSizes;

/// How patches are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchConfig {
    /// How many patches the surface would have, both sides counted once, if it were one flat
    /// piece and the size field 1: a patch's edge is the root of the area over this. Bends, small
    /// objects and the size field make them more.
    pub count: usize,
    /// Directions that light is sorted into along each axis of a glossy patch, squared.
    pub directions: u32,
    /// Surfaces of at most this perceptual roughness, and metals, are glossy.
    pub gloss: f32,
}

impl Default for PatchConfig {
    fn default() -> PatchConfig {
        PatchConfig {
            count: 4_000,
            directions: 4,
            gloss: 0.3,
        }
    }
}

/// Where the points of a triangle look for their patch.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// The triangle has no area.
    Nowhere,
    /// All of it is in one patch.
    Whole(u32),
    /// In this grid.
    Grid(u32),
}

/// The patches of a scene: parallel columns, one row a patch, both sides of a surface together.
#[derive(Clone, Debug)]
pub struct Patches {
    places: Vec<Place>,
    grids: Vec<Grid>,
    /// Pieces of all patches, those of a patch together.
    pieces: Vec<Piece>,
    /// First piece of each patch, and the number of all.
    first_piece: Vec<u32>,
    /// First column of each patch's front, and the number of all.
    first_column: Vec<u32>,
    /// Directions along each axis that the patch's light is sorted into.
    directions: Vec<u8>,
    /// Square metres.
    pub area: Vec<f32>,
    /// Middle of each patch, world frame, metres.
    pub centre: Vec<Vec3>,
    /// Mean of the geometric normals of its front, unit length, world frame.
    pub normal: Vec<Vec3>,
    /// Object id.
    pub object: Vec<u32>,
    /// Material id.
    pub material: Vec<u32>,
}

impl Patches {
    /// Edge of a patch where the size field is 1, metres; 0 where there is no surface.
    pub fn edge(scene: &Scene, config: &PatchConfig) -> f32 {
        let total: f64 = (0..scene.triangles.len())
            .map(|t| 0.5 * planes::doubled_area(planes::corners(scene, t as u32)).length())
            .sum();
        (total / config.count.max(1) as f64).sqrt() as f32
    }

    /// Cuts a scene's surface into `config.count` patches or more; the size field makes them finer.
    pub fn new(
        scene: &Scene,
        config: &PatchConfig,
        size: SizeField,
    ) -> Result<Patches, TransferError> {
        let groups = planes::groups(scene);
        if groups.is_empty() || config.count == 0 {
            return Err(TransferError::NoPatches);
        }
        let edge = f64::from(Patches::edge(scene, config));
        Ok(Draft::new(scene, &groups, edge, size).finish(scene, config))
    }

    /// How many patches there are, both sides counted once.
    pub fn len(&self) -> usize {
        self.area.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }

    /// How many columns a transfer over these patches has.
    pub fn columns(&self) -> usize {
        self.first_column.last().map_or(0, |&n| n as usize)
    }

    /// Directions along each axis that a patch's light is sorted into.
    #[inline]
    pub fn directions(&self, patch: u32) -> u32 {
        u32::from(self.directions[patch as usize])
    }

    /// Triangles of the scene.
    pub fn triangles(&self) -> usize {
        self.places.len()
    }

    /// The patch that a surface point lies in.
    #[inline]
    pub fn patch(&self, point: &SurfacePoint) -> Option<u32> {
        match self.places[point.triangle as usize] {
            Place::Nowhere => None,
            Place::Whole(patch) => Some(patch),
            Place::Grid(grid) => Some(self.grids[grid as usize].at(point.position)),
        }
    }

    /// First column of one side of a patch.
    #[inline]
    pub fn first_column(&self, patch: u32, back: bool) -> u32 {
        let side = self.directions(patch).pow(2) * u32::from(back);
        self.first_column[patch as usize] + side
    }

    /// The column of light that arrives from the unit direction `l` at a point of the patch with
    /// the unit normal `n`, on the side that `back` names.
    #[inline]
    pub fn column(&self, patch: u32, back: bool, n: Vec3, l: Vec3) -> u32 {
        let first = self.first_column(patch, back);
        let count = self.directions(patch);
        if count == 1 {
            return first;
        }
        let [i, j] = square(self.local(patch, n, l));
        let cell = |x: f32| ((x * count as f32) as u32).min(count - 1);
        first + cell(j) * count + cell(i)
    }

    /// The middle of one of the directions that a side of a patch with the unit normal `n` tells
    /// apart; the normal itself where it tells none.
    pub fn middle_direction(&self, patch: u32, n: Vec3, cell: u32) -> Vec3 {
        let count = self.directions(patch);
        if count == 1 {
            return n;
        }
        let middle = |k: u32| 2.0 * (k as f32 + 0.5) / count as f32 - 1.0;
        let [x, y] = disk([middle(cell % count), middle(cell / count)]);
        let across = self.across(patch, n);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        across * x + n.cross(across) * y + n * z
    }

    /// A direction along the tangents at a point of a patch: the first tangent is across the same
    /// world axis all over the patch, so that neighbouring points sort light alike.
    fn local(&self, patch: u32, n: Vec3, l: Vec3) -> [f32; 2] {
        let x = self.across(patch, n);
        [l.dot(x), l.dot(n.cross(x))]
    }

    /// The first tangent at a point of a patch with this normal.
    fn across(&self, patch: u32, n: Vec3) -> Vec3 {
        let mean = self.normal[patch as usize].abs();
        let axis = if mean.x <= mean.y && mean.x <= mean.z {
            Vec3::X
        } else if mean.y <= mean.z {
            Vec3::Y
        } else {
            Vec3::Z
        };
        axis.cross(n).normalize_or(n.any_orthonormal_vector())
    }
}

/// A point of the unit disk in the unit square, equal areas to equal areas (Shirley and Chiu
/// 1997). On the disk of directions, equal areas are equal projected solid angles.
fn square([x, y]: [f32; 2]) -> [f32; 2] {
    let radius = x.hypot(y).min(1.0);
    let quarter = std::f32::consts::FRAC_PI_4;
    let (a, b) = if x.abs() > y.abs() {
        let a = radius.copysign(x);
        (a, a * (y / x).atan() / quarter)
    } else if y != 0.0 {
        let b = radius.copysign(y);
        (b * (x / y).atan() / quarter, b)
    } else {
        (0.0, 0.0)
    };
    [a, b].map(|c| (0.5 * (c + 1.0)).clamp(0.0, 1.0))
}

/// A point of the square from -1 to 1 on the unit disk: undoes [`square`].
fn disk([a, b]: [f32; 2]) -> [f32; 2] {
    let quarter = std::f32::consts::FRAC_PI_4;
    let (radius, turn) = if a.abs() > b.abs() {
        (a, quarter * b / a)
    } else if b != 0.0 {
        (b, 2.0 * quarter - quarter * a / b)
    } else {
        (0.0, 0.0)
    };
    [radius * turn.cos(), radius * turn.sin()]
}

/// Elements and the patches that they are joined to.
struct Draft {
    elements: Vec<Element>,
    grids: Vec<Grid>,
    places: Vec<Place>,
    /// Patch of each element.
    patch: Vec<u32>,
}

impl Draft {
    fn new(scene: &Scene, groups: &[planes::Group], edge: f64, size: SizeField) -> Draft {
        let mut draft = Draft {
            elements: Vec::new(),
            grids: Vec::new(),
            places: vec![Place::Nowhere; scene.triangles.len()],
            patch: Vec::new(),
        };
        let mut kinds = Vec::new();
        for group in groups {
            draft.add(scene, group, edge, size);
            let kind = (group.triangles.first()).map_or([0; 3], |&t| planes::kind(scene, t));
            kinds.resize(draft.elements.len(), kind);
        }
        draft.patch = merge::patches_of(&draft.elements, &kinds);
        draft
    }

    /// The elements of one plane.
    fn add(&mut self, scene: &Scene, group: &planes::Group, edge: f64, size: SizeField) {
        let whole = |&t: &u32| {
            let corners = planes::corners(scene, t);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            level(size(middle))
        };
        let deepest = group.triangles.iter().map(whole).max().unwrap_or(0);
        if group.longest > 1.5 * edge / f64::from(1u32 << deepest) {
            let cutter = Cutter {
                scene,
                group,
                edge,
                size,
            };
            let grid = cutter.cut(&mut self.elements);
            for &t in &group.triangles {
                self.places[t as usize] = Place::Grid(self.grids.len() as u32);
            }
            self.grids.push(grid);
            return;
        }
        for &t in &group.triangles {
            let corners = planes::corners(scene, t);
            let doubled = planes::doubled_area(corners);
            let middle = corners.iter().map(|c| c.as_dvec3()).sum::<DVec3>() / 3.0;
            let area = 0.5 * doubled.length();
            self.places[t as usize] = Place::Whole(self.elements.len() as u32);
            self.elements.push(Element {
                area,
                centre: middle,
                normal: doubled.normalize_or_zero().as_vec3(),
                edge: edge / f64::from(1u32 << whole(&t)),
                pieces: vec![Piece {
                    triangle: t,
                    corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
                    area: area as f32,
                }],
            });
        }
    }

    fn count(&self) -> usize {
        self.patch.iter().max().map_or(1, |&p| p as usize + 1)
    }

    fn finish(mut self, scene: &Scene, config: &PatchConfig) -> Patches {
        let count = self.count();
        let to_patch = |id: &mut u32| *id = self.patch.get(*id as usize).copied().unwrap_or(0);
        self.grids
            .iter_mut()
            .for_each(|g| g.slots.iter_mut().for_each(to_patch));
        for place in &mut self.places {
            if let Place::Whole(id) = place {
                to_patch(id);
            }
        }
        let mut order: Vec<u32> = (0..self.elements.len() as u32).collect();
        order.sort_by_key(|&e| (self.patch[e as usize], e));
        let mut sums = vec![(0.0f64, DVec3::ZERO, DVec3::ZERO); count];
        let (mut pieces, mut first_piece) = (Vec::new(), Vec::with_capacity(count + 1));
        for &e in &order {
            let (element, patch) = (&self.elements[e as usize], self.patch[e as usize] as usize);
            while first_piece.len() <= patch {
                first_piece.push(pieces.len() as u32);
            }
            let sum = &mut sums[patch];
            sum.0 += element.area;
            sum.1 += element.centre * element.area;
            sum.2 += element.normal.as_dvec3() * element.area;
            pieces.extend_from_slice(&element.pieces);
        }
        first_piece.push(pieces.len() as u32);
        let triangle = |patch: usize| {
            let piece = pieces.get(first_piece[patch] as usize);
            piece.map_or(0, |p: &Piece| p.triangle as usize)
        };
        let owners: Vec<usize> = (0..count).map(triangle).collect();
        let material: Vec<u32> = owners.iter().map(|&t| scene.triangle_material[t]).collect();
        let directions: Vec<u8> = (material.iter())
            .map(|&m| sorted_directions(&Bsdf::of(&scene.materials[m as usize]), config))
            .collect();
        let mut first_column = vec![0];
        for &n in &directions {
            let last = first_column.last().copied().unwrap_or(0);
            first_column.push(last + 2 * u32::from(n).pow(2));
        }
        Patches {
            places: self.places,
            grids: self.grids,
            first_piece,
            first_column,
            directions,
            area: sums.iter().map(|s| s.0 as f32).collect(),
            centre: sums.iter().map(|s| (s.1 / s.0).as_vec3()).collect(),
            normal: sums
                .iter()
                .map(|s| s.2.normalize_or(DVec3::Z).as_vec3())
                .collect(),
            object: owners
                .iter()
                .map(|&t| scene.triangle_object.get(t).copied().unwrap_or(0))
                .collect(),
            material,
            pieces,
        }
    }
}

/// Directions along each axis that a material's light is sorted into.
fn sorted_directions(bsdf: &Bsdf, config: &PatchConfig) -> u8 {
    let glossy = bsdf.roughness <= config.gloss || bsdf.metallic > 0.5;
    if is_lambert(bsdf) || !glossy {
        1
    } else {
        config.directions.clamp(1, 64) as u8
    }
}
