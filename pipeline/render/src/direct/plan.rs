//! Number of shadow rays, and the rounds that they go out in.

/// Rays of the first round at the most.
const FIRST: u32 = 8;
/// Numbers of the rounds' random numbers: the first has 0.
pub(super) const TRIALS: [u32; 2] = [1, 2];
pub(super) const LAST: u32 = 3;
/// Rays of the last round at the least where a bound decides.
pub(super) const SECOND: u32 = 8;
/// Rays of a pixel at the most where a bound decides.
const MOST: u32 = 1024;

/// Number and choice of shadow rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowRays {
    /// Shadow rays of each camera ray; with `noise` the most.
    pub count: u32,
    /// Standard error of a pixel's luminance [W/(sr m²)] that its rays go on to, if their number is
    /// not fixed.
    pub noise: Option<f32>,
    /// Whether lights are chosen by what could reach a point and what its neighbours found;
    /// otherwise uniformly.
    pub adaptive: bool,
}

impl Default for ShadowRays {
    fn default() -> ShadowRays {
        ShadowRays {
            count: 16,
            noise: None,
            adaptive: true,
        }
    }
}

impl ShadowRays {
    /// As many as a bound on the noise needs, up to `MOST`; the usual number without one.
    pub fn down_to(noise: Option<f32>) -> ShadowRays {
        let usual = ShadowRays::default();
        ShadowRays {
            count: noise.map_or(usual.count, |_| MOST),
            noise,
            ..usual
        }
    }
}

/// Rays of two rounds, and the weight of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rounds {
    pub(super) first: u32,
    pub(super) second: u32,
    pub(super) first_weight: f32,
}

impl Rounds {
    /// `None`: one round of all the rays, which learns nothing.
    pub(super) fn of(plan: ShadowRays) -> Option<Rounds> {
        if !plan.adaptive {
            return None;
        }
        let first = (plan.count * 3 / 8).clamp(1, FIRST);
        let second = plan.count.saturating_sub(first);
        // rays of the second round are taken to be worth two of the first
        let weight = 0.5 * first as f32 / (0.5 * first as f32 + second as f32);
        Some(Rounds {
            first,
            second,
            first_weight: match plan.noise {
                // its few rays would be the noisiest part of a long mean
                Some(_) if second > 0 => 0.0,
                _ => weight,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_have_all_the_rays() {
        for count in 1..40 {
            let plan = ShadowRays {
                count,
                ..ShadowRays::default()
            };
            let rounds = Rounds::of(plan).unwrap();
            assert_eq!(rounds.first + rounds.second, count);
            assert!(rounds.first > 0);
            assert_eq!(rounds.second == 0, rounds.first_weight == 1.0);
        }
    }
}
