//! From what was typed to a view and its lights; the scene's own are the defaults.

use crate::args::CameraArgs;
use crate::failure::BadInput;
use glam::Vec3;
use rrf_render::{Lights, View};
use rrf_scene::{PointLight, Scene};

/// The view typed, over the scene's first camera.
pub fn view(args: &CameraArgs, scene: &Scene) -> Result<View, BadInput> {
    let camera = scene.cameras.first();
    let mut view = match (args.eye, args.look_at, camera) {
        (Some(eye), Some(target), _) => {
            look_at(args, eye.into(), target.into(), camera.map(|c| c.fov))?
        }
        (Some(_), None, _) => return Err(BadInput("--eye needs --look-at".into())),
        (None, _, Some(camera)) => View::from(camera),
        (None, _, None) => {
            return Err(BadInput(
                "the scene has no camera: give --eye x,y,z --look-at x,y,z --fov DEG --size WxH"
                    .into(),
            ));
        }
    };
    if let Some(fov) = args.fov {
        view.fov = fov;
    }
    if let Some([width, height]) = args.size {
        (view.width, view.height) = (width, height);
    }
    if !(view.fov > 0.0 && view.fov < 180.0) {
        return Err(BadInput(format!(
            "--fov {}: has to lie between 0 and 180 degrees",
            view.fov
        )));
    }
    Ok(view)
}

fn look_at(args: &CameraArgs, eye: Vec3, target: Vec3, fov: Option<f32>) -> Result<View, BadInput> {
    let up = Vec3::from(args.up.unwrap_or([0.0, 1.0, 0.0]));
    let forward = target - eye;
    if forward.length() == 0.0 || forward.normalize().cross(up.normalize_or_zero()).length() < 1e-6
    {
        return Err(BadInput(format!(
            "--eye {eye} --look-at {target} --up {up}: the view has no direction, or up lies along it"
        )));
    }
    let fov = args.fov.or(fov).unwrap_or(40.0);
    let mut view = View::look_at(eye, target, up, fov, args.size.unwrap_or([512, 512]));
    if args.mirror {
        view.right = -view.right;
    }
    Ok(view)
}

/// The lights typed, or the scene's own.
pub fn lights(args: &CameraArgs, scene: &Scene) -> Result<Lights, BadInput> {
    let typed = args.light.iter().map(|l| PointLight {
        position: Vec3::new(l[0], l[1], l[2]),
        intensity: Vec3::new(l[3], l[4], l[5]),
    });
    if args.light.is_empty() || args.scene_lights {
        if scene.point_lights.is_empty() && scene.area_lights.is_empty() {
            return Err(BadInput(
                "the scene has no light: give --light x,y,z[,r,g,b]".into(),
            ));
        }
        return Ok(Lights {
            points: scene.point_lights.iter().copied().chain(typed).collect(),
            area: true,
        });
    }
    Ok(Lights {
        points: typed.collect(),
        area: false,
    })
}
