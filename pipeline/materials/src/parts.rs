//! Which lobes of a material are broad.

use std::ops::BitOr;

/// Perceptual roughness from which on a lobe is broad.
pub const BROAD_ROUGHNESS: f32 = 0.25;

/// GGX alpha from which on a lobe is broad.
const BROAD_ALPHA: f32 = BROAD_ROUGHNESS * BROAD_ROUGHNESS;

/// A set of parts of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts(u32);

impl Parts {
    /// Nothing.
    pub const NONE: Parts = Parts(0);
    /// Diffuse lobes, and microfacet lobes of a roughness of [`BROAD_ROUGHNESS`] and above.
    pub const BROAD: Parts = Parts(1);
    /// Narrower lobes and sharp reflection and refraction.
    pub const NARROW: Parts = Parts(2);
    /// Light that goes straight through thin panes. It goes with the narrow part; whoever lets rays
    /// pass panes takes it out.
    pub const STRAIGHT: Parts = Parts(4);
    /// Everything.
    pub const ALL: Parts = Parts(7);

    /// Whether it has all of `other`.
    #[inline(always)]
    pub fn has(self, other: Parts) -> bool {
        self.0 & other.0 == other.0
    }

    /// Parts that are in `other` too.
    pub fn and(self, other: Parts) -> Parts {
        Parts(self.0 & other.0)
    }

    /// Parts that are not in `other`.
    pub fn without(self, other: Parts) -> Parts {
        Parts(self.0 & !other.0)
    }

    /// One if it has light that goes straight through, else zero.
    #[inline(always)]
    pub(crate) fn straight(self) -> f32 {
        (self.0 >> 2 & 1) as f32
    }

    /// The part that a microfacet lobe belongs to.
    pub(crate) fn of_lobe(alpha: f32) -> Parts {
        if alpha < BROAD_ALPHA {
            Parts::NARROW
        } else {
            Parts::BROAD
        }
    }

    /// One if it has the broad part, else zero.
    #[inline(always)]
    pub(crate) fn broad(self) -> f32 {
        (self.0 & 1) as f32
    }

    /// One if it has the narrow part, else zero.
    #[inline(always)]
    pub(crate) fn narrow(self) -> f32 {
        (self.0 >> 1 & 1) as f32
    }

    /// One if it has the part of a microfacet lobe, else zero.
    #[inline(always)]
    pub(crate) fn lobe(self, alpha: f32) -> f32 {
        if alpha < BROAD_ALPHA {
            self.narrow()
        } else {
            self.broad()
        }
    }
}

impl BitOr for Parts {
    type Output = Parts;

    fn bitor(self, other: Parts) -> Parts {
        Parts(self.0 | other.0)
    }
}
