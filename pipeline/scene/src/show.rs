//! A scene's summary as text.

use crate::summary::{
    AreaLightSummary, CameraSummary, LightSummary, MaterialSummary, Summary, TextureSummary,
};
use std::fmt;

/// Three numbers with spaces.
struct Triple<'a, T>(&'a [T; 3]);

impl<T: fmt::Display> fmt::Display for Triple<'_, T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c] = self.0;
        match out.precision() {
            Some(digits) => write!(out, "{a:.digits$} {b:.digits$} {c:.digits$}"),
            None => write!(out, "{a} {b} {c}"),
        }
    }
}

/// At most so many entries of a list are printed.
const LONGEST_LIST: usize = 40;

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}", self.file)?;
        writeln!(out, "  hash         {}", self.hash)?;
        writeln!(
            out,
            "  triangles    {} ({} vertices), area {:.6}",
            self.triangles, self.vertices, self.area
        )?;
        if let Some(bounds) = &self.bounds {
            writeln!(
                out,
                "  bounds       {} to {}",
                Triple(&bounds.min),
                Triple(&bounds.max)
            )?;
        }
        writeln!(out, "  objects      {}", self.objects.len())?;
        self.list(out, "materials", &self.materials)?;
        self.list(out, "textures", &self.textures)?;
        self.list(out, "lights", &self.lights)?;
        self.list(out, "area lights", &self.area_lights)?;
        self.list(out, "cameras", &self.cameras)?;
        writeln!(out, "  warnings     {}", self.warnings.len())?;
        for warning in &self.warnings {
            writeln!(out, "    {}: {}", warning.place, warning.message)?;
        }
        Ok(())
    }
}

impl Summary {
    fn list<T: fmt::Display>(
        &self,
        out: &mut fmt::Formatter<'_>,
        title: &str,
        entries: &[T],
    ) -> fmt::Result {
        writeln!(out, "  {title:<12} {}", entries.len())?;
        for (id, entry) in entries.iter().take(LONGEST_LIST).enumerate() {
            writeln!(out, "    {id:>3}  {entry}")?;
        }
        match entries.len().checked_sub(LONGEST_LIST) {
            None | Some(0) => Ok(()),
            Some(more) => writeln!(out, "    and {more} more (--json lists all)"),
        }
    }
}

impl fmt::Display for MaterialSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{:<24} {:<10} {:.3}",
            self.name,
            self.kind,
            Triple(&self.base_color)
        )?;
        let mut gap = "  ";
        let common = [
            ("roughness", self.roughness),
            ("metallic", self.metallic),
            ("specular", self.specular),
        ];
        for (name, value) in common {
            if let Some(value) = value {
                write!(out, "{gap}{name} {value:.3}")?;
                gap = " ";
            }
        }
        for (name, value) in &self.own {
            write!(out, "{gap}{name} {value:.3?}")?;
            gap = " ";
        }
        for (name, texture) in ["colour", "roughness", "normal"].iter().zip(self.textures) {
            if let Some(id) = texture {
                write!(out, "  {name} texture {id}")?;
            }
        }
        write!(
            out,
            "  ({} triangles, area {:.4})",
            self.triangles, self.area
        )
    }
}

impl fmt::Display for TextureSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} x {}", self.width, self.height)
    }
}

impl fmt::Display for LightSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{:<16} {:<12} {}, power {:.3} W",
            self.name,
            self.kind,
            self.summary,
            Triple(&self.power)
        )
    }
}

impl fmt::Display for AreaLightSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sides = if self.two_sided {
            "two sides"
        } else {
            "one side"
        };
        write!(
            out,
            "{:<16} {} W/(sr m^2), {sides}, {} triangles, area {:.4}, power {:.3} W",
            self.name,
            Triple(&self.radiance),
            self.triangles,
            self.area,
            Triple(&self.power)
        )?;
        match self.texture {
            Some(id) => write!(out, ", texture {id}"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for CameraSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{}: at {} looking along {:.4}, up {:.4}, fov {}, {} x {}{}",
            self.name,
            Triple(&self.eye),
            Triple(&self.forward),
            Triple(&self.up),
            self.fov,
            self.width,
            self.height,
            if self.mirrored { ", mirrored" } else { "" }
        )
    }
}
