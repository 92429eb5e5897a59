//! A look over the text of an OBJ file before `tobj` reads it.
//!
//! Faces are checked with their line numbers, statements without surface are left out with
//! a warning, unknown ones are errors. What is handed on is one statement a line, spelled
//! in one way, with a new object wherever faces begin or end to have texture coordinates
//! or normals.

use super::lines::{Reader, statements};
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

/// The checked text.
pub(super) struct Scan {
    /// Statements for `tobj`.
    text: String,
    /// Line in the file of each line of `text`.
    lines: Vec<u32>,
    /// MTL files named, with their lines.
    pub(super) libraries: Vec<(u32, String)>,
    /// Materials used, with their first lines.
    pub(super) materials: Vec<(u32, String)>,
}

impl Scan {
    /// The text with a count of the lines read.
    pub(super) fn reader(&self) -> Reader<'_> {
        Reader::new(&self.text, &self.lines)
    }
}

/// Which of texture coordinate and normal a corner has.
type Layout = [bool; 2];

struct Scanner<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    scan: Scan,
    line: u32,
    /// Statements `v`, `vt` and `vn` so far.
    counts: [i64; 3],
    /// The greatest index used of each, with its line.
    greatest: [(i64, u32); 3],
    object: String,
    layout: Option<Layout>,
    has_smoothing: bool,
}

/// Checks the text of the OBJ file `path`.
pub(super) fn scan(path: &Path, text: &str, warnings: &mut Warnings) -> Result<Scan, SceneError> {
    let mut scanner = Scanner {
        path,
        warnings,
        scan: Scan {
            text: String::with_capacity(text.len()),
            lines: Vec::new(),
            libraries: Vec::new(),
            materials: Vec::new(),
        },
        line: 0,
        counts: [0; 3],
        greatest: [(0, 0); 3],
        object: "unnamed".into(),
        layout: None,
        has_smoothing: false,
    };
    // All libraries stand for one, so that their order does not matter.
    scanner.emit("mtllib all");
    for (line, statement) in statements(text) {
        scanner.line = line;
        scanner.statement(&statement)?;
    }
    scanner.finish()
}

impl Scanner<'_> {
    fn statement(&mut self, statement: &str) -> Result<(), SceneError> {
        let (word, rest) = statement
            .split_once(char::is_whitespace)
            .unwrap_or((statement, ""));
        let rest = rest.trim();
        match word {
            "v" => self.vertex(rest),
            "vt" => self.texture_coordinate(rest),
            "vn" => self.data(2, statement),
            "f" | "fo" => self.face(statement)?,
            "o" | "g" => self.object(rest),
            "usemtl" => self.use_material(rest),
            "mtllib" => self.scan.libraries.push((self.line, rest.into())),
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

    /// A position; a fourth number is a weight for curves, six are a colour besides.
    fn vertex(&mut self, rest: &str) {
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words.len() > 4 {
            self.warnings.add("vertex colours", "left out");
        }
        let position = words.get(..3).unwrap_or(&words).join(" ");
        self.data(0, &format!("v {position}"));
    }

    /// Two numbers; one alone is legal and means v = 0.
    fn texture_coordinate(&mut self, rest: &str) {
        let zero = if rest.contains(char::is_whitespace) {
            ""
        } else {
            " 0"
        };
        self.data(1, &format!("vt {rest}{zero}"));
    }

    fn data(&mut self, kind: usize, statement: &str) {
        if let Some(count) = self.counts.get_mut(kind) {
            *count += 1;
        }
        self.emit(statement);
    }

    fn object(&mut self, name: &str) {
        self.object = if name.is_empty() { "unnamed" } else { name }.into();
        self.layout = None;
        self.emit(&format!("o {}", self.object));
    }

    fn use_material(&mut self, name: &str) {
        let is_known = self.scan.materials.iter().any(|(_, known)| known == name);
        if !is_known {
            self.scan.materials.push((self.line, name.into()));
        }
        // Without a name nothing is used: `tobj` asks for some name, and finds none.
        self.emit(&format!(
            "usemtl {}",
            if name.is_empty() { "?" } else { name }
        ));
    }

    fn face(&mut self, statement: &str) -> Result<(), SceneError> {
        let mut layout = None;
        let mut corners = 0;
        let mut face = String::from("f");
        for corner in statement.split_whitespace().skip(1) {
            let found = self.corner(statement, corner)?;
            if *layout.get_or_insert(found) != found {
                let message = "the corners of a face must have texture coordinates and normals \
                               alike";
                return Err(self.error(statement, corner, message));
            }
            face.push(' ');
            face.push_str(corner);
            corners += 1;
        }
        if corners < 3 {
            let message = format!("a face of {corners} corners, must have 3 or more");
            return Err(self.error(statement, statement, message));
        }
        if corners > 4 {
            let message = "split as fans: right for convex polygons only";
            self.warnings
                .add("polygons of five or more corners", message);
        }
        if self.layout.is_some() && self.layout != layout {
            let object = format!("o {}", self.object);
            self.emit(&object);
        }
        self.layout = layout;
        self.emit(&face);
        Ok(())
    }

    /// Checks `v`, `v/vt`, `v//vn` or `v/vt/vn`: indices from 1, or back from -1.
    fn corner(&mut self, statement: &str, corner: &str) -> Result<Layout, SceneError> {
        let mut has = [false; 3];
        for (kind, index) in corner.split('/').enumerate() {
            let (Some(has), Some(&count)) = (has.get_mut(kind), self.counts.get(kind)) else {
                return Err(self.error(statement, corner, "more than three indices in a corner"));
            };
            if index.is_empty() && kind > 0 {
                continue;
            }
            *has = true;
            let number: i64 = index
                .parse::<i32>()
                .map_err(|error| self.error(statement, corner, format!("index: {error}")))?
                .into();
            if number == 0 || number < -count {
                let message = format!("index {number}: there are {count} so far, from 1 or -1");
                return Err(self.error(statement, corner, message));
            }
            if let Some(greatest) = self.greatest.get_mut(kind)
                && number > greatest.0
            {
                *greatest = (number, self.line);
            }
        }
        let [_, texture, normal] = has;
        Ok([texture, normal])
    }

    fn finish(mut self) -> Result<Scan, SceneError> {
        let kinds = ["vertices", "texture coordinates", "normals"];
        for ((kind, count), (greatest, line)) in kinds.iter().zip(self.counts).zip(self.greatest) {
            if greatest > count {
                self.line = line;
                let message = format!("a face uses number {greatest}, there are {count} {kind}");
                return Err(self.error("", "", message));
            }
        }
        if self.has_smoothing && self.counts.get(2) == Some(&0) {
            let message = "left out: without vn the triangles' own normals are used";
            self.warnings.add("smoothing groups", message);
        }
        Ok(self.scan)
    }

    fn emit(&mut self, statement: &str) {
        self.scan.text.push_str(statement);
        self.scan.text.push('\n');
        self.scan.lines.push(self.line);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn scanned(text: &str) -> Result<Scan, String> {
        scan(Path::new("x.obj"), text, &mut Warnings::default()).map_err(|e| e.to_string())
    }

    fn refused(text: &str) -> String {
        match scanned(text) {
            Ok(scan) => panic!("accepted: {}", scan.text),
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
        let scan = scanned(&text).unwrap();
        let tail: Vec<_> = scan.text.lines().skip(4).collect();
        let want = [
            "vt 0 0",
            "o a",
            "f 1/1 2/1 3/1",
            "o a",
            "f 1 2 3",
            "f 3 2 1",
        ];
        assert_eq!(tail, want);
    }
}
