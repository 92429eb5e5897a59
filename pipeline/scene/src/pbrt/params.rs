//! Parameter lists: `"type name" value` or `"type name" [ values ]`.

use super::fault::{Place, Read, fault};
use super::param::{Param, Type, Values, read_values};
use super::token::{Kind, Token, Tokens};
use glam::{DVec2, DVec3};
use std::cell::Cell;

/// A directive's parameters. Each look-up marks its parameter as used.
#[derive(Clone, Debug)]
pub(super) struct Params {
    /// The directive's place.
    pub place: Place,
    /// The directive and its type for messages: `Shape "sphere"`.
    pub owner: String,
    list: Vec<Param>,
}

impl Params {
    /// An empty list.
    pub fn none(place: Place, owner: impl Into<String>) -> Self {
        Self {
            place,
            owner: owner.into(),
            list: Vec::new(),
        }
    }

    /// Reads parameters until something else follows.
    pub fn read(tokens: &mut Tokens<'_>, place: Place, owner: String) -> Read<Self> {
        let mut params = Self::none(place, owner);
        while let Some(Token {
            kind: Kind::Quoted(_),
            ..
        }) = tokens.peek()?
        {
            let (declaration, place) = tokens.string("a parameter")?;
            let mut words = declaration.split_ascii_whitespace();
            let (Some(type_name), Some(name), None) = (words.next(), words.next(), words.next())
            else {
                return fault(
                    place,
                    format!("\"{declaration}\" is not a parameter: \"type name\" is needed"),
                );
            };
            let Some(kind) = Type::named(type_name) else {
                return fault(place, format!("unknown parameter type \"{type_name}\""));
            };
            let values = read_values(tokens, kind, name, place)?;
            let (name, used) = (name.to_owned(), Cell::new(false));
            params.list.push(Param {
                place,
                kind,
                name,
                values,
                used,
            });
        }
        Ok(params)
    }

    /// Adds parameters that are used where this list has none of the name.
    pub fn add_defaults(&mut self, defaults: &Params) {
        for param in &defaults.list {
            if self.list.iter().all(|own| own.name != param.name) {
                // A default may serve another shape than this one.
                param.used.set(true);
                self.list.push(param.clone());
            }
        }
    }

    /// A parameter of one of these types; one of another type is a fault.
    pub fn find(&self, name: &str, kinds: &[Type]) -> Read<Option<&Param>> {
        let Some(param) = self.list.iter().find(|param| param.name == name) else {
            return Ok(None);
        };
        param.used.set(true);
        if kinds.contains(&param.kind) {
            return Ok(Some(param));
        }
        let expected: Vec<String> = kinds.iter().map(Type::to_string).collect();
        let expected = expected.join(" or ");
        fault(
            param.place,
            format!(
                "\"{name}\" of {} cannot be of type {}; expected {expected}",
                self.owner, param.kind
            ),
        )
    }

    /// Whether a parameter is there, of whatever type; it counts as used.
    pub fn has(&self, name: &str) -> bool {
        self.place_of(name).is_some()
    }

    /// The place of a parameter of whatever type; it counts as used.
    pub fn place_of(&self, name: &str) -> Option<Place> {
        let param = self.list.iter().find(|param| param.name == name)?;
        param.used.set(true);
        Some(param.place)
    }

    /// Marks parameters as known that change nothing here.
    pub fn ignore(&self, names: &[&str]) {
        for param in self
            .list
            .iter()
            .filter(|param| names.contains(&param.name.as_str()))
        {
            param.used.set(true);
        }
    }

    /// Parameters that nothing has asked for.
    pub fn unused(&self) -> impl Iterator<Item = &Param> {
        self.list.iter().filter(|param| !param.used.get())
    }

    /// One number.
    pub fn float(&self, name: &str) -> Read<Option<f64>> {
        match self.find(name, &[Type::Float, Type::Integer])? {
            Some(param) => Ok(Some(*param.one(param.numbers()?)?)),
            None => Ok(None),
        }
    }

    /// One whole number.
    pub fn integer(&self, name: &str) -> Read<Option<i64>> {
        match self.integers(name)? {
            Some((param, values)) => Ok(Some(*param.one(&values)?)),
            None => Ok(None),
        }
    }

    /// Whole numbers.
    pub fn integers(&self, name: &str) -> Read<Option<(&Param, Vec<i64>)>> {
        let Some(param) = self.find(name, &[Type::Integer])? else {
            return Ok(None);
        };
        let whole = |&value: &f64| {
            if value == value.trunc() && value.abs() <= f64::from(u32::MAX) {
                Ok(value as i64)
            } else {
                fault(
                    param.place,
                    format!("{value} in \"{name}\" is not a 32-bit whole number"),
                )
            }
        };
        let values = param.numbers()?.iter().map(whole).collect::<Read<_>>()?;
        Ok(Some((param, values)))
    }

    /// One Boolean; version 3 writes it in quotes.
    pub fn bool(&self, name: &str) -> Read<Option<bool>> {
        let Some(param) = self.find(name, &[Type::Bool])? else {
            return Ok(None);
        };
        match &param.values {
            Values::Bools(bools) => Ok(Some(*param.one(bools)?)),
            _ => match param.string()? {
                "true" => Ok(Some(true)),
                "false" => Ok(Some(false)),
                other => fault(
                    param.place,
                    format!("\"{name}\" is \"{other}\", not true or false"),
                ),
            },
        }
    }

    /// One string.
    pub fn string(&self, name: &str) -> Read<Option<&str>> {
        self.find(name, &[Type::String])?
            .map(Param::string)
            .transpose()
    }

    /// Strings.
    pub fn strings(&self, name: &str) -> Read<Option<&[String]>> {
        match self.find(name, &[Type::String])? {
            Some(Param {
                values: Values::Strings(strings),
                ..
            }) => Ok(Some(strings)),
            Some(param) => fault(param.place, format!("\"{name}\" needs strings in quotes")),
            None => Ok(None),
        }
    }

    /// Triples of numbers: points, vectors or normals.
    pub fn triples(&self, name: &str) -> Read<Option<Vec<DVec3>>> {
        let kinds = [Type::Point3, Type::Vector3, Type::Normal];
        match self.find(name, &kinds)? {
            Some(param) => Ok(Some(param.groups::<3>()?.map(DVec3::from_array).collect())),
            None => Ok(None),
        }
    }

    /// One triple.
    pub fn triple(&self, name: &str) -> Read<Option<DVec3>> {
        let place = self.place_of(name);
        match (self.triples(name)?.as_deref(), place) {
            (None, _) | (_, None) => Ok(None),
            (Some(&[value]), _) => Ok(Some(value)),
            (Some(_), Some(place)) => fault(place, format!("\"{name}\" needs three numbers")),
        }
    }

    /// Pairs of numbers, as `point2` or plain `float`.
    pub fn pairs(&self, name: &str) -> Read<Option<Vec<DVec2>>> {
        match self.find(name, &[Type::Point2, Type::Float])? {
            Some(param) => Ok(Some(param.groups::<2>()?.map(DVec2::from_array).collect())),
            None => Ok(None),
        }
    }
}
