//! One parameter: its type, name and values.

use super::fault::{Place, Read, fault};
use super::token::{Kind, Token, Tokens, number};
use std::cell::Cell;

/// A parameter's declared type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Bool,
    Integer,
    Float,
    Point2,
    Point3,
    Vector3,
    Normal,
    String,
    Texture,
    Rgb,
    Xyz,
    Spectrum,
    Blackbody,
}

impl Type {
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Type::Bool,
            "integer" => Type::Integer,
            "float" => Type::Float,
            "point2" | "vector2" => Type::Point2,
            "point" | "point3" => Type::Point3,
            "vector" | "vector3" => Type::Vector3,
            "normal" | "normal3" => Type::Normal,
            "string" => Type::String,
            "texture" => Type::Texture,
            "rgb" | "color" => Type::Rgb,
            "xyz" => Type::Xyz,
            "spectrum" => Type::Spectrum,
            "blackbody" => Type::Blackbody,
            _ => return None,
        })
    }
}

/// As pbrt writes it.
impl std::fmt::Display for Type {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Type::Bool => "bool",
            Type::Integer => "integer",
            Type::Float => "float",
            Type::Point2 => "point2",
            Type::Point3 => "point3",
            Type::Vector3 => "vector3",
            Type::Normal => "normal",
            Type::String => "string",
            Type::Texture => "texture",
            Type::Rgb => "rgb",
            Type::Xyz => "xyz",
            Type::Spectrum => "spectrum",
            Type::Blackbody => "blackbody",
        })
    }
}

/// A parameter's values.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Strings(Vec<String>),
    Bools(Vec<bool>),
}

/// One parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub place: Place,
    pub kind: Type,
    pub name: String,
    pub values: Values,
    /// Something has asked for it.
    pub used: Cell<bool>,
}

impl Param {
    /// The numbers of a numeric parameter.
    pub fn numbers(&self) -> Read<&[f64]> {
        match &self.values {
            Values::Numbers(numbers) => Ok(numbers),
            _ => fault(self.place, format!("\"{}\" needs numbers", self.name)),
        }
    }

    /// The only value of a list of one.
    pub fn one<'v, T>(&self, values: &'v [T]) -> Read<&'v T> {
        match values {
            [value] => Ok(value),
            _ => fault(
                self.place,
                format!("\"{}\" needs one value, found {}", self.name, values.len()),
            ),
        }
    }

    /// The only string.
    pub fn string(&self) -> Read<&str> {
        match &self.values {
            Values::Strings(strings) => Ok(self.one(strings)?),
            _ => fault(
                self.place,
                format!("\"{}\" needs a string in quotes", self.name),
            ),
        }
    }

    /// Numbers in groups of `N`.
    pub fn groups<const N: usize>(&self) -> Read<impl Iterator<Item = [f64; N]>> {
        let numbers = self.numbers()?;
        if numbers.len() % N != 0 {
            return fault(
                self.place,
                format!(
                    "\"{}\" has {} numbers, not a multiple of {N}",
                    self.name,
                    numbers.len()
                ),
            );
        }
        Ok(numbers.chunks_exact(N).map(|chunk| {
            let mut group = [0.0; N];
            group.copy_from_slice(chunk);
            group
        }))
    }
}

/// Reads one value, or values in brackets.
pub(super) fn read_values(
    tokens: &mut Tokens<'_>,
    kind: Type,
    name: &str,
    at: Place,
) -> Read<Values> {
    let what = format!("the value of \"{name}\"");
    let first = tokens.require(&what)?;
    let mut values = None;
    if first.kind != Kind::Open {
        add_value(&mut values, &first, kind, name)?;
    } else {
        loop {
            let token = tokens.require(&format!("`]` after \"{name}\""))?;
            match token.kind {
                Kind::Close => break,
                _ => add_value(&mut values, &token, kind, name)?,
            }
        }
    }
    match values {
        Some(values) => Ok(values),
        None if matches!(kind, Type::Bool | Type::String | Type::Texture) => {
            fault(at, format!("\"{name}\" has no value"))
        }
        None => Ok(Values::Numbers(Vec::new())),
    }
}

/// Adds one value; the first one decides between numbers, strings and Booleans.
fn add_value(values: &mut Option<Values>, token: &Token<'_>, kind: Type, name: &str) -> Read<()> {
    let stringly = matches!(
        kind,
        Type::String | Type::Texture | Type::Spectrum | Type::Bool
    );
    match &token.kind {
        Kind::Quoted(text) if stringly => {
            if let Values::Strings(list) = values.get_or_insert(Values::Strings(Vec::new())) {
                list.push(text.to_string());
                return Ok(());
            }
        }
        Kind::Word(word @ ("true" | "false")) if kind == Type::Bool => {
            if let Values::Bools(list) = values.get_or_insert(Values::Bools(Vec::new())) {
                list.push(*word == "true");
                return Ok(());
            }
        }
        _ if !matches!(kind, Type::String | Type::Texture | Type::Bool) => {
            let value = number(token, name)?;
            if let Values::Numbers(list) = values.get_or_insert(Values::Numbers(Vec::new())) {
                list.push(value);
                return Ok(());
            }
        }
        _ => {}
    }
    fault(
        token.place,
        format!("{} does not fit \"{name}\" of type {kind}", token.kind),
    )
}
