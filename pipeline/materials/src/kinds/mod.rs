//! The kinds of materials: one file each, registered here.

mod lambert;
mod principled;

use crate::MaterialKind;

pub use lambert::{LAMBERT, cosine_hemisphere, cosine_hemisphere_pdf};
pub use principled::PRINCIPLED;

/// All kinds.
pub static KINDS: [&MaterialKind; 2] = [&LAMBERT, &PRINCIPLED];

#[cfg(test)]
mod tests {
    use super::KINDS;

    #[test]
    fn names_and_numbers_stand_once() {
        for (i, kind) in KINDS.iter().enumerate() {
            for other in &KINDS[..i] {
                assert!(kind.name != other.name && kind.number != other.number);
            }
        }
    }
}
