//! What denoisers and compositing ask for beside the light: albedo, normals, depth.

use crate::frame::Frame;
use crate::tile::VisiblePoints;
use crate::view::View;
use glam::Vec3;
use rayon::prelude::*;
use rrf_materials::Bsdf;
use rrf_trace::Tracer;

/// Depth where a camera ray meets nothing, as other programs write it.
const FAR: f32 = 1e10;

/// A layer of what the camera sees, light left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Auxiliary {
    /// Reflectance of the first surface: of metals their specular colour. Never black where light comes
    /// from, so that a picture can be divided by it: 1 where there are lamps, and where nothing is met.
    Albedo,
    /// Unit shading normal on the viewer's side, world frame; zero where nothing is met.
    Normal,
    /// Distance along the viewing direction \[m\]; 1e10 where nothing is met.
    Depth,
}

/// Adds layers to a frame of `view`, each the mean over a pixel's `aa` x `aa` camera rays; depth over
/// those of them that meet something.
pub fn add_auxiliary(
    tracer: &Tracer,
    view: &View,
    aa: u32,
    wanted: &[Auxiliary],
    frame: &mut Frame,
) {
    let aa = aa.max(1);
    let has = |layer| wanted.contains(&layer);
    if wanted.is_empty() {
        return;
    }
    let rows = (0..view.height).into_par_iter();
    let rows: Vec<Vec<Pixel>> = rows.map(|y| row(tracer, view, y, aa)).collect();
    let pixels = || rows.iter().flatten();
    let share = 1.0 / (aa * aa) as f32;
    if has(Auxiliary::Albedo) {
        frame.albedo = Some(pixels().map(|p| p.albedo * share).collect());
    }
    if has(Auxiliary::Normal) {
        frame.normal = Some(pixels().map(|p| p.normal * share).collect());
    }
    if has(Auxiliary::Depth) {
        let depth = |p: &Pixel| match p.hits {
            0 => FAR,
            hits => p.depth / hits as f32,
        };
        frame.depth = Some(pixels().map(depth).collect());
    }
}

/// Sums over a pixel's camera rays.
#[derive(Clone, Copy, Default)]
struct Pixel {
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    hits: u32,
}

fn row(tracer: &Tracer, view: &View, y: u32, aa: u32) -> Vec<Pixel> {
    let seen = VisiblePoints::of_row(tracer, view, y, aa);
    let mut pixels = vec![Pixel::default(); view.width as usize];
    for (i, &pixel) in seen.pixel.iter().enumerate() {
        let sum = &mut pixels[pixel as usize];
        sum.albedo += albedo(&seen.materials[i]);
        sum.normal += seen.normals[i];
        sum.depth += (seen.points[i].position - view.eye).dot(view.forward);
        sum.hits += 1;
    }
    for &(pixel, _) in &seen.missed {
        pixels[pixel as usize].albedo += Vec3::ONE;
    }
    pixels
}

/// Reflectance by which a denoiser divides.
fn albedo(material: &Bsdf) -> Vec3 {
    if material.is_black() {
        return Vec3::ONE;
    }
    let lobe = (material.kind.lobe)(material).map_or(0.0, |lobe| lobe.reflectance);
    match material.base_color == Vec3::ZERO {
        true => Vec3::splat(lobe),
        false => material.base_color,
    }
}
