//! Questions of a page: a view, its lights, and the layer to show.

use glam::Vec3;
use rrf_lights::{DistantLight, sky_direction};
use rrf_render::{Lights, View};
use rrf_scene::{OwnLight, PointLight};
use serde::Deserialize;

/// Most pixels a side of a live picture.
pub const LARGEST_SIDE: u32 = 2048;
/// Most lights of a live picture.
pub const MOST_LIGHTS: usize = 64;

/// Most camera rays along a side of a live picture's pixel.
const MOST_SAMPLES: u32 = 8;

/// Name of the suns that a page adds, reserved for them.
const SUN: &str = "sun";

/// Layer that a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShownLayer {
    /// Direct and indirect light.
    #[default]
    Full,
    /// Light straight from the lights.
    Direct,
    /// Light from other surfaces: the nets.
    Indirect,
    /// Which net lit each pixel.
    Cells,
    /// Places for which the nets were trained.
    Trust,
}

/// An own light that shines, and how it differs from the scene's.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnAsk {
    /// Its name.
    pub name: String,
    /// What its channels are multiplied with.
    pub dim: [f32; 3],
    /// Where it stands instead.
    #[serde(default)]
    pub position: Option<[f32; 3]>,
    /// Azimuth and elevation \[degrees\] of a sun instead.
    #[serde(default)]
    pub toward: Option<[f32; 2]>,
}

/// A question as it comes over the wire: positions in metres, world frame; `lights` are rows of
/// position and radiant intensity [W/sr].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ask {
    /// Comes back with the answer.
    #[serde(default)]
    pub id: u32,
    eye: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    forward: [f32; 3],
    fov: f32,
    size: [u32; 2],
    lights: Vec<[f32; 6]>,
    /// Azimuth, elevation \[degrees\] and irradiance [W/m²] of suns.
    #[serde(default)]
    suns: Vec<[f32; 5]>,
    /// The scene's own lights that shine.
    #[serde(default)]
    pub own: Vec<OwnAsk>,
    /// The layer to show.
    #[serde(default)]
    pub mode: ShownLayer,
    /// Exposure in stops; none to have it chosen from the picture.
    #[serde(default)]
    pub exposure: Option<f32>,
    /// Camera rays a pixel are `aa` x `aa`; more than 1 for a picture at rest, which is given up as soon
    /// as another question comes.
    #[serde(default = "one")]
    pub aa: u32,
    /// Whether cells are blended where they meet.
    #[serde(default)]
    pub blend: bool,
    /// A place in the picture, in pixels from the top left, whose surface point is wanted
    /// instead of a frame.
    #[serde(default)]
    pub pick: Option<[f32; 2]>,
}

fn one() -> u32 {
    1
}

impl Ask {
    /// A question that can be answered, or why it cannot.
    pub fn parse(text: &str) -> Result<Ask, String> {
        let ask: Ask = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let [width, height] = ask.size;
        if width > LARGEST_SIDE || height > LARGEST_SIDE {
            return Err(format!(
                "a live picture has at most {LARGEST_SIDE} pixels a side"
            ));
        }
        if ask.lights.len().max(ask.suns.len()) > MOST_LIGHTS {
            return Err(format!("a live picture has at most {MOST_LIGHTS} lights"));
        }
        if !(1..=MOST_SAMPLES).contains(&ask.aa) {
            return Err(format!(
                "a live picture has 1 to {MOST_SAMPLES} camera rays along each side of a pixel"
            ));
        }
        if ask.exposure.is_some_and(|ev| !ev.is_finite()) {
            return Err("the exposure is not finite".into());
        }
        ask.view().check().map_err(|e| e.to_string())?;
        let typed = Lights {
            points: ask.points().collect(),
            sources: ask.suns().collect(),
            ..Lights::default()
        };
        typed.check().map_err(|e| e.to_string())?;
        Ok(ask)
    }

    /// The view.
    pub fn view(&self) -> View {
        View {
            eye: self.eye.into(),
            right: self.right.into(),
            up: self.up.into(),
            forward: self.forward.into(),
            fov: self.fov,
            width: self.size[0],
            height: self.size[1],
        }
    }

    /// The point lights of the page itself.
    pub fn points(&self) -> impl Iterator<Item = PointLight> + '_ {
        self.lights.iter().map(|&[x, y, z, r, g, b]| PointLight {
            position: Vec3::new(x, y, z),
            intensity: Vec3::new(r, g, b),
        })
    }

    /// The suns of the page itself.
    pub fn suns(&self) -> impl Iterator<Item = OwnLight> + '_ {
        self.suns.iter().map(|&[azimuth, elevation, r, g, b]| {
            let toward = sky_direction(f64::from(azimuth), f64::from(elevation));
            OwnLight {
                name: SUN.into(),
                source: DistantLight::sun(toward, Vec3::new(r, g, b)).into(),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"eye":[0,0,0],"right":[1,0,0],"up":[0,1,0],"forward":[0,0,-1],
        "fov":40,"size":[64,48],"lights":[[0,1,0,1,1,1]],"mode":"cells"}"#;

    #[test]
    fn a_question_is_a_view_lights_and_a_mode() {
        let ask = Ask::parse(GOOD).unwrap();
        assert_eq!((ask.view().width, ask.view().height), (64, 48));
        assert_eq!(ask.points().next().unwrap().position, Vec3::Y);
        assert_eq!(
            (ask.mode, ask.exposure, ask.pick),
            (ShownLayer::Cells, None, None)
        );
    }

    #[test]
    fn what_cannot_be_shown_is_refused() {
        let bad = [
            ("\"size\":[64,48]", "\"size\":[0,48]"),
            ("\"size\":[64,48]", "\"size\":[64,4096]"),
            ("\"forward\":[0,0,-1]", "\"forward\":[0,0,0]"),
            ("\"fov\":40", "\"fov\":180"),
            ("\"fov\":40", "\"fov\":1e999"),
            ("[0,1,0,1,1,1]", "[0,1,0,1,1]"),
            ("[0,1,0,1,1,1]", "[0,1e39,0,1,1,1]"),
            ("\"mode\":\"cells\"", "\"mode\":\"x\""),
            ("\"mode\":\"cells\"", "\"file\":\"/etc/passwd\""),
            ("\"mode\":\"cells\"", "\"exposure\":1e39"),
            ("\"mode\":\"cells\"", "\"aa\":0"),
            ("\"mode\":\"cells\"", "\"aa\":9"),
        ];
        for (good, bad) in bad {
            let text = GOOD.replace(good, bad);
            assert!(text != GOOD && Ask::parse(&text).is_err(), "{bad}");
        }
        let many = vec!["[0,1,0,1,1,1]"; MOST_LIGHTS + 1].join(",");
        assert!(Ask::parse(&GOOD.replace("[0,1,0,1,1,1]", &many)).is_err());
    }
}
