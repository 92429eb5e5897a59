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

/// A camera as `rrf render` is told of one.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AskCamera {
    eye: [f32; 3],
    /// The point that it looks at.
    target: [f32; 3],
    up: [f32; 3],
    /// Whether left and right are turned around.
    mirror: bool,
}

/// How far a picture's shadow rays go on.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskNoise {
    /// Standard error of a pixel's direct light, as a share of white.
    share: f32,
    /// Exposure in stops that says what white is.
    exposure: f32,
}

/// A question as it comes over the wire: positions in metres, world frame; `lights` are rows of
/// position and radiant intensity [W/sr].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ask {
    /// Comes back with the answer.
    #[serde(default)]
    pub id: u32,
    /// None for the camera that the page starts with.
    #[serde(default)]
    camera: Option<AskCamera>,
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
    /// None for 16 shadow rays a camera ray.
    #[serde(default)]
    noise: Option<AskNoise>,
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
    /// A question that can be answered, or why it cannot; `start` is the view that the page starts with.
    pub fn parse(text: &str, start: &View) -> Result<Ask, String> {
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
        if let Some(noise) = ask.noise
            && !(noise.share > 0.0 && noise.share.is_finite() && noise.exposure.is_finite())
        {
            return Err("the noise's share of white is not above zero".into());
        }
        ask.view(start).check().map_err(|e| e.to_string())?;
        let typed = Lights {
            points: ask.points().collect(),
            sources: ask.suns().collect(),
            ..Lights::default()
        };
        typed.check().map_err(|e| e.to_string())?;
        Ok(ask)
    }

    /// The view, as `rrf render` makes it of the same numbers; `start` is the one that the page starts with.
    pub fn view(&self, start: &View) -> View {
        let (fov, size) = (self.fov, self.size);
        let Some(camera) = self.camera else {
            return View {
                fov,
                width: size[0],
                height: size[1],
                ..start.clone()
            };
        };
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(Vec3::from);
        let mut view = View::look_at(eye, target, up, fov, size);
        if camera.mirror {
            view.right = -view.right;
        }
        view
    }

    /// Bound on the standard error of direct light [W/(sr m²)], by the formula of `rrf render --noise`.
    pub fn noise(&self) -> Option<f32> {
        self.noise
            .map(|noise| noise.share * (-noise.exposure).exp2())
    }

    /// That bound as a share of white.
    pub fn noise_share(&self) -> Option<f32> {
        self.noise.map(|noise| noise.share)
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

    const GOOD: &str = r#"{"camera":{"eye":[0,0,0],"target":[0,0,-1],"up":[0,1,0],"mirror":true},
        "fov":40,"size":[64,48],"lights":[[0,1,0,1,1,1]],"mode":"cells"}"#;

    fn start() -> View {
        View::look_at(Vec3::Y, Vec3::ZERO, Vec3::X, 30.0, [512, 512])
    }

    #[test]
    fn a_question_is_a_view_lights_and_a_mode() {
        let ask = Ask::parse(GOOD, &start()).unwrap();
        let view = ask.view(&start());
        assert_eq!((view.width, view.height), (64, 48));
        assert_eq!((view.right, view.up), (Vec3::NEG_X, Vec3::Y));
        assert_eq!(ask.points().next().unwrap().position, Vec3::Y);
        assert_eq!(
            (ask.mode, ask.exposure, ask.pick),
            (ShownLayer::Cells, None, None)
        );
        let ask = Ask::parse(r#"{"fov":40,"size":[64,48],"lights":[]}"#, &start()).unwrap();
        let expected = View {
            fov: 40.0,
            width: 64,
            height: 48,
            ..start()
        };
        assert_eq!(ask.view(&start()), expected);
    }

    #[test]
    fn what_cannot_be_shown_is_refused() {
        let bad = [
            ("\"size\":[64,48]", "\"size\":[0,48]"),
            ("\"size\":[64,48]", "\"size\":[64,4096]"),
            ("\"target\":[0,0,-1]", "\"target\":[0,0,0]"),
            ("\"target\":[0,0,-1]", "\"target\":[0,-1,0]"),
            ("\"fov\":40", "\"fov\":180"),
            ("\"fov\":40", "\"fov\":1e999"),
            ("[0,1,0,1,1,1]", "[0,1,0,1,1]"),
            ("[0,1,0,1,1,1]", "[0,1e39,0,1,1,1]"),
            ("\"mode\":\"cells\"", "\"mode\":\"x\""),
            ("\"mode\":\"cells\"", "\"file\":\"/etc/passwd\""),
            ("\"mode\":\"cells\"", "\"exposure\":1e39"),
            (
                "\"mode\":\"cells\"",
                "\"noise\":{\"share\":0,\"exposure\":0}",
            ),
            ("\"mode\":\"cells\"", "\"noise\":{\"share\":0.1}"),
            ("\"mode\":\"cells\"", "\"aa\":0"),
            ("\"mode\":\"cells\"", "\"aa\":9"),
        ];
        for (good, bad) in bad {
            let text = GOOD.replace(good, bad);
            assert!(
                text != GOOD && Ask::parse(&text, &start()).is_err(),
                "{bad}"
            );
        }
        let many = vec!["[0,1,0,1,1,1]"; MOST_LIGHTS + 1].join(",");
        assert!(Ask::parse(&GOOD.replace("[0,1,0,1,1,1]", &many), &start()).is_err());
    }
}
