//! Cameras, lights and pictures, as typed; the scene's own are the defaults.

use super::parse::{
    LightDim, LightMove, parse_dim, parse_light, parse_move, parse_size, parse_sun, parse_vec3,
};
use crate::failure::BadInput;
use clap::{Args, ValueEnum};
use glam::Vec3;
use rrf_bake::settings::parse::{number, positive};
use rrf_lights::{DistantLight, LightSource, OwnLight, sky_direction};
use rrf_metrics::tone::Exposure;
use rrf_render::{Auxiliary, Lights, View, position_text};
use rrf_scene::{PointLight, Scene};
use rrf_store::points::SUN;
use std::borrow::Cow;

/// A camera and lights; what is not given comes from the scene.
#[derive(Args, Clone, Debug)]
pub struct CameraArgs {
    /// Eye position.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub eye: Option<[f32; 3]>,
    /// Point that the camera looks at.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<[f32; 3]>,
    /// Up direction.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub up: Option<[f32; 3]>,
    /// Turn image left and right around, as left-handed scenes' own cameras do.
    #[arg(long, requires = "eye")]
    pub mirror: bool,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    pub fov: Option<f32>,
    /// Picture size in pixels; by default the scene camera's, with --eye 512x512.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// A point light: position and radiant intensity [W/sr] (again for more).
    #[arg(long, value_name = "x,y,z[,r,g,b]", value_parser = parse_light, allow_hyphen_values = true)]
    pub light: Vec<[f32; 6]>,
    /// A sun: azimuth from -z towards +x and elevation over the horizon [degrees], irradiance on a
    /// plane that faces it [W/m²], 1 where it is not given (again for more).
    #[arg(long, value_name = "AZ,EL[,R,G,B]", value_parser = parse_sun, allow_hyphen_values = true)]
    pub sun: Vec<[f32; 5]>,
    /// The scene's own lights shine beside those of --light and --sun.
    #[arg(long)]
    pub scene_lights: bool,
    /// One of the scene's own lights times a factor a channel, 0,0,0 to turn it off (again for
    /// more). `rrf scene` lists their names.
    #[arg(long, value_name = "NAME=R,G,B", value_parser = parse_dim)]
    pub dim: Vec<LightDim>,
    /// One of the scene's own lights moved: a point or spot, or the middle of a lamp's surface
    /// (again for more).
    #[arg(long = "move", value_name = "NAME:X,Y,Z", value_parser = parse_move)]
    pub moves: Vec<LightMove>,
    /// The scene's own lights: none of them, or as other options say.
    #[arg(long, value_enum, default_value_t = OwnLights::All, conflicts_with = "scene_lights")]
    pub own_lights: OwnLights,
}

/// Which of the scene's own lights shine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OwnLights {
    /// All, unless lights are typed in their place.
    All,
    /// None.
    None,
}

/// A view and the part of its light to show.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// Camera and lights.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Which part of the light the picture shows.
    #[arg(long, value_enum, default_value_t = Part::Full)]
    pub part: Part,
    /// Camera rays a pixel are N x N.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub aa: u32,
    /// Layers of what the camera sees, beside the light, in EXR files.
    #[arg(long, value_enum, value_name = "LAYER,...", value_delimiter = ',')]
    pub aov: Vec<Aov>,
    /// Exposure of the PNG in stops; by default chosen from the picture and printed.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = number)]
    pub exposure: Option<f32>,
}

/// A layer for denoisers and compositing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Aov {
    /// Reflectance, of metals their specular colour: albedo.R, albedo.G, albedo.B.
    Albedo,
    /// Shading normal, world frame: normal.X, normal.Y, normal.Z.
    Normal,
    /// Distance along the viewing direction in metres: Z.
    Depth,
}

/// Which part of the light a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// Direct and indirect.
    Full,
    /// Emission and light that arrives from the lights themselves.
    Direct,
    /// Light that arrives from other surfaces.
    Indirect,
}

/// Which cells are believed.
#[derive(Args, Clone, Debug)]
pub struct TrustArgs {
    /// Cells whose relative error on rows held out is above this, by more than two standard errors, are not trusted; cells of
    /// a transfer by the error that they state. 0.1 with --fallback trace leaves to the nets what they know within 10 %.
    #[arg(long, value_name = "ERROR", default_value_t = rrf_transfer::TRUST_ERROR, value_parser = positive)]
    pub trust_error: f32,
}

impl CameraArgs {
    /// The view typed, over the scene's first camera.
    pub fn view(&self, scene: &Scene) -> Result<View, BadInput> {
        let camera = scene.cameras.first();
        let mut view = match (self.eye, self.look_at, camera) {
            (Some(eye), Some(target), _) => self.look_at(eye, target, camera.map(|c| c.fov))?,
            (Some(_), None, _) => return Err(BadInput("--eye needs --look-at".into())),
            (None, _, Some(camera)) => View::from(camera),
            (None, _, None) => {
                return Err(BadInput(
                    "the scene has no camera; give --eye x,y,z --look-at x,y,z --fov DEG --size WxH"
                        .into(),
                ));
            }
        };
        view.fov = self.fov.unwrap_or(view.fov);
        if let Some([width, height]) = self.size {
            (view.width, view.height) = (width, height);
        }
        if !(view.fov > 0.0 && view.fov < 180.0) {
            let told = format!("--fov {}: has to lie between 0 and 180 degrees", view.fov);
            return Err(BadInput(told));
        }
        Ok(view)
    }

    fn look_at(&self, eye: [f32; 3], target: [f32; 3], fov: Option<f32>) -> Result<View, BadInput> {
        let up = Vec3::from(self.up.unwrap_or([0.0, 1.0, 0.0]));
        let (eye, target) = (Vec3::from(eye), Vec3::from(target));
        let forward = target - eye;
        let across = forward.normalize_or_zero().cross(up.normalize_or_zero());
        if across.length() < 1e-6 {
            let [eye, target, up] = [eye, target, up].map(position_text);
            return Err(BadInput(format!(
                "--eye {eye} --look-at {target} --up {up}: the view has no direction, or up lies along it"
            )));
        }
        let fov = fov.unwrap_or(40.0);
        let mut view = View::look_at(eye, target, up, fov, self.size.unwrap_or([512, 512]));
        if self.mirror {
            view.right = -view.right;
        }
        Ok(view)
    }

    /// Whether the scene's own lights shine.
    pub fn shows_own_lights(&self) -> bool {
        let typed = !self.light.is_empty() || !self.sun.is_empty();
        self.own_lights == OwnLights::All && (!typed || self.scene_lights)
    }

    /// The scene with its own lights dimmed and moved as typed.
    pub fn relit<'s>(&self, scene: &'s Scene) -> Result<Cow<'s, Scene>, BadInput> {
        if self.dim.is_empty() && self.moves.is_empty() {
            return Ok(Cow::Borrowed(scene));
        }
        if !self.shows_own_lights() {
            let told = "--dim and --move change the scene's own lights, which do not shine here: \
                        add --scene-lights, or leave --own-lights none out";
            return Err(BadInput(told.into()));
        }
        let mut scene = scene.clone();
        for LightDim { name, factor } in &self.dim {
            let done = scene.dim_light(name, Vec3::from(*factor));
            done.map_err(|error| BadInput(format!("--dim: {error}")))?;
        }
        for LightMove { name, to } in &self.moves {
            let done = scene.move_light(name, Vec3::from(*to));
            done.map_err(|error| BadInput(format!("--move: {error}")))?;
        }
        Ok(Cow::Owned(scene))
    }

    /// The lights typed, or the scene's own; `scene` is that of [`CameraArgs::relit`].
    pub fn lights(&self, scene: &Scene) -> Result<Lights, BadInput> {
        let own = self.shows_own_lights();
        let typed = !self.light.is_empty() || !self.sun.is_empty();
        if !(typed || own && scene.has_own_lights()) {
            let told = match own {
                true => "the scene has no light; give --light x,y,z[,r,g,b] or --sun az,el[,r,g,b]",
                false => "no light shines; give --light x,y,z[,r,g,b] or --sun az,el[,r,g,b]",
            };
            return Err(BadInput(told.into()));
        }
        let is_point = |light: &&OwnLight| matches!(light.source, LightSource::Point(_));
        // as with --own-lights none, lamps that are all dimmed to nothing are not there
        let lamps = scene.area_lights.as_slice();
        let dark = !lamps.is_empty() && lamps.iter().all(|lamp| lamp.radiance == Vec3::ZERO);
        let others = scene.lights.iter().filter(|light| own && !is_point(light));
        Ok(Lights {
            points: scene.points().filter(|_| own).chain(self.typed()).collect(),
            area: own && !dark,
            dims: Vec::new(),
            sources: others.cloned().chain(self.suns()).collect(),
        })
    }

    /// The point lights typed.
    pub fn typed(&self) -> impl Iterator<Item = PointLight> + '_ {
        self.light.iter().map(|&[x, y, z, r, g, b]| PointLight {
            position: Vec3::new(x, y, z),
            intensity: Vec3::new(r, g, b),
        })
    }

    /// The suns typed.
    pub fn suns(&self) -> impl Iterator<Item = OwnLight> + '_ {
        self.typed_suns().map(|sun| OwnLight {
            name: SUN.into(),
            source: sun.into(),
        })
    }

    /// The suns typed, without their name.
    pub fn typed_suns(&self) -> impl Iterator<Item = DistantLight> + '_ {
        self.sun.iter().map(|&[azimuth, elevation, r, g, b]| {
            let toward = sky_direction(f64::from(azimuth), f64::from(elevation));
            DistantLight::sun(toward, Vec3::new(r, g, b))
        })
    }
}

impl ViewArgs {
    /// The part of the light.
    pub fn part(&self) -> rrf_render::Part {
        match self.part {
            Part::Full => rrf_render::Part::Full,
            Part::Direct => rrf_render::Part::Direct,
            Part::Indirect => rrf_render::Part::Indirect,
        }
    }

    /// The layers typed.
    pub fn auxiliary(&self) -> Vec<Auxiliary> {
        let layer = |aov: &Aov| match aov {
            Aov::Albedo => Auxiliary::Albedo,
            Aov::Normal => Auxiliary::Normal,
            Aov::Depth => Auxiliary::Depth,
        };
        self.aov.iter().map(layer).collect()
    }

    /// The exposure typed.
    pub fn exposure(&self) -> Option<Exposure> {
        self.exposure.map(|ev| Exposure { ev })
    }
}
