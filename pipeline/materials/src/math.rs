//! Small functions without branches and without calls, so that loops over them vectorise and
//! every instruction set gives the same bits.

use glam::Vec3;
use std::f32::consts::TAU;

/// `a` where `condition` holds, else `b`.
#[inline(always)]
pub fn pick(condition: bool, a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        if condition { a.x } else { b.x },
        if condition { a.y } else { b.y },
        if condition { a.z } else { b.z },
    )
}

/// Sine and cosine of `turn` full turns, 0 <= turn < 1, within 2e-7.
///
/// Reduced to an eighth of a turn about the nearest quarter; Taylor polynomials to degree 9
/// and 8 there (remainders below 2e-9 and 3e-8).
#[inline(always)]
pub fn sin_cos_turn(turn: f32) -> (f32, f32) {
    let quarter = (4.0 * turn + 0.5) as i32;
    let x = (turn - 0.25 * quarter as f32) * TAU;
    let x2 = x * x;
    let sine = x
        * (1.0
            - x2 * (1.0 / 6.0)
                * (1.0
                    - x2 * (1.0 / 20.0) * (1.0 - x2 * (1.0 / 42.0) * (1.0 - x2 * (1.0 / 72.0)))));
    let cosine = 1.0
        - x2 * 0.5
            * (1.0 - x2 * (1.0 / 12.0) * (1.0 - x2 * (1.0 / 30.0) * (1.0 - x2 * (1.0 / 56.0))));
    let swap = quarter & 1 == 1;
    let (s, c) = (
        if swap { cosine } else { sine },
        if swap { sine } else { cosine },
    );
    let s = if quarter & 2 == 2 { -s } else { s };
    let c = if (quarter + 1) & 2 == 2 { -c } else { c };
    (s, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_agree_with_f64() {
        for i in 0..65_536u32 {
            let turn = i as f32 / 65_536.0;
            let (sine, cosine) = sin_cos_turn(turn);
            let (s, c) = (std::f64::consts::TAU * f64::from(turn)).sin_cos();
            assert!((f64::from(sine) - s).abs() < 2e-7, "sin of {turn} turns");
            assert!((f64::from(cosine) - c).abs() < 2e-7, "cos of {turn} turns");
        }
    }
}
