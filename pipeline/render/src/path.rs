//! A camera's path: one row a frame, as comma-separated values.
//!
//! The first line names the columns, in any order: `eye_x eye_y eye_z target_x target_y target_z
//! fov` have to be there; `up_x up_y up_z` may be (default 0,1,0); `light0_x light0_y light0_z`,
//! `light1_x` ... give point lights, with `light0_r light0_g light0_b` their intensity (default
//! 1 W/sr a channel). Numbers are plain decimals; metres, degrees, W/sr, world frame.

use crate::error::RenderError;
use crate::view::View;
use glam::Vec3;
use rrf_scene::PointLight;
use std::path::Path;

/// A frame of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The view.
    pub view: View,
    /// The row's own lights; none where the path has no light columns.
    pub lights: Vec<PointLight>,
}

const AXES: [&str; 3] = ["x", "y", "z"];
const CHANNELS: [&str; 3] = ["r", "g", "b"];

/// Where three columns of a vector are.
type Triple = [usize; 3];

/// Which columns mean what.
struct Header {
    eye: Triple,
    target: Triple,
    fov: usize,
    up: Option<Triple>,
    lights: Vec<(Triple, Option<Triple>)>,
    width: usize,
}

/// Reads a path of frames of `size` pixels.
///
/// # Errors
/// [`RenderError::PathFile`] with the row (from 1, the header not counted) and the column.
pub fn read(file: &Path, size: [u32; 2]) -> Result<Vec<Shot>, RenderError> {
    let refuse = |reason: String| RenderError::PathFile {
        path: file.to_path_buf(),
        reason,
    };
    let text = std::fs::read_to_string(file).map_err(|e| refuse(e.to_string()))?;
    parse(&text, size).map_err(refuse)
}

/// The frames of a path's text, or what is wrong with it.
pub fn parse(text: &str, size: [u32; 2]) -> Result<Vec<Shot>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().filter(|line| !line.trim().is_empty());
    let names: Vec<&str> = match lines.next() {
        Some(line) => line.split(',').map(str::trim).collect(),
        None => return Err("it is empty; its first line has to name the columns".into()),
    };
    let header = Header::new(&names)?;
    let rows = lines.zip(1..).map(|(line, row)| {
        let shot = header.shot(&names, line, size);
        shot.map_err(|reason| format!("row {row}: {reason}"))
    });
    let shots = rows.collect::<Result<Vec<Shot>, String>>()?;
    if shots.is_empty() {
        return Err("it has columns, but no row".into());
    }
    Ok(shots)
}

impl Header {
    fn new(names: &[&str]) -> Result<Header, String> {
        if let Some(name) = (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
            return Err(format!("column {} is there twice", names[name]));
        }
        let find = |name: &str| names.iter().position(|n| *n == name);
        let need = |name: &str| {
            find(name).ok_or_else(|| format!("no column {name}; it has {}", names.join(", ")))
        };
        let triple = |first: &str, parts: [&str; 3]| -> Result<Option<Triple>, String> {
            let columns = parts.map(|part| format!("{first}_{part}"));
            if columns.iter().all(|name| find(name).is_none()) {
                return Ok(None);
            }
            let [a, b, c] = &columns;
            Ok(Some([need(a)?, need(b)?, need(c)?]))
        };
        let vector = |first: &str| {
            let missing = || format!("no column {first}_x; it has {}", names.join(", "));
            triple(first, AXES)?.ok_or_else(missing)
        };
        let mut lights = Vec::new();
        while let Some(position) = triple(&format!("light{}", lights.len()), AXES)? {
            let intensity = triple(&format!("light{}", lights.len()), CHANNELS)?;
            lights.push((position, intensity));
        }
        let header = Header {
            eye: vector("eye")?,
            target: vector("target")?,
            fov: need("fov")?,
            up: triple("up", AXES)?,
            lights,
            width: names.len(),
        };
        match (0..names.len()).find(|&column| !header.reads(column)) {
            Some(column) => Err(format!("column {:?} means nothing here", names[column])),
            None => Ok(header),
        }
    }

    fn reads(&self, column: usize) -> bool {
        let lights = self.lights.iter();
        let triples = lights.flat_map(|(p, i)| [Some(*p), *i]).flatten();
        let mut triples = triples.chain([self.eye, self.target]).chain(self.up);
        column == self.fov || triples.any(|triple| triple.contains(&column))
    }

    /// One row's frame.
    fn shot(&self, names: &[&str], line: &str, size: [u32; 2]) -> Result<Shot, String> {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != self.width {
            let (has, needs) = (fields.len(), self.width);
            return Err(format!("{has} values for {needs} columns"));
        }
        let mut values = Vec::with_capacity(fields.len());
        for (name, field) in names.iter().zip(&fields) {
            match field.parse::<f32>() {
                Ok(value) if value.is_finite() => values.push(value),
                _ => return Err(format!("{name}: {field:?} is not a finite number")),
            }
        }
        let at = |[x, y, z]: Triple| Vec3::new(values[x], values[y], values[z]);
        let up = self.up.map_or(Vec3::Y, at);
        let view = View::look_at(at(self.eye), at(self.target), up, values[self.fov], size);
        view.check().map_err(|error| error.to_string())?;
        let light = |(position, intensity): &(Triple, Option<Triple>)| PointLight {
            position: at(*position),
            intensity: intensity.map_or(Vec3::ONE, at),
        };
        let lights: Vec<PointLight> = self.lights.iter().map(light).collect();
        match lights.iter().position(|l| l.intensity.min_element() < 0.0) {
            Some(k) => Err(format!("light{k}: an intensity cannot be negative")),
            None => Ok(Shot { view, lights }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "eye_x,eye_y,eye_z,target_x,target_y,target_z,fov";

    #[test]
    fn columns_in_any_order_with_lights() {
        let text = format!(
            "fov,light0_x,light0_y,light0_z,light1_x,light1_y,light1_z,light1_r,light1_g,light1_b,\
             {}\r\n40, 1,2,3, 4,5,6,7,8,9, 0,0,5,0,0,0\r\n\r\n",
            HEAD.trim_end_matches(",fov")
        );
        let shots = parse(&text, [8, 4]).unwrap();
        assert_eq!(shots.len(), 1);
        let view = View::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 40.0, [8, 4]);
        assert_eq!(shots[0].view, view);
        let [a, b] = shots[0].lights[..] else {
            panic!("{shots:?}")
        };
        assert_eq!(
            (a.position, a.intensity),
            (Vec3::new(1.0, 2.0, 3.0), Vec3::ONE)
        );
        assert_eq!(b.intensity, Vec3::new(7.0, 8.0, 9.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = "0,0,5,0,0,0,40";
        let cases = [
            (String::new(), "empty"),
            (format!("{HEAD}\n"), "no row"),
            (
                format!("{HEAD}\n{good}\n0,NaN,5,0,0,0,40"),
                "row 2: eye_y: \"NaN\"",
            ),
            (format!("{HEAD}\n0,0,5,0,0,inf,40"), "row 1: target_z"),
            (
                format!("{HEAD}\n{good}\n{good}\n0,0,5,0,0,5,40"),
                "row 3: the view",
            ),
            (format!("{HEAD}\n0,5,0,0,0,0,40"), "row 1: the view"),
            (format!("{HEAD}\n0,0,5,0,0,0,180"), "row 1: the view"),
            (format!("{HEAD}\n0,0,5,0,0,0"), "6 values for 7"),
            (format!("{HEAD},light0_x\n{good},1"), "no column light0_y"),
            (
                format!("{HEAD},light1_x\n{good},1"),
                "\"light1_x\" means nothing",
            ),
            (format!("{HEAD},fov\n{good},1"), "fov is there twice"),
            (HEAD.replace(",fov", ""), "no column fov"),
            (HEAD.replace("eye_y", "eyes"), "no column eye_y"),
        ];
        for (text, words) in cases {
            let error = parse(&text, [8, 8]).unwrap_err();
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
