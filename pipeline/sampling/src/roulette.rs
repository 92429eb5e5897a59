//! The end of paths that nothing absorbs.

/// Reflections after which a path's chance to go on falls, whatever the surfaces do.
const LONGEST: u32 = 128;

/// Chance to go on from then on, a reflection. The weight of a path that goes on grows by its inverse,
/// so that variance stays finite where surfaces reflect less than this share of the light.
const TAIL: f32 = 0.995;

/// Factor on the chance with which a path goes on after `bounce` reflections. Russian roulette by
/// throughput alone never ends a path between surfaces that absorb nothing; this does, without
/// bias, and changes nothing about shorter paths.
pub fn roulette_tail(bounce: u32) -> f32 {
    TAIL.powi(bounce.saturating_sub(LONGEST).min(10_000) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_paths_are_shortened() {
        assert!((0..=LONGEST).all(|bounce| roulette_tail(bounce) == 1.0));
        assert!((roulette_tail(LONGEST + 2) - 0.990_025).abs() < 1e-6);
        assert!(roulette_tail(u32::MAX) >= 0.0);
    }
}
