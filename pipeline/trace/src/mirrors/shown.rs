//! How much of a light each mirror shows, for all mirrors at once.

use super::image::{Mirror, Shown};
use glam::Vec3;
use multiversion::multiversion;

/// Mirrors at the most: each is asked at every vertex.
pub(super) const MOST: usize = 16;
/// Of a mirror whose image lies beside it: the lobe's share below which it is left out.
const LEAST_SHARE: f32 = 0.01;
/// Height over a plane, relative to the distance to the image, below which a point lies on it.
const CLEAR: f32 = 1e-4;

/// One number a mirror.
pub(super) type Each = [f32; MOST];

/// Geometry of all mirrors side by side, to find how much of a light's image each shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Frames {
    normal: [Each; 3],
    offset: Each,
    axes: [[Each; 3]; 2],
    low: [Each; 2],
    high: [Each; 2],
    /// 1 / alpha².
    sharpness: Each,
    /// Zero past the last mirror.
    reflectance: Each,
}

/// How much of the image of `l` each mirror shows `x`, in proportion: the mirror's reflectance
/// over the squared distance, times what the lobe leaves where the image lies beside the mirror;
/// zero where that is too little or the two are not on one side, clear of the plane.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(super) fn weights(frames: &Frames, x: Vec3, l: Shown) -> Each {
    let mut weights = [0.0; MOST];
    for (i, weight) in weights.iter_mut().enumerate() {
        let along =
            |axis: &[Each; 3], p: Vec3| axis[0][i] * p.x + axis[1][i] * p.y + axis[2][i] * p.z;
        let a = along(&frames.normal, x) - frames.offset[i];
        let b = along(&frames.normal, l.at) - l.w * frames.offset[i];
        let height = l.w * a + b;
        let (mut to_rectangle, mut apart) = ([0.0; 2], [0.0; 2]);
        for axis in 0..2 {
            let from = along(&frames.axes[axis], x);
            apart[axis] = along(&frames.axes[axis], l.at) - l.w * from;
            let center = from + apart[axis] * (a / height);
            let nearest = center.max(frames.low[axis][i]).min(frames.high[axis][i]);
            to_rectangle[axis] = nearest - center;
        }
        let apart2 = apart[0] * apart[0] + apart[1] * apart[1];
        let distance2 = apart2 + height * height;
        let dot = to_rectangle[0] * apart[0] + to_rectangle[1] * apart[1];
        let cross = to_rectangle[0] * apart[1] - to_rectangle[1] * apart[0];
        let cos2 = height * height / distance2;
        let k = height / (2.0 * a * b);
        let tiny = f32::MIN_POSITIVE;
        let slope2 = k * k * (cos2 * cos2 * dot * dot + cross * cross) / (apart2 + tiny);
        // straight above, the plane of incidence may be any
        let beside2 = to_rectangle[0] * to_rectangle[0] + to_rectangle[1] * to_rectangle[1];
        let slope2 = if apart2 > tiny {
            slope2
        } else {
            k * k * beside2
        };
        let spread = 1.0 + slope2 * frames.sharpness[i];
        let share = 1.0 / (spread * spread);
        let clear = CLEAR * CLEAR * distance2;
        let off = (a * a > clear * l.w) & (b * b > clear);
        let shown = (a * b > 0.0) & off & (share >= LEAST_SHARE);
        let full = share * frames.reflectance[i] / distance2;
        *weight = if shown { full } else { 0.0 };
    }
    weights
}

/// In halves, so that no addition waits for all before it.
pub(super) fn sum(weights: &Each) -> f32 {
    let mut sums = *weights;
    let mut half = MOST / 2;
    while half > 0 {
        let (low, high) = sums.split_at_mut(half);
        low.iter_mut().zip(high).for_each(|(a, b)| *a += *b);
        half /= 2;
    }
    sums[0]
}

impl Frames {
    pub(super) fn new(mirrors: &[Mirror]) -> Frames {
        let mut frames = Frames::default();
        for (i, mirror) in mirrors.iter().enumerate().take(MOST) {
            for axis in 0..3 {
                frames.normal[axis][i] = mirror.normal[axis];
                frames.axes[0][axis][i] = mirror.axes[0][axis];
                frames.axes[1][axis][i] = mirror.axes[1][axis];
            }
            for axis in 0..2 {
                frames.low[axis][i] = mirror.low[axis];
                frames.high[axis][i] = mirror.high[axis];
            }
            frames.offset[i] = mirror.offset;
            frames.sharpness[i] = 1.0 / (mirror.alpha * mirror.alpha);
            frames.reflectance[i] = mirror.reflectance;
        }
        frames
    }
}
