//! Environment maps: looked up, sampled by their light, with the density beside.

use super::distribution::CellChoice;
use super::mapping::Mapping;
use crate::error::LightError;
use crate::kind::Panorama;
use glam::{Mat3, Vec3};

/// Radiance over all directions as a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
    mapping: Mapping,
    /// World directions to the picture's frame: orthogonal, mirrored or not.
    to_map: Mat3,
    /// `None` where the map is black.
    choice: Option<CellChoice>,
}

impl EnvironmentMap {
    /// `texels` are `width * height` values row-major from the top; `to_map` turns (and perhaps
    /// mirrors) world directions into the picture's frame.
    ///
    /// # Errors
    /// A texel that is not finite or negative, by its place; a size that does not fit.
    pub fn new(
        (width, height): (u32, u32),
        texels: Vec<Vec3>,
        mapping: Mapping,
        to_map: Mat3,
    ) -> Result<EnvironmentMap, LightError> {
        let refuse = |wanted| {
            Err(LightError::Size {
                width,
                height,
                wanted,
            })
        };
        if texels.is_empty() || texels.len() as u64 != u64::from(width) * u64::from(height) {
            return refuse("it needs at least one texel, and all of them");
        }
        if mapping == Mapping::Octahedral && width != height {
            return refuse("an equal-area octahedral map is square");
        }
        let bad = |v: &Vec3| !v.is_finite() || v.min_element() < 0.0;
        if let Some(at) = texels.iter().position(bad) {
            return Err(LightError::Texel {
                column: at as u32 % width,
                row: at as u32 / width,
                value: texels.get(at).copied().unwrap_or(Vec3::NAN),
            });
        }
        let mut map = EnvironmentMap {
            width,
            height,
            texels,
            mapping,
            to_map,
            choice: None,
        };
        map.choice = CellChoice::new(width, height, |x, y| {
            map.mean_of_cell(x, y) * mapping.texel_solid_angle(y, width, height)
        });
        Ok(map)
    }

    fn texel(&self, column: u32, row: u32) -> Vec3 {
        let at = row as usize * self.width as usize + column as usize;
        self.texels.get(at).copied().unwrap_or_default()
    }

    /// Channel mean of the radiance over a texel's cell of the picture. Bilinear interpolation
    /// weighs the texels about it 1, 6, 1 eighths in either dimension.
    fn mean_of_cell(&self, column: u32, row: u32) -> f64 {
        let level = |v: Vec3| v.as_dvec3().element_sum() / 3.0;
        if self.mapping == Mapping::Octahedral {
            return level(self.texel(column, row));
        }
        let (left, right) = (before(column, self.width), after(column, self.width));
        let rows = [
            (row.saturating_sub(1), 1.0),
            (row, 6.0),
            ((row + 1).min(self.height - 1), 1.0),
        ];
        let of_row = |(row, weight): (u32, f64)| {
            let sides = level(self.texel(left, row)) + level(self.texel(right, row));
            weight * (sides + 6.0 * level(self.texel(column, row)))
        };
        rows.into_iter().map(of_row).sum::<f64>() / 64.0
    }

    /// Radiance [W/(sr m²)] from a unit world direction.
    pub fn radiance(&self, toward: Vec3) -> Vec3 {
        let [s, t] = self.mapping.place(self.to_map * toward);
        let (x, y) = (s * f64::from(self.width), t * f64::from(self.height));
        if self.mapping == Mapping::Octahedral {
            let (column, row) = self.cell(x, y);
            return self.texel(column, row);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let left = if x0 < 0.0 {
            self.width - 1
        } else {
            (x0 as u32).min(self.width - 1)
        };
        let right = after(left, self.width);
        let top = y0.max(0.0) as u32;
        let bottom = ((y0 + 1.0) as u32).min(self.height - 1);
        let row = |row: u32| self.texel(left, row).lerp(self.texel(right, row), fx);
        row(top.min(self.height - 1)).lerp(row(bottom), fy)
    }

    fn cell(&self, x: f64, y: f64) -> (u32, u32) {
        (
            (x as u32).min(self.width - 1),
            (y as u32).min(self.height - 1),
        )
    }

    /// A unit world direction by two numbers in [0, 1) and its density with respect to solid
    /// angle [1/sr]: texels by the channel mean of their light times their solid angle, uniform
    /// within. `None` where the map is black.
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let cell = self.choice.as_ref()?.sample(u);
        let size = (self.width, self.height);
        let local = self
            .mapping
            .within((cell.column, cell.row), cell.place, size);
        let density = self.per_solid_angle(cell.probability, cell.row);
        Some((self.to_map.transpose() * local, density))
    }

    /// Density of [`EnvironmentMap::sample`] with respect to solid angle [1/sr].
    pub fn density(&self, toward: Vec3) -> f32 {
        let Some(choice) = &self.choice else {
            return 0.0;
        };
        let [s, t] = self.mapping.place(self.to_map * toward);
        let (column, row) = self.cell(s * f64::from(self.width), t * f64::from(self.height));
        self.per_solid_angle(choice.probability(column, row), row)
    }

    fn per_solid_angle(&self, probability: f32, row: u32) -> f32 {
        let angle = self.mapping.texel_solid_angle(row, self.width, self.height);
        probability / angle as f32
    }

    /// Integral of the radiance times a weight over all world directions, by texels:
    /// weight 1 gives ∫ L dω [W/m²], a clamped cosine an irradiance.
    pub fn integral(&self, weight: impl Fn(Vec3) -> f64) -> Vec3 {
        let mut sum = glam::DVec3::ZERO;
        let to_world = self.to_map.transpose();
        let places = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        for ((x, y), texel) in places.zip(&self.texels) {
            let size = (self.width, self.height);
            let direction = to_world * self.mapping.within((x, y), [0.5; 2], size);
            let angle = self.mapping.texel_solid_angle(y, self.width, self.height);
            sum += texel.as_dvec3() * (angle * weight(direction));
        }
        sum.as_vec3()
    }

    /// The map as a lat-long picture of the world: itself where it is one, else looked up anew.
    pub fn panorama(&self, scale: Vec3) -> Panorama {
        let straight = self.mapping == Mapping::LatLong && self.to_map == Mat3::IDENTITY;
        let (width, height) = match self.mapping {
            Mapping::LatLong => (self.width, self.height),
            Mapping::Octahedral => (2 * self.width, self.width),
        };
        let texel = |k: u64| {
            let (x, y) = (k % u64::from(width), k / u64::from(width));
            let place = [(x, width), (y, height)].map(|(i, n)| (i as f64 + 0.5) / f64::from(n));
            self.radiance(Mapping::LatLong.direction(place)) * scale
        };
        Panorama {
            width,
            height,
            texels: if straight {
                self.texels.iter().map(|&t| t * scale).collect()
            } else {
                (0..u64::from(width) * u64::from(height))
                    .map(texel)
                    .collect()
            },
        }
    }

    /// Texels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Feeds the picture and its place to a hash.
    pub(crate) fn words(&self, sink: &mut dyn FnMut(u32)) {
        [self.width, self.height, self.mapping as u32]
            .into_iter()
            .for_each(&mut *sink);
        crate::kind::hash_vectors(&self.to_map.to_cols_array_2d().map(Vec3::from), sink);
        crate::kind::hash_vectors(&self.texels, sink);
    }
}

fn before(column: u32, width: u32) -> u32 {
    column.checked_sub(1).unwrap_or(width - 1)
}

fn after(column: u32, width: u32) -> u32 {
    if column + 1 < width { column + 1 } else { 0 }
}
