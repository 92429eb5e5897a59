//! What a user should know of a view and its lights before a frame is believed.

use glam::Vec3;

/// Something about a view and its lights that a user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The eye is inside a solid: the frame shows its inner side.
    EyeInSolid {
        /// Position of the eye.
        eye: Vec3,
    },
    /// A light is inside a solid and lights nothing outside.
    LightInSolid {
        /// Its place in the list.
        light: usize,
        /// Its position.
        position: Vec3,
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
            Notice::LightInSolid { light, position } => write!(
                f,
                "point light {light} at {position} is inside a solid: it lights nothing outside"
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

/// What a user should know of a view and its lights. `inside_solid` answers whether a free
/// place is inside a solid; `light_box` is the baked one, where nets are to be used.
pub fn notices(
    eye: Vec3,
    lights: impl Iterator<Item = Vec3>,
    light_box: Option<[Vec3; 2]>,
    inside_solid: impl Fn(Vec3) -> bool,
) -> Vec<Notice> {
    let mut notices = Vec::new();
    if inside_solid(eye) {
        notices.push(Notice::EyeInSolid { eye });
    }
    for (light, position) in lights.enumerate() {
        if inside_solid(position) {
            notices.push(Notice::LightInSolid { light, position });
        }
        let outside =
            |[low, high]: &[Vec3; 2]| !(position.cmpge(*low) & position.cmple(*high)).all();
        if let Some(light_box) = light_box.filter(outside) {
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
        let told = |eye: Vec3, light_box| {
            let notices = notices(eye, places.into_iter(), light_box, solid);
            let lines = notices.iter().map(|n| n.to_string());
            lines.collect::<Vec<_>>()
        };
        let lines = told(Vec3::new(20.0, 0.0, 0.0), Some(light_box));
        assert_eq!(lines.len(), 4, "{lines:?}");
        assert!(lines[0].starts_with("the eye at [20, 0, 0] is inside a solid"));
        assert!(lines[1].starts_with("point light 1 at [0, 2, 0] is outside the baked light box"));
        assert!(lines[2].starts_with("point light 2 at [11, 0, 0] is inside a solid"));
        assert!(lines[3].starts_with("point light 2 at [11, 0, 0] is outside"));
        assert_eq!(told(Vec3::ZERO, None).len(), 1);
    }
}
