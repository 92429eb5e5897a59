//! Rooms, views and fields, and the difference of two sets of frames.

use glam::{Vec2, Vec3};
use rrf_field::Field;
use rrf_field::columns::{self};
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_render::{Frame, FrameTimings, Lights, RenderOptions, Renderer, View};
use rrf_scene::{AreaLight, INVALID, Material, PointLight, Scene};
use rrf_trace::Tracer;

pub const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);
pub const SILVER: Vec3 = Vec3::new(0.9, 0.85, 0.7);

/// A square in the plane z = `height`: its middle, half its side, and its material.
pub type Square = ([f32; 2], f32, f32, u32);

/// Horizontal squares; those of `lamps` shine downward.
pub fn squares(squares: &[Square], materials: Vec<Material>, lamps: &[(usize, Vec3)]) -> Scene {
    let mut scene = Scene {
        materials,
        ..Scene::default()
    };
    for (number, &([x, y], half, height, material)) in squares.iter().enumerate() {
        let first = scene.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corner = |(dx, dy)| Vec3::new(x + half * dx, y + half * dy, height);
        scene.positions.extend(corners.map(corner));
        // the normal of the second order looks down
        scene
            .triangles
            .extend([[0, 2, 1], [0, 3, 2]].map(|t: [u32; 3]| t.map(|v| first + v)));
        scene.triangle_material.extend([material; 2]);
        scene.triangle_object.extend([number as u32; 2]);
        let lamp = lamps.iter().find(|(of, _)| *of == number);
        let light = lamp.map_or(INVALID, |&(_, radiance)| {
            scene.area_lights.push(AreaLight {
                radiance,
                two_sided: false,
            });
            scene.area_lights.len() as u32 - 1
        });
        scene.triangle_light.extend([light; 2]);
    }
    scene.normals = vec![Vec3::ZERO; scene.positions.len()];
    scene.uvs = vec![Vec2::ZERO; scene.positions.len()];
    scene
}

pub fn metal(roughness: f32) -> Material {
    Material::principled("metal", SILVER, roughness, 1.0, 0.5)
}

/// A mirror at z = 0 under a Lambert ceiling at z = 2.
pub fn mirror_room() -> Scene {
    let materials = vec![metal(0.0), Material::lambert("ceiling", ALBEDO)];
    squares(
        &[([0.0; 2], 2.0, 0.0, 0), ([0.0; 2], 6.0, 2.0, 1)],
        materials,
        &[],
    )
}

/// A camera at height 1 that looks down at a slant.
pub fn slanting(size: [u32; 2]) -> View {
    View::look_at(
        Vec3::new(-0.8, 0.1, 1.0),
        Vec3::new(0.2, 0.0, 0.0),
        Vec3::Z,
        30.0,
        size,
    )
}

/// Φ = (1, p_x, l_x) for z < 1, (1, p_x, l_x + 1) above.
pub fn field() -> Field {
    let mut tree = Tree::single();
    tree.split(0, columns::P + 2, 1.0, 1);
    let model = |cell: u32| CellModel {
        cell,
        kind: Kind::Net,
        inputs: vec![columns::P as u8, columns::L as u8],
        input_offset: vec![0.0; 2],
        input_scale: vec![1.0; 2],
        shape: Shape { sizes: vec![2, 3] },
        weights: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, cell as f32, 0.0, 1.0],
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: false,
    };
    Field::new(tree, vec![model(0), model(1)]).unwrap()
}

pub fn point_light(position: [f32; 3]) -> PointLight {
    PointLight {
        position: position.into(),
        intensity: Vec3::new(1.0, 2.0, 3.0),
    }
}

pub fn frame_of(
    tracer: &Tracer,
    view: &View,
    lights: &Lights,
    options: &RenderOptions,
) -> (Frame, FrameTimings) {
    let field = field();
    let renderer = Renderer::new(tracer, &field).tracing_narrow(true);
    let mut frame = Frame::default();
    let timings = renderer.render(view, lights, options, &mut frame).unwrap();
    (frame, timings)
}

/// Schlick's Fresnel factor of a metal.
pub fn fresnel(cosine: f32) -> Vec3 {
    SILVER + (Vec3::ONE - SILVER) * (1.0 - cosine).powi(5)
}

/// Mean of three channels.
pub fn level(v: Vec3) -> f64 {
    f64::from(v.element_sum()) / 3.0
}

/// Difference of two means over its standard error; a thousandth of the mean is rounding.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    let statistics = |x: &[f64]| {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let squares = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        (mean, squares / (n * (n - 1.0)))
    };
    let ((a, va), (b, vb)) = (statistics(a), statistics(b));
    let rounding = 1e-3 * b;
    (a - b) / (va + vb + rounding * rounding).sqrt()
}
