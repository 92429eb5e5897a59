//! The rows held out of training: 30 %, chosen by a hash of the row (Beale et al.: 70 % train, 30 % validate).

use rrf_sampling::hash::hash;

/// Whether the row with this index in the run is held out of training. Depends on the arguments alone,
/// so that a row stays on its side when its cell is extracted again, split or refined.
pub fn is_held_out(seed: u64, index: u64) -> bool {
    // compares a uniform 64-bit number with 0.3 of its range
    hash(seed, index) < (u64::MAX / 10) * 3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share is 30 % and does not follow the index: chi-square over 16 residue classes of
    /// the index, 15 degrees of freedom, 1e-6 significance (53.1).
    #[test]
    fn three_in_ten_whatever_the_index() {
        const N: u64 = 160_000;
        let mut held = [0u64; 16];
        (0..N)
            .filter(|&i| is_held_out(1, (5 << 32) + i))
            .for_each(|i| held[(i % 16) as usize] += 1);
        let per_class = N as f64 / 16.0;
        let variance = per_class * 0.3 * 0.7;
        let chi2: f64 = held
            .iter()
            .map(|&h| (h as f64 - 0.3 * per_class).powi(2) / variance)
            .sum();
        assert!(chi2 < 53.1, "chi2 = {chi2}, {held:?}");
    }
}
