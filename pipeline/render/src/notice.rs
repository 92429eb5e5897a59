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
        if let Some([low, high]) = light_box {
            if !(position.cmpge(low) & position.cmple(high)).all() {
                notices.push(Notice::LightOutsideBox {
                    light,
                    position,
                    light_box: [low, high],
                });
            }
        }
    }
    notices
}
