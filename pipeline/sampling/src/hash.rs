//! Hashes of integers.

/// 2^64 over the golden ratio, odd.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A uniform 64-bit number from a seed and an index: the output function of SplitMix64 (Steele,
/// Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014).
#[inline]
pub fn hash(seed: u64, index: u64) -> u64 {
    split_mix(seed ^ index.wrapping_mul(GOLDEN))
}

/// Number `index`, from 0, of the SplitMix64 sequence of a seed.
#[inline]
pub(crate) fn split_mix_at(seed: u64, index: u64) -> u64 {
    split_mix(seed.wrapping_add((index + 1).wrapping_mul(GOLDEN)))
}

#[inline]
fn split_mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The seed of the Sobol sequence of a draw: the finalizer of MurmurHash3 (Appleby 2011).
pub fn sequence_seed(seed: u64, draw: u64) -> u64 {
    let mut z = seed ^ draw.wrapping_mul(GOLDEN);
    z = (z ^ (z >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z = (z ^ (z >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ (z >> 33)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First outputs of Java's `SplittableRandom` and Vigna's splitmix64.c for the seeds 0 and
    /// 1234567.
    #[test]
    fn known_answers() {
        let zero = [
            0xe220_a839_7b1d_cdaf,
            0x6e78_9e6a_a1b9_65f4,
            0x06c4_5d18_8009_454f,
        ];
        for (index, answer) in (0..).zip(zero) {
            assert_eq!(split_mix_at(0, index), answer);
            assert_eq!(hash(0, index + 1), answer);
        }
        assert_eq!(split_mix_at(1_234_567, 0), 6_457_827_717_110_365_317);
        assert_eq!(split_mix_at(1_234_567, 1), 3_203_168_211_198_807_973);
    }
}
