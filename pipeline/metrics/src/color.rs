//! Luminance, CIE colour spaces under D65, and colour differences.

use glam::{DMat3, DVec3, Vec3};
use palette::color_difference::Ciede2000;
use palette::convert::FromColorUnclamped;
use palette::num::Real;
use palette::white_point::{Any, WhitePoint};
use palette::{Lab, Xyz};

/// Luminance of linear Rec. 709 RGB (CIE Y). It serves tone mapping; errors are relative to
/// [`channel_mean`](crate::channel_mean).
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Linear Rec. 709 (sRGB) to CIE XYZ, rows X, Y, Z: solved from the primaries
/// (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) and the white (0.3127, 0.3290) of IEC 61966-2-1.
const XYZ: [[f64; 3]; 3] = [
    [
        0.412_390_799_265_959_5,
        0.357_584_339_383_877_96,
        0.180_480_788_401_834_3,
    ],
    [
        0.212_639_005_871_510_36,
        0.715_168_678_767_756,
        0.072_192_315_360_733_71,
    ],
    [
        0.019_330_818_715_591_85,
        0.119_194_779_794_626,
        0.950_532_152_249_660_6,
    ],
];

/// XYZ of linear Rec. 709 RGB; Y of white is 1.
pub fn xyz(rgb: DVec3) -> DVec3 {
    DVec3::from_array(XYZ.map(|row| DVec3::from_array(row).dot(rgb)))
}

/// XYZ of D65 white, RGB (1, 1, 1).
pub fn white() -> DVec3 {
    xyz(DVec3::ONE)
}

/// The matrix from XYZ to linear Rec. 709 RGB.
pub fn xyz_to_rgb() -> DMat3 {
    let [x, y, z] = XYZ.map(DVec3::from_array);
    DMat3::from_cols(x, y, z).transpose().inverse()
}

/// White of an sRGB display: D65 by its chromaticity, not rounded as in `palette`'s own.
struct DisplayWhite;

impl<T: Real> WhitePoint<T> for DisplayWhite {
    fn get_xyz() -> Xyz<Any, T> {
        let [x, y, z] = white().to_array().map(T::from_f64);
        Xyz::new(x, y, z)
    }
}

/// CIELAB (L*, a*, b*) of XYZ under D65 (CIE 15:2004, eq. 8.3 to 8.11).
pub fn lab(xyz: DVec3) -> DVec3 {
    let xyz = Xyz::<DisplayWhite, f64>::new(xyz.x, xyz.y, xyz.z);
    let lab = Lab::from_color_unclamped(xyz);
    DVec3::new(lab.l, lab.a, lab.b)
}

/// ΔE*ab of 1976: the Euclidean distance in CIELAB.
pub fn delta_e_ab(a: DVec3, b: DVec3) -> f64 {
    a.distance(b)
}

/// ΔE00, CIEDE2000 with unit weights (Sharma, Wu, Dalal 2005).
pub fn delta_e_2000(a: DVec3, b: DVec3) -> f64 {
    let [a, b] = [a, b].map(|lab| Lab::<DisplayWhite, f64>::new(lab.x, lab.y, lab.z));
    a.difference(b)
}
