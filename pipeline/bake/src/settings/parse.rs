//! From typed text to values, with a message that says what would be right.

use rrf_extract::Region;
use std::str::FromStr;

/// A finite number.
///
/// # Errors
/// A message for the user, as from all functions here.
pub fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("{text:?} is not finite")),
        Err(_) => Err(format!("{text:?} is not a number")),
    }
}

/// Finite numbers with commas between them.
///
/// # Errors
/// As [`number`].
pub fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let given: Vec<&str> = text.split(',').collect();
    if given.len() != N {
        let found = given.len();
        return Err(format!(
            "needs {N} numbers separated by commas, has {found}"
        ));
    }
    let mut out = [0.0; N];
    for (out, text) in out.iter_mut().zip(given) {
        *out = number(text)?;
    }
    Ok(out)
}

/// A number above 0.
///
/// # Errors
/// As [`number`].
pub fn positive(text: &str) -> Result<f32, String> {
    match number(text)? {
        x if x > 0.0 => Ok(x),
        _ => Err("has to be above 0".into()),
    }
}

/// A relative error above 0: `0.05` or `5%`.
pub(super) fn share(text: &str) -> Result<f32, String> {
    match text.trim().strip_suffix('%') {
        Some(percent) => Ok(positive(percent.trim_end())? / 100.0),
        None => positive(text),
    }
}

/// A number from 0 to 1.
pub(super) fn unit_interval(text: &str) -> Result<f32, String> {
    match number(text)? {
        x if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("has to be from 0 to 1".into()),
    }
}

/// A box, `x0,y0,z0,x1,y1,z1`.
pub(super) fn region(text: &str) -> Result<Region, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers(text)?;
    if x0 > x1 || y0 > y1 || z0 > z1 {
        return Err("the first corner has to be the smaller one on every axis".into());
    }
    Ok(Region {
        minimum: [x0, y0, z0],
        maximum: [x1, y1, z1],
    })
}

/// Units of hidden layers, `20,10`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hidden(pub Vec<usize>);

impl FromStr for Hidden {
    type Err = String;

    fn from_str(text: &str) -> Result<Hidden, String> {
        let units: Result<Vec<usize>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match units {
            Ok(units) if units.len() <= 2 && units.iter().all(|n| (1..=256).contains(n)) => {
                match weights(&units) {
                    0..=MOST_WEIGHTS => Ok(Hidden(units)),
                    most => Err(format!(
                        "makes up to {most} weights; the solver's matrix takes at most {MOST_WEIGHTS}"
                    )),
                }
            }
            _ => Err("needs one or two layers of 1 to 256 units, for example 20,10".into()),
        }
    }
}

/// Most weights of a net: a step of the solver takes the square of their number, 512 MiB.
const MOST_WEIGHTS: usize = 8192;

/// Weights of a net of three outputs with all inputs.
fn weights(hidden: &[usize]) -> usize {
    let layers = hidden.iter().copied().chain([3]);
    let (sum, _) = layers.fold((0, rrf_field::inputs::NAMES.len()), |(sum, from), to| {
        (sum + (from + 1) * to, to)
    });
    sum
}

/// The name of an input of a net.
pub(super) fn input(text: &str) -> Result<String, String> {
    if rrf_field::inputs::NAMES.contains(&text) {
        return Ok(text.into());
    }
    let known = rrf_field::inputs::NAMES.join(" ");
    Err(format!("is no input of a net; the inputs are {known}"))
}
