//! `grid.toml`: which settings a sweep bakes, and what it measures them against.
//!
//! ```toml
//! seeds = [1, 2, 3]
//! light_box = [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6]
//! points = "../tests/data/oracle/cornell_overhead.parquet"  # optional, relative to this file
//!
//! [frame]
//! light = "0.1,1.6,0.2,4,4,4"
//! size = "256x256"
//! reference_spp = 2048
//!
//! [[bake]]            # every combination; each name is an option of `rrf bake`
//! preset = ["preview"]
//! rows = [10000, 20000, 40000]
//! cells = [4, 16]
//!
//! [trace]             # path tracing of the same frame
//! spp = [2, 8, 32]
//! ```

use crate::ReportError;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A sweep as it was asked for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Every setting is baked with each of these.
    pub seeds: Vec<u64>,
    /// Box that lights may stand in, as in `rrf bake`.
    pub light_box: Option<[f32; 6]>,
    /// Points table with reference radiance (`r g b r_se g_se b_se`).
    pub points: Option<PathBuf>,
    /// The frame that is compared.
    pub frame: GridFrame,
    /// Blocks of options of `rrf bake`, without the dashes.
    #[serde(default)]
    pub bake: Vec<BTreeMap<String, Vec<toml::Value>>>,
    /// Path tracing at some numbers of paths a pixel.
    pub trace: Option<GridTrace>,
}

/// The frame that every run renders.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridFrame {
    /// `x,y,z[,r,g,b]`.
    pub light: String,
    /// `WxH`.
    pub size: String,
    /// `x,y,z`; the scene's camera where absent.
    pub eye: Option<String>,
    /// `x,y,z`.
    pub look_at: Option<String>,
    /// Degrees.
    pub fov: Option<f32>,
    /// Paths a pixel of the reference, in two independent halves.
    pub reference_spp: u32,
}

/// `[trace]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridTrace {
    /// Paths a pixel, even numbers.
    pub spp: Vec<u32>,
}

/// One setting: options of `rrf bake` and their values, by name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Setting(pub BTreeMap<String, String>);

impl Setting {
    /// `cells=16,preset=preview,rows=20000`.
    pub fn name(&self) -> String {
        let parts = self.0.iter().map(|(name, value)| format!("{name}={value}"));
        parts.collect::<Vec<_>>().join(",")
    }
}

impl Grid {
    /// Reads and checks a grid.
    ///
    /// # Errors
    /// [`ReportError::File`], [`ReportError::Input`].
    pub fn read(path: &Path) -> Result<Grid, ReportError> {
        let text =
            std::fs::read_to_string(path).map_err(|e| ReportError::file(path, "be read", e))?;
        let refused = |reason: String| ReportError::input(path, reason);
        let mut grid: Grid = toml::from_str(&text).map_err(|e| refused(e.to_string()))?;
        if let Some(points) = &grid.points {
            grid.points = Some(path.parent().unwrap_or(Path::new(".")).join(points));
        }
        grid.check().map_err(refused)?;
        Ok(grid)
    }

    fn check(&self) -> Result<(), String> {
        if self.seeds.is_empty() || self.settings().is_empty() && self.trace.is_none() {
            return Err("no seed, or neither [[bake]] nor [trace]: nothing to run".into());
        }
        let odd = |spp: &u32| *spp == 0 || spp % 2 == 1;
        let spp = self.trace.iter().flat_map(|t| &t.spp);
        if let Some(spp) = spp
            .chain([&(self.frame.reference_spp / 2)])
            .find(|s| odd(s))
        {
            return Err(format!(
                "{spp} paths a pixel (of a reference, of each half): an even number above 0 is needed"
            ));
        }
        let unfit = |setting: &Setting| setting.name().contains(['/', '\\']);
        if let Some(setting) = self.settings().iter().find(|s| unfit(s)) {
            return Err(format!(
                "{}: settings are names of folders and can have no slash",
                setting.name()
            ));
        }
        for name in ["output", "seed", "light-box", "resume", "quiet", "threads"] {
            if self.bake.iter().any(|block| block.contains_key(name)) {
                return Err(format!("[[bake]] {name}: the sweep itself chooses it"));
            }
        }
        Ok(())
    }

    /// Every combination of every block, without repetitions, in the grid's order.
    pub fn settings(&self) -> Vec<Setting> {
        let mut all = Vec::new();
        for block in &self.bake {
            let mut partial = vec![BTreeMap::new()];
            for (name, values) in block {
                let extended = partial.iter().flat_map(|setting| {
                    values.iter().map(move |value| {
                        let mut setting: BTreeMap<String, String> = setting.clone();
                        setting.insert(name.clone(), word(value));
                        setting
                    })
                });
                partial = extended.collect();
            }
            for setting in partial.into_iter().map(Setting) {
                if !all.contains(&setting) {
                    all.push(setting);
                }
            }
        }
        all
    }
}

/// A value as it would be typed.
fn word(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: &str = "seeds = [1, 2]\n[frame]\nlight = \"0,1,0\"\nsize = \"8x8\"\n\
        reference_spp = 8\n[[bake]]\npreset = [\"preview\"]\nrows = [1, 2]\ncells = [3, 4]\n\
        [[bake]]\nrows = [2]\ncells = [4]\npreset = [\"preview\"]\n";

    fn read(text: &str) -> Result<Grid, ReportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grid.toml");
        std::fs::write(&path, text).unwrap();
        Grid::read(&path)
    }

    #[test]
    fn every_combination_once() {
        let names: Vec<String> = (read(GRID).unwrap().settings().iter())
            .map(Setting::name)
            .collect();
        let wanted = [(3, 1), (3, 2), (4, 1), (4, 2)]
            .map(|(cells, rows)| format!("cells={cells},preset=preview,rows={rows}"));
        assert_eq!(names, wanted);
    }

    #[test]
    fn what_cannot_be_run_is_refused() {
        for (from, to) in [
            ("seeds = [1, 2]", "seeds = []"),
            ("reference_spp = 8", "reference_spp = 6"),
            ("rows = [1, 2]", "seed = [1]"),
            ("rows = [1, 2]", "rows = 1"),
            ("size", "sizes"),
        ] {
            let error = read(&GRID.replacen(from, to, 1)).unwrap_err();
            assert!(error.is_bad_input(), "{to}: {error}");
        }
        assert!(!read(GRID).unwrap().settings().is_empty());
    }
}
