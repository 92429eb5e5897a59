//! A PLY file's header.

use super::token::shortened;

/// A fault's place in the file and its words.
pub(super) type Wrong = (String, String);

/// A number's type in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    /// Type of the list's length, for a list.
    pub length: Option<Scalar>,
    pub scalar: Scalar,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A fault.
pub(super) fn wrong<T>(place: impl Into<String>, message: impl Into<String>) -> Result<T, Wrong> {
    Err((place.into(), message.into()))
}

/// The format, the elements, and the bytes after the header.
pub(super) fn header(bytes: &[u8]) -> Result<(Format, Vec<Element>, &[u8]), Wrong> {
    let mut rest = bytes;
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    for number in 1.. {
        let place = format!("header line {number}");
        let Some(end) = rest.iter().take(4096).position(|&byte| byte == b'\n') else {
            return wrong(
                place,
                "the file ends before end_header; is it truncated or no PLY file?",
            );
        };
        let (line, after) = rest.split_at(end);
        rest = after.get(1..).unwrap_or_default();
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match (number, words.as_slice()) {
            (1, ["ply"]) => {}
            (1, _) => {
                return wrong(place, "a PLY file starts with the word ply");
            }
            (_, ["format", name, "1.0"]) => format = Some(format_named(name, &place)?),
            (_, ["comment" | "obj_info", ..] | []) => {}
            (_, ["element", name, count]) => {
                let Ok(count) = count.parse() else {
                    return wrong(place, format!("`{}` is no count", shortened(count)));
                };
                elements.push(Element {
                    name: (*name).to_owned(),
                    count,
                    properties: Vec::new(),
                });
            }
            (_, ["property", declaration @ ..]) => {
                let property = property(declaration, &place)?;
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return wrong(place, "a property before any element"),
                }
            }
            (_, ["end_header"]) => match format {
                Some(format) => return Ok((format, elements, rest)),
                None => return wrong(place, "the header has no format line"),
            },
            _ => {
                return wrong(place, format!("unknown header line `{}`", shortened(&line)));
            }
        }
    }
    wrong("header", "no end_header")
}

fn format_named(name: &str, place: &str) -> Result<Format, Wrong> {
    match name {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::Little),
        "binary_big_endian" => Ok(Format::Big),
        _ => wrong(place, format!("unknown format `{}`", shortened(name))),
    }
}

fn property(declaration: &[&str], place: &str) -> Result<Property, Wrong> {
    let scalar = |name: &str| match Scalar::named(name) {
        Some(scalar) => Ok(scalar),
        None => wrong(place, format!("unknown type `{}`", shortened(name))),
    };
    match declaration {
        ["list", length, kind, name] => {
            let length = scalar(length)?;
            if matches!(length, Scalar::F32 | Scalar::F64) {
                return wrong(place, "the length of a list cannot be a fraction");
            }
            Ok(Property {
                name: (*name).to_owned(),
                length: Some(length),
                scalar: scalar(kind)?,
            })
        }
        [kind, name] => Ok(Property {
            name: (*name).to_owned(),
            length: None,
            scalar: scalar(kind)?,
        }),
        _ => wrong(place, "a property is `type name` or `list type type name`"),
    }
}
