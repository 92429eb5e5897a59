//! Why a light was refused.

use glam::Vec3;

/// A light that cannot be computed with, and the reason.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// A number that is not finite, or negative where light cannot be.
    #[error("{what} is {value}; {wanted} is needed")]
    Number {
        /// The parameter.
        what: &'static str,
        /// Its value.
        value: f32,
        /// The values that are allowed.
        wanted: &'static str,
    },
    /// A colour with a channel that is not finite or negative.
    #[error("{what} is {} {} {}; three finite numbers, none negative, are needed", value.x, value.y, value.z)]
    Colour {
        /// The parameter.
        what: &'static str,
        /// Its value.
        value: Vec3,
    },
    /// A texel of an environment map or of a goniometric picture that is no light.
    #[error(
        "texel in column {column}, row {row} (from 0, row 0 at the top) is {} {} {}; \
         light is finite and not negative",
        value.x, value.y, value.z
    )]
    Texel {
        /// Column, from 0.
        column: u32,
        /// Row, from 0 at the top.
        row: u32,
        /// The texel.
        value: Vec3,
    },
    /// A picture whose size does not fit its use.
    #[error("picture of {width} x {height} texels: {wanted}")]
    Size {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// The sizes that are allowed.
        wanted: &'static str,
    },
    /// A portal that is no rectangle.
    #[error("a portal needs four corners of a flat rectangle with an area, in order")]
    Portal,
    /// An IES file that does not follow LM-63.
    #[error("IES profile, line {line}: {message}")]
    Ies {
        /// Line, from 1.
        line: usize,
        /// The fault and its remedy.
        message: String,
    },
}

/// Refuses a colour that is no light.
pub(crate) fn check_colour(what: &'static str, value: Vec3) -> Result<(), LightError> {
    if value.is_finite() && value.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(LightError::Colour { what, value })
    }
}

/// Refuses coordinates that are not finite.
pub(crate) fn check_finite(what: &'static str, value: Vec3) -> Result<(), LightError> {
    match value.to_array().into_iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(value) => Err(LightError::Number {
            what,
            value,
            wanted: "a finite number",
        }),
    }
}
