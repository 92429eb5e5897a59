//! The photometric web: intensities over angles, looked up in between.

use glam::Vec3;
use std::f64::consts::PI;

/// How the two angles name a direction. The frame: +z is the direction where both angles are 0,
/// which the luminaire is aimed at, x and y are across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Photometry {
    /// Vertical: angle from +z, 0 to 180; horizontal: turn about +z from +x towards +y.
    C,
    /// Polar axis x: vertical turns about it from +z towards +y, horizontal rises towards +x.
    B,
    /// Polar axis y: horizontal turns about it from +z towards +x, vertical rises towards +y.
    A,
}

/// Luminous intensity of a luminaire by direction \[cd\].
#[derive(Clone, Debug, PartialEq)]
pub struct IesProfile {
    photometry: Photometry,
    /// Vertical angles [degrees], increasing.
    vertical: Vec<f32>,
    /// Horizontal angles [degrees], increasing.
    horizontal: Vec<f32>,
    /// Intensities [cd], one row of vertical angles for every horizontal angle.
    candela: Vec<f32>,
}

impl IesProfile {
    /// Angles in degrees, increasing; `candela` has a row of vertical angles for every
    /// horizontal one. `Err` says what is wrong.
    pub fn new(
        photometry: Photometry,
        vertical: Vec<f32>,
        horizontal: Vec<f32>,
        candela: Vec<f32>,
    ) -> Result<IesProfile, String> {
        for (what, angles) in [("vertical", &vertical), ("horizontal", &horizontal)] {
            let pairs = angles.iter().zip(angles.iter().skip(1));
            if let Some((a, b)) = pairs.clone().find(|(a, b)| a >= b) {
                return Err(format!("the {what} angles {a} and {b} do not increase"));
            }
        }
        let ends = |angles: &[f32]| Some((*angles.first()?, *angles.last()?));
        let (Some((low, high)), Some((first, last))) = (ends(&vertical), ends(&horizontal)) else {
            return Err("a profile needs angles".into());
        };
        let good = match photometry {
            Photometry::C => low >= 0.0 && high <= 180.0 && first >= 0.0 && last <= 360.0,
            Photometry::A | Photometry::B => {
                low >= -90.0 && high <= 90.0 && first >= -90.0 && last <= 90.0
            }
        };
        if !good {
            return Err(format!(
                "angles from {low} to {high} and {first} to {last} degrees are beyond those of \
                 type {photometry:?}"
            ));
        }
        if photometry == Photometry::C && !c_planes(first, last) {
            return Err(format!(
                "horizontal angles from {first} to {last}; 0 alone, 0 to 90, 0 to 180, 90 to \
                 270 or all round are read"
            ));
        }
        if candela.len() != vertical.len() * horizontal.len() {
            return Err(format!("{} intensities for these angles", candela.len()));
        }
        if let Some(bad) = candela.iter().find(|c| !(c.is_finite() && **c >= 0.0)) {
            return Err(format!(
                "an intensity of {bad} cd; light is finite and not negative"
            ));
        }
        Ok(IesProfile {
            photometry,
            vertical,
            horizontal,
            candela,
        })
    }

    /// Intensity \[cd\] in a direction of the profile's frame ([`Photometry`]); linear between the
    /// angles of the table, 0 beyond them.
    pub fn candela(&self, d: Vec3) -> f32 {
        let d = d.as_dvec3().normalize_or_zero();
        let (vertical, horizontal) = match self.photometry {
            Photometry::C => (d.x.hypot(d.y).atan2(d.z), d.y.atan2(d.x)),
            Photometry::B => (d.y.atan2(d.z), d.x.clamp(-1.0, 1.0).asin()),
            Photometry::A => (d.y.clamp(-1.0, 1.0).asin(), d.x.atan2(d.z)),
        };
        self.at(vertical.to_degrees() as f32, horizontal.to_degrees() as f32)
    }

    /// Intensity \[cd\] at a vertical and a horizontal angle \[degrees\], by the table's symmetry.
    pub fn at(&self, vertical: f32, horizontal: f32) -> f32 {
        let (first, last) = (self.horizontal.first(), self.horizontal.last());
        let (&first, &last) = (first.unwrap_or(&0.0), last.unwrap_or(&0.0));
        let folded = match self.photometry {
            Photometry::C => fold(horizontal.rem_euclid(360.0), first, last),
            Photometry::A | Photometry::B if first >= 0.0 => horizontal.abs(),
            Photometry::A | Photometry::B => horizontal,
        };
        let mirrored = self.photometry != Photometry::C && self.vertical.first() >= Some(&0.0);
        let vertical = if mirrored { vertical.abs() } else { vertical };
        let Some((row, next, across)) = self.plane(folded, last) else {
            return 0.0;
        };
        let Some((low, high, along)) = bracket(&self.vertical, vertical) else {
            return 0.0;
        };
        let entry = |plane: usize, at: usize| {
            let at = plane * self.vertical.len() + at;
            self.candela.get(at).copied().unwrap_or(0.0)
        };
        let of = |plane| entry(plane, low) * (1.0 - along) + entry(plane, high) * along;
        of(row) * (1.0 - across) + of(next) * across
    }

    /// The planes about a horizontal angle; those of type C close the circle.
    fn plane(&self, horizontal: f32, last: f32) -> Option<(usize, usize, f32)> {
        let planes = self.horizontal.len();
        if planes == 1 {
            let any = self.photometry == Photometry::C || self.horizontal == [horizontal];
            return any.then_some((0, 0, 0.0));
        }
        if self.photometry == Photometry::C && horizontal > last {
            let first = self.horizontal.first().copied().unwrap_or(0.0);
            let gap = 360.0 - last + first;
            return Some((planes - 1, 0, (horizontal - last) / gap));
        }
        bracket(&self.horizontal, horizontal)
    }

    /// Luminous flux over the sphere \[lm\], by midpoints of one degree.
    pub fn lumens(&self) -> f64 {
        let step = PI / 180.0;
        let mut sum = 0.0;
        for vertical in 0..180 {
            let theta = (f64::from(vertical) + 0.5) * step;
            let (sine, cosine) = theta.sin_cos();
            for horizontal in 0..360 {
                let (y, x) = ((f64::from(horizontal) + 0.5) * step).sin_cos();
                let d = glam::DVec3::new(sine * x, sine * y, cosine).as_vec3();
                sum += f64::from(self.candela(d)) * sine * step * step;
            }
        }
        sum
    }

    /// Largest intensity \[cd\].
    pub fn peak(&self) -> f32 {
        self.candela.iter().copied().fold(0.0, f32::max)
    }

    /// Feeds the table to a hash.
    pub(crate) fn words(&self, sink: &mut dyn FnMut(u32)) {
        sink(self.photometry as u32);
        sink(self.vertical.len() as u32);
        let columns = [&self.vertical, &self.horizontal, &self.candela];
        for value in columns.into_iter().flatten() {
            sink(value.to_bits());
        }
    }
}

/// Whether the planes of type C tell the whole circle.
fn c_planes(first: f32, last: f32) -> bool {
    let symmetric = first == 0.0 && [0.0, 90.0, 180.0].contains(&last);
    symmetric || (first, last) == (90.0, 270.0) || last - first > 180.0
}

/// A horizontal angle in [0, 360) by the symmetry that the range of planes tells.
fn fold(angle: f32, first: f32, last: f32) -> f32 {
    match (first, last) {
        (0.0, 0.0) => 0.0,
        (0.0, 90.0) => {
            let half = if angle > 180.0 { 360.0 - angle } else { angle };
            if half > 90.0 { 180.0 - half } else { half }
        }
        (0.0, 180.0) if angle > 180.0 => 360.0 - angle,
        (90.0, 270.0) if angle < 90.0 => 180.0 - angle,
        (90.0, 270.0) if angle > 270.0 => 540.0 - angle,
        _ if angle < first => angle + 360.0,
        _ => angle,
    }
}

/// The entries about a value and the share of the second; `None` beyond the ends.
fn bracket(angles: &[f32], value: f32) -> Option<(usize, usize, f32)> {
    let next = angles.partition_point(|&a| a <= value);
    let low = next.checked_sub(1)?;
    let start = angles.get(low)?;
    match angles.get(next) {
        Some(end) => Some((low, next, (value - start) / (end - start))),
        None if value == *start => Some((low, low, 0.0)),
        None => None,
    }
}
