//! The table of inputs.

use super::lane::Lane;
use super::number::{Number, reciprocal, sqrt};

/// One input, or one raw column of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its name in tables, options and exported files.
    pub name: &'static str,
    /// Unit of its values.
    pub unit: &'static str,
    /// Coordinate frame: `world` or `none`.
    pub frame: &'static str,
    /// The vector that it is a coordinate of; its own name where it stands alone.
    pub vector: &'static str,
    /// Whether bakes offer it to their nets unless told otherwise.
    pub by_default: bool,
    /// What its values say.
    pub meaning: &'static str,
    /// How it is computed, as numpy and Rust both read it; none for a raw column.
    pub formula: Option<&'static str>,
}

/// Defines the inputs: raw columns in the order of rows, then derived inputs.
///
/// A formula may name raw columns and other derived inputs, wherever those stand. It is plain
/// arithmetic on [`Number`]s, which Rust never fuses: training and rendering see the same bits.
macro_rules! net_inputs {
    (
        raw { $($raw:ident $raw_unit:literal $raw_frame:ident $raw_vector:ident $raw_meaning:literal,)* }
        derived { $($name:ident $unit:literal $frame:ident $vector:ident $offered:ident
            $meaning:literal = $formula:expr,)* }
    ) => {
        /// Places of the inputs.
        #[allow(non_camel_case_types)]
        pub(crate) enum Place { $($raw,)* $($name,)* }

        /// Names of the raw columns, in order.
        pub(crate) const RAW_NAMES: [&str; RAW] = [$(stringify!($raw)),*];

        /// Names of all inputs, in order; the raw columns are the first [`RAW`].
        pub const NAMES: [&str; COUNT] = [$(stringify!($raw),)* $(stringify!($name),)*];

        /// How many raw columns a row has.
        pub const RAW: usize = [$(Place::$raw),*].len();

        /// How many inputs there are.
        pub const COUNT: usize = RAW + [$(Place::$name),*].len();

        /// Every input: the raw columns in their order, then those computed from them.
        pub const INPUTS: [Input; COUNT] = [
            $(Input {
                name: stringify!($raw),
                unit: $raw_unit,
                frame: stringify!($raw_frame),
                vector: stringify!($raw_vector),
                by_default: true,
                meaning: $raw_meaning,
                formula: None,
            },)*
            $(Input {
                name: stringify!($name),
                unit: $unit,
                frame: stringify!($frame),
                vector: stringify!($vector),
                by_default: matches!(stringify!($offered).as_bytes(), b"default"),
                meaning: $meaning,
                formula: Some(stringify!($formula)),
            },)*
        ];

        /// The value of one input where `of` holds the values of all that it reads.
        #[allow(unused_variables)]
        #[inline(always)]
        pub(super) fn formula<T: Number>(input: usize, of: &[T; COUNT]) -> T {
            let [$($raw,)* $($name,)*] = *of;
            match input {
                $(place if place == Place::$name as usize => $formula,)*
                raw => of[raw],
            }
        }

        /// Every input of one row of a block.
        #[inline(always)]
        fn row(block: &[Lane; COUNT], r: usize) -> [f32; COUNT] {
            [
                $(block[Place::$raw as usize].0[r],)*
                $(block[Place::$name as usize].0[r],)*
            ]
        }

        /// Computes a derived input over the first `rows` rows of a block.
        #[inline(always)]
        pub(super) fn derive(input: usize, rows: usize, block: &mut [Lane; COUNT]) {
            match input {
                $(place if place == Place::$name as usize => {
                    derive_one::<{ Place::$name as usize }>(rows, block);
                })*
                _ => {}
            }
        }
    };
}

net_inputs! {
    //  name      unit frame vector     meaning
    raw {
        px        "m"  world p          "surface point, x",
        py        "m"  world p          "surface point, y",
        pz        "m"  world p          "surface point, z",
        nx        "1"  world n          "unit surface normal, on the side that is seen, x",
        ny        "1"  world n          "unit surface normal, on the side that is seen, y",
        nz        "1"  world n          "unit surface normal, on the side that is seen, z",
        vx        "1"  world v          "unit direction from p to the viewer, x",
        vy        "1"  world v          "unit direction from p to the viewer, y",
        vz        "1"  world v          "unit direction from p to the viewer, z",
        lx        "m"  world l          "position of the point light, x",
        ly        "m"  world l          "position of the point light, y",
        lz        "m"  world l          "position of the point light, z",
        base_r    "1"  none  base       "base colour, linear sRGB, red, in [0, 1]",
        base_g    "1"  none  base       "base colour, linear sRGB, green, in [0, 1]",
        base_b    "1"  none  base       "base colour, linear sRGB, blue, in [0, 1]",
        roughness "1"  none  roughness  "perceptual roughness in [0, 1]; GGX alpha is max(0.001, roughness^2)",
        metallic  "1"  none  metallic   "metalness in [0, 1]",
        specular  "1"  none  specular   "dielectric specular in [0, 1]; 0.5 means an index of refraction of 1.5",
    }
    //  `default`: bakes offer it to nets; `named`: only where --inputs names it
    derived {
        dx "1" world d default "unit direction d from p to the light, x; 0 for a light on p"
            = (lx - px) * inv_distance,
        dy "1" world d default "unit direction d from p to the light, y; 0 for a light on p"
            = (ly - py) * inv_distance,
        dz "1" world d default "unit direction d from p to the light, z; 0 for a light on p"
            = (lz - pz) * inv_distance,
        inv_distance "1/m" none inv_distance default "1 / |l - p|; 0 for a light on p"
            = reciprocal(sqrt(
                (lx - px) * (lx - px) + (ly - py) * (ly - py) + (lz - pz) * (lz - pz)
            )),
        mirror_light "1" none mirror_light named "mirror direction of v about n, dotted with d"
            = cos_view * 2.0 * cos_light - (vx * dx + vy * dy + vz * dz),
        cos_light "1" none cos_light named "cosine between n and d"
            = nx * dx + ny * dy + nz * dz,
        cos_view "1" none cos_view named "cosine between n and v"
            = nx * vx + ny * vy + nz * vz,
    }
}

/// A loop of its own for each input: known places are what makes it vector instructions.
#[inline(always)]
fn derive_one<const INPUT: usize>(rows: usize, block: &mut [Lane; COUNT]) {
    for r in 0..rows {
        block[INPUT].0[r] = formula(INPUT, &row(block, r));
    }
}
