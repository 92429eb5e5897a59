//! Direct light of a scene's own lights in frames: whether rays that learn are unbiased, how near to
//! the bound their noise comes, and what they cost.
//!
//! ```text
//! cargo run --release -p rrf-render --example direct_noise -- SCENE [sky=FILE.exr] [size=96x64] [seeds=32] [rays=1024] [noise=0.01] [narrow=4] [fixed=64] [only=LIGHT] [ev=0] [worst=10] [picture=F.png]
//! ```
//!
//! `only` a light, or `lamps`, shines; `ev` is an exposure in place of the automatic one; `worst` pixels are told.
//! `fixed` shadow rays of each camera ray take the bound's place.
//! `narrow` rays of a pixel go into lobes that are narrow, but not as a mirror's.
//! Frames of `seeds` seeds go down to the bound, as `rrf render --part direct` does; as many more have
//! `rays` plain shadow rays each, which choose lights uniformly and learn nothing. Blocks of 8 x 8
//! pixels, and the whole, are compared by Welch's t, as z (Wallace 1959): the largest of all blocks may
//! pass by chance once in 1,000 such runs (Šidák), and so may the whole.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../tests/direct_light/dark.rs"]
mod dark;

use glam::Vec3;
use rrf_lights::{LightSource, OwnLight};
use rrf_metrics::color::luminance;
use rrf_metrics::tone::Exposure;
use rrf_render::{AreaLights, Frame, Lights, Part, RenderOptions, Renderer, ShadowRays, View, png};
use rrf_scene::{LoadOptions, SkyOption, SkySource, load};
use rrf_trace::Tracer;
use std::time::Instant;

/// Side of a block in pixels.
const BLOCK: usize = 8;
/// Chance that the largest of all z is beyond its bound.
const SIGNIFICANCE: f64 = 1e-3;

/// Mean and squared standard error of each column of independent rows.
fn moments(rows: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let n = rows.len() as f64;
    let columns = 0..rows[0].len();
    let of = |column: usize| {
        let mean = rows.iter().map(|row| row[column]).sum::<f64>() / n;
        let squares = rows.iter().map(|row| (row[column] - mean).powi(2));
        [mean, squares.sum::<f64>() / (n - 1.0) / n]
    };
    columns.map(of).collect()
}

/// Welch's t of two means as a normal z.
fn z([a, a_se2]: [f64; 2], [b, b_se2]: [f64; 2], count: usize) -> Option<f64> {
    let variance = a_se2 + b_se2;
    if variance <= 0.0 {
        return None;
    }
    let freedom = variance * variance * (count - 1) as f64 / (a_se2 * a_se2 + b_se2 * b_se2);
    let t = (a - b) / variance.sqrt();
    let size = (freedom * (t * t / freedom).ln_1p()).sqrt();
    Some(size.copysign(t) * (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0))
}

/// The two-sided bound on the largest of `count` normal z at [`SIGNIFICANCE`].
fn bound(count: usize) -> f64 {
    let chance = 0.5 * (1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / count as f64));
    // Hastings' approximation of the normal quantile, errs by less than 4.5e-4
    let t = (-2.0 * chance.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |key: &str| {
        let key = format!("{key}=");
        words.iter().find_map(|w| w.strip_prefix(&key))
    };
    let number = |key: &str, otherwise: f64| {
        word(key).map_or(otherwise, |value| value.parse().expect("a number"))
    };
    let options = LoadOptions {
        sky: word("sky").map(|file| SkyOption {
            source: match file {
                "constant" => SkySource::Constant([1.0; 3]),
                _ => SkySource::Picture(file.into()),
            },
            rotate: 0.0,
        }),
        ..LoadOptions::default()
    };
    let scene = load(words[0].as_ref(), &options).expect("a scene");
    let size = word("size").unwrap_or("96x64").split_once('x');
    let [width, height] = size.map_or([96, 64], |(w, h)| [w, h].map(|n| n.parse().unwrap()));
    let view = View {
        width,
        height,
        ..View::from(scene.cameras.first().expect("a camera"))
    };
    let tracer = Tracer::new(&scene).unwrap();
    let lamps = AreaLights::without_proxies(&scene);
    let is_point = |light: &&OwnLight| matches!(light.source, LightSource::Point(_));
    let is_asked = |name: &str| word("only").is_none_or(|only| only == name);
    let others = scene.lights.iter().filter(|light| !is_point(light));
    let sources = others.filter(|light| is_asked(&light.name));
    let lights = Lights {
        points: scene.points().collect(),
        area: !scene.area_lights.is_empty() && is_asked("lamps"),
        sources: sources.cloned().collect(),
        ..Lights::default()
    };
    let field = dark::field();
    let renderer = Renderer::new(&tracer, &field);
    let narrow_rays = number("narrow", 0.0) as u32;
    let render = |rays: Option<ShadowRays>, noise: Option<f32>, seed: u64| -> Vec<Vec3> {
        let options = RenderOptions {
            part: Part::Direct,
            area_lights: Some(&lamps),
            shadow_rays: rays,
            noise,
            seed,
            narrow_rays,
            ..RenderOptions::default()
        };
        let mut frame = Frame::default();
        renderer
            .render(&view, &lights, &options, &mut frame)
            .unwrap();
        frame.full
    };
    let ev = word("ev").map(|ev| ev.parse().expect("a number"));
    let mut small = Frame {
        width,
        height,
        full: render(None, None, 1),
        ..Frame::default()
    };
    let exposure = Exposure::automatic(&small.picture());
    let ev = ev.unwrap_or(exposure.ev);
    println!("exposure: {ev}");
    let noise = number("noise", 0.01) as f32 * (-ev).exp2();
    if let Some(file) = word("picture") {
        small.full = render(None, Some(noise), 1);
        let shown = png::tone_mapped(&small.picture(), exposure);
        shown.save(file).unwrap();
        return;
    }
    let seeds = number("seeds", 32.0) as u64;
    let plain = ShadowRays {
        count: number("rays", 1024.0) as u32,
        noise: None,
        adaptive: false,
    };
    // seeds that both share would leave their differences alike
    let frames = |rays: Option<ShadowRays>, noise: Option<f32>, first: u64| {
        let start = Instant::now();
        let frames = (first..first + seeds).map(|seed| {
            let pixels = render(rays, noise, seed);
            pixels.iter().map(|&p| f64::from(luminance(p))).collect()
        });
        let frames: Vec<Vec<f64>> = frames.collect();
        (frames, start.elapsed().as_secs_f64() / seeds as f64)
    };
    let fixed = word("fixed").map(|rays| ShadowRays {
        count: rays.parse().expect("a number"),
        ..ShadowRays::default()
    });
    let (learned, learned_s) = frames(fixed, Some(noise), 1);
    let (plain, plain_s) = frames(Some(plain), None, 1_000_000);

    let pixels = moments(&learned);
    let unit = f64::from(noise);
    let mut deviations: Vec<f64> = (pixels.iter())
        .map(|[_, se2]| (se2 * seeds as f64).sqrt() / unit)
        .collect();
    let rms = (deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64).sqrt();
    let worst = (0..deviations.len()).max_by(|&a, &b| deviations[a].total_cmp(&deviations[b]));
    let worst = worst.map_or([0, 0], |p| [p % width as usize, p / width as usize]);
    if let Some(count) = word("worst") {
        let mut order: Vec<usize> = (0..deviations.len()).collect();
        order.sort_by(|&a, &b| deviations[b].total_cmp(&deviations[a]));
        for &pixel in order.iter().take(count.parse().expect("a number")) {
            let place = [pixel % width as usize, pixel / width as usize];
            let [deviation, mean] = [deviations[pixel], pixels[pixel][0] / unit];
            println!("{place:?}: noise {deviation:.1}, light {mean:.1} bounds");
        }
    }
    deviations.sort_by(f64::total_cmp);
    let quantile = |q: f64| deviations[(q * (deviations.len() - 1) as f64) as usize];
    let far = |frame: &Vec<f64>| {
        let outliers = frame.iter().zip(&pixels);
        outliers
            .filter(|(x, [mean, _])| (*x - mean).abs() > 10.0 * unit)
            .count()
    };
    let outliers: usize = learned.iter().map(far).sum();
    println!(
        "noise over the bound: root mean square {rms:.2}, median {:.2}, 99 % {:.2}, largest {:.1} at {worst:?}",
        quantile(0.5),
        quantile(0.99),
        quantile(1.0)
    );
    println!(
        "pixels off by more than ten bounds: {:.1} of {} in a frame",
        outliers as f64 / seeds as f64,
        pixels.len()
    );
    println!("seconds a frame: {learned_s:.3}, plain {plain_s:.3}");

    let blocks = |frames: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let across = (width as usize).div_ceil(BLOCK);
        let down = (height as usize).div_ceil(BLOCK);
        let of = |frame: &Vec<f64>| {
            let mut sums = vec![0.0; across * down];
            for (pixel, x) in frame.iter().enumerate() {
                let (column, row) = (pixel % width as usize, pixel / width as usize);
                sums[row / BLOCK * across + column / BLOCK] += x;
            }
            sums
        };
        frames.iter().map(of).collect()
    };
    let whole = |frames: &[Vec<f64>]| -> Vec<Vec<f64>> {
        frames
            .iter()
            .map(|frame| vec![frame.iter().sum()])
            .collect()
    };
    let compare = |name: &str, some: &[Vec<f64>], others: &[Vec<f64>]| {
        let pairs = moments(some).into_iter().zip(moments(others));
        let all: Vec<f64> = pairs.filter_map(|(a, b)| z(a, b, seeds as usize)).collect();
        let largest = all.iter().fold(0.0f64, |most, z| most.max(z.abs()));
        let squares = all.iter().map(|z| z * z).sum::<f64>() / all.len() as f64;
        let bound = bound(all.len());
        println!(
            "{name}: {} z, mean square {squares:.2}, largest {largest:.2} (bound {bound:.2})",
            all.len()
        );
        largest < bound
    };
    let passes = [
        compare("blocks", &blocks(&learned), &blocks(&plain)),
        compare("whole", &whole(&learned), &whole(&plain)),
    ];
    if passes != [true; 2] {
        println!("biased");
        std::process::exit(1);
    }
}
