//! What a user should know of a view and its lights before a frame is believed.

use glam::Vec3;
use rrf_trace::Tracer;

/// Something about a view and its lights that a user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The eye is inside a solid: the frame shows its inner side.
    EyeInSolid {
        /// Position of the eye.
        eye: Vec3,
    },
    /// The eye is where none was expected: what it sees may have had no samples.
    EyeOutsideBox {
        /// Position of the eye.
        eye: Vec3,
        /// Least and greatest corner of the box that eyes were expected in.
        eye_box: [Vec3; 2],
    },
    /// A light is inside a solid and lights nothing outside.
    LightInSolid {
        /// Its place in the list.
        light: usize,
        /// Its position.
        position: Vec3,
    },
    /// A light is on a surface, which has no front for it.
    LightOnSurface {
        /// Its place in the list.
        light: usize,
        /// Its position.
        position: Vec3,
    },
    /// A light makes a spot on a surface that no net of a few thousand rows follows.
    LightNearSurface {
        /// Its place in the list.
        light: usize,
        /// Its position.
        position: Vec3,
        /// How near it is.
        distance: f32,
        /// How near is too near.
        least: f32,
    },
    /// A light is where no net was trained.
    LightOutsideBox {
        /// Its place in the list.
        light: usize,
        /// Its position.
        position: Vec3,
        /// Least and greatest corner of the baked light box.
        light_box: [Vec3; 2],
    },
}

impl std::fmt::Display for Notice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Notice::EyeInSolid { eye } => write!(
                f,
                "the eye at {eye} is inside a solid: the frame shows its inner side"
            ),
            Notice::EyeOutsideBox {
                eye,
                eye_box: [low, high],
            } => write!(
                f,
                "the eye at {eye} is outside the box {low} to {high} that the bake expected eyes in: \
                 what is not seen from there had no samples"
            ),
            Notice::LightInSolid { light, position } => write!(
                f,
                "point light {light} at {position} is inside a solid: it lights nothing outside"
            ),
            Notice::LightOnSurface { light, position } => write!(
                f,
                "point light {light} at {position} lies on a surface: move it off by a \
                 thousandth of the scene's size"
            ),
            Notice::LightNearSurface {
                light,
                position,
                distance,
                least,
            } => write!(
                f,
                "point light {light} at {position} is {distance:.3} from a surface, nearer than \
                 {least:.3}: expect twice the usual error of the indirect light, and more the nearer it is"
            ),
            Notice::LightOutsideBox {
                light,
                position,
                light_box: [low, high],
            } => write!(
                f,
                "point light {light} at {position} is outside the baked light box {low} to \
                 {high}: the nets were not trained there"
            ),
        }
    }
}

impl Notice {
    /// Whether a picture would show nothing that was meant.
    pub fn is_fatal(&self) -> bool {
        !matches!(
            self,
            Notice::LightOutsideBox { .. }
                | Notice::LightNearSurface { .. }
                | Notice::EyeOutsideBox { .. }
        )
    }
}

/// A light nearer to a surface than this share of the diagonal of the baked light box is badly learned
/// (docs/failure-map.md).
const NEAR_SURFACE: f32 = 0.025;

/// A light nearer to a surface than this share of the scene's size is on it.
const ON_SURFACE: f32 = 2e-5;

/// Whether a place lies on a surface.
pub fn on_surface(tracer: &Tracer, place: Vec3) -> bool {
    let size = tracer.scene().bounds().map_or(0.0, |b| {
        (Vec3::from(b.max) - Vec3::from(b.min)).max_element()
    });
    // of the triangles near by, `locate` prefers those that face along a given normal
    let near = Vec3::AXES.map(|axis| tracer.locate(place, axis));
    near.iter()
        .flatten()
        .any(|at| at.position.distance(place) <= ON_SURFACE * size)
}

/// What a user should know of a view and its lights. `inside_solid` answers whether a free
/// place is inside a solid, `on_surface` whether one is no free place, `distance` how far the nearest
/// surface is if that is within a reach; `light_box` is the baked one, where nets are to be used, `eye_box`
/// the one that eyes were expected in.
pub fn notices(
    eye: Vec3,
    lights: impl Iterator<Item = Vec3>,
    light_box: Option<[Vec3; 2]>,
    eye_box: Option<[Vec3; 2]>,
    inside_solid: impl Fn(Vec3) -> bool,
    on_surface: impl Fn(Vec3) -> bool,
    distance: impl Fn(Vec3, f32) -> Option<f32>,
) -> Vec<Notice> {
    let mut notices = Vec::new();
    if inside_solid(eye) {
        notices.push(Notice::EyeInSolid { eye });
    }
    let outside = |[low, high]: &[Vec3; 2], p: Vec3| !(p.cmpge(*low) & p.cmple(*high)).all();
    if let Some(eye_box) = eye_box.filter(|b| outside(b, eye)) {
        notices.push(Notice::EyeOutsideBox { eye, eye_box });
    }
    for (light, position) in lights.enumerate() {
        if on_surface(position) {
            notices.push(Notice::LightOnSurface { light, position });
        } else if inside_solid(position) {
            notices.push(Notice::LightInSolid { light, position });
        } else if let Some([low, high]) = light_box {
            let least = NEAR_SURFACE * low.distance(high);
            notices.extend(
                distance(position, least).map(|distance| Notice::LightNearSurface {
                    light,
                    position,
                    distance,
                    least,
                }),
            );
        }
        if let Some(light_box) = light_box.filter(|b| outside(b, position)) {
            notices.push(Notice::LightOutsideBox {
                light,
                position,
                light_box,
            });
        }
    }
    notices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_odd_place_is_told_once() {
        let solid = |p: Vec3| p.x > 10.0;
        let places = [
            Vec3::ZERO,
            Vec3::new(0.0, 2.0, 0.0),
            Vec3::new(11.0, 0.0, 0.0),
        ];
        let light_box = [Vec3::splat(-1.0), Vec3::ONE];
        let told = |eye: Vec3, light_box: Option<[Vec3; 2]>| {
            let near = |p: Vec3, reach: f32| (p == Vec3::ZERO).then_some(0.5 * reach);
            let on = |p: Vec3| p.y == 2.0;
            let eye_box = light_box.map(|[low, high]| [low, Vec3::new(50.0, high.y, high.z)]);
            let notices = notices(eye, places.into_iter(), light_box, eye_box, solid, on, near);
            let lines = notices.iter().map(|n| n.to_string());
            lines.collect::<Vec<_>>()
        };
        let mut lines = told(Vec3::new(20.0, 0.0, 0.0), Some(light_box));
        assert_eq!(lines.len(), 6, "{lines:?}");
        let near = "point light 0 at [0, 0, 0] is 0.043 from a surface, nearer than 0.087";
        assert!(lines.remove(1).starts_with(near), "{lines:?}");
        let on = lines.remove(1);
        assert!(
            on.starts_with("point light 1 at [0, 2, 0] lies on a surface"),
            "{on}"
        );
        assert!(lines[0].starts_with("the eye at [20, 0, 0] is inside a solid"));
        assert!(lines[1].starts_with("point light 1 at [0, 2, 0] is outside the baked light box"));
        assert!(lines[2].starts_with("point light 2 at [11, 0, 0] is inside a solid"));
        assert!(lines[3].starts_with("point light 2 at [11, 0, 0] is outside"));
        assert_eq!(told(Vec3::ZERO, None).len(), 2);
        let lines = told(Vec3::new(0.0, 0.0, -3.0), Some(light_box));
        let eye = "the eye at [0, 0, -3] is outside the box [-1, -1, -1] to [50, 1, 1]";
        assert!(lines[0].starts_with(eye), "{lines:?}");
    }
}
