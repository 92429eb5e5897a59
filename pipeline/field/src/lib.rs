//! The baked field: a kd-tree whose leaves hold small neural nets.
//! Plain slices in, plain slices out; no files, no scene.
//!
//! A row is a query: surface point p, normal n, unit direction to the viewer v,
//! light position l, material parameters a (see [`columns`]).

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod columns;
pub mod model;
pub mod net;
pub mod tree;

#[cfg(test)]
mod rng_for_tests {
    /// A small generator for tests (Knuth's MMIX constants).
    pub struct Lcg(pub u64);

    impl Lcg {
        pub fn unit(&mut self) -> f32 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / 16_777_216.0
        }

        pub fn below(&mut self, n: usize) -> usize {
            ((self.unit() * n as f32) as usize).min(n - 1)
        }
    }
}
