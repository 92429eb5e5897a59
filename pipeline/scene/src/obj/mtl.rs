//! Statements of an MTL library.

use super::lines::statements;
use crate::SceneError;
use crate::warn::Warnings;
use glam::Vec3;
use std::path::{Path, PathBuf};

/// A material as the library states it; `None` where it says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mtl {
    /// Its name.
    pub(super) name: String,
    /// `library.mtl:line`.
    pub(super) place: String,
    /// The library's folder.
    pub(super) folder: PathBuf,
    /// Kd, diffuse reflectance.
    pub(super) diffuse: Option<Vec3>,
    /// Ks, Phong reflectance.
    pub(super) phong: Option<Vec3>,
    /// Ns, Phong exponent.
    pub(super) exponent: Option<f32>,
    /// Ke, emitted radiance.
    pub(super) emission: Option<Vec3>,
    /// Ni, index of refraction.
    pub(super) index: Option<f32>,
    /// Pr, roughness.
    pub(super) roughness: Option<f32>,
    /// Pm, metalness.
    pub(super) metallic: Option<f32>,
    /// d or 1 - Tr.
    pub(super) opacity: Option<f32>,
    /// Tf, share that glass lets through.
    pub(super) filter: Option<Vec3>,
    /// map_d, opacity.
    pub(super) opacity_map: Option<String>,
    /// illum.
    pub(super) model: Option<f32>,
    /// map_Kd, as it is written.
    pub(super) diffuse_map: Option<String>,
    /// map_Ke.
    pub(super) emission_map: Option<String>,
    /// norm.
    pub(super) normal_map: Option<String>,
}

/// Statements without influence on a path tracer.
const WITHOUT_EFFECT: [&str; 5] = ["Ka", "map_Ka", "map_aat", "sharpness", "map_Ns"];

/// Reads the text of the library `path`.
pub(super) fn parse(
    path: &Path,
    text: &str,
    warnings: &mut Warnings,
) -> Result<Vec<Mtl>, SceneError> {
    let mut materials: Vec<Mtl> = Vec::new();
    for (line, statement) in statements(text) {
        let (word, rest) = statement
            .split_once(char::is_whitespace)
            .unwrap_or((&statement, ""));
        let statement = Statement {
            path,
            line,
            word,
            rest: rest.trim(),
        };
        if word == "newmtl" {
            materials.push(Mtl {
                name: statement.rest.into(),
                place: statement.place(),
                folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
                ..Mtl::default()
            });
            continue;
        }
        match materials.last_mut() {
            Some(material) => statement.apply(material, warnings)?,
            None => return Err(statement.error("stands before the first newmtl")),
        }
    }
    Ok(materials)
}

struct Statement<'a> {
    path: &'a Path,
    line: u32,
    word: &'a str,
    rest: &'a str,
}

impl Statement<'_> {
    fn apply(&self, material: &mut Mtl, warnings: &mut Warnings) -> Result<(), SceneError> {
        match self.word {
            "Kd" => material.diffuse = self.colour(warnings)?,
            "Ks" => material.phong = self.colour(warnings)?,
            "Tf" => material.filter = self.colour(warnings)?,
            "map_d" => material.opacity_map = self.file(warnings),
            "Ke" => material.emission = self.colour(warnings)?,
            "Ns" => material.exponent = Some(self.number()?),
            "Ni" => material.index = Some(self.number()?),
            "Pr" => material.roughness = Some(self.number()?),
            "Pm" => material.metallic = Some(self.number()?),
            "d" => material.opacity = Some(self.number()?),
            "Tr" => material.opacity = Some(1.0 - self.number()?),
            "illum" => material.model = Some(self.number()?),
            "map_Kd" => material.diffuse_map = self.file(warnings),
            "map_Ke" => material.emission_map = self.file(warnings),
            "norm" => material.normal_map = self.file(warnings),
            word if WITHOUT_EFFECT.contains(&word) => {}
            word => {
                let shown: String = word.chars().take(20).collect();
                warnings.add(self.place(), format!("{shown:?} left out"));
            }
        }
        Ok(())
    }

    /// One number for all channels, or three.
    fn colour(&self, warnings: &mut Warnings) -> Result<Option<Vec3>, SceneError> {
        let words: Vec<&str> = self.rest.split_whitespace().collect();
        match words.as_slice() {
            ["spectral" | "xyz", ..] => {
                let message = format!("{} {} left out: only RGB is read", self.word, words[0]);
                warnings.add(self.place(), message);
                Ok(None)
            }
            [grey] => Ok(Some(Vec3::splat(self.finite(grey)?))),
            [r, g, b] => Ok(Some(Vec3::new(
                self.finite(r)?,
                self.finite(g)?,
                self.finite(b)?,
            ))),
            _ => Err(self.error("takes one number or three")),
        }
    }

    fn number(&self) -> Result<f32, SceneError> {
        // `d -halo 0.5` depends on the view; the number is what counts here.
        let number = self.rest.split_whitespace().next_back();
        self.finite(number.unwrap_or(""))
    }

    fn finite(&self, word: &str) -> Result<f32, SceneError> {
        let number = word.parse().ok().filter(|number: &f32| number.is_finite());
        number.ok_or_else(|| self.error(&format!("{word:?} is not a finite number")))
    }

    /// The picture's name; options before it are left out.
    fn file(&self, warnings: &mut Warnings) -> Option<String> {
        let mut rest = self.rest;
        while rest.starts_with('-') {
            let (option, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            let values = match option {
                "-o" | "-s" | "-t" => 3,
                "-mm" => 2,
                _ => 1,
            };
            warnings.add(self.place(), format!("{} {option} left out", self.word));
            rest = after.trim_start();
            for value in 0..values {
                let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
                // Of three numbers the last two may be missing.
                if value > 0 && word.parse::<f32>().is_err() {
                    break;
                }
                rest = after.trim_start();
            }
        }
        if rest.is_empty() {
            warnings.add(self.place(), format!("{} names no file", self.word));
            return None;
        }
        Some(rest.to_owned())
    }

    fn place(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        format!("{}:{}", name.to_string_lossy(), self.line)
    }

    fn error(&self, message: &str) -> SceneError {
        SceneError::Syntax {
            path: self.path.to_path_buf(),
            line: self.line,
            column: 1,
            message: format!("{} {message}", self.word),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (Vec<Mtl>, Vec<crate::Warning>) {
        let mut warnings = Warnings::default();
        let materials = parse(Path::new("d/x.mtl"), text, &mut warnings).unwrap();
        (materials, warnings.finish())
    }

    #[test]
    fn statements_become_fields() {
        let (materials, warnings) = parsed(
            "newmtl a b\nKd 0.5\nKs 0.1 0.2 0.3\nKe 17 12 4\nTr 0.25\nPr 0.3\nPm 1\n\
             map_Kd -s 2 2 wood floor.png\nnorm sub\\n.png\nnewmtl c\n",
        );
        let a = &materials[0];
        assert_eq!(a.name, "a b");
        assert_eq!(a.place, "x.mtl:1");
        assert_eq!(a.diffuse, Some(Vec3::splat(0.5)));
        assert_eq!(a.phong, Some(Vec3::new(0.1, 0.2, 0.3)));
        assert_eq!(a.emission, Some(Vec3::new(17.0, 12.0, 4.0)));
        assert_eq!(
            (a.opacity, a.roughness, a.metallic),
            (Some(0.75), Some(0.3), Some(1.0))
        );
        assert_eq!(a.folder, Path::new("d"));
        assert_eq!(a.diffuse_map.as_deref(), Some("wood floor.png"));
        assert_eq!(a.normal_map.as_deref(), Some(r"sub\n.png"));
        assert_eq!(materials[1].diffuse, None);
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].message, "map_Kd -s left out");
    }

    #[test]
    fn broken_statements_say_where() {
        let refused = |text: &str| {
            parse(Path::new("x.mtl"), text, &mut Warnings::default())
                .unwrap_err()
                .to_string()
        };
        assert!(refused("Kd 1 1 1").contains("newmtl"));
        assert!(refused("newmtl a\nKd 1 2").starts_with("x.mtl:2:1: Kd takes"));
        assert!(refused("newmtl a\n\nNi nan").starts_with("x.mtl:3:1: "));
        assert!(refused("newmtl a\nPr").contains("not a finite number"));
    }

    #[test]
    fn unknown_words_are_named() {
        let (_, warnings) = parsed("newmtl a\nPc 0.5\nKd spectral x.rfl\nmap_Kd\n");
        let messages: Vec<_> = warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(messages[0], "\"Pc\" left out");
        assert!(messages[1].contains("spectral"));
        assert!(messages[2].contains("names no file"));
    }
}
