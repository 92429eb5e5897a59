//! CIE colour spaces, D65, and colour differences.

use glam::{DMat3, DVec3};

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

/// CIELAB (L*, a*, b*) of XYZ under D65 (CIE 15:2004, eq. 8.3 to 8.11).
pub fn lab(xyz: DVec3) -> DVec3 {
    const LIMIT: f64 = 216.0 / 24_389.0; // (6/29)^3
    let f = |t: f64| {
        if t > LIMIT {
            t.cbrt()
        } else {
            (841.0 / 108.0) * t + 4.0 / 29.0
        }
    };
    let t = xyz / white();
    let (x, y, z) = (f(t.x), f(t.y), f(t.z));
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// ΔE*ab of 1976: the Euclidean distance in CIELAB.
pub fn delta_e_ab(a: DVec3, b: DVec3) -> f64 {
    a.distance(b)
}

/// ΔE00, CIEDE2000 with unit weights; numbered as in Sharma, Wu, Dalal 2005.
pub fn delta_e_2000(lab1: DVec3, lab2: DVec3) -> f64 {
    let power7 = |c: f64| {
        let c7 = c.powi(7);
        (c7 / (c7 + 25f64.powi(7))).sqrt()
    };
    // Eq. 2 to 7: chroma raised near grey, hue angle.
    let mean_c = (lab1.y.hypot(lab1.z) + lab2.y.hypot(lab2.z)) / 2.0;
    let g = 0.5 * (1.0 - power7(mean_c));
    let polar = |lab: DVec3| {
        let a = (1.0 + g) * lab.y;
        let hue = if a == 0.0 && lab.z == 0.0 {
            0.0
        } else {
            lab.z.atan2(a).to_degrees().rem_euclid(360.0)
        };
        (a.hypot(lab.z), hue)
    };
    let ((c1, h1), (c2, h2)) = (polar(lab1), polar(lab2));
    let grey = c1 * c2 == 0.0;
    // Eq. 8 to 11: differences.
    let (dl, dc) = (lab2.x - lab1.x, c2 - c1);
    let dh = match h2 - h1 {
        _ if grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let dh = 2.0 * (c1 * c2).sqrt() * (dh / 2.0).to_radians().sin();
    // Eq. 12 to 14: means.
    let (l, c) = ((lab1.x + lab2.x) / 2.0, (c1 + c2) / 2.0);
    let h = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => sum / 2.0,
        sum if sum < 360.0 => (sum + 360.0) / 2.0,
        sum => (sum - 360.0) / 2.0,
    };
    // Eq. 15 to 21: weights.
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0)
        - 0.20 * cos(4.0 * h - 63.0);
    let rotation = 30.0 * (-((h - 275.0) / 25.0).powi(2)).exp();
    let l50 = (l - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * l50 / (20.0 + l50).sqrt();
    let s_c = 1.0 + 0.045 * c;
    let s_h = 1.0 + 0.015 * c * t;
    let r_t = -(2.0 * rotation).to_radians().sin() * 2.0 * power7(c);
    // Eq. 22.
    let (l, c, h) = (dl / s_l, dc / s_c, dh / s_h);
    (l * l + c * c + h * h + r_t * c * h).max(0.0).sqrt()
}
