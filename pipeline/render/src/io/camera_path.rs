//! A camera's path: one row a frame, as comma-separated values.
//!
//! The first line names the columns, in any order: `eye_x eye_y eye_z target_x target_y target_z
//! fov` have to be there; `up_x up_y up_z` may be (default 0,1,0); `light0_x light0_y light0_z`,
//! `light1_x` ... give point lights, with `light0_r light0_g light0_b` their intensity (default
//! 1 W/sr a channel). Numbers are plain decimals; metres, degrees, W/sr, world frame.

use crate::error::RenderError;
use crate::view::{Lights, View};
use glam::Vec3;
use rrf_scene::PointLight;
use std::collections::BTreeMap;
use std::path::Path;

/// Most bytes of a path: a million frames.
const MAX_BYTES: u64 = 256 << 20;

const XYZ: [&str; 3] = ["x", "y", "z"];
const RGB: [&str; 3] = ["r", "g", "b"];

/// A frame of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The view.
    pub view: View,
    /// The row's own lights; none where the path has no light columns.
    pub lights: Lights,
}

/// Reads a path of frames of `size` pixels.
///
/// # Errors
/// [`RenderError::PathFile`] with the row (from 1, the header not counted) and the column.
pub fn read_camera_path(file: &Path, size: [u32; 2]) -> Result<Vec<Shot>, RenderError> {
    let refuse = |reason: String| RenderError::PathFile {
        path: file.to_path_buf(),
        reason,
    };
    let bytes = rrf_files::read_regular(file, MAX_BYTES).map_err(|e| refuse(e.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|e| refuse(e.to_string()))?;
    parse_camera_path(&text, size).map_err(refuse)
}

/// The frames of a path's text, or what is wrong with it.
fn parse_camera_path(text: &str, size: [u32; 2]) -> Result<Vec<Shot>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    let mut lines = lines.map(|line| line.split(',').map(str::trim).collect::<Vec<&str>>());
    let names = (lines.next()).ok_or("it is empty; its first line has to name the columns")?;
    if let Some(i) = (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        return Err(format!("column {} is there twice", names[i]));
    }
    let shots = lines.zip(1..).map(|(fields, row)| {
        let shot = shot(&names, &fields, size);
        shot.map_err(|reason| format!("row {row}: {reason}"))
    });
    let shots = shots.collect::<Result<Vec<Shot>, String>>()?;
    match shots.is_empty() {
        true => Err("it has columns, but no row".into()),
        false => Ok(shots),
    }
}

/// One row's frame: columns are taken out as they are understood.
fn shot(names: &[&str], fields: &[&str], size: [u32; 2]) -> Result<Shot, String> {
    if fields.len() != names.len() {
        let (has, needs) = (fields.len(), names.len());
        return Err(format!("{has} values for {needs} columns"));
    }
    let mut values: BTreeMap<String, f32> = BTreeMap::new();
    for (name, field) in names.iter().zip(fields) {
        let value = field.parse().ok().filter(|value: &f32| value.is_finite());
        let value = value.ok_or(format!("{name}: \"{field}\" is not a finite number"))?;
        values.insert(name.to_string(), value);
    }
    let missing = |name: &str| format!("no column {name}; it has {}", names.join(", "));
    let fov = values.remove("fov").ok_or_else(|| missing("fov"))?;
    let mut vector = |name: &str, axes: [&str; 3]| {
        let columns = axes.map(|axis| format!("{name}_{axis}"));
        let found = columns.each_ref().map(|column| values.remove(column));
        match (found, found.iter().position(Option::is_none)) {
            ([Some(x), Some(y), Some(z)], _) => Ok(Some(Vec3::new(x, y, z))),
            ([None, None, None], _) => Ok(None),
            (_, absent) => Err(missing(&columns[absent.unwrap_or(0)])),
        }
    };
    let eye = vector("eye", XYZ)?.ok_or_else(|| missing("eye_x"))?;
    let target = vector("target", XYZ)?.ok_or_else(|| missing("target_x"))?;
    let up = vector("up", XYZ)?.unwrap_or(Vec3::Y);
    let mut points = Vec::new();
    while let Some(position) = vector(&format!("light{}", points.len()), XYZ)? {
        let name = format!("light{}", points.len());
        let intensity = vector(&name, RGB)?.unwrap_or(Vec3::ONE);
        if intensity.min_element() < 0.0 {
            return Err(format!("{name}: an intensity cannot be negative"));
        }
        points.push(PointLight {
            position,
            intensity,
        });
    }
    if let Some(name) = values.keys().next() {
        return Err(format!("column {name} is not one of a camera path"));
    }
    let view = View::look_at(eye, target, up, fov, size);
    view.check().map_err(|error| error.to_string())?;
    let lights = Lights {
        points,
        ..Lights::default()
    };
    Ok(Shot { view, lights })
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
        let shots = parse_camera_path(&text, [8, 4]).unwrap();
        assert_eq!(shots.len(), 1);
        let view = View::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 40.0, [8, 4]);
        assert_eq!(shots[0].view, view);
        let [a, b] = shots[0].lights.points[..] else {
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
            (format!("{HEAD},light1_x\n{good},1"), "light1_x is not one"),
            (format!("{HEAD},fov\n{good},1"), "fov is there twice"),
            (
                format!("{}\n1,1,1,1,1,1", HEAD.replace(",fov", "")),
                "no column fov",
            ),
            (
                format!("{}\n{good}", HEAD.replace("eye_y", "eyes")),
                "no column eye_y",
            ),
        ];
        for (text, words) in cases {
            let error = parse_camera_path(&text, [8, 8]).unwrap_err();
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
