//! Statements of an OBJ file.
//!
//! Faces are checked with their line numbers, statements without surface are left out with
//! a warning, unknown ones are errors. A new model begins at every object, group and change of
//! material, and wherever faces begin or end to have texture coordinates or normals.

use super::lines::statements;
use super::model::{Corner, Model, Obj};
use crate::SceneError;
use crate::warn::Warnings;
use std::path::Path;

/// Free-form curves and surfaces, points, lines.
const WITHOUT_POLYGONS: [&str; 21] = [
    "l",
    "p",
    "vp",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "call",
    "csh",
    "shadow_obj",
    "trace_obj",
];

/// Statements that change how a polygon is drawn elsewhere, not where it is.
const DISPLAY: [&str; 9] = [
    "mg", "bevel", "c_interp", "d_interp", "lod", "ctech", "stech", "maplib", "usemap",
];

/// Which of texture coordinate and normal a corner has.
type Layout = [bool; 2];

/// Most corners of a face: ear clipping may take the square of their number.
const MAX_CORNERS: usize = 1 << 14;

struct Parser<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    obj: Obj,
    line: u32,
    /// The greatest index used of positions, texture coordinates and normals, with its line.
    greatest: [(i64, u32); 3],
    layout: Option<Layout>,
    has_smoothing: bool,
}

/// Reads the text of the OBJ file `path`.
pub(super) fn parse(path: &Path, text: &str, warnings: &mut Warnings) -> Result<Obj, SceneError> {
    let mut parser = Parser {
        path,
        warnings,
        obj: Obj::default(),
        line: 0,
        greatest: [(0, 0); 3],
        layout: None,
        has_smoothing: false,
    };
    parser.begin_model("unnamed".into(), None, false);
    for (line, statement) in statements(text) {
        parser.line = line;
        parser.statement(&statement)?;
    }
    parser.finish()
}

impl Parser<'_> {
    fn statement(&mut self, statement: &str) -> Result<(), SceneError> {
        let (word, rest) = statement
            .split_once(char::is_whitespace)
            .unwrap_or((statement, ""));
        let rest = rest.trim();
        match word {
            "v" => self.position(rest)?,
            "vt" => self.texture_coordinate(rest)?,
            "vn" => {
                let normal = self.numbers(rest, "normal")?;
                self.obj.normals.push(normal.into());
            }
            "f" | "fo" => self.face(statement)?,
            "o" | "g" => {
                let name = if rest.is_empty() { "unnamed" } else { rest };
                let (_, material) = self.current();
                self.begin_model(name.into(), material, false);
                self.layout = None;
            }
            "usemtl" => self.use_material(rest),
            "mtllib" => self.obj.libraries.push((self.line, rest.into())),
            "s" => self.has_smoothing |= !matches!(rest, "off" | "0"),
            _ if WITHOUT_POLYGONS.contains(&word) => {
                let message = "left out: only polygons are read";
                self.warnings.add(format!("{word:?} statements"), message);
            }
            _ if DISPLAY.contains(&word) => {
                let message = "left out: display attributes";
                self.warnings.add(format!("{word:?} statements"), message);
            }
            _ => {
                let shown: String = word.chars().take(20).collect();
                return Err(self.error(statement, word, format!("unknown statement {shown:?}")));
            }
        }
        Ok(())
    }

    /// The first `N` numbers of a statement.
    fn numbers<const N: usize>(&self, rest: &str, what: &str) -> Result<[f32; N], SceneError> {
        let mut words = rest.split_whitespace();
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = words.next().and_then(|word| word.parse().ok());
            *number = word.ok_or_else(|| {
                let message = format!("{what} {rest:?}: {N} numbers are needed");
                self.error("", "", message)
            })?;
        }
        Ok(numbers)
    }

    /// A position; a fourth number is a weight for curves, six are a colour besides.
    fn position(&mut self, rest: &str) -> Result<(), SceneError> {
        if rest.split_whitespace().nth(4).is_some() {
            self.warnings.add("vertex colours", "left out");
        }
        let position = self.numbers(rest, "position")?;
        self.obj.positions.push(position.into());
        Ok(())
    }

    /// Two numbers; one alone is legal and means v = 0.
    fn texture_coordinate(&mut self, rest: &str) -> Result<(), SceneError> {
        let uv = if rest.contains(char::is_whitespace) {
            self.numbers(rest, "texture coordinate")?
        } else {
            let [u] = self.numbers(rest, "texture coordinate")?;
            [u, 0.0]
        };
        self.obj.uvs.push(uv.into());
        Ok(())
    }

    /// Name and material of the model that faces are added to.
    fn current(&self) -> (String, Option<String>) {
        let model = self.obj.models.last();
        model.map_or_else(Default::default, |m| (m.name.clone(), m.material.clone()))
    }

    /// Begins a model, in place of one without triangles.
    fn begin_model(&mut self, name: String, material: Option<String>, continues: bool) {
        let empty = self.obj.models.pop_if(|model| model.triangles.is_empty());
        self.obj.models.push(Model {
            name,
            material,
            continues: continues && empty.is_none_or(|model| model.continues),
            ..Model::default()
        });
    }

    fn use_material(&mut self, name: &str) {
        let is_known = self.obj.materials.iter().any(|(_, known)| known == name);
        if !is_known {
            self.obj.materials.push((self.line, name.into()));
        }
        let (object, _) = self.current();
        self.begin_model(object, Some(name.into()), true);
    }

    fn face(&mut self, statement: &str) -> Result<(), SceneError> {
        let mut corners: Vec<Corner> = Vec::new();
        for word in statement.split_whitespace().skip(1) {
            let corner = self.corner(statement, word)?;
            if corners
                .first()
                .is_some_and(|&first| layout(first) != layout(corner))
            {
                let message = "the corners of a face must have texture coordinates and normals \
                               alike";
                return Err(self.error(statement, word, message));
            }
            corners.push(corner);
        }
        let [first, rest @ ..] = corners.as_slice() else {
            return Err(self.too_few(statement, 0));
        };
        if rest.len() < 2 {
            return Err(self.too_few(statement, corners.len()));
        }
        if rest.len() >= MAX_CORNERS {
            let message = format!("a face of more than {MAX_CORNERS} corners; divide it");
            return Err(self.error(statement, statement, message));
        }
        let layout = layout(*first);
        if self.layout.replace(layout).is_some_and(|l| l != layout) {
            let (name, material) = self.current();
            self.begin_model(name, material, false);
        }
        let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
        if let Some(model) = self.obj.models.last_mut() {
            model.add_fan(fan);
        }
        Ok(())
    }

    fn too_few(&self, statement: &str, corners: usize) -> SceneError {
        let message = format!("a face of {corners} corners, must have 3 or more");
        self.error(statement, statement, message)
    }

    /// Checks `v`, `v/vt`, `v//vn` or `v/vt/vn`: indices from 1, or back from -1.
    fn corner(&mut self, statement: &str, corner: &str) -> Result<Corner, SceneError> {
        let obj = &self.obj;
        let counts = [obj.positions.len(), obj.uvs.len(), obj.normals.len()].map(|n| n as i64);
        let mut found = [None; 3];
        for (kind, index) in corner.split('/').enumerate() {
            let (Some(found), Some(&count)) = (found.get_mut(kind), counts.get(kind)) else {
                return Err(self.error(statement, corner, "more than three indices in a corner"));
            };
            if index.is_empty() && kind > 0 {
                continue;
            }
            let number: i64 = index
                .parse::<i32>()
                .map_err(|error| self.error(statement, corner, format!("index: {error}")))?
                .into();
            if number == 0 || number < -count {
                let message = format!("index {number}: there are {count} so far, from 1 or -1");
                return Err(self.error(statement, corner, message));
            }
            let from_one = if number < 0 {
                count + 1 + number
            } else {
                number
            };
            *found = Some(from_one as u32 - 1);
            if let Some(greatest) = self.greatest.get_mut(kind)
                && number > greatest.0
            {
                *greatest = (number, self.line);
            }
        }
        Ok(found)
    }

    fn finish(mut self) -> Result<Obj, SceneError> {
        let kinds = ["vertices", "texture coordinates", "normals"];
        let obj = &self.obj;
        let counts = [obj.positions.len(), obj.uvs.len(), obj.normals.len()];
        for ((kind, count), (greatest, line)) in kinds.iter().zip(counts).zip(self.greatest) {
            if greatest > count as i64 {
                self.line = line;
                let message = format!("a face uses number {greatest}, there are {count} {kind}");
                return Err(self.error("", "", message));
            }
        }
        if self.has_smoothing && obj.normals.is_empty() {
            let message = "left out: without vn the triangles' own normals are used";
            self.warnings.add("smoothing groups", message);
        }
        let Obj {
            positions, models, ..
        } = &mut self.obj;
        models
            .iter_mut()
            .for_each(|model| model.divide_concave(positions));
        Ok(self.obj)
    }

    /// An error at `word`, a part of `statement`, in the current line.
    fn error(&self, statement: &str, word: &str, message: impl Into<String>) -> SceneError {
        let before = statement.find(word).and_then(|at| statement.get(..at));
        SceneError::Syntax {
            path: self.path.to_path_buf(),
            line: self.line,
            column: before.map_or(0, |before| before.chars().count()) as u32 + 1,
            message: message.into(),
        }
    }
}

fn layout([_, uv, normal]: Corner) -> Layout {
    [uv.is_some(), normal.is_some()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Obj, String> {
        parse(Path::new("x.obj"), text, &mut Warnings::default()).map_err(|e| e.to_string())
    }

    fn refused(text: &str) -> String {
        match parsed(text) {
            Ok(_) => panic!("accepted: {text}"),
            Err(message) => message,
        }
    }

    const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    #[test]
    fn errors_carry_line_and_column() {
        assert!(refused("v 0 0 0\n  wobble 3").starts_with("x.obj:2:1: "));
        assert!(refused(&format!("{THREE}f 1 2 x")).starts_with("x.obj:4:7: "));
        assert!(refused(&format!("{THREE}f 1 2 0")).contains("index 0"));
        assert!(refused(&format!("{THREE}f 1 2 -4")).starts_with("x.obj:4:7: "));
        assert!(refused(&format!("{THREE}\n\nf 1 2 4\n")).starts_with("x.obj:6:1: "));
        assert!(refused(&format!("{THREE}f 1 2")).contains("2 corners"));
        assert!(refused(&format!("{THREE}f 1/1/1/1 2 3")).contains("three indices"));
        assert!(refused(&format!("{THREE}f /1 2 3")).contains("index: "));
        assert!(refused(&format!("{THREE}f 1//1 2 3")).contains("alike"));
        assert!(refused(&format!("{THREE}f 1 2 99999999999")).contains("index: "));
        assert!(refused("\u{fffd}PNG\r\n").contains("unknown statement"));
    }

    #[test]
    fn faces_that_change_their_layout_start_an_object() {
        let text = format!("{THREE}vt 0\no a\nf 1/1 2/1 3/1\nf 1 2 3\nf 3 2 1\n");
        let models = parsed(&text).unwrap().models;
        let found: Vec<_> = models
            .iter()
            .map(|m| (m.name.as_str(), m.triangles.len()))
            .collect();
        assert_eq!(found, [("a", 1), ("a", 2)]);
        assert_eq!(models[0].triangles[0][1], [Some(1), Some(0), None]);
    }
}
