//! The kinds of materials: one file each, registered here.

mod conductor;
mod dielectric;
mod diffuse_transmission;
mod lambert;
mod plastic;
mod plastic_table;
mod principled;
mod principled_extended;
mod rough_dielectric;
mod thin_dielectric;

use crate::MaterialKind;

pub use conductor::{CONDUCTOR, Metal};
pub use dielectric::DIELECTRIC;
pub use diffuse_transmission::DIFFUSE_TRANSMISSION;
pub use lambert::{LAMBERT, cosine_hemisphere, cosine_hemisphere_pdf};
pub use plastic::PLASTIC;
pub use principled::PRINCIPLED;
pub use principled_extended::{Layers, PRINCIPLED_EXTENDED};
pub use rough_dielectric::ROUGH_DIELECTRIC;
pub use thin_dielectric::THIN_DIELECTRIC;

/// All kinds.
pub static KINDS: [&MaterialKind; 9] = [
    &LAMBERT,
    &PRINCIPLED,
    &CONDUCTOR,
    &PLASTIC,
    &DIELECTRIC,
    &ROUGH_DIELECTRIC,
    &THIN_DIELECTRIC,
    &PRINCIPLED_EXTENDED,
    &DIFFUSE_TRANSMISSION,
];

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
