//! Warnings about a view and its lights, before a frame is believed.

use glam::Vec3;
use rrf_trace::Tracer;

/// A light nearer to a surface than this share of the diagonal of the baked light box is badly learned
/// (docs/science/failure-map.md).
const NEAR_SURFACE: f32 = 0.025;

/// A light nearer to a surface than this share of the scene's size is on it.
const ON_SURFACE: f32 = 2e-5;

/// Something about a view and its lights that a user should know.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewWarning {
    /// The fact, its place, and the remedy.
    pub message: String,
    /// Whether a picture would show nothing that was meant.
    pub is_fatal: bool,
}

impl ViewWarning {
    fn new(is_fatal: bool, message: String) -> ViewWarning {
        ViewWarning { message, is_fatal }
    }
}

impl std::fmt::Display for ViewWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

/// Surroundings of views and lights: a scene, and the boxes that its nets were baked for.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The scene.
    pub tracer: &'a Tracer<'a>,
    /// Whether a free place is inside a solid.
    pub inside_solid: &'a (dyn Fn(Vec3) -> bool + Sync),
    /// Least and greatest corner of the baked light box.
    pub light_box: [Vec3; 2],
    /// Least and greatest corner of the box that eyes were expected in.
    pub eye_box: Option<[Vec3; 2]>,
}

impl Surroundings<'_> {
    /// Warnings of an eye and of point lights at `lights`.
    pub fn warnings(&self, eye: Vec3, lights: impl Iterator<Item = Vec3>) -> Vec<ViewWarning> {
        let mut warnings = Vec::new();
        let at = position_text(eye);
        if (self.inside_solid)(eye) {
            let told = format!("the eye at {at} is inside a solid; move it into free space");
            warnings.push(ViewWarning::new(true, told));
        }
        if let Some(eye_box) = self.eye_box.filter(|b| is_outside(b, eye)) {
            let told = format!(
                "the eye at {at} is outside the eye box {}; what cannot be seen from there was not \
                 sampled, so bake again with a larger --eye-box",
                box_text(eye_box)
            );
            warnings.push(ViewWarning::new(false, told));
        }
        for (number, light) in lights.enumerate() {
            self.warn_of_light(number, light, &mut warnings);
        }
        warnings
    }

    fn warn_of_light(&self, number: usize, light: Vec3, warnings: &mut Vec<ViewWarning>) {
        let [low, high] = self.light_box;
        let least = NEAR_SURFACE * low.distance(high);
        let name = format!("point light {number} at {}", position_text(light));
        if self.is_on_surface(light) {
            let told =
                format!("{name} lies on a surface; move it off by a thousandth of the scene");
            warnings.push(ViewWarning::new(true, told));
        } else if (self.inside_solid)(light) {
            let told = format!("{name} is inside a solid; move it out, or it lights nothing else");
            warnings.push(ViewWarning::new(true, told));
        } else if let Some(distance) = self.tracer.distance(light, least) {
            let told = format!(
                "{name} is {} from a surface; below {}, expect at least twice the usual error of \
                 the indirect light",
                tidy_number(distance),
                tidy_number(least)
            );
            warnings.push(ViewWarning::new(false, told));
        }
        if is_outside(&self.light_box, light) {
            let told = format!(
                "{name} is outside the baked light box {}; the nets were not trained there",
                box_text(self.light_box)
            );
            warnings.push(ViewWarning::new(false, told));
        }
    }

    fn is_on_surface(&self, place: Vec3) -> bool {
        let bounds = self.tracer.scene().bounds();
        let size = bounds.map_or(0.0, |b| {
            (Vec3::from(b.max) - Vec3::from(b.min)).max_element()
        });
        // of the triangles near by, `locate` prefers those that face along a given normal
        let near = Vec3::AXES.map(|axis| self.tracer.locate(place, axis));
        near.iter()
            .flatten()
            .any(|at| at.position.distance(place) <= ON_SURFACE * size)
    }
}

fn is_outside([low, high]: &[Vec3; 2], p: Vec3) -> bool {
    !(p.cmpge(*low) & p.cmple(*high)).all()
}

/// A position as it would be typed, to four significant digits.
pub fn position_text(p: Vec3) -> String {
    p.to_array().map(tidy_number).join(",")
}

fn box_text([low, high]: [Vec3; 2]) -> String {
    format!("{} to {}", position_text(low), position_text(high))
}

/// A number to four significant digits.
fn tidy_number(x: f32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.abs().to_string();
    }
    let unit = 10f64.powi(3 - x.abs().log10().floor() as i32);
    ((f64::from(x) * unit).round() / unit).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (-2.800_000_2, "-2.8"),
            (0.0, "0"),
            (-0.0, "0"),
            (0.043_301, "0.0433"),
            (12_345.6, "12350"),
            (f32::NAN, "NaN"),
        ];
        for (x, wanted) in cases {
            assert_eq!(tidy_number(x), wanted);
        }
    }
}
